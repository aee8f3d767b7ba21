//! Analyses of several measurements of one oscillator.

use super::analyse::refer;
use super::choices::{Constants, LevelsChoices, ResonanceChoices, RingdownChoices};
use super::{Analysed, Answer};
use crate::failure::{core_error, option_error, spell};
use crate::interrupt::interruptible;
use crate::reading::{Curve, Levels, Record};
use pyo3::prelude::*;
use slipfit::answer::hint::Analysis;
use slipfit::model::displacement::DisplacementUnit;
use slipfit::series;
use slipfit::series::{Condition, Data, Measurement};
use slipfit_io::ReadReport;
use slipfit_report::{SeriesHeading, SeriesInput};

/// One measurement of a series: data with the choices for its analysis.
#[derive(FromPyObject)]
pub(crate) enum Measured<'py> {
    #[pyo3(transparent)]
    Ringdown((PyRef<'py, Record>, RingdownChoices)),
    #[pyo3(transparent)]
    Sweep((PyRef<'py, Curve>, Option<PyRef<'py, Curve>>, ResonanceChoices)),
    #[pyo3(transparent)]
    Levels((PyRef<'py, Levels>, LevelsChoices)),
    /// The data and options of an answer.
    #[pyo3(transparent)]
    Answered((PyRef<'py, Answer>,)),
}

/// Description of one file in the report of the series.
fn input(report: &ReadReport, kind: &'static str, unit: &str) -> SeriesInput {
    SeriesInput {
        path: report.path.clone(),
        sha256: report.sha256.clone(),
        kind,
        unit: unit.to_owned(),
        notes: report.notes.iter().map(|note| note.spelled(&spell)).collect(),
    }
}

impl Measured<'_> {
    fn data(self, py: Python<'_>) -> PyResult<(Data, SeriesInput)> {
        Ok(match self {
            Self::Ringdown((record, choices)) => {
                let reading = &record.reading;
                let mut options = choices.options(py)?;
                options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
                let input = input(&reading.report, "ringdown", &reading.record.displacement_unit());
                let record = Box::new(reading.record.clone());
                (Data::RingDown { record, options: Box::new(options) }, input)
            }
            Self::Sweep((curve, reference, choices)) => {
                let reading = &curve.reading;
                let mut options = choices.options(py)?;
                refer(py, &mut options, reading, reference.as_ref().map(|r| &*r.reading))?;
                let input = input(&reading.report, "sweep", reading.curve.unit());
                (Data::Sweep { curve: Box::new(reading.curve.clone()), options: Box::new(options) }, input)
            }
            Self::Levels((levels, choices)) => {
                let reading = &levels.reading;
                let input = input(&reading.report, "levels", reading.levels.unit());
                let options = Box::new(choices.options(reading));
                (Data::Levels { levels: Box::new(reading.levels.clone()), options }, input)
            }
            Self::Answered((answer,)) => return answered(py, &answer.0),
        })
    }
}

/// The data and options of an answer; forces are those of the series.
fn answered(py: Python<'_>, answer: &Analysed) -> PyResult<(Data, SeriesInput)> {
    Ok(match answer {
        Analysed::Ringdown { reading, options, .. } => {
            let input = input(&reading.report, "ringdown", &reading.record.displacement_unit());
            let mut options = Box::new(options.clone());
            options.calibration = None;
            (Data::RingDown { record: Box::new(reading.record.clone()), options }, input)
        }
        Analysed::Curve { reading, options, .. } => {
            let input = input(&reading.report, "sweep", reading.curve.unit());
            let mut options = options.clone();
            options.calibration = None;
            (Data::Sweep { curve: Box::new(reading.curve.clone()), options }, input)
        }
        Analysed::Levels { reading, options, .. } => {
            let input = input(&reading.report, "levels", reading.levels.unit());
            let mut options = Box::new(options.clone());
            options.calibration = None;
            (Data::Levels { levels: Box::new(reading.levels.clone()), options }, input)
        }
        Analysed::Series { .. } => {
            let message = "an answer to a series has several measurements; each is needed by itself";
            return Err(option_error(py, "data", message));
        }
    })
}

/// The error of one measurement, with its name added.
fn of_measurement(py: Python<'_>, error: PyErr, name: &str) -> PyErr {
    let value = error.value(py);
    let told = value.getattr("message").and_then(|message| message.extract::<String>());
    let Ok(message) = told else { return error };
    match value.setattr("message", format!("{name}: {message}")) {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// A measurement with its name, the label and value of its condition, and its scale.
type Entry<'py> = (Measured<'py>, String, String, Option<(f64, f64)>, Option<f64>);

/// Description given above the measurements of a series.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SeriesChoices {
    title: String,
    condition: String,
    condition_unit: String,
    unit: Option<String>,
    shared: Vec<String>,
}

/// Analyses several measurements of one oscillator.
#[pyfunction]
pub(crate) fn series_answer(
    py: Python<'_>,
    entries: Vec<Entry<'_>>,
    choices: SeriesChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let (mut measurements, mut inputs) = (Vec::new(), Vec::new());
    let mut scales = Vec::new();
    for (measured, name, label, value, scale) in entries {
        let (data, input) = measured.data(py).map_err(|error| of_measurement(py, error, &name))?;
        let condition = Condition { label, value: value.map(<[f64; 2]>::from) };
        measurements.push(Measurement { name, condition, data, scale: 1.0 });
        inputs.push(input);
        scales.push(scale);
    }
    let calibration = constants.given(py)?;
    let first = inputs.first().map_or("", |input| input.unit.as_str());
    let coordinate = calibration.map(|(_, _, coordinate)| coordinate);
    let unit = series::common_unit(coordinate, choices.unit.as_deref(), first);
    for ((measurement, input), scale) in measurements.iter_mut().zip(&mut inputs).zip(scales) {
        measurement.scale = match scale {
            Some(scale) => scale,
            None if input.unit.is_empty() && !unit.is_empty() => {
                input.notes.push(format!(
                    "no unit is named: its numbers were taken as {unit}; unit or scale gives another"
                ));
                1.0
            }
            None => DisplacementUnit::factor(&input.unit, &unit).map_err(|_| {
                let message = format!(
                    "{}: its unit is `{}`, that of the series `{unit}`; scale gives the factor",
                    measurement.name, input.unit
                );
                option_error(py, "scale", message)
            })?,
        };
    }
    let mut options = series::Options::default();
    for name in &choices.shared {
        match name.as_str() {
            "natural_frequency" | "natural_frequency_hz" => options.shared.natural_frequency = true,
            "drive_amplitude" => options.shared.drive_amplitude = true,
            "decay_rate" | "decay_rate_per_s" => options.shared.decay_rate = true,
            other => {
                let message = format!(
                    "shared: {other:?} cannot be shared; natural_frequency, drive_amplitude and decay_rate can"
                );
                return Err(option_error(py, "shared", message));
            }
        }
    }
    options.calibration = calibration.map(|(_, constant, _)| constant);
    options.unit = unit;
    options.condition_unit = choices.condition_unit.clone();
    let heading = SeriesHeading {
        title: choices.title,
        condition: choices.condition,
        condition_unit: choices.condition_unit,
        shared: options.shared,
        ..SeriesHeading::default()
    };
    let (held, asked) = (measurements.clone(), options.clone());
    let answer = interruptible(py, move || series::analyse(&held, &asked))?
        .map_err(|error| core_error(py, Analysis::Resonance, &error))?;
    Ok(Answer(Analysed::Series { heading, inputs, measurements, options, answer: Box::new(answer) }))
}

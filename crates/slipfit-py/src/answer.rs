//! Analyses and their answers.

use crate::failure::{HintParts, core_error, hint_parts, option_error, spell};
use crate::interrupt::interruptible;
use crate::reading::{Curve, Levels, Record};
use anstyle::Style;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipfit::answer::hint::Analysis;
use slipfit::answer::{Parameters, Warning};
use slipfit::model::displacement::{Coordinate, DisplacementUnit};
use slipfit::resonance::{DriveAmplitude, Method, Terms};
use slipfit::ringdown::{LawOption, LowPass};
use slipfit::series::{Condition, Data, Measurement};
use slipfit::{Calibration, LossModel, Parameter, levels, resonance, ringdown, series};
use slipfit_io::{LevelReading, Note, Reading, SweepReading};
use slipfit_report::{
    AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, DocumentWarning, Report, SeriesHeading,
    SeriesInput, page, plot::Format, terminal, warning_text,
};
use std::path::Path;
use std::sync::Arc;

/// An answer with everything its reports need.
#[pyclass(frozen, module = "slipfit._core")]
pub(crate) struct Answer(Analysed);

enum Analysed {
    Ringdown {
        reading: Arc<Reading>,
        options: ringdown::Options,
        answer: Box<ringdown::Answer>,
    },
    Curve {
        reading: Arc<SweepReading>,
        reference: Option<Arc<SweepReading>>,
        options: Box<resonance::Options>,
        answer: Box<resonance::Answer>,
    },
    Levels {
        reading: Arc<LevelReading>,
        options: levels::Options,
        answer: Box<levels::Answer>,
    },
    Series {
        heading: SeriesHeading,
        inputs: Vec<SeriesInput>,
        measurements: Vec<Measurement>,
        options: series::Options,
        answer: Box<series::Answer>,
    },
}

impl Analysed {
    /// What `look` sees in the report.
    fn report<T>(&self, look: impl FnOnce(&dyn Report) -> T) -> T {
        match self {
            Self::Ringdown { reading, options, answer } => {
                let file = Path::new(&reading.report.path);
                look(&AnalysedRingdown { file, reading, options, answer })
            }
            Self::Curve { reading, reference, options, answer } => {
                let reference = reference.as_deref();
                look(&AnalysedCurve { reading, reference, options, answer })
            }
            Self::Levels { reading, options, answer } => look(&AnalysedLevels { reading, options, answer }),
            Self::Series { heading, inputs, measurements, options, answer } => {
                look(&AnalysedSeries { heading, inputs, measurements, options, answer })
            }
        }
    }

    fn warnings(&self) -> &[Warning] {
        match self {
            Self::Ringdown { answer, .. } => &answer.warnings,
            Self::Curve { answer, .. } => &answer.warnings,
            Self::Levels { answer, .. } => &answer.warnings,
            Self::Series { answer, .. } => &answer.warnings,
        }
    }

    fn parameters(&self) -> Option<&Parameters> {
        match self {
            Self::Ringdown { answer, .. } => Some(&answer.parameters),
            Self::Curve { answer, .. } => Some(&answer.parameters),
            Self::Levels { answer, .. } => Some(&answer.parameters),
            Self::Series { .. } => None,
        }
    }
}

/// Name, value, standard error, interval, value with the limit lifted, unit.
type QuantityParts = (&'static str, f64, f64, (f64, f64), f64, String);
/// Code, message, hints, all of it in words.
type WarningParts = (&'static str, String, Vec<HintParts>, String);

#[pymethods]
impl Answer {
    /// The whole answer as JSON: docs/json.md.
    fn json(&self) -> PyResult<String> {
        let mut text = Vec::new();
        self.0.report(|report| report.write_json(&mut text))?;
        Ok(String::from_utf8(text)?)
    }

    /// The numbers behind the figure as CSV.
    fn csv(&self) -> PyResult<String> {
        let mut text = Vec::new();
        self.0.report(|report| report.write_csv(&mut text))?;
        Ok(String::from_utf8(text)?)
    }

    /// The report as on a screen, without colours.
    fn screen(&self) -> String {
        let text = self.0.report(|report| {
            let document = report.document(&spell);
            let warning = |w: &DocumentWarning| terminal::hanging("warning:", Style::new(), &w.text);
            let warnings: String = document.warnings().iter().map(warning).collect();
            terminal::screen(&document, &[]) + &warnings
        });
        anstream::adapter::strip_str(&text).to_string()
    }

    /// The answer, its parameters and tables as one element of HTML.
    fn html(&self) -> String {
        self.0.report(|report| page::fragment(&report.document(&spell)))
    }

    /// The figure as SVG.
    fn svg(&self) -> PyResult<String> {
        let picture = self.0.report(|report| report.figure().render(Format::Svg));
        Ok(String::from_utf8(picture.unwrap_or_default())?)
    }

    fn quantities(&self) -> Vec<QuantityParts> {
        let list = self.0.parameters().into_iter().flat_map(Parameters::iter);
        list.map(|(p, q)| {
            let [low, high] = q.interval_95;
            (p.name(), q.value, q.std_error, (low, high), q.unbounded_value, q.unit.clone())
        })
        .collect()
    }

    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<WarningParts>> {
        let parts = |w: &Warning| {
            let hints = w.hints().iter().map(|h| hint_parts(py, h)).collect::<PyResult<_>>()?;
            Ok((w.code(), w.to_string(), hints, warning_text(w, &spell)))
        };
        self.0.warnings().iter().map(parts).collect()
    }

    /// The measured data and the fitted model beside them, as named arrays.
    fn fit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        let add = |name: &str, values: Vec<f64>| columns.set_item(name, values.into_pyarray(py));
        match &self.0 {
            Analysed::Ringdown { reading, answer, .. } => {
                let record = &reading.record;
                let [start, end] = answer.fit.range_s();
                let times = record.times_s(0..record.len());
                let within = |t: f64| (start..=end).contains(&t);
                let of = |f: &dyn Fn(f64) -> f64| {
                    times.iter().map(|&t| if within(t) { f(t) } else { f64::NAN }).collect::<Vec<_>>()
                };
                let (amplitude, fitted) =
                    (of(&|t| answer.fit.amplitude_at(t)), of(&|t| answer.fit.signal_at(t)));
                add("time_s", times)?;
                add("signal", record.signal().to_vec())?;
                add("fitted", fitted)?;
                add("amplitude", amplitude)?;
            }
            Analysed::Curve { answer, .. } => {
                let hz: Vec<f64> = answer.points.iter().map(|p| p.frequency_hz).collect();
                let ends = [
                    hz.iter().copied().fold(f64::INFINITY, f64::min),
                    hz.iter().copied().fold(0.0, f64::max),
                ];
                let dense = even(ends);
                add("amplitude", dense.iter().map(|f| answer.fit.response(*f).norm()).collect())?;
                add("phase_rad", dense.iter().map(|f| answer.fit.response(*f).arg()).collect())?;
                add("friction_free", dense.iter().map(|f| answer.fit.friction_free(*f).norm()).collect())?;
                add("frequency_hz", dense)?;
            }
            Analysed::Levels { answer, .. } => {
                let most = answer.points.iter().map(|p| p.drive).fold(0.0, f64::max);
                let dense = even([0.0, most]);
                add("amplitude", dense.iter().map(|d| answer.fit.amplitude(*d)).collect())?;
                add("friction_free", dense.iter().map(|d| answer.fit.friction_free(*d)).collect())?;
                add("drive", dense)?;
            }
            Analysed::Series { .. } => {}
        }
        Ok(columns)
    }

    /// Name of the analysis.
    #[getter]
    fn analysis(&self) -> &'static str {
        match &self.0 {
            Analysed::Ringdown { .. } => "ringdown",
            Analysed::Curve { .. } => "resonance",
            Analysed::Levels { .. } => "levels",
            Analysed::Series { .. } => "series",
        }
    }
}

/// Points of a curve that is drawn.
const DENSE: u32 = 801;

fn even([from, to]: [f64; 2]) -> Vec<f64> {
    (0..DENSE).map(|i| from + (to - from) * f64::from(i) / f64::from(DENSE - 1)).collect()
}

/// A value with its standard error; a bare number is exact.
#[derive(FromPyObject, Clone, Copy)]
pub(crate) enum Uncertain {
    #[pyo3(transparent)]
    Exact(f64),
    #[pyo3(transparent)]
    Pair((f64, f64)),
}

impl Uncertain {
    fn parts(self) -> [f64; 2] {
        match self {
            Self::Exact(value) => [value, 0.0],
            Self::Pair((value, std_error)) => [value, std_error],
        }
    }
}

/// At most one mechanical constant.
#[derive(FromPyObject, Clone, Copy)]
#[pyo3(from_item_all)]
pub(crate) struct Constants {
    stiffness: Option<Uncertain>,
    mass: Option<Uncertain>,
    torsion_stiffness: Option<Uncertain>,
    inertia: Option<Uncertain>,
}

impl Constants {
    fn given(self, py: Python<'_>) -> PyResult<Option<(&'static str, Calibration, Coordinate)>> {
        let stiffness = |[value, std_error]: [f64; 2]| Calibration::Stiffness { value, std_error };
        let mass = |[value, std_error]: [f64; 2]| Calibration::Mass { value, std_error };
        let given: Vec<_> = [
            ("stiffness", self.stiffness.map(|u| stiffness(u.parts())), Coordinate::Length),
            ("mass", self.mass.map(|u| mass(u.parts())), Coordinate::Length),
            ("torsion_stiffness", self.torsion_stiffness.map(|u| stiffness(u.parts())), Coordinate::Angle),
            ("inertia", self.inertia.map(|u| mass(u.parts())), Coordinate::Angle),
        ]
        .into_iter()
        .filter_map(|(name, constant, coordinate)| Some((name, constant?, coordinate)))
        .collect();
        match given[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [(a, ..), (b, ..), ..] => Err(option_error(
                py,
                b,
                format!("{a} and {b} are both given: one of them calibrates the forces"),
            )),
        }
    }

    /// The constant, which must fit a signal in `unit`.
    fn calibration(self, py: Python<'_>, unit: &str) -> PyResult<Option<Calibration>> {
        let Some((name, constant, coordinate)) = self.given(py)? else { return Ok(None) };
        coordinate.check_unit(unit).map_err(|_| {
            let other = match coordinate {
                Coordinate::Length => "torsion_stiffness or inertia calibrates an angle",
                Coordinate::Angle => "stiffness or mass calibrates a displacement",
            };
            let words = coordinate.words();
            option_error(py, name, format!("{name} is for {words}; the signal is in {unit}; {other}"))
        })?;
        Ok(Some(constant))
    }
}

fn loss_model(py: Python<'_>, word: Option<String>) -> PyResult<Option<LossModel>> {
    word.map(|word| {
        word.parse::<LossModel>().map_err(|e| option_error(py, "model", format!("model={word:?}: {e}")))
    })
    .transpose()
}

fn law(py: Python<'_>, word: &str) -> PyResult<LawOption> {
    word.parse().map_err(|e| option_error(py, "law", format!("law={word:?}: {e}")))
}

/// What is fixed before a ring-down is analysed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RingdownChoices {
    start_s: Option<f64>,
    end_s: Option<f64>,
    min_amplitude: Option<f64>,
    band_hz: Option<(f64, f64)>,
    model: Option<String>,
    law: Option<String>,
    lockin_time_constant_s: Option<f64>,
    lockin_order: Option<u32>,
    frequency_hz: Option<f64>,
}

impl RingdownChoices {
    pub(crate) fn options(self, py: Python<'_>) -> PyResult<ringdown::Options> {
        let mut options = ringdown::Options::default();
        options.start_s = self.start_s;
        options.end_s = self.end_s;
        options.min_amplitude = self.min_amplitude;
        options.band_hz = self.band_hz.map(<[f64; 2]>::from);
        options.model = loss_model(py, self.model)?;
        options.law = self.law.map(|word| law(py, &word)).transpose()?;
        options.lockin = match (self.lockin_time_constant_s, self.lockin_order) {
            (Some(time_constant_s), Some(order)) => Some(LowPass { time_constant_s, order }),
            (None, None) => None,
            _ => {
                let message = "lockin_time_constant_s and lockin_order describe one filter: give both";
                return Err(option_error(py, "lockin_order", message));
            }
        };
        options.frequency_hz = self.frequency_hz;
        Ok(options)
    }
}

/// Analyses a free decay.
#[pyfunction]
pub(crate) fn ringdown_answer(
    py: Python<'_>,
    record: &Record,
    choices: RingdownChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let mut options = choices.options(py)?;
    let reading = Arc::clone(&record.reading);
    options.calibration = constants.calibration(py, reading.record.unit())?;
    if let Some(f) = options.frequency_hz.filter(|_| reading.record.kind().oscillates()) {
        let message = format!(
            "frequency_hz={f}: only for a record of amplitudes; this one oscillates and has its own frequency; \
             band_hz says where to look for it"
        );
        return Err(option_error(py, "frequency_hz", message));
    }
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || {
        let answer = ringdown::analyse(&held.record, &asked)?;
        asked.check_reached(&answer)?;
        Ok(answer)
    })?
    .map_err(|error| core_error(py, Analysis::Ringdown, &error))?;
    Ok(Answer(Analysed::Ringdown { reading, options, answer: Box::new(answer) }))
}

/// What is fixed before a resonance curve is analysed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ResonanceChoices {
    band_hz: Option<(f64, f64)>,
    method: String,
    model: Option<String>,
    drive_amplitude: Option<Uncertain>,
    background: Option<bool>,
    delay: Option<bool>,
    phase_offset: Option<bool>,
    duffing: Option<bool>,
}

impl ResonanceChoices {
    fn options(self, py: Python<'_>) -> PyResult<resonance::Options> {
        let mut options = resonance::Options::default();
        options.band_hz = self.band_hz.map(<[f64; 2]>::from);
        options.method = match self.method.as_str() {
            "exact" => Method::Exact,
            "leading" => Method::Leading,
            "paper" => Method::Paper,
            other => {
                let message = format!("method={other:?}: one of exact, leading, paper");
                return Err(option_error(py, "method", message));
            }
        };
        options.model = loss_model(py, self.model)?;
        options.drive_amplitude = self.drive_amplitude.map(|u| {
            let [value, std_error] = u.parts();
            DriveAmplitude { value, std_error }
        });
        let mut terms = Terms::default();
        terms.background = self.background;
        terms.delay = self.delay;
        terms.phase_offset = self.phase_offset;
        terms.duffing = self.duffing;
        options.terms = terms;
        Ok(options)
    }
}

/// Gives the options their reference, which must be in the unit of the curve.
fn refer(
    py: Python<'_>,
    options: &mut resonance::Options,
    reading: &SweepReading,
    reference: Option<&SweepReading>,
) -> PyResult<()> {
    let Some(reference) = reference else { return Ok(()) };
    let (unit, other) = (reading.curve.unit(), reference.curve.unit());
    if unit != other {
        let message = format!(
            "reference={:?}: its amplitudes are in `{other}`, those of {} in `{unit}`; unit says what both are in",
            reference.report.path, reading.report.path
        );
        return Err(option_error(py, "reference", message));
    }
    options.reference = Some(reference.curve.clone());
    Ok(())
}

/// Analyses a resonance curve.
#[pyfunction]
pub(crate) fn resonance_answer(
    py: Python<'_>,
    curve: &Curve,
    reference: Option<&Curve>,
    choices: ResonanceChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let mut options = choices.options(py)?;
    let reading = Arc::clone(&curve.reading);
    let reference = reference.map(|r| Arc::clone(&r.reading));
    options.calibration = constants.calibration(py, reading.curve.unit())?;
    refer(py, &mut options, &reading, reference.as_deref())?;
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || resonance::analyse(&held.curve, &asked))?
        .map_err(|error| core_error(py, Analysis::Resonance, &error))?;
    let options = Box::new(options);
    Ok(Answer(Analysed::Curve { reading, reference, options, answer: Box::new(answer) }))
}

/// What is fixed before drive levels are analysed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LevelsChoices {
    frequency_hz: Option<f64>,
    drive_gain: Option<Uncertain>,
    q_factor: Option<Uncertain>,
}

impl LevelsChoices {
    fn options(self, reading: &LevelReading) -> levels::Options {
        let mut options = levels::Options::default();
        options.frequency_hz = self.frequency_hz.or_else(|| reading.named_frequency_hz());
        options.drive_gain = self.drive_gain.map(Uncertain::parts);
        options.q_factor = self.q_factor.map(Uncertain::parts);
        options
    }
}

/// Analyses amplitudes over drive levels.
#[pyfunction]
pub(crate) fn levels_answer(
    py: Python<'_>,
    levels: &Levels,
    choices: LevelsChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let reading = Arc::clone(&levels.reading);
    let mut options = choices.options(&reading);
    options.calibration = constants.calibration(py, reading.levels.unit())?;
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || levels::analyse(&held.levels, &asked))?
        .map_err(|error| core_error(py, Analysis::Levels, &error))?;
    Ok(Answer(Analysed::Levels { reading, options, answer: Box::new(answer) }))
}

/// One measurement of a series: data with the choices for its analysis.
#[derive(FromPyObject)]
pub(crate) enum Measured<'py> {
    #[pyo3(transparent)]
    Ringdown((PyRef<'py, Record>, RingdownChoices)),
    #[pyo3(transparent)]
    Sweep((PyRef<'py, Curve>, Option<PyRef<'py, Curve>>, ResonanceChoices)),
    #[pyo3(transparent)]
    Levels((PyRef<'py, Levels>, LevelsChoices)),
}

fn in_keywords(notes: &[Note]) -> Vec<String> {
    notes.iter().map(|note| note.spelled(&spell)).collect()
}

impl Measured<'_> {
    fn data(self, py: Python<'_>) -> PyResult<(Data, SeriesInput)> {
        Ok(match self {
            Self::Ringdown((record, choices)) => {
                let reading = &record.reading;
                let mut options = choices.options(py)?;
                options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
                let input = SeriesInput {
                    path: reading.report.path.clone(),
                    sha256: reading.report.sha256.clone(),
                    kind: "ringdown",
                    unit: reading.record.unit().to_owned(),
                    notes: in_keywords(&reading.report.notes),
                };
                let record = Box::new(reading.record.clone());
                (Data::RingDown { record, options: Box::new(options) }, input)
            }
            Self::Sweep((curve, reference, choices)) => {
                let reading = &curve.reading;
                let mut options = choices.options(py)?;
                refer(py, &mut options, reading, reference.as_ref().map(|r| &*r.reading))?;
                let input = SeriesInput {
                    path: reading.report.path.clone(),
                    sha256: reading.report.sha256.clone(),
                    kind: "sweep",
                    unit: reading.curve.unit().to_owned(),
                    notes: in_keywords(&reading.report.notes),
                };
                (Data::Sweep { curve: Box::new(reading.curve.clone()), options: Box::new(options) }, input)
            }
            Self::Levels((levels, choices)) => {
                let reading = &levels.reading;
                let input = SeriesInput {
                    path: reading.report.path.clone(),
                    sha256: reading.report.sha256.clone(),
                    kind: "levels",
                    unit: reading.levels.unit().to_owned(),
                    notes: in_keywords(&reading.report.notes),
                };
                let options = Box::new(choices.options(reading));
                (Data::Levels { levels: Box::new(reading.levels.clone()), options }, input)
            }
        })
    }
}

/// A measurement with its name, the label and value of its condition, and its scale.
type Entry<'py> = (Measured<'py>, String, String, Option<(f64, f64)>, Option<f64>);

/// What stands above the measurements of a series.
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
        let (data, input) = measured.data(py)?;
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
                    "no unit is named: its numbers were taken as {unit}; unit or scale says otherwise"
                ));
                1.0
            }
            None => DisplacementUnit::factor(&input.unit, &unit).map_err(|_| {
                let message = format!(
                    "{}: it is in `{}`, the series in `{unit}`; scale gives the factor between the two",
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

/// Names of every parameter an answer may have.
#[pyfunction]
pub(crate) fn parameter_names() -> Vec<&'static str> {
    Parameter::all().map(Parameter::name).collect()
}

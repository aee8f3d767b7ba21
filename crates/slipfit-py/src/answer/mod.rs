//! Answers and their reports.

mod analyse;
mod choices;
mod series;

pub(crate) use analyse::{check_ringdown, levels_answer, resonance_answer, ringdown_answer};
pub(crate) use choices::RingdownChoices;
pub(crate) use series::series_answer;

use crate::failure::{HintParts, hint_parts, spell};
use crate::interrupt::uninterrupted;
use anstyle::Style;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipfit::answer::{Parameters, Warning};
use slipfit::series::Measurement;
use slipfit::{Parameter, levels, resonance, ringdown, series as several};
use slipfit_io::{LevelReading, Reading, SweepReading};
use slipfit_report::{
    AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, Report, SeriesHeading, SeriesInput,
    page, plot::Format, terminal, warning_text,
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
        options: several::Options,
        answer: Box<several::Answer>,
    },
}

impl Analysed {
    /// The result of `look` for the report.
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

    /// The measured data and the fitted model, as named arrays.
    fn fit(&self) -> Vec<(&'static str, Vec<f64>)> {
        let mut columns = Vec::new();
        match self {
            Self::Ringdown { reading, answer, .. } => {
                let record = &reading.record;
                let [start, end] = answer.fit.range_s();
                let times = record.times_s(0..record.len());
                let within = |t: f64| (start..=end).contains(&t);
                let of = |f: &dyn Fn(f64) -> f64| {
                    times.iter().map(|&t| if within(t) { f(t) } else { f64::NAN }).collect::<Vec<_>>()
                };
                let (amplitude, fitted) =
                    (of(&|t| answer.fit.amplitude_at(t)), of(&|t| answer.fit.signal_at(t)));
                columns.push(("time_s", times));
                columns.push(("signal", record.signal().to_vec()));
                columns.push(("fitted", fitted));
                columns.push(("amplitude", amplitude));
            }
            Self::Curve { answer, .. } => {
                let hz: Vec<f64> = answer.points.iter().map(|p| p.frequency_hz).collect();
                let ends = [
                    hz.iter().copied().fold(f64::INFINITY, f64::min),
                    hz.iter().copied().fold(0.0, f64::max),
                ];
                let dense = even(ends);
                columns.push(("amplitude", dense.iter().map(|f| answer.fit.response(*f).norm()).collect()));
                columns.push(("phase_rad", dense.iter().map(|f| answer.fit.response(*f).arg()).collect()));
                columns.push((
                    "friction_free",
                    dense.iter().map(|f| answer.fit.friction_free(*f).norm()).collect(),
                ));
                columns.push(("frequency_hz", dense));
            }
            Self::Levels { answer, .. } => {
                let most = answer.points.iter().map(|p| p.drive).fold(0.0, f64::max);
                let dense = even([0.0, most]);
                columns.push(("amplitude", dense.iter().map(|d| answer.fit.amplitude(*d)).collect()));
                columns.push(("friction_free", dense.iter().map(|d| answer.fit.friction_free(*d)).collect()));
                columns.push(("drive", dense));
            }
            Self::Series { .. } => {}
        }
        columns
    }
}

/// Name, value, standard error, interval, value without its limit, unit.
type QuantityParts = (&'static str, f64, f64, (f64, f64), f64, String);
/// Code, message, hints, and all of these in words.
type WarningParts = (&'static str, String, Vec<HintParts>, String);

impl Answer {
    /// The text that `write` writes of the report.
    fn written(
        &self,
        py: Python<'_>,
        write: impl FnOnce(&dyn Report, &mut Vec<u8>) -> std::io::Result<()> + Send,
    ) -> PyResult<String> {
        let text = uninterrupted(py, || {
            let mut text = Vec::new();
            self.0.report(|report| write(report, &mut text)).map(|()| text)
        })??;
        Ok(String::from_utf8(text)?)
    }
}

#[pymethods]
impl Answer {
    /// The whole answer as JSON: docs/json.md.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let write = |report: &dyn Report, text: &mut Vec<u8>| report.write_json(text);
        self.written(py, write)
    }

    /// The numbers behind the figure as CSV.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        let write = |report: &dyn Report, text: &mut Vec<u8>| report.write_csv(text);
        self.written(py, write)
    }

    /// The report as on a screen, without colours.
    fn screen(&self, py: Python<'_>) -> PyResult<String> {
        let print = |report: &dyn Report| {
            let document = report.document(&spell);
            let warnings: String =
                document.warnings().iter().map(|w| terminal::warning(w, Style::new())).collect();
            let text = terminal::screen(&document, &[]) + &warnings;
            anstream::adapter::strip_str(&text).to_string()
        };
        uninterrupted(py, || self.0.report(print))
    }

    /// The answer, its parameters and tables as one element of HTML.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        uninterrupted(py, || self.0.report(|report| page::fragment(&report.document(&spell))))
    }

    /// The figure as SVG.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        let picture = uninterrupted(py, || self.0.report(|report| report.figure().render(Format::Svg)))?;
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

    /// The measured data and the fitted model, as named arrays.
    fn fit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        for (name, values) in uninterrupted(py, || self.0.fit())? {
            columns.set_item(name, values.into_pyarray(py))?;
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

/// Number of points of a drawn curve.
const DENSE: u32 = 801;

fn even([from, to]: [f64; 2]) -> Vec<f64> {
    (0..DENSE).map(|i| from + (to - from) * f64::from(i) / f64::from(DENSE - 1)).collect()
}

/// Names of all parameters an answer may have.
#[pyfunction]
pub(crate) fn parameter_names() -> Vec<&'static str> {
    Parameter::all().map(Parameter::name).collect()
}

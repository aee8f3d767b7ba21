//! Exceptions: the errors of the libraries, with their values as attributes and their hints in Python syntax.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use slipfit::Error;
use slipfit::answer::hint::{Analysis, Hint, HintValue, spelled};
use slipfit::error::out_of_range;
use slipfit_io::{ReadError, ReadProblem};
use std::fmt::Debug;

/// An option of a library with its value as a keyword argument: `band_hz=(79, 82)`, `slipfit.levels`.
pub(crate) fn spell(option: &'static str, value: Option<&HintValue>) -> String {
    if let ("analysis", Some(analysis)) = (option, value) {
        return format!("slipfit.{analysis}");
    }
    let name = keyword(option);
    match value {
        None => name.to_owned(),
        // Words of the command line that stand for a value.
        Some(HintValue::Text(word)) if word == "RATE" => name.to_owned(),
        Some(HintValue::Text(word)) => match (word.as_str(), switch(name)) {
            ("off", true) => format!("{name}=False"),
            ("on", true) => format!("{name}=True"),
            _ => format!("{name}={word:?}"),
        },
        Some(value) => format!("{name}={value}"),
    }
}

/// The keyword that sets an option of a library, if it differs from the option's name.
pub(crate) fn keyword(option: &str) -> &str {
    match option {
        "time_constant_s" => "lockin_time_constant_s",
        "order" => "lockin_order",
        other => other,
    }
}

fn switch(name: &str) -> bool {
    matches!(name, "background" | "delay" | "amplitude_offset" | "noise_floor" | "phase_offset" | "duffing")
}

/// A hint in Python: option, value, advice, and all of these in words.
pub(crate) type HintParts = (Option<String>, Option<Py<PyAny>>, String, String);

pub(crate) fn hint_parts(py: Python<'_>, hint: &Hint) -> PyResult<HintParts> {
    let known = hint.value.as_ref().filter(|value| **value != HintValue::Text("RATE".to_owned()));
    let value = known.map(|value| {
        Ok::<_, PyErr>(match value {
            HintValue::Number(number) => number.into_pyobject(py)?.into_any().unbind(),
            HintValue::Range([low, high]) => (*low, *high).into_pyobject(py)?.into_any().unbind(),
            HintValue::Text(word) => word.into_pyobject(py)?.into_any().unbind(),
        })
    });
    // Another analysis is advice, not an argument.
    let option = hint.option.filter(|option| *option != "analysis").map(|option| keyword(option).to_owned());
    Ok((option, value.transpose()?, hint.advice.clone().into_owned(), hint.spelled(&spell)))
}

/// Name of an enum's variant as a code: `NotARingDown` becomes `not_a_ring_down`.
fn code(variant: &impl Debug) -> String {
    let text = format!("{variant:?}");
    let name = text.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
    name.char_indices().fold(String::new(), |mut code, (i, c)| {
        if c.is_ascii_uppercase() && i > 0 {
            code.push('_');
        }
        code.push(c.to_ascii_lowercase());
        code
    })
}

/// An exception of `slipfit._errors`.
pub(crate) struct Failure<'py> {
    py: Python<'py>,
    class: &'static str,
    message: String,
    code: String,
    hints: Vec<Hint>,
    details: Bound<'py, PyDict>,
}

impl<'py> Failure<'py> {
    pub(crate) fn new(py: Python<'py>, class: &'static str, code: &str, message: impl Into<String>) -> Self {
        Self {
            py,
            class,
            message: message.into(),
            code: code.to_owned(),
            hints: Vec::new(),
            details: PyDict::new(py),
        }
    }

    /// Adds an attribute of the exception; one that cannot be converted is left out.
    pub(crate) fn with(self, name: &str, value: impl IntoPyObject<'py>) -> Self {
        if let Ok(value) = value.into_bound_py_any(self.py) {
            // Setting a string key cannot fail.
            let _ = self.details.set_item(name, value);
        }
        self
    }

    pub(crate) fn hints(mut self, hints: Vec<Hint>) -> Self {
        self.hints = hints;
        self
    }

    pub(crate) fn into_error(self) -> PyErr {
        let py = self.py;
        let raise = || -> PyResult<Bound<'py, PyAny>> {
            let hints = PyList::empty(py);
            for hint in &self.hints {
                hints.append(hint_parts(py, hint)?)?;
            }
            let words = spelled(&self.hints, &spell);
            let class = py.import("slipfit._errors")?.getattr(self.class)?;
            class.call1((&self.message, &self.code, hints, words, &self.details))
        };
        raise().map_or_else(|error| error, PyErr::from_value)
    }
}

/// The exception for an invalid argument.
pub(crate) fn option_error(py: Python<'_>, option: &str, message: impl Into<String>) -> PyErr {
    Failure::new(py, "OptionError", "option", message).with("option", option).into_error()
}

/// The exception for an error of the core.
pub(crate) fn core_error(py: Python<'_>, analysis: Analysis, error: &Error) -> PyErr {
    let class = match error {
        Error::NoOscillation { .. }
        | Error::NotARingDown { .. }
        | Error::NoSteadyMotion { .. }
        | Error::NoFit { .. }
        | Error::NoResonance { .. } => "NoAnswerError",
        _ => "OptionError",
    };
    let message = match error {
        Error::Parameter { name, value, range } => out_of_range(keyword(name), *value, range),
        other => other.to_string(),
    };
    let raised = Failure::new(py, class, &code(error), message).hints(error.hints(analysis));
    match error {
        Error::Parameter { name, value, range } => {
            raised.with("option", keyword(name)).with("value", *value).with("range", *range)
        }
        Error::MissingParameter { name, .. } => raised.with("option", keyword(name)),
        Error::ConflictingParameters { second, .. } => raised.with("option", keyword(second)),
        Error::OutsideRecord { name, value_s, from_s, to_s } => {
            raised.with("option", *name).with("value", *value_s).with("range", (*from_s, *to_s))
        }
        Error::Length { name, found, expected } => {
            raised.with("option", *name).with("found", *found).with("expected", *expected)
        }
        Error::TooFewSamples { found, needed } => raised.with("found", *found).with("needed", *needed),
        Error::TooFewPoints { points, parameters } => {
            raised.with("found", *points).with("needed", parameters + 1)
        }
        Error::TimeBackwards { index, previous, next }
        | Error::TimeOutOfOrder { index, previous, next, .. } => {
            raised.with("index", *index).with("previous", *previous).with("next", *next)
        }
        Error::Band { low_hz, high_hz } => {
            raised.with("option", "band_hz").with("value", (*low_hz, *high_hz))
        }
        Error::NoSuchRun { asked, found } => {
            raised.with("option", "run").with("value", *asked).with("found", *found)
        }
        Error::NotARingDown { cycles, needed, reason } => {
            raised.with("cycles", *cycles).with("needed", *needed).with("reason", *reason)
        }
        Error::NoSteadyMotion { cycles, needed } => raised.with("cycles", *cycles).with("needed", *needed),
        Error::NoFit { reason } | Error::NoOscillation { reason } | Error::NoResonance { reason } => {
            raised.with("reason", *reason)
        }
        Error::ConstantSignal { value } => raised.with("value", *value),
        Error::PointOutOfRange { name, index, value, range } => {
            raised.with("option", *name).with("index", *index).with("value", *value).with("range", *range)
        }
        Error::FrequencyNegative { index, value } => raised.with("index", *index).with("value", *value),
        Error::WrongCoordinate { unit, .. } => raised.with("unit", unit),
        Error::NeitherLengthNorAngle { unit } => raised.with("option", "unit").with("value", unit),
        Error::BelowLeastAmplitude { least, initial, .. } => {
            raised.with("option", "min_amplitude").with("value", *least).with("initial", *initial)
        }
        _ => raised,
    }
    .into_error()
}

/// The exception for a file that could not be read; errors of the system are an `OSError`, as elsewhere in
/// Python.
pub(crate) fn read_error(py: Python<'_>, error: ReadError) -> PyErr {
    match error.problem {
        ReadProblem::Io(ref problem) => {
            let text = problem.to_string();
            match problem.raw_os_error() {
                // Python adds number and file itself.
                Some(number) => {
                    let text = text.split(" (os error").next().unwrap_or_default().to_owned();
                    PyOSError::new_err((number, text, error.file))
                }
                None => PyOSError::new_err(format!("{}: {text}", error.file)),
            }
        }
        ref problem => {
            let raised = Failure::new(py, "ReadError", &code(problem), error.spelled(&spell));
            let raised = raised.hints(error.hints()).with("file", &error.file).with("row", problem.row());
            match problem {
                ReadProblem::Option { option, value, .. } => {
                    raised.with("option", *option).with("value", value)
                }
                ReadProblem::Data(Error::Parameter { name, value, range }) => {
                    raised.with("option", keyword(name)).with("value", *value).with("range", *range)
                }
                ReadProblem::Data(Error::PointOutOfRange { name, index, value, range }) => raised
                    .with("option", *name)
                    .with("index", *index)
                    .with("value", *value)
                    .with("range", *range),
                ReadProblem::TimeBackwards { column, .. }
                | ReadProblem::TooFewRows { column, .. }
                | ReadProblem::Negative { column, .. }
                | ReadProblem::NoTickRate { column }
                | ReadProblem::NoCentre { column }
                | ReadProblem::TimeRecord { column, .. }
                | ReadProblem::NotOverTime { column, .. }
                | ReadProblem::OneFrequency { column, .. }
                | ReadProblem::OneLevel { column, .. }
                | ReadProblem::ConstantSignal { column, .. } => raised.with("column", column),
                _ => raised,
            }
            .into_error()
        }
    }
}

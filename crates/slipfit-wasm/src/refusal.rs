//! Why there is no answer, with hints.

use crate::words::words;
use serde::Serialize;
use serde_json::{Value, json};
use slipfit::answer::hint::{Analysis, Hint, HintValue};
use slipfit_io::{Format, ReadError, ReadProblem};

/// A failure, described for the user.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refusal {
    /// What is wrong.
    pub message: String,
    /// What would help.
    pub hints: Vec<Advice>,
    /// Whether this crate can read the file with its feature `formats`, without which it was built.
    pub with_formats: bool,
}

/// A hint that a page can turn into a button: set `option` to `value`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// The option, by its name in [`crate::Options`]; `None` if no option helps.
    pub option: Option<&'static str>,
    /// The value to give it, as JSON; null if the user must choose.
    pub value: Value,
    /// What that does.
    pub advice: String,
}

impl Refusal {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hints: Vec::new(), with_formats: false }
    }

    /// The failure of an analysis.
    pub(crate) fn analysing(what: Analysis, file: &str, error: &slipfit::Error) -> Self {
        let hints = error.hints(what).iter().map(Advice::from).collect();
        Self { hints, ..Self::new(format!("{file}: {error}")) }
    }
}

impl From<ReadError> for Refusal {
    fn from(error: ReadError) -> Self {
        let further = |format: &Format| {
            use Format::{Aac, Arrow, Flac, Hdf5, Mp3, Mp4, Ods, Ogg, Parquet, Xls, Xlsx};
            let sound = matches!(format, Aac | Flac | Mp3 | Mp4 | Ogg);
            sound || matches!(format, Arrow | Hdf5 | Parquet | Ods | Xls | Xlsx)
        };
        let with_formats = !cfg!(feature = "formats")
            && matches!(&error.problem, ReadProblem::Unsupported(format) if further(format));
        let hints = error.hints().iter().map(Advice::from).collect();
        Self { hints, with_formats, ..Self::new(error.spelled(&words)) }
    }
}

impl From<&Hint> for Advice {
    fn from(hint: &Hint) -> Self {
        let value = match &hint.value {
            None => Value::Null,
            Some(HintValue::Number(number)) => json!(number),
            Some(HintValue::Range(limits)) => json!(limits),
            Some(HintValue::Text(word)) => json!(word),
        };
        Self { option: hint.option, value, advice: hint.advice.clone().into_owned() }
    }
}

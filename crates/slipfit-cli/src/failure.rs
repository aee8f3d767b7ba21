//! Why a command failed, and what would help.

use anstyle::{AnsiColor, Style};
use slipfit::answer::Warning;
use slipfit::answer::hint::{self, Hint, HintValue};
use slipfit_report::terminal::hanging;
use std::fmt;
use std::path::Path;

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
const HINT: Style = AnsiColor::Cyan.on_default();

/// A failure as the person sees it; exit status 2.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Something to say.
    Said(Complaint),
    /// The reader of our output has gone: nothing to say, and to nobody.
    ClosedPipe,
}

#[derive(Debug)]
pub(crate) struct Complaint {
    message: String,
    hint: Option<String>,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self::Said(Complaint { message: message.into(), hint: None })
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        if let Self::Said(complaint) = &mut self {
            complaint.hint = Some(hint.into());
        }
        self
    }

    /// What went wrong, in one line.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Said(complaint) => complaint.message.clone(),
            Self::ClosedPipe => "the output was closed".to_owned(),
        }
    }

    /// Output that could not be written.
    pub(crate) fn writing(target: &str, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::ClosedPipe;
        }
        Self::new(format!("{target}: cannot be written: {error}"))
    }

    /// An analysis that could not be done.
    pub(crate) fn analysing(file: &Path, error: &slipfit::Error) -> Self {
        if let slipfit::Error::Parameter { name, value, range } = error {
            return Self::new(format!("{} {value}: must be among {}", flag(name), in_flags(range)));
        }
        let failure = Self::new(format!("{}: {error}", file.display()));
        match error {
            slipfit::Error::NoOscillation { .. } => {
                failure.hint("--signal names another column, --kind says what it holds, --band where to look")
            }
            slipfit::Error::NotARingDown { .. }
            | slipfit::Error::TooFewSamples { .. }
            | slipfit::Error::OutsideRecord { .. } => {
                failure.hint("--start and --end choose the free decay by hand; a longer record helps more")
            }
            slipfit::Error::NoFit { .. } => failure.hint("--start, --end and --band choose a cleaner part"),
            slipfit::Error::ConstantSignal { .. } => failure.hint("--signal names another column"),
            slipfit::Error::TimeBackwards { .. } | slipfit::Error::TimeStandsStill { .. } => {
                let time = Hint::new("time", "names another column");
                failure.hint(in_flags_with_values(&[time, Hint::new("rate_hz", "replaces it")]))
            }
            _ => failure,
        }
    }
}

impl Failure {
    /// A curve, levels or a series that could not be analysed.
    pub(crate) fn analysing_curve(file: &Path, error: &slipfit::Error) -> Self {
        use slipfit::Error;
        if let Error::Parameter { name, value, range } = error {
            return Self::new(format!("{} {value}: must be among {}", flag(name), in_flags(range)));
        }
        let failure = Self::new(format!("{}: {error}", file.display()));
        match error {
            Error::TooFewPoints { .. } | Error::TooFewSamples { .. } => failure.hint(
                "measure more points across the line; --background off, --delay off and --duffing off need fewer",
            ),
            Error::NoResonance { .. } => {
                failure.hint("--amplitude names another column, --frequency-unit its unit, --band where to look")
            }
            Error::NoFit { .. } => failure.hint("--band chooses a cleaner part, --model another law"),
            Error::ConflictingParameters { .. } => failure.hint("give --drive-amplitude or --reference, not both"),
            _ => failure,
        }
    }
}

impl Failure {
    /// Amplitudes over drive levels that could not be analysed.
    pub(crate) fn analysing_levels(file: &Path, error: &slipfit::Error) -> Self {
        use slipfit::Error;
        if let Error::Parameter { name, value, range } = error {
            return Self::new(format!("{} {value}: must be among {}", flag(name), in_flags(range)));
        }
        let failure = Self::new(format!("{}: {error}", file.display()));
        match error {
            Error::TooFewPoints { .. } | Error::TooFewSamples { .. } => {
                failure.hint("measure at more levels of the drive, below and above the threshold")
            }
            Error::NoFit { .. } | Error::NoResonance { .. } => {
                failure.hint("--drive and --amplitude name other columns")
            }
            _ => failure,
        }
    }
}

/// Hints of the libraries with the flags of this program: `--band 79 82 isolates one mode`.
pub(crate) fn in_flags_with_values(hints: &[Hint]) -> String {
    hint::spelled(hints, &spelled)
}

/// An option of a library with its value, as this program takes it: `--band 79 82`.
pub(crate) fn spelled(option: &'static str, value: Option<&HintValue>) -> String {
    let flag = match flag(option) {
        known if known.starts_with("--") => known.to_owned(),
        other => format!("--{}", other.replace('_', "-")),
    };
    match value {
        None => flag,
        Some(HintValue::Number(number)) => format!("{flag} {number}"),
        Some(HintValue::Range([low, high])) => format!("{flag} {low} {high}"),
        Some(HintValue::Text(word)) => format!("{flag} {word}"),
    }
}

/// The flag that sets an option of a library, where it is not the option's name.
fn flag(name: &str) -> &str {
    match name {
        "start_s" => "--start",
        "end_s" => "--end",
        "min_amplitude" => "--min-amplitude",
        "band_hz" => "--band",
        "frequency_hz" => "--frequency-hz",
        "rate_hz" => "--rate-hz",
        "time_constant_s" => "--lockin-time-constant",
        "order" => "--lockin-order",
        "drive_amplitude" | "drive_amplitude std_error" => "--drive-amplitude",
        "drive_gain" => "--drive-gain",
        "q_factor" => "--q",
        "calibration" | "calibration std_error" => "--stiffness or --mass",
        other => other,
    }
}

fn in_flags(text: &str) -> String {
    text.split(' ').map(flag).collect::<Vec<_>>().join(" ")
}

impl From<slipfit_io::ReadError> for Failure {
    fn from(error: slipfit_io::ReadError) -> Self {
        let failure = Self::new(error.spelled(&spelled));
        match &error.hints()[..] {
            [] => failure,
            hints => failure.hint(in_flags_with_values(hints)),
        }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hanging("error:", ERROR, &self.message))?;
        match &self.hint {
            Some(hint) => f.write_str(&hanging("  hint:", HINT, hint)),
            None => Ok(()),
        }
    }
}

/// A warning of an analysis with what helps, for standard error.
pub(crate) fn warned(warning: &Warning) -> String {
    warning_line(&slipfit_report::warning_text(warning, &spelled))
}

/// A warning, for standard error.
pub(crate) fn warning_line(text: &str) -> String {
    hanging("warning:", WARNING, text)
}

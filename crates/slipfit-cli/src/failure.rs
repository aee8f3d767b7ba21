//! Failures of commands, with hints.

use anstyle::{AnsiColor, Style};
use slipfit::Error;
use slipfit::answer::hint::{self, Analysis, Hint, HintValue};
use slipfit_report::format::plain;
use slipfit_report::terminal::hanging;
use std::fmt;
use std::path::Path;

const ERROR: Style = AnsiColor::Red.on_default().bold();
pub(crate) const WARNING: Style = AnsiColor::Yellow.on_default().bold();
const HINT: Style = AnsiColor::Cyan.on_default();

/// Exit status of warnings under `--strict`.
pub(crate) const WARNED: u8 = 1;
/// Exit status of a failure; clap uses the same for a wrong command line.
pub(crate) const FAILED: u8 = 2;

/// The error of `slipfit app` in a program without the page, and the hint for it.
pub(crate) const WITHOUT_PAGE: &str = "this slipfit was built without the browser page";
pub(crate) const BUILD_PAGE: &str = "`cargo xtask web` builds the page into target/site; SLIPFIT_SITE names that \
    folder where slipfit is built with --features app";

/// A failure as shown to the user; exit status [`FAILED`].
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error with its message.
    Message(MessageWithHint),
    /// The reader of the output has closed the pipe: nobody is left to be told.
    ClosedPipe,
}

#[derive(Debug)]
pub(crate) struct MessageWithHint {
    message: String,
    hint: Option<String>,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self::Message(MessageWithHint { message: message.into(), hint: None })
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        if let Self::Message(complaint) = &mut self {
            complaint.hint = Some(hint.into());
        }
        self
    }

    /// What went wrong, in one line.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Message(complaint) => complaint.message.clone(),
            Self::ClosedPipe => "the output was closed".to_owned(),
        }
    }

    /// The failure of writing to an output.
    pub(crate) fn writing(target: &str, error: &std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::ClosedPipe;
        }
        Self::new(format!("{target}: cannot be written: {error}"))
    }

    /// The failure of an analysis.
    pub(crate) fn analysing(what: Analysis, file: &Path, error: &Error) -> Self {
        match error {
            Error::Parameter { name, value, range } => {
                let range = in_flags(range);
                let must_be = match range.strip_prefix("times ") {
                    Some(rest) => format!("must be a time {rest}"),
                    None => format!("must be among {range}"),
                };
                return Self::new(format!("{} {value}: {must_be}", flag(name)));
            }
            Error::Band { low_hz, high_hz } => {
                return Self::new(format!("--band {low_hz} {high_hz}: the lower frequency must come first"));
            }
            Error::BelowLeastAmplitude { least, initial, unit } => {
                let initial = plain(*initial, 3, unit);
                return Self::new(format!(
                    "--min-amplitude {least} {unit}: the decay already begins at {initial}"
                ));
            }
            Error::OutsideRecord { name, value_s, from_s, to_s } => {
                let message = format!(
                    "{}: {} {value_s} leaves no samples: the record extends from {from_s} s to {to_s} s",
                    file.display(),
                    flag(name)
                );
                return Self::new(message).hints(&error.hints(what));
            }
            Error::MissingParameter { name, hint } => {
                return Self::new(format!("{} is missing: {hint}", flag(name))).hints(&error.hints(what));
            }
            _ => {}
        }
        Self::new(format!("{}: {error}", file.display())).hints(&error.hints(what))
    }

    /// The same with hints, if there are any.
    pub(crate) fn hints(self, hints: &[Hint]) -> Self {
        if hints.is_empty() { self } else { self.hint(hint::spelled(hints, &spelled)) }
    }
}

/// An option of a library with its value, in the syntax of this program: `--band 79 82`, `slipfit levels`.
pub(crate) fn spelled(option: &'static str, value: Option<&HintValue>) -> String {
    if let ("analysis", Some(analysis)) = (option, value) {
        return format!("slipfit {analysis}");
    }
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

/// The flag that sets an option of a library, if it differs from the option's name.
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
        Self::new(error.spelled(&spelled)).hints(&error.hints())
    }
}

impl fmt::Display for MessageWithHint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hanging("error:", ERROR, &self.message))?;
        match &self.hint {
            Some(hint) => f.write_str(&hanging("  hint:", HINT, hint)),
            None => Ok(()),
        }
    }
}

/// A note on how the program is used, for standard error.
pub(crate) fn note_line(text: &str) -> String {
    hanging("note:", HINT, text)
}

/// A warning, for standard error.
pub(crate) fn warning_line(text: &str) -> String {
    hanging("warning:", WARNING, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_of_an_analysis_are_spelled_as_flags() {
        let hint = |what, error| match Failure::analysing(what, Path::new("a.csv"), &error) {
            Failure::Message(complaint) => complaint.hint.unwrap_or_default(),
            Failure::ClosedPipe => String::new(),
        };
        let refused = Error::NotARingDown { cycles: 1.0, needed: 3.0, reason: "it does not decay" };
        assert_eq!(
            hint(Analysis::Ringdown, refused),
            "--start or --end chooses the free decay by hand; a longer record helps more"
        );
        let few = Error::TooFewPoints { points: 4, parameters: 6 };
        assert_eq!(
            hint(Analysis::Resonance, few),
            "measure more points across the peak; --background off, --delay off or --duffing off needs fewer"
        );
        assert_eq!(spelled("analysis", Some(&Analysis::Levels.into())), "slipfit levels");
    }
}

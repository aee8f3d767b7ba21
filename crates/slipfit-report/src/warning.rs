//! Warnings with their hints, in the notation of the program that shows them.

use slipfit::answer::Warning;
use slipfit::answer::hint::{Spelling, spelled};

/// A warning in one line: what was found, then what helps, with each option written by `spell`.
///
/// ```
/// use slipfit::answer::Warning;
/// use slipfit_report::warning_text;
/// let modes = Warning::SeveralModes { main_hz: 80.52, other_hz: 297.667, relative_amplitude: 0.18 };
/// let python = |option: &'static str, value: Option<&slipfit::answer::hint::HintValue>| match value {
///     Some(value) => format!("{option}={value}"),
///     None => option.to_owned(),
/// };
/// assert!(warning_text(&modes, &python).ends_with("; band_hz=(8.052, 167.3788) isolates the first"));
/// ```
pub fn warning_text(warning: &Warning, spell: Spelling<'_>) -> String {
    let hints = warning.hints();
    if hints.is_empty() { warning.to_string() } else { format!("{warning}; {}", spelled(&hints, spell)) }
}

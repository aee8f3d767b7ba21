//! What a step is and how it ends.

use std::time::Duration;

use crate::Failure;

/// Result of a step that did not fail; the text is the note in the table.
pub(super) enum Outcome {
    Passed(String),
    Skipped(String),
}

impl Outcome {
    pub(super) fn passed() -> Outcome {
        Outcome::Passed(String::new())
    }
}

/// Profile with which a step compiles.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Profile {
    /// Development, or nothing is compiled.
    Dev,
    /// Release.
    Release,
}

/// A step with its name.
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) profile: Profile,
    pub(super) action: fn() -> Result<Outcome, Failure>,
}

impl Step {
    pub(super) const fn dev(name: &'static str, action: fn() -> Result<Outcome, Failure>) -> Step {
        Step { name, profile: Profile::Dev, action }
    }

    pub(super) const fn release(name: &'static str, action: fn() -> Result<Outcome, Failure>) -> Step {
        Step { name, profile: Profile::Release, action }
    }
}

/// A finished step: one row of the table.
pub(super) struct Row {
    pub(super) name: String,
    pub(super) result: Result<Outcome, Failure>,
    pub(super) time: Duration,
}

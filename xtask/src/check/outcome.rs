//! What a step is and how it ends.

use crate::Failure;

/// How a step ended that did not fail; the text is the note in the table.
pub(super) enum Outcome {
    Passed(String),
    Skipped(String),
}

impl Outcome {
    pub(super) fn passed() -> Outcome {
        Outcome::Passed(String::new())
    }
}

/// A step with its name.
pub(super) type Step = (&'static str, fn() -> Result<Outcome, Failure>);

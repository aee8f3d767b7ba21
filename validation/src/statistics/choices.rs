//! Command-line options of a run of the statistics.

use crate::Failure;
use crate::places::write_page;

/// What the arguments select.
pub(super) struct Choices {
    /// Number of trials of each experiment.
    pub(super) seeds: u64,
    /// Only the experiments whose name contains this text are run.
    pub(super) only: String,
    /// Whether to rewrite the page of the documentation.
    pub(super) write: bool,
}

impl Choices {
    pub(super) fn publish(&self, page: &str, text: &str) -> Result<(), Failure> {
        if self.write {
            write_page(page, text)
        } else {
            println!("{text}");
            Ok(())
        }
    }
}

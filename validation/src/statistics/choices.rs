//! What a run of the statistics is asked for.

use crate::Failure;
use crate::places::write_page;

/// What the arguments ask for.
pub(super) struct Choices {
    /// Trials of each experiment.
    pub(super) seeds: u64,
    /// Only the experiments whose name contains this.
    pub(super) only: String,
    /// Whether to renew the page of the documentation.
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

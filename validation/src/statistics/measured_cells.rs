//! Cells of a page: each is measured, and those that miss the requirement are measured again.

use std::ops::Range;

/// Factor by which the number of trials is raised for a cell that misses.
const REPEAT_FACTOR: u64 = 10;

/// A cell with the scores of its trials.
pub(super) trait Scored {
    /// Whether it misses the requirement of the page.
    fn misses(&self) -> bool;
}

/// The measured cells, and the cells that missed, measured again on other trials.
pub(super) struct MeasuredCells<R> {
    pub(super) rows: Vec<R>,
    again: Vec<R>,
}

impl<R: Scored> MeasuredCells<R> {
    pub(super) fn new() -> Self {
        Self { rows: Vec::new(), again: Vec::new() }
    }

    /// Measures a cell on this many trials, identified by their seeds.
    pub(super) fn measure(&mut self, trials: u64, measured: impl Fn(Range<u64>) -> R) {
        let row = measured(0..trials);
        if row.misses() {
            self.again.push(measured(trials..(1 + REPEAT_FACTOR) * trials));
        }
        self.rows.push(row);
    }

    /// The section about the cells that miss; `demand` states the requirement that the cells miss, and ends with the
    /// subject of the sentence about the repeated measurement.
    pub(super) fn misses(&self, demand: &str, trials: &str, table: impl Fn(&[&R]) -> String) -> String {
        let (missing, by_chance): (Vec<&R>, Vec<&R>) = self.again.iter().partition(|row| row.misses());
        format!(
            "\n## Cells that miss\n\n{} of {} cells {demand} were measured again on {REPEAT_FACTOR} times as many other {trials}, \
             by which {} still miss:\n\n{}\nand {} do not:\n\n{}",
            self.again.len(),
            self.rows.len(),
            missing.len(),
            table(&missing),
            by_chance.len(),
            table(&by_chance)
        )
    }
}

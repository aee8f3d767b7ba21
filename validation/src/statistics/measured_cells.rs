//! Cells of a page: each is measured, and those that miss are measured again.

use std::ops::Range;

/// Times as many trials for a cell that misses.
const MORE: u64 = 10;

/// A cell with what became of its trials.
pub(super) trait Scored {
    /// Whether it falls short of what the page demands.
    fn misses(&self) -> bool;
}

/// The cells measured, and those that missed, measured again on other trials.
pub(super) struct MeasuredCells<R> {
    pub(super) rows: Vec<R>,
    again: Vec<R>,
}

impl<R: Scored> MeasuredCells<R> {
    pub(super) fn new() -> Self {
        Self { rows: Vec::new(), again: Vec::new() }
    }

    /// Measures a cell on so many trials, by their seeds.
    pub(super) fn measure(&mut self, trials: u64, measured: impl Fn(Range<u64>) -> R) {
        let row = measured(0..trials);
        if row.misses() {
            self.again.push(measured(trials..(1 + MORE) * trials));
        }
        self.rows.push(row);
    }

    /// The section about the cells that miss; `demand` says of the cells what they fall short of, and ends with a subject
    /// for what was measured again.
    pub(super) fn misses(&self, demand: &str, trials: &str, table: impl Fn(&[&R]) -> String) -> String {
        let (missing, by_chance): (Vec<&R>, Vec<&R>) = self.again.iter().partition(|row| row.misses());
        format!(
            "\n## Cells that miss\n\n{} of {} cells {demand} were measured again on {MORE} times as many other {trials}, \
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

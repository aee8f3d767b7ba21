//! Rows of a text as columns of numbers.

use crate::tables::table::{Irregularity, Reason};

/// Successive rows.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Part {
    /// The requested columns, NaN if a row has no number.
    pub(super) columns: Vec<Vec<f64>>,
    /// Lines that are not rows, and rows without a number.
    pub(super) irregularities: Vec<Irregularity>,
    /// Number of lines, rows or not.
    pub(super) lines: u64,
}

impl Part {
    pub(super) fn push(&mut self, values: &[f64]) {
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
        self.lines += 1;
    }

    pub(super) fn note(&mut self, reason: Reason) {
        let row = self.columns.first().map_or(0, Vec::len);
        self.irregularities.push(Irregularity { row, reason });
    }
}

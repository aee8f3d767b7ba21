//! Rows that have a number in every column needed.

use crate::{
    report::Skipped,
    tables::table::{LeftOut, Reason},
};

/// The rows of a table that have a number in all columns `needed`; the others are added to
/// `skipped`. The first row of the table has the number `first_row`.
pub(crate) fn complete(
    values: &[Vec<f64>],
    needed: &[usize],
    first_row: u64,
    skipped: &mut Vec<Skipped>,
) -> Vec<usize> {
    let mut left_out = LeftOut::default();
    let rows = values.first().map_or(0, Vec::len);
    let is_complete = |row: &usize| match needed.iter().find(|c| !values[**c][*row].is_finite()) {
        None => true,
        Some(column) => {
            left_out.count(&Reason::NoValue(column + 1), first_row + *row as u64);
            false
        }
    };
    let kept = (0..rows).filter(is_complete).collect();
    skipped.extend(left_out.skipped());
    kept
}

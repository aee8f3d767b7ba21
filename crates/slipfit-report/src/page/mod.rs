//! A report to hand in: one account of an analysis, written as a page or as tables.

mod formula;
mod html;
mod latex;
mod markdown;
mod method;
mod symbol;
mod view;

pub use html::html;
pub use latex::{escaped as latex_escaped, latex};
pub use markdown::{cell as markdown_cell, markdown};
pub use view::{levels, resonance, ringdown, series};

use crate::Provenance;
use crate::plot::Picture;
use crate::terminal::{Facts, Told};
use method::Step;

/// Everything a report says, in no format yet.
pub struct Document<'a> {
    pub(crate) provenance: &'a Provenance,
    /// The command, `ringdown`.
    pub(crate) command: &'static str,
    /// What was measured: the file's name, or the title of a series.
    pub(crate) subject: String,
    pub(crate) sentence: String,
    pub(crate) parameters: Vec<Told>,
    pub(crate) tables: Vec<Table>,
    pub(crate) facts: Facts,
    pub(crate) warnings: Vec<Doubt>,
    pub(crate) method: Vec<Step>,
    pub(crate) inputs: Vec<Input>,
    /// Drawn only where they are shown.
    pub(crate) pictures: Box<dyn Fn() -> Vec<Picture> + 'a>,
}

/// A warning with its code.
pub(crate) struct Doubt {
    pub(crate) code: &'static str,
    pub(crate) text: String,
}

/// A file, and what tells it from every other.
pub(crate) struct Input {
    pub(crate) path: String,
    pub(crate) sha256: String,
}

/// A table: the first row are its headings, columns without any content are left out.
pub(crate) struct Table {
    pub(crate) title: &'static str,
    pub(crate) rows: Vec<Vec<String>>,
    /// The row reported, counted without the headings.
    pub(crate) chosen: Option<usize>,
    /// Below it; may be empty.
    pub(crate) note: String,
}

impl Table {
    pub(crate) fn new(title: &'static str, rows: Vec<Vec<String>>) -> Self {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let filled: Vec<usize> =
            (0..columns).filter(|&c| rows.iter().any(|r| r.get(c).is_some_and(|s| !s.is_empty()))).collect();
        let kept =
            |row: &Vec<String>| filled.iter().map(|&c| row.get(c).cloned().unwrap_or_default()).collect();
        Self { title, rows: rows.iter().map(kept).collect(), chosen: None, note: String::new() }
    }

    /// Headings and the rows below them.
    fn split(&self) -> (&[String], &[Vec<String>]) {
        match self.rows.split_first() {
            Some((head, rows)) => (head, rows),
            None => (&[], &[]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_say_nothing_are_left_out() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let table = Table::new("t", vec![row(["a", "", "c"]), row(["1", "", "2"])]);
        assert_eq!(table.rows, [["a", "c"], ["1", "2"]]);
    }
}

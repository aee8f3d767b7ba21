//! A report to hand in: one account of an analysis, written as a page or as tables.

mod formula;
mod html;
mod latex;
mod markdown;
mod method;
mod symbol;
mod view;

pub(crate) use html::html;
pub(crate) use latex::{escaped as latex_escaped, latex};
pub(crate) use markdown::{cell as markdown_cell, markdown};
pub(crate) use view::{levels, resonance, ringdown, series};

use crate::plot::Picture;
use crate::report::{Facts, Told};
use method::Step;

/// Everything a report says, in no format yet.
pub(crate) struct Document<'a> {
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

/// The command line that was typed, as a shell takes it.
pub(crate) fn command_line() -> String {
    quoted(arguments())
}

/// The words typed behind the program's name; what is no text is replaced by signs.
pub(crate) fn arguments() -> impl Iterator<Item = String> {
    std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned())
}

fn quoted(words: impl Iterator<Item = String>) -> String {
    let mut line = "slipfit".to_owned();
    for word in words {
        line.push(' ');
        // A word with a zero byte cannot have been typed.
        line.push_str(&shlex::try_quote(&word).unwrap_or_default());
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_would_take_the_command_line_apart_again() {
        let typed = ["ringdown", "it's a \"swing\" & more.csv", "--stiffness", "12000±300", "$HOME", "-"];
        let line = quoted(typed.iter().map(|word| (*word).to_owned()));
        let back = shlex::split(&line).unwrap();
        assert_eq!(back[0], "slipfit");
        assert_eq!(back[1..], typed);
        assert!(!line.contains(" $HOME"), "{line}");
    }

    #[test]
    fn columns_that_say_nothing_are_left_out() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let table = Table::new("t", vec![row(["a", "", "c"]), row(["1", "", "2"])]);
        assert_eq!(table.rows, [["a", "c"], ["1", "2"]]);
    }
}

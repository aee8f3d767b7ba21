//! Settings in columns beside the first rows, as written by Tektronix oscilloscopes:
//! `Record Length,2.500000e+03,,-0.5000,0.02,` above `,,,-0.4996,0.04,`.

use std::ops::Range;

use super::{
    dialect,
    layout::{Layout, text},
    number,
};
use crate::{
    columns::{name::Name, named},
    report::{Delimiter, Note},
};

/// Minimum number of rows with settings beside them.
const FEWEST: usize = 3;
/// Number of following rows with which their times are compared.
const COMPARED: usize = 20;

/// The settings and their position.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Settings {
    /// Number of columns of settings, to the left of those of samples.
    columns: usize,
    delimiter: Delimiter,
    /// Number of lines of samples that have settings.
    rows: usize,
    values: Vec<(String, String)>,
    names: Vec<Name>,
}

impl Settings {
    /// Settings of a table whose first columns are empty, below lines that are the same rows with words in those
    /// columns.
    pub(super) fn find(lines: &[&[u8]], layout: &Layout) -> Option<Self> {
        let shape = layout.shape;
        let separator = char::from(dialect::separator(shape.delimiter)?);
        let cells = |line: &[u8]| -> Vec<Vec<u8>> {
            dialect::cells(line, shape.delimiter).iter().map(|cell| number::trim(cell).to_vec()).collect()
        };
        let first = cells(lines.get(layout.first_line)?);
        if layout.first_line < FEWEST || first.len() < 3 || !first[..2].iter().all(Vec::is_empty) {
            return None;
        }
        let rows: Vec<Vec<Vec<u8>>> = lines[layout.first_line..]
            .iter()
            .map(|line| cells(line))
            .filter(|row| row.len() == shape.width)
            .collect();
        let filled = |row: &Vec<Vec<u8>>| row.iter().position(|cell| !cell.is_empty());
        let columns = rows.iter().filter_map(filled).min()?;
        if columns < 2 {
            return None;
        }
        let numbers = |row: &[Vec<u8>]| -> Option<Vec<f64>> {
            let cells = row.get(columns..)?.iter().filter(|cell| !cell.is_empty());
            cells.map(|cell| number::number(cell, shape.decimal)).collect()
        };
        let usual = numbers(rows.first()?)?.len();
        let above: Vec<Vec<Vec<u8>>> = lines[..layout.first_line]
            .iter()
            .rev()
            .map(|line| cells(line))
            .take_while(|row| row.len() == shape.width && numbers(row).is_some_and(|n| n.len() == usual))
            .collect();
        // The times beside the settings and below them must be nearly evenly spaced.
        let times: Vec<f64> = above
            .iter()
            .rev()
            .chain(rows.iter().take(COMPARED))
            .filter_map(|row| Some(*numbers(row)?.first()?))
            .collect();
        let steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
        let range =
            |steps: &[f64]| steps.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(*s), h.max(*s)));
        let (least, most) = range(&steps);
        if above.len() < FEWEST || !(least > 0.0 && most < 2.0 * least) {
            return None;
        }
        let said: Range<usize> = layout.first_line - above.len()..layout.first_line;
        let settings = lines[said].iter().map(|line| {
            let cells = dialect::cells(line, shape.delimiter);
            let cells: Vec<_> = cells[..columns]
                .iter()
                .map(|cell| text(number::trim(cell)))
                .filter(|c| !c.is_empty())
                .collect();
            cells.join(&separator.to_string())
        });
        let settings: Vec<String> = settings.collect();
        let names = names(&settings, separator, columns, shape.width);
        let values = named::values(settings.into_iter());
        Some(Self { columns, delimiter: shape.delimiter, rows: above.len(), values, names })
    }

    /// A line without the cells of the settings.
    pub(super) fn line(&self, line: &[u8], out: &mut Vec<u8>) {
        let separator = dialect::separator(self.delimiter).unwrap_or(b',');
        let cells = dialect::cells(line, self.delimiter);
        if cells.len() <= self.columns {
            return out.extend_from_slice(line);
        }
        for (i, cell) in cells.into_iter().enumerate() {
            if i > 0 {
                out.push(separator);
            }
            if i >= self.columns {
                out.extend_from_slice(cell);
            }
        }
    }

    /// Names stated in the settings: `Horizontal Units,s`.
    pub(super) fn names(&self) -> Vec<Name> {
        self.names.clone()
    }

    pub(super) fn values(&self) -> &[(String, String)] {
        &self.values
    }

    pub(super) fn note(&self) -> Note {
        let Self { columns, rows, .. } = self;
        Note::new(format!(
            "columns 1 to {columns} hold settings next to the first {rows} rows, which were read as \
             samples too"
        ))
    }
}

/// Names of the columns from the units and the source in the settings; empty if no unit is stated.
fn names(settings: &[String], separator: char, columns: usize, width: usize) -> Vec<Name> {
    let value = |wanted: &str| {
        let pairs = settings.iter().filter_map(|line| line.split_once(separator));
        pairs
            .into_iter()
            .find(|(key, _)| key.trim().eq_ignore_ascii_case(wanted))
            .map(|(_, value)| value.trim().to_owned())
    };
    let (over, of) = (value("Horizontal Units"), value("Vertical Units"));
    if over.is_none() && of.is_none() {
        return Vec::new();
    }
    let with_unit = |name: &str, unit: Option<String>| {
        Name::parse(&unit.map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})")))
    };
    let mut names = vec![Name::default(); width];
    let in_frequency = over.as_deref() == Some("Hz");
    names[columns] = with_unit(if in_frequency { "Frequency" } else { "Time" }, over);
    if let Some(name) = names.get_mut(columns + 1) {
        *name = with_unit(&value("Source").unwrap_or_default(), of);
    }
    names
}

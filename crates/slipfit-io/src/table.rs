//! Tables of named columns, whatever the format.

use crate::{
    Format, ReadProblem,
    columns::{
        Head,
        names::{Name, Role},
    },
    report::{Dialect, Skipped},
};

/// Rows handed on at once.
pub(crate) const BATCH: usize = 8192;

/// All tables of a file, every column of them.
///
/// This is what a sheet, a variable, a group or a text holds before anybody
/// has decided which column is what.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Tables {
    /// The file, as named by the caller.
    pub path: String,
    /// Its format.
    pub format: Format,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Its length in bytes.
    pub bytes: u64,
    /// How the text is written; `None` of other formats.
    pub dialect: Option<Dialect>,
    /// The tables in the order of the file, at least one.
    pub tables: Vec<Table>,
}

/// A table: columns of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Table {
    /// Sheet, variable, group or track; empty where the file has one table only.
    pub name: String,
    /// The columns in the order of the file.
    pub columns: Vec<Column>,
    /// Samples per second (Hz), where the format itself states it.
    pub rate_hz: Option<f64>,
    /// Values named beside the table, such as a centre frequency, as written.
    pub named_values: Vec<(String, String)>,
    /// Rows that gave no number in any column, by reason.
    pub skipped: Vec<Skipped>,
    /// Whether rows were left unread because enough had been seen.
    pub cut: bool,
    /// Whatever else a reader of the numbers should know, one sentence each.
    pub notes: Vec<String>,
}

/// A column of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Column {
    /// Its header as written; empty without one.
    pub header: String,
    /// Its unit as written; empty if none is known.
    pub unit: String,
    /// One value a row; NaN where the cell holds no number.
    pub values: Vec<f64>,
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// Whether a column is a frequency or a period of a drive: the table is a
    /// sweep rather than a record in time.
    #[must_use]
    pub fn is_sweep(&self) -> bool {
        self.columns.iter().any(|c| {
            let name = Name::parse(&c.header);
            let word = name.bare.to_lowercase();
            let frequency = ["hz", "khz", "mhz", "ghz"].contains(&name.unit.to_lowercase().as_str())
                || ["f", "freq", "omega", "ω"].contains(&word.as_str())
                || ["frequen", "frecuen"].iter().any(|w| word.starts_with(w));
            frequency && c.values.windows(2).any(|w| w[0] != w[1])
        }) && !self.columns.iter().any(|c| Name::parse(&c.header).role() == Role::Time)
    }
}

/// Takes columns, some rows at a time; answers whether it wants more.
pub(crate) type Sink<'a> = &'a mut dyn FnMut(&[&[f64]]) -> bool;

/// What every format is read through: tables that are described first and
/// handed on column by column.
pub(crate) trait TableSource {
    /// The tables in the order of the file.
    fn heads(&self) -> &[Head];

    /// Hands the columns `wanted` of a table to `sink`, some rows at a time,
    /// NaN where a row has no number, until it answers `false`. Returns the
    /// rows that could not be handed on.
    fn scan(&mut self, table: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem>;

    /// Whether its tables are unlike each other, so that the first is no
    /// better guess than any other: variables, not sheets or runs.
    fn must_choose(&self) -> bool {
        false
    }

    /// Whether it holds less than the file because enough had been seen.
    fn cut(&self) -> bool {
        false
    }

    /// How it is written, if it is text.
    fn dialect(&self) -> Option<Dialect> {
        None
    }
}

/// Tables that are held as a whole, as small formats are.
#[derive(Debug, Default)]
pub(crate) struct HeldTables {
    heads: Vec<Head>,
    columns: Vec<Vec<Vec<f64>>>,
    skipped: Vec<Vec<Skipped>>,
    pub(crate) must_choose: bool,
    pub(crate) dialect: Option<Dialect>,
    /// Whether rows were left unread because enough had been seen.
    pub(crate) cut: bool,
}

impl HeldTables {
    /// Adds a table; its columns may end one before the other.
    pub(crate) fn push(&mut self, head: Head, mut columns: Vec<Vec<f64>>, skipped: Vec<Skipped>) {
        let rows = columns.iter().map(Vec::len).max().unwrap_or(0);
        columns.iter_mut().for_each(|c| c.resize(rows, f64::NAN));
        self.heads.push(head);
        self.columns.push(columns);
        self.skipped.push(skipped);
    }

    /// Says something of every table.
    pub(crate) fn note_all(&mut self, notes: &[String]) {
        self.heads.iter_mut().for_each(|h| h.notes.extend_from_slice(notes));
    }

    /// Adds values named beside every table.
    pub(crate) fn name_all(&mut self, named: &[(String, String)]) {
        self.heads.iter_mut().for_each(|h| h.named_values.extend_from_slice(named));
    }

    /// Takes over the tables of another, under a name.
    pub(crate) fn absorb(&mut self, other: Self, name: &str) {
        for ((mut head, columns), skipped) in other.heads.into_iter().zip(other.columns).zip(other.skipped) {
            name.clone_into(&mut head.name);
            self.push(head, columns, skipped);
        }
        self.cut |= other.cut;
        self.dialect = self.dialect.take().or(other.dialect);
    }

    /// Changes every time that is in seconds.
    pub(crate) fn map_times(&mut self, change: impl Fn(f64) -> f64) {
        for (head, columns) in self.heads.iter().zip(&mut self.columns) {
            for (name, column) in head.names.iter().zip(columns) {
                if name.role() == Role::Time && name.unit == "s" {
                    column.iter_mut().for_each(|v| *v = change(*v));
                }
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }
}

impl TableSource for HeldTables {
    fn heads(&self) -> &[Head] {
        &self.heads
    }

    fn scan(&mut self, table: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        let columns: Vec<&[f64]> = wanted.iter().map(|&c| &self.columns[table][c][..]).collect();
        let rows = columns.first().map_or(0, |c| c.len());
        for from in (0..rows).step_by(BATCH) {
            let to = rows.min(from + BATCH);
            let batch: Vec<&[f64]> = columns.iter().map(|c| &c[from..to]).collect();
            if !sink(&batch) {
                break;
            }
        }
        Ok(self.skipped[table].clone())
    }

    fn must_choose(&self) -> bool {
        self.must_choose
    }

    fn cut(&self) -> bool {
        self.cut
    }

    fn dialect(&self) -> Option<Dialect> {
        self.dialect.clone()
    }
}

/// All columns of one table, of its first `most_rows` rows.
pub(crate) fn gather(
    source: &mut dyn TableSource,
    table: usize,
    most_rows: usize,
) -> Result<Table, ReadProblem> {
    let head = source.heads()[table].clone();
    let wanted: Vec<usize> = (0..head.names.len()).collect();
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
    let (mut rows, mut cut) = (0, false);
    let skipped = source.scan(table, &wanted, &mut |batch| {
        let given = batch.first().map_or(0, |c| c.len());
        let taken = given.min(most_rows - rows);
        for (held, new) in values.iter_mut().zip(batch) {
            held.extend_from_slice(&new[..taken]);
        }
        rows += taken;
        cut = taken < given;
        !cut
    })?;
    let columns = head
        .names
        .into_iter()
        .zip(values)
        .map(|(name, values)| Column { header: name.header, unit: name.unit, values })
        .collect();
    Ok(Table {
        name: head.name,
        columns,
        rate_hz: head.rate_hz,
        named_values: head.named_values,
        skipped,
        cut: cut || source.cut(),
        notes: head.notes,
    })
}

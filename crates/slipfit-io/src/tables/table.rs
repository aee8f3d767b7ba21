//! Tables of named columns, independent of the format.

use crate::{
    columns::{head::Head, name::Name, role::Role},
    error::ReadProblem,
    format::Format,
    report::{Dialect, Note, Skipped},
};

/// Number of rows passed on at once.
pub(crate) const BATCH: usize = 8192;

/// All tables of a file, every column of them.
///
/// Content of a sheet, a variable, a group or a text before the columns are assigned roles.
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
    /// How the text is written; `None` for other formats.
    pub dialect: Option<Dialect>,
    /// The tables in the order of the file, at least one.
    pub tables: Vec<Table>,
}

/// A table: columns of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Table {
    /// Sheet, variable, group or track; empty if the file has only one table.
    pub name: String,
    /// The columns in the order of the file.
    pub columns: Vec<Column>,
    /// Samples per second (Hz), if the format itself states it.
    pub rate_hz: Option<f64>,
    /// Values named outside the table, such as a centre frequency, as written.
    pub named_values: Vec<(String, String)>,
    /// Rows that gave no number in any column, by reason.
    pub skipped: Vec<Skipped>,
    /// Whether rows were left unread because enough had been read.
    pub cut: bool,
    /// Further information for the user of the numbers.
    pub notes: Vec<Note>,
}

/// A column of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Column {
    /// Its header as written; empty if there is none.
    pub header: String,
    /// Its unit as written; empty if none is known.
    pub unit: String,
    /// One value per row; NaN if the cell holds no number.
    pub values: Vec<f64>,
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// Whether a column is a frequency or a period of a drive, so that the table is a sweep and not a record in time.
    #[must_use]
    pub fn is_sweep(&self) -> bool {
        self.columns.iter().any(|c| {
            let name = Name::parse(&c.header);
            let word = name.bare.to_lowercase();
            let frequency = ["hz", "khz", "mhz", "ghz"].contains(&name.unit.to_lowercase().as_str())
                || ["f", "freq", "omega", "ω"].contains(&word.as_str())
                || ["frequen", "frecuen"].iter().any(|w| word.starts_with(w));
            frequency && c.values.windows(2).any(|w| w[0] != w[1])
        }) && !self.columns.iter().any(|c| Role::in_record(&Name::parse(&c.header)) == Role::Time)
    }
}

/// Some rows of the requested columns.
pub(crate) struct Batch<'a> {
    /// One slice per column, NaN if a row has no number.
    pub(crate) columns: &'a [&'a [f64]],
    /// Line number of the first row in the file, if rows are lines of it.
    pub(crate) line: Option<u64>,
    /// Lines that are not rows and rows without a number, in order; empty if rows are not lines.
    pub(crate) irregularities: &'a [Irregularity],
    /// Whether more rows have been read already.
    pub(crate) more: bool,
}

impl<'a> Batch<'a> {
    /// Rows that are not lines of a text.
    pub(crate) fn of(columns: &'a [&'a [f64]]) -> Self {
        Self { columns, line: None, irregularities: &[], more: false }
    }

    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.len())
    }
}

/// A line that is not a row, or a row with a missing number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Irregularity {
    /// The row of the batch, or the one after the line.
    pub(crate) row: usize,
    pub(crate) reason: Reason,
}

/// Why a row or a line gave no sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Reason {
    BlankLine,
    Remark,
    /// A header line of a block among the rows.
    BlockHeader,
    /// Number of the column, from 1.
    TooFewCells(usize),
    NoValue(usize),
    Text(usize, String),
    NoNumber,
    /// Names of other columns, with which another table begins.
    OtherHeader,
}

impl Reason {
    /// Whether this is a line without a row.
    pub(crate) fn is_no_row(&self) -> bool {
        matches!(self, Self::BlankLine | Self::Remark | Self::BlockHeader)
    }

    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Text(column, _), Self::Text(other, _)) => column == other,
            _ => self == other,
        }
    }

    pub(crate) fn text(&self) -> String {
        match self {
            Self::BlankLine => "blank line".to_owned(),
            Self::Remark => "remark".to_owned(),
            Self::BlockHeader => "line of a block's header".to_owned(),
            Self::TooFewCells(column) => format!("row ends before column {column}"),
            Self::NoValue(column) => format!("no value in column {column}"),
            Self::Text(column, example) => format!("`{example}` in column {column} is not a number"),
            Self::NoNumber => "no number in any column".to_owned(),
            Self::OtherHeader => "the header of another table and its rows".to_owned(),
        }
    }
}

/// Rows left out, counted by reason.
#[derive(Debug, Default)]
pub(crate) struct LeftOut(Vec<(Reason, u64, u64)>);

impl LeftOut {
    pub(crate) fn count(&mut self, reason: &Reason, row: u64) {
        match self.0.iter_mut().find(|(known, ..)| known.is_same(reason)) {
            Some((_, rows, _)) => *rows += 1,
            None => self.0.push((reason.clone(), 1, row)),
        }
    }

    /// In order of appearance.
    pub(crate) fn skipped(&self) -> Vec<Skipped> {
        let skipped = |(reason, rows, first_row): &(Reason, u64, u64)| Skipped {
            reason: reason.text(),
            rows: *rows,
            first_row: *first_row,
        };
        self.0.iter().map(skipped).collect()
    }
}

/// Receives successive rows; returns whether more are wanted.
pub(crate) type Sink<'a> = &'a mut dyn FnMut(Batch<'_>) -> bool;

/// Number of rows from which the roles of columns are determined.
const PREVIEW_ROWS: usize = 1 << 17;

/// Common interface of all formats: tables that are described first and then passed on column by column.
pub(crate) trait TableSource {
    /// The tables in the order of the file.
    fn heads(&self) -> Vec<&Head>;

    /// Passes the columns `wanted` of a table to `sink`, some rows at a time, with NaN if a row has no number, until
    /// `sink` returns `false`. Returns the rows that could not be passed on.
    fn scan(&mut self, table: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem>;

    /// The first rows of a source that cannot be read twice; the second attempt returns more of them.
    fn window(&mut self, _attempt: usize) -> Result<Option<LoadedTable>, ReadProblem> {
        Ok(None)
    }

    /// Maximum size of a preview.
    fn previewed(&self) -> String {
        previewed()
    }

    /// Number of rows of a table, as far as it is known before reading.
    fn rows_expected(&self) -> usize {
        0
    }

    /// Whether the tables differ in kind, so that the first is no better guess than any other: variables, not sheets or
    /// runs.
    fn must_choose(&self) -> bool {
        false
    }

    /// Whether rows of a table were left unread when the file was opened.
    fn is_cut(&self, _table: usize) -> bool {
        false
    }

    /// How a table is written, if it is text.
    fn dialect(&self, _table: usize) -> Option<Dialect> {
        None
    }
}

/// Maximum size of a preview by rows.
pub(crate) fn previewed() -> String {
    format!("{PREVIEW_ROWS} rows")
}

/// A table in memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct LoadedTable {
    pub(crate) head: Head,
    pub(crate) columns: Vec<Vec<f64>>,
    /// Rows that gave no number, by reason.
    pub(crate) skipped: Vec<Skipped>,
    /// Whether rows were left unread because enough had been read.
    pub(crate) cut: bool,
    /// How it is written, if it is text.
    pub(crate) dialect: Option<Dialect>,
}

impl LoadedTable {
    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

impl From<LoadedTable> for Table {
    fn from(table: LoadedTable) -> Self {
        let LoadedTable { head, columns, skipped, cut, .. } = table;
        let column = |(name, values): (Name, _)| Column { header: name.header, unit: name.unit, values };
        Self {
            name: head.name,
            columns: head.names.into_iter().zip(columns).map(column).collect(),
            rate_hz: head.rate_hz,
            named_values: head.named_values,
            skipped,
            cut,
            notes: head.notes,
        }
    }
}

/// Tables in memory, as used for small formats.
#[derive(Debug, Default)]
pub(crate) struct LoadedTables {
    tables: Vec<LoadedTable>,
    pub(crate) must_choose: bool,
}

impl LoadedTables {
    /// Adds a table; its columns may have different lengths.
    pub(crate) fn push(&mut self, head: Head, mut columns: Vec<Vec<f64>>, skipped: Vec<Skipped>) {
        let rows = columns.iter().map(Vec::len).max().unwrap_or(0);
        columns.iter_mut().for_each(|c| c.resize(rows, f64::NAN));
        self.tables.push(LoadedTable { head, columns, skipped, cut: false, dialect: None });
    }

    /// Adds notes to every table.
    pub(crate) fn note_all(&mut self, notes: &[String]) {
        let notes = || notes.iter().map(|note| Note::new(note.as_str()));
        self.tables.iter_mut().for_each(|t| t.head.notes.extend(notes()));
    }

    /// Adds values named outside the tables to every table.
    pub(crate) fn name_all(&mut self, named: &[(String, String)]) {
        self.tables.iter_mut().for_each(|t| t.head.named_values.extend_from_slice(named));
    }

    /// Adds the tables of a text under a name; if there are several, their own names are appended.
    pub(crate) fn absorb(&mut self, tables: Vec<LoadedTable>, name: &str) {
        let alone = tables.len() == 1;
        self.tables.extend(tables.into_iter().map(|mut table| {
            let own = std::mem::take(&mut table.head.name);
            table.head.name = if alone { name.to_owned() } else { format!("{name}/{own}") };
            table
        }));
    }

    /// Changes every time given in seconds.
    pub(crate) fn map_times(&mut self, change: impl Fn(f64) -> f64) {
        for LoadedTable { head, columns, .. } in &mut self.tables {
            for (name, column) in head.names.iter().zip(columns) {
                if Role::in_record(name) == Role::Time && name.unit == "s" {
                    column.iter_mut().for_each(|v| *v = change(*v));
                }
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.tables.is_empty()
    }
}

impl TableSource for LoadedTables {
    fn heads(&self) -> Vec<&Head> {
        self.tables.iter().map(|t| &t.head).collect()
    }

    fn scan(&mut self, table: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        let table = &self.tables[table];
        let columns: Vec<&[f64]> = wanted.iter().map(|&c| &table.columns[c][..]).collect();
        let rows = columns.first().map_or(0, |c| c.len());
        for from in (0..rows).step_by(BATCH) {
            let to = rows.min(from + BATCH);
            let batch: Vec<&[f64]> = columns.iter().map(|c| &c[from..to]).collect();
            if !sink(Batch::of(&batch)) {
                break;
            }
        }
        Ok(table.skipped.clone())
    }

    fn must_choose(&self) -> bool {
        self.must_choose
    }

    fn is_cut(&self, table: usize) -> bool {
        self.tables[table].cut
    }

    fn dialect(&self, table: usize) -> Option<Dialect> {
        self.tables.get(table)?.dialect.clone()
    }
}

/// The first rows of a table. A second attempt returns more of them, or `None` if there are no more.
pub(crate) fn preview(
    source: &mut dyn TableSource,
    table: usize,
    attempt: usize,
) -> Result<Option<LoadedTable>, ReadProblem> {
    match source.window(attempt)? {
        None if attempt == 0 => gather(source, table, PREVIEW_ROWS).map(Some),
        window => Ok(window),
    }
}

/// All columns of the first `most_rows` rows of a table; rows of a text without any number are left out and counted.
pub(crate) fn gather(
    source: &mut dyn TableSource,
    table: usize,
    most_rows: usize,
) -> Result<LoadedTable, ReadProblem> {
    let head = source.heads()[table].clone();
    let wanted = head.all();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
    let (mut rows, mut cut) = (0, false);
    let mut left_out = LeftOut::default();
    let mut skipped = source.scan(table, &wanted, &mut |batch| {
        let mut take = |from: usize, to: usize| {
            let to = to.min(from.saturating_add(most_rows - rows));
            for (column, new) in columns.iter_mut().zip(batch.columns) {
                column.extend_from_slice(&new[from..to]);
            }
            rows += to - from;
            to
        };
        let (mut row, mut lines) = (0, 0);
        for irregularity in batch.irregularities {
            let empty = !irregularity.reason.is_no_row()
                && batch.columns.iter().all(|c| c[irregularity.row].is_nan());
            if !empty && !irregularity.reason.is_no_row() {
                continue;
            }
            if take(row, irregularity.row) < irregularity.row {
                cut = true;
                return false;
            }
            let reason = if empty { &Reason::NoNumber } else { &irregularity.reason };
            left_out.count(reason, batch.line.unwrap_or(1) + (irregularity.row + lines) as u64);
            lines += usize::from(!empty);
            row = irregularity.row + usize::from(empty);
        }
        cut = take(row, batch.rows()) < batch.rows();
        !cut
    })?;
    skipped.extend(left_out.skipped());
    cut |= source.is_cut(table);
    let dialect = source.dialect(table);
    Ok(LoadedTable { head, columns, skipped, cut, dialect })
}

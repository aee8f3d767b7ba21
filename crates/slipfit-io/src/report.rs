//! What was read, how, and what was left out.

use slipfit::{Record, SignalKind};

use crate::Format;

/// A record and the account of how it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The samples. Its clock report counts what became of the stamps.
    pub record: Record,
    /// The account.
    pub report: ReadReport,
}

impl Reading {
    /// The frequency of the oscillation [Hz], where amplitudes alone were recorded and the lines
    /// above the table name it `frequency_hz`.
    pub fn named_frequency_hz(&self) -> Option<f64> {
        if !matches!(self.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
            return None;
        }
        named_number(&self.report.named_values, "frequency_hz")
    }
}

/// The positive number of this name.
pub(crate) fn named_number(values: &[(String, String)], wanted: &str) -> Option<f64> {
    let (_, value) = values.iter().find(|(name, _)| name == wanted)?;
    value.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0)
}

/// How a file was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadReport {
    /// The file, as named by the caller.
    pub path: String,
    /// Its format.
    pub format: Format,
    /// The sheet, variable, group or track read; empty where the file has one table only.
    pub sheet: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Its length in bytes.
    pub bytes: u64,
    /// Rows of the table read as samples. The record may hold fewer: see its
    /// clock report.
    pub rows_read: u64,
    /// Rows of the table that gave no sample, by reason, in order of
    /// appearance.
    pub skipped: Vec<Skipped>,
    /// How the text is written; `None` of other formats.
    pub dialect: Option<Dialect>,
    /// Where the times come from.
    pub time: TimeSource,
    /// The signal.
    pub signal: ColumnTaken,
    /// The quadrature output of a lock-in.
    pub quadrature: Option<ColumnTaken>,
    /// What the signal was taken to be.
    pub kind: SignalKind,
    /// All columns of the file, taken or not.
    pub columns: Vec<ColumnInfo>,
    /// Tables side by side in the file.
    pub tables: usize,
    /// The one read, from 1.
    pub table: usize,
    /// Runs in column groups of that table.
    pub runs: usize,
    /// The one read, from 1.
    pub run: usize,
    /// Values named in the lines before the table, such as a sampling rate, as written.
    pub named_values: Vec<(String, String)>,
    /// Whatever else a reader of the result should know, one sentence each.
    pub notes: Vec<String>,
}

impl ReadReport {
    /// Rows of the table that gave no sample.
    #[must_use]
    pub fn rows_skipped(&self) -> u64 {
        self.skipped.iter().map(|s| s.rows).sum()
    }
}

/// Rows left out for one reason.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Skipped {
    /// The reason, such as `no value in column 4`.
    pub reason: String,
    /// How many rows.
    pub rows: u64,
    /// Line of the file, from 1, where it first happened.
    pub first_row: u64,
}

/// How a text file is written.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Dialect {
    /// What stands between two cells.
    pub delimiter: Delimiter,
    /// What stands before the fraction of a number.
    pub decimal: Decimal,
    /// The program or instrument that wrote it, if that can be told.
    pub convention: Option<&'static str>,
    /// Name of the character encoding.
    pub encoding: &'static str,
    /// Line of the column names, from 1.
    pub header_row: Option<u64>,
    /// First line of numbers, from 1. Everything above it is preamble.
    pub first_data_row: u64,
}

/// What stands between two cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Delimiter {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// A tabulator.
    Tab,
    /// `|`
    Bar,
    /// One or more blanks or tabulators.
    Blanks,
    /// Nothing: each row is one cell.
    None,
}

/// What stands before the fraction of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Decimal {
    /// `.`
    Point,
    /// `,`
    Comma,
}

/// A column of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ColumnInfo {
    /// From 1.
    pub number: usize,
    /// Its header as written; empty without one.
    pub header: String,
    /// The unit in its header; empty without one.
    pub unit: String,
}

/// A column that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ColumnTaken {
    /// The column.
    pub column: ColumnInfo,
    /// Unit its numbers were taken to have; empty if unknown.
    pub unit: String,
    /// Why this column, in a sentence such as
    /// ``column 4 `Weg &b_A1 / rad`: named like a position``.
    pub why: String,
}

/// Where the times of the samples come from.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum TimeSource {
    /// A column of times.
    Column(ColumnTaken),
    /// A column of the times since the sample before.
    Intervals(ColumnTaken),
    /// A sampling rate (Hz).
    Rate(f64),
}

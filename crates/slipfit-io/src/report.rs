//! What was read, how, and what was left out.

use std::fmt;

use slipfit::{
    Record, SignalKind,
    answer::hint::{Hint, Spelling, spelled},
    levels::Levels,
    resonance::Curve,
    signal::demodulate::SteadyMotion,
};

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
    /// The frequency of the oscillation, Hz, where amplitudes alone were recorded and the lines
    /// above the table name it `frequency_hz`.
    pub fn named_frequency_hz(&self) -> Option<f64> {
        if !matches!(self.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
            return None;
        }
        self.report.named_number("frequency_hz")
    }
}

/// A resonance curve and the account of how it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SweepReading {
    /// The points, in the order of measurement.
    pub curve: Curve,
    /// The account.
    pub report: ReadReport,
}

/// Amplitudes over drive levels and the account of how they were read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LevelReading {
    /// The points, in the order of measurement.
    pub levels: Levels,
    /// The account.
    pub report: ReadReport,
}

/// How a file was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadReport {
    /// The file or the folder, as named by the caller.
    pub path: String,
    /// Its format; of several files that of the first.
    pub format: Format,
    /// SHA-256 of its bytes, in hexadecimal; of several files that of their fingerprints in a row.
    pub sha256: String,
    /// Its length in bytes; of several files that of the first.
    pub bytes: u64,
    /// The sheet, variable, group or track read; empty where the file has one table only.
    pub sheet: String,
    /// How the text is written; `None` of other formats.
    pub dialect: Option<Dialect>,
    /// All columns of the table, taken or not.
    pub columns: Vec<ColumnInfo>,
    /// Rows of the table read as samples or points. The record or curve may hold fewer.
    pub rows_read: u64,
    /// Rows of the table that gave none, by reason, in order of appearance.
    pub skipped: Vec<Skipped>,
    /// The columns read, with what they are: `signal`, `quadrature`, `frequency`, `amplitude`, …
    pub taken: Vec<(&'static str, ColumnTaken)>,
    /// Where the times of a record come from; `None` of a curve or of levels.
    pub time: Option<TimeSource>,
    /// What the signal was taken to be; a response before it was made a displacement.
    pub kind: SignalKind,
    /// Whether the name of a column says that this is a curve, or levels, not its numbers alone.
    pub named: bool,
    /// Tables side by side in the file.
    pub parts: usize,
    /// The one read, from 1.
    pub part: usize,
    /// Runs or curves in groups of columns, or runs one after the other.
    pub runs: usize,
    /// The one read, from 1.
    pub run: usize,
    /// Values named beside the table, such as a sampling rate, as written.
    pub named_values: Vec<(String, String)>,
    /// The driven records the points of a curve come from; empty where the file held the curve.
    pub records: Vec<DrivenRecord>,
    /// Files that could not be read as driven records; `notes` says why.
    pub files_left_out: usize,
    /// Whatever else a reader of the result should know.
    pub notes: Vec<Note>,
}

impl LevelReading {
    /// The frequency of the drive, Hz, where the lines above the table name it `drive_frequency_hz`,
    /// as simulated levels do.
    #[must_use]
    pub fn named_frequency_hz(&self) -> Option<f64> {
        self.report.named_number("drive_frequency_hz")
    }
}

impl ReadReport {
    /// The positive number of this name beside the table.
    fn named_number(&self, wanted: &str) -> Option<f64> {
        let (_, value) = self.named_values.iter().find(|(name, _)| name == wanted)?;
        value.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0)
    }

    /// Rows of the table that gave no sample or point.
    #[must_use]
    pub fn rows_skipped(&self) -> u64 {
        self.skipped.iter().map(|s| s.rows).sum()
    }

    /// The column read as `signal`, `quadrature`, `frequency`, `amplitude`, …
    #[must_use]
    pub fn column(&self, what: &str) -> Option<&ColumnTaken> {
        self.taken.iter().find(|(name, _)| *name == what).map(|(_, taken)| taken)
    }
}

/// A file of driven motion and what came of it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DrivenRecord {
    /// The file.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Samples read.
    pub samples: usize,
    /// The steady motion.
    pub steady: SteadyMotion,
}

/// A sentence about what was read, with the options that would change it.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The sentence.
    pub text: String,
    /// The options.
    pub hints: Vec<Hint>,
}

impl Note {
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), hints: Vec::new() }
    }

    /// The same with an option that would change what it says.
    pub(crate) fn hint(
        mut self,
        option: &'static str,
        advice: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Self {
        self.hints.push(Hint::new(option, advice));
        self
    }

    /// The sentence with its options as `spell` writes them.
    #[must_use]
    pub fn spelled(&self, spell: Spelling<'_>) -> String {
        let semicolon = if self.hints.is_empty() { "" } else { "; " };
        format!("{}{semicolon}{}", self.text, spelled(&self.hints, spell))
    }
}

impl From<&str> for Note {
    fn from(text: &str) -> Self {
        Self::new(text)
    }
}

impl From<String> for Note {
    fn from(text: String) -> Self {
        Self::new(text)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(&|option, _| option.to_owned()))
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

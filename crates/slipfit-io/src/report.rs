//! Reports on what was read, how it was read, and what was left out.

use std::fmt;

use slipfit::{
    Record, SignalKind,
    answer::hint::{Hint, Spelling, spelled},
    levels::Levels,
    resonance::Curve,
    signal::demodulate::SteadyMotion,
};

use crate::Format;

/// A record and the report on how it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The samples. The clock report of the record describes the treatment of the time stamps.
    pub record: Record,
    /// The report.
    pub report: ReadReport,
}

impl Reading {
    /// The frequency of the oscillation, Hz, if only amplitudes were recorded and the lines above the table give it as
    /// `frequency_hz`.
    pub fn named_frequency_hz(&self) -> Option<f64> {
        if !matches!(self.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
            return None;
        }
        self.report.named_number("frequency_hz")
    }
}

/// A resonance curve and the report on how it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SweepReading {
    /// The points, in the order of measurement.
    pub curve: Curve,
    /// The report.
    pub report: ReadReport,
}

/// Amplitudes over drive levels and the report on how they were read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LevelReading {
    /// The points, in the order of measurement.
    pub levels: Levels,
    /// The report.
    pub report: ReadReport,
}

/// How a file was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadReport {
    /// The file or the folder, as named by the caller.
    pub path: String,
    /// Its format; that of the first file if there are several.
    pub format: Format,
    /// SHA-256 of its bytes, in hexadecimal; for several files, that of their concatenated fingerprints.
    pub sha256: String,
    /// Its length in bytes; that of the first file if there are several.
    pub bytes: u64,
    /// The sheet, variable, group or track read; empty if the file has only one table.
    pub sheet: String,
    /// How the text is written; `None` for other formats.
    pub dialect: Option<Dialect>,
    /// All columns of the table, read or not.
    pub columns: Vec<ColumnInfo>,
    /// Rows of the table read as samples or points. The record or curve may hold fewer.
    pub rows_read: u64,
    /// Rows of the table that gave no sample or point, by reason, in order of appearance.
    pub skipped: Vec<Skipped>,
    /// The columns read, with their roles: `signal`, `quadrature`, `frequency`, `amplitude`, …
    pub taken: Vec<(&'static str, ColumnTaken)>,
    /// Source of the times of a record; `None` for a curve or levels.
    pub time: Option<TimeSource>,
    /// Kind assumed for the signal; for a response, before its conversion to a displacement.
    pub kind: SignalKind,
    /// Whether the name of a column, and not only its numbers, identifies the data as a curve or as levels.
    pub named: bool,
    /// Number of tables side by side in the file.
    pub parts: usize,
    /// The one read, from 1.
    pub part: usize,
    /// Number of runs or curves in groups of columns, or of runs that follow each other.
    pub runs: usize,
    /// The one read, from 1.
    pub run: usize,
    /// Values named outside the table, such as a sampling rate, as written.
    pub named_values: Vec<(String, String)>,
    /// The driven records from which the points of a curve were obtained; empty if the file contained the curve.
    pub records: Vec<DrivenRecord>,
    /// Number of files that could not be read as driven records; `notes` gives the reasons.
    pub files_left_out: usize,
    /// Further information for the user of the result.
    pub notes: Vec<Note>,
}

impl LevelReading {
    /// The frequency of the drive, Hz, if the lines above the table give it as `drive_frequency_hz`, as for simulated
    /// levels.
    #[must_use]
    pub fn named_frequency_hz(&self) -> Option<f64> {
        self.report.named_number("drive_frequency_hz")
    }
}

impl ReadReport {
    /// The positive number with this name given outside the table.
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

/// A file of driven motion and its steady motion.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DrivenRecord {
    /// The file.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Number of samples read.
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

    /// The same with an option that would change what the note describes.
    pub(crate) fn hint(
        mut self,
        option: &'static str,
        advice: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Self {
        self.hints.push(Hint::new(option, advice));
        self
    }

    /// The sentence with its options as written by `spell`.
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
    /// Number of rows.
    pub rows: u64,
    /// Line of the file, from 1, of the first such row.
    pub first_row: u64,
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { reason, rows, first_row } = self;
        if *rows == 1 {
            write!(f, "row {first_row} ({reason})")
        } else {
            write!(f, "{rows} rows ({reason}), the first in row {first_row}")
        }
    }
}

/// How a text file is written.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Dialect {
    /// Separator between cells.
    pub delimiter: Delimiter,
    /// Decimal mark.
    pub decimal: Decimal,
    /// The program or instrument that wrote it, if it is known.
    pub convention: Option<&'static str>,
    /// Name of the character encoding.
    pub encoding: &'static str,
    /// Line of the column names, from 1.
    pub header_row: Option<u64>,
    /// First line of numbers, from 1. All lines above it are preamble.
    pub first_data_row: u64,
}

/// Separator between the cells of a row.
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

/// Mark before the fraction of a number.
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
    /// Its header as written; empty if there is none.
    pub header: String,
    /// The unit in its header; empty if there is none.
    pub unit: String,
}

/// A column that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ColumnTaken {
    /// The column.
    pub column: ColumnInfo,
    /// Unit assumed for its numbers; empty if unknown.
    pub unit: String,
    /// Reason for choosing this column, in a sentence such as ``column 4 `Weg &b_A1 / rad`: named like a position``.
    pub why: String,
}

/// Source of the times of the samples.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum TimeSource {
    /// A time column.
    Column(ColumnTaken),
    /// A column of time steps since the previous sample.
    Intervals(ColumnTaken),
    /// A sampling rate (Hz).
    Rate(f64),
}

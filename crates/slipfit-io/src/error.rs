//! Why a file could not be read, and what would help.

use std::io;

use crate::{Format, SweepProblem};

/// A file that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{file}{}: {problem}", row_suffix(.problem))]
pub struct ReadError {
    /// The file, as named by the caller.
    pub file: String,
    /// What is wrong with it.
    #[source]
    pub problem: ReadProblem,
}

fn row_suffix(problem: &ReadProblem) -> String {
    problem.row().map(|row| format!(", row {row}")).unwrap_or_default()
}

impl ReadError {
    pub(crate) fn new(file: &str, problem: ReadProblem) -> Self {
        Self { file: file.to_owned(), problem }
    }

    /// What the person can do about it, if anything: a flag, mostly.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        self.problem.hint()
    }
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadProblem {
    /// The system refused.
    #[error("{0}")]
    Io(io::Error),
    /// Another program wrote to the file while it was read.
    #[error("the file changed while it was read")]
    Changed,
    /// No bytes, or nothing but blanks.
    #[error("the file is empty")]
    Empty,
    /// A format that is known by name only.
    #[error("this is {}, which is not read yet", .0.name())]
    Unsupported(Format),
    /// A file that breaks the rules of its format.
    #[error("this begins like {} but breaks its rules: {reason}", .format.name())]
    Broken {
        /// The format.
        format: Format,
        /// What is wrong.
        reason: String,
    },
    /// Bytes no text has.
    #[error("this is not text: byte {byte:#04x} at position {position}")]
    Binary {
        /// The first such byte.
        byte: u8,
        /// Its position, from 0.
        position: usize,
    },
    /// A line too long for any table.
    #[error("a line of more than {limit} bytes: this is not a table")]
    LineTooLong {
        /// Line number, from 1.
        row: u64,
        /// The longest that is read.
        limit: usize,
    },
    /// Text without numbers in rows.
    #[error("no table of numbers {}; the first line reads `{first}`", looked_through(*.lines))]
    NoTable {
        /// Lines looked at.
        lines: usize,
        /// Beginning of the first of them.
        first: String,
    },
    /// No column of times and no rate.
    #[error("no column of times among {columns}")]
    NoTime {
        /// The columns there are.
        columns: String,
        /// A rate (Hz) the preamble names.
        rate_hz: Option<f64>,
    },
    /// Nothing left to be the signal.
    #[error("no column could be the signal among {columns}")]
    NoSignal {
        /// The columns there are.
        columns: String,
    },
    /// The column asked for does not exist.
    #[error("{flag} {wanted}: no such column; there are {columns}")]
    UnknownColumn {
        /// The flag it was asked for with.
        flag: &'static str,
        /// The column asked for.
        wanted: String,
        /// The columns there are.
        columns: String,
    },
    /// Several columns fit what was asked for.
    #[error("{flag} {wanted} could be {candidates}")]
    AmbiguousColumn {
        /// The flag it was asked for with.
        flag: &'static str,
        /// The column asked for.
        wanted: String,
        /// The columns that fit.
        candidates: String,
    },
    /// The table or run asked for does not exist.
    #[error("{flag} {wanted}: the file has {found}")]
    UnknownGroup {
        /// `--part` or `--run`.
        flag: &'static str,
        /// The one asked for.
        wanted: usize,
        /// How many there are.
        found: usize,
    },
    /// The sheet, variable or group asked for does not exist, or several fit.
    #[error("--sheet {wanted}: no such table, or several; there are {tables}")]
    UnknownTable {
        /// The one asked for.
        wanted: String,
        /// Those there are.
        tables: String,
    },
    /// Several tables could be meant and none was named.
    #[error("several tables could be read: {tables}")]
    SeveralTables {
        /// Those that could be read, with their columns.
        tables: String,
    },
    /// None of several tables holds what is needed.
    #[error("none of the tables holds a record: {tables}; of the first: {reason}")]
    NoTableFits {
        /// The tables, with their columns.
        tables: String,
        /// What is wrong with the first.
        reason: String,
    },
    /// A unit that is not known for times.
    #[error("`{unit}` is no unit of time known here")]
    UnknownTimeUnit {
        /// The unit given.
        unit: String,
    },
    /// Times in ticks of a clock whose rate the file does not name.
    #[error("{column} counts ticks of the instrument's clock, whose rate the file does not name")]
    NoTickRate {
        /// The time column.
        column: String,
    },
    /// Two options that exclude each other.
    #[error("{0} and {1} exclude each other")]
    Conflict(&'static str, &'static str),
    /// Time runs backwards.
    #[error("{column}: time goes backwards ({previous} s, then {next} s)")]
    TimeBackwards {
        /// Line of the file, from 1.
        row: u64,
        /// The time column.
        column: String,
        /// Time before (s).
        previous: f64,
        /// Time on that line (s).
        next: f64,
    },
    /// Too few rows could be read.
    #[error("{column}: usable rows {read}, needed at least {needed}{skipped}")]
    TooFewRows {
        /// Rows with a sample.
        read: usize,
        /// The least that would do.
        needed: usize,
        /// The signal column.
        column: String,
        /// Rows left out, by reason; empty if none.
        skipped: String,
    },
    /// The signal never changes.
    #[error("{column} is constant ({value}): nothing oscillates")]
    ConstantSignal {
        /// The signal column.
        column: String,
        /// Its one value.
        value: f64,
    },
    /// The record could not be made.
    #[error("{0}")]
    Record(slipfit::Error),
    /// A file that should hold a resonance curve does not.
    #[error("{0}")]
    Sweep(SweepProblem),
}

impl ReadProblem {
    /// The line of the file it is about, from 1.
    #[must_use]
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::LineTooLong { row, .. } | Self::TimeBackwards { row, .. } => Some(*row),
            Self::Sweep(problem) => problem.row(),
            _ => None,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Sweep(problem) => return problem.hint(),
            Self::Unsupported(_) | Self::Binary { .. } | Self::LineTooLong { .. } => {
                "export the data as text: one row per sample, columns for time and signal".to_owned()
            }
            Self::Changed => "read it again once it is complete, or read a copy".to_owned(),
            Self::NoTime { rate_hz: Some(rate), .. } => {
                format!(
                    "--rate-hz {rate} takes the rate named in the file's first lines; --time names a column"
                )
            }
            Self::NoTime { rate_hz: None, .. } => {
                "--rate-hz RATE gives the samples per second; --time names a column".to_owned()
            }
            Self::NoSignal { .. } | Self::ConstantSignal { .. } | Self::TooFewRows { .. } => {
                "--signal names another column".to_owned()
            }
            Self::NoTable { .. } => {
                "the samples belong into rows of numbers, one row each, below a header or without one".to_owned()
            }
            Self::SeveralTables { .. } => "--sheet names the one to read".to_owned(),
            Self::NoTableFits { .. } => {
                "--sheet names a table, --signal and --time its columns, --rate-hz a rate".to_owned()
            }
            Self::AmbiguousColumn { .. } => "give the column's number".to_owned(),
            Self::NoTickRate { .. } => {
                "--time-unit takes the clock's rate: 60MHz for an MFLI, 210MHz for an HF2LI, 1.8GHz for a UHFLI"
                    .to_owned()
            }
            Self::UnknownTimeUnit { .. } => "--time-unit takes s, ms, us, ns, min, h or the rate of a clock such as 60MHz".to_owned(),
            Self::TimeBackwards { .. } | Self::Record(slipfit::Error::TimeStandsStill { .. }) => {
                "--time names another column, --rate-hz replaces it".to_owned()
            }
            Self::Record(slipfit::Error::Parameter { name: "rate_hz", .. }) => {
                "--rate-hz takes a positive number of samples per second".to_owned()
            }
            _ => return None,
        };
        Some(hint)
    }
}

fn looked_through(lines: usize) -> String {
    if lines == 1 { "in its only line".to_owned() } else { format!("in the first {lines} lines") }
}

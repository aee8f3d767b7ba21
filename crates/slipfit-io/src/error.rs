//! Reasons why a file could not be read, and hints on how to proceed.

use std::{fmt, io};

use slipfit::answer::hint::{Analysis, Hint, HintValue, Spelling};

use crate::Format;

/// A file that could not be read.
#[derive(Debug, thiserror::Error)]
pub struct ReadError {
    /// The file, as named by the caller.
    pub file: String,
    /// What is wrong with it.
    #[source]
    pub problem: ReadProblem,
}

impl ReadError {
    pub(crate) fn new(file: &str, problem: ReadProblem) -> Self {
        Self { file: file.to_owned(), problem }
    }

    /// What the user can do about it, if anything; in most cases this is an option.
    #[must_use]
    pub fn hints(&self) -> Vec<Hint> {
        self.problem.hints()
    }

    /// The message, with the option it concerns as written by `spell`.
    #[must_use]
    pub fn spelled(&self, spell: Spelling<'_>) -> String {
        let row = self.problem.row().map(|row| format!(", row {row}")).unwrap_or_default();
        format!("{}{row}: {}", self.file, self.problem.spelled(spell))
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(&|option, value| match value {
            Some(value) => format!("{option} = {value}"),
            None => option.to_owned(),
        }))
    }
}

/// Problem with a file. Columns are given in the form used in messages.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadProblem {
    /// Error of the operating system.
    #[error("{0}")]
    Io(io::Error),
    /// Another program wrote to the file while it was read.
    #[error("the file changed while it was read")]
    Changed,
    /// No bytes, or only blanks.
    #[error("the file is empty")]
    Empty,
    /// A format that is recognised but not supported.
    #[error("this is {}, which is not read yet", .0.name())]
    Unsupported(Format),
    /// A file that violates the rules of its format.
    #[error("this cannot be read as {}: {reason}", .format.name())]
    Broken {
        /// The format.
        format: Format,
        /// What is wrong.
        reason: String,
    },
    /// A file that conforms to its format but contains nothing that can be read.
    #[error("this is {}, but no table in it can be read: {reason}", .format.name())]
    Without {
        /// The format.
        format: Format,
        /// What it contains instead.
        reason: String,
    },
    /// Bytes that do not occur in text.
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
        /// The longest line that is read.
        limit: usize,
    },
    /// Text without rows of numbers.
    #[error("no table of numbers {}; the first line reads `{first}`", looked_through(*.lines))]
    NoTable {
        /// Lines looked at.
        lines: usize,
        /// Beginning of the first of them.
        first: String,
    },
    /// Commas both as decimal marks and between cells, in rows that differ in length.
    #[error(
        "`{line}`: commas are both cell separators and decimal marks, for {columns} columns, and rows \
         differ in length: the two cannot be distinguished"
    )]
    DecimalCommas {
        /// Line of the file, from 1.
        row: u64,
        /// That line.
        line: String,
        /// Columns that the header names.
        columns: usize,
    },
    /// Several tables could be read and none was selected.
    #[error("several tables could be read: {tables}")]
    SeveralTables {
        /// Those that could be read, with their columns.
        tables: String,
    },
    /// None of several tables contains what is needed.
    #[error("none of the tables holds a record: {tables}; of the first: {first}")]
    NoTableFits {
        /// The tables, with their columns.
        tables: String,
        /// What is wrong with the first.
        first: Box<ReadProblem>,
    },
    /// An option that does not fit the file.
    #[error("{option} = {value}: {problem}")]
    Option {
        /// The field of [`crate::ReadOptions`].
        option: &'static str,
        /// Its value.
        value: String,
        /// What is wrong with it.
        problem: OptionProblem,
    },
    /// No time column and no sampling rate.
    #[error("no column of times; the file has {columns}")]
    NoTime {
        /// The available columns.
        columns: String,
        /// A rate (Hz) named in the preamble.
        rate_hz: Option<f64>,
    },
    /// Another column that is needed is missing.
    #[error("{}; the file has {columns}", .needed.missing())]
    NoColumn {
        /// What is needed.
        needed: Needed,
        /// The available columns.
        columns: String,
    },
    /// Times in ticks or samples of a clock whose rate is not given in the file.
    #[error("{column} counts ticks or samples, whose rate the file does not name")]
    NoTickRate {
        /// The time column.
        column: String,
    },
    /// Time runs backwards.
    #[error(
        "{column}: time goes backwards ({previous} s, then {next} s), {}", slipfit::error::out_of_order(*backward, *forward)
    )]
    TimeBackwards {
        /// Line of the file, from 1.
        row: u64,
        /// The time column.
        column: String,
        /// Time before (s).
        previous: f64,
        /// Time on that line (s).
        next: f64,
        /// Number of backward steps between rows.
        backward: usize,
        /// Number of forward steps.
        forward: usize,
    },
    /// Too few rows could be read.
    #[error("{column} has {}; at least {needed} are needed{skipped}", usable_rows(*.read))]
    TooFewRows {
        /// Rows with a sample.
        read: usize,
        /// The minimum number.
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
        /// Its constant value.
        value: f64,
    },
    /// A real part without an imaginary one, or the reverse.
    #[error("{given} is only half of a complex response: its {missing} part is missing among {columns}")]
    HalfComplex {
        /// The column that is present.
        given: String,
        /// `real` or `imaginary`.
        missing: &'static str,
        /// The available columns.
        columns: String,
    },
    /// Shifts from an unknown centre.
    #[error("{column} holds frequency shifts, and nothing says from which frequency they are counted")]
    NoCentre {
        /// The column of shifts.
        column: String,
    },
    /// Frequencies relative to a reference that is not given.
    #[error("{column} is a ratio of frequencies, and nothing says which frequency it refers to")]
    FrequencyRatio {
        /// The column of ratios.
        column: String,
    },
    /// Samples over time instead of a curve over frequency or amplitudes over drive levels.
    #[error("{column} holds times: this is a record of the motion, not {instead_of}")]
    TimeRecord {
        /// The column of times.
        column: String,
        /// What was expected.
        instead_of: &'static str,
    },
    /// A curve over frequency or amplitudes over drive levels instead of samples over time.
    #[error("{missing}, and {column} holds {holds}: this is {what}, not a record over time")]
    NotOverTime {
        /// Which column is missing, as text.
        missing: &'static str,
        /// The column of frequencies or drive levels.
        column: String,
        /// What it holds.
        holds: &'static str,
        /// What the file is.
        what: &'static str,
        /// The analysis that reads it.
        analysis: Analysis,
    },
    /// A frequency, a period or an amplitude below zero.
    #[error("{column}: {what} {value}{} is below zero", spaced(.unit))]
    Negative {
        /// `frequency`, `period` or `amplitude`.
        what: &'static str,
        /// Row of the table, from 1.
        row: u64,
        /// The column.
        column: String,
        /// The number.
        value: f64,
        /// Its unit.
        unit: String,
    },
    /// No sweep: all points have the same frequency.
    #[error("{column} is {value} {unit} in all of {points} points: a curve needs several frequencies")]
    OneFrequency {
        /// The column.
        column: String,
        /// Its constant value.
        value: f64,
        /// Its unit.
        unit: String,
        /// Number of points.
        points: usize,
    },
    /// A curve over frequency instead of amplitudes over drive levels.
    #[error(
        "{column} varies and the drive does not: this is a resonance curve, not amplitudes at {needed} levels \
         of the drive or more"
    )]
    OneLevel {
        /// The column of frequencies.
        column: String,
        /// The minimum number of levels.
        needed: usize,
    },
    /// No row contains all values needed for a point.
    #[error("no row has a number in {columns}{skipped}")]
    NoPoints {
        /// The columns read.
        columns: String,
        /// Rows left out, by reason; empty if none.
        skipped: String,
    },
    /// No array of three dimensions, or several of which none was selected.
    #[error("no stack of traces: {reason}")]
    NoStack {
        /// What was found instead.
        reason: String,
    },
    /// A folder without files.
    #[error("the folder contains no files")]
    NoFiles,
    /// None of the files, or of the files in a folder, is a driven record.
    #[error("none of {files} files could be read as a driven record; the first: {first}")]
    NoDrivenRecords {
        /// Number of files tried.
        files: usize,
        /// Why the first one could not be read.
        first: String,
    },
    /// The record, the curve or the levels could not be built from what was read.
    #[error("{0}")]
    Data(slipfit::Error),
}

impl Format {
    /// Problem for a file that violates the rules of this format.
    pub(crate) fn broken(self, reason: impl fmt::Display) -> ReadProblem {
        ReadProblem::Broken { format: self, reason: reason.to_string() }
    }
}

/// A column that is required.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Needed {
    /// The signal of a record.
    Signal,
    /// The second output of a lock-in.
    Quadrature,
    /// The frequencies of a curve.
    Frequency,
    /// The same in a table of amplitudes over drive levels.
    FrequencyOfLevels,
    /// The amplitudes of a curve.
    Amplitude,
    /// The amplitudes at drive levels.
    LevelAmplitude,
}

impl Needed {
    pub(crate) fn missing(self) -> &'static str {
        match self {
            Self::Signal => "no column could be the signal",
            Self::Quadrature => "no column could be the Y output of the lock-in",
            Self::Frequency | Self::FrequencyOfLevels => "no column of frequencies",
            Self::Amplitude | Self::LevelAmplitude => "no column could be the amplitude",
        }
    }
}

/// What is wrong with the value of an option.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionProblem {
    /// No column has this name.
    #[error("no such column; the columns are {0}")]
    NoSuchColumn(String),
    /// The names of several columns contain it.
    #[error("could be {0}")]
    SeveralColumns(String),
    /// No table, or several, with this name or number.
    #[error("not the name of exactly one table; the tables are {0}")]
    NoSuchTable(String),
    /// A table is named in a text that has only one.
    #[error("a text file has no sheets")]
    NoSheets,
    /// A table or run number greater than the number of tables side by side or of runs.
    #[error("the file has only {0}")]
    NumberTooLarge(usize),
    /// A unit that is not known for this column; holds the known units.
    #[error("not a known unit")]
    UnknownUnit(&'static str),
    /// An option that cannot be combined with another one.
    #[error("cannot be combined with {0}")]
    Excludes(&'static str),
    /// A kind of signals that a response cannot have.
    #[error("the response of a curve is a displacement, a velocity or an acceleration")]
    NotOfResponse,
    /// An option for samples over time, given for a curve.
    #[error("has no effect on a curve over frequency, which has no samples over time")]
    NotOfCurve,
    /// An option for a curve, given for driven records.
    #[error("has no effect on driven records, of which frequencies, amplitudes and phases are computed")]
    NotOfDrivenRecords,
    /// The column that another option names as well.
    #[error("{column} is also the {other}")]
    SameColumn {
        /// The column.
        column: String,
        /// What the other option names.
        other: &'static str,
    },
}

impl ReadProblem {
    /// The line of the file or row of the table concerned, from 1.
    #[must_use]
    pub fn row(&self) -> Option<u64> {
        match self {
            Self::LineTooLong { row, .. }
            | Self::DecimalCommas { row, .. }
            | Self::TimeBackwards { row, .. }
            | Self::Negative { row, .. } => Some(*row),
            _ => None,
        }
    }

    /// The message, with the option it concerns as written by `spell`.
    #[must_use]
    pub fn spelled(&self, spell: Spelling<'_>) -> String {
        match self {
            Self::Option { option, value, problem } => {
                format!("{}: {problem}", spell(option, Some(&HintValue::Text(value.clone()))))
            }
            Self::NoTableFits { tables, first } => {
                let first = first.spelled(spell);
                format!("none of the tables holds a record: {tables}; of the first: {first}")
            }
            other => other.to_string(),
        }
    }

    fn hints(&self) -> Vec<Hint> {
        match self {
            Self::Unsupported(format) => vec![Hint::advice(format.export())],
            Self::Binary { .. } | Self::LineTooLong { .. } => vec![Hint::advice(Format::Text.export())],
            Self::Changed => vec![Hint::advice("read it again once it is complete, or read a copy")],
            Self::NoTable { .. } => vec![Hint::advice(
                "write the samples as rows of numbers, one row per sample, with or without a header",
            )],
            Self::DecimalCommas { .. } => {
                vec![Hint::advice(
                    "export it again with decimal points, or with semicolons or tabs between the cells",
                )]
            }
            Self::SeveralTables { .. } => vec![Hint::new("sheet", "names the one to read")],
            Self::NoTableFits { .. } => vec![
                Hint::new("sheet", "names a table"),
                Hint::new("signal", "names its column of the signal"),
                Hint::new("time", "names its column of times"),
                Hint::new("rate_hz", "gives a rate"),
            ],
            Self::Option { problem: OptionProblem::SeveralColumns(_), .. } => {
                vec![Hint::advice("give the column's number")]
            }
            Self::Option { option, problem: OptionProblem::UnknownUnit(known), .. } => {
                vec![Hint::new(option, format!("takes {known}"))]
            }
            Self::Option { problem: OptionProblem::NoSheets, .. } => vec![
                Hint::new("part", "chooses one of several tables side by side"),
                Hint::new("run", "chooses one of several runs"),
            ],
            Self::Option { problem: OptionProblem::NotOfCurve, .. } => vec![Hint::advice(
                "leave it out; samples over time are read from several files or a folder, one record per frequency",
            )],
            Self::Option { problem: OptionProblem::NotOfDrivenRecords, .. } => {
                vec![Hint::advice("leave it out, or give the one file that contains the curve")]
            }
            Self::Option { option: "quadrature", problem: OptionProblem::SameColumn { .. }, .. } => {
                vec![Hint::new("quadrature", "names the Y output, which is not the column of the signal")]
            }
            Self::Option { problem: OptionProblem::SameColumn { .. }, .. } => {
                vec![Hint::advice("name different columns")]
            }
            Self::NoTime { rate_hz, .. } => vec![
                match rate_hz {
                    Some(rate) => {
                        Hint::new("rate_hz", "takes the rate named in the file's first lines").with(*rate)
                    }
                    None => Hint::new("rate_hz", "gives the samples per second").with("RATE"),
                },
                Hint::new("time", "names a column"),
            ],
            Self::NotOverTime { analysis, .. } => vec![
                Hint::analysis(*analysis, "reads it"),
                Hint::new("time", "names a column of times"),
                Hint::new("rate_hz", "gives the samples per second"),
            ],
            Self::NoColumn { needed: Needed::Frequency, .. } => vec![
                Hint::new("frequency", "names a column"),
                Hint::new("frequency_unit", "gives its unit (s or ms for periods)"),
            ],
            Self::NoColumn { needed: Needed::FrequencyOfLevels, .. } => vec![
                Hint::analysis(Analysis::Levels, "reads amplitudes over drive levels"),
                Hint::new("frequency", "names a column"),
                Hint::new("frequency_unit", "gives its unit (s or ms for periods)"),
            ],
            Self::NoColumn { needed: Needed::Amplitude, .. } | Self::NoPoints { .. } => vec![
                Hint::new("amplitude", "names a column"),
                Hint::new("real", "names a part of a complex response"),
                Hint::new("imaginary", "names a part of a complex response"),
            ],
            Self::NoColumn { needed: Needed::Signal, .. } => vec![Hint::new("signal", "names a column")],
            Self::NoColumn { needed: Needed::Quadrature, .. } => {
                vec![Hint::new("quadrature", "names the Y output")]
            }
            Self::ConstantSignal { .. } | Self::TooFewRows { .. } => {
                vec![Hint::new("signal", "names another column")]
            }
            Self::NoColumn { needed: Needed::LevelAmplitude, .. } | Self::OneLevel { .. } => levels_hints(),
            Self::TimeRecord { instead_of, .. } if instead_of.contains("levels") => levels_hints(),
            Self::NoTickRate { .. } => vec![Hint::new(
                "time_unit",
                "takes the clock's rate: 60MHz for an MFLI, 210MHz for an HF2LI, 1.8GHz for a UHFLI",
            )],
            Self::TimeBackwards { .. } | Self::Data(slipfit::Error::TimeStandsStill { .. }) => {
                vec![Hint::new("time", "names another column"), Hint::new("rate_hz", "replaces these times")]
            }
            Self::Data(slipfit::Error::Parameter { name: "rate_hz", .. }) => {
                vec![Hint::new("rate_hz", "takes a positive number of samples per second")]
            }
            Self::HalfComplex { .. } => vec![
                Hint::new("real", "names the other part"),
                Hint::new("imaginary", "names the other part"),
                Hint::new("amplitude", "names a column that stands alone"),
            ],
            Self::NoCentre { .. } => {
                vec![Hint::new("centre_hz", "gives the frequency the shifts are counted from")]
            }
            Self::FrequencyRatio { .. } => vec![
                Hint::new("frequency_unit", "says what 1 stands for, such as \"80.1 Hz\""),
                Hint::new("frequency", "names another column"),
            ],
            Self::TimeRecord { .. } => vec![
                Hint::analysis(Analysis::Ringdown, "reads a free decay"),
                Hint::advice("for driven runs give all their files, or their folder"),
                Hint::new("frequency", "names a column of frequencies"),
            ],
            Self::OneFrequency { .. } => vec![
                Hint::new("frequency", "names another column"),
                Hint::analysis(Analysis::Levels, "reads amplitudes at several levels of the drive"),
            ],
            Self::Negative { what: "frequency", .. } => vec![
                Hint::new("centre_hz", "gives the frequency that shifts are counted from"),
                Hint::new("frequency", "names another column"),
            ],
            Self::Negative { what: "period", .. } => vec![Hint::new("frequency", "names another column")],
            Self::Negative { .. } => vec![
                Hint::new("unit", "reads levels").with("dB"),
                Hint::new("real", "names a part of a complex response"),
                Hint::new("imaginary", "names a part of a complex response"),
                Hint::new("amplitude", "names another column"),
            ],
            Self::NoDrivenRecords { .. } => vec![
                Hint::advice("each file needs columns of time and response"),
                Hint::new("time", "names one of them"),
                Hint::new("amplitude", "names one of them"),
                Hint::new("drive", "names one of them"),
            ],
            _ => Vec::new(),
        }
    }
}

fn levels_hints() -> Vec<Hint> {
    vec![
        Hint::new("drive", "names a column"),
        Hint::new("amplitude", "names a column"),
        Hint::new("sheet", "names a table"),
        Hint::analysis(Analysis::Resonance, "reads a curve"),
        Hint::analysis(Analysis::Ringdown, "reads a free decay"),
    ]
}

fn looked_through(lines: usize) -> String {
    if lines == 1 { "in its only line".to_owned() } else { format!("in the first {lines} lines") }
}

fn usable_rows(rows: usize) -> String {
    match rows {
        0 => "no usable rows".to_owned(),
        1 => "only 1 usable row".to_owned(),
        _ => format!("only {rows} usable rows"),
    }
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

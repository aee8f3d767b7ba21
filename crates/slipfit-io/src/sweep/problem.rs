//! Why a resonance curve could not be read, and what would help.

/// What is wrong with a file that should hold a resonance curve.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepProblem {
    /// No column of frequencies.
    #[error("no column of frequencies among {columns}")]
    NoFrequency {
        /// The columns there are.
        columns: String,
    },
    /// Nothing left to be the response.
    #[error("no column could be the amplitude among {columns}")]
    NoResponse {
        /// The columns there are.
        columns: String,
    },
    /// A real part without an imaginary one, or the reverse.
    #[error("{given} is only half of a complex response: its {missing} part is missing among {columns}")]
    HalfComplex {
        /// The column there is.
        given: String,
        /// `real` or `imaginary`.
        missing: &'static str,
        /// The columns there are.
        columns: String,
    },
    /// Shifts from an unknown centre.
    #[error("{column} holds shifts, and nothing says from which frequency")]
    NoCentre {
        /// The column of shifts.
        column: String,
    },
    /// Samples over time instead of a curve over frequency.
    #[error("{column} holds times: this is a record of the motion, not a resonance curve")]
    TimeRecord {
        /// The column of times.
        column: String,
    },
    /// A frequency below zero.
    #[error("{column}: {what} {value} {unit} is below zero")]
    NegativeFrequency {
        /// `frequency` or `period`.
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
    /// No sweep: one frequency in all points.
    #[error("{column} is {value} {unit} in all of {points} points: a curve needs several frequencies")]
    OneFrequency {
        /// The column.
        column: String,
        /// Its one value.
        value: f64,
        /// Its unit.
        unit: String,
        /// Points.
        points: usize,
    },
    /// A table that should hold amplitudes over drive levels does not.
    #[error("{reason}")]
    NotLevels {
        /// What it holds instead.
        reason: String,
    },
    /// An amplitude below zero.
    #[error("{column}: amplitude {value} is below zero")]
    NegativeAmplitude {
        /// Row of the table, from 1.
        row: u64,
        /// The column.
        column: String,
        /// The number.
        value: f64,
    },
    /// A unit that is not known for this column.
    #[error("{flag} {unit}: no unit known here")]
    UnknownUnit {
        /// The flag.
        flag: &'static str,
        /// The unit given.
        unit: String,
        /// What would do.
        known: &'static str,
    },
    /// No row with everything a point needs.
    #[error("no row has a number in {columns}{skipped}")]
    NoPoints {
        /// The columns read.
        columns: String,
        /// Rows left out, by reason; empty if none.
        skipped: String,
    },
    /// A folder without files.
    #[error("the folder holds no files")]
    NoFiles,
    /// Files or a folder that hold no driven record at all.
    #[error("none of {files} files could be read as a driven record; the first: {first}")]
    NoRuns {
        /// How many were tried.
        files: usize,
        /// Why the first one could not.
        first: String,
    },
    /// The curve could not be made.
    #[error("{0}")]
    Curve(slipfit::Error),
}

impl SweepProblem {
    /// The row of the table it is about, from 1.
    pub(crate) fn row(&self) -> Option<u64> {
        match self {
            Self::NegativeFrequency { row, .. } | Self::NegativeAmplitude { row, .. } => Some(*row),
            _ => None,
        }
    }

    pub(crate) fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::NoFrequency { .. } => {
                "--frequency names a column, --frequency-unit its unit (s or ms of a period)"
            }
            Self::NoResponse { .. } | Self::NoPoints { .. } => {
                "--amplitude, or --real and --imaginary, name columns"
            }
            Self::HalfComplex { .. } => "--real and --imaginary name both, --amplitude one that stands alone",
            Self::NoCentre { .. } => "--centre-hz gives the frequency the shifts are counted from",
            Self::TimeRecord { .. } => {
                "slipfit ringdown reads a free decay; for driven runs give all their files, or their folder; \
                 --frequency names a column of frequencies"
            }
            Self::OneFrequency { .. } => {
                "--frequency names another column; slipfit levels reads amplitudes at several levels of the drive"
            }
            Self::NotLevels { .. } => {
                "--drive and --amplitude name columns, --sheet a table; slipfit resonance reads a curve, slipfit \
                 ringdown a free decay"
            }
            Self::NegativeFrequency { what: "period", .. } => "--frequency names another column",
            Self::NegativeFrequency { .. } => {
                "shifts from a centre need --centre-hz; --frequency names another column"
            }
            Self::NegativeAmplitude { .. } => {
                "--unit dB reads levels, --real and --imaginary the parts of a complex response, --amplitude \
                 another column"
            }
            Self::UnknownUnit { known, .. } => return Some((*known).to_owned()),
            Self::NoRuns { .. } => {
                "each file needs columns of time and response: --time, --amplitude and --drive name them"
            }
            Self::NoFiles | Self::Curve(_) => return None,
        };
        Some(hint.to_owned())
    }
}

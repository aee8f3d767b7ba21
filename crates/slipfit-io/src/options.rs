//! Options that override what a file suggests.

use slipfit::SignalKind;

use crate::Format;

/// How to read a file, for everything that it does not state itself. With the default everything is taken from the
/// file; each reader uses the fields that concern it.
///
/// A column is given by its number, from 1, or by its name: the whole header or the header without its unit, in upper
/// or lower case, or a part of it that occurs in no other header.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// The format, if the first bytes do not identify it or suggest another one; for a gzip file, the format of its
    /// content.
    pub format: Option<Format>,
    /// One of several sheets, variables, groups, data sets or tracks: its name, a part of the name that occurs in no
    /// other, or its number from 1.
    pub sheet: Option<String>,
    /// One of several tables side by side, from 1.
    pub part: Option<usize>,
    /// One of several runs, from 1. Runs are in groups of columns or, if there is one group, follow each other with a
    /// clock that restarts; of the latter the longest is read by default. Also one of several curves in groups of
    /// columns.
    pub run: Option<usize>,
    /// Time column.
    pub time: Option<String>,
    /// Unit of the times: `s`, `ms`, `us`, `ns`, `min`, `h`, or the rate of the clock whose ticks they count, such as
    /// `60MHz`.
    pub time_unit: Option<String>,
    /// Samples per second (Hz), instead of a time column.
    pub rate_hz: Option<f64>,
    /// Column of the signal of a record; for a lock-in, its in-phase output.
    pub signal: Option<String>,
    /// Column of the quadrature output of a lock-in.
    pub quadrature: Option<String>,
    /// Unit of the signal or of the amplitudes. `dB` and `dBm` are converted to linear values.
    pub unit: Option<String>,
    /// Kind of the signal or of the response. The response of a curve is divided by `i omega` once if it is a velocity,
    /// twice if it is an acceleration.
    pub kind: Option<SignalKind>,
    /// Maximum number of samples held, [`ReadOptions::MOST_SAMPLES`] by default: longer records with an even clock are
    /// averaged while they are read ([`slipfit::record::Averaging`]).
    pub most_samples: Option<usize>,
    /// Column of the frequencies of a curve, of their periods, or of frequency shifts.
    pub frequency: Option<String>,
    /// Unit of the frequencies: `Hz`, `kHz`, `MHz`, `rad/s`, `rpm`; `s` or `ms` for periods; `log10 Hz`, `log10 kHz`,
    /// `ln rad/s` for logarithms; or the reference frequency of a column of ratios, such as `80.1 Hz`.
    pub frequency_unit: Option<String>,
    /// Reference frequency (Hz) of the shifts.
    pub centre_hz: Option<f64>,
    /// Column of the amplitudes of a curve, or of the response in driven records.
    pub amplitude: Option<String>,
    /// Column of the phases.
    pub phase: Option<String>,
    /// Unit of the phases: `deg`, `rad`, `cycles`, or `pi` for multiples of pi.
    pub phase_unit: Option<String>,
    /// Column of the real part of the response, of a curve or at drive levels.
    pub real: Option<String>,
    /// Column of its imaginary part.
    pub imaginary: Option<String>,
    /// Column of the standard errors of the amplitudes.
    pub std_error: Option<String>,
    /// Column of the drive: its level at each point, or its signal in driven records; `none` if a curve has no drive.
    pub drive: Option<String>,
    /// Unit of the drive levels.
    pub drive_unit: Option<String>,
}

impl ReadOptions {
    /// Half a gigabyte of times and values.
    pub const MOST_SAMPLES: usize = 1 << 25;
}

//! Choices that override what a file suggests.

use slipfit::SignalKind;

use crate::Format;

/// How to read a file, where it does not say so itself. The default leaves everything to the
/// file; each reading uses the fields that concern it.
///
/// A column is given by its number, from 1, or by its name: the whole header
/// or the header without its unit, in any case, or a part of it that no other
/// header has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// The format, where the first bytes do not tell it or tell another; of a gzip file that of
    /// what it packs.
    pub format: Option<Format>,
    /// Which of several sheets, variables, groups, data sets or tracks: its
    /// name, a part of it that no other has, or its number from 1.
    pub sheet: Option<String>,
    /// Which of several tables side by side, from 1.
    pub part: Option<usize>,
    /// Which of several runs, from 1: in groups of columns or, where there is one group, one after the other with
    /// a clock that begins again, of which the longest is read if none is named; or which of several curves in
    /// groups of columns.
    pub run: Option<usize>,
    /// Column of the times.
    pub time: Option<String>,
    /// Unit of the times: `s`, `ms`, `us`, `ns`, `min`, `h`, or the rate of a clock whose ticks
    /// they are, such as `60MHz`.
    pub time_unit: Option<String>,
    /// Samples per second (Hz), in place of a column of times.
    pub rate_hz: Option<f64>,
    /// Column of the signal of a record; of a lock-in, its in-phase output.
    pub signal: Option<String>,
    /// Column of the quadrature output of a lock-in.
    pub quadrature: Option<String>,
    /// Unit of the signal or of the amplitudes. `dB` and `dBm` are made linear.
    pub unit: Option<String>,
    /// What the signal or the response is. The response of a curve is divided by `i omega` once
    /// where it is a velocity, twice where it is an acceleration.
    pub kind: Option<SignalKind>,
    /// Samples held at most, [`ReadOptions::MOST_SAMPLES`] if not said: longer records of an even
    /// clock are averaged while they are read ([`slipfit::record::Averaging`]).
    pub most_samples: Option<usize>,
    /// Column of the frequencies of a curve, of their periods or of shifts.
    pub frequency: Option<String>,
    /// Unit of the frequencies: `Hz`, `kHz`, `MHz`, `rad/s`, `rpm`, `s` or `ms` of a period, or `log10 Hz`,
    /// `log10 kHz`, `ln rad/s` of logarithms; or what 1 stands for in a column of ratios, such as `80.1 Hz`.
    pub frequency_unit: Option<String>,
    /// The frequency (Hz) the shifts are counted from.
    pub centre_hz: Option<f64>,
    /// Column of the amplitudes of a curve; of driven records, of the response.
    pub amplitude: Option<String>,
    /// Column of the phases.
    pub phase: Option<String>,
    /// Unit of the phases: `deg`, `rad`, `cycles`, or `pi` of multiples of it.
    pub phase_unit: Option<String>,
    /// Column of the real part of the response, of a curve or at drive levels.
    pub real: Option<String>,
    /// Column of its imaginary part.
    pub imaginary: Option<String>,
    /// Column of the standard errors of the amplitudes.
    pub std_error: Option<String>,
    /// Column of the drive: its level at each point, or in driven records its signal; `none` where a curve has none.
    pub drive: Option<String>,
    /// Unit of the drive levels.
    pub drive_unit: Option<String>,
}

impl ReadOptions {
    /// Half a gigabyte of times and values.
    pub const MOST_SAMPLES: usize = 1 << 25;
}

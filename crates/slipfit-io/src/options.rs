//! What the person reading a file may decide.

use slipfit::{SignalKind, record::Averaging};

use crate::columns::{Choice, Time};

/// Choices that override what the file itself suggests. The default leaves
/// everything to the file.
///
/// A column is given by its number, from 1, or by its name: the whole header
/// or the header without its unit, in any case, or a part of it that no other
/// header has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Column of the times.
    pub time: Option<String>,
    /// Column of the signal; of a lock-in, its in-phase output.
    pub signal: Option<String>,
    /// Column of the quadrature output of a lock-in.
    pub quadrature: Option<String>,
    /// Unit of the time column: `s`, `ms`, `us`, `ns`, `min`, `h`.
    pub time_unit: Option<String>,
    /// Unit of the signal. `dB` and `dBm` are made linear.
    pub signal_unit: Option<String>,
    /// What the signal is.
    pub kind: Option<SignalKind>,
    /// Samples per second, in place of a time column.
    pub rate_hz: Option<f64>,
    /// Which of several sheets, variables, groups, data sets or tracks: its
    /// name, a part of it that no other has, or its number from 1.
    pub sheet: Option<String>,
    /// Which of several tables side by side, from 1.
    pub table: Option<usize>,
    /// Which of several runs in groups of columns, from 1.
    pub run: Option<usize>,
    /// Samples held at most, [`ReadOptions::MOST_SAMPLES`] if not said: longer records of an even
    /// clock are averaged while they are read ([`slipfit::record::Averaging`]).
    pub most_samples: Option<usize>,
}

impl ReadOptions {
    /// Half a gigabyte of times and values.
    pub const MOST_SAMPLES: usize = 1 << 25;

    /// Averages what the columns chosen give, where there is more than wanted.
    pub(crate) fn averaging(&self, choice: &Choice) -> Averaging {
        let interval_s = match choice.time {
            Time::Rate(rate_hz) => Some(1.0 / rate_hz),
            _ => None,
        };
        // The mean of levels is no level of the mean.
        let level = choice.signal.level || choice.quadrature.as_ref().is_some_and(|q| q.level);
        let most = if level { usize::MAX } else { self.most_samples.unwrap_or(Self::MOST_SAMPLES) };
        Averaging::new(most, interval_s)
    }
}

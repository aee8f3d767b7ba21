//! The times at which the samples of a record were taken.

/// The times of the samples of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Clock {
    /// Sample `i` at `start_s + i interval_s`.
    Uniform {
        /// Time of the first sample (s).
        start_s: f64,
        /// Time between two samples (s), positive.
        interval_s: f64,
    },
    /// One stamp (s) per sample, non-decreasing; equal stamps may follow each other.
    Stamps(Vec<f64>),
}

impl Clock {
    /// Time of sample `index` (s).
    pub(super) fn time_s(&self, index: usize) -> f64 {
        match self {
            Self::Uniform { start_s, interval_s } => start_s + index as f64 * interval_s,
            Self::Stamps(stamps) => stamps[index],
        }
    }

    /// Whether the samples are exactly equidistant.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        matches!(self, Self::Uniform { .. })
    }
}

/// A stretch without samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Time of the last sample before it (s).
    pub start_s: f64,
    /// Time to the next sample (s).
    pub length_s: f64,
}

/// Findings about the clock of a record and the corrections made.
///
/// `rows` equals the number of samples of the record plus all rows counted as dropped: the three `nonfinite_*`,
/// `corrupt_stamps` and `other_run_rows`.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ClockReport {
    /// Number of rows given.
    pub rows: usize,
    /// Rows before the first usable one, dropped because of a non-finite value.
    pub nonfinite_leading: usize,
    /// The same, between usable rows.
    pub nonfinite_inner: usize,
    /// The same, after the last usable row.
    pub nonfinite_trailing: usize,
    /// Steps of exactly zero between successive stamps, as given.
    pub repeated_stamps: usize,
    /// Backward steps of single rows that were sorted into order of time.
    pub reordered: usize,
    /// Rows dropped because their stamp is far from both neighbours.
    pub corrupt_stamps: usize,
    /// Places where a counter restarts at zero while the motion goes on; its count was continued.
    pub wraps: usize,
    /// Period (s) after which the counter restarts.
    pub wrap_period_s: Option<f64>,
    /// Places where the clock jumps back permanently: another run begins.
    pub resets: usize,
    /// The run that was kept, from 1; 0 if no stamps were examined.
    pub run: usize,
    /// Rows of the other runs, dropped.
    pub other_run_rows: usize,
    /// Coarsest rounding (s) of the stamps, if these were those of a uniform clock written with too few digits, which
    /// was rebuilt.
    pub rebuilt_quantum_s: Option<f64>,
    /// Largest deviation of a stamp from the rebuilt clock beyond half its rounding (s), at most a tenth of a step
    /// and of the rounding.
    pub rebuilt_excess_s: f64,
    /// Half width of the range of rates compatible with all stamps of a rebuilt clock, over the rate; 0 if none was
    /// rebuilt or the stamps leave no range.
    pub rebuilt_rate_error: f64,
    /// Usual number of samples per burst, if the stamps stood for bursts of samples; their times were spread evenly
    /// between the stamps.
    pub burst_samples: Option<usize>,
    /// Number of stretches without samples. If sampling is regular (80 % of the steps within 20 % of the median), a
    /// step above 1.5 medians; otherwise a step above 10 medians of the record and of its eight neighbours.
    pub gaps: usize,
    /// The longest of them.
    pub longest_gap: Option<Gap>,
    /// Median step (s); if more than half of the steps are zero, the median of the others.
    pub median_step_s: f64,
    /// Root mean square deviation of the steps from their median, over that median, without gaps; 0 for a uniform
    /// clock.
    pub step_spread: f64,
}

impl ClockReport {
    /// Rows dropped because of a non-finite value.
    #[must_use]
    pub fn nonfinite(&self) -> usize {
        self.nonfinite_leading + self.nonfinite_inner + self.nonfinite_trailing
    }
}

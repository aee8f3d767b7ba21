//! Levels in order of increasing drive.

use super::Levels;
use crate::numeric::order::ascending;

/// Drive levels with their amplitudes, in order of increasing drive.
#[derive(Clone)]
pub(super) struct SortedLevels {
    /// Index of each level in the order of measurement.
    pub(super) order: Vec<usize>,
    pub(super) drive: Vec<f64>,
    pub(super) amplitude: Vec<f64>,
    /// Inverse variances, if errors are given.
    pub(super) weights: Option<Vec<f64>>,
    /// Amplitude of the motion at each level as a function of the line.
    pub(super) rows: Vec<LevelRow>,
}

/// Amplitude of the motion at one level as a function of intercept and slope of the line: that of the line itself, or
/// the exact one to first order about a line near it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LevelRow {
    /// Amplitude for a vanishing line.
    pub(super) offset: f64,
    /// Derivatives with respect to intercept and slope.
    pub(super) by: [f64; 2],
    /// Derivative with respect to the logarithm of Q for a given line.
    pub(super) by_log_q: f64,
}

impl LevelRow {
    /// A level on the line.
    pub(super) fn straight(drive: f64) -> Self {
        Self { offset: 0.0, by: [1.0, drive], by_log_q: 0.0 }
    }

    /// Amplitude for a line `[intercept, slope]`.
    pub(super) fn amplitude(&self, [intercept, slope]: [f64; 2]) -> f64 {
        self.offset + self.by[0] * intercept + self.by[1] * slope
    }
}

impl SortedLevels {
    pub(super) fn of(levels: &Levels) -> Self {
        let order = ascending(levels.drive());
        let sorted = |values: &[f64]| -> Vec<f64> { order.iter().map(|&i| values[i]).collect() };
        let drive = sorted(levels.drive());
        Self {
            rows: drive.iter().map(|x| LevelRow::straight(*x)).collect(),
            drive,
            amplitude: sorted(levels.amplitude()),
            weights: levels.std_error().map(|s| order.iter().map(|&i| 1.0 / (s[i] * s[i])).collect()),
            order,
        }
    }

    /// Number of levels.
    pub(super) fn len(&self) -> usize {
        self.drive.len()
    }

    /// Weight of a level; one if no errors are given.
    pub(super) fn weight(&self, level: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[level])
    }

    /// Amplitude of a level without the part that does not depend on the line.
    pub(super) fn response(&self, level: usize) -> f64 {
        self.amplitude[level] - self.rows[level].offset
    }

    /// Highest drive.
    pub(super) fn widest(&self) -> f64 {
        self.drive.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
    }
}

//! Levels by rising drive.

use super::Levels;
use crate::numeric::order::ascending;

/// Drive levels with their amplitudes, by rising drive.
pub(super) struct SortedLevels {
    /// Place of each in the order of measurement.
    pub(super) order: Vec<usize>,
    pub(super) drive: Vec<f64>,
    pub(super) amplitude: Vec<f64>,
    /// Inverse variances, where errors are given.
    pub(super) weights: Option<Vec<f64>>,
}

impl SortedLevels {
    pub(super) fn of(levels: &Levels) -> Self {
        let order = ascending(levels.drive());
        let sorted = |values: &[f64]| -> Vec<f64> { order.iter().map(|&i| values[i]).collect() };
        Self {
            drive: sorted(levels.drive()),
            amplitude: sorted(levels.amplitude()),
            weights: levels.std_error().map(|s| order.iter().map(|&i| 1.0 / (s[i] * s[i])).collect()),
            order,
        }
    }

    /// Weight of a level: one where no errors are given.
    pub(super) fn weight(&self, level: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[level])
    }
}

//! Levels in order of increasing drive.

use super::Levels;
use crate::numeric::order::ascending;

/// Drive levels with their amplitudes, in order of increasing drive.
pub(super) struct SortedLevels {
    /// Index of each level in the order of measurement.
    pub(super) order: Vec<usize>,
    pub(super) drive: Vec<f64>,
    pub(super) amplitude: Vec<f64>,
    /// Inverse variances, if errors are given.
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

    /// Weight of a level; one if no errors are given.
    pub(super) fn weight(&self, level: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |w| w[level])
    }
}

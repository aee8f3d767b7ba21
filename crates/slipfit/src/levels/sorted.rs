//! Levels in order of increasing drive.

use super::Levels;
use super::level_row::LevelRow;
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

//! Amplitudes of consecutive blocks and the effect of noise on them.

use super::criteria::BlockCriteria;
use crate::signal::blocks::Block;

/// Amplitudes of consecutive blocks.
#[derive(Debug, Clone)]
pub(crate) struct BlockAmplitudes<'a> {
    pub(crate) blocks: &'a [Block],
    /// Standard error of each amplitude.
    pub(crate) error: Vec<f64>,
    /// Amplitude below which a block shows only noise.
    pub(crate) floor: Vec<f64>,
    /// Angular frequency of the oscillation, rad/s.
    pub(crate) omega: f64,
    /// Reading of a block of moduli due to noise alone, `E[R²] = A² + level²`; zero for blocks of an
    /// oscillation, for which noise enters only through the standard error.
    pub(crate) level: f64,
}

impl<'a> BlockAmplitudes<'a> {
    /// Blocks of an oscillation sampled in steps of `converter_step` (zero if unknown).
    pub(crate) fn of_oscillation(
        blocks: &'a [Block],
        omega: f64,
        converter_step: f64,
        noise_rms: f64,
        criteria: &BlockCriteria,
    ) -> Self {
        let top = blocks.iter().fold(0.0f64, |m, b| m.max(b.amplitude));
        let least = (criteria.floor_steps * converter_step).max(criteria.floor_of_top * top);
        let floor = |error: f64| (criteria.floor_errors * error).max(least);
        Self::with_floor(blocks, omega, noise_rms, floor)
    }

    /// Blocks whose standard errors come from `noise_rms`, with a floor for each error.
    pub(crate) fn with_floor(
        blocks: &'a [Block],
        omega: f64,
        noise_rms: f64,
        floor: impl Fn(f64) -> f64,
    ) -> Self {
        let error: Vec<f64> = blocks.iter().map(|b| b.std_error(noise_rms)).collect();
        let floor = error.iter().map(|&e| floor(e)).collect();
        Self { blocks, error, floor, omega, level: 0.0 }
    }

    pub(crate) fn amplitude(&self, block: usize) -> f64 {
        self.blocks[block].amplitude
    }

    /// Expected reading of a block if the motion has this amplitude.
    pub(crate) fn reading(&self, amplitude: f64) -> f64 {
        amplitude.hypot(self.level)
    }

    /// Amplitude of the motion in a block, and its standard error.
    pub(crate) fn of_motion(&self, block: usize) -> [f64; 2] {
        let (read, error) = (self.amplitude(block), self.error[block]);
        if self.level == 0.0 {
            return [read, error];
        }
        let amplitude = (read * read - self.level * self.level).max(error * error).sqrt();
        [amplitude, error * (read / amplitude).max(1.0)]
    }

    /// Running median of three, so that single outlying blocks have no effect.
    pub(crate) fn smooth(&self) -> Vec<f64> {
        let last = self.blocks.len() - 1;
        (0..=last)
            .map(|i| {
                if i == 0 || i == last {
                    return self.amplitude(i);
                }
                let (x, y, z) = (self.amplitude(i - 1), self.amplitude(i), self.amplitude(i + 1));
                x.max(y).min(x.min(y).max(z))
            })
            .collect()
    }
}

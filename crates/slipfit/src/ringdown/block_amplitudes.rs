//! Amplitudes of consecutive blocks, with what noise makes of them.

use super::criteria::BlockCriteria;
use crate::signal::blocks::{self, Block};

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
}

impl<'a> BlockAmplitudes<'a> {
    /// Blocks of an oscillation sampled in steps of `converter_step` (zero if unknown).
    pub(crate) fn of_oscillation(
        blocks: &'a [Block],
        omega: f64,
        converter_step: f64,
        noise_inflation: f64,
        criteria: &BlockCriteria,
    ) -> Self {
        let top = blocks.iter().fold(0.0f64, |m, b| m.max(b.amplitude));
        let least = (criteria.floor_steps * converter_step).max(criteria.floor_of_top * top);
        let floor = |error: f64| (criteria.floor_errors * error).max(least);
        let noise_rms = noise_inflation.sqrt() * blocks::noise_rms(blocks);
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
        Self { blocks, error, floor, omega }
    }

    pub(crate) fn amplitude(&self, block: usize) -> f64 {
        self.blocks[block].amplitude
    }

    /// Running median of three, so that single blocks count for nothing.
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

//! Amplitudes and phases along a free decay.

use super::window::{DecayWindow, EndReason};
use crate::signal::blocks::Block;
use crate::signal::phase::PhaseLaw;
use crate::signal::spectrum::Periodogram;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Reason for refusing amplitudes that carry no information.
pub(crate) const BELOW_NOISE: &str =
    "the first amplitude is less than twice its standard error, so any oscillation lies below the noise";

/// Amplitudes along the record and its free decay.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredDecay {
    /// Blocks of the whole record, as first measured.
    pub(crate) all: Vec<Block>,
    pub(crate) window: DecayWindow,
    /// Blocks of the free decay, along a smooth phase.
    pub(crate) points: Vec<Block>,
    pub(crate) law: PhaseLaw,
    /// The phase follows `law`; otherwise it was smoothed locally.
    pub(crate) phase_follows_law: bool,
    /// Noise of one sample.
    pub(crate) noise_rms: f64,
    /// Whether the amplitudes are root mean squares that include the noise, `R² = A² + floor`.
    pub(crate) root_mean_squares: bool,
    /// Variance of the times of the samples averaged in an amplitude, s²; zero if the amplitude is that at
    /// their middle.
    pub(crate) time_variance_s2: f64,
    /// Periodogram of all samples, if it was computed to find their oscillation.
    pub(crate) periodogram: Option<Arc<Periodogram>>,
}

impl MeasuredDecay {
    /// Start of the first block, s.
    pub(crate) fn start_s(&self) -> f64 {
        self.points[0].time_s - 0.5 * self.points[0].span_s
    }

    /// End of the last block, s.
    pub(crate) fn end_s(&self) -> f64 {
        let last = &self.points[self.points.len() - 1];
        last.time_s + 0.5 * last.span_s
    }

    /// Number of cycles from the first to the last block, including the gaps between blocks.
    pub(crate) fn cycles(&self) -> f64 {
        let spans: f64 = self.points.iter().map(|b| b.span_s).sum();
        let turns: f64 = self.points.iter().map(|b| b.span_s * b.omega / TAU).sum();
        if spans > 0.0 { turns / spans * (self.end_s() - self.start_s()) } else { 0.0 }
    }

    /// Discards the blocks before a time.
    pub(crate) fn begin_at(&mut self, time_s: f64) {
        self.points.retain(|b| b.time_s >= time_s - 1e-9 * b.span_s);
    }

    /// Discards the blocks from a time on.
    pub(crate) fn end_before(&mut self, time_s: f64, reason: EndReason) {
        self.points.retain(|b| b.time_s < time_s);
        self.window.end_reason = reason;
        self.window.disturbed = false;
    }
}

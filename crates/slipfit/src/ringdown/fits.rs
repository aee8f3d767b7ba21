//! The data as one least-squares problem: the amplitudes of the blocks with the
//! phase left free, or every sample against the exact motion.

use super::compare::{Comparison, Scale};
use super::envelope::{A0, DELTA, DRAG, EnvelopeProblem, X_F};
use super::waveform::Waveform;
use crate::inference::least_squares::LeastSquares;

/// The data as one least-squares problem, all models fitted to it.
pub(crate) struct Described<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) comparison: Comparison,
    pub(crate) scale: Scale,
    /// Window start the parameters refer to, s.
    pub(crate) origin: f64,
    pub(crate) end: f64,
    /// Residual variance of the fundamental over that of the noise.
    pub(crate) excess: f64,
    pub(crate) autocorrelation: f64,
    /// Blocks left out because they lie far off every law.
    pub(crate) outliers: usize,
}

/// Either description.
pub(crate) enum Problem<'a> {
    /// Amplitudes of blocks.
    Envelope(EnvelopeProblem),
    /// Every sample.
    Waveform(Waveform<'a>),
}

impl Problem<'_> {
    pub(crate) fn least_squares(&self) -> &dyn LeastSquares {
        match self {
            Problem::Envelope(p) => p,
            Problem::Waveform(p) => p,
        }
    }

    pub(crate) fn method(&self) -> &'static str {
        match self {
            Problem::Envelope(_) => "envelope",
            Problem::Waveform(_) => "waveform",
        }
    }
}

/// The loss parameters, all of them.
pub(super) const FULL: [usize; 4] = [A0, X_F, DELTA, DRAG];

/// The comparison with its criteria in the units of another scale.
pub(super) fn rescored(mut comparison: Comparison, scale: Scale) -> Comparison {
    for entry in &mut comparison.entries {
        entry.bic = scale.bic(entry.bounded.rss, entry.fit.free.len());
    }
    comparison
}

pub(crate) fn first_autocorrelation(residuals: &[f64]) -> f64 {
    let n = residuals.len() as f64;
    let mean = residuals.iter().sum::<f64>() / n;
    let (mut c0, mut c1) = (0.0, 0.0);
    for (i, r) in residuals.iter().enumerate() {
        c0 += (r - mean).powi(2);
        if i > 0 {
            c1 += (r - mean) * (residuals[i - 1] - mean);
        }
    }
    if c0 > 0.0 { c1 / c0 } else { 0.0 }
}

/// Variance factor of an AR(1) residual on a slowly varying derivative; one unless significant.
pub(crate) fn widening(autocorrelation: f64, n: usize) -> f64 {
    if autocorrelation > 2.6 / (n as f64).sqrt() {
        let r = autocorrelation.min(0.95);
        (1.0 + r) / (1.0 - r)
    } else {
        1.0
    }
}

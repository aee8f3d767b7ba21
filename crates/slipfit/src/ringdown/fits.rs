//! The data as one least-squares problem: the amplitudes of the blocks with the
//! phase left free, or every sample against the exact motion.

use super::envelope::{A0, DELTA, DRAG, EnvelopeProblem, X_F};
use super::waveform::Waveform;
use crate::inference::least_squares::LeastSquares;
use crate::inference::model_selection::ModelComparison;

/// The data as one least-squares problem, all models fitted to it.
pub(crate) struct Described<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) comparison: ModelComparison,
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

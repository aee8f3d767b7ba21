//! The loss models fitted to the data of one window: the amplitudes of the blocks with the phase
//! left free, or every sample against the exact motion.

use super::criteria::AnswerCriteria;
use super::envelope::EnvelopeProblem;
use super::remainder::Harmonics;
use super::wandering_phase::WanderingPhase;
use super::waveform::Waveform;
use crate::inference::evidence::chi_square_tail;
use crate::inference::least_squares::{Fit, LeastSquares};
use crate::inference::model_selection::ModelComparison;

/// Every loss model fitted to the data of one window.
pub(crate) struct WindowFit<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) comparison: ModelComparison,
    /// Start of the window, to which the parameters refer, s.
    pub(crate) origin: f64,
    /// End of the window, s.
    pub(crate) end: f64,
    /// Residual variance of the fundamental over that of the noise.
    pub(crate) excess: f64,
    /// Degrees of freedom of that.
    pub(crate) excess_freedom: f64,
    /// First autocorrelation of the residuals.
    pub(crate) autocorrelation: f64,
    /// What autocorrelation alone does to the variances of the parameters.
    pub(crate) serial_inflation: f64,
    /// A phase that walks at random beside the motion, where every sample is compared with it.
    pub(crate) wandering: Option<WanderingPhase>,
    /// Harmonics beyond its own.
    pub(crate) harmonics: Option<Harmonics>,
    /// Another last swing explains the samples nearly as well: the sum of squares has several minima.
    pub(crate) several_minima: bool,
    /// The minima with another last swing that explain the samples nearly as well.
    pub(crate) other_minima: Vec<Fit>,
    /// Blocks left out because they lie far off every law.
    pub(crate) outliers: usize,
}

impl WindowFit<'_> {
    /// Whether the law leaves far more than the noise, by more than a few residuals do by chance.
    pub(crate) fn leaves_much(&self, criteria: &AnswerCriteria) -> bool {
        self.excess > criteria.misfit && !(self.excess_by_chance() > criteria.misfit_by_chance)
    }

    /// Probability of as large an excess in residuals of white noise.
    pub(crate) fn excess_by_chance(&self) -> f64 {
        chi_square_tail(self.excess * self.excess_freedom, self.excess_freedom)
    }
}

/// The data of a window with the motion that they are compared with.
pub(crate) enum Problem<'a> {
    /// Amplitudes of blocks.
    Envelope(EnvelopeProblem),
    /// Every sample.
    Waveform(Waveform<'a>),
}

/// Name of the method that compares every sample with the exact motion.
pub(crate) const WAVEFORM: &str = "waveform";

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
            Problem::Waveform(_) => WAVEFORM,
        }
    }
}

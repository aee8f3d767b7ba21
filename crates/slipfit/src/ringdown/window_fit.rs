//! Fits of the loss models to the data of one window: either the amplitudes of the blocks with the phase left
//! free, or every sample compared with the exact motion.

use super::criteria::AnswerCriteria;
use super::envelope::EnvelopeProblem;
use super::residuals::Harmonics;
use super::wandering_phase::WanderingPhase;
use super::waveform::Waveform;
use crate::inference::evidence::chi_square_tail;
use crate::inference::least_squares::{Fit, LeastSquares};
use crate::inference::model_selection::ModelComparison;

/// Fits of every loss model to the data of one window.
pub(crate) struct WindowFit<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) comparison: ModelComparison,
    /// Start of the window, to which the parameters refer, s.
    pub(crate) origin: f64,
    /// End of the window, s.
    pub(crate) end: f64,
    /// Ratio of the residual variance of the fundamental to the noise variance.
    pub(crate) excess: f64,
    /// Degrees of freedom of that ratio.
    pub(crate) excess_freedom: f64,
    /// Lag-one autocorrelation of the residuals.
    pub(crate) autocorrelation: f64,
    /// Inflation of the variances of the parameters without that from cluster to cluster.
    pub(crate) serial_inflation: f64,
    /// Random walk of the phase, if every sample is compared with the motion.
    pub(crate) wandering: Option<WanderingPhase>,
    /// Harmonics in addition to those of the motion itself.
    pub(crate) harmonics: Option<Harmonics>,
    /// Whether another last half cycle explains the samples nearly as well: the sum of squares has several
    /// minima.
    pub(crate) several_minima: bool,
    /// The minima with another last half cycle that explain the samples nearly as well.
    pub(crate) other_minima: Vec<Fit>,
    /// Number of blocks left out because they lie far from every law.
    pub(crate) outliers: usize,
}

impl WindowFit<'_> {
    /// Whether the residuals of the law far exceed the noise, by more than a few residuals do by chance.
    pub(crate) fn leaves_much(&self, criteria: &AnswerCriteria) -> bool {
        self.excess > criteria.misfit && !(self.excess_by_chance() > criteria.misfit_by_chance)
    }

    /// Probability of such a large excess for residuals of white noise.
    pub(crate) fn excess_by_chance(&self) -> f64 {
        chi_square_tail(self.excess * self.excess_freedom, self.excess_freedom)
    }
}

/// The data of a window and the model that they are compared with.
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

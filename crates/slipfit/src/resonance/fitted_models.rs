//! Results of the fits of a curve, and their implications for the loss models.

use super::alternatives::{Alternative, FreeGain};
use super::block::Block;
use super::criteria::AnswerCriteria;
use super::peak::Peak;
use super::problem::Problem;
use super::response::{BG_IM, BG_RE, FLOOR, OFFSET};
use super::{DriveSource, Method};
use crate::inference::least_squares::Fit;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::model::loss::LossTerm;
use crate::motion::steady::Phasor;

/// A column that was not used.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetAside {
    /// Its relative scatter.
    pub(crate) scatter: f64,
    /// Whether no fit was found with it; otherwise the residuals contradict it.
    pub(crate) no_fit: bool,
}

/// Columns that were not used.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ColumnsSetAside {
    /// Errors of the points.
    pub(crate) errors: Option<SetAside>,
    /// The drive of each point.
    pub(crate) drive: Option<SetAside>,
}

/// Results of all fits.
#[derive(Debug)]
pub(crate) struct FittedModels {
    pub(crate) problem: Problem,
    pub(crate) peak: Peak,
    pub(crate) comparison: ModelComparison,
    pub(crate) source: DriveSource,
    pub(crate) conjugated: bool,
    /// The phases fit no resonance, so that only the amplitudes were used.
    pub(crate) phases_ignored: bool,
    /// All points, if the fit used means of neighbours.
    pub(crate) all: Option<Block>,
    /// Points left out of the fit.
    pub(crate) left_out: usize,
    /// Points left out before the fit.
    pub(crate) spikes: usize,
    /// Noise of one point from differences of the residuals between neighbours.
    pub(crate) neighbour_noise: f64,
    pub(crate) autocorrelation: f64,
    /// Minima that are as good as the best one within its errors, if there are several: amplitudes do not determine on
    /// which side of the line a background lies.
    pub(crate) minima: Vec<Fit>,
    /// Other sets of instrument terms with a significant weight.
    pub(crate) alternatives: Vec<Alternative>,
    /// Curve and reference of amplitudes with separate drives.
    pub(crate) free_gain: Option<FreeGain>,
    /// Ratio of the noise to the amplitude, if the noise grows with the amplitude.
    pub(crate) proportional_noise: Option<f64>,
    pub(crate) set_aside: ColumnsSetAside,
    pub(crate) criteria: AnswerCriteria,
    /// [`ReportCriteria::near_limit`](crate::answer::ReportCriteria::near_limit).
    pub(crate) near_limit: f64,
    /// [`ReportCriteria::mentioned_widening`](crate::answer::ReportCriteria::mentioned_widening).
    pub(crate) mentioned_widening: f64,
}

/// Amplitudes of the oscillator according to the points: without the fitted background and offset, at the mean drive.
/// `None` if these are the measured amplitudes.
pub(crate) fn oscillator_amplitudes(problem: &Problem, p: &[f64]) -> Option<Block> {
    let b = &problem.main;
    let background = Phasor::new(p[BG_RE], p[BG_IM]);
    let even = b.drive.iter().all(|d| *d == 1.0);
    if even && background == Phasor::default() && p[OFFSET] == 0.0 && p[FLOOR] == 0.0 {
        return None;
    }
    let mut mean = problem.clone();
    mean.main.drive.fill(1.0);
    let data = problem
        .predict(p, false)
        .into_iter()
        .zip(mean.predict(p, false))
        .enumerate()
        .map(|(i, pair)| {
            let (Some(here), Some(mean)) = pair else { return Phasor::new(b.amplitude(i), 0.0) };
            let (size, wanted) = (here.oscillator.norm(), mean.oscillator.norm());
            let amplitude = if b.complex {
                let ratio = if size > 0.0 { wanted / size } else { 1.0 };
                (b.data[i] - problem.background_at(p, b.omega[i])).norm() * ratio
            } else {
                (wanted + b.residual(i, &here).re).max(0.0)
            };
            Phasor::new(amplitude, 0.0)
        })
        .collect();
    Some(Block { data, complex: false, drive: vec![1.0; b.len()], ..b.clone() })
}

impl FittedModels {
    /// The problem as used by the fit of a model.
    pub(crate) fn problem_of(&self, fit: &ModelFit) -> Problem {
        self.problem.with(&fit.unbounded.free)
    }

    /// Whether the residuals of the losses beyond the noise are smaller than what friction explains, and small compared
    /// with the height: otherwise friction may only compensate for a wrong law.
    pub(crate) fn law_holds(&self, chosen: &ModelFit) -> bool {
        let noise = &self.comparison.noise;
        if noise.variance_inflation == 1.0 {
            return true;
        }
        let left = chosen.bounded.rss;
        let variance = noise.residual_variance(&chosen.bounded);
        let beyond = (variance - self.neighbour_noise * self.neighbour_noise).max(0.0);
        let without = self.comparison.fits.iter().filter(|f| !f.model.has(LossTerm::Sliding));
        let explained = without.map(|f| f.bounded.rss - left).fold(f64::INFINITY, f64::min);
        explained >= left * beyond / variance
            && beyond.sqrt() < self.comparison.criteria.no_law * self.problem.main.highest()
    }

    pub(crate) fn method(&self) -> Method {
        self.problem.method
    }
}

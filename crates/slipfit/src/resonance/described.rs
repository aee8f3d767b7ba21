//! What the fits of a curve bring, and what they say of the loss models.

use super::block::Block;
use super::peak::Peak;
use super::problem::{BG_IM, BG_RE, DELTA, DRAG, Problem, X_F};
use super::{DriveSource, Method};
use crate::inference::least_squares::Fit;
use crate::inference::profile::Scale;
use crate::motion::steady::Phasor;
use crate::ringdown::{Entry, LossModel, ranked};

/// Everything the fits brought.
#[derive(Debug)]
pub(crate) struct Described {
    pub(crate) problem: Problem,
    pub(crate) peak: Peak,
    pub(crate) entries: Vec<Entry>,
    pub(crate) scale: Scale,
    pub(crate) source: DriveSource,
    pub(crate) conjugated: bool,
    /// The phases fit no resonance; only amplitudes were used.
    pub(crate) phases_ignored: bool,
    /// Every point, where the fit used means of neighbours.
    pub(crate) all: Option<Block>,
    pub(crate) left_out: usize,
    /// Noise of one point as differences of the residuals between neighbours give it.
    pub(crate) neighbour_noise: f64,
    pub(crate) autocorrelation: f64,
    /// Minima as good as the best within its errors, where there are several: amplitudes do not
    /// tell on which side of the line a background lies.
    pub(crate) minima: Vec<Fit>,
}

/// Terms beside the loss that are free.
pub(crate) fn loss_terms(model: LossModel) -> Vec<usize> {
    [(model.has_sliding(), X_F), (model.has_viscous(), DELTA), (model.has_drag(), DRAG)]
        .into_iter()
        .filter_map(|(has, k)| has.then_some(k))
        .collect()
}

/// Amplitudes of the oscillator as the points show them: without the background fitted, at the
/// mean drive. `None` where that is what was measured.
pub(crate) fn oscillator_seen(problem: &Problem, p: &[f64]) -> Option<Block> {
    let b = &problem.main;
    let background = Phasor::new(p[BG_RE], p[BG_IM]);
    let even = b.drive.iter().all(|d| *d == 1.0);
    if even && background == Phasor::default() {
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
                (wanted + b.residual(i, here.value).re).max(0.0)
            };
            Phasor::new(amplitude, 0.0)
        })
        .collect();
    Some(Block { data, complex: false, drive: vec![1.0; b.len()], ..b.clone() })
}

impl Described {
    pub(crate) fn get(&self, model: LossModel) -> Option<&Entry> {
        ranked::of(&self.entries, model)
    }

    /// The model of least BIC among those with every term inside its limit.
    pub(crate) fn preferred(&self) -> Option<&Entry> {
        ranked::best(&self.entries)
    }

    /// The entry with the terms of `model` and one more.
    pub(crate) fn with_term(&self, model: LossModel, term: usize) -> Option<&Entry> {
        LossModel::from_terms(
            model.has_viscous() || term == DELTA,
            model.has_sliding() || term == X_F,
            model.has_drag() || term == DRAG,
        )
        .and_then(|m| self.get(m))
    }

    /// p value of sliding friction given the best model without it, and the BIC's verdict.
    pub(crate) fn sliding_evidence(&self) -> (f64, f64) {
        ranked::sliding_evidence(&self.entries, |small, large| self.test(small, large))
    }

    /// p value of a purely viscous loss against `model`.
    pub(crate) fn viscous_only(&self, model: LossModel) -> f64 {
        let Some(viscous) = self.get(LossModel::Viscous) else { return 1.0 };
        let against = match model {
            LossModel::Viscous => return 1.0,
            LossModel::Sliding => LossModel::ViscousSliding,
            LossModel::SlidingDrag => LossModel::ViscousSlidingDrag,
            m => m,
        };
        self.get(against).map_or(1.0, |m| self.test(viscous, m))
    }

    fn test(&self, small: &Entry, large: &Entry) -> f64 {
        self.scale.test(small.bounded.rss, large.bounded.rss, &large.bounded)
    }

    /// The problem as the entry's model uses it.
    pub(crate) fn problem_of(&self, entry: &Entry) -> Problem {
        self.problem.with(&entry.fit.free)
    }

    pub(crate) fn method(&self) -> Method {
        self.problem.method
    }
}

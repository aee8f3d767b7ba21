//! Every loss model on the data of one decay.

use super::envelope::{A0, DELTA, DRAG, X_F};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise};
use crate::inference::model_selection::ModelComparison;
use crate::inference::noise::NoiseModel;
use crate::model::loss::{LossModel, LossTerm};
use std::f64::consts::PI;

/// Where every fit of a decay keeps the coefficient of a loss term.
pub(crate) fn slot(term: LossTerm) -> usize {
    match term {
        LossTerm::Sliding => X_F,
        LossTerm::Viscous => DELTA,
        LossTerm::Drag => DRAG,
        // Further terms follow in the order of their list.
        #[allow(unreachable_patterns, reason = "there may be none")]
        further => A0 + 1 + further as usize,
    }
}

/// Free parameters of a model: amplitude, its loss terms, the nuisances.
fn free_of(model: LossModel, nuisance: &[usize]) -> Vec<usize> {
    let mut free: Vec<usize> =
        [A0].into_iter().chain(model.terms().map(slot)).chain(nuisance.iter().copied()).collect();
    free.sort_unstable();
    free
}

/// Coefficients that each give all of a loss by themselves, at one amplitude.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WholeLoss {
    decay_rate: f64,
    friction_displacement: f64,
    drag_rate: f64,
}

impl WholeLoss {
    /// Those of a loss of `decay_rate` per second of the `amplitude` at `omega`.
    pub(crate) fn new(decay_rate: f64, amplitude: f64, omega: f64) -> Self {
        Self {
            decay_rate,
            friction_displacement: decay_rate * amplitude * PI / (2.0 * omega),
            drag_rate: decay_rate / amplitude,
        }
    }
}

/// Shares of the loss at the first amplitude that sliding friction takes in the starts of the search.
const SLIDING_SHARES: [f64; 4] = [0.1, 0.35, 0.65, 0.9];

/// Fits every model from several starts and keeps the lowest sum of squares of each.
///
/// `start` holds the amplitude, loss coefficients and the nuisances; `whole` is the coefficient that
/// each term would have if it made up all loss at the first amplitude. Where friction stops the motion the sum of squares has a
/// minimum for every number of swings: viscous and sliding loss are begun at `start`, at the best
/// fit of every model within theirs, and at [`SLIDING_SHARES`] of the loss; larger models at the
/// best fits of the smaller ones.
pub(crate) fn compare(
    problem: &dyn LeastSquares,
    start: &[f64],
    nuisance: &[usize],
    noise: NoiseModel,
    whole: WholeLoss,
) -> ModelComparison {
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let only = |model: LossModel| {
        let mut p = start.to_vec();
        for &term in LossTerm::ALL.iter().filter(|t| !model.has(**t)) {
            p[slot(term)] = 0.0;
        }
        p
    };
    let shared = |share: f64| {
        let mut p = only(LossModel::VISCOUS_SLIDING);
        (p[DELTA], p[X_F]) = ((1.0 - share) * whole.decay_rate, share * whole.friction_displacement);
        p
    };
    for model in LossModel::ALL {
        let free = free_of(model, nuisance);
        if (noise.observations as usize) <= free.len() {
            continue;
        }
        let mut starts: Vec<Vec<f64>> =
            fits.iter().filter(|(m, _)| m.is_within(model)).map(|(_, f)| f.parameters.clone()).collect();
        match model {
            LossModel::VISCOUS_SLIDING => {
                starts.push(only(model));
                starts.extend(SLIDING_SHARES.map(shared));
            }
            LossModel::SLIDING => starts.push(shared(1.0)),
            LossModel::VISCOUS => starts.push(shared(0.0)),
            LossModel::DRAG => {
                let mut p = only(model);
                p[DRAG] = whole.drag_rate;
                starts.push(p);
            }
            _ if starts.is_empty() => starts.push(only(model)),
            _ => {}
        }
        if let Some(fit) = best_of(problem, &starts, &free) {
            fits.push((model, fit));
        }
    }
    ModelComparison::new(&fits, slot, noise)
}

/// Starts from which a model is fitted, of those with the lowest sums of squares.
const FITTED_STARTS: usize = 2;

/// The lowest minimum reached from the starts with the lowest sums of squares.
fn best_of(problem: &dyn LeastSquares, starts: &[Vec<f64>], free: &[usize]) -> Option<Fit> {
    if let [start] = starts {
        return minimise(problem, start, free);
    }
    let mut sums = Normal::zeros(problem.parameters());
    let mut ranked: Vec<(f64, &Vec<f64>)> =
        starts.iter().filter_map(|s| problem.normal(s, &mut sums).then_some((sums.rss, s))).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let fits = ranked.iter().take(FITTED_STARTS).filter_map(|(_, start)| minimise(problem, start, free));
    fits.min_by(|a, b| a.rss.total_cmp(&b.rss))
}

//! Every loss model on the data of one decay.

use super::envelope::{A0, DELTA, DRAG, X_F};
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::model_selection::ModelComparison;
use crate::inference::noise::NoiseModel;
use crate::model::loss::{LossModel, LossTerm};
use crate::motion::decay::amplitude::FURTHER;

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

/// Fits every model, each from the best fit of a model within it.
///
/// `start` holds the amplitude, a decay rate and the nuisances.
pub(crate) fn compare(
    problem: &dyn LeastSquares,
    start: &[f64],
    nuisance: &[usize],
    noise: NoiseModel,
    sliding_start: f64,
) -> ModelComparison {
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let mut base = start.to_vec();
    base[X_F] = 0.0;
    base[DRAG..DRAG + 1 + FURTHER].fill(0.0);
    let mut sliding = base.clone();
    (sliding[DELTA], sliding[X_F]) = (0.0, sliding_start);
    for model in LossModel::ALL {
        let free = free_of(model, nuisance);
        if (noise.observations as usize) <= free.len() {
            continue;
        }
        let bare = if model.has(LossTerm::Viscous) { &base } else { &sliding };
        let nested =
            fits.iter().filter(|(m, _)| m.is_within(model)).min_by(|(_, a), (_, b)| a.rss.total_cmp(&b.rss));
        let from = nested.map_or(bare, |(_, f)| &f.parameters);
        let fit = minimise(problem, from, &free).or_else(|| minimise(problem, bare, &free));
        if let Some(fit) = fit {
            fits.push((model, fit));
        }
    }
    ModelComparison::new(&fits, slot, noise)
}

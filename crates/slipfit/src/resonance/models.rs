//! Every loss model fitted, each from its relatives.

use super::described::slot;
use super::problem::Problem;
use super::response::{DELTA, DRAG, X_0, X_F};
use super::search::best_of;
use crate::inference::least_squares::{Fit, LeastSquares};
use crate::inference::noise::NoiseModel;
use crate::model::loss::{LossModel, LossTerm};

/// Fits every loss model, each from its relatives.
pub(super) fn compare(
    problem: &Problem,
    starts: &[Vec<f64>],
    others: &[usize],
    noise: NoiseModel,
    asked: Option<LossModel>,
    tries: usize,
) -> Vec<(LossModel, Fit)> {
    // The richer model of two comes first: its solution starts the smaller ones.
    let order = [
        LossModel::VISCOUS_SLIDING,
        LossModel::VISCOUS,
        LossModel::SLIDING,
        LossModel::VISCOUS_DRAG,
        LossModel::SLIDING_DRAG,
        LossModel::VISCOUS_SLIDING_DRAG,
    ];
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let mut surely_viscous = false;
    for model in order {
        let terms: Vec<usize> = model.terms().map(slot).collect();
        if surely_viscous && !model.has(LossTerm::Viscous) && asked != Some(model) {
            continue;
        }
        let mut free: Vec<usize> = others.iter().chain(&terms).copied().collect();
        free.sort_unstable();
        if (problem.observations() as usize) <= free.len() {
            continue;
        }
        let mut from: Vec<Vec<f64>> =
            fits.iter().map(|(_, f)| f.parameters.clone()).chain(starts.iter().cloned()).collect();
        for p in &mut from {
            for k in [X_F, DELTA, DRAG] {
                if !terms.contains(&k) {
                    p[k] = 0.0;
                }
            }
            // Sliding alone has no height at resonance: the drive must fall short of it.
            if model == LossModel::SLIDING || model == LossModel::SLIDING_DRAG {
                p[X_F] = p[X_F].max(0.7 * p[X_0]);
            }
        }
        from.dedup();
        if let Some(fit) = best_of(&problem.with(&free), &from, &free, tries) {
            if model == LossModel::VISCOUS_SLIDING {
                // So far from zero no data call for a model without it.
                surely_viscous = fit.parameters[DELTA] > 10.0 * noise.std_error(&fit, DELTA);
            }
            fits.push((model, fit));
        }
    }
    fits
}

//! Intervals that account for the choice of terms apart from the losses: instrument terms, and a Duffing term.

use super::alternatives::{Alternative, Kind, OtherFit};
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::response::{DELTA, OMEGA, X_0, X_F};
use crate::Quantity;
use crate::answer::averaged::{self, WeightedEstimate};
use crate::inference::Z_95;
use crate::inference::least_squares::Fit;
use crate::inference::model_selection::ModelFit;
use crate::inference::noise::NoiseModel;
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// Value and standard error, including the factor of Student's t, of a function of the oscillator's parameters in a
/// fit.
pub(super) fn estimate(fit: &OtherFit, noise: NoiseModel, of: &dyn Fn(&[f64]) -> f64) -> [f64; 2] {
    let p = &fit.bounded.parameters;
    let std_error = (variance_of(&fit.unbounded, p, of) * noise.variance(&fit.bounded)).sqrt();
    [of(p), std_error * noise.student_factor(&fit.unbounded)]
}

/// Variance by first-order propagation, over the variance of one observation; derivatives at `p`.
fn variance_of(fit: &Fit, p: &[f64], of: &dyn Fn(&[f64]) -> f64) -> f64 {
    let slopes: Vec<(usize, f64)> = fit
        .free
        .iter()
        .filter(|&&k| [OMEGA, DELTA, X_0, X_F].contains(&k))
        .map(|&k| {
            let error = fit.unit_std(k).max(1e-9 * p[k].abs());
            // The step must not make a loss negative; a shift of the frequency has no such limit.
            let step = 1e-4 * if k == OMEGA { error } else { error.min(p[k].abs().max(1e-12)) };
            let (mut up, mut down) = (p.to_vec(), p.to_vec());
            (up[k], down[k]) = (p[k] + step, p[k] - step);
            (k, (of(&up) - of(&down)) / (2.0 * step))
        })
        .collect();
    let mut square = 0.0;
    for &(a, slope_a) in &slopes {
        for &(b, slope_b) in &slopes {
            square += slope_a * slope_b * fit.unit_covariance[(a, b)];
        }
    }
    square.max(0.0)
}

/// Widens the interval to contain those of all minima that explain the data equally well, and to account for other
/// terms apart from the losses, each with its `weight`, and for losses absent from the model (`absent`).
pub(super) fn widened(
    d: &FittedModels,
    mut q: Quantity,
    absent: &[WeightedEstimate],
    weight: fn(&Alternative) -> f64,
    of: &dyn Fn(&[f64]) -> f64,
) -> Quantity {
    let noise = d.comparison.noise;
    let before = q.interval_95;
    if d.minima.len() > 1 {
        for fit in &d.minima {
            let p = &fit.parameters;
            let error = (variance_of(fit, p, of) * noise.variance(fit)).sqrt();
            let half = Z_95 * error * noise.student_factor(fit);
            if half.is_finite() {
                q.interval_95[0] = q.interval_95[0].min((of(p) - half).max(0.0));
                q.interval_95[1] = q.interval_95[1].max(of(p) + half);
            }
        }
    }
    let absence = absent.iter().map(|a| a.weight).sum::<f64>().min(1.0);
    let of_kind = |kind: Kind| d.alternatives.iter().filter(move |a| a.kind == kind).map(weight).sum::<f64>();
    let others = |a: &Alternative, share: f64| {
        // Other terms and an absent loss are rivals; each was weighted against the reported fit alone.
        let rest = match a.kind {
            Kind::Noise => 1.0,
            kind => remaining_weight(absence, of_kind(kind)),
        };
        let [value, std_error] = estimate(&a.fit, noise, of);
        WeightedEstimate { weight: share * rest * weight(a), value, std_error }
    };
    let gain = d.free_gain.as_ref().map(|g| &g.alternative);
    let same_gain = 1.0 - gain.map_or(0.0, weight);
    let instruments = d.alternatives.iter().map(|a| others(a, same_gain));
    let instruments = instruments.chain(gain.map(|a| others(a, 1.0)));
    let others: Vec<WeightedEstimate> = instruments.chain(absent.iter().copied()).collect();
    let mut q = averaged::widened(q, &others);
    if q.interval_95 != before {
        q.std_error = q.std_error.max((q.interval_95[1] - q.interval_95[0]) / (2.0 * Z_95));
    }
    q
}

/// Factor by which an absent loss reduces the weight of other terms, which alone would have the probability `terms`:
/// with odds `a` for the loss and `t` for the terms, `t/(1 + a + t)` over `t/(1 + t)`.
fn remaining_weight(absence: f64, terms: f64) -> f64 {
    (1.0 - absence) / (1.0 - absence * terms).max(f64::MIN_POSITIVE)
}

/// p value of sliding friction averaged over the other fits; not smaller than the p value at any of the minima that
/// explain the data equally well, over which the interval is widened.
pub(super) fn sliding_p_value(d: &FittedModels, own: f64) -> f64 {
    let noise = d.comparison.noise;
    let by = |fit: &Fit| {
        let z = fit.parameters[X_F] / noise.std_error(fit, X_F);
        if z.is_finite() { 0.5 * erfc(z / SQRT_2) } else { 1.0 }
    };
    let several = d.minima.iter().filter(|_| d.minima.len() > 1);
    let own = several.map(by).fold(own, f64::max);
    let of = |a: &Alternative| a.weight * by(&a.fit.unbounded);
    // Weights of different kinds may sum to more than one.
    let mean = |own: f64, noise: bool| {
        let list = || d.alternatives.iter().filter(|a| (a.kind == Kind::Noise) == noise);
        let sum: f64 = list().map(|a| a.weight).sum();
        ((1.0 - sum).max(0.0) * own + list().map(of).sum::<f64>()) / sum.max(1.0)
    };
    let same_gain = mean(mean(own, true), false);
    let gain = d.free_gain.as_ref().map(|g| &g.alternative);
    gain.map_or(same_gain, |a| (1.0 - a.weight) * same_gain + of(a))
}

/// Whether a fit gives a loss that differs from that of the chosen fit by more than its errors.
pub(super) fn moves_a_loss(
    d: &FittedModels,
    a: &Alternative,
    chosen: &ModelFit,
    criteria: &Criteria,
) -> bool {
    [DELTA, X_F].into_iter().any(|k| {
        let apart = a.fit.bounded.parameters[k] - chosen.bounded.parameters[k];
        apart.abs() > criteria.answer.rival_errors * d.comparison.noise.std_error(&chosen.unbounded, k)
    })
}

/// Other terms apart from the losses that explain the curve as well as the reported ones and change the losses: their
/// fit, the difference of BIC, and the friction displacement with them.
pub(super) fn rival<'a>(
    d: &'a FittedModels,
    chosen: &ModelFit,
    criteria: &Criteria,
) -> Option<(&'a OtherFit, f64, [f64; 2])> {
    let noise = d.comparison.noise;
    let close = d
        .alternatives
        .iter()
        .filter(|a| a.delta_bic < criteria.report.rival_bic && moves_a_loss(d, a, chosen, criteria));
    let best = close.min_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))?;
    Some((&best.fit, best.delta_bic, estimate(&best.fit, noise, &|p| p[X_F])))
}

#[cfg(test)]
mod tests {
    use super::remaining_weight;

    /// Odds of 10 for an absent loss, 4 for other terms.
    #[test]
    fn rivals_are_each_weighed_against_the_fit_reported() {
        let (absence, terms) = (10.0 / 11.0, 4.0 / 5.0);
        assert!((terms * remaining_weight(absence, terms) - 4.0 / 15.0).abs() < 1e-12);
        assert_eq!(remaining_weight(0.0, terms), 1.0);
        assert_eq!(remaining_weight(1.0, 1.0), 0.0);
    }
}

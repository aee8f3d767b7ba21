//! Intervals that count the choice of the instrument's terms.

use super::alternatives::{Alternative, InstrumentSet, OtherFit};
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::response::{DELTA, OMEGA, X_0, X_F};
use crate::Quantity;
use crate::inference::Z_95;
use crate::inference::least_squares::Fit;
use crate::inference::model_selection::ModelFit;
use crate::inference::noise::NoiseModel;
use crate::numeric::roots::root;
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// Value and standard error of a function of the oscillator's parameters by a fit.
pub(super) fn estimate(fit: &OtherFit, noise: NoiseModel, of: &dyn Fn(&[f64]) -> f64) -> [f64; 2] {
    let p = &fit.bounded.parameters;
    let std_error = (variance_of(&fit.unbounded, p, of) * noise.variance(&fit.bounded)).sqrt();
    [of(p), std_error]
}

/// By first-order propagation, over the variance of one observation; slopes at `p`.
fn variance_of(fit: &Fit, p: &[f64], of: &dyn Fn(&[f64]) -> f64) -> f64 {
    let slopes: Vec<(usize, f64)> = fit
        .free
        .iter()
        .filter(|&&k| [OMEGA, DELTA, X_0, X_F].contains(&k))
        .map(|&k| {
            let error = fit.unit_std(k).max(1e-9 * p[k].abs());
            // No loss below zero; a shift of the frequency has no such side.
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

/// The interval stretched over those of all minima that explain the data as well, and by what other
/// terms of the instrument would give: the end beyond which the tails of all estimates, each by its
/// weight, hold 2.5 % (Turek and Fletcher 2012, Computational Statistics and Data Analysis 56, 2809).
pub(super) fn stretched(d: &FittedModels, mut q: Quantity, of: &dyn Fn(&[f64]) -> f64) -> Quantity {
    let noise = d.comparison.noise;
    let before = q.interval_95;
    if d.minima.len() > 1 {
        for fit in &d.minima {
            let p = &fit.parameters;
            let half = Z_95 * (variance_of(fit, p, of) * noise.variance(fit)).sqrt();
            if half.is_finite() {
                q.interval_95[0] = q.interval_95[0].min((of(p) - half).max(0.0));
                q.interval_95[1] = q.interval_95[1].max(of(p) + half);
            }
        }
    }
    let others: Vec<(f64, [f64; 2])> = d
        .alternatives
        .iter()
        .map(|a| (a.weight, estimate(&a.fit, noise, of)))
        .filter(|(_, [value, error])| value.is_finite() && error.is_finite() && *error > 0.0)
        .collect();
    if !others.is_empty() && q.interval_95[1].is_finite() {
        q.interval_95 = averaged(&q, &others);
    }
    if q.interval_95 != before {
        q.std_error = q.std_error.max((q.interval_95[1] - q.interval_95[0]) / (2.0 * Z_95));
    }
    q
}

/// Where the tails of an estimate and others, each with weight, value and error, hold 2.5 % together;
/// not inside the interval of the estimate itself.
fn averaged(q: &Quantity, others: &[(f64, [f64; 2])]) -> [f64; 2] {
    let own = 1.0 - others.iter().map(|o| o.0).sum::<f64>();
    let [low, high] = q.interval_95;
    let end = |side: f64, end: f64| {
        // Normal tails, each half with the width that its end has.
        let width = side * (end - q.value) / Z_95;
        let tail = |at: f64| {
            let beyond = |value: f64, width: f64| 0.5 * erfc(side * (at - value) / (width * SQRT_2));
            let mine = if width > 0.0 { own * beyond(q.value, width) } else { 0.0 };
            mine + others.iter().map(|(w, [value, error])| w * beyond(*value, *error)).sum::<f64>()
        };
        let ends = others.iter().map(|(_, [value, error])| value + side * Z_95 * error);
        let far = side * ends.map(|e| side * e).fold(side * end, f64::max);
        if far == end || tail(end) <= 0.025 { end } else { root(end, far, |at| tail(at) - 0.025) }
    };
    let (lower, upper) = (end(-1.0, low), end(1.0, high));
    let lower = if low >= 0.0 { lower.max(0.0) } else { lower };
    [lower.min(low), upper.max(high)]
}

/// p value of sliding friction with the other fits counted: the mean of what each says.
pub(super) fn sliding_p_value(d: &FittedModels, own: f64) -> f64 {
    let noise = d.comparison.noise;
    let of = |a: &Alternative| {
        let fit = &a.fit.unbounded;
        let z = fit.parameters[X_F] / noise.std_error(fit, X_F);
        if z.is_finite() { a.weight * 0.5 * erfc(z / SQRT_2) } else { a.weight }
    };
    let rest: f64 = d.alternatives.iter().map(|a| a.weight).sum();
    (1.0 - rest) * own + d.alternatives.iter().map(of).sum::<f64>()
}

/// Other terms of the instrument that explain the curve as well as those reported, and move the
/// losses: the terms, the difference of BIC, and the friction displacement with them.
pub(super) fn rival(
    d: &FittedModels,
    chosen: &ModelFit,
    criteria: &Criteria,
) -> Option<(InstrumentSet, f64, [f64; 2])> {
    let noise = d.comparison.noise;
    let moved = |a: &Alternative| {
        [DELTA, X_F].into_iter().any(|k| {
            let apart = a.fit.bounded.parameters[k] - chosen.bounded.parameters[k];
            apart.abs() > criteria.answer.rival_errors * noise.std_error(&chosen.unbounded, k)
        })
    };
    let close = d.alternatives.iter().filter(|a| a.delta_bic < criteria.report.rival_bic && moved(a));
    let best = close.min_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic))?;
    Some((best.fit.set, best.delta_bic, estimate(&best.fit, noise, &|p| p[X_F])))
}

//! Minima with a background under amplitudes: it may lie on either side of the peak, and much of it
//! looks like friction.

use super::criteria::{Criteria, TermCriteria};
use super::peak::Peak;
use super::problem::Problem;
use super::residuals::autocorrelation;
use super::response::{BG_IM, BG_RE, DELTA, R_OMEGA, X_0, X_F};
use super::search::{best_of, thinned};
use super::start;
use crate::inference::least_squares::{Fit, LeastSquares, by_rss, minimise};
use crate::motion::steady::Phasor;
use std::f64::consts::FRAC_PI_4;

/// Backgrounds tried, over the height of the peak; each at eight angles.
const SIZES: [f64; 3] = [0.04, 0.2, 0.6];
/// Starts that are followed for each of them.
const TRIES: usize = 2;

/// Every minimum from the fit without a background and from backgrounds all round, the best first.
pub(super) fn background_minima(
    problem: &Problem,
    fit: &Fit,
    peak: &Peak,
    free: &[usize],
    criteria: &Criteria,
) -> Vec<Fit> {
    let few = thinned(problem, criteria.terms.background_points, &criteria.search);
    let coarse = few.as_ref().unwrap_or(problem);
    let mut from = vec![fit.parameters.clone()];
    let fixed: Vec<usize> = free.iter().copied().filter(|k| ![BG_RE, BG_IM].contains(k)).collect();
    let known = (!free.contains(&X_0)).then(|| fit.parameters[X_0]);
    let mut oscillators: Vec<Vec<f64>> =
        start::grid(peak, 0.0, known).iter().map(|s| start::parameters(s, known)).collect();
    oscillators.push(fit.parameters.clone());
    for p in &mut oscillators {
        p[R_OMEGA..].copy_from_slice(&fit.parameters[R_OMEGA..]);
    }
    for size in SIZES {
        for eighth in 0..8 {
            let b = Phasor::from_polar(size * peak.height, FRAC_PI_4 * f64::from(eighth));
            for p in &mut oscillators {
                (p[BG_RE], p[BG_IM]) = (b.re, b.im);
            }
            let best = best_of(coarse, &oscillators, &fixed, TRIES, &criteria.search);
            from.extend(best.map(|f| f.parameters));
        }
    }
    let kept = criteria.terms.kept_minima;
    let mut minima = distinct(coarse, from, peak, free, &criteria.terms);
    if few.is_some() {
        by_rss(minima.get_mut(1..).unwrap_or_default());
        minima.truncate(1 + kept);
        let from = minima.into_iter().map(|m| m.parameters).collect();
        minima = distinct(problem, from, peak, free, &criteria.terms);
    }
    let near = minima.first().cloned();
    by_rss(&mut minima);
    // Where the best leaves more than noise, a far one may only make up for what the law lacks.
    let correlated = |m: &Fit| autocorrelation(problem, m, &criteria.residuals).variance_inflation > 1.0;
    if minima.first().is_some_and(correlated) {
        return near.into_iter().collect();
    }
    minima.truncate(kept);
    minima
}

/// Where these lead, each minimum once; no loss below zero but from the first.
fn distinct(
    problem: &Problem,
    from: Vec<Vec<f64>>,
    peak: &Peak,
    free: &[usize],
    c: &TermCriteria,
) -> Vec<Fit> {
    let mut minima: Vec<Fit> = Vec::new();
    for p in from {
        let Some(f) = minimise(problem, &p, free) else { continue };
        let apart = |m: &Fit| {
            [X_F, BG_RE, BG_IM].into_iter().any(|k| {
                let error = (m.unit_std(k).powi(2) * m.rss / problem.observations()).sqrt();
                let least = c.distinct_errors * error.max(1e-9 * peak.height);
                (m.parameters[k] - f.parameters[k]).abs() > least
            })
        };
        let physical = f.parameters[X_F] >= 0.0 && f.parameters[DELTA] >= 0.0;
        if (physical || minima.is_empty()) && minima.iter().all(apart) {
            minima.push(f);
        }
    }
    minima
}

//! Residuals of a fit: Rice noise, outliers, autocorrelation.

use super::criteria::ResidualCriteria;
use super::problem::Problem;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::noise::{NoiseModel, ar1_variance_inflation};
use crate::motion::steady::Phasor;

/// Variance of a point with precision one.
pub(super) fn variance(problem: &Problem, fit: &Fit) -> f64 {
    fit.rss / (problem.observations() - fit.free.len() as f64).max(1.0)
}

/// Sets the Rice noise and the corresponding weights.
pub(super) fn set_rice(problem: &mut Problem, p: &[f64], variance: f64, c: &ResidualCriteria) {
    let n = problem.main.len();
    // Noise larger than the lowest amplitudes cannot be Rice noise.
    let mut low: Vec<f64> = (0..n).map(|i| problem.main.data[i].re).collect();
    low.sort_by(f64::total_cmp);
    problem.main.rice = variance.min(low[(n / c.rice_part.max(1)).min(n - 1)].powi(2));
    for (i, modelled) in problem.predict(p, false).into_iter().enumerate() {
        if problem.main.weight[i] > 0.0
            && let Some(m) = modelled
        {
            problem.main.weight[i] = problem.main.rice_weight(m.size(), i);
        }
    }
}

/// Fits amplitudes with Rice noise, whose size is taken from the previous fit.
pub(super) fn refit_with_rice(problem: &mut Problem, fit: &mut Fit, free: &[usize], c: &ResidualCriteria) {
    const ROUNDS: usize = 2;
    if problem.main.complex {
        return;
    }
    for _ in 0..ROUNDS {
        let variance = variance(problem, fit);
        set_rice(problem, &fit.parameters, variance, c);
        if let Some(better) = minimise(problem, &fit.parameters, free) {
            *fit = better;
        }
    }
}

/// Excludes single points far from the curve from the sums; returns their number.
pub(super) fn drop_outliers(problem: &mut Problem, p: &[f64], noise: f64, c: &ResidualCriteria) -> usize {
    let n = problem.main.len();
    if n < c.outlier_points {
        return 0;
    }
    let sizes: Vec<f64> = problem
        .residuals(p)
        .into_iter()
        .zip(&problem.main.precision)
        .map(|(r, precision)| r.map_or(0.0, |r| r.norm() * precision.sqrt()))
        .collect();
    let mut sorted = sizes.clone();
    sorted.sort_by(f64::total_cmp);
    // Median of |r|: 0.6745 sigma for one, 1.177 sigma for two quadratures.
    let sigma = sorted[n / 2] / if problem.main.complex { 1.177 } else { 0.6745 };
    let limit = c.outlier_deviations * sigma.max(noise);
    let far: Vec<usize> = (0..n)
        .filter(|&i| sizes[i] > limit)
        .filter(|&i| {
            let near = |j: usize| sizes.get(j).is_some_and(|s| *s > c.outlier_neighbour * limit);
            !(near(i + 1) || (i > 0 && near(i - 1)))
        })
        .collect();
    if far.len() * c.outlier_part > n {
        return 0;
    }
    for &i in &far {
        problem.main.weight[i] = 0.0;
    }
    far.len()
}

/// Lag-one autocorrelation of the residuals along the frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Autocorrelation {
    pub(super) rho: f64,
    /// Noise of one point from differences between the residuals of neighbours.
    pub(super) neighbour_noise: f64,
    /// Variance inflation; 1 if the autocorrelation is not significant.
    pub(super) variance_inflation: f64,
}

pub(super) fn autocorrelation(problem: &Problem, fit: &Fit, c: &ResidualCriteria) -> Autocorrelation {
    let b = &problem.main;
    let r: Vec<Phasor> = problem
        .predict(&fit.parameters, false)
        .into_iter()
        .enumerate()
        .filter(|&(i, _)| b.weight[i] > 0.0)
        .filter_map(|(i, m)| {
            let m = m?;
            let r = b.residual(i, &m) * b.precision[i].sqrt();
            // Along and perpendicular to the fitted phase, which rotates through the peak.
            Some(if b.complex && m.value.norm() > 0.0 { r * m.value.conj() / m.value.norm() } else { r })
        })
        .collect();
    // Rounding counts as white noise, whatever its effect on these residuals.
    let rounding = b.rounding();
    let square: f64 = rounding + r.iter().map(Phasor::norm_sqr).sum::<f64>();
    if r.len() < 5 || !(square > 0.0) {
        let neighbour_noise = square.max(0.0).sqrt();
        return Autocorrelation { rho: 0.0, neighbour_noise, variance_inflation: 1.0 };
    }
    let product: f64 = r.windows(2).map(|w| w[0].re * w[1].re + w[0].im * w[1].im).sum();
    let difference = 2.0 * rounding + r.windows(2).map(|w| (w[1] - w[0]).norm_sqr()).sum::<f64>();
    let per = if b.complex { 2.0 } else { 1.0 };
    let count = per * (r.len() - 1) as f64;
    let rho = product / square;
    let neighbour_noise = (0.5 * difference / count).sqrt();
    // Fitting reduces the correlation by about half the ratio of the numbers of parameters and points.
    let corrected = rho + fit.free.len() as f64 / (per * r.len() as f64) * 0.5;
    let significant = rho * count.sqrt() > c.autocorrelation_errors;
    let variance_inflation = if significant { ar1_variance_inflation(corrected) } else { 1.0 };
    Autocorrelation { rho, neighbour_noise, variance_inflation }
}

/// The noise model estimated from the residuals, including their autocorrelation.
pub(super) fn noise_model(problem: &Problem, fit: &Fit, c: &ResidualCriteria) -> NoiseModel {
    let variance_inflation = autocorrelation(problem, fit, c).variance_inflation;
    NoiseModel { variance_inflation, ..NoiseModel::white(problem.observations()) }
}

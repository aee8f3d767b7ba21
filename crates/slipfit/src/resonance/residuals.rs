//! What a fit leaves: Rice's noise, points far off, residuals that hang together.

use super::problem::Problem;
use crate::inference::least_squares::{Fit, LeastSquares};
use crate::inference::noise::{NoiseModel, ar1_variance_inflation};
use crate::motion::steady::Phasor;

/// Variance of a point of precision one.
pub(super) fn variance(problem: &Problem, fit: &Fit) -> f64 {
    fit.rss / (problem.observations() - fit.free.len() as f64).max(1.0)
}

/// The noise as the residuals give it, none of it known beforehand.
pub(super) fn plain_scale(problem: &Problem) -> NoiseModel {
    NoiseModel::white(problem.observations())
}

/// Sets Rice's noise and the weights that go with it.
pub(super) fn settle_rice(problem: &mut Problem, p: &[f64], variance: f64) {
    let n = problem.main.len();
    // Noise above the lowest amplitudes read is none of Rice's.
    let mut low: Vec<f64> = (0..n).map(|i| problem.main.data[i].re).collect();
    low.sort_by(f64::total_cmp);
    problem.main.rice = variance.min(low[n / 10].powi(2));
    for (i, modelled) in problem.predict(p, false).into_iter().enumerate() {
        if problem.main.weight[i] > 0.0
            && let Some(m) = modelled
        {
            problem.main.weight[i] = problem.main.rice_weight(m.value.norm(), i);
        }
    }
}

/// Takes single points far off out of the sums; how many.
pub(super) fn leave_out(problem: &mut Problem, p: &[f64], noise: f64) -> usize {
    const FAR: f64 = 7.0;
    let n = problem.main.len();
    if n < 20 {
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
    let limit = FAR * sigma.max(noise);
    let far: Vec<usize> = (0..n)
        .filter(|&i| sizes[i] > limit)
        .filter(|&i| {
            let near = |j: usize| sizes.get(j).is_some_and(|s| *s > 0.5 * limit);
            !(near(i + 1) || (i > 0 && near(i - 1)))
        })
        .collect();
    if far.len() * 20 > n {
        return 0;
    }
    for &i in &far {
        problem.main.weight[i] = 0.0;
    }
    far.len()
}

/// First autocorrelation of the residuals, the noise between neighbours, and the factor on
/// variances that follows.
pub(super) fn autocorrelation_of(problem: &Problem, fit: &Fit) -> (f64, f64, f64) {
    let b = &problem.main;
    let r: Vec<Phasor> = problem
        .predict(&fit.parameters, false)
        .into_iter()
        .enumerate()
        .filter(|&(i, _)| b.weight[i] > 0.0)
        .filter_map(|(i, m)| {
            let m = m?;
            let r = b.residual(i, m.value) * b.precision[i].sqrt();
            // Along and across the fitted phase, which turns through the line.
            Some(if b.complex && m.value.norm() > 0.0 { r * m.value.conj() / m.value.norm() } else { r })
        })
        .collect();
    let square: f64 = r.iter().map(Phasor::norm_sqr).sum();
    if r.len() < 5 || !(square > 0.0) {
        return (0.0, square.max(0.0).sqrt(), 1.0);
    }
    let product: f64 = r.windows(2).map(|w| w[0].re * w[1].re + w[0].im * w[1].im).sum();
    let difference: f64 = r.windows(2).map(|w| (w[1] - w[0]).norm_sqr()).sum();
    let per = if b.complex { 2.0 } else { 1.0 };
    let count = per * (r.len() - 1) as f64;
    let rho = product / square;
    let noise = (0.5 * difference / count).sqrt();
    // Fitting takes correlation away: about the number of parameters over that of points.
    let mended = rho + fit.free.len() as f64 / (per * r.len() as f64) * 0.5;
    let sure = rho * count.sqrt() > 2.8;
    let widening = if sure { ar1_variance_inflation(mended) } else { 1.0 };
    (rho, noise, widening)
}

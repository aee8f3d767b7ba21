//! Smoothing: many small parameters with a common spread that is estimated from the data.
//!
//! A curve of arbitrary shape is described by a straight line and many deviations from it. If the deviations are draws
//! from one normal distribution of spread `tau`, the fit has a penalty on their squares,
//! `lambda = variance of the noise / tau²`, and `tau` is estimated by restricted likelihood (Wahba 1985, Annals of
//! Statistics 13, 1378). The posterior covariance covers the true curve on average over the curve (Nychka 1988, Journal
//! of the American Statistical Association 83, 1134).

use super::least_squares::{Fit, LeastSquares, Normal, log_determinant, minimise};
use super::model_average::ModelWeights;
use nalgebra::DMatrix;
use std::ops::Range;

/// Range of penalties tried, in decades relative to the mean information of the data on one deviation.
const LARGEST_DECADE: f64 = 3.0;
const SMALLEST_DECADE: f64 = -9.0;
/// Penalties per decade.
const PER_DECADE: f64 = 3.0;
/// Excess of the deviance over its minimum above which smaller penalties are not tried.
const FAR: f64 = 40.0;

/// A smooth fit, averaged over the spreads that the data allow.
#[derive(Debug, Clone)]
pub(crate) struct Smoothed {
    /// Mean of the parameters.
    pub(crate) parameters: Vec<f64>,
    /// Their covariance, including the uncertainty of the spread and the variance of the noise.
    pub(crate) covariance: DMatrix<f64>,
    /// Effective number of deviations determined by the data.
    pub(crate) effective: f64,
}

/// A problem with a penalty on the squares of some parameters.
struct Ridge<'a> {
    problem: &'a dyn LeastSquares,
    deviations: Range<usize>,
    penalty: f64,
}

impl LeastSquares for Ridge<'_> {
    fn parameters(&self) -> usize {
        self.problem.parameters()
    }

    fn observations(&self) -> f64 {
        self.problem.observations()
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        if !self.problem.normal(p, out) {
            return false;
        }
        for k in self.deviations.clone() {
            out.jtj[(k, k)] += self.penalty;
            out.jtr[k] -= self.penalty * p[k];
            out.rss += self.penalty * p[k] * p[k];
        }
        out.rss.is_finite()
    }
}

/// One spread: the fit, the noise variance for it, and minus twice its restricted log-likelihood.
struct Tried {
    fit: Fit,
    penalty: f64,
    variance: f64,
    deviance: f64,
}

/// Fits all parameters, those in `deviations` with a common spread. The fits for the spreads tried are averaged by
/// their restricted likelihood with a prior uniform in the logarithm of the spread; the most likely spread alone would
/// treat an undetected curve as absent. A prior uniform in the spread itself (Gelman 2006, Bayesian Analysis 1, 515)
/// gives wider bands that cover no more curves.
///
/// `least_variance`: lower limit of the variance of one weighted observation, known from elsewhere. `None` if there is
/// no fit without deviations, or fewer observations than parameters without a spread.
#[inline(never)]
pub(crate) fn smooth(
    problem: &dyn LeastSquares,
    start: &[f64],
    deviations: Range<usize>,
    least_variance: f64,
) -> Option<Smoothed> {
    let all: Vec<usize> = (0..problem.parameters()).collect();
    let straight: Vec<usize> = all.iter().copied().filter(|k| !deviations.contains(k)).collect();
    let spare = problem.observations() - straight.len() as f64;
    if spare < 1.0 || deviations.is_empty() {
        return None;
    }
    let line = minimise(problem, start, &straight)?;
    let mut sums = Normal::zeros(problem.parameters());
    if !problem.normal(&line.parameters, &mut sums) {
        return None;
    }
    let information: f64 = deviations.clone().map(|k| sums.jtj[(k, k)]).sum();
    let information = information / deviations.len() as f64;
    let mut tried: Vec<Tried> = Vec::new();
    let mut from = line.parameters;
    let count = ((LARGEST_DECADE - SMALLEST_DECADE) * PER_DECADE) as u32;
    for i in 0..=count {
        let penalty = information * 10f64.powf(LARGEST_DECADE - f64::from(i) / PER_DECADE);
        let ridge = Ridge { problem, deviations: deviations.clone(), penalty };
        let Some(fit) = minimise(&ridge, &from, &all) else { continue };
        if !ridge.normal(&fit.parameters, &mut sums) {
            continue;
        }
        let Some(log_determinant) = log_determinant(&sums, &all) else { continue };
        let variance = (fit.rss / spare).max(least_variance).max(f64::MIN_POSITIVE);
        let deviance = spare * variance.ln() + fit.rss / variance + log_determinant
            - deviations.len() as f64 * penalty.ln();
        from.clone_from(&fit.parameters);
        let lowest = tried.iter().map(|t| t.deviance).fold(deviance, f64::min);
        tried.push(Tried { fit, penalty, variance, deviance });
        if deviance > lowest + FAR {
            break;
        }
    }
    average(&tried, deviations)
}

/// Mean and covariance averaged over the spreads tried.
fn average(tried: &[Tried], deviations: Range<usize>) -> Option<Smoothed> {
    if tried.is_empty() {
        return None;
    }
    let weights = ModelWeights::new(tried.iter().map(|t| [1.0, t.deviance]));
    let (parameters, covariance) = weights
        .moments(|t| &tried[t].fit.parameters, |t, at| tried[t].variance * tried[t].fit.unit_covariance[at]);
    let effective = weights.mean(|t| {
        let Tried { fit, penalty, .. } = &tried[t];
        let free: f64 = deviations.clone().map(|k| 1.0 - penalty * fit.unit_covariance[(k, k)]).sum();
        free.max(0.0)
    });
    covariance.iter().all(|c| c.is_finite()).then_some(Smoothed { parameters, covariance, effective })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    /// A straight line with changes of slope at fixed points.
    struct Bent {
        x: Vec<f64>,
        y: Vec<f64>,
    }

    const BENDS: usize = 20;

    fn row(x: f64) -> Vec<f64> {
        let bend = |k: usize| (x - k as f64 / BENDS as f64).max(0.0) * (BENDS as f64).sqrt();
        [1.0, x].into_iter().chain((0..BENDS).map(bend)).collect()
    }

    impl LeastSquares for Bent {
        fn parameters(&self) -> usize {
            2 + BENDS
        }

        fn observations(&self) -> f64 {
            self.x.len() as f64
        }

        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            for (x, y) in self.x.iter().zip(&self.y) {
                let row = row(*x);
                let model: f64 = row.iter().zip(p).map(|(r, p)| r * p).sum();
                out.add_row(&row, y - model, 1.0);
            }
            true
        }
    }

    fn of(shape: impl Fn(f64) -> f64, noise: f64, seed: usize) -> (Smoothed, f64) {
        let x: Vec<f64> = (0..200).map(|i| f64::from(i) / 200.0).collect();
        let y = x.iter().enumerate().map(|(i, x)| shape(*x) + noise * jitter(i + 1000 * seed, 3)).collect();
        let problem = Bent { x, y };
        let found = smooth(&problem, &[0.0; 2 + BENDS], 2..2 + BENDS, 0.0).unwrap();
        let inside = problem.x.iter().filter(|x| {
            let row = row(**x);
            let dot = |v: &[f64]| row.iter().zip(v).map(|(r, v)| r * v).sum::<f64>();
            let variance: f64 = (0..row.len())
                .flat_map(|i| (0..row.len()).map(move |j| (i, j)))
                .map(|(i, j)| row[i] * row[j] * found.covariance[(i, j)])
                .sum();
            (dot(&found.parameters) - shape(**x)).abs() < 1.96 * variance.sqrt()
        });
        let share = inside.count() as f64 / 200.0;
        (found, share)
    }

    #[test]
    fn a_line_needs_no_bends_and_a_wave_many() {
        let (line, _) = of(|x| 1.0 + 2.0 * x, 0.1, 0);
        assert!(line.effective < 2.0, "{}", line.effective);
        let (wave, _) = of(|x| (9.0 * x).sin(), 0.1, 0);
        assert!(wave.effective > 5.0, "{}", wave.effective);
        assert!(wave.effective < BENDS as f64, "{}", wave.effective);
    }

    #[test]
    fn the_band_holds_the_curve_on_the_average_over_it() {
        for shape in [|x: f64| 1.0 + 2.0 * x, |x: f64| (6.0 * x).sin(), |x: f64| x * x] {
            let shares: Vec<f64> = (0..40).map(|seed| of(shape, 0.1, seed).1).collect();
            let mean = shares.iter().sum::<f64>() / shares.len() as f64;
            assert!(mean > 0.9, "{mean}");
        }
    }

    #[test]
    fn noise_free_data_are_followed_exactly() {
        let (found, _) = of(|x| 1.0 + 2.0 * x, 0.0, 0);
        assert!((found.parameters[0] - 1.0).abs() < 1e-6, "{:?}", found.parameters);
    }
}

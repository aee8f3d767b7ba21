//! Damped Gauss-Newton method on normal equations accumulated by the model.

use super::covariance::Covariance;
use super::limited_step::Limits;
use super::normal::{invert, solve};
use crate::numeric::order::sort_by_value;
use nalgebra::{DMatrix, SymmetricEigen};

pub(crate) use super::normal::{LeastSquares, Normal, log_determinant, newton_step, predicted_gain};

/// Result of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) parameters: Vec<f64>,
    /// `(JᵀJ)⁻¹`, not yet scaled by the noise variance.
    pub(crate) unit_covariance: Covariance,
    pub(crate) rss: f64,
    pub(crate) free: Vec<usize>,
    pub(crate) converged: bool,
}

/// Sorts fits by their sums of squares in ascending order.
pub(crate) fn by_rss(fits: &mut [Fit]) {
    sort_by_value(fits, |f| f.rss);
}

impl Fit {
    pub(crate) fn unit_std(&self, parameter: usize) -> f64 {
        self.unit_covariance[(parameter, parameter)].max(0.0).sqrt()
    }

    pub(crate) fn correlation(&self, a: usize, b: usize) -> f64 {
        let scale = self.unit_std(a) * self.unit_std(b);
        if scale > 0.0 { self.unit_covariance[(a, b)] / scale } else { 0.0 }
    }

    /// Steps of all parameters along the principal axes of the correlation matrix, each one standard error long at unit
    /// variance: the covariance is the sum of their outer products.
    pub(crate) fn principal_steps(&self) -> Vec<Vec<f64>> {
        let free = &self.free;
        let correlation = DMatrix::from_fn(free.len(), free.len(), |a, b| self.correlation(free[a], free[b]));
        let axes = SymmetricEigen::new(correlation);
        let along = |axis: usize| {
            let length = axes.eigenvalues[axis].max(0.0).sqrt();
            let mut step = vec![0.0; self.parameters.len()];
            for (a, &k) in free.iter().enumerate() {
                step[k] = length * self.unit_std(k) * axes.eigenvectors[(a, axis)];
            }
            step
        };
        (0..free.len()).map(along).collect()
    }
}

const MAX_STEPS: usize = 40;
/// A step is small enough if it changes no parameter by more than this fraction of its standard error, far below what
/// the data can resolve.
pub(crate) const STEP_TOLERANCE: f64 = 3e-3;

/// Minimises `rᵀr` over the `free` parameters from `start`.
///
/// `None` if the model does not exist at `start` or a free parameter has no influence.
pub(crate) fn minimise(problem: &dyn LeastSquares, start: &[f64], free: &[usize]) -> Option<Fit> {
    minimise_until(problem, start, free, STEP_TOLERANCE, false)
}

/// [`minimise`] to within `tolerance` standard errors. With `take_last` the final step is applied without evaluating
/// the model there: the error is of second order, and a pass over the data is saved.
pub(crate) fn minimise_until(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    tolerance: f64,
    take_last: bool,
) -> Option<Fit> {
    let found = descend(problem, start, free, tolerance, take_last)?;
    fit_at(found, free)
}

/// [`minimise`] for the sum of squares alone: a step that is small only because of the damping also ends the search,
/// which avoids many small steps along an edge of the model.
pub(crate) fn minimise_roughly(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    tolerance: f64,
) -> Option<Fit> {
    let found = descend_until(problem, start, free, &[], tolerance, Ending::Damped)?;
    fit_at(found, free)
}

/// [`minimise`] from a start near the minimum: a first step below [`NEAR`] standard errors, or one that reduces the sum
/// of squares by no more than `most`, is applied without evaluating the model there; the error is of second order.
pub(crate) fn minimise_near(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    tolerance: f64,
    most: f64,
) -> Option<Fit> {
    let mut sums = Normal::zeros(problem.parameters());
    let limits = Limits::of(problem, free, &[]);
    let start = &limits.within(start)[..];
    if !problem.normal_of(start, free, &mut sums, f64::INFINITY) {
        return None;
    }
    let (step, predicted) = limits.step(start, &sums, 0.0)?;
    let there = stepped(start, free, &step);
    let near = predicted <= most.max(NEAR * NEAR * sums.rss / problem.observations().max(1.0));
    if !(near && there.iter().all(|v| v.is_finite())) {
        return minimise_until(problem, start, free, tolerance, true);
    }
    sums.rss -= predicted;
    fit_at((there, sums, true), free)
}

/// Standard errors.
const NEAR: f64 = 0.3;

pub(crate) fn fit_at((parameters, sums, converged): (Vec<f64>, Normal, bool), free: &[usize]) -> Option<Fit> {
    let unit_covariance = invert(&sums, free, parameters.len())?;
    Some(Fit { parameters, unit_covariance, rss: sums.rss, free: free.to_vec(), converged })
}

/// Treatment of the small step that ends a search.
#[derive(Clone, Copy, PartialEq)]
enum Ending {
    /// The step is not taken.
    Left,
    /// The step is taken without evaluating the model.
    Taken,
    /// The step is taken; a step that is small only because of the damping ends the search but is not taken.
    Damped,
}

/// [`minimise_until`] without the covariance: parameters, the sums there, and whether the search converged.
pub(crate) fn descend(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    tolerance: f64,
    take_last: bool,
) -> Option<(Vec<f64>, Normal, bool)> {
    let ending = if take_last { Ending::Taken } else { Ending::Left };
    descend_until(problem, start, free, &[], tolerance, ending)
}

/// [`descend`] with the parameters in `non_negative` kept at zero or above; the last step is taken.
pub(crate) fn descend_within(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    non_negative: &[usize],
    tolerance: f64,
) -> Option<(Vec<f64>, Normal, bool)> {
    descend_until(problem, start, free, non_negative, tolerance, Ending::Taken)
}

/// Smallest significant decrease of the sum of squares by a step, in rounding variances of one observation.
const WITHIN_ROUNDING: f64 = 10.0;

fn descend_until(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    non_negative: &[usize],
    tolerance: f64,
    ending: Ending,
) -> Option<(Vec<f64>, Normal, bool)> {
    let p = problem.parameters();
    let limits = Limits::of(problem, free, non_negative);
    let mut best = limits.within(start);
    let mut sums = Normal::zeros(p);
    if !problem.normal_of(&best, free, &mut sums, f64::INFINITY) || !sums.rss.is_finite() {
        return None;
    }
    let mut trial_sums = Normal::zeros(p);
    let mut damping = 0.0;
    let mut converged = false;
    let mut moved = false;
    for _ in 0..MAX_STEPS {
        let Some((step, predicted)) = limits.step(&best, &sums, damping) else {
            if damping > 1e10 {
                break;
            }
            damping = if damping == 0.0 { 1e-6 } else { damping * 10.0 };
            continue;
        };
        // Decrease of rss predicted by the quadratic model, in units of the noise variance.
        let noise = sums.rss / problem.observations().max(1.0);
        let rounding = WITHIN_ROUNDING * problem.rounding() / problem.observations().max(1.0);
        let least = (tolerance * tolerance * noise).max(1e-15 * sums.rss).max(rounding);
        let negligible = predicted <= least;
        let undamped = damping <= 1e-3;
        if negligible && (undamped || ending == Ending::Damped) {
            converged = true;
            let last = stepped(&best, free, &step);
            // If the start is a minimum with an edge, such as a stop between two samples, rounding decides on which
            // side of the edge the slope is evaluated. Therefore a step from the start is evaluated before it is taken.
            let mut downhill = || {
                let exists = problem.normal_of(&last, free, &mut trial_sums, sums.rss);
                exists && trial_sums.rss <= sums.rss
            };
            let taken = undamped && ending != Ending::Left && last.iter().all(|v| v.is_finite());
            if taken && (moved || downhill()) {
                best = last;
                sums.rss -= predicted;
            }
            break;
        }
        let trial = stepped(&best, free, &step);
        let exists = trial.iter().all(|v| v.is_finite())
            && problem.normal_of(&trial, free, &mut trial_sums, sums.rss * (1.0 + 1e-12));
        if exists && trial_sums.rss.is_finite() && trial_sums.rss <= sums.rss * (1.0 + 1e-13) {
            let gained = sums.rss - trial_sums.rss;
            best = trial;
            moved = true;
            std::mem::swap(&mut sums, &mut trial_sums);
            damping = if gained > 0.25 * predicted { damping * 0.1 } else { damping * 2.0 };
            if damping < 1e-9 {
                damping = 0.0;
            }
        } else {
            damping = if damping == 0.0 { 1e-3 } else { damping * 8.0 };
            if damping > 1e10 {
                // No downhill step at rounding level, so this is the minimum.
                converged = true;
                break;
            }
        }
    }
    Some((best, sums, converged))
}

fn stepped(from: &[f64], free: &[usize], step: &[f64]) -> Vec<f64> {
    let mut to = from.to_vec();
    for (&i, s) in free.iter().zip(step) {
        to[i] += s;
    }
    to
}

/// One step over all observations from the minimum of a subset of them, `part`, with its `sums` there. The error of the
/// step is estimated from the subset, whose gradient would change in proportion to the step for a linear model. `None`
/// if this estimate exceeds `tolerance` standard errors.
pub(crate) fn one_step(
    problem: &dyn LeastSquares,
    part: &dyn LeastSquares,
    sums: &Normal,
    start: &[f64],
    free: &[usize],
    tolerance: f64,
) -> Option<Fit> {
    let mut all = Normal::zeros(problem.parameters());
    if !problem.normal(start, &mut all) {
        return None;
    }
    let (step, gained) = solve(&all, free, 0.0)?;
    let parameters = stepped(start, free, &step);
    let mut there = Normal::zeros(problem.parameters());
    if !parameters.iter().all(|v| v.is_finite()) || !part.normal(&parameters, &mut there) {
        return None;
    }
    for &i in free {
        let foreseen: f64 = free.iter().zip(&step).map(|(&j, s)| sums.jtj[(i.max(j), i.min(j))] * s).sum();
        there.jtr[i] += foreseen;
    }
    let left = solve(&there, free, 0.0)?.1 * problem.observations() / part.observations();
    let rss = (all.rss - gained).max(0.0);
    let noise = rss / problem.observations();
    if !(left <= tolerance * tolerance * noise) {
        return None;
    }
    let unit_covariance = invert(&all, free, problem.parameters())?;
    Some(Fit { parameters, unit_covariance, rss, free: free.to_vec(), converged: true })
}

/// Weighted linear least squares: coefficients, `(XᵀWX)⁻¹` and the weighted sum of squares of the residuals.
pub(crate) fn linear(
    rows: impl Iterator<Item = (Vec<f64>, f64, f64)>,
    columns: usize,
) -> Option<(Vec<f64>, DMatrix<f64>, f64)> {
    let mut sums = Normal::zeros(columns);
    for (row, value, weight) in rows {
        sums.add_row(&row, value, weight);
    }
    linear_of(&sums, &(0..columns).collect::<Vec<usize>>())
}

/// The same for some of the columns, from their sums.
pub(crate) fn linear_of(sums: &Normal, columns: &[usize]) -> Option<(Vec<f64>, DMatrix<f64>, f64)> {
    let (step, gain) = solve(sums, columns, 0.0)?;
    let all = invert(sums, columns, sums.jtr.len())?;
    let covariance = DMatrix::from_fn(columns.len(), columns.len(), |i, j| all[(columns[i], columns[j])]);
    Some((step, covariance, (sums.rss - gain).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Exponential {
        t: Vec<f64>,
        y: Vec<f64>,
    }

    impl LeastSquares for Exponential {
        fn parameters(&self) -> usize {
            3
        }
        fn observations(&self) -> f64 {
            self.t.len() as f64
        }
        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            for (&t, &y) in self.t.iter().zip(&self.y) {
                let e = (-p[1] * t).exp();
                out.add_row(&[e, -p[0] * t * e, 1.0], y - (p[0] * e + p[2]), 1.0);
            }
            true
        }
    }

    #[test]
    fn finds_an_exponential_from_afar() {
        let t: Vec<f64> = (0..200).map(|i| i as f64 * 0.05).collect();
        let y = t.iter().map(|t| 3.0 * (-0.7 * t).exp() - 0.4).collect();
        let fit = minimise(&Exponential { t, y }, &[1.0, 0.1, 0.0], &[0, 1, 2]).expect("exists");
        assert!(fit.converged);
        for (found, truth) in fit.parameters.iter().zip([3.0, 0.7, -0.4]) {
            assert!((found - truth).abs() < 1e-9, "{found} for {truth}");
        }
    }

    /// Two lines that meet at an edge; the gradient at the edge is that of one of them.
    struct Edge {
        slope: f64,
    }

    impl LeastSquares for Edge {
        fn parameters(&self) -> usize {
            1
        }
        fn observations(&self) -> f64 {
            2.0
        }
        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            let side = if p[0] < 1.0 { -1.0 } else { 1.0 };
            out.add_row(&[-self.slope * side], 1.0 + self.slope * side * (p[0] - 1.0), 1.0);
            out.add_row(&[1.0], 1.0 - p[0], 1.0);
            true
        }
    }

    #[test]
    fn at_an_edge_no_step_is_taken_unseen() {
        for start in [1.0 - 1e-12, 1.0, 1.0 + 1e-12] {
            let fit = minimise_until(&Edge { slope: 0.01 }, &[start], &[0], 0.03, true).expect("exists");
            assert!(fit.converged && (fit.parameters[0] - 1.0).abs() < 1e-9, "{:?}", fit.parameters);
        }
    }

    #[test]
    fn a_parameter_without_influence_is_refused() {
        let problem = Exponential { t: vec![0.0; 5], y: vec![1.0; 5] };
        assert!(minimise(&problem, &[1.0, 0.5, 0.0], &[0, 1]).is_none());
    }
}

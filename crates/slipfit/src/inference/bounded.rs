//! Least squares with parameters that cannot be negative.

use super::least_squares::{Fit, LeastSquares, minimise_until};
use super::quadratic::given;

/// Minimises `rᵀr` over the `free` parameters with those of `non_negative` kept at zero or above, to
/// within `tolerance` standard errors: where the free minimum has one below, the lowest minimum with
/// such parameters on their limit.
pub(crate) fn minimise_bounded(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    non_negative: &[usize],
    tolerance: f64,
) -> Option<Fit> {
    let fit = minimise_until(problem, start, free, tolerance, true);
    let below: Vec<usize> = match &fit {
        Some(f) => non_negative.iter().copied().filter(|&i| f.parameters[i] < 0.0).collect(),
        None => non_negative.iter().copied().filter(|i| free.contains(i)).collect(),
    };
    if below.is_empty() {
        return fit;
    }
    let on_limit = |limit: usize| {
        let rest: Vec<usize> = free.iter().copied().filter(|&i| i != limit).collect();
        let search = |mut from: Vec<f64>| {
            from[limit] = 0.0;
            minimise_bounded(problem, &from, &rest, non_negative, tolerance)
        };
        // Far from the limit the plane through the minimum may lead nowhere.
        let near = fit.as_ref().and_then(|f| given(f, &[(limit, 0.0)])).and_then(|(_, near)| search(near));
        near.or_else(|| search(start.to_vec()))
    };
    below.into_iter().filter_map(on_limit).min_by(|a, b| a.rss.total_cmp(&b.rss))
}

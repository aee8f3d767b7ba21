//! Least squares with parameters that cannot be negative.

use super::least_squares::{Fit, LeastSquares, minimise_until};
use super::quadratic::given;
use crate::numeric::order::sort_by_value;

/// Minimises `rᵀr` over the `free` parameters with those of `non_negative` kept at zero or above, to
/// within `tolerance` standard errors: where the free minimum has one below, the lowest minimum with
/// such parameters on their limit.
///
/// Branch and bound: every further parameter on its limit raises the sum of squares, so that nothing is
/// searched below a minimum that is not lower than the best so far. The limit that costs least by the
/// quadratic form comes first.
pub(crate) fn minimise_bounded(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    non_negative: &[usize],
    tolerance: f64,
) -> Option<Fit> {
    let mut search = Search { problem, non_negative, tolerance, best: None, reached: Vec::new() };
    search.descend(start, free);
    search.best
}

struct Search<'a> {
    problem: &'a dyn LeastSquares,
    non_negative: &'a [usize],
    tolerance: f64,
    best: Option<Fit>,
    /// Sets of free parameters searched, and whether a minimum was reached.
    reached: Vec<(Vec<usize>, bool)>,
}

impl Search<'_> {
    /// Searches with these parameters free, and with more of them on their limit; whether there is a
    /// minimum.
    fn descend(&mut self, start: &[f64], free: &[usize]) -> bool {
        let fit = minimise_until(self.problem, start, free, self.tolerance, true);
        let is_lower = |f: &Fit| self.best.as_ref().is_none_or(|best| f.rss < best.rss);
        if fit.as_ref().is_some_and(|f| !is_lower(f)) {
            return true;
        }
        let non_negative = self.non_negative.iter().copied();
        let below: Vec<usize> = match &fit {
            Some(f) => non_negative.filter(|&i| f.parameters[i] < 0.0).collect(),
            None => non_negative.filter(|i| free.contains(i)).collect(),
        };
        if below.is_empty() {
            let exists = fit.is_some();
            self.best = fit.or_else(|| self.best.take());
            return exists;
        }
        let mut limits: Vec<(f64, usize, Option<Vec<f64>>)> = below
            .into_iter()
            .map(|limit| match fit.as_ref().and_then(|f| given(f, &[(limit, 0.0)])) {
                Some((rise, near)) => (rise, limit, Some(near)),
                None => (f64::INFINITY, limit, None),
            })
            .collect();
        sort_by_value(&mut limits, |l| l.0);
        let mut exists = false;
        for (_, limit, near) in limits {
            let rest: Vec<usize> = free.iter().copied().filter(|&i| i != limit).collect();
            let known = self.reached.iter().find(|(searched, _)| *searched == rest).map(|(_, found)| *found);
            let found = known.unwrap_or_else(|| {
                let mut from = |mut from: Vec<f64>| {
                    from[limit] = 0.0;
                    self.descend(&from, &rest)
                };
                // Far from the limit the plane through the minimum may lead nowhere.
                let found = near.is_some_and(&mut from) || from(start.to_vec());
                self.reached.push((rest, found));
                found
            });
            exists |= found;
        }
        exists
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::least_squares::{Normal, minimise};
    use std::cell::Cell;

    /// `y = sum_k p_k x_k` with correlated columns.
    struct Line {
        rows: Vec<([f64; 6], f64)>,
        passes: Cell<usize>,
    }

    impl LeastSquares for Line {
        fn parameters(&self) -> usize {
            6
        }

        fn observations(&self) -> f64 {
            self.rows.len() as f64
        }

        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            self.passes.set(self.passes.get() + 1);
            out.clear();
            for (x, y) in &self.rows {
                let model: f64 = x.iter().zip(p).map(|(x, p)| x * p).sum();
                out.add_row(x, y - model, 1.0);
            }
            true
        }
    }

    #[test]
    fn the_lowest_of_all_sets_on_their_limit_is_found_in_few_fits() {
        let free: Vec<usize> = (0..6).collect();
        for seed in 0..20 {
            let rows = (0..40)
                .map(|i| {
                    let noise = |k: usize| crate::noise::jitter(i, 100 * seed + k as u64);
                    let common = noise(0);
                    let x: [f64; 6] = std::array::from_fn(|k| common + 0.7 * noise(k + 1));
                    (x, 0.9 * x[0] - 0.4 * x[1] - 0.2 * x[2] + 0.3 * x[3] - 0.1 * x[4] + noise(9))
                })
                .collect();
            let problem = Line { rows, passes: Cell::new(0) };
            let found = minimise_bounded(&problem, &[0.0; 6], &free, &free, 1e-6).unwrap();
            let passes = problem.passes.get();
            let every_set = (0u32..64).filter_map(|set| {
                let free: Vec<usize> = free.iter().copied().filter(|k| set >> k & 1 == 1).collect();
                minimise(&problem, &[0.0; 6], &free).filter(|f| f.parameters.iter().all(|p| *p >= 0.0))
            });
            let least = every_set.map(|f| f.rss).fold(f64::INFINITY, f64::min);
            assert!(found.parameters.iter().all(|p| *p >= 0.0));
            assert!((found.rss / least - 1.0).abs() < 1e-9, "{seed}: {} {least}", found.rss);
            assert!(passes < 100, "{seed}: {passes}");
        }
    }
}

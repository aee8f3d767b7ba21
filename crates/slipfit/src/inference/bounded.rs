//! Least squares with parameters that cannot be negative.

use super::least_squares::{Fit, LeastSquares, descend_within, fit_at};
use super::limited_step::{Limits, parameters_without_influence};

/// Minimises `rᵀr` over the `free` parameters to within `tolerance` standard errors, with the parameters in
/// `non_negative` kept at zero or above. Parameters that end at their limit are not free in the fit.
///
/// If the remaining free parameters are not determined because two of them are interchangeable, one of them is held at
/// zero: the one without which the sum of squares is smallest.
pub(crate) fn minimise_bounded(
    problem: &dyn LeastSquares,
    start: &[f64],
    free: &[usize],
    non_negative: &[usize],
    tolerance: f64,
) -> Option<Fit> {
    let limited = |i: &usize| non_negative.contains(i);
    let mut free = free.to_vec();
    let mut found = descend_within(problem, start, &free, non_negative, tolerance)?;
    loop {
        let mut left = Limits::of(problem, &free, non_negative).influential(&found.0).into_owned();
        left.retain(|i| !limited(i) || found.0[*i] > 0.0);
        if let Some(mut fit) = fit_at(found.clone(), &left) {
            parameters_without_influence(problem, &found.0).for_each(|i| fit.parameters[i] = 0.0);
            return Some(fit);
        }
        let without = |i: usize| {
            let mut at = found.0.clone();
            at[i] = 0.0;
            let rest: Vec<usize> = free.iter().copied().filter(|k| *k != i).collect();
            descend_within(problem, &at, &rest, non_negative, tolerance).map(|found| (found, rest))
        };
        let ends = left.into_iter().filter(limited).filter_map(without);
        (found, free) = ends.min_by(|a, b| a.0.1.rss.total_cmp(&b.0.1.rss))?;
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

    /// `y = a + c exp(-s x)`: if `c` is zero, `s` has no effect; `s` lies within limits.
    struct Decay {
        points: Vec<(f64, f64)>,
    }

    const RANGE: [f64; 2] = [0.1, 3.0];

    impl Decay {
        fn of(c: f64, s: f64) -> Self {
            let at = |i: usize| {
                let x = 0.05 * i as f64;
                (x, 0.5 + c * (-s * x).exp() + 0.01 * crate::noise::jitter(i, 7))
            };
            Self { points: (0..80).map(at).collect() }
        }
    }

    impl LeastSquares for Decay {
        fn parameters(&self) -> usize {
            3
        }

        fn observations(&self) -> f64 {
            self.points.len() as f64
        }

        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            for &(x, y) in &self.points {
                let e = (-p[2] * x).exp();
                out.add_row(&[1.0, e, -p[1] * x * e], y - (p[0] + p[1] * e), 1.0);
            }
            p[2] == 0.0 || (RANGE[0]..=RANGE[1]).contains(&p[2])
        }

        fn range(&self, parameter: usize) -> [f64; 2] {
            if parameter == 2 { RANGE } else { [f64::NEG_INFINITY, f64::INFINITY] }
        }

        fn without_influence(&self, zero: usize) -> Option<(usize, f64)> {
            (zero == 1).then_some((2, 0.3))
        }
    }

    #[test]
    fn what_has_no_influence_on_a_limit_is_no_parameter_there() {
        for start in [[0.2, 0.4, 1.0], [0.2, -0.4, 0.0], [0.5, 0.0, 0.0]] {
            let absent = minimise_bounded(&Decay::of(-0.3, 1.0), &start, &[0, 1, 2], &[1], 1e-6).unwrap();
            assert_eq!((&absent.parameters[1..], &absent.free[..]), (&[0.0, 0.0][..], &[0][..]));
            let present = minimise_bounded(&Decay::of(0.3, 1.0), &start, &[0, 1, 2], &[1], 1e-6).unwrap();
            let off = |i: usize, truth: f64| (present.parameters[i] - truth).abs() / present.unit_std(i);
            assert!(off(0, 0.5) < 0.04 && off(1, 0.3) < 0.04 && off(2, 1.0) < 0.04, "{present:?}");
        }
    }

    #[test]
    fn a_parameter_beyond_its_range_ends_on_it_and_the_others_follow() {
        let problem = Decay::of(0.3, 8.0);
        let found = minimise(&problem, &[0.2, 0.4, 1.0], &[0, 1, 2]).unwrap();
        assert_eq!(found.parameters[2], RANGE[1]);
        let there = minimise(&problem, &[0.2, 0.4, RANGE[1]], &[0, 1]).unwrap();
        assert!((found.rss / there.rss - 1.0).abs() < 1e-9, "{} {}", found.rss, there.rss);
    }
}

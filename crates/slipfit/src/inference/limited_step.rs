//! Steps of a fit to the minimum of the quadratic form within the limits of its parameters.

use super::normal::{LeastSquares, Normal, solve};
use std::borrow::Cow;

/// The free parameters of a fit and their limits.
pub(crate) struct Limits<'a> {
    problem: &'a dyn LeastSquares,
    free: &'a [usize],
    non_negative: &'a [usize],
    /// Whether any parameter has a limit.
    has_limits: bool,
}

/// Slope away from a limit that is attributed to rounding, for parameters scaled to unit norm of their columns and
/// relative to the norm of the residuals.
const LEAST_SLOPE: f64 = 1e-10;

/// Maximum number of active sets tried; each has a lower value of the quadratic form than the previous one.
const MOST_SETS: usize = 256;

impl<'a> Limits<'a> {
    /// The limits of the problem, with zero as an additional lower limit of the parameters in `non_negative`.
    pub(crate) fn of(problem: &'a dyn LeastSquares, free: &'a [usize], non_negative: &'a [usize]) -> Self {
        let has = |i: &usize| non_negative.contains(i) || problem.range(*i).iter().any(|v| v.is_finite());
        Self { problem, free, non_negative, has_limits: free.iter().any(has) }
    }

    fn range(&self, i: usize) -> [f64; 2] {
        let [least, most] = self.problem.range(i);
        [if self.non_negative.contains(&i) { least.max(0.0) } else { least }, most]
    }

    /// Clamps each free parameter to its limits, and sets parameters that gain influence when another one departs from
    /// zero to their initial values.
    pub(crate) fn within(&self, start: &[f64]) -> Vec<f64> {
        let mut start = start.to_vec();
        if !self.has_limits {
            return start;
        }
        for &i in self.free {
            let [least, most] = self.range(i);
            start[i] = if start[i] == 0.0 && least > 0.0 { 0.0 } else { start[i].clamp(least, most) };
        }
        for i in 0..start.len() {
            let other = self.problem.without_influence(i).filter(|(other, _)| start[*other] == 0.0);
            if let Some((other, first)) = other.filter(|_| start[i] != 0.0 || self.free.contains(&i)) {
                start[other] = first;
            }
        }
        start
    }

    /// The free parameters, excluding those that have no influence because another parameter is zero.
    pub(crate) fn influential(&self, at: &[f64]) -> Cow<'a, [usize]> {
        let idle: Vec<usize> =
            parameters_without_influence(self.problem, at).filter(|i| self.free.contains(i)).collect();
        if idle.is_empty() {
            return Cow::Borrowed(self.free);
        }
        self.free.iter().copied().filter(|i| !idle.contains(i)).collect()
    }

    /// The step of the free parameters to the minimum of the damped quadratic form within the limits, and the decrease
    /// of the sum of squares that it predicts.
    ///
    /// Active-set method (Lawson and Hanson 1974, Solving Least Squares Problems, chapter 23; for limits on both sides
    /// Stark and Parker 1995, Computational Statistics 10, 129).
    pub(crate) fn step(&self, at: &[f64], sums: &Normal, damping: f64) -> Option<(Vec<f64>, f64)> {
        if !self.has_limits {
            return solve(sums, self.free, damping);
        }
        let moving = self.influential(at);
        let jtj = |i: usize, k: usize| sums.jtj[(i.max(k), i.min(k))];
        // Downhill slope after a step, of the quadratic form and of the damped one.
        let slope =
            |step: &[f64], i: usize| sums.jtr[i] - moving.iter().map(|&k| jtj(i, k) * step[k]).sum::<f64>();
        let damped = |step: &[f64], i: usize| slope(step, i) - damping * jtj(i, i) * step[i];
        let mut step = vec![0.0; at.len()];
        let off_limit = |i: &usize| self.range(*i)[0] < at[*i] && at[*i] < self.range(*i)[1];
        let mut inside: Vec<usize> = moving.iter().copied().filter(off_limit).collect();
        for _ in 0..MOST_SETS {
            while let Some(limit) = self.toward_minimum(at, sums, damping, (&moving, &inside), &mut step)? {
                inside.retain(|i| *i != limit);
            }
            let gain = |i: usize| {
                let inward = if at[i] + step[i] > self.range(i)[0] { -1.0 } else { 1.0 };
                inward * damped(&step, i) / jtj(i, i).sqrt()
            };
            let least = LEAST_SLOPE * sums.rss.sqrt();
            let on_limit = moving.iter().copied().filter(|i| !inside.contains(i) && jtj(*i, *i) > 0.0);
            let Some(next) =
                on_limit.filter(|i| gain(*i) > least).max_by(|a, b| gain(*a).total_cmp(&gain(*b)))
            else {
                break;
            };
            inside.push(next);
        }
        let promised = moving.iter().map(|&i| step[i] * (sums.jtr[i] + slope(&step, i))).sum();
        Some((self.free.iter().map(|&i| step[i]).collect(), promised))
    }

    /// Moves the parameters `inside` toward the minimum of the form until one of them reaches a limit; returns that
    /// parameter, if any.
    fn toward_minimum(
        &self,
        at: &[f64],
        sums: &Normal,
        damping: f64,
        (moving, inside): (&[usize], &[usize]),
        step: &mut [f64],
    ) -> Option<Option<usize>> {
        if inside.is_empty() {
            return Some(None);
        }
        let mut rest = Cow::Borrowed(sums);
        for &k in moving.iter().filter(|k| step[**k] != 0.0 && !inside.contains(k)) {
            for &i in inside {
                rest.to_mut().jtr[i] -= sums.jtj[(i.max(k), i.min(k))] * step[k];
            }
        }
        let (target, _) = solve(&rest, inside, damping)?;
        let first = inside.iter().zip(&target).filter_map(|(&i, target)| {
            let [least, most] = self.range(i);
            let end = at[i] + target;
            let limit = if end < least { least } else { most };
            let way = || ((limit - at[i] - step[i]) / (target - step[i])).clamp(0.0, 1.0);
            (end < least || end > most).then(|| (way(), i, limit))
        });
        let first = first.min_by(|a, b| a.0.total_cmp(&b.0));
        let part = first.map_or(1.0, |f| f.0);
        inside.iter().zip(&target).for_each(|(&i, target)| step[i] += part * (target - step[i]));
        Some(first.map(|(_, i, limit)| {
            step[i] = limit - at[i];
            i
        }))
    }
}

/// The parameters that have no influence because another is zero.
pub(crate) fn parameters_without_influence<'a>(
    problem: &'a dyn LeastSquares,
    at: &'a [f64],
) -> impl Iterator<Item = usize> + 'a {
    let zeros = (0..at.len()).filter(|i| at[*i] == 0.0);
    zeros.filter_map(|i| problem.without_influence(i)).map(|(other, _)| other)
}

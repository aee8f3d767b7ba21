//! Steps of a fit to the least of the quadratic form within the limits of its parameters.

use super::normal::{LeastSquares, Normal, solve};
use std::borrow::Cow;

/// The free parameters of a fit and their limits.
pub(crate) struct Limits<'a> {
    problem: &'a dyn LeastSquares,
    free: &'a [usize],
    non_negative: &'a [usize],
    /// Whether there are any.
    any: bool,
}

/// Slope off a limit, by a parameter scaled to unit norm of its column and over the norm of the residuals, that is
/// rounding.
const LEAST_SLOPE: f64 = 1e-10;

/// Sets of parameters on their limit that are passed at most; each has a lower form than the one before.
const MOST_SETS: usize = 256;

impl<'a> Limits<'a> {
    /// Those of the problem, and zero as the least of some.
    pub(crate) fn of(problem: &'a dyn LeastSquares, free: &'a [usize], non_negative: &'a [usize]) -> Self {
        let has = |i: &usize| non_negative.contains(i) || problem.range(*i).iter().any(|v| v.is_finite());
        Self { problem, free, non_negative, any: free.iter().any(has) }
    }

    fn range(&self, i: usize) -> [f64; 2] {
        let [least, most] = self.problem.range(i);
        [if self.non_negative.contains(&i) { least.max(0.0) } else { least }, most]
    }

    /// The same with each free parameter within its limits, and with what has an influence as soon as another one
    /// leaves zero.
    pub(crate) fn within(&self, start: &[f64]) -> Vec<f64> {
        let mut start = start.to_vec();
        if !self.any {
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

    /// The free parameters without those that have no influence because another is zero.
    pub(crate) fn influential(&self, at: &[f64]) -> Cow<'a, [usize]> {
        let idle: Vec<usize> = idle(self.problem, at).filter(|i| self.free.contains(i)).collect();
        if idle.is_empty() {
            return Cow::Borrowed(self.free);
        }
        self.free.iter().copied().filter(|i| !idle.contains(i)).collect()
    }

    /// The step of the free parameters to the least of the damped quadratic form within the limits, and the decrease
    /// of the sum of squares it promises.
    ///
    /// By an active set (Lawson and Hanson 1974, Solving Least Squares Problems, chapter 23; for limits on both sides
    /// Stark and Parker 1995, Computational Statistics 10, 129).
    pub(crate) fn step(&self, at: &[f64], sums: &Normal, damping: f64) -> Option<(Vec<f64>, f64)> {
        if !self.any {
            return solve(sums, self.free, damping);
        }
        let moving = self.influential(at);
        let jtj = |i: usize, k: usize| sums.jtj[(i.max(k), i.min(k))];
        // Slope downhill behind a step, of the form and of the damped one.
        let slope =
            |step: &[f64], i: usize| sums.jtr[i] - moving.iter().map(|&k| jtj(i, k) * step[k]).sum::<f64>();
        let damped = |step: &[f64], i: usize| slope(step, i) - damping * jtj(i, i) * step[i];
        let mut step = vec![0.0; at.len()];
        let off_limit = |i: &usize| self.range(*i)[0] < at[*i] && at[*i] < self.range(*i)[1];
        let mut inside: Vec<usize> = moving.iter().copied().filter(off_limit).collect();
        for _ in 0..MOST_SETS {
            while let Some(limit) = self.toward_least(at, sums, damping, (&moving, &inside), &mut step)? {
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

    /// Goes toward the least of the form by the parameters `inside` as far as none leaves its limits; the one that
    /// would.
    fn toward_least(
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
pub(crate) fn idle<'a>(problem: &'a dyn LeastSquares, at: &'a [f64]) -> impl Iterator<Item = usize> + 'a {
    let zeros = (0..at.len()).filter(|i| at[*i] == 0.0);
    zeros.filter_map(|i| problem.without_influence(i)).map(|(other, _)| other)
}

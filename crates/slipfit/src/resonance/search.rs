//! Multi-start: the smallest sum of squares from many start values.

use super::block::Block;
use super::criteria::SearchCriteria;
use super::peak::Peak;
use super::problem::Problem;
use super::response::COUNT;
use super::start::{self, Start};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, by_rss, minimise};
use crate::numeric::order::sort_by_value;

/// All start values for the minimiser, with the centre at the peak.
pub(crate) fn starts(
    b: &Block,
    peak: &Peak,
    from_phases: Option<Start>,
    known: Option<f64>,
    fixed: bool,
) -> Vec<Vec<f64>> {
    let phase = from_phases.map_or_else(|| start::phase_at_peak(b, peak), |s| s.phase);
    let first = from_phases.map(|s| start::parameters(&s, known));
    let mut list: Vec<Start> = start::grid(peak, phase, known);
    if known.is_some() && !fixed {
        list.extend(start::grid(peak, phase, None));
    }
    first.into_iter().chain(list.iter().map(|s| start::parameters(s, None))).collect()
}

/// The best fit, started from the best of several starts.
pub(crate) fn best(
    problem: &Problem,
    starts: &[Vec<f64>],
    free: &[usize],
    c: &SearchCriteria,
) -> Option<Fit> {
    best_of(problem, starts, free, c.tries, c)
}

/// With many points the starts are followed with some of the points, and only the resulting minima are followed with
/// all.
pub(super) fn best_of(
    problem: &Problem,
    starts: &[Vec<f64>],
    free: &[usize],
    tries: usize,
    c: &SearchCriteria,
) -> Option<Fit> {
    if starts.len() > 1
        && let Some(few) = thinned(problem, c.few_points, c)
    {
        let ends: Vec<Vec<f64>> =
            followed(&few, starts, free, tries, c, &minimise).into_iter().map(|f| f.parameters).collect();
        if let Some(fit) = followed(problem, &ends, free, c.last_tries, c, &minimise).into_iter().next() {
            return Some(fit);
        }
    }
    followed(problem, starts, free, tries, c, &minimise).into_iter().next()
}

/// A minimisation: the problem, the start, and the free parameters.
type Minimiser<'a> = dyn Fn(&dyn LeastSquares, &[f64], &[usize]) -> Option<Fit> + 'a;

/// The minima reached from the best of the starts by a minimiser, in ascending order of the sum of squares.
pub(super) fn followed(
    problem: &Problem,
    starts: &[Vec<f64>],
    free: &[usize],
    tries: usize,
    c: &SearchCriteria,
    minimised: &Minimiser<'_>,
) -> Vec<Fit> {
    // For a start far worse than the best the summation is stopped early.
    let mut least = f64::INFINITY;
    let mut ranked: Vec<(f64, &Vec<f64>)> = starts
        .iter()
        .filter_map(|s| {
            let r = rss(problem, s, c.hopeless * least)?;
            least = least.min(r);
            Some((r, s))
        })
        .collect();
    sort_by_value(&mut ranked, |r| r.0);
    let mut found: Vec<Fit> = Vec::new();
    for (_, s) in ranked.into_iter().take(tries) {
        let fit = problem.main.work.within(c.share, || minimised(problem, s, free));
        let Some(fit) = fit else { continue };
        let near = |f: &Fit| (f.rss - fit.rss).abs() < c.same_minimum * fit.rss / problem.observations();
        if !found.iter().any(near) {
            found.push(fit);
            by_rss(&mut found);
        } else if tries == c.tries && near(&found[0]) {
            // If the same minimum is found twice, the search ends; with more or fewer tries every start is followed.
            break;
        }
    }
    found
}

/// The sum of squares for one parameter vector; `None` if there is no motion or if it exceeds `limit`.
pub(super) fn rss(problem: &Problem, p: &[f64], limit: f64) -> Option<f64> {
    let mut sums = Normal::zeros(COUNT);
    (problem.normal_within(p, &mut sums, limit) && sums.rss.is_finite()).then_some(sums.rss)
}

/// The problem with about `few` of the points, if there are many.
pub(super) fn thinned(problem: &Problem, few: usize, c: &SearchCriteria) -> Option<Problem> {
    let n = problem.main.len();
    if n < 2 * few {
        return None;
    }
    let level = problem.main.levels();
    let (low, high) = level.iter().fold((f64::INFINITY, 0.0f64), |(l, h), a| (l.min(*a), h.max(*a)));
    let above = level.iter().filter(|a| **a > 0.5 * (low + high)).count();
    let stride = (n / few).min(above.min(n - above) / c.few_on_peak);
    (stride > 1).then(|| Problem { main: problem.main.thinned(stride), ..problem.clone() })
}

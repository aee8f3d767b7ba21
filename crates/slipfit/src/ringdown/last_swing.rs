//! Which swing was the last: the sum of squares of a motion that stops has a minimum for every number of them.

use super::envelope::law_of;
use super::waveform::{OMEGA, Waveform};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise};
use crate::inference::quadratic::given;
use crate::motion::decay::parameters::{A0, COUNT, DELTA, X_F};
use std::f64::consts::PI;

/// Swings fewer and more from which the next minimum is looked for.
const SWINGS: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];
/// Neighbours fitted in each round, those with the lowest sums of squares where they begin.
const FITTED: usize = 2;
/// Rounds; each ends at a lower minimum than the one before.
const ROUNDS: usize = 4;
/// Least part by which a minimum is lower than another.
const LOWER: f64 = 1e-9;
/// Halvings of the factor of `x_F`, and its least and greatest value, in the search for a number of swings.
const HALVINGS: usize = 40;
const FACTORS: [f64; 2] = [0.05, 20.0];

/// The lowest minimum reached over the numbers of swings near that of `fit`: `x_F` is moved so that the motion ends a
/// swing or two earlier or later, and a fit begins there. The other parameters follow by the quadratic form, or the
/// viscous loss alone follows and keeps the loss at the first amplitude: far from the lowest minimum the form of one
/// that is not says little.
pub(crate) fn over_last_swings(problem: &Waveform, mut fit: Fit) -> Fit {
    let mut sums = Normal::zeros(COUNT);
    for _ in 0..ROUNDS {
        let by_form = |x_f: f64| given(&fit, &[(X_F, x_f)]).map(|(_, p)| p);
        let at_equal_loss = |x_f: f64| {
            let mut p = fit.parameters.clone();
            p[DELTA] -= 2.0 * p[OMEGA] * (x_f - p[X_F]) / (PI * p[A0]);
            p[X_F] = x_f;
            Some(p)
        };
        let mut starts: Vec<(f64, Vec<f64>)> = SWINGS
            .iter()
            .flat_map(|more| {
                let duration = problem.duration;
                [
                    with_swings(&fit, *more, duration, by_form),
                    with_swings(&fit, *more, duration, at_equal_loss),
                ]
            })
            .flatten()
            .filter_map(|start| problem.normal(&start, &mut sums).then_some((sums.rss, start)))
            .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let lowest = starts
            .iter()
            .take(FITTED)
            .filter_map(|(_, start)| minimise(problem, start, &fit.free))
            .min_by(|a, b| a.rss.total_cmp(&b.rss));
        match lowest {
            Some(lower) if lower.rss < fit.rss * (1.0 - LOWER) => fit = lower,
            _ => break,
        }
    }
    fit
}

/// Parameters along a line in `x_F` with which the motion stops so many swings later; `None` where it does not stop
/// in the window.
fn with_swings(
    fit: &Fit,
    more: f64,
    duration: f64,
    line: impl Fn(f64) -> Option<Vec<f64>>,
) -> Option<Vec<f64>> {
    let stop = |p: &[f64]| law_of(p, p[OMEGA]).stop_time_s();
    let (x_f, omega) = (fit.parameters[X_F], fit.parameters[OMEGA]);
    let now = stop(&fit.parameters).filter(|t| *t < duration)?;
    let wanted = now + more * PI / omega;
    let at = |factor: f64| {
        let mut p = line(factor * x_f)?;
        p[DELTA] = p[DELTA].max(0.0);
        Some(p)
    };
    // More friction, an earlier stop.
    let [mut low, mut high] = FACTORS.map(f64::ln);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let later = at(middle.exp()).is_some_and(|p| stop(&p).is_none_or(|t| t > wanted));
        *(if later { &mut low } else { &mut high }) = middle;
    }
    at((0.5 * (low + high)).exp()).filter(|p| stop(p).is_some_and(|t| (t - wanted).abs() * omega < 1.0))
}

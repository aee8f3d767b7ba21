//! Which swing was the last before friction stopped the motion.
//!
//! Successive swings end `2 x_F` closer to the centre, and the last one leaves the mass on one side or the
//! other. The sum of squares therefore has a minimum for every number of swings, and a fit that knows the
//! level of the rest stays in the one it began in.

use super::criteria::WaveformCriteria;
use super::envelope::{X_F, law_of};
use super::waveform::{OMEGA, RestLevel, Waveform};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, STEP_TOLERANCE, by_rss, minimise_until};
use crate::inference::quadratic::given;
use crate::numeric::order::ascending;
use std::f64::consts::PI;

/// Steps of the search in which the place of rest moves by `x_F`, and most steps to either side.
const STEPS_PER_FRICTION: f64 = 3.0;
const MOST_STEPS: usize = 40;
/// Minima descended into, of those met along the search.
const DESCENDED: usize = 3;
/// Standard errors beyond which a minimum is another one.
const APART: f64 = 0.3;

/// The lowest minimum over all last swings.
pub(super) struct LastSwing {
    pub(super) fit: Fit,
    /// No other last swing explains the samples nearly as well.
    pub(super) is_known: bool,
}

impl LastSwing {
    /// The lowest minimum, `fit` among them, of motions that stop.
    ///
    /// The motion before the rest alone tells the loss to some accuracy: that range is searched in steps of
    /// the friction displacement, the other parameters following. `inflation` is that of the variance at a
    /// minimum.
    pub(super) fn search(
        problem: &Waveform,
        fit: Fit,
        inflation: impl Fn(&Fit) -> f64,
        criteria: &WaveformCriteria,
    ) -> Self {
        let mut minima = other_minima(problem, &fit, criteria.last_swing_errors).unwrap_or_default();
        minima.push(fit);
        by_rss(&mut minima);
        let mut fit = minima.swap_remove(0);
        if problem.gathered.is_some() {
            let closer = minimise_until(&problem.exact(), &fit.parameters, &fit.free, STEP_TOLERANCE, true);
            fit = closer.unwrap_or(fit);
        }
        let variance = fit.rss / (problem.observations() - fit.free.len() as f64).max(1.0);
        let apart = APART * fit.unit_std(X_F) * variance.sqrt();
        let is_other = |other: &Fit| (other.parameters[X_F] - fit.parameters[X_F]).abs() > apart;
        let next = minima.iter().find(|other| is_other(other));
        let is_known = next.is_none_or(|next| {
            next.rss - fit.rss > criteria.last_swing_variances * variance * inflation(&fit)
        });
        Self { fit, is_known }
    }
}

/// The lowest minima met along the friction displacement.
fn other_minima(problem: &Waveform, fit: &Fit, errors: f64) -> Option<Vec<Fit>> {
    let bounded = Waveform { rest: RestLevel::Bounded, ..problem.clone() };
    let motion = minimise_until(&bounded, &fit.parameters, &fit.free, STEP_TOLERANCE, true)?;
    let p = &motion.parameters;
    let (x_f, omega) = (p[X_F], p[OMEGA]);
    let stop_s = law_of(p, omega).stop_time_s().filter(|t| *t < problem.duration && x_f > 0.0)?;
    let reach = errors * motion.unit_std(X_F) * (motion.rss / problem.observations()).sqrt();
    // Every swing takes 2 x_F: a change of x_F moves the place of rest by as many of it.
    let swings = omega * stop_s / PI;
    let finest = x_f / (STEPS_PER_FRICTION * 2.0 * swings.max(1.0));
    let steps = ((reach / finest).ceil() as usize).clamp(1, MOST_STEPS);
    let step = finest.max(reach / steps as f64);
    let mut sums = Normal::zeros(problem.parameters());
    let seen: Vec<(f64, Vec<f64>)> = (0..=2 * steps)
        .map(|i| x_f + step * (i as f64 - steps as f64))
        .filter(|x| *x > 0.0)
        .filter_map(|x| given(&motion, &[(X_F, x)]))
        .filter_map(|(_, p)| problem.normal_of(&p, &[], &mut sums, f64::INFINITY).then_some((sums.rss, p)))
        .collect();
    let at = |i: usize| seen.get(i).map_or(f64::INFINITY, |s| s.0);
    let lowest = |i: &usize| at(*i) <= at(i + 1) && (*i == 0 || at(*i) <= at(i - 1));
    let minima: Vec<usize> = (0..seen.len()).filter(lowest).collect();
    let rss: Vec<f64> = minima.iter().map(|i| at(*i)).collect();
    let descend = |i: usize| minimise_until(problem, &seen[minima[i]].1, &fit.free, STEP_TOLERANCE, true);
    Some(ascending(&rss).into_iter().take(DESCENDED).filter_map(descend).collect())
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::Options;
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    /// Fifteen cycles, friction of three times the noise, and a rest twice as long as the motion: neighbouring
    /// last swings differ by one part in a hundred of the friction.
    #[test]
    fn friction_is_held_whichever_minimum_the_search_begins_in() {
        let (q, x_f, noise) = (80.0, 0.012, 0.004);
        let oscillator = Oscillator::kinematic(TAU, PI / q, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let end = 3.0 * decay.stop().expect("stops").time_s;
        let time: Vec<f64> = (0..(end * 41.0) as usize).map(|i| i as f64 / 41.0).collect();
        let record = |repeat: usize| {
            let noisy =
                |(i, &t): (usize, &f64)| decay.displacement(t) + noise * jitter(repeat * time.len() + i, 7);
            Record::new(time.clone(), time.iter().enumerate().map(noisy).collect()).expect("valid")
        };
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, x_f);
    }
}

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
const MOST_STEPS: usize = 80;
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
    use crate::ringdown::{Answer, Options, analyse};
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

    /// Motions that stop in their records, at 20 and 50 dB: the reported one is the closest of all, whatever the
    /// last swing and the share of friction that the search begins with.
    #[test]
    fn no_answer_lies_above_the_truth() {
        for (q, share, noise, decay_times) in [(50.0, 0.7, 3.2e-3, 2.5), (30.0, 0.03, 0.1, 8.0)] {
            let rate = PI / q;
            let oscillator =
                Oscillator::kinematic(TAU, rate, share / (1.0 - share) * rate / 4.0).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let count = (decay_times / rate * 15.0) as usize;
            let time: Vec<f64> = (0..count).map(|i| i as f64 / 15.0).collect();
            let mut by_waveform = 0;
            let mut above = |repeat: &usize| {
                let noisy =
                    |(i, &t): (usize, &f64)| decay.displacement(t) + noise * jitter(repeat * count + i, 3);
                let signal: Vec<f64> = time.iter().enumerate().map(noisy).collect();
                let record = Record::new(time.clone(), signal.clone()).expect("valid");
                let answer = analyse(&record, &Options::default()).expect("a ring-down");
                answer.diagnostics.method == "waveform" && {
                    by_waveform += 1;
                    let [fitted, truth] = sums_of_squares(&answer, &time, &signal, &decay);
                    fitted > truth + 0.01 * noise.powi(2)
                }
            };
            let found: Vec<usize> = (0..150).filter(|repeat| above(repeat)).collect();
            assert!(by_waveform > 140, "Q {q}: {by_waveform} of 150 by the waveform");
            assert!(found.is_empty(), "Q {q}: records {found:?}");
        }
    }

    /// Of the reported motion and of the true one over the window of an answer, the level of the rest free.
    fn sums_of_squares(answer: &Answer, time: &[f64], signal: &[f64], decay: &FreeDecay) -> [f64; 2] {
        let [from, to] = answer.fit.range_s();
        let rest = answer.fit.rest_s().unwrap_or(f64::INFINITY);
        let samples = || time.iter().zip(signal).filter(|(t, _)| (from..=to).contains(*t));
        let still: Vec<f64> = samples().filter(|(t, _)| **t > rest).map(|(_, x)| *x).collect();
        let level = still.iter().sum::<f64>() / still.len().max(1) as f64;
        let motion = |t: f64| if t > rest { level } else { answer.fit.signal_at(t) };
        let sum = |of: &dyn Fn(f64) -> f64| samples().map(|(t, x)| (x - of(*t)).powi(2)).sum();
        [sum(&motion), sum(&|t| decay.displacement(t))]
    }
}

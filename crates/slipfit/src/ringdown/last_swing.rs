//! Search for the last half cycle (swing) before friction stopped the motion.
//!
//! Successive swings end `2 x_F` closer to the centre, and the last one leaves the mass on one side or the
//! other. The sum of squares therefore has a minimum for every number of swings, and a fit that uses the
//! level of the rest stays in the minimum in which it started.

use super::criteria::WaveformCriteria;
use super::envelope::{X_F, law_of};
use super::waveform::{OMEGA, PHASE, RestLevel, Waveform};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, STEP_TOLERANCE, by_rss, minimise_until};
use crate::inference::quadratic::conditional_minimum;
use crate::numeric::order::ascending;
use std::f64::consts::PI;

/// Number of search steps in which the rest position moves by `x_F`, and range of the number of steps on
/// either side: if few swings end near the edge of the stick zone, two minima may be closer to each other
/// than such a step.
const STEPS_PER_FRICTION: f64 = 3.0;
const STEPS: [usize; 2] = [8, 80];
/// Number of minima along the search that are refined.
const CANDIDATES: usize = 3;
/// Standard errors beyond which a minimum counts as a different one.
const LEAST_SEPARATION: f64 = 0.3;

/// The lowest minimum over all possible last swings.
pub(super) struct LastSwing {
    pub(super) fit: Fit,
    /// The minima of other last swings that explain the samples nearly as well.
    pub(super) others: Vec<Fit>,
}

impl LastSwing {
    /// The lowest minimum, starting from `fit`, of motions that stop.
    ///
    /// The motion before the rest alone determines the friction displacement to some accuracy. That range is
    /// searched in steps of the friction displacement, with the other parameters at their conditional
    /// minimum. `inflation` is the variance inflation at a minimum.
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
        let apart = LEAST_SEPARATION * fit.unit_std(X_F) * variance.sqrt();
        let is_other = |other: &Fit| (other.parameters[X_F] - fit.parameters[X_F]).abs() > apart;
        let most = fit.rss + criteria.last_swing_variances * variance * inflation(&fit);
        minima.retain(|other| is_other(other) && other.rss <= most);
        Self { fit, others: minima }
    }
}

/// The lowest minima found along the friction displacement.
fn other_minima(problem: &Waveform, fit: &Fit, errors: f64) -> Option<Vec<Fit>> {
    let bounded = Waveform { rest: RestLevel::Bounded, ..problem.clone() };
    let motion = minimise_until(&bounded, &fit.parameters, &fit.free, STEP_TOLERANCE, true)?;
    let p = &motion.parameters;
    let (x_f, omega) = (p[X_F], p[OMEGA]);
    let stop_s = law_of(p, omega).stop_time_s().filter(|t| *t < problem.duration && x_f > 0.0)?;
    let reach = errors * motion.unit_std(X_F) * (motion.rss / problem.observations()).sqrt();
    // Every swing loses 2 x_F: a change of x_F shifts the rest position by that many times the change.
    let swings = omega * stop_s / PI;
    let finest = x_f / (STEPS_PER_FRICTION * 2.0 * swings.max(1.0));
    let reach = reach.max(finest);
    let steps = ((reach / finest).ceil() as usize).clamp(STEPS[0], STEPS[1]);
    let step = reach / steps as f64;
    let mut sums = Normal::zeros(problem.parameters());
    let evaluated: Vec<(f64, Vec<f64>)> = (0..=2 * steps)
        .map(|i| x_f + step * (i as f64 - steps as f64))
        .filter(|x| *x > 0.0)
        .filter_map(|x| conditional_minimum(&motion, &[(X_F, x)]))
        .filter_map(|(_, p)| problem.normal_of(&p, &[], &mut sums, f64::INFINITY).then_some((sums.rss, p)))
        .collect();
    let turns: Vec<f64> = evaluated.iter().map(|(_, p)| last_turn(p)).collect();
    // Each number of swings has a separate minimum, which a step may pass over.
    let at = |i: usize, turn: f64| if turns.get(i) == Some(&turn) { evaluated[i].0 } else { f64::INFINITY };
    let lowest = |i: &usize| {
        let (rss, turn) = (evaluated[*i].0, turns[*i]);
        rss <= at(i + 1, turn) && (*i == 0 || rss <= at(i - 1, turn))
    };
    let minima: Vec<usize> = (0..evaluated.len()).filter(lowest).collect();
    let rss: Vec<f64> = minima.iter().map(|i| evaluated[*i].0).collect();
    let descend =
        |i: usize| minimise_until(problem, &evaluated[minima[i]].1, &fit.free, STEP_TOLERANCE, true);
    Some(ascending(&rss).into_iter().take(CANDIDATES).filter_map(descend).collect())
}

/// Whether one swing more or less would change the samples too little to be detected: the mass stops close to
/// the edge of the stick zone, or barely passed it.
///
/// A swing of amplitude `m` deviates from the rest position without it by `m (1 + cos theta)`: the mean
/// square over the samples of the swing is `1.5 m²`.
pub(super) fn is_hidden(problem: &Waveform, fit: &Fit, variances: f64) -> bool {
    let p = &fit.parameters;
    let law = law_of(p, p[OMEGA]);
    let turn = last_turn(p);
    let beyond = |turn: f64| law.amplitude((turn * PI - p[PHASE]) / p[OMEGA]).abs() - p[X_F];
    let swing = beyond(turn).abs().min(beyond(turn - 1.0).abs());
    let samples = problem.observations() * PI / (p[OMEGA] * problem.duration);
    let variance = fit.rss / problem.observations();
    turn.is_finite() && 1.5 * swing * swing * samples < variances * variance
}

/// Whether a friction displacement within `reach` of a fit gives the motion another last swing. The sum of
/// squares has a kink where it changes, beyond which the curvature at the minimum carries no information.
pub(super) fn may_be_another(fit: &Fit, reach: f64) -> bool {
    let turn = last_turn(&fit.parameters);
    let differs =
        |x_f: f64| conditional_minimum(fit, &[(X_F, x_f)]).is_some_and(|(_, p)| last_turn(&p) != turn);
    turn.is_finite() && [-1.0, 1.0].iter().any(|side| differs(fit.parameters[X_F] + side * reach))
}

/// Index of the turning point at which friction stops a motion, from its phase without disturbances; infinite
/// if it does not stop.
fn last_turn(p: &[f64]) -> f64 {
    let stuck_s = law_of(p, p[OMEGA]).time_to(p[X_F]);
    stuck_s.map_or(f64::INFINITY, |t| ((p[PHASE] + p[OMEGA] * t) / PI).ceil())
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Answer, Options, analyse};
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    /// Fifteen cycles, friction of three times the noise, and a rest twice as long as the motion: the
    /// friction of neighbouring last swings differs by one part in a hundred.
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

    /// One cycle that ends at 0.97 of the friction displacement: with one more swing, from just beyond it,
    /// the motion differs by two thousandths of the amplitude.
    #[test]
    fn friction_is_held_where_the_mass_stops_near_the_edge_of_the_stick_zone() {
        let oscillator = Oscillator::kinematic(TAU, PI / 3.0, 0.1).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let record = |repeat: usize| {
            let time: Vec<f64> = (0..400).map(|i| f64::from(i) / 40.0).collect();
            let noisy =
                |(i, &t): (usize, &f64)| decay.displacement(t) + 1.26e-3 * jitter(repeat * 400 + i, 9);
            Record::new(time.clone(), time.iter().enumerate().map(noisy).collect()).expect("valid")
        };
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, 0.1);
        assert_held(record, &Options::default(), Parameter::DECAY_RATE, PI / 3.0);
    }

    /// Four hundred half cycles that end at 0.9 of the friction displacement, which is half the noise of a
    /// sample: the additional swing for a smaller friction is a tenth of the noise.
    #[test]
    fn friction_is_held_where_a_swing_more_could_not_be_seen() {
        let (q, x_f, noise) = (330.0, 4.2006e-4, 9e-4);
        let oscillator = Oscillator::kinematic(TAU, PI / q, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let stop = decay.stop().expect("stops");
        let left = 1.0 - stop.position.abs() / x_f;
        assert!((0.02..0.15).contains(&left), "{left}");
        let count = (3.0 * stop.time_s * 21.0) as usize;
        let time: Vec<f64> = (0..count).map(|i| i as f64 / 21.0).collect();
        let clean: Vec<f64> = time.iter().map(|t| decay.displacement(*t)).collect();
        let record = |repeat: usize| {
            let noisy = |(i, x): (usize, &f64)| x + noise * jitter(repeat * count + i, 11);
            Record::new(time.clone(), clean.iter().enumerate().map(noisy).collect()).expect("valid")
        };
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, x_f);
        assert_held(record, &Options::default(), Parameter::DECAY_RATE, PI / q);
    }

    /// Motions that stop within their records, at 20 and 50 dB: no motion may fit better than the reported
    /// one, whichever last swing and share of friction the search starts with.
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

    /// Sums of squares of the reported and of the true motion over the window of an answer, with the level of
    /// the rest free.
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

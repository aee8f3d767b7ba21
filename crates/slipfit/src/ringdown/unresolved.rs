//! Unresolved rest: the end of a record in which the steps of the converter hide the remaining motion.

use super::criteria::ResolutionCriteria;
use crate::numeric::robust::median;

/// Number of samples up to half a cycle after the last motion visible above the steps of the converter, of
/// height `step`; the number of all samples if no long rest follows.
///
/// The rounding error of a sample acts as independent noise with variance `step²/12` if the signal or its
/// noise crosses steps between samples (W. R. Bennett, *Spectra of quantized signals*, 1948). At rest all
/// samples share one error. Counted as hundreds of measurements of a mass at rest they would exclude every
/// motion below a step, and a viscous decay that falls below it would appear to be stopped by friction. With
/// noise of half a step neighbouring samples differ by more than is allowed in such a rest, and the record is
/// left unchanged.
pub(crate) fn resolved(time: &[f64], signal: &[f64], step: f64, criteria: &ResolutionCriteria) -> usize {
    let n = signal.len();
    resolved_end(time, signal, step, criteria).unwrap_or(n)
}

/// Whether the last samples take as few distinct values as in an unresolved rest.
pub(crate) fn may_be_unresolved(signal: &[f64], criteria: &ResolutionCriteria) -> bool {
    let mut values: Vec<f64> = Vec::new();
    for x in final_samples(signal, criteria) {
        if !values.contains(x) {
            values.push(*x);
        }
        if values.len() > criteria.most_values {
            return false;
        }
    }
    true
}

/// The samples at the end from which the level of the rest is determined.
fn final_samples<'a>(signal: &'a [f64], criteria: &ResolutionCriteria) -> &'a [f64] {
    let n = signal.len();
    &signal[n - (n / criteria.last_part).max(criteria.least_last).min(n)..]
}

fn resolved_end(time: &[f64], signal: &[f64], step: f64, criteria: &ResolutionCriteria) -> Option<usize> {
    let level = median(&mut final_samples(signal, criteria).to_vec())?;
    let beyond = (criteria.steps + 0.5) * step;
    let side = |i: usize| match signal[i] - level {
        off if off > beyond => 1,
        off if off < -beyond => -1,
        _ => 0,
    };
    // A single sample may be noise.
    let moves = |i: &usize| side(*i) != 0 && side(i - 1) == side(*i);
    let moving = (1..signal.len()).rev().find(moves)?;
    let half_period_s = half_period(time, moving, side, criteria.turns)?;
    let kept_s = time[moving] + 2.0 * criteria.kept_cycles * half_period_s;
    let end = time.partition_point(|t| *t <= kept_s);
    let hidden_s = time[time.len() - 1] - kept_s;
    (hidden_s > 2.0 * criteria.rest_cycles * half_period_s).then_some(end)
}

/// Median time between the last changes of side before a given sample, at most `most` of them.
fn half_period(time: &[f64], last: usize, side: impl Fn(usize) -> i32, most: usize) -> Option<f64> {
    let mut turns = Vec::new();
    let mut from = side(last);
    for i in (0..last).rev() {
        let now = side(i);
        if now != 0 && now != from {
            from = now;
            turns.push(time[i]);
            if turns.len() > most {
                break;
            }
        }
    }
    median(&mut turns.windows(2).map(|w| w[0] - w[1]).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{EndReason, Options, analyse};
    use crate::{Oscillator, Parameter, Record};

    const DELTA: f64 = 0.12;
    const STEP: f64 = 0.02;

    /// 70 s at 30 samples per second from amplitude 1, in steps of a fiftieth, with noise given in steps.
    fn record(x_f: f64, noise_steps: f64, repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(6.0, DELTA, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let zero = 0.37 + 0.11 * repeat as f64;
        let sample = |i: usize| {
            let noise = noise_steps * jitter(i + 2100 * repeat, 5);
            STEP * (decay.displacement(i as f64 / 30.0) / STEP + zero + noise).round()
        };
        Record::uniform(30.0, (0..2100).map(sample).collect()).expect("valid")
    }

    #[test]
    fn a_viscous_decay_that_sinks_below_a_step_is_not_stopped_by_friction() {
        for noise_steps in [0.0, 0.15] {
            for repeat in 0..12 {
                let answer = analyse(&record(0.0, noise_steps, repeat), &Options::default()).expect("fits");
                assert!(!answer.sliding.detected, "{noise_steps}, {repeat}: {:?}", answer.sliding);
                let faded = [EndReason::Resolution, EndReason::Noise].contains(&answer.segment.end_reason);
                assert!(faded, "{:?}", answer.segment);
                assert_eq!(answer.stop, None);
            }
        }
        let options = Options::default();
        assert_held(|repeat| record(0.0, 0.15, repeat), &options, Parameter::DECAY_RATE, DELTA);
    }

    #[test]
    fn the_level_of_a_rest_is_known_to_a_step() {
        let options = Options::default();
        for x_f in [0.03, 0.008] {
            assert_held(|repeat| record(x_f, 0.15, repeat), &options, Parameter::FRICTION_DISPLACEMENT, x_f);
            assert_held(|repeat| record(x_f, 0.15, repeat), &options, Parameter::DECAY_RATE, DELTA);
        }
        let answer = analyse(&record(0.03, 0.15, 0), &options).expect("fits");
        let stop = answer.stop.expect("friction stops it");
        assert!(stop.position.abs() < 0.03 + STEP, "{stop:?}");
        assert_eq!(answer.segment.end_reason, EndReason::Rest);
    }

    #[test]
    fn a_rest_with_noise_of_a_step_is_used_to_its_end() {
        let noisy = record(0.03, 1.0, 0);
        let end = resolved(&noisy.times_s(0..2100), noisy.signal(), STEP, &ResolutionCriteria::default());
        assert_eq!(end, 2100);
        assert!(!may_be_unresolved(noisy.signal(), &ResolutionCriteria::default()));
    }
}

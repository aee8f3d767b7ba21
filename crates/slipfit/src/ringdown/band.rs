//! Samples within a frequency band, filtered such that the filter does not distort the motion itself.

use super::Answer;
use super::criteria::{BandCriteria, Criteria};
use super::sampled_signal::SampledSignal;
use super::samples::{Filtered, Samples};
use super::second_mode::main_mode;
use super::two_modes::mode_in_residuals;
use super::window::{EndReason, StartReason};
use crate::Parameter;
use crate::signal::spectrum;
use std::f64::consts::TAU;
use std::ops::Range;

/// The answer for the motion within a band. The fitted motion is excluded from the filter, iteratively, until
/// the losses no longer change.
///
/// A filter smears the ends of a record, a stop and the turning points of friction over the time
/// `1/(high - low)`, and the amplitudes there follow no law. The residuals of a motion near the true one
/// contain only its errors: they alone are filtered, and the motion is added again.
pub(super) fn beyond_filter<'a>(
    unfiltered: &Samples<'a>,
    filtered: Answer,
    band_hz: [f64; 2],
    criteria: &Criteria,
    analyse: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Answer {
    let mut answer = filtered;
    for _ in 0..criteria.band.rounds {
        let Some((samples, driven_before)) = motion_and_band(unfiltered, &answer, band_hz, criteria) else {
            break;
        };
        let Some(mut found) = analyse(samples) else { break };
        if driven_before && found.segment.start_reason == StartReason::RecordStart {
            found.segment.start_reason = StartReason::LeadIn;
        }
        let settled = is_settled(&answer, &found, &criteria.band);
        answer = found;
        if settled {
            break;
        }
    }
    answer
}

/// The motion of an answer plus its band-passed residuals; also whether samples before the decay are driven
/// and therefore excluded from the filter.
fn motion_and_band<'a>(
    unfiltered: &Samples<'a>,
    answer: &Answer,
    band_hz: [f64; 2],
    criteria: &Criteria,
) -> Option<(Samples<'a>, bool)> {
    let reach_s = criteria.band.reach / (band_hz[1] - band_hz[0]);
    let mut samples = unfiltered.part(described(unfiltered, answer, reach_s));
    let fit = answer.fit.continued_to(samples.time[samples.len() - 1]);
    let mut motion: Vec<f64> = samples.time.iter().map(|t| fit.extrapolated_motion(*t)).collect();
    if !motion.iter().all(|x| x.is_finite()) {
        return None;
    }
    let band_of_left = |samples: &Samples, motion: &[f64]| {
        let left = samples.signal.iter().zip(motion).map(|(x, m)| x - m).collect();
        let left = without_modes_outside(&samples.time, left, answer, band_hz, criteria);
        spectrum::band_pass(&samples.time, &left, band_hz)
    };
    let mut noise = band_of_left(&samples, &motion);
    let first = samples.time.partition_point(|t| *t < answer.fit.range_s()[0]);
    let (before, after) = noise.split_at(first);
    let driven_before = rms(before) > criteria.band.driven * rms(after);
    if driven_before {
        // An impulse or a drive: the filter would smear it over the decay.
        samples = samples.part(first..samples.len());
        motion.drain(..first);
        noise = band_of_left(&samples, &motion);
    }
    let cleaned = noise.iter().zip(&motion).map(|(x, m)| x + m);
    samples.signal = SampledSignal::new(cleaned.collect::<Vec<f64>>());
    // The rest has the level of the motion: the filter removes the level of the samples.
    samples.level_known = false;
    let half_rate_hz = 0.5 * noise.len() as f64 / samples.duration();
    let part_of_noise = (band_hz[1] - band_hz[0]) / half_rate_hz;
    samples.filtered = Filtered::Noise { rms: rms(&noise) / part_of_noise.sqrt() };
    Some((samples, driven_before))
}

/// Root mean square; zero for an empty slice.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// The residuals without the strongest modes outside the band, which have a part inside it where the record
/// truncates them.
fn without_modes_outside(
    time_s: &[f64],
    mut left: Vec<f64>,
    answer: &Answer,
    [low_hz, high_hz]: [f64; 2],
    criteria: &Criteria,
) -> Vec<f64> {
    let Some(main) = main_mode(answer) else { return left };
    for _ in 0..criteria.band.modes {
        let found = mode_in_residuals(time_s, &left, &main, None, criteria);
        let Some(mode) = found.filter(|mode| !(low_hz..=high_hz).contains(&(mode.omega / TAU))) else {
            break;
        };
        left.iter_mut().zip(time_s).for_each(|(x, t)| *x -= mode.at(*t));
    }
    left
}

/// The samples to filter: those of the window, those beside it within reach of the filter, and a rest or
/// noise after it.
fn described(samples: &Samples, answer: &Answer, reach_s: f64) -> Range<usize> {
    let [from_s, to_s] = answer.fit.range_s();
    let to_the_end = matches!(answer.segment.end_reason, EndReason::Noise | EndReason::Rest);
    let last_s = if to_the_end { f64::INFINITY } else { to_s + reach_s };
    samples.time.partition_point(|t| *t < from_s - reach_s)..samples.time.partition_point(|t| *t <= last_s)
}

/// Whether the losses changed by no more than a small fraction of their errors.
fn is_settled(before: &Answer, now: &Answer, criteria: &BandCriteria) -> bool {
    [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT].iter().all(|parameter| {
        let pair = before.parameter(*parameter).zip(now.parameter(*parameter));
        pair.is_none_or(|(a, b)| (a.value - b.value).abs() <= criteria.settled * a.std_error.min(b.std_error))
    })
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Options, StartReason, analyse};
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    const DELTA: f64 = PI * 1.2 / 80.0;

    /// A decay from 0.4 m at 1.2 Hz and Q 80, with another mode.
    fn record(x_f: f64, other: [f64; 2], repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(TAU * 1.2, DELTA, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.4).expect("valid");
        let [frequency_hz, amplitude] = other;
        let sample = |i: usize| {
            let t = i as f64 / 50.0;
            let beside = amplitude * (-0.05 * t).exp() * (TAU * frequency_hz * t + repeat as f64).cos();
            decay.displacement(t) + beside + 5e-4 * jitter(i + 2000 * repeat, 6)
        };
        Record::uniform(50.0, (0..2000).map(sample).collect()).expect("valid").with_unit("m")
    }

    fn within(band_hz: [f64; 2]) -> Options {
        Options { band_hz: Some(band_hz), ..Options::default() }
    }

    #[test]
    fn the_filter_makes_no_friction() {
        for band_hz in [[0.1, 20.0], [0.6, 2.4], [1.0, 1.4]] {
            for repeat in 0..6 {
                let answer = analyse(&record(0.0, [3.0, 0.0], repeat), &within(band_hz)).expect("fits");
                assert!(!answer.sliding.detected, "{band_hz:?}, {repeat}");
                let delta = answer.parameter(Parameter::DECAY_RATE).expect("always reported");
                let [least, most] = delta.interval_95;
                assert!(least <= DELTA && DELTA <= most, "{band_hz:?}, {repeat}: {delta:?}");
            }
        }
    }

    /// A mass hit by an impulse at 0.2 s, with noise of a thousandth: the motion before the impulse is not a
    /// decay.
    #[test]
    fn a_blow_before_the_decay_is_kept_from_the_filter() {
        let struck = |repeat: usize| {
            let of_decay = record(5e-4, [3.0, 0.0], repeat);
            let noise = |i: usize| 5e-4 * jitter(i + 2000 * repeat, 7);
            let blow = |i: usize| if (8..10).contains(&i) { 4.0 } else { 0.0 };
            let before = (0..10).map(|i| blow(i) + noise(i));
            let signal = before.chain(of_decay.signal().iter().copied()).collect();
            Record::uniform(50.0, signal).expect("valid").with_unit("m")
        };
        let options = within([0.6, 2.4]);
        assert_held(struck, &options, Parameter::FRICTION_DISPLACEMENT, 5e-4);
        assert_held(struck, &options, Parameter::DECAY_RATE, DELTA);
        let answer = analyse(&struck(0), &options).expect("fits");
        assert_eq!(answer.segment.start_reason, StartReason::LeadIn);
    }

    #[test]
    fn the_truth_is_held_within_narrow_and_wide_bands() {
        for band_hz in [[0.2, 5.0], [0.6, 2.4], [1.0, 1.4]] {
            let alone = |repeat: usize| record(5e-4, [3.0, 0.0], repeat);
            assert_held(alone, &within(band_hz), Parameter::FRICTION_DISPLACEMENT, 5e-4);
            assert_held(alone, &within(band_hz), Parameter::DECAY_RATE, DELTA);
        }
        let beside = |repeat: usize| record(5e-4, [3.0, 0.1], repeat);
        assert_held(beside, &within([0.5, 2.0]), Parameter::FRICTION_DISPLACEMENT, 5e-4);
    }
}

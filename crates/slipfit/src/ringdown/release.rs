//! Held start: the stretch in which the mass is held at a deflection before its release.

use super::criteria::HeldCriteria;
use crate::numeric::robust::{deviation, median};
use crate::numeric::sum_of;
use std::ops::Range;

/// Numbers of windows that the record is divided into: more windows resolve a short hold, fewer average more
/// noise.
const WINDOWS: [usize; 2] = [256, 1024];
/// Minimum number of samples per window.
const LEAST_WINDOW: usize = 4;
/// Minimum number of windows of a record for the search for a held start.
const LEAST_WINDOWS: usize = 16;
/// The last 1/2, 1/4 and 1/8 of the record in which the rest position is searched for: a hold may be longer
/// than the motion.
const REST_PARTS: [usize; 3] = [2, 4, 8];
/// Fraction of the deflection attributed to rounding.
const ROUNDING: f64 = 1e-9;

/// The first sample after the release if the record shows the mass held at a deflection; otherwise `None`.
///
/// A long hold before the decay is a step, which has more power at low frequencies than the motion. The hold
/// is the longest run of windows at one level away from the rest position, with no oscillation before it and
/// no larger deflection after it, and followed at once by motion to the other side. (A slow oscillation, in
/// contrast, leaves its crest as slowly as the crest lasts.)
pub(crate) fn release(signal: &[f64], criteria: &HeldCriteria) -> Option<usize> {
    let mut lengths = WINDOWS.map(|windows| signal.len().div_ceil(windows).max(LEAST_WINDOW)).to_vec();
    lengths.dedup();
    lengths.into_iter().find_map(|length| {
        let means: Vec<f64> = signal.chunks(length).map(mean).collect();
        if means.len() < LEAST_WINDOWS {
            return None;
        }
        REST_PARTS.into_iter().find_map(|part| {
            let centre = median(&mut means[means.len() - means.len() / part..].to_vec())?;
            release_from(signal, length, &means, centre, criteria)
        })
    })
}

/// The release for a given rest position, from the means of windows of one length.
fn release_from(
    signal: &[f64],
    length: usize,
    means: &[f64],
    centre: f64,
    criteria: &HeldCriteria,
) -> Option<usize> {
    let n = signal.len();
    let held = longest_level(means, centre, criteria.level_range)?;
    let level = median(&mut means[held.clone()].to_vec())?;
    // Scaled such that the held level is 1 and the rest position 0.
    let relative = |x: f64| (x - centre) / (level - centre);
    let (before, after) = (&signal[..held.start * length], &signal[held.end * length..]);
    let across = before.iter().filter(|x| relative(**x) < -criteria.across).count();
    let widest = means[held.end..].iter().map(|m| relative(*m).abs()).fold(0.0, f64::max);
    let leaving = means[held.end..].iter().position(|m| relative(*m) < criteria.left)?;
    // Reaching the other side takes three times as long as leaving the held level.
    let first_swing = criteria.leaving_times * ((leaving + 1) * length) as f64;
    let swings = after.iter().take(first_swing as usize).any(|x| relative(*x) < -criteria.left);
    if !swings
        || across as f64 > criteria.across_part * before.len() as f64
        || widest > criteria.widest
        || (held.len() as f64) < criteria.leaving_times * (leaving + 1) as f64
    {
        return None;
    }
    // The last windows may contain the beginning of the motion.
    let samples = signal[held.start * length..held.end * length].iter();
    let noise_rms = deviation(samples.map(|x| x - level))?;
    let last = (held.end + 1) * length;
    let still = |x: &f64| {
        (x - level).abs() <= criteria.release_errors * noise_rms + ROUNDING * (level - centre).abs()
    };
    let from = held.start * length;
    let released = from + signal[from..last.min(n)].iter().rposition(still)? + 1;
    (n - released >= LEAST_WINDOWS * LEAST_WINDOW).then_some(released)
}

/// The longest run of windows whose means have a range within a fraction `range` of their distance from the
/// centre.
fn longest_level(means: &[f64], centre: f64, range: f64) -> Option<Range<usize>> {
    let mut longest = 0..0;
    for start in 0..means.len() {
        let Some(&beyond) = means.get(start + longest.len()) else { break };
        let (mut least, mut most) = (means[start], means[start]);
        let level = |least: f64, most: f64| {
            let distance = (least - centre).abs().min((most - centre).abs());
            (least > centre) == (most > centre) && most - least <= range * distance && distance > 0.0
        };
        // In a longer run both of these windows must be at its level.
        if !level(least.min(beyond), most.max(beyond)) {
            continue;
        }
        let mut end = start;
        while let Some(m) = means.get(end) {
            (least, most) = (least.min(*m), most.max(*m));
            if !level(least, most) {
                break;
            }
            end += 1;
        }
        if end - start > longest.len() {
            longest = start..end;
        }
    }
    (!longest.is_empty() && longest.end < means.len()).then_some(longest)
}

fn mean(values: &[f64]) -> f64 {
    sum_of(values, |x| x) / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Options, StartReason, analyse};
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    const DELTA: f64 = 0.05;

    /// 40 s at 50 samples per second, released after `held_s` from 0.4.
    fn record(held_s: f64, noise: f64, repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(7.0, DELTA, 0.008).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.4).expect("valid");
        let time: Vec<f64> = (0..2000).map(|i| 0.02 * i as f64).collect();
        let angle = |t: f64| if t < held_s { 0.4 } else { decay.displacement(t - held_s) };
        let noisy = |(i, &t): (usize, &f64)| 0.1 + angle(t) + noise * jitter(2000 * repeat + i, 7);
        let signal = time.iter().enumerate().map(noisy).collect();
        Record::new(time, signal).expect("valid").with_unit("rad")
    }

    #[test]
    fn a_held_mass_is_left_out_up_to_its_release() {
        let criteria = HeldCriteria::default();
        for held_s in [4.0, 8.0, 15.0] {
            for (noise, late_s) in [(0.0, 0.04), (0.004, 0.06), (0.06, 0.3)] {
                let record = record(held_s, noise, 0);
                let first = release(record.signal(), &criteria).expect("held");
                let after_s = 0.02 * first as f64 - held_s;
                assert!((-0.04..=late_s + 0.03).contains(&after_s), "{held_s} s, noise {noise}: {after_s} s");
            }
        }
    }

    /// A cycle of a hundred windows, and a hold longer than the motion after it.
    #[test]
    fn a_release_is_found_in_short_records() {
        let oscillator = Oscillator::kinematic(TAU, PI / 9.0, 0.02).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        for (held_s, moving_s, rate_hz) in [(5.0, 8.0, 30.0), (5.0, 8.0, 120.0), (9.0, 4.0, 60.0)] {
            let sample = |i: usize| {
                let t = i as f64 / rate_hz - held_s;
                (if t < 0.0 { 1.0 } else { decay.displacement(t) }) + 3e-3 * jitter(i, 5)
            };
            let signal: Vec<f64> = (0..((held_s + moving_s) * rate_hz) as usize).map(sample).collect();
            let first = release(&signal, &HeldCriteria::default()).expect("held");
            let after_s = first as f64 / rate_hz - held_s;
            assert!((0.0..0.06).contains(&after_s), "{held_s} s at {rate_hz} Hz: {after_s} s");
        }
    }

    #[test]
    fn the_analysis_begins_at_the_release() {
        let answer = analyse(&record(15.0, 0.004, 0), &Options::default()).expect("a ring-down");
        assert_eq!(answer.segment.start_reason, StartReason::Held);
        assert!((answer.segment.start_s - 15.0).abs() < 0.1, "{}", answer.segment.start_s);
        let options = Options::default();
        assert_held(|repeat| record(15.0, 0.02, repeat), &options, Parameter::DECAY_RATE, DELTA);
        assert_held(|repeat| record(15.0, 0.02, repeat), &options, Parameter::FRICTION_DISPLACEMENT, 0.008);
    }

    /// Slow oscillations starting at a crest, with and without noise; a creep back to rest; noise alone.
    #[test]
    fn motion_is_no_hold() {
        let criteria = HeldCriteria::default();
        let motion = |omega: f64, i: usize| (-1e-3 * i as f64).exp() * (omega * i as f64).cos();
        for (k, omega) in [0.003, 0.01, 0.03, 0.3, 2.0].into_iter().enumerate() {
            for noise in [0.0, 0.02, 0.2] {
                let signal: Vec<f64> =
                    (0..3000).map(|i| motion(omega, i) + noise * jitter(i, k as u64)).collect();
                assert_eq!(release(&signal, &criteria), None, "{omega}, {noise}");
            }
        }
        let dropped = [vec![1.0; 600], vec![0.0; 2400]].concat();
        assert_eq!(release(&dropped, &criteria), None);
        let creep: Vec<f64> = (0..3000).map(|i| (-2e-3 * f64::from(i)).exp()).collect();
        assert_eq!(release(&creep, &criteria), None);
        for k in 0..20 {
            let noise: Vec<f64> = (0..3000).map(|i| jitter(i, k)).collect();
            assert_eq!(release(&noise, &criteria), None, "{k}");
        }
    }

    #[test]
    fn hostile_signals_have_an_answer() {
        let criteria = HeldCriteria::default();
        for signal in [vec![], vec![1.0; 9], vec![0.0; 500], [vec![1e300; 250], vec![-1e300; 250]].concat()] {
            let released = release(&signal, &criteria);
            assert!(released.is_none_or(|first| first < signal.len()), "{released:?}");
        }
    }
}

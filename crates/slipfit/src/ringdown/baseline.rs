//! Baseline: a level about which the motion swings that wanders along a curve, subtracted.

use super::criteria::BaselineCriteria;
use super::level::{Baseline, Position};
use super::samples::Samples;
use super::{Answer, Criteria};
use crate::Parameter;
use crate::inference::least_squares::linear;
use crate::numeric::robust::neighbour_noise;
use crate::signal::spectrum::dominant;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Levels of a record at most.
const LEVELS: f64 = 400.0;
/// Samples of a level at least.
const LEAST_SAMPLES: usize = 8;

/// The samples without their baseline, and it; `None` where the levels about which `answer` swings, or the
/// strongest oscillation where there is none, lie on a parabola that is not steep, which every fit has, or where cycles
/// are few.
///
/// The level of each cycle is that of a local fit of level, slope and an oscillation with its slope. Of polynomials of
/// time that with the least BIC is taken, the noise of the levels being that from one to the next.
pub(crate) fn without_baseline<'a>(
    samples: &Samples<'a>,
    answer: Option<&Answer>,
    criteria: &BaselineCriteria,
) -> Option<(Samples<'a>, Baseline)> {
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    if time.len() > criteria.most_samples {
        return None;
    }
    // Before the decay a drive or a hand moves the level.
    let from_s = answer.map_or(time[0], |answer| answer.segment.start_s);
    let at = Position::between(from_s, time[time.len() - 1]);
    let frequency_hz = match answer {
        Some(answer) => answer.parameter(Parameter::Frequency)?.value,
        None => {
            let all: Vec<(f64, f64)> = time.iter().copied().zip(signal.iter().copied()).collect();
            let (curve, _) = polynomial(&all, &at, criteria.most_degree)?;
            let rough = Baseline { at, curve, range: 0.0 };
            dominant(time, &less(time, signal, &rough), None)?.frequency_hz
        }
    };
    if !(frequency_hz * samples.duration() >= criteria.least_cycles) {
        return None;
    }
    let from = time.partition_point(|t| *t < from_s).min(time.len() - 1);
    let levels = levels(&time[from..], &signal[from..], frequency_hz);
    let most = criteria.most_degree.min(levels.len() / criteria.levels_per_degree);
    let values: Vec<f64> = levels.iter().map(|l| l.1).collect();
    let variance = neighbour_noise(values.windows(3))?.powi(2).max(f64::MIN_POSITIVE);
    let price = (levels.len() as f64).ln();
    let fits = (0..=most).filter_map(|degree| {
        let (curve, rss) = polynomial(&levels, &at, degree)?;
        Some((rss / variance + price * degree as f64, curve))
    });
    let (_, curve) = fits.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(_, curve)| curve.len() > 1)?;
    let is_parabola = curve.len() <= 3;
    let mut baseline = Baseline { at, curve, range: 0.0 };
    let flat = less(time, signal, &baseline);
    let moved = signal.iter().zip(&flat).map(|(before, after)| before - after);
    let (low, high) = moved.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m), h.max(m)));
    baseline.range = high - low;
    // A steep one hides frequency, rest and end before any fit.
    let first = answer.and_then(|a| a.parameter(Parameter::InitialAmplitude)).map_or(0.0, |a| a.value);
    if is_parabola && baseline.range < criteria.steep * first {
        return None;
    }
    Some((
        Samples {
            signal: Cow::Owned(flat),
            level_known: false,
            rest: samples.rest_alone(),
            ..samples.clone()
        },
        baseline,
    ))
}

/// Whether an answer about samples without a baseline describes them better.
pub(crate) fn better(found: &Answer, before: Option<&Answer>, criteria: &Criteria) -> bool {
    let Some(before) = before else { return true };
    let (found, before) = (&found.diagnostics, &before.diagnostics);
    let noise = |d: &super::Diagnostics| d.noise_rms.powi(2) * d.residual_excess.max(1.0);
    let gained =
        if found.method == "waveform" && before.method != "waveform" { 1.0 } else { criteria.baseline.gain };
    noise(found) < gained * noise(before)
}

/// Coefficients of a polynomial through values at instants, and the sum of squares it leaves.
fn polynomial(values: &[(f64, f64)], at: &Position, degree: usize) -> Option<(Vec<f64>, f64)> {
    let rows = values.iter().map(|(t, y)| (at.basis(*t, degree), *y, 1.0));
    linear(rows, degree + 1).map(|(coefficients, _, rss)| (coefficients, rss))
}

/// A signal less a baseline.
fn less(time: &[f64], signal: &[f64], baseline: &Baseline) -> Vec<f64> {
    time.iter().zip(signal).map(|(t, x)| x - baseline.value(*t)).collect()
}

/// Instants and levels of stretches of at least a cycle.
fn levels(time: &[f64], signal: &[f64], frequency_hz: f64) -> Vec<(f64, f64)> {
    let cycles = ((time[time.len() - 1] - time[0]) * frequency_hz / LEVELS).ceil().max(1.0);
    let span_s = cycles / frequency_hz;
    let mut found = Vec::new();
    let mut from = 0;
    while from < time.len() {
        let start = time[from];
        let end = from + time[from..].partition_point(|t| t - start < span_s);
        if end == time.len() {
            break;
        }
        if end - from >= LEAST_SAMPLES {
            let middle = start + 0.5 * span_s;
            let rows = time[from..end].iter().zip(&signal[from..end]).map(|(t, x)| {
                let u = (t - middle) / span_s;
                let (sin, cos) = (TAU * frequency_hz * (t - middle)).sin_cos();
                (vec![1.0, u, cos, sin, u * cos, u * sin], *x, 1.0)
            });
            found.extend(linear(rows, 6).map(|(level, _, _)| (middle, level[0])));
        }
        from = end.max(from + 1);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::PI;

    const DELTA: f64 = 0.05;
    const X_F: f64 = 0.006;

    /// 50 s at 40 samples a second from 1, about a level that is given along the record, from 0 to 1.
    fn record(level: fn(f64) -> f64, repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(7.0, DELTA, X_F).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let sample = |i: usize| {
            let t = i as f64 / 40.0;
            decay.displacement(t) + level(t / 50.0) + 0.005 * jitter(i + 2000 * repeat, 6)
        };
        Record::uniform(40.0, (0..2000).map(sample).collect()).expect("valid")
    }

    fn told(level: fn(f64) -> f64) -> Vec<&'static str> {
        let answer = analyse(&record(level, 0), &Options::default()).expect("a ring-down");
        answer.warnings.iter().map(|w| w.code()).collect()
    }

    #[test]
    fn a_curved_baseline_leaves_friction_and_decay_rate_where_they_are() {
        let levels: [fn(f64) -> f64; 3] =
            [|v| 0.3 * (2.2 * PI * v + 1.0).sin(), |v| (-4.0 * v).exp(), |v| (4.0 * PI * v).sin()];
        let record_0 = record(levels[0], 0);
        let fit = analyse(&record_0, &Options::default()).expect("a ring-down").fit;
        let off =
            record_0.signal().iter().enumerate().map(|(i, x)| (x - fit.signal_at(i as f64 / 40.0)).abs());
        assert!(off.filter(|off| off.is_finite()).fold(0.0, f64::max) < 0.03);
        assert!(told(levels[0]).contains(&"baseline"));
        assert!(told(levels[2]).contains(&"baseline"));
        for level in levels {
            let options = Options::default();
            assert_held(|repeat| record(level, repeat), &options, Parameter::DECAY_RATE, DELTA);
            assert_held(|repeat| record(level, repeat), &options, Parameter::FRICTION_DISPLACEMENT, X_F);
        }
    }

    /// Six times as high as the motion: the levels tell the rest from the motion no more, and their mean is none of rest.
    #[test]
    fn a_steep_baseline_hides_no_rest() {
        let (delta, x_f) = (0.018, 0.0093);
        let oscillator = Oscillator::kinematic(4.6, delta, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let record = |repeat: usize| {
            let sample = |i: usize| {
                let t = i as f64 / 36.0;
                decay.displacement(t) - 0.17 * t + 0.016 * jitter(i + 1224 * repeat, 6)
            };
            Record::uniform(36.0, (0..1224).map(sample).collect()).expect("valid")
        };
        let options = Options::default();
        assert_held(record, &options, Parameter::DECAY_RATE, delta);
        assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, x_f);
    }

    #[test]
    fn a_straight_or_parabolic_baseline_is_part_of_every_fit() {
        let levels: [fn(f64) -> f64; 3] = [|_| 0.0, |v| 2.0 * v, |v| v * (1.0 - v)];
        assert!(levels.into_iter().all(|level| !told(level).contains(&"baseline")));
    }
}

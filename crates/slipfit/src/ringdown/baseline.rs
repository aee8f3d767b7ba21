//! Baseline: the level about which the motion oscillates, if it wanders along a curve; it is subtracted.

use super::Answer;
use super::criteria::{BaselineCriteria, Criteria};
use super::level::{Baseline, Position};
use super::sampled_signal::SampledSignal;
use super::samples::Samples;
use crate::Parameter;
use crate::inference::least_squares::{Normal, linear, linear_of};
use crate::numeric::robust::{median, neighbour_noise};
use crate::signal::spectrum::dominant;
use std::f64::consts::TAU;
use std::ops::Range;

/// Maximum number of levels of a record.
const LEVELS: f64 = 400.0;
/// Number of parts of a decay whose median levels are compared.
const PARTS: usize = 8;
/// Minimum number of samples per level.
const LEAST_SAMPLES: usize = 8;
/// Columns of level, slope, the oscillation and its slope; then the same with the second harmonic.
const FIRST: Range<usize> = 0..6;
const WITH_SECOND: Range<usize> = 0..8;

/// The level of a stretch of the record, and its second harmonic.
struct Level {
    time_s: f64,
    value: f64,
    second: Option<SecondHarmonic>,
}

/// Second harmonic of a stretch, in phase with the square of the motion.
struct SecondHarmonic {
    amplitude: f64,
    squared_motion: f64,
    weight: f64,
}

/// The samples without their baseline, and the baseline. `None` if the levels about which `answer` oscillates
/// (or, without an answer, the strongest oscillation) lie on a parabola that is not steep, which every fit
/// includes, or if there are few cycles.
///
/// The level of each cycle comes from a local fit of level, slope and an oscillation with its slope. Of the
/// polynomials in time the one with the least BIC is used; the noise of the levels is estimated from
/// neighbouring levels.
pub(crate) fn without_baseline<'a>(
    samples: &Samples<'a>,
    answer: Option<&Answer>,
    criteria: &Criteria,
) -> Option<(Samples<'a>, Baseline)> {
    let Criteria { spectrum: lines, baseline: criteria, .. } = criteria;
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let most_stride = (time.len() / criteria.most_samples).max(1);
    // Before the decay a drive or a hand shifts the level.
    let from_s = answer.map_or(time[0], |answer| answer.segment.start_s);
    let at = Position::between(from_s, time[time.len() - 1]);
    let frequency_hz = match answer {
        Some(answer) => answer.parameter(Parameter::Frequency)?.value,
        None => {
            let all: Vec<(f64, f64)> =
                time.iter().copied().zip(signal.iter().copied()).step_by(most_stride).collect();
            let (curve, _) = polynomial(&all, &at, criteria.most_degree)?;
            let rough = Baseline { at, curve, range: 0.0, goes_with_motion: false };
            dominant(time, &subtract(time, signal, &rough), None, lines)?.frequency_hz
        }
    };
    if !(frequency_hz * samples.duration() >= criteria.least_cycles) {
        return None;
    }
    let from = time.partition_point(|t| *t < from_s).min(time.len() - 1);
    let per_cycle = time.len() as f64 / (samples.duration() * frequency_hz);
    let stride = most_stride.min((per_cycle / criteria.samples_per_cycle) as usize).max(1);
    let thinned = |values: &[f64]| values[from..].iter().step_by(stride).copied().collect::<Vec<f64>>();
    let stretches = if stride == 1 {
        levels(&time[from..], &signal[from..], frequency_hz)
    } else {
        levels(&thinned(time), &thinned(signal), frequency_hz)
    };
    let levels: Vec<(f64, f64)> = stretches.iter().map(|l| (l.time_s, l.value)).collect();
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
    let mut baseline = Baseline { at, curve, range: 0.0, goes_with_motion: false };
    baseline.goes_with_motion = goes_with_motion(&stretches, &baseline, criteria);
    let flat = subtract(time, signal, &baseline);
    baseline.range = range(signal.iter().zip(&flat).map(|(before, after)| before - after));
    // A steep parabola prevents any fit from finding frequency, rest and end.
    let first = answer.and_then(|a| a.parameter(Parameter::InitialAmplitude)).map_or(0.0, |a| a.value);
    if is_parabola && baseline.range < criteria.steep * first {
        return None;
    }
    Some((
        Samples {
            signal: SampledSignal::new(flat),
            level_known: false,
            rest: samples.rest_alone(),
            ..samples.clone()
        },
        baseline,
    ))
}

/// Whether an answer for samples without a baseline describes them better.
pub(crate) fn better(
    found: &Answer,
    before: Option<&Answer>,
    baseline: &Baseline,
    criteria: &BaselineCriteria,
) -> bool {
    let Some(before) = before else { return true };
    let first = before.parameter(Parameter::InitialAmplitude).map_or(0.0, |a| a.value);
    let (found, before) = (&found.diagnostics, &before.diagnostics);
    let noise = |d: &super::Diagnostics| d.noise_rms.powi(2) * d.residual_excess.max(1.0);
    // A slowly wandering level adds nothing to the noise within single cycles: a curve that increases this
    // noise is no baseline.
    let as_quiet = found.noise_rms.powi(2) <= criteria.noise_of_wide * before.noise_rms.powi(2);
    let is_wide = baseline.range > criteria.wide * first && !baseline.goes_with_motion && as_quiet;
    let gained = if is_wide {
        criteria.gain_of_wide
    } else if found.method == "waveform" && before.method != "waveform" {
        1.0
    } else {
        criteria.gain
    };
    noise(found) < gained * noise(before)
}

/// Whether the range of the level about which the cycles of an answer oscillate exceeds both its noise and the
/// fraction of the first amplitude that matters.
pub(crate) fn level_moves(answer: &Answer, criteria: &BaselineCriteria) -> bool {
    let levels: Vec<f64> = answer.fit.knots.iter().map(|knot| knot.offset).collect();
    let first = answer.parameter(Parameter::InitialAmplitude);
    let Some((noise, first)) = neighbour_noise(levels.windows(3)).zip(first) else { return false };
    let together = levels.len().div_ceil(PARTS);
    let moved = range(levels.chunks(together).filter_map(|part| median(&mut part.to_vec())));
    let errors = moved / (noise / (together as f64).sqrt()).max(f64::MIN_POSITIVE);
    moved > criteria.moving * first.value && errors > criteria.moving_errors
}

/// Coefficients of a polynomial fitted to values at given times, and the residual sum of squares.
fn polynomial(values: &[(f64, f64)], at: &Position, degree: usize) -> Option<(Vec<f64>, f64)> {
    let rows = values.iter().map(|(t, y)| (at.basis(*t, degree), *y, 1.0));
    linear(rows, degree + 1).map(|(coefficients, _, rss)| (coefficients, rss))
}

/// A signal minus a baseline.
fn subtract(time: &[f64], signal: &[f64], baseline: &Baseline) -> Vec<f64> {
    time.iter().zip(signal).map(|(t, x)| x - baseline.value(*t)).collect()
}

/// Maximum minus minimum of the values.
fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}

/// Whether the motion itself shifts the level, as with a nonlinear reading or an asymmetric spring. Such a
/// motion also changes the second harmonic, which a level that wanders independently does not.
///
/// `q x²` raises the level by `q A²/2` and adds the same amplitude of `cos 2φ`; a force `-α x²` lowers the
/// level by `α A²/2ω²`, three times that amplitude.
fn goes_with_motion(levels: &[Level], baseline: &Baseline, criteria: &BaselineCriteria) -> bool {
    let seconds: Vec<&SecondHarmonic> = levels.iter().filter_map(|l| l.second.as_ref()).collect();
    let rows = seconds.iter().map(|h| (vec![h.squared_motion], h.amplitude, h.weight));
    let Some((slope, covariance, rss)) = linear(rows, 1).filter(|_| seconds.len() > 1) else { return false };
    let error = (covariance[(0, 0)] * rss / (seconds.len() - 1) as f64).sqrt();
    let moved = slope[0].abs() * range(seconds.iter().map(|h| h.squared_motion));
    let of_level = range(levels.iter().map(|l| baseline.value(l.time_s)));
    slope[0].abs() > criteria.second_harmonic_errors * error && moved > criteria.second_harmonic * of_level
}

/// Levels of stretches of at least one cycle.
fn levels(time: &[f64], signal: &[f64], frequency_hz: f64) -> Vec<Level> {
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
            let mut sums = Normal::zeros(WITH_SECOND.end);
            for (t, x) in time[from..end].iter().zip(&signal[from..end]) {
                let u = (t - middle) / span_s;
                let angle = TAU * frequency_hz * (t - middle);
                let ((sin, cos), (sin_2, cos_2)) = (angle.sin_cos(), (2.0 * angle).sin_cos());
                sums.add_row(&[1.0, u, cos, sin, u * cos, u * sin, cos_2, sin_2], *x, 1.0);
            }
            let level = linear_of(&sums, &FIRST.collect::<Vec<usize>>());
            found.extend(level.map(|(level, ..)| Level {
                time_s: middle,
                value: level[0],
                second: second_harmonic(&sums),
            }));
        }
        from = end.max(from + 1);
    }
    found
}

fn second_harmonic(sums: &Normal) -> Option<SecondHarmonic> {
    let (by, covariance, _) = linear_of(sums, &WITH_SECOND.collect::<Vec<usize>>())?;
    let (cos, sin) = (by[2], by[3]);
    let squared_motion = cos * cos + sin * sin;
    // Components of the square of the motion, scaled to a level of 1.
    let [cos_2, sin_2] = [(cos * cos - sin * sin) / squared_motion, 2.0 * cos * sin / squared_motion];
    let variance = cos_2 * cos_2 * covariance[(6, 6)]
        + sin_2 * sin_2 * covariance[(7, 7)]
        + 2.0 * cos_2 * sin_2 * covariance[(6, 7)];
    let found =
        SecondHarmonic { amplitude: by[6] * cos_2 + by[7] * sin_2, squared_motion, weight: variance.recip() };
    (found.amplitude.is_finite() && found.weight.is_finite() && found.weight > 0.0).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::Criteria;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::PI;

    const DELTA: f64 = 0.05;
    const X_F: f64 = 0.006;

    /// 50 s at 40 samples per second from amplitude 1, about a level given as a function of the position in
    /// the record (0 to 1).
    fn record(level: fn(f64) -> f64, repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(7.0, DELTA, X_F).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let sample = |i: usize| {
            let t = i as f64 / 40.0;
            decay.displacement(t) + level(t / 50.0) + 0.005 * jitter(i + 2000 * repeat, 6)
        };
        Record::uniform(40.0, (0..2000).map(sample).collect()).expect("valid")
    }

    fn warnings_of(level: fn(f64) -> f64) -> Vec<&'static str> {
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
        assert!(warnings_of(levels[0]).contains(&"baseline"));
        assert!(warnings_of(levels[2]).contains(&"baseline"));
        for level in levels {
            let options = Options::default();
            assert_held(|repeat| record(level, repeat), &options, Parameter::DECAY_RATE, DELTA);
            assert_held(|repeat| record(level, repeat), &options, Parameter::FRICTION_DISPLACEMENT, X_F);
        }
    }

    /// Wandering noise hides what a relaxing level adds to the first amplitudes; a range of 2 % may be no
    /// baseline.
    #[test]
    fn a_wide_baseline_is_subtracted_without_a_gain_unless_the_motion_makes_it() {
        let answer = analyse(&record(|_| 0.0, 0), &Options::default()).expect("a ring-down");
        let subtracted = |range: f64, goes_with_motion: bool| {
            let at = Position::between(0.0, 50.0);
            let baseline = Baseline { at, curve: vec![0.0; 5], range, goes_with_motion };
            better(&answer, Some(&answer), &baseline, &BaselineCriteria::default())
        };
        assert!(subtracted(0.2, false) && !subtracted(0.2, true) && !subtracted(0.02, false));
    }

    /// The level relaxes by one and a half times the first amplitude and performs a random walk, which leaves
    /// the variance unchanged.
    #[test]
    fn a_level_that_relaxes_and_walks_leaves_friction_and_decay_rate_where_they_are() {
        let (delta, x_f) = (0.08, 0.003);
        let oscillator = Oscillator::kinematic(7.0, delta, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let record = |repeat: usize| {
            let mut walk = 0.0;
            let sample = |i: usize| {
                let t = i as f64 / 15.0;
                walk += 0.002 * jitter(i + 600 * repeat, 7);
                decay.displacement(t) + 1.5 * (-t / 6.0).exp() + walk + 0.001 * jitter(i + 600 * repeat, 6)
            };
            Record::uniform(15.0, (0..600).map(sample).collect()).expect("valid")
        };
        let options = Options::default();
        assert_held(record, &options, Parameter::DECAY_RATE, delta);
        assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, x_f);
    }

    #[test]
    fn a_level_that_the_motion_moves_is_no_baseline() {
        let follows_motion = |reading: fn(f64, f64) -> f64, repeat: usize| {
            let oscillator = Oscillator::kinematic(7.0, DELTA, X_F).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let sample = |i: usize| {
                let t = i as f64 / 40.0;
                reading(decay.displacement(t), t) + 0.005 * jitter(i + 2000 * repeat, 6)
            };
            let record = Record::uniform(40.0, (0..2000).map(sample).collect()).expect("valid");
            let (options, criteria) = (Options::default(), Criteria::default());
            let samples = Samples::prepare(&record, &options, &criteria).expect("samples");
            let found = without_baseline(&samples, None, &criteria);
            found.expect("the level moves along a curve").1.goes_with_motion
        };
        // A nonlinear reading, and a level that drifts by itself as fast as the square of the amplitude
        // falls.
        for repeat in 0..8 {
            assert!(follows_motion(|x, _| x - 0.2 * x * x, repeat), "{repeat}");
            assert!(follows_motion(|x, t| x - 0.1 * (-0.13 * t).exp() + 0.2 * x * x, repeat), "{repeat}");
            assert!(!follows_motion(|x, t| x - 0.1 * (-0.13 * t).exp(), repeat), "{repeat}");
        }
    }

    /// A baseline six times as high as the motion: the levels no longer separate rest and motion, and their
    /// mean is not the rest.
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
        assert!(levels.into_iter().all(|level| !warnings_of(level).contains(&"baseline")));
    }
}

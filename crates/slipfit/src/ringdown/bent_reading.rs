//! Bent reading: a sensor curve found by the harmonics that the motion leaves, and straightened.

use super::Answer;
use super::criteria::SensorCriteria;
use super::remainder::Harmonics;
use super::samples::Samples;
use super::sensor_curve::SensorCurve;
use super::window_fit::WAVEFORM;
use crate::answer::Warning;
use crate::inference::evidence::chi_square_tail;
use crate::inference::least_squares::linear;
use crate::model::loss::LossModel;
use crate::{Parameter, Quantity};
use std::borrow::Cow;

/// Rounds, at most, in which the curve is estimated from what the motion leaves and the motion fitted to the straightened
/// reading. The first takes the amplitude as it is read: of a cubic part of a tenth it makes an eighth.
const ROUNDS: usize = 8;
/// Part of its standard error by which the cubic coefficient moves in the last of them, and of a strong line the
/// quadratic one.
const SETTLED: f64 = 0.1;

/// Coefficients by which a reading still bends, and the standard error of the cubic one.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    quadratic: f64,
    cubic: f64,
    cubic_error: f64,
}

/// The answer by `refit` to the straightened reading, where the samples show a second or third harmonic in phase with the
/// motion that falls as the square or cube of the amplitude, beyond what a spring that stiffens gives. A reading that bends
/// by more than such a curve describes is warned of.
///
/// Losses make harmonics in quadrature to the motion, electronics in proportion to it. The error of the curve counts in
/// every parameter by the difference that it makes.
pub(crate) fn straightened<'a>(
    samples: &Samples<'a>,
    mut answer: Answer,
    criteria: &SensorCriteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Answer {
    let bends = |e: &Estimate| e.quadratic != 0.0 || e.cubic.abs() > criteria.significance * e.cubic_error;
    let may_bend = may_bend(&answer, criteria);
    let estimate = may_bend.then(|| bend(samples, &answer, criteria, None).filter(bends)).flatten();
    let Some(estimate) = estimate else { return answer };
    if let Some(found) = along_curve(samples, &answer, estimate, criteria, refit) {
        return found;
    }
    let named = answer.warnings.iter().any(|w| matches!(w, Warning::Harmonics { .. }));
    let relative_amplitude =
        0.25 * estimate.cubic.abs() * answer.fit.amplitude_at(answer.fit.start_s).powi(2);
    let sure = estimate.cubic.abs() > criteria.unstraightened_errors * estimate.cubic_error;
    if sure && relative_amplitude > criteria.unstraightened && !named {
        answer.warnings.push(Warning::Harmonics { order: 3, relative_amplitude });
    }
    answer
}

/// The answer to the reading straightened along a curve of which there is an estimate; `None` where no curve describes it.
fn along_curve<'a>(
    samples: &Samples<'a>,
    answer: &Answer,
    estimate: Estimate,
    criteria: &SensorCriteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Option<Answer> {
    // At the start the mean of a bent reading is another one.
    let centre = answer.fit.knots.last()?.offset;
    let Estimate { quadratic, cubic, cubic_error: cubic_std_error } = estimate;
    let mut curve = SensorCurve { centre, quadratic, cubic, cubic_std_error };
    let by = |curve: SensorCurve| {
        let straight: Option<Vec<f64>> = samples.signal.iter().map(|s| curve.straightened(*s)).collect();
        let straight =
            Samples { signal: Cow::Owned(straight?), rest: samples.rest_alone(), ..samples.clone() };
        let found = refit(straight.clone()).filter(|found| found.diagnostics.method == WAVEFORM)?;
        Some((straight, found))
    };
    let (mut straight, mut found) = by(curve)?;
    for _ in 1..ROUNDS {
        let Some(more) = bend(&straight, &found, criteria, Some(&curve)) else { break };
        curve.quadratic += more.quadratic;
        curve.cubic += more.cubic;
        curve.cubic_std_error = more.cubic_error;
        (straight, found) = by(curve)?;
        let bends = more.quadratic.abs() * answer.fit.amplitude_at(answer.fit.start_s);
        if more.cubic.abs() < SETTLED * more.cubic_error && bends < SETTLED * criteria.strong_line {
            break;
        }
    }
    let amplitude = found.parameter(Parameter::InitialAmplitude)?.value;
    let third = 0.25 * curve.cubic * amplitude.powi(2);
    let better = found.diagnostics.residual_rms < answer.diagnostics.residual_rms;
    let describes = better || answer.diagnostics.method != WAVEFORM;
    if !describes || third.abs() > criteria.most {
        return None;
    }
    let (_, beside) = by(SensorCurve { cubic: curve.cubic + curve.cubic_std_error, ..curve })?;
    let list: Vec<Parameter> = found.parameters.iter().map(|(p, _)| p).collect();
    for parameter in list {
        let difference = beside.parameter(parameter).map(|q| q.unbounded_value);
        if let (Some(quantity), Some(there)) = (found.parameters.get_mut(parameter), difference) {
            *quantity = with_error(quantity.clone(), there - quantity.unbounded_value);
        }
    }
    let x_f = found.parameter(Parameter::FRICTION_DISPLACEMENT)?;
    let errors = x_f.value / x_f.std_error;
    counting_the_curve(&mut found, errors, criteria);
    found.fit.sensor_curve = Some(curve);
    found.sensor_curve = Some(curve);
    let relative = curve.quadratic.abs() * amplitude + curve.cubic.abs() * amplitude.powi(2);
    found.warnings.push(Warning::SensorCurve { relative });
    Some(found)
}

/// The evidence for friction of `errors` standard errors, those of the curve included: what the curve may have made of a
/// viscous decay is no evidence.
fn counting_the_curve(answer: &mut Answer, errors: f64, criteria: &SensorCriteria) {
    let viscous = answer.preferred_model.is_within(LossModel::VISCOUS_SLIDING);
    let by_chance = 0.5 * chi_square_tail(errors * errors, 1.0);
    let evidence = &mut answer.sliding;
    evidence.p_value = evidence.p_value.max(by_chance);
    evidence.detected &= errors > criteria.friction_errors;
    if viscous && evidence.viscous_only_p_value < 1.0 {
        evidence.viscous_only_p_value = evidence.viscous_only_p_value.max(by_chance);
        evidence.viscous_only_excluded &= errors > criteria.friction_errors;
    }
}

fn with_error(quantity: Quantity, extra: f64) -> Quantity {
    if extra.is_finite() { quantity.with_error(extra) } else { quantity }
}

/// Whether the samples may bend: where every sample is compared with the motion, by the harmonics that it leaves;
/// elsewhere by the strongest line.
fn may_bend(answer: &Answer, criteria: &SensorCriteria) -> bool {
    let fit = &answer.fit;
    let plain = fit.baseline.is_none() && answer.second_mode.is_none() && fit.knots.len() > 1;
    plain
        && match fit.harmonics {
            Some(Harmonics { in_phase: [second, third], .. }) => {
                second.abs() > criteria.quadratic_significance || third.abs() > criteria.significance
            }
            None => {
                answer.diagnostics.distortion.is_some_and(|d| d.relative_amplitude > criteria.strong_line)
            }
        }
}

/// What bends the reading of a fitted motion, by its harmonics; `None` where they are not those of a curve. What is left of
/// one that was `found` counts however small it is.
fn bend(
    samples: &Samples,
    answer: &Answer,
    criteria: &SensorCriteria,
    found: Option<&SensorCurve>,
) -> Option<Estimate> {
    let fit = &answer.fit;
    let [from, to] = fit.range_s();
    let to = fit.rest_s().unwrap_or(to).min(to);
    let range = samples.time.partition_point(|t| *t < from)..samples.time.partition_point(|t| *t <= to);
    let first = fit.amplitude_at(from);
    if !(first > 0.0) {
        return None;
    }
    // Third harmonic in phase and in quadrature, second harmonic with its mean and in quadrature, a level.
    let rows = |powers: [i32; 2]| {
        samples.time[range.clone()].iter().zip(&samples.signal[range.clone()]).filter_map(move |(t, s)| {
            let phase = fit.phase_at(*t)?.phase;
            let a = fit.amplitude_at(*t) / first;
            let [third, second] = powers.map(|power| a.powi(power));
            let (sin_3, cos_3) = (3.0 * phase).sin_cos();
            let (sin_2, cos_2) = (2.0 * phase).sin_cos();
            let row = vec![third * cos_3, third * sin_3, second * cos_2, second * sin_2, second, 1.0];
            Some((row, s - fit.signal_at(*t), 1.0)).filter(|(_, left, _)| left.is_finite())
        })
    };
    let columns = 6;
    let (c, covariance, rss) = linear(rows([3, 2]), columns)?;
    let dof = range.len().checked_sub(columns + answer.parameters.iter().count()).filter(|n| *n > 0)?;
    let variance = rss / dof as f64;
    let error = |i: usize| (variance * covariance[(i, i)]).sqrt();
    let in_phase =
        |i: usize| c[i].abs() + criteria.phase_errors * error(i + 1) > criteria.in_phase * c[i + 1].abs();
    let (third, second) =
        (in_phase(0), in_phase(2) && c[2].abs() > criteria.quadratic_significance * error(2));
    let in_proportion = || linear(rows([1, 1]), columns).map(|(.., rss)| rss);
    if found.is_none() && !((third || second) && rss < in_proportion()?) {
        return None;
    }
    let third = third || found.is_some_and(|curve| curve.cubic != 0.0);
    let second = second || found.is_some_and(|curve| curve.quadratic != 0.0);
    // A spring that stiffens by a part of the frequency has a third harmonic of a twelfth of that part.
    let shift = answer.backbone.as_ref().map_or(0.0, |b| b.quadratic) * first * first;
    let cubic = if third { 4.0 * (c[0] - shift / 12.0 * first) / first.powi(3) } else { 0.0 };
    let quadratic = if second { 2.0 * c[2] / first.powi(2) } else { 0.0 };
    Some(Estimate { quadratic, cubic, cubic_error: 4.0 * error(0) / first.powi(3) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter, motion};
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};

    const DELTA: f64 = 0.06;

    /// 40 s at 40 samples a second from 1, read as `x + q x² + k x³`.
    fn record(x_f: f64, curve: [f64; 2], noise: f64, repeat: usize) -> Record {
        sampled(40, x_f, curve, noise, repeat)
    }

    fn sampled(rate_hz: usize, x_f: f64, [q, k]: [f64; 2], noise: f64, repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(7.0, DELTA, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let n = 40 * rate_hz;
        let sample = |i: usize| {
            let x = decay.displacement(i as f64 / rate_hz as f64);
            0.2 + x + x * x * (q + k * x) + noise * jitter(i + n * repeat, 8)
        };
        Record::uniform(rate_hz as f64, (0..n).map(sample).collect()).expect("valid")
    }

    fn told(record: &Record) -> bool {
        let answer = analyse(record, &Options::default()).expect("a ring-down");
        answer.warnings.iter().any(|w| w.code() == "sensor_curve")
    }

    #[test]
    fn a_reading_that_bends_is_straightened() {
        let options = Options::default();
        for (curve, noise) in [([0.0, -0.1], 0.01), ([0.05, 0.05], 0.005), ([0.1, 0.0], 0.003)] {
            for x_f in [0.0, 0.008] {
                let read = |repeat| record(x_f, curve, noise, repeat);
                assert!(told(&read(0)), "{curve:?}");
                assert_held(read, &options, Parameter::DECAY_RATE, DELTA);
                assert_held(read, &options, Parameter::FRICTION_DISPLACEMENT, x_f);
            }
        }
    }

    /// The curve that the third harmonic asks for does not rise to the highest reading.
    #[test]
    fn a_reading_that_no_curve_straightens_is_warned_of() {
        for x_f in [0.0, 0.008] {
            let oscillator = Oscillator::kinematic(7.0, DELTA, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let sample = |i: usize| decay.displacement(i as f64 / 40.0).tanh() + 0.02 * jitter(i, 8);
            let record = Record::uniform(40.0, (0..1600).map(sample).collect()).expect("valid");
            let answer = analyse(&record, &Options::default()).expect("a ring-down");
            let codes: Vec<&str> = answer.warnings.iter().map(Warning::code).collect();
            assert!(codes.contains(&"harmonics") && answer.sensor_curve.is_none(), "{codes:?}");
        }
    }

    /// A third harmonic this strong passes for a second mode at three times the frequency; after two rounds of straightening the
    /// amplitude still lay standard errors off.
    #[test]
    fn many_samples_leave_no_more_of_the_curve_than_their_noise() {
        let options = Options::default();
        for x_f in [0.0, 0.004] {
            let read = |repeat| sampled(250, x_f, [0.0, -0.1], 0.007, repeat);
            assert_held(read, &options, Parameter::DECAY_RATE, DELTA);
            assert_held(read, &options, Parameter::InitialAmplitude, 1.0);
        }
    }

    /// What the error of the curve may have made of a viscous decay is no evidence for friction.
    #[test]
    fn the_p_value_counts_the_error_of_the_curve() {
        let answer = |x_f: f64, repeat: usize| {
            analyse(&record(x_f, [0.0, -0.1], 0.01, repeat), &Options::default()).expect("a ring-down")
        };
        for repeat in 0..20 {
            let viscous = answer(0.0, repeat);
            let x_f = viscous.parameter(Parameter::FRICTION_DISPLACEMENT).expect("reported").clone();
            let least = 0.5 * chi_square_tail((x_f.unbounded_value.max(0.0) / x_f.std_error).powi(2), 1.0);
            assert!(viscous.sliding.p_value >= 0.99 * least, "{repeat}: {:?}, {x_f:?}", viscous.sliding);
            assert!(viscous.sliding.p_value > 1e-3, "{repeat}: {:?}", viscous.sliding);
            let curve = viscous.sensor_curve.expect("it bends");
            assert!((curve.cubic + 0.1).abs() < 4.0 * curve.cubic_std_error, "{repeat}: {curve:?}");
        }
        assert!(answer(0.008, 0).sliding.detected);
    }

    /// A spring that stiffens gives the motion itself a third harmonic.
    #[test]
    fn a_stiffening_spring_is_no_curve() {
        let stiffened = |stiffening: f64, repeat: usize| {
            let force = |x: f64, v: f64| -2.0 * DELTA * v - 49.0 * x * (1.0 + stiffening * x * x);
            let states = motion(force, 1.0, 1600, 1.0 / 40.0, 20);
            let seen = |(i, [x, _]): (usize, &[f64; 2])| 0.2 + x + 0.001 * jitter(i + 1600 * repeat, 8);
            let signal = states.iter().enumerate().map(seen).collect();
            Record::uniform(40.0, signal).expect("valid")
        };
        for stiffening in [0.03, 0.1, -0.05] {
            let count = (0..8).filter(|repeat| told(&stiffened(stiffening, *repeat))).count();
            assert_eq!(count, 0, "{stiffening}");
        }
    }

    /// The fit is drawn as it is read.
    #[test]
    fn the_fit_bends_with_the_reading() {
        let read = record(0.008, [0.05, -0.1], 0.005, 0);
        let fit = analyse(&read, &Options::default()).expect("a ring-down").fit;
        let off = read.signal().iter().enumerate().map(|(i, s)| (s - fit.signal_at(i as f64 / 40.0)).abs());
        assert!(off.filter(|off| off.is_finite()).fold(0.0, f64::max) < 0.03);
    }

    #[test]
    fn friction_and_stiffening_are_no_curve() {
        assert_eq!((0..30).filter(|repeat| told(&record(0.02, [0.0; 2], 0.001, *repeat))).count(), 0);
    }
}

//! Nonlinear reading: the sensor curve is estimated from the harmonics in the residuals of the motion, and
//! inverted.

use super::Answer;
use super::criteria::SensorCriteria;
use super::curve_estimate::{Estimate, bend, of_pendulum};
use super::fitted::FittedMotion;
use super::residuals::Harmonics;
use super::sampled_signal::SampledSignal;
use super::samples::Samples;
use super::sensor_curve::SensorCurve;
use super::window_fit::WAVEFORM;
use crate::answer::Warning;
use crate::inference::evidence::chi_square_tail;
use crate::model::loss::LossModel;
use crate::{Parameter, Quantity};

/// The answer of `fit` and `refine` for the straightened reading, if the samples show a second or third
/// harmonic in phase with the motion that falls as the square or cube of the amplitude, beyond what a
/// stiffening spring gives. A reading that is more nonlinear than such a curve describes causes a warning.
///
/// Losses produce harmonics in quadrature to the motion, electronics produce harmonics proportional to it.
/// The error of the curve enters every parameter through the change that it causes.
pub(crate) fn straightened<'a>(
    samples: &Samples<'a>,
    mut answer: Answer,
    criteria: &SensorCriteria,
    fit: impl Fn(Samples<'a>) -> Option<Answer>,
    refine: impl Fn(Samples<'a>, Answer) -> Answer,
) -> Answer {
    let bends = |e: &Estimate| e.quadratic != 0.0 || e.odd[0].abs() > criteria.significance * e.errors()[0];
    let may_be_nonlinear = may_be_nonlinear(&answer, criteria);
    let estimate =
        may_be_nonlinear.then(|| bend(samples, &answer, criteria, None, None).filter(bends)).flatten();
    let along =
        |estimate: (Estimate, Option<f64>)| along_curve(samples, &answer, estimate, criteria, &fit, &refine);
    let Some(estimate) = estimate else {
        let pendulum =
            of_pendulum(&answer).filter(|_| is_single_motion(&answer) && answer.fit.harmonics.is_some());
        let hidden =
            pendulum.and_then(|k| along((bend(samples, &answer, criteria, None, Some(k))?, Some(k))));
        return hidden.unwrap_or(answer);
    };
    if let Some(found) = along((estimate, None)) {
        return found;
    }
    let named = answer.warnings.iter().any(|w| matches!(w, Warning::Harmonics { .. }));
    let relative_amplitude =
        0.25 * estimate.odd[0].abs() * answer.fit.amplitude_at(answer.fit.start_s).powi(2);
    let sure = estimate.odd[0].abs() > criteria.unstraightened_errors * estimate.errors()[0];
    if sure && relative_amplitude > criteria.unstraightened && !named {
        answer.warnings.push(Warning::Harmonics { order: 3, relative_amplitude });
    }
    answer
}

/// The answer for the reading straightened along an estimated curve; `None` if no curve describes the
/// reading.
fn along_curve<'a>(
    samples: &Samples<'a>,
    answer: &Answer,
    (estimate, pendulum): (Estimate, Option<f64>),
    criteria: &SensorCriteria,
    fit: &impl Fn(Samples<'a>) -> Option<Answer>,
    refine: &impl Fn(Samples<'a>, Answer) -> Answer,
) -> Option<Answer> {
    // At the start the mean of a nonlinear reading differs from its centre.
    let centre = answer.fit.knots.last()?.offset;
    let straight = SensorCurve { centre, ..SensorCurve::default() };
    let along = |curve: SensorCurve| -> Option<Vec<f64>> {
        samples.signal.iter().map(|s| curve.straightened(*s)).collect()
    };
    // An estimate from an amplitude that is read too small may make the curve turn down below the highest
    // reading.
    let towards = |curve: SensorCurve, estimate: &Estimate| {
        let parts = (0..criteria.halvings).map(|n| estimate.times(0.5f64.powi(n as i32)));
        parts.map(|part| part.added_to(curve)).find_map(|next| Some((next, along(next)?)))
    };
    let fitted = |signal: Vec<f64>| {
        let straight =
            Samples { signal: SampledSignal::new(signal), rest: samples.rest_alone(), ..samples.clone() };
        let found = fit(straight.clone())?;
        Some((straight, found))
    };
    let (mut curve, signal) = towards(straight, &estimate)?;
    let (mut straight, mut found) = fitted(signal)?;
    let mut spread = estimate.spread;
    let top = answer.fit.amplitude_at(answer.fit.start_s);
    for _ in 1..criteria.rounds {
        let Some(more) = bend(&straight, &found, criteria, Some(&curve), pendulum) else { break };
        let (next, signal) = towards(curve, &more)?;
        curve = next;
        spread = more.spread;
        (straight, found) = fitted(signal)?;
        let settled = |(change, error): (f64, f64)| change.abs() <= criteria.settled * error;
        let odd = more.odd.into_iter().zip(more.errors()).all(settled);
        if odd && more.quadratic.abs() * top < criteria.settled * criteria.strong_line {
            break;
        }
    }
    // A second mode or another law would absorb what the curve has not yet straightened.
    found = refine(straight, found);
    let amplitude = found.parameter(Parameter::InitialAmplitude)?.value;
    let third = curve.third_harmonic(amplitude) / amplitude;
    found.fit.sensor_curve = Some(curve);
    let better = {
        // The noise of the straightened signal is larger than that of the reading.
        let [one, other] = [&found.fit, &answer.fit].map(FittedMotion::range_s);
        let both = [one[0].max(other[0]), one[1].min(other[1])];
        residual_sum_of_squares(samples, &found.fit, both)
            < residual_sum_of_squares(samples, &answer.fit, both)
    };
    let describes = found.diagnostics.method == WAVEFORM && (better || answer.diagnostics.method != WAVEFORM);
    let most = if curve.saturation > 0.0 { criteria.most_saturated } else { criteria.most };
    if !describes || third.abs() > most {
        return None;
    }
    let list: Vec<Parameter> = found.parameters.iter().map(|(p, _)| p).collect();
    let values = list.iter().map(|p| found.parameter(*p).map(|q| q.unbounded_value)).collect::<Vec<_>>();
    for change in spread.into_iter().filter(|change| *change != [0.0; 2]) {
        // Shifted by a full standard error, the curve may no longer rise up to the highest reading.
        let shifted_signal = |part: f64| {
            let [cubic, saturation] = change.map(|c| part * c);
            let saturation = curve.saturation + saturation;
            along(SensorCurve { cubic: curve.cubic + cubic, saturation, ..curve })
                .map(|signal| (part, signal))
        };
        let (part, signal) = CURVE_SHIFTS.into_iter().find_map(shifted_signal)?;
        let (straight, shifted) = fitted(signal)?;
        let shifted = refine(straight, shifted);
        for (parameter, here) in list.iter().zip(&values) {
            let there = shifted.parameter(*parameter).map(|q| q.unbounded_value);
            if let (Some(quantity), Some((there, here))) =
                (found.parameters.get_mut(*parameter), there.zip(*here))
            {
                *quantity = with_error(quantity.clone(), (there - here) / part);
            }
        }
    }
    let x_f = found.parameter(Parameter::FRICTION_DISPLACEMENT)?;
    let errors = x_f.value / x_f.std_error;
    limit_friction_evidence(&mut found, errors, criteria);
    found.sensor_curve = Some(curve);
    let odd = curve.cubic * curve.by_odd(amplitude)[0] / amplitude;
    let relative = curve.quadratic.abs() * amplitude + odd.abs();
    found.warnings.push(Warning::SensorCurve { relative });
    Some(found)
}

/// Residual sum of squares of the reading about a fitted motion.
fn residual_sum_of_squares(samples: &Samples, fit: &FittedMotion, [from, to]: [f64; 2]) -> f64 {
    let both = samples.time.iter().zip(&samples.signal[..]);
    both.filter(|(t, _)| (from..=to).contains(*t)).map(|(t, s)| (s - fit.signal_at(*t)).powi(2)).sum()
}

/// Limits the evidence for friction to that of `errors` standard errors, which include those of the curve: an
/// apparent friction that the curve may have produced from a viscous decay is no evidence.
fn limit_friction_evidence(answer: &mut Answer, errors: f64, criteria: &SensorCriteria) {
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

/// Whether the fit is a single motion about a constant level.
fn is_single_motion(answer: &Answer) -> bool {
    answer.fit.baseline.is_none() && answer.second_mode.is_none() && answer.fit.knots.len() > 1
}

/// Whether the reading may be nonlinear: judged by the residual harmonics if every sample is compared with
/// the motion, otherwise by the strongest harmonic line.
fn may_be_nonlinear(answer: &Answer, criteria: &SensorCriteria) -> bool {
    is_single_motion(answer)
        && match answer.fit.harmonics {
            Some(Harmonics { in_phase: [second, third], .. }) => {
                second.abs() > criteria.quadratic_significance || third.abs() > criteria.significance
            }
            None => {
                answer.diagnostics.distortion.is_some_and(|d| d.relative_amplitude > criteria.strong_line)
            }
        }
}

/// Shifts of the curve, in standard errors, that measure its effect on the parameters; the first that gives a
/// curve is used.
const CURVE_SHIFTS: [f64; 6] = [1.0, -1.0, 0.5, -0.5, 0.25, -0.25];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter, motion};
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::FRAC_PI_3;

    const DELTA: f64 = 0.06;

    /// 40 s at 40 samples per second from amplitude 1, read as `x + q x² + k x³`.
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

    #[test]
    fn noise_that_is_smoothed_bends_no_reading() {
        let smoothed = |repeat: usize| {
            let noisy = record(0.0, [0.0; 2], 0.03, repeat);
            let mean: Vec<f64> = noisy.signal().windows(5).map(|w| w.iter().sum::<f64>() / 5.0).collect();
            Record::uniform(40.0, mean).expect("valid")
        };
        assert!((0..100).filter(|repeat| is_straightened(&smoothed(*repeat))).count() <= 1);
    }

    fn is_straightened(record: &Record) -> bool {
        let answer = analyse(record, &Options::default()).expect("a ring-down");
        answer.warnings.iter().any(|w| w.code() == "sensor_curve")
    }

    #[test]
    fn a_reading_that_bends_is_straightened() {
        let options = Options::default();
        for (curve, noise) in [([0.0, -0.1], 0.01), ([0.05, 0.05], 0.005), ([0.1, 0.0], 0.003)] {
            for x_f in [0.0, 0.008] {
                let read = |repeat| record(x_f, curve, noise, repeat);
                assert!(is_straightened(&read(0)), "{curve:?}");
                assert_held(read, &options, Parameter::DECAY_RATE, DELTA);
                assert_held(read, &options, Parameter::FRICTION_DISPLACEMENT, x_f);
            }
        }
    }

    /// The reading saturates by more than the curve describes.
    #[test]
    fn a_reading_that_no_curve_straightens_is_warned_of() {
        for x_f in [0.0, 0.008] {
            let oscillator = Oscillator::kinematic(7.0, DELTA, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let sample =
                |i: usize| (2.0 * decay.displacement(i as f64 / 40.0)).tanh() / 2.0 + 0.05 * jitter(i, 8);
            let record = Record::uniform(40.0, (0..1600).map(sample).collect()).expect("valid");
            let answer = analyse(&record, &Options::default()).expect("a ring-down");
            let codes: Vec<&str> = answer.warnings.iter().map(Warning::code).collect();
            assert!(codes.contains(&"harmonics") && answer.sensor_curve.is_none(), "{codes:?}");
        }
    }

    /// The cubic that the third harmonic requires here has its maximum below the highest readings of the
    /// record.
    #[test]
    fn a_reading_that_saturates_is_straightened() {
        let options = Options::default();
        let tracker = |x: f64| (FRAC_PI_3 * x).sin() / FRAC_PI_3;
        for (curve, saturation) in [(f64::tanh as fn(f64) -> f64, 0.4), (tracker, 0.0)] {
            for x_f in [0.0, 0.008] {
                let decay =
                    FreeDecay::from_rest(&Oscillator::kinematic(7.0, DELTA, x_f).expect("valid"), 1.0);
                let decay = decay.expect("valid");
                let read = |repeat: usize| {
                    let sample =
                        |i| curve(decay.displacement(i as f64 / 40.0)) + 0.005 * jitter(i + 1600 * repeat, 8);
                    Record::uniform(40.0, (0..1600).map(sample).collect()).expect("valid")
                };
                let found = analyse(&read(0), &options).expect("a ring-down").sensor_curve.expect("it bends");
                let off = (found.saturation - saturation).abs();
                assert!(off <= 5.0 * found.saturation_std_error, "{found:?}");
                assert_held(read, &options, Parameter::DECAY_RATE, DELTA);
                assert_held(read, &options, Parameter::FRICTION_DISPLACEMENT, x_f);
                assert_held(read, &options, Parameter::InitialAmplitude, 1.0);
            }
        }
    }

    /// Such a strong third harmonic looks like a second mode at three times the frequency; after two rounds
    /// of straightening the amplitude was still in error by several standard errors.
    #[test]
    fn many_samples_leave_no_more_of_the_curve_than_their_noise() {
        let options = Options::default();
        for x_f in [0.0, 0.004] {
            let read = |repeat| sampled(250, x_f, [0.0, -0.1], 0.007, repeat);
            assert_held(read, &options, Parameter::DECAY_RATE, DELTA);
            assert_held(read, &options, Parameter::InitialAmplitude, 1.0);
        }
    }

    /// An apparent friction that the error of the curve may have produced from a viscous decay is no evidence
    /// for friction.
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

    /// A stiffening spring gives the motion itself a third harmonic.
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
            let count = (0..8).filter(|repeat| is_straightened(&stiffened(stiffening, *repeat))).count();
            assert_eq!(count, 0, "{stiffening}");
        }
    }

    /// At 15° the third harmonic of `L sin θ`, 0.3 %, is below the noise; the frequency reveals it, unless
    /// the record is an angle.
    #[test]
    fn a_tracked_pendulum_is_straightened_where_noise_hides_the_harmonic() {
        let top = 15f64.to_radians();
        let force = |x: f64, v: f64| -2.0 * DELTA * v - 49.0 * (top * x).sin() / top;
        let states = motion(force, 1.0, 1200, 1.0 / 25.0, 20);
        let seen = |tracked: bool, repeat: usize| {
            let read = |(i, [x, _]): (usize, &[f64; 2])| {
                let place = if tracked { (top * x).sin() } else { top * x };
                place + 0.007 * top * jitter(i + 1200 * repeat, 8)
            };
            let record = Record::uniform(25.0, states.iter().enumerate().map(read).collect());
            record.expect("valid").with_unit(if tracked { "m" } else { "rad" })
        };
        let options = Options::default();
        assert_held(|repeat| seen(true, repeat), &options, Parameter::DECAY_RATE, DELTA);
        assert_held(|repeat| seen(false, repeat), &options, Parameter::DECAY_RATE, DELTA);
        let count = |tracked| (0..24).filter(|repeat| is_straightened(&seen(tracked, *repeat))).count();
        assert!(count(true) >= 16 && count(false) == 0, "{} {}", count(true), count(false));
    }

    /// The fitted signal includes the nonlinearity of the reading.
    #[test]
    fn the_fit_bends_with_the_reading() {
        let read = record(0.008, [0.05, -0.1], 0.005, 0);
        let fit = analyse(&read, &Options::default()).expect("a ring-down").fit;
        let off = read.signal().iter().enumerate().map(|(i, s)| (s - fit.signal_at(i as f64 / 40.0)).abs());
        assert!(off.filter(|off| off.is_finite()).fold(0.0, f64::max) < 0.03);
    }

    #[test]
    fn friction_and_stiffening_are_no_curve() {
        assert_eq!(
            (0..30).filter(|repeat| is_straightened(&record(0.02, [0.0; 2], 0.001, *repeat))).count(),
            0
        );
    }
}

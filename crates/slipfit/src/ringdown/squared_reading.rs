//! Squared reading: a level that follows the amplitude, as it does for the square of a deflection.

use super::Answer;
use super::criteria::SquaredReadingCriteria;
use crate::SignalKind;
use crate::answer::Warning;
use crate::inference::least_squares::linear;

/// The acceleration of gravity in m/s², and in units of g.
const GRAVITY: [f64; 2] = [9.81, 1.0];

/// Warns of a reading whose level along the decay is a linear function of its amplitude with the slope of a
/// square.
///
/// `(A cos φ)² = A²/2 + A²/2 cos 2φ`: the level relative to the rest equals the amplitude. A sensor at the
/// distance `r` from the pivot of a pendulum with the length `L` of the equivalent simple pendulum reads,
/// along the pendulum,
///
/// ```text
/// g cos θ + r θ'² = g + g A² (r/2L - 1/4) - g A² (r/2L + 1/4) cos 2φ
/// ```
///
/// so that the level is `(2r - L)/(2r + L)` times the amplitude: a third for a mass hanging on strings.
pub(crate) fn squared_reading(
    answer: &Answer,
    kind: SignalKind,
    criteria: &SquaredReadingCriteria,
) -> Option<Warning> {
    let fit = &answer.fit;
    if fit.knots.len() < criteria.least_levels {
        return None;
    }
    let levels: Vec<(f64, f64)> = fit
        .knots
        .iter()
        .map(|k| {
            (fit.amplitude_at(k.time_s), k.offset + fit.baseline.as_ref().map_or(0.0, |b| b.value(k.time_s)))
        })
        .filter(|(amplitude, level)| (amplitude + level).is_finite())
        .collect();
    let left = |columns: usize| {
        let rows =
            levels.iter().map(|(amplitude, level)| ([1.0, *amplitude][..columns].to_vec(), *level, 1.0));
        linear(rows, columns)
    };
    let ((.., about_mean), (line, _, about_line)) = (left(1)?, left(2)?);
    if about_line > (1.0 - criteria.explained) * about_mean {
        return None;
    }
    let [rest, slope] = [line[0], line[1]];
    let is_gravity = |g: f64| (rest.abs() / g - 1.0).abs() < criteria.gravity_within;
    let upwards = slope * rest.signum();
    let along_pendulum = kind == SignalKind::Acceleration
        && GRAVITY.into_iter().any(is_gravity)
        && (criteria.pendulum_least..criteria.pendulum_most).contains(&upwards);
    let is_square = (slope.abs() - 1.0).abs() < criteria.square_within;
    (along_pendulum || is_square).then_some(Warning::SquaredReading { along_pendulum })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};

    /// 60 s at 50 samples per second of a decay from 0.3 rad, read as `reading` of angle and angular
    /// velocity.
    fn warnings(kind: SignalKind, reading: impl Fn(f64, f64) -> f64, noise: f64) -> Vec<Warning> {
        let oscillator = Oscillator::kinematic(4.4, 0.03, 4e-4).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.3).expect("valid");
        let sample = |i: usize| {
            let t = i as f64 / 50.0;
            let [before, here, after] = [t - 1e-4, t, t + 1e-4].map(|t| decay.displacement(t.max(0.0)));
            reading(here, (after - before) / 2e-4) + noise * jitter(i, 5)
        };
        let record = Record::uniform(50.0, (0..3000).map(sample).collect()).expect("valid").with_kind(kind);
        analyse(&record, &Options::default()).expect("a ring-down").warnings
    }

    fn warned(kind: SignalKind, reading: impl Fn(f64, f64) -> f64, noise: f64) -> Option<bool> {
        warnings(kind, reading, noise).into_iter().find_map(|w| match w {
            Warning::SquaredReading { along_pendulum } => Some(along_pendulum),
            _ => None,
        })
    }

    #[test]
    fn an_acceleration_along_a_pendulum_gives_a_warning() {
        let length = 9.81 / 4.4f64.powi(2);
        for part in [0.8, 1.0] {
            for sign in [1.0, -1.0] {
                let along = |angle: f64, velocity: f64| {
                    sign * (9.81 * angle.cos() + part * length * velocity * velocity)
                };
                assert_eq!(warned(SignalKind::Acceleration, along, 0.02), Some(true), "{part}");
            }
        }
    }

    #[test]
    fn a_squared_deflection_is_told_and_the_deflection_is_not() {
        let displacement = SignalKind::Displacement;
        assert_eq!(warned(displacement, |angle, _| 2.0 + angle * angle, 2e-3), Some(false));
        assert_eq!(warned(displacement, |angle, _| 2.0 - angle * angle, 2e-3), Some(false));
        assert_eq!(warned(displacement, |angle, _| 2.0 + angle, 2e-3), None);
        // A mass on a spring with a phone on it, and one with a nonlinear sensor.
        assert_eq!(warned(SignalKind::Acceleration, |angle, _| 9.81 - 19.4 * angle, 0.02), None);
        assert_eq!(
            warned(SignalKind::Acceleration, |angle, _| 9.81 + 9.0 * angle + angle * angle, 0.02),
            None
        );
    }

    #[test]
    fn gravity_across_a_pendulum_is_told_where_the_reader_says_so() {
        let signal = (0..2000).map(|i| {
            (-0.002 * f64::from(i)).exp() * (0.1 * f64::from(i)).cos() + 1e-3 * jitter(i as usize, 2)
        });
        let record =
            Record::uniform(50.0, signal.collect()).expect("valid").with_kind(SignalKind::Acceleration);
        let codes = |record: &Record| -> Vec<&str> {
            let answer = analyse(record, &Options::default()).expect("a ring-down");
            answer.warnings.iter().map(Warning::code).collect()
        };
        assert!(!codes(&record).contains(&"turning_gravity"));
        assert!(codes(&record.with_turning_gravity(true)).contains(&"turning_gravity"));
    }
}

//! A measurement analysed alone, as used by the comparison and the joint fit.

use super::answer::SingleAnswer;
use crate::answer::Parameter;
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

/// Result of one measurement, without limits, in the common unit.
#[derive(Clone)]
pub(super) struct SolvedMeasurement {
    pub(super) measurement: usize,
    pub(super) ring_down: bool,
    /// Damping rate and friction displacement.
    pub(super) value: Vector2<f64>,
    pub(super) covariance: Matrix2<f64>,
    /// Shift by one standard error of the disturbance common to all measurements; not included in the covariance.
    pub(super) shared: Vector2<f64>,
    /// Natural frequency, Hz, and its standard error, which is zero if it was given.
    pub(super) frequency: [f64; 2],
    /// Drive amplitude, its standard error, and its correlations with the two.
    pub(super) drive: Option<([f64; 2], [f64; 2])>,
}

impl SolvedMeasurement {
    /// Values and covariance from an answer.
    pub(super) fn new(measurement: usize, scale: f64, answer: &SingleAnswer) -> Result<Self, &'static str> {
        const PAIR: [Parameter; 2] = [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT];
        // Errors are those of the fit that has the correlations, without limits, as the values are. Drag that a
        // measurement does not exclude is weighted over all of them.
        let by_few = match answer {
            SingleAnswer::Levels(a) => a.student_factor(),
            _ => 1.0,
        };
        let get = |parameter: Parameter| {
            let mut quantity = answer.parameters().get(parameter).cloned()?;
            quantity.std_error = answer.own_error(parameter).unwrap_or(quantity.std_error) * by_few;
            Some(quantity)
        };
        let delta = get(PAIR[0]).ok_or("it gives no decay rate")?;
        let x_f = get(PAIR[1]).ok_or("it gives no friction displacement")?.scaled(scale, "");
        let rho = answer.correlation(PAIR[0], PAIR[1]).unwrap_or(0.0).clamp(-0.999_999, 0.999_999);
        let (s_d, s_x) = (delta.std_error, x_f.std_error);
        if !(s_d > 0.0 && s_x > 0.0 && s_d.is_finite() && s_x.is_finite()) {
            return Err("it does not determine damping and friction");
        }
        let covariance = Matrix2::new(s_d * s_d, rho * s_d * s_x, rho * s_d * s_x, s_x * s_x);
        if !(covariance[(0, 0)].is_normal() && covariance[(1, 1)].is_normal()) {
            return Err("the squares of its standard errors exceed the range of double precision: use \
                        another unit");
        }
        let frequency = match answer {
            // A ring-down swings at omega_d.
            SingleAnswer::RingDown(_) => {
                get(Parameter::Frequency).map(|q| [q.value.hypot(delta.value / TAU), q.std_error])
            }
            SingleAnswer::Sweep(_) => get(Parameter::NaturalFrequency).map(|q| [q.value, q.std_error]),
            SingleAnswer::Levels(a) => a.frequency_hz.map(|hz| [hz, 0.0]),
        };
        let frequency = frequency.ok_or("its frequency is not known")?;
        let drive = match answer {
            SingleAnswer::Sweep(a) => get(Parameter::DriveAmplitude)
                .filter(|q| q.std_error > 0.0 && q.std_error.is_finite())
                .map(|q| {
                    let with = |other| a.correlation(Parameter::DriveAmplitude, other).unwrap_or(0.0);
                    ([q.unbounded_value * scale, q.std_error * scale], PAIR.map(with))
                }),
            _ => None,
        };
        Ok(Self {
            measurement,
            ring_down: matches!(answer, SingleAnswer::RingDown(_)),
            value: Vector2::new(delta.unbounded_value, x_f.unbounded_value),
            covariance,
            shared: Vector2::zeros(),
            frequency,
            drive,
        })
    }

    /// Its natural frequency and standard error, if it was measured.
    pub(super) fn measured_frequency(&self) -> Option<[f64; 2]> {
        Some(self.frequency).filter(|f| f[1] > 0.0 && f[1].is_finite())
    }

    /// The same with additional scatter between repeats.
    pub(super) fn with_scatter(&self, more: &Matrix2<f64>) -> Self {
        let covariance = self.covariance + more;
        let shrunk = |k: usize, rho: f64| rho * (self.covariance[(k, k)] / covariance[(k, k)]).sqrt();
        let drive = self.drive.map(|(value, [a, b])| (value, [shrunk(0, a), shrunk(1, b)]));
        Self { covariance, drive, ..self.clone() }
    }
}

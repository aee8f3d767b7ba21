//! Sensor curve: a reading that is a nonlinear function of the deflection.

use std::f64::consts::FRAC_PI_2;

/// Maximum number of Newton steps for straightening a reading.
const STEPS: usize = 30;
/// Number of points per quarter cycle for the integration of a harmonic.
const POINTS: usize = 16;

/// `s = c + x + q x² + k x³/(1 + r x²)`: the reading of a sensor for a displacement `x` from the rest
/// position `c`.
///
/// A tracker that sees `L sin θ` of a pendulum has `k = -1/(6 L²)` and `r = 1/(20 L²)`; the latter is
/// noticeable above about 50°. A reading `tanh(g x)/g` has `k = -g²/3` and `r = 2g²/5` (Padé approximants,
/// accurate to 0.1 % for `θ` and `g x` up to 1). With `x = A cos φ` and `r = 0` the third harmonic is
/// `k A³/4`, and the fundamental `A + 3 k A³/4`: a reading that is too small at large amplitudes resembles
/// friction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorCurve {
    /// Reading at rest c, signal unit.
    pub centre: f64,
    /// Quadratic coefficient q, one over the signal unit; zero if the samples show none.
    pub quadratic: f64,
    /// Cubic coefficient k, one over the signal unit squared; zero if the samples show none.
    pub cubic: f64,
    /// Standard error of the cubic coefficient, which is included in the errors of the parameters.
    pub cubic_std_error: f64,
    /// Saturation coefficient r of the cubic term, one over the signal unit squared; zero unless k is
    /// negative.
    pub saturation: f64,
    /// Its standard error, which is included likewise; zero unless k is negative.
    pub saturation_std_error: f64,
}

impl SensorCurve {
    /// The reading for a straightened value.
    pub(crate) fn reading(&self, straight: f64) -> f64 {
        let x = straight - self.centre;
        let [by_cubic, _] = self.by_odd(x);
        straight + x * x * self.quadratic + self.cubic * by_cubic
    }

    /// Derivatives of the reading at `x` from the centre with respect to the cubic and the saturation
    /// coefficient.
    pub(super) fn by_odd(&self, x: f64) -> [f64; 2] {
        let by_cubic = x * x * x / (1.0 + self.saturation * x * x);
        [by_cubic, -self.cubic * x * x / (1.0 + self.saturation * x * x) * by_cubic]
    }

    /// Slope of the odd part of the curve.
    pub(super) fn odd_slope(&self, x: f64) -> f64 {
        let r = self.saturation * x * x;
        1.0 + self.cubic * x * x * (3.0 + r) / ((1.0 + r) * (1.0 + r))
    }

    /// Third harmonic of the reading of `A cos φ`, signal unit.
    pub(super) fn third_harmonic(&self, amplitude: f64) -> f64 {
        let at = |i: usize| {
            let phase = (i as f64 + 0.5) / POINTS as f64 * FRAC_PI_2;
            self.cubic * self.by_odd(amplitude * phase.cos())[0] * (3.0 * phase).cos()
        };
        2.0 * (0..POINTS).map(at).sum::<f64>() / POINTS as f64
    }

    /// The straightened value of a reading; `None` if the curve does not increase up to there.
    pub(super) fn straightened(&self, reading: f64) -> Option<f64> {
        let mut x = reading - self.centre;
        for _ in 0..STEPS {
            let slope = self.odd_slope(x) + 2.0 * self.quadratic * x;
            let step = (self.reading(self.centre + x) - reading) / slope;
            if !(slope > 0.0) || !step.is_finite() {
                return None;
            }
            x -= step;
            if step.abs() <= f64::EPSILON * x.abs() {
                break;
            }
        }
        Some(self.centre + x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_the_inverse_of_its_straightened_value() {
        let curve =
            SensorCurve { centre: 0.3, quadratic: 0.1, cubic: -0.2, saturation: 0.1, ..Default::default() };
        for x in [-0.5, 0.0, 0.3, 0.9] {
            let straight = curve.straightened(curve.reading(x)).expect("it rises");
            assert!((straight - x).abs() < 1e-14);
        }
        // A reading above the maximum of the curve.
        let falling = SensorCurve { cubic: -1.0, ..Default::default() };
        assert_eq!(falling.straightened(5.0), None);
    }

    #[test]
    fn derivatives_are_those_of_the_reading() {
        let curve = SensorCurve { cubic: -0.3, saturation: 0.4, ..Default::default() };
        let step = 1e-6;
        for x in [-1.2, -0.3, 0.8] {
            let by =
                |plus: SensorCurve, minus: SensorCurve| (plus.reading(x) - minus.reading(x)) / (2.0 * step);
            let cubic = |d: f64| SensorCurve { cubic: curve.cubic + d, ..curve };
            let saturation = |d: f64| SensorCurve { saturation: curve.saturation + d, ..curve };
            let [by_cubic, by_saturation] = curve.by_odd(x);
            assert!((by(cubic(step), cubic(-step)) - by_cubic).abs() < 1e-9);
            assert!((by(saturation(step), saturation(-step)) - by_saturation).abs() < 1e-9);
            let slope = (curve.reading(x + step) - curve.reading(x - step)) / (2.0 * step);
            assert!((slope - curve.odd_slope(x)).abs() < 1e-9);
        }
    }

    #[test]
    fn it_follows_a_hyperbolic_tangent_and_a_sine() {
        let tanh = SensorCurve { cubic: -1.0 / 3.0, saturation: 0.4, ..Default::default() };
        let sine = SensorCurve { cubic: -1.0 / 6.0, saturation: 0.05, ..Default::default() };
        assert!((tanh.reading(1.0) - 1f64.tanh()).abs() < 5e-4);
        assert!((sine.reading(1.0) - 1f64.sin()).abs() < 3e-4);
        let plain = SensorCurve { cubic: -0.1, ..Default::default() };
        assert!((plain.third_harmonic(0.8) + 0.025 * 0.8f64.powi(3)).abs() < 1e-15);
    }
}

//! Sensor curve: a reading that bends with the deflection.

/// Steps of Newton's method that straighten a reading.
const STEPS: usize = 30;

/// `s = c + x + q x² + k x³`: what a sensor reads of a displacement `x` off the place `c` of rest.
///
/// A tracker that sees `L sin θ` of a pendulum has `k = -1/(6 L²)`. With `x = A cos φ` the third harmonic is `k A³/4`,
/// and the fundamental `A + 3 k A³/4`: an amplitude that is read too small where it is large looks like friction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorCurve {
    /// Reading at rest c, signal unit.
    pub centre: f64,
    /// Quadratic coefficient q, one over the signal unit; zero where the samples show none.
    pub quadratic: f64,
    /// Cubic coefficient k, one over the signal unit squared; zero where the samples show none.
    pub cubic: f64,
    /// Standard error of the cubic coefficient, which the errors of the parameters count.
    pub cubic_std_error: f64,
}

impl SensorCurve {
    /// The reading at a straightened value.
    pub(crate) fn reading(&self, straight: f64) -> f64 {
        let x = straight - self.centre;
        straight + x * x * (self.quadratic + x * self.cubic)
    }

    /// The straightened value of a reading; `None` where the curve does not rise up to there.
    pub(super) fn straightened(&self, reading: f64) -> Option<f64> {
        let mut x = reading - self.centre;
        for _ in 0..STEPS {
            let slope = 1.0 + x * (2.0 * self.quadratic + 3.0 * x * self.cubic);
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
        let curve = SensorCurve { centre: 0.3, quadratic: 0.1, cubic: -0.2, cubic_std_error: 0.0 };
        for x in [-0.5, 0.0, 0.3, 0.9] {
            let straight = curve.straightened(curve.reading(x)).expect("it rises");
            assert!((straight - x).abs() < 1e-14);
        }
        // Beyond its highest reading.
        let falling = SensorCurve { centre: 0.0, quadratic: 0.0, cubic: -1.0, cubic_std_error: 0.0 };
        assert_eq!(falling.straightened(5.0), None);
    }
}

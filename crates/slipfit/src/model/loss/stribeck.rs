//! Friction that decreases with speed.

use super::kind::{Loss, ShapeParameter, scaled};
use crate::model::unit::UnitRule;

/// Excess of friction at low speed over its value at high speed, the Stribeck effect: `F_e sgn(v)/(1 + (v/v_s)²)`.
/// Averaged over a cycle,
///
/// ```text
/// dA/dt = -r A0 H(z)/H(z_0),   H = asinh(z)/(z sqrt(1 + z²)),   z = A omega/v_s,   z_0 = A0 omega/v_s
/// ```
///
/// with `r A0 = (2 omega x_e/pi) H(z_0)`, `x_e = F_e/k`: the loss at the initial amplitude. At small velocity it is
/// sliding friction `x_e`; at large velocity it falls with the square of the amplitude, apart from a logarithm. The
/// term `sliding` of the same model is then the friction at high speed. The shape parameter is `v_s/(A0 omega)`.
/// Friction that increases with speed is described by drag or another power of the speed.
///
/// Source: the Stribeck curve in the form of D. P. Hess and A. Soom (1990), Journal of Tribology 112, 147; the
/// average by `∫ sin t/(1 + z² sin² t) dt` over a quarter turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stribeck;

/// `asinh(z)/(z sqrt(1 + z²))` and its derivative.
fn average(z: f64) -> [f64; 2] {
    let square = z * z;
    if z < 1e-3 {
        return [1.0 - square * (2.0 / 3.0 - 8.0 / 15.0 * square), -z * (4.0 / 3.0 - 32.0 / 15.0 * square)];
    }
    let root = (1.0 + square).sqrt();
    let value = (z + root).ln() / (z * root);
    [value, (1.0 - (1.0 + 2.0 * square) * value) / (z * (1.0 + square))]
}

impl Loss for Stribeck {
    const NAME: &'static str = "stribeck";
    const COEFFICIENT: &'static str = "stribeck_rate_per_s";
    const LABEL: &'static str = "Stribeck rate";
    const SYMBOL: &'static str = "r_s";
    const UNIT: UnitRule = UnitRule::Fixed("1/s");
    const WORDS: &'static str = "friction that falls with speed";
    const METHOD: Option<[&'static str; 3]> = Some([
        "Friction that falls with speed (Stribeck)",
        "dA/dt = −r_s A_0 H(Aω/v_s)/H(A_0 ω/v_s),   H(z) = asinh(z)/(z √(1 + z²))",
        "For a friction x_e/(1 + (v/v_s)²), as in Hess and Soom (1990), with r_s A_0 = (2ωx_e/π) H(A_0 ω/v_s); the ratio v_s/(A_0 ω) is fitted.",
    ]);
    const COMPARED: bool = false;
    const FREQUENCY_POWER: i32 = -1;
    const BACKBONE: f64 = 23.0 / 12.0;
    const SHAPE: Option<ShapeParameter> = Some(ShapeParameter {
        name: "stribeck_velocity_ratio",
        range: [0.1, 3.0],
        starts: &[0.12, 0.25, 0.5, 1.0],
    });

    /// The shape for a velocity ratio of one.
    fn shape(amplitude: f64) -> f64 {
        average(amplitude)[0]
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        average(amplitude)[1]
    }

    fn relative(u: f64, ratio: f64, at_start: [f64; 2]) -> [f64; 3] {
        scaled(average, u, ratio, at_start)
    }

    fn relative_value(u: f64, ratio: f64, at_start: [f64; 2]) -> f64 {
        average(u.max(0.0) / ratio)[0] / at_start[0]
    }

    fn at_start(ratio: f64) -> [f64; 2] {
        average(1.0 / ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::law::amplitude_loss_rate;
    use std::f64::consts::PI;

    #[test]
    fn is_the_average_of_its_force() {
        let (m, omega, v_s, force) = (0.7, 3.0, 0.4, 0.2);
        for amplitude in [1e-5, 0.01, 0.1, 1.0, 20.0] {
            let law = |v: f64| force / (1.0 + (v / v_s).powi(2));
            let rate = amplitude_loss_rate(m, omega, amplitude, law).expect("valid");
            let closed = 2.0 * force / (PI * m * omega) * average(amplitude * omega / v_s)[0];
            assert!((rate / closed - 1.0).abs() < 1e-10, "{amplitude}: {rate} {closed}");
        }
    }
}

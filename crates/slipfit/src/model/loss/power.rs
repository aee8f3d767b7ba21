//! Loss proportional to a fitted power of the amplitude.

use super::kind::{Loss, ShapeParameter};
use crate::model::unit::UnitRule;

/// A loss proportional to a power of the amplitude whose exponent is a parameter: `dA/dt = -a_n A^n`, written with
/// the initial amplitude `A0` as `-r A0 (A/A0)^n`, so that the rate `r` is in 1/s for every `n` and
/// `a_n = r A0^(1-n)`.
///
/// Sliding friction is `n = 0`, viscous damping `n = 1`, quadratic drag `n = 2`. A force `c |v|^n` gives
/// `a_n = (2 c omega^(n-1)/(pi m)) ∫_0^(pi/2) sin^(n+1)`; hysteresis of materials and joints has intermediate powers
/// (an energy loss per cycle `~ A^m` corresponds to `n = m - 1`). The law should not be extrapolated below the
/// measured amplitudes: for `n < 1` the motion ends in finite time, for `n > 1` never.
///
/// Source: the average of a power of the velocity over a cycle, as in B. J. Lazan (1968), Damping of Materials
/// and Members in Structural Mechanics, whose damping energy is a power of the stress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Power;

/// Smallest amplitude, relative to the initial one, at which the slope is evaluated: below it the slope for `n < 1`
/// is unbounded.
const LEAST: f64 = 1e-3;

impl Loss for Power {
    const NAME: &'static str = "power";
    const COEFFICIENT: &'static str = "power_rate_per_s";
    const LABEL: &'static str = "power-law rate";
    const SYMBOL: &'static str = "r_n";
    const UNIT: UnitRule = UnitRule::Fixed("1/s");
    const WORDS: &'static str = "a power-law loss";
    const METHOD: Option<[&'static str; 3]> = Some([
        "Power-law loss",
        "dA/dt = −r A_0 (A/A_0)^n,   n = 0 sliding, 1 viscous, 2 drag",
        "The exponent is fitted with the rate; A_0 is the initial amplitude. Averaged over a cycle, as in Lazan (1968).",
    ]);
    const COMPARED: bool = false;
    const FREQUENCY_POWER: i32 = 0;
    const BACKBONE: f64 = 1.0;
    const SHAPE: Option<ShapeParameter> = Some(ShapeParameter {
        name: "loss_exponent",
        range: [1e-3, 4.0],
        starts: &[0.3, 0.6, 1.5, 2.5, 3.5],
    });

    /// The shape for `n = 3/2`.
    fn shape(amplitude: f64) -> f64 {
        amplitude * amplitude.max(0.0).sqrt()
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        1.5 * amplitude.max(0.0).sqrt()
    }

    fn relative(u: f64, exponent: f64, _at_start: [f64; 2]) -> [f64; 3] {
        if !(u > 0.0) {
            return [0.0; 3];
        }
        let ln = u.ln();
        let value = (exponent * ln).exp();
        let slope = if u > LEAST { exponent * value / u } else { exponent * LEAST.powf(exponent - 1.0) };
        [value, slope, value * ln]
    }

    fn relative_value(u: f64, exponent: f64, _at_start: [f64; 2]) -> f64 {
        if u > 0.0 { (exponent * u.ln()).exp() } else { 0.0 }
    }
}

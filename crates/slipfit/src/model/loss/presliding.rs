//! Friction of a contact that yields elastically before it slides.

use super::kind::{Loss, ShapeParameter, scaled};
use crate::model::unit::UnitRule;

/// Pre-sliding: contacts act like a spring before they slide, so that the loss vanishes at small amplitude. The
/// hysteresis loop of Dahl's friction, `dF/dx = sigma (1 - F/F_c sgn v)`, encloses the area `4 A F_c (1 - tanh(a)/a)`
/// per cycle, `a = sigma A/F_c`:
///
/// ```text
/// dA/dt = -r A0 H(A/A_b)/H(A0/A_b),   H(a) = 1 - tanh(a)/a,   r A0 = (2 omega x_F/pi) H(A0/A_b)
/// ```
///
/// This is sliding friction above the break amplitude `A_b = F_c/sigma`, and a loss that falls with the square of the
/// amplitude below it. The shape parameter is `A_b/A0`. The stiffness of the contacts also raises the frequency at
/// small amplitude, which the backbone of the fit absorbs.
///
/// Sources: P. R. Dahl (1976), AIAA Journal 14, 1675; the area is the integral of its loop between turning
/// points `±A`, `F(A) = F_c tanh a`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Presliding;

/// `1 - tanh(a)/a` and its derivative.
fn loop_area(a: f64) -> [f64; 2] {
    if a < 0.02 {
        let square = a * a;
        let value = square * (1.0 / 3.0 - square * (2.0 / 15.0 - 17.0 / 315.0 * square));
        return [value, a * (2.0 / 3.0 - square * (8.0 / 15.0 - 34.0 / 105.0 * square))];
    }
    let tanh = a.tanh();
    [1.0 - tanh / a, tanh / (a * a) - (1.0 - tanh * tanh) / a]
}

impl Loss for Presliding {
    const NAME: &'static str = "presliding";
    const COEFFICIENT: &'static str = "presliding_rate_per_s";
    const LABEL: &'static str = "pre-sliding rate";
    const SYMBOL: &'static str = "r_p";
    const UNIT: UnitRule = UnitRule::Fixed("1/s");
    const WORDS: &'static str = "friction of contacts that yield before they slide";
    const METHOD: Option<[&'static str; 3]> = Some([
        "Pre-sliding friction (Dahl)",
        "dA/dt = −r_p A_0 H(A/A_b)/H(A_0/A_b),   H(a) = 1 − tanh(a)/a,   r_p A_0 = (2ωx_F/π) H(A_0/A_b)",
        "The area of the hysteresis loop of Dahl (1976) between turning points ±A; the ratio A_b/A_0 is fitted with the rate.",
    ]);
    const COMPARED: bool = false;
    const FREQUENCY_POWER: i32 = -1;
    const BACKBONE: f64 = 23.0 / 12.0;
    const SHAPE: Option<ShapeParameter> = Some(ShapeParameter {
        name: "break_amplitude_ratio",
        range: [3e-3, 3.0],
        starts: &[0.02, 0.06, 0.15, 0.4, 1.0],
    });

    /// The shape for a break amplitude of one.
    fn shape(amplitude: f64) -> f64 {
        loop_area(amplitude)[0]
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        loop_area(amplitude)[1]
    }

    fn relative(u: f64, ratio: f64, at_start: [f64; 2]) -> [f64; 3] {
        scaled(loop_area, u, ratio, at_start)
    }

    fn relative_value(u: f64, ratio: f64, at_start: [f64; 2]) -> f64 {
        loop_area(u.max(0.0) / ratio)[0] / at_start[0]
    }

    fn at_start(ratio: f64) -> [f64; 2] {
        loop_area(1.0 / ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates the force along the loop by small steps of its differential equation.
    #[test]
    fn is_the_area_of_its_loop() {
        for a in [0.01, 0.1, 0.7, 3.0, 12.0] {
            let steps = 20_000;
            let dx = 2.0 * a / f64::from(steps);
            // F_c and sigma are one; the second half mirrors the first. Midpoint steps.
            let (mut force, mut area) = (-f64::tanh(a), 0.0);
            for _ in 0..steps {
                let middle = force + 0.5 * dx * (1.0 - force);
                area += 2.0 * middle * dx;
                force += dx * (1.0 - middle);
            }
            assert!((force - f64::tanh(a)).abs() < 1e-6);
            assert!((area / (4.0 * a) - loop_area(a)[0]).abs() < 1e-6 * (1.0 + a * a), "{a}");
        }
    }
}

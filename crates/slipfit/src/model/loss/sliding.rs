//! Sliding friction.

use super::kind::Loss;
use crate::model::unit::UnitRule;

/// Sliding friction `F sgn(x')`: the amplitude falls along a straight line, `dA/dt = -a0` with `a0 = 2 omega x_F/pi`
/// (eq. (16) of Vitorino, Vieira and Rodrigues; with viscous damping exactly `delta x_F coth(pi delta/2 omega_d)`).
///
/// The coefficient reported is the friction displacement `x_F = F/k`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sliding;

impl Loss for Sliding {
    const NAME: &'static str = "sliding";
    const COEFFICIENT: &'static str = "friction_displacement";
    const LABEL: &'static str = "friction displacement";
    const SYMBOL: &'static str = "x_F";
    const WORDS: &'static str = "sliding friction";
    const FREQUENCY_POWER: i32 = -1;
    const BACKBONE: f64 = 23.0 / 12.0;
    const UNIT: UnitRule = UnitRule::Signal;

    fn shape(_: f64) -> f64 {
        1.0
    }

    fn shape_derivative(_: f64) -> f64 {
        0.0
    }
}

//! Viscous damping.

use super::kind::Loss;
use crate::model::unit::UnitRule;

/// Viscous damping, `gamma x'`: the amplitude falls exponentially, `dA/dt = -delta A` with
/// `delta = gamma/2m`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Viscous;

impl Loss for Viscous {
    const NAME: &'static str = "viscous";
    const COEFFICIENT: &'static str = "decay_rate_per_s";
    const LABEL: &'static str = "decay rate";
    const SYMBOL: &'static str = "δ";
    const WORDS: &'static str = "viscous damping";
    const FREQUENCY_POWER: i32 = 0;
    const BACKBONE: f64 = 1.0;
    const UNIT: UnitRule = UnitRule::Fixed("1/s");

    fn shape(amplitude: f64) -> f64 {
        amplitude
    }

    fn shape_derivative(_: f64) -> f64 {
        1.0
    }
}

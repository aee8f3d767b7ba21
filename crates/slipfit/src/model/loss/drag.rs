//! Quadratic drag.

use super::kind::Loss;
use crate::model::unit::UnitRule;

/// Drag `c x'|x'|` of air or water: `dA/dt = -a2 A²` with `a2 = 4 c omega/(3 pi m)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Drag;

impl Loss for Drag {
    const NAME: &'static str = "drag";
    const COEFFICIENT: &'static str = "drag_rate";
    const LABEL: &'static str = "drag rate";
    const SYMBOL: &'static str = "a₂";
    const UNIT: UnitRule = UnitRule::PerSignalSecond;

    fn shape(amplitude: f64) -> f64 {
        amplitude * amplitude
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        2.0 * amplitude
    }
}

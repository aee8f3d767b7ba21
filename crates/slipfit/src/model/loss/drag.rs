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
    const WORDS: &'static str = "quadratic drag";
    const METHOD: Option<[&'static str; 3]> = Some([
        "Amplitude law with all three losses",
        "dA/dt = −(a_0 + a_1 A + a_2 A²),   a_0 = 2ωx_F/π,   a_1 = δ,   a_2 = 4cω/3πm   for drag c v|v|",
        "Energy lost per cycle, as in eqs. (17) and (18) of the paper, which proposes the square term. Eq. \
         (17) prints the viscous loss as (π/2)γv²; the correct expression is (π/2)γv²/ω_r, from which (18) \
         follows.",
    ]);
    const FREQUENCY_POWER: i32 = 1;
    const BACKBONE: f64 = 0.15;
    const UNIT: UnitRule = UnitRule::LossRate(2);

    fn shape(amplitude: f64) -> f64 {
        amplitude * amplitude
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        2.0 * amplitude
    }
}

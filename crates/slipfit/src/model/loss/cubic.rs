//! Nonlinear damping, proportional to the cube of the amplitude.

use super::kind::Loss;
use crate::model::unit::UnitRule;

/// Nonlinear damping `m eta x² x'` (van der Pol's term, with damping sign): `dA/dt = -a3 A³` with `a3 = eta/8`. It
/// has been measured in MEMS, nanotube and graphene resonators.
///
/// A force `c x'³` gives the same law with `a3 = 3 c omega²/(8 m)`; one free decay cannot distinguish them. Averaged
/// over a cycle: `<x² x'²> = omega² A⁴/8`.
///
/// Sources: R. Lifshitz and M. C. Cross (2008), Reviews of Nonlinear Dynamics and Complexity 1, 1;
/// A. Eichler et al. (2011), Nature Nanotechnology 6, 339.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cubic;

impl Loss for Cubic {
    const NAME: &'static str = "cubic";
    const COEFFICIENT: &'static str = "cubic_rate";
    const LABEL: &'static str = "cubic damping rate";
    const SYMBOL: &'static str = "a₃";
    const UNIT: UnitRule = UnitRule::LossRate(3);
    const WORDS: &'static str = "cubic damping";
    const METHOD: Option<[&'static str; 3]> = Some([
        "Nonlinear damping",
        "dA/dt = −(a_0 + a_1 A + a_2 A² + a_3 A³),   a_3 = η/8   for mηx²x′",
        "Energy lost per cycle; the force as in Lifshitz and Cross (2008) and Eichler et al. (2011). A \
         driven motion of amplitude R is damped by a_3 R² in addition to δ.",
    ]);
    const COMPARED: bool = false;
    const FREQUENCY_POWER: i32 = 0;
    const BACKBONE: f64 = 2.0 / 3.0;

    fn shape(amplitude: f64) -> f64 {
        amplitude * amplitude * amplitude
    }

    fn shape_derivative(amplitude: f64) -> f64 {
        3.0 * amplitude * amplitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_backbone_changes_it_as_its_work_says() {
        let found = crate::model::loss::tests::backbone_of(|x, v| x * x * v);
        assert!((found - Cubic::BACKBONE).abs() < 2e-3, "{found}");
    }
}

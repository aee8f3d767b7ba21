//! The trait that describes a kind of loss.

use crate::model::unit::UnitRule;

/// One kind of loss: its rate of amplitude loss, and the names of its coefficient.
///
/// The amplitude of a slowly decaying oscillation obeys, with a coefficient `c` for each kind,
///
/// ```text
/// dA/dt = - sum c g(A),      g(A) = 1 (sliding), A (viscous), A² (drag)
/// ```
///
/// (averaged over a cycle; eqs. (15) to (18) of Vitorino, Vieira and Rodrigues contain the first two).
pub(crate) trait Loss {
    /// Name in a model, e.g. `viscous` in `viscous+sliding`.
    const NAME: &'static str;
    /// Name of the reported coefficient, as in JSON, e.g. `decay_rate_per_s`.
    const COEFFICIENT: &'static str;
    /// The coefficient in words.
    const LABEL: &'static str;
    /// Its symbol.
    const SYMBOL: &'static str;
    /// Its unit, derived from the unit of the signal.
    const UNIT: UnitRule;
    /// Name of the loss in running text, e.g. `viscous damping`.
    const WORDS: &'static str;
    /// Title, formula and source for the list of equations in a report; `None` if the equations of the exact motion
    /// already contain it.
    const METHOD: Option<[&'static str; 3]> = None;
    /// Whether every analysis compares models with this term. Otherwise it takes part only if the requested model
    /// contains it.
    const COMPARED: bool = true;
    /// Power of the angular frequency in the damping `c g(A)/A` of a motion driven at that frequency.
    const FREQUENCY_POWER: i32;
    /// Relative fall of the loss over the relative rise of the frequency with amplitude, for a
    /// spring `k (x + alpha x³)` to first order in alpha, both at the amplitude of the fundamental.
    const BACKBONE: f64;
    /// A parameter of the shape that is fitted in addition to the coefficient; `None` if the shape is fixed.
    const SHAPE: Option<ShapeParameter> = None;
    /// Shape of the loss, `g(A)`, for an amplitude `A >= 0`.
    fn shape(amplitude: f64) -> f64;
    /// Its derivative, `dg/dA`.
    fn shape_derivative(amplitude: f64) -> f64;
    /// If the shape has a parameter `s`, the loss is `c A0 G(A/A0; s)` with the initial amplitude `A0`: `G(u; s)` and
    /// its derivatives by `u` and by `s`, given [`Loss::at_start`].
    fn relative(_u: f64, _s: f64, _at_start: [f64; 2]) -> [f64; 3] {
        [0.0; 3]
    }
    /// The value `G(u; s)` only.
    fn relative_value(u: f64, s: f64, at_start: [f64; 2]) -> f64 {
        Self::relative(u, s, at_start)[0]
    }
    /// The part of `G` that depends on the initial amplitude and is the same for every `u`: if `G` is
    /// `H(u/s)/H(1/s)`, these are `H(1/s)` and the derivative of `H` there.
    fn at_start(_s: f64) -> [f64; 2] {
        [1.0, 0.0]
    }
}

/// `G(u; s) = H(u/s)/H(1/s)` and its derivatives by `u` and by `s`, for a shape `H` given with its derivative. `G` is
/// one at the initial amplitude, so that the coefficient is the loss there, which data determine best.
pub(crate) fn scaled(h: impl Fn(f64) -> [f64; 2], u: f64, s: f64, at_start: [f64; 2]) -> [f64; 3] {
    let u = u.max(0.0);
    let ([here, slope], [first, first_slope]) = (h(u / s), at_start);
    [here / first, slope / (s * first), (here * first_slope - u * slope * first) / (s * s * first * first)]
}

/// A parameter of the shape of a loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShapeParameter {
    /// Its name as a parameter of the answer.
    pub(crate) name: &'static str,
    /// Its limits, both above zero: at zero the term is absent from the fit.
    pub(crate) range: [f64; 2],
    /// Start values of the search for it.
    pub(crate) starts: &'static [f64],
}

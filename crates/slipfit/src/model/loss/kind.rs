//! What a kind of loss says of itself.

use crate::model::unit::UnitRule;

/// One kind of loss: how fast it takes amplitude, and what its coefficient is called.
///
/// The amplitude of a slowly decaying oscillation obeys, with a coefficient `c` for each kind,
///
/// ```text
/// dA/dt = - sum c g(A),      g(A) = 1 (sliding), A (viscous), A² (drag)
/// ```
///
/// (averaged over a cycle; eqs. (15) to (18) of Vitorino, Vieira and Rodrigues have the first two).
pub(crate) trait Loss {
    /// Name in a model, e.g. `viscous` in `viscous+sliding`.
    const NAME: &'static str;
    /// Name of the coefficient that is reported, as in JSON, e.g. `decay_rate_per_s`.
    const COEFFICIENT: &'static str;
    /// The coefficient in words.
    const LABEL: &'static str;
    /// Its symbol.
    const SYMBOL: &'static str;
    /// Its unit, given the signal's.
    const UNIT: UnitRule;
    /// The loss in a sentence, e.g. `viscous damping`.
    const WORDS: &'static str;
    /// Title, formula and source for the list of equations in a report; none where the equations of
    /// the exact motion say it.
    const METHOD: Option<[&'static str; 3]> = None;
    /// Whether every analysis compares models with the term. One that is not compared takes part
    /// where a model asked for has it.
    const COMPARED: bool = true;
    /// Power of the angular frequency in the damping `c g(A)/A` of a motion driven at that frequency.
    const FREQUENCY_POWER: i32;
    /// Relative fall of the loss over the relative rise of the frequency with amplitude, for a
    /// spring `k (x + alpha x³)` to first order in alpha, both at the amplitude of the fundamental.
    const BACKBONE: f64;
    /// A parameter of the shape that is fitted besides the coefficient; none where the shape is fixed.
    const SHAPE: Option<ShapeParameter> = None;
    /// Shape of the loss, `g(A)`, for an amplitude `A >= 0`.
    fn shape(amplitude: f64) -> f64;
    /// Its derivative, `dg/dA`.
    fn shape_derivative(amplitude: f64) -> f64;
    /// Where the shape has a parameter `s`, the loss is `c A0 G(A/A0; s)` with the initial amplitude `A0`:
    /// `G(u; s)` and its derivatives by `u` and by `s`, given [`Loss::at_start`].
    fn relative(_u: f64, _s: f64, _at_start: [f64; 2]) -> [f64; 3] {
        [0.0; 3]
    }
    /// The first of these alone.
    fn relative_value(u: f64, s: f64, at_start: [f64; 2]) -> f64 {
        Self::relative(u, s, at_start)[0]
    }
    /// What `G` takes from the initial amplitude, the same for every `u`: where it is `H(u/s)/H(1/s)`, `H(1/s)` and
    /// the derivative of `H` there.
    fn at_start(_s: f64) -> [f64; 2] {
        [1.0, 0.0]
    }
}

/// `G(u; s) = H(u/s)/H(1/s)` and its derivatives by `u` and by `s`, of a shape `H` with its derivative: one at
/// the initial amplitude, so that the coefficient is the loss there, which data determine best.
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
    /// Its limits, both above zero: at zero a fit has no such term.
    pub(crate) range: [f64; 2],
    /// Where the search for it begins.
    pub(crate) starts: &'static [f64],
}

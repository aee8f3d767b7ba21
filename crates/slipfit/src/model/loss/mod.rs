//! The kinds of loss an oscillator may have, and the models that combine them.
//!
//! Each kind is one file with one type that implements [`Loss`]; [`LossTerm`] is their list. A new
//! kind needs its file and its line in the list below: model comparison, reports, JSON and tables
//! follow from there. `docs/extending.md` shows it step by step.

mod cubic;
mod drag;
mod model;
mod sliding;
mod viscous;

pub use cubic::Cubic;
pub use drag::Drag;
pub use model::LossModel;
pub use sliding::Sliding;
pub use viscous::Viscous;

use crate::model::unit::UnitRule;

/// One kind of loss: how fast it takes amplitude, and what its coefficient is called.
///
/// The amplitude of a slowly decaying oscillation obeys, with a coefficient `c` for each kind,
///
/// ```text
/// dA/dt = - sum c g(A),      g(A) = 1 (sliding), A (viscous), A² (drag) ...
/// ```
///
/// (averaged over a cycle; eqs. (15) to (18) of Vitorino, Vieira and Rodrigues have the first two).
pub trait Loss {
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
    /// Shape of the loss, `g(A)`, for an amplitude `A >= 0`.
    fn shape(amplitude: f64) -> f64;
    /// Its derivative, `dg/dA`.
    fn shape_derivative(amplitude: f64) -> f64;
}

macro_rules! loss_terms {
    ($($term:ident: $docs:literal),+ $(,)?) => {
        /// The kinds of loss slipfit knows, in the order in which a model names them.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum LossTerm {
            $(#[doc = $docs] $term),+
        }

        impl LossTerm {
            /// Every kind of loss.
            pub const ALL: &[LossTerm] = &[$(LossTerm::$term),+];

            /// Name in a model.
            pub const fn name(self) -> &'static str {
                match self { $(LossTerm::$term => <$term as Loss>::NAME),+ }
            }

            /// Name of its coefficient, as in JSON.
            pub const fn coefficient(self) -> &'static str {
                match self { $(LossTerm::$term => <$term as Loss>::COEFFICIENT),+ }
            }

            /// Its coefficient in words.
            pub const fn label(self) -> &'static str {
                match self { $(LossTerm::$term => <$term as Loss>::LABEL),+ }
            }

            /// Symbol of its coefficient.
            pub const fn symbol(self) -> &'static str {
                match self { $(LossTerm::$term => <$term as Loss>::SYMBOL),+ }
            }

            /// The loss in a sentence.
            pub const fn words(self) -> &'static str {
                match self { $(LossTerm::$term => <$term as Loss>::WORDS),+ }
            }

            /// Title, formula and source of its law, for the list of equations in a report.
            pub const fn method(self) -> Option<[&'static str; 3]> {
                match self { $(LossTerm::$term => <$term as Loss>::METHOD),+ }
            }

            /// Whether every analysis compares models with it.
            pub const fn is_compared(self) -> bool {
                match self { $(LossTerm::$term => <$term as Loss>::COMPARED),+ }
            }

            /// Power of the angular frequency in its damping of a driven motion.
            pub(crate) const fn frequency_power(self) -> i32 {
                match self { $(LossTerm::$term => <$term as Loss>::FREQUENCY_POWER),+ }
            }

            /// Relative fall of the loss over the relative rise of the frequency with amplitude.
            pub(crate) const fn backbone(self) -> f64 {
                match self { $(LossTerm::$term => <$term as Loss>::BACKBONE),+ }
            }

            /// Unit of its coefficient, given the signal's.
            pub const fn unit(self) -> UnitRule {
                match self { $(LossTerm::$term => <$term as Loss>::UNIT),+ }
            }

            /// Shape of the loss, `g(A)` in `dA/dt = -c g(A)`.
            pub fn shape(self, amplitude: f64) -> f64 {
                match self { $(LossTerm::$term => $term::shape(amplitude)),+ }
            }

            /// Derivative of the shape by the amplitude.
            pub fn shape_derivative(self, amplitude: f64) -> f64 {
                match self { $(LossTerm::$term => $term::shape_derivative(amplitude)),+ }
            }
        }
    };
}

/// Number of loss terms behind viscous, sliding and drag loss in [`LossTerm::ALL`].
pub(crate) const FURTHER: usize = LossTerm::ALL.len() - 3;

impl LossTerm {
    /// The loss terms behind viscous, sliding and drag loss: no fit needs to know which they are.
    pub(crate) fn further() -> &'static [LossTerm] {
        &Self::ALL[Self::ALL.len() - FURTHER..]
    }

    /// The terms that an analysis compares, given the model asked for.
    pub(crate) fn compared(asked: Option<LossModel>) -> impl Iterator<Item = LossTerm> {
        let wanted = move |t: &LossTerm| t.is_compared() || asked.is_some_and(|m| m.has(*t));
        Self::ALL.iter().copied().filter(wanted)
    }

    /// The further terms of the model asked for.
    pub(crate) fn further_of(asked: Option<LossModel>) -> impl Iterator<Item = LossTerm> {
        Self::further().iter().copied().filter(move |t| asked.is_some_and(|m| m.has(*t)))
    }
}

loss_terms! {
    Viscous: "Loss proportional to velocity.",
    Sliding: "Sliding (Coulomb, dry) friction: a force of constant size.",
    Drag: "Loss proportional to the square of velocity.",
    Cubic: "Nonlinear damping, proportional to the cube of the amplitude.",
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// [`Loss::BACKBONE`] of a force, from the energy it takes in a cycle of `x = A cos p + alpha A³/32
    /// cos 3p`, the motion under `x + alpha x³` to first order, over dE/dA.
    pub(super) fn backbone_of(force: impl Fn(f64, f64) -> f64) -> f64 {
        // Loss of amplitude at A = 1; E = A²/2 (1 + 9/16 alpha A²).
        let rate = |alpha: f64| {
            let omega = 1.0 + 0.375 * alpha;
            let n = 4000;
            let power = |i: usize| {
                let p = TAU * (i as f64 + 0.5) / n as f64;
                let x = p.cos() + alpha / 32.0 * (3.0 * p).cos();
                let v = -omega * (p.sin() + 3.0 * alpha / 32.0 * (3.0 * p).sin());
                force(x, v) * v
            };
            (0..n).map(power).sum::<f64>() / n as f64 / (1.0 + 1.125 * alpha)
        };
        let alpha = 1e-4;
        (1.0 - rate(alpha) / rate(0.0)) / (0.375 * alpha)
    }

    #[test]
    fn the_backbone_changes_each_loss_as_its_work_says() {
        let off = |term: LossTerm, found: f64| assert!((found - term.backbone()).abs() < 2e-3, "{found}");
        off(LossTerm::Viscous, backbone_of(|_, v| v));
        off(LossTerm::Sliding, backbone_of(|_, v| v.signum()));
        off(LossTerm::Drag, backbone_of(|_, v| v * v.abs()));
    }

    #[test]
    fn every_shape_has_its_derivative() {
        for &term in LossTerm::ALL {
            for amplitude in [0.1, 0.7, 2.0] {
                let h = 1e-6;
                let numeric = (term.shape(amplitude + h) - term.shape(amplitude - h)) / (2.0 * h);
                let error = (term.shape_derivative(amplitude) - numeric).abs();
                assert!(error < 1e-8, "{} at {amplitude}: off by {error}", term.name());
            }
        }
    }
}

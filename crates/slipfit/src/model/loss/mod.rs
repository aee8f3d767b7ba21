//! The kinds of loss an oscillator may have, and the models that combine them.
//!
//! Each kind is one file with one type that implements `kind::Loss`; [`LossTerm`] is their list. A new
//! kind needs its file and its line in the list below: model comparison, reports, JSON and tables
//! follow from there. `docs/extending.md` shows it step by step.

mod drag;
mod kind;
mod model;
mod sliding;
mod viscous;

use drag::Drag;
use kind::Loss;
pub use model::LossModel;
use sliding::Sliding;
use viscous::Viscous;

use crate::model::unit::UnitRule;

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

            /// Unit of its coefficient, given the signal's.
            pub(crate) const fn unit(self) -> UnitRule {
                match self { $(LossTerm::$term => <$term as Loss>::UNIT),+ }
            }

            /// Shape of the loss, `g(A)` in `dA/dt = -c g(A)`.
            pub(crate) fn shape(self, amplitude: f64) -> f64 {
                match self { $(LossTerm::$term => $term::shape(amplitude)),+ }
            }

            /// Derivative of the shape by the amplitude.
            pub(crate) fn shape_derivative(self, amplitude: f64) -> f64 {
                match self { $(LossTerm::$term => $term::shape_derivative(amplitude)),+ }
            }
        }
    };
}

loss_terms! {
    Viscous: "Loss proportional to velocity.",
    Sliding: "Sliding (Coulomb, dry) friction: a force of constant size.",
    Drag: "Loss proportional to the square of velocity.",
}

#[cfg(test)]
mod tests {
    use super::*;

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

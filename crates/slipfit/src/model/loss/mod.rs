//! The kinds of loss an oscillator may have, and the models that combine them.
//!
//! Each kind is one file with one type that implements `kind::Loss`; [`LossTerm`] is their list. A new kind needs a
//! file and a line in the list below: model comparison, reports, JSON and tables then include it. `docs/extending.md`
//! shows it step by step.

mod cubic;
mod drag;
mod kind;
mod model;
mod power;
mod presliding;
mod sliding;
mod stribeck;
mod viscous;

use cubic::Cubic;
use drag::Drag;
use kind::{Loss, ShapeParameter};
pub use model::LossModel;
use power::Power;
use presliding::Presliding;
use sliding::Sliding;
use stribeck::Stribeck;
use viscous::Viscous;

use crate::model::unit::UnitRule;

macro_rules! loss_terms {
    ($($term:ident: $docs:literal),+ $(,)?) => {
        /// The kinds of loss known to slipfit, in the order in which a model names them.
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

            /// Name of the loss in running text.
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
            pub(crate) const fn unit(self) -> UnitRule {
                match self { $(LossTerm::$term => <$term as Loss>::UNIT),+ }
            }

            /// The parameter of its shape; `None` if the shape is fixed.
            pub(crate) const fn shape_parameter(self) -> Option<ShapeParameter> {
                match self { $(LossTerm::$term => <$term as Loss>::SHAPE),+ }
            }

            /// Shape relative to the initial amplitude, given the shape parameter, and its derivatives.
            pub(crate) fn relative(self, u: f64, Shape { parameter, at_start }: Shape) -> [f64; 3] {
                match self { $(LossTerm::$term => $term::relative(u, parameter, at_start)),+ }
            }

            /// The value only, which is the rate that is integrated.
            #[inline]
            pub(crate) fn relative_value(self, u: f64, Shape { parameter, at_start }: Shape) -> f64 {
                match self { $(LossTerm::$term => $term::relative_value(u, parameter, at_start)),+ }
            }

            /// Its shape with this parameter.
            pub(crate) fn with(self, parameter: f64) -> Shape {
                let at_start = match self { $(LossTerm::$term => $term::at_start(parameter)),+ };
                Shape { parameter, at_start }
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

/// The shape of a loss that has a shape parameter; zero if the term is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Shape {
    pub(crate) parameter: f64,
    /// The part that depends on the initial amplitude: [`Loss::at_start`].
    at_start: [f64; 2],
}

/// Number of loss terms after viscous, sliding and drag loss in [`LossTerm::ALL`].
pub(crate) const FURTHER: usize = LossTerm::ALL.len() - 3;

/// Number of loss terms with a shape parameter; they are the last of the list.
pub(crate) const SHAPED: usize = {
    let (mut count, mut i) = (0, 0);
    while i < LossTerm::ALL.len() {
        if LossTerm::ALL[i].is_shaped() {
            count += 1;
        }
        i += 1;
    }
    count
};

impl LossTerm {
    /// Whether its shape has a parameter that is fitted. Such a loss is fitted to free decays only.
    pub const fn is_shaped(self) -> bool {
        self.shape_parameter().is_some()
    }

    /// The loss terms with a shape parameter.
    pub(crate) fn shaped() -> &'static [LossTerm] {
        &Self::ALL[Self::ALL.len() - SHAPED..]
    }

    /// The loss terms after viscous, sliding and drag loss; fits treat them all alike.
    pub(crate) fn further() -> &'static [LossTerm] {
        &Self::ALL[Self::ALL.len() - FURTHER..]
    }

    /// The terms that an analysis compares, given the requested model.
    pub(crate) fn compared(asked: Option<LossModel>) -> impl Iterator<Item = LossTerm> {
        let wanted = move |t: &LossTerm| t.is_compared() || asked.is_some_and(|m| m.has(*t));
        Self::ALL.iter().copied().filter(wanted)
    }

    /// The further terms of the requested model.
    pub(crate) fn further_of(asked: Option<LossModel>) -> impl Iterator<Item = LossTerm> {
        Self::further().iter().copied().filter(move |t| asked.is_some_and(|m| m.has(*t)))
    }
}

loss_terms! {
    Viscous: "Loss proportional to velocity.",
    Sliding: "Sliding (Coulomb, dry) friction: a force of constant size.",
    Drag: "Loss proportional to the square of velocity.",
    Cubic: "Nonlinear damping, proportional to the cube of the amplitude.",
    Power: "Loss by a power of the amplitude that is fitted.",
    Stribeck: "Friction that falls with speed.",
    Presliding: "Friction of contacts that yield before they slide.",
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// [`Loss::BACKBONE`] of a force, from the energy it dissipates per cycle of `x = A cos p + alpha A³/32 cos 3p`,
    /// the motion under `x + alpha x³` to first order, over dE/dA.
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
    fn shapes_with_a_parameter_are_last_and_have_their_derivatives() {
        assert!(LossTerm::ALL.iter().rev().take(SHAPED).all(|t| t.is_shaped()));
        for &term in LossTerm::shaped() {
            let parameter = term.shape_parameter().expect("has one");
            assert!(parameter.range[0] > 0.0, "{parameter:?}");
            assert!(!term.is_compared());
            for &s in parameter.starts {
                assert!((parameter.range[0]..=parameter.range[1]).contains(&s));
                for u in [0.05, 0.3, 0.9, 1.0] {
                    let h = 1e-6;
                    let at = |u: f64, s: f64| term.relative(u, term.with(s));
                    let [value, by_u, by_s] = at(u, s);
                    assert_eq!(value, term.relative_value(u, term.with(s)));
                    let numeric = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]) / (2.0 * h);
                    let u_off = (by_u - numeric(at(u + h, s), at(u - h, s))).abs();
                    let s_off = (by_s - numeric(at(u, s + h), at(u, s - h))).abs();
                    assert!(u_off < 1e-7, "{} at {u}, {s}: {u_off}", term.name());
                    assert!(s_off < 1e-7, "{} at {u}, {s}: {s_off}", term.name());
                }
            }
        }
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

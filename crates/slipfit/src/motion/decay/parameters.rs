//! Layout of the parameters of a free decay, common to all fits: the amplitude, its losses, the phase, the offset.

use super::amplitude::{AmplitudeLaw, sliding_gain};
use super::path::{CARRIED, SHAPE};
use crate::model::loss::{LossTerm, Shape};

/// Initial amplitude.
pub(crate) const A0: usize = 0;
/// Friction displacement.
pub(crate) const X_F: usize = 1;
/// Decay rate, 1/s.
pub(crate) const DELTA: usize = 2;
/// Drag rate; the coefficients of further loss terms follow.
pub(crate) const DRAG: usize = 3;
/// Phase at the start, rad.
pub(crate) const PHASE: usize = CARRIED;
/// Angular frequency at vanishing amplitude, rad/s.
pub(crate) const OMEGA: usize = PHASE + 1;
/// Change of angular frequency per squared reference amplitude, rad/s per A².
pub(crate) const BACKBONE: usize = PHASE + 2;
/// Change of angular frequency with time, rad/s².
pub(crate) const CHIRP: usize = PHASE + 3;
/// Offset, its slope and its curvature over the window.
pub(crate) const OFFSET: usize = PHASE + 4;
/// Number of parameters.
pub(crate) const COUNT: usize = OFFSET + 3;

/// Amplitude law of a parameter vector, before correction for the backbone.
pub(crate) fn law_of(p: &[f64], omega: f64) -> AmplitudeLaw {
    let [gain, ..] = sliding_gain(p[DELTA], omega);
    let further = std::array::from_fn(|k| p[DRAG + 1 + k]);
    let shape = |k: usize| {
        if p[SHAPE + k] == 0.0 { Shape::default() } else { LossTerm::shaped()[k].with(p[SHAPE + k]) }
    };
    let shapes = std::array::from_fn(shape);
    AmplitudeLaw { further, shapes, ..AmplitudeLaw::from_rates(p[A0], [gain * p[X_F], p[DELTA], p[DRAG]]) }
}

/// Index of the shape parameter of a loss.
pub(crate) fn shape_slot(term: LossTerm) -> Option<usize> {
    LossTerm::shaped().iter().position(|t| *t == term).map(|k| SHAPE + k)
}

/// Index of the shape parameter of the loss with this coefficient index, and the start value of its search.
pub(crate) fn shape_of(coefficient: usize) -> Option<(usize, f64)> {
    let mut further = LossTerm::further().iter().zip(DRAG + 1..);
    let (term, _) = further.find(|(_, slot)| *slot == coefficient)?;
    shape_slot(*term).zip(first_shape(*term))
}

/// Start value of the search for the shape of a loss.
pub(crate) fn first_shape(term: LossTerm) -> Option<f64> {
    term.shape_parameter()?.starts.first().copied()
}

/// Limits of a parameter: only shape parameters of losses have finite ones.
pub(crate) fn range(parameter: usize) -> [f64; 2] {
    let term = parameter.checked_sub(SHAPE).and_then(|k| LossTerm::shaped().get(k));
    let shape = term.and_then(|term| term.shape_parameter());
    shape.map_or([f64::NEG_INFINITY, f64::INFINITY], |shape| shape.range)
}

/// Whether the shape parameters of the losses lie within their limits.
pub(crate) fn shapes_exist(p: &[f64]) -> bool {
    let within = |(s, term): (&f64, &LossTerm)| {
        let range = term.shape_parameter().map_or([0.0; 2], |shape| shape.range);
        *s == 0.0 || (range[0]..=range[1]).contains(s)
    };
    p[SHAPE..CARRIED].iter().zip(LossTerm::shaped()).all(within)
}

/// Derivatives with respect to A0, x_F, delta, drag and further terms from those with respect to A0, a0, a1, a2 …
///
/// `gain`: [`sliding_gain`] of these parameters.
#[inline(always)]
pub(crate) fn by_parameters(mut by: [f64; CARRIED], p: &[f64], gain: &[f64; 3]) -> [f64; CARRIED] {
    let [gain, gain_by_delta, _] = *gain;
    by[DELTA] += by[X_F] * p[X_F] * gain_by_delta;
    by[X_F] *= gain;
    by
}

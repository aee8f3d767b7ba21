//! Other sets of terms beside the losses than the one reported.

use super::criteria::AnswerCriteria;
use super::response::{BG_RE, DUFFING, FLOOR, OFFSET};
use crate::inference::least_squares::Fit;
use crate::inference::model_selection::ModelComparison;

/// Which of the terms beside the losses take part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TermSet {
    pub(super) background: bool,
    pub(super) delay: bool,
    /// The delay is the background's too.
    pub(super) background_delayed: bool,
    /// A constant in every amplitude.
    pub(super) offset: bool,
    /// A noise floor in every amplitude.
    pub(super) floor: bool,
    /// The natural frequency depends on the amplitude.
    pub(super) duffing: bool,
}

/// The fit of another set, or of the same one with another background or without drag.
#[derive(Debug, Clone)]
pub(crate) struct OtherFit {
    pub(crate) set: TermSet,
    /// Best fit with the limits of the losses lifted.
    pub(crate) unbounded: Fit,
    /// Best fit within them.
    pub(crate) bounded: Fit,
}

/// A fit beside the one reported.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) fit: OtherFit,
    /// Over that of the fit reported and of the others of its kind.
    pub(crate) weight: f64,
    /// The same for the natural frequency, for which a Duffing term is probable before the data.
    pub(crate) frequency_weight: f64,
    /// By which its BIC is higher than that of the fit reported.
    pub(crate) delta_bic: f64,
}

/// What curve and reference say where each has a drive of its own.
#[derive(Debug)]
pub(crate) struct FreeGain {
    /// The fit of the curve; the sums of squares are those of both.
    pub(crate) alternative: Alternative,
    /// Drive of the curve by its shape over that of the reference.
    pub(crate) ratio: f64,
}

/// Whether a constant or a noise floor in every amplitude takes part and no background.
fn is_level(free: &[usize]) -> bool {
    (free.contains(&OFFSET) || free.contains(&FLOOR)) && !free.contains(&BG_RE)
}

/// Free parameters, a constant or a noise floor counted like the two of a background: a background is the rule, and under
/// amplitudes they look alike.
pub(super) fn counted_parameters(free: &[usize]) -> usize {
    free.len() + usize::from(is_level(free))
}

/// The other fits with their weights, those that count; `exp(-delta/2)` where `delta` is the
/// difference of `n ln rss + c p` (Burnham and Anderson 2002, *Model Selection and Multimodel
/// Inference*, have `c = 2`), `c` being [`AnswerCriteria::alternative_penalty`].
pub(super) fn weighed(
    others: Vec<OtherFit>,
    comparison: &ModelComparison,
    c: &AnswerCriteria,
) -> Vec<Alternative> {
    let Some(chosen) = comparison.reported().or_else(|| comparison.preferred()) else { return Vec::new() };
    let noise = comparison.noise;
    let effective = noise.observations / noise.variance_inflation;
    let rank = |rss: f64, parameters: usize| {
        effective * rss.max(f64::MIN_POSITIVE).ln() + c.alternative_penalty * parameters as f64
    };
    let own = rank(chosen.bounded.rss, counted_parameters(&chosen.unbounded.free));
    let own_bic = noise.bic(chosen.bounded.rss, chosen.unbounded.free.len());
    let mut list: Vec<Alternative> = others
        .into_iter()
        .map(|fit| {
            let free = &fit.unbounded.free;
            let weight = (0.5 * (own - rank(fit.bounded.rss, counted_parameters(free)))).exp();
            let delta_bic = noise.bic(fit.bounded.rss, free.len()) - own_bic;
            Alternative { fit, weight, frequency_weight: 0.0, delta_bic }
        })
        .filter(|a| a.weight.is_finite() && a.weight > c.least_weight)
        .collect();
    // Several minima of one set are one model.
    let of_set = |set: TermSet| list.iter().filter(move |a| a.fit.set == set).map(|a| a.weight);
    let shares: Vec<f64> =
        list.iter().map(|a| of_set(a.fit.set).fold(0.0, f64::max) / of_set(a.fit.set).sum::<f64>()).collect();
    list.iter_mut().zip(shares).for_each(|(a, share)| a.weight *= share);
    // A Duffing term, a background and a constant or noise floor look alike, so that none may take the weight of
    // another: each kind is weighed against the fit reported alone.
    let duffing = chosen.unbounded.free.contains(&DUFFING);
    let odds = if duffing { 1.0 / c.duffing_odds } else { c.duffing_odds };
    let (springs, sets): (Vec<_>, Vec<_>) = list.iter_mut().partition(|a| a.fit.set.duffing != duffing);
    let share = |mut kind: Vec<&mut Alternative>, odds: f64| {
        let total: f64 = kind.iter().map(|a| a.weight).sum();
        for a in &mut kind {
            a.frequency_weight = odds * a.weight / (1.0 + odds * total);
            a.weight /= 1.0 + total;
        }
    };
    let (levels, sets): (Vec<_>, Vec<_>) = sets.into_iter().partition(|a| is_level(&a.fit.unbounded.free));
    share(sets, 1.0);
    share(levels, 1.0);
    share(springs, odds);
    list
}

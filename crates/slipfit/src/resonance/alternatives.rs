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

/// What a fit has otherwise than the one reported. The fits of one kind are rivals; those of several kinds look alike or
/// may be there together, so that none takes the weight of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Background, delay or drive.
    Instrument,
    /// A constant or a noise floor in every amplitude.
    Level,
    /// With or without a Duffing term.
    Spring,
    /// The same terms, the points weighed by another law of their noise.
    Noise,
}

/// A fit beside the one reported.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) fit: OtherFit,
    pub(crate) kind: Kind,
    /// Over that of the fit reported and of the others of its kind.
    pub(crate) weight: f64,
    /// The same for the natural frequency, for which a Duffing term is probable before the data.
    pub(crate) frequency_weight: f64,
    /// By which its BIC is higher than that of the fit reported.
    pub(crate) delta_bic: f64,
}

/// What the curve says by itself, with a drive that is neither given nor that of its reference.
#[derive(Debug)]
pub(crate) struct FreeGain {
    /// The fit of the curve; the sums of squares are those of both.
    pub(crate) alternative: Alternative,
    /// Drive of the curve by its shape over the one given or that of the reference.
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
    let duffing = chosen.unbounded.free.contains(&DUFFING);
    let mut list: Vec<Alternative> = others
        .into_iter()
        .map(|fit| {
            let free = &fit.unbounded.free;
            let weight = (0.5 * (own - rank(fit.bounded.rss, counted_parameters(free)))).exp();
            let delta_bic = noise.bic(fit.bounded.rss, free.len()) - own_bic;
            let kind = match fit.set.duffing != duffing {
                true => Kind::Spring,
                false if is_level(free) => Kind::Level,
                false => Kind::Instrument,
            };
            Alternative { kind, weight, frequency_weight: 0.0, delta_bic, fit }
        })
        .filter(|a| a.weight.is_finite() && a.weight > c.least_weight)
        .collect();
    // Several minima of one set are one model.
    let of_set = |set: TermSet| list.iter().filter(move |a| a.fit.set == set).map(|a| a.weight);
    let shares: Vec<f64> =
        list.iter().map(|a| of_set(a.fit.set).fold(0.0, f64::max) / of_set(a.fit.set).sum::<f64>()).collect();
    list.iter_mut().zip(shares).for_each(|(a, share)| a.weight *= share);
    for kind in [Kind::Instrument, Kind::Level, Kind::Spring] {
        let odds = match kind {
            Kind::Spring if duffing => 1.0 / c.duffing_odds,
            Kind::Spring => c.duffing_odds,
            _ => 1.0,
        };
        let total: f64 = list.iter().filter(|a| a.kind == kind).map(|a| a.weight).sum();
        for a in list.iter_mut().filter(|a| a.kind == kind) {
            a.frequency_weight = odds * a.weight / (1.0 + odds * total);
            a.weight /= 1.0 + total;
        }
    }
    list
}

//! Sets of terms apart from the losses that differ from the reported one.

use super::criteria::AnswerCriteria;
use super::response::{BG_RE, DUFFING, FLOOR, OFFSET};
use crate::inference::least_squares::Fit;
use crate::inference::model_selection::ModelComparison;

/// Terms apart from the losses that are included in a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TermSet {
    pub(super) background: bool,
    pub(super) delay: bool,
    /// The delay also applies to the background.
    pub(super) background_delayed: bool,
    /// A constant in every amplitude.
    pub(super) offset: bool,
    /// A noise floor in every amplitude.
    pub(super) floor: bool,
    /// The natural frequency depends on the amplitude.
    pub(super) duffing: bool,
}

/// The fit of another set, or of the same set with another background or without drag.
#[derive(Debug, Clone)]
pub(crate) struct OtherFit {
    pub(crate) set: TermSet,
    /// Best fit without limits on the losses.
    pub(crate) unbounded: Fit,
    /// Best fit within the limits.
    pub(crate) bounded: Fit,
}

/// How a fit differs from the reported one. The fits of one kind are rivals; those of different kinds look alike or may
/// be present together, so that none reduces the weight of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Background, delay or drive.
    Instrument,
    /// A constant or a noise floor in every amplitude.
    Level,
    /// With or without a Duffing term.
    Spring,
    /// The same terms, with the points weighted by another noise law.
    Noise,
}

/// A fit in addition to the reported one.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    pub(crate) fit: OtherFit,
    pub(crate) kind: Kind,
    /// Probability relative to the reported fit and the others of its kind.
    pub(crate) weight: f64,
    /// The same for the natural frequency, for which a Duffing term is probable a priori.
    pub(crate) frequency_weight: f64,
    /// Its BIC minus that of the reported fit.
    pub(crate) delta_bic: f64,
}

/// The fit of the curve alone, with a drive that is neither given nor that of its reference.
#[derive(Debug)]
pub(crate) struct FreeGain {
    /// The fit of the curve; the sums of squares are those of curve and reference.
    pub(crate) alternative: Alternative,
    /// Drive of the curve implied by its shape, over the one given or that of the reference.
    pub(crate) ratio: f64,
}

/// Whether a constant or a noise floor in every amplitude is included without a background.
fn is_level(free: &[usize]) -> bool {
    (free.contains(&OFFSET) || free.contains(&FLOOR)) && !free.contains(&BG_RE)
}

/// Number of free parameters; a constant or a noise floor counts as two, like a background: a background is more
/// common, and in amplitudes they look alike.
pub(super) fn counted_parameters(free: &[usize]) -> usize {
    free.len() + usize::from(is_level(free))
}

/// The other fits with their weights, if these are large enough: `exp(-delta/2)` with `delta` the difference of
/// `n ln rss + c p` (Burnham and Anderson 2002, *Model Selection and Multimodel Inference*, have `c = 2`), `c` being
/// [`AnswerCriteria::alternative_penalty`].
pub(super) fn weighted(
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
    // Several minima of one set share the weight of one model.
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

//! Comparison of the fit of the curve alone with the fit with its drive known, in case the curve was measured with
//! another gain or drive than its reference or than given.

use super::alternatives::{Alternative, FreeGain, Kind, OtherFit, TermSet, counted_parameters};
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::prepared::PreparedCurve;
use super::problem::Problem;
use super::reference::FrictionFreeFit;
use super::response::X_0;
use super::term_sets::within_limits;
use super::{Options, selection};
use crate::inference::least_squares::minimise;

/// Number of parameters of a reference without phases.
const OF_REFERENCE: usize = 3;

/// Fit of the curve `alone`, without its reference; `None` if the curve alone is not a resonance.
///
/// A background, a constant, drag or sliding friction that only the known drive requires compensates for a different
/// drive; therefore all parameters enter the weights of the fits.
pub(super) fn free_gain(
    fitted: &FittedModels,
    alone: PreparedCurve,
    options: &Options,
    criteria: &Criteria,
    errors_known: bool,
) -> Option<FreeGain> {
    let reference = fitted.problem.reference.as_ref();
    let of_reference = reference.map_or(0, |r| OF_REFERENCE + usize::from(r.complex));
    let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
    let options = Options { reference: None, drive_amplitude: None, ..options.clone() };
    let alone = selection::best_fit(&alone, &options, criteria, errors_known).ok()?;
    let other = alone.comparison.reported().or_else(|| alone.comparison.preferred())?;
    // Evaluated with the weights of the points in the joint fit.
    let free = other.unbounded.free.clone();
    let problem = Problem { reference: None, prior: None, ..fitted.problem.clone() }.with(&free);
    let problem = Problem { background_delayed: alone.problem.background_delayed, ..problem };
    let mut unbounded = minimise(&problem, &other.unbounded.parameters, &free)?;
    let mut bounded = within_limits(&problem, &unbounded)?;
    let left = match reference {
        Some(reference) => {
            let own = FrictionFreeFit::new(reference.clone(), &problem, false, criteria).ok()?;
            let observations = reference.observations() - of_reference as f64;
            fitted.problem.reference_weight * own.variance * observations.max(1.0)
        }
        None => 0.0,
    };
    (unbounded.rss, bounded.rss) = (unbounded.rss + left, bounded.rss + left);
    let c = &criteria.reference;
    let noise = fitted.comparison.noise;
    let effective = noise.observations / noise.variance_inflation;
    let penalty = criteria.answer.alternative_penalty;
    let rank = |rss: f64, parameters: usize| {
        effective * rss.max(f64::MIN_POSITIVE).ln() + penalty * parameters as f64
    };
    let gain = rank(chosen.bounded.rss, counted_parameters(&chosen.unbounded.free))
        - rank(bounded.rss, counted_parameters(&free) + of_reference);
    let odds = c.other_gain_odds * (0.5 * gain).exp();
    let weight = if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 };
    let delta_bic = noise.bic(bounded.rss, free.len() + of_reference)
        - noise.bic(chosen.bounded.rss, chosen.unbounded.free.len());
    let ratio = bounded.parameters[X_0] / chosen.bounded.parameters[X_0];
    let fit = OtherFit { set: TermSet::of(&problem, &free), unbounded, bounded };
    let kind = Kind::Instrument;
    let alternative = Alternative { fit, kind, weight, frequency_weight: weight, delta_bic };
    Some(FreeGain { alternative, ratio })
}

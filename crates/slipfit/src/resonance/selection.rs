//! The hypotheses about a curve that are fitted, and the choice among the fits.

use super::criteria::{Criteria, SelectionCriteria};
use super::fitted_models::FittedModels;
use super::hypothesis::Hypothesis;
use super::hypothesis_fit::HypothesisFit;
use super::noise::NoiseLaw;
use super::prepared::PreparedCurve;
use super::residuals::autocorrelation;
use super::{Options, models};
use crate::Error;

/// The best hypothesis; if the points have no given errors, with noise proportional to the amplitudes if the residuals
/// show it.
pub(super) fn best_fit(
    curve: &PreparedCurve,
    options: &Options,
    criteria: &Criteria,
    errors_known: bool,
) -> Result<FittedModels, Error> {
    let mut found = best_hypothesis(curve, options, criteria)?;
    if errors_known {
        return Ok(found);
    }
    let mut last: Option<NoiseLaw> = None;
    for _ in 0..criteria.noise.rounds {
        let Some(law) = NoiseLaw::of(&found, last, &criteria.noise) else { break };
        let settled = last.is_some_and(|last| law.is_near(last, criteria.noise.settled));
        let Some(weighted) = law.weighted(curve, &found).filter(|_| !settled) else { break };
        let Ok(mut better) = best_hypothesis(&weighted, options, criteria) else { break };
        better.proportional_noise = Some(law.part(&better));
        (found, last) = (better, Some(law));
    }
    if found.proportional_noise.is_none() {
        let others = NoiseLaw::alternatives(&found, &criteria.noise);
        found.alternatives.extend(others);
    }
    Ok(found)
}

/// Fits the plain curve, and the other hypotheses suggested by its fit or the options; returns the loss models of the
/// one chosen by the rules of [`select`].
fn best_hypothesis(
    curve: &PreparedCurve,
    options: &Options,
    criteria: &Criteria,
) -> Result<FittedModels, Error> {
    let c = &criteria.selection;
    let work = &curve.main.work;
    let fit = |hypothesis| fit(curve, hypothesis, options, criteria);
    // If the delay of a curve is missing, the search for the plain curve may not converge.
    let share = if curve.main.complex { criteria.search.share } else { 1.0 };
    let plain = work.within(share, || fit(Hypothesis::plain(curve)));
    // A requested delay may be many turns across the curve, which only its own start value can reach.
    let delay_asked = options.terms.delay == Some(true) && curve.main.complex;
    let first = plain.as_ref().ok().map(PlainOutcome::of);
    let implausible = first.is_some_and(|f| f.implausible(c));
    let insufficient = first.is_some_and(|f| f.insufficient(c));
    let amplitudes =
        (implausible && curve.main.separate_phase).then(|| Hypothesis::amplitudes(curve)).flatten();
    let compared = |h| work.within(criteria.search.share, || models::compare(curve, fit(h)?));
    let amplitudes = amplitudes.and_then(|h| compared(h).ok());
    let mut others: Vec<FittedModels> = Vec::new();
    if delay_asked || implausible || insufficient {
        // If the plain curve is plausible, its outliers are valid.
        let plausible = plain.as_ref().ok().filter(|_| insufficient && !implausible);
        let without = plausible.map(|plain| curve.weighted(&plain.problem.main.weight));
        let by_amplitudes = amplitudes.as_ref().map_or(f64::INFINITY, |a| Outcome::of(a).variance);
        let of_use = |f: PlainOutcome| {
            if delay_asked { f.variance } else { f.variance_for_instrument(by_amplitudes, c) }
        };
        let most = first.map_or(f64::INFINITY, |f| c.hopeless * of_use(f));
        others = with_instrument(without.as_ref().unwrap_or(curve), most, options, criteria);
    }
    others.extend(amplitudes);
    let outcomes: Vec<Outcome> = others.iter().map(Outcome::of).collect();
    let chosen = plain.and_then(|plain| match select(&PlainOutcome::of(&plain), &outcomes, c) {
        Some(other) => Ok(others.swap_remove(other)),
        None => {
            // Work is reserved for its loss models, whatever its fit and the others used.
            work.reserve(criteria.search.models_part);
            models::compare(curve, plain)
        }
    });
    if !delay_asked {
        return chosen;
    }
    let left = |d: &FittedModels| Outcome::of(d).variance;
    let with_delay =
        others.into_iter().filter(|d| !d.phases_ignored).min_by(|a, b| left(a).total_cmp(&left(b)));
    match (chosen, with_delay) {
        (Ok(chosen), Some(with_delay)) if left(&with_delay) < left(&chosen) => Ok(with_delay),
        (Err(_), Some(with_delay)) => Ok(with_delay),
        (chosen, _) => chosen,
    }
}

/// Fits with backgrounds and delays from the start, until the residuals of one are only noise; those with a variance
/// above `most` are excluded.
fn with_instrument(
    curve: &PreparedCurve,
    most: f64,
    options: &Options,
    criteria: &Criteria,
) -> Vec<FittedModels> {
    let noise = criteria.selection.noise_variances * curve.fitted_noise * curve.fitted_noise;
    let mut found = Vec::new();
    for hypothesis in Hypothesis::with_instrument(curve, options, criteria) {
        let described = curve.main.work.within(criteria.search.share, || {
            let fit = fit(curve, hypothesis, options, criteria).ok().filter(|f| f.variance() <= most)?;
            models::compare(curve, fit).ok()
        });
        let Some(described) = described else { continue };
        let nothing_left = Outcome::of(&described).variance < noise;
        found.push(described);
        if nothing_left {
            break;
        }
    }
    found
}

/// Fit of one hypothesis with the terms that the data require.
fn fit<'a>(
    curve: &PreparedCurve,
    hypothesis: Hypothesis,
    options: &'a Options,
    criteria: &'a Criteria,
) -> Result<HypothesisFit<'a>, Error> {
    let mut fit = HypothesisFit::new(curve, hypothesis, options, criteria)?;
    fit.add_needed();
    fit.settle_reference();
    fit.settle_instrument();
    if fit.settle_reference() {
        fit.settle_instrument();
    }
    fit.settle_minima();
    Ok(fit)
}

/// Properties of the plain curve used by the rules.
#[derive(Debug, Clone, Copy)]
struct PlainOutcome {
    complex: bool,
    /// Height of the peak.
    height: f64,
    /// Variance of the points about their mean.
    variation: f64,
    /// Residual variance of a point before terms were added.
    first_variance: f64,
    /// The same after terms were added.
    variance: f64,
    /// Variance of the noise from differences between neighbours.
    noise_variance: f64,
    /// Whether instrument terms, drag or Duffing were added, or a background is included.
    more_terms: bool,
}

impl PlainOutcome {
    fn of(fit: &HypothesisFit) -> Self {
        let residuals = autocorrelation(&fit.problem, &fit.fit, &fit.criteria.residuals);
        Self {
            complex: fit.problem.main.complex,
            height: fit.hypothesis.peak.height,
            variation: fit.problem.main.variation(),
            first_variance: fit.first_variance,
            variance: fit.variance(),
            noise_variance: fit.noise.min(residuals.neighbour_noise).powi(2),
            more_terms: fit.has_more_terms(),
        }
    }

    /// Whether its phases fit no resonance, and added instrument terms do not correct this.
    fn implausible(&self, c: &SelectionCriteria) -> bool {
        let suspect = self.first_variance.sqrt() > c.implausible_residual * self.height
            || self.first_variance > c.implausible_part * self.variation;
        self.complex && suspect && self.leaves_more_than_noise(c)
    }

    /// Whether terms were added one by one and the residuals are more than noise; fitted together they may suffice.
    fn insufficient(&self, c: &SelectionCriteria) -> bool {
        self.complex && self.more_terms && self.leaves_more_than_noise(c)
    }

    /// Largest variance with phases and instrument terms at which these replace the plain curve; `amplitudes` is the
    /// residual variance of its amplitudes alone.
    fn variance_to_replace_plain(&self, amplitudes: f64, c: &SelectionCriteria) -> f64 {
        let with_phases = c.phases_over_amplitudes * amplitudes;
        with_phases.min(c.phases_over_plain * self.first_variance).min(self.variance)
    }

    /// Whether amplitudes alone explain the curve so much better that its phases are invalid.
    fn phases_are_wrong(&self, amplitudes: f64, c: &SelectionCriteria) -> bool {
        self.implausible(c)
            && amplitudes < c.amplitudes_over_plain * self.first_variance
            && c.phases_over_amplitudes * amplitudes < self.variance
    }

    /// Largest variance with which a hypothesis with instrument terms from the start may be chosen.
    fn variance_for_instrument(&self, amplitudes: f64, c: &SelectionCriteria) -> f64 {
        let instead = if self.implausible(c) { self.variance_to_replace_plain(amplitudes, c) } else { 0.0 };
        let asked = self.insufficient(c) && !self.phases_are_wrong(amplitudes, c);
        let together = if asked { c.together * self.variance } else { 0.0 };
        instead.max(together)
    }

    fn leaves_more_than_noise(&self, c: &SelectionCriteria) -> bool {
        self.variance > c.noise_variances * self.noise_variance
    }
}

/// Properties of another hypothesis used by the rules.
#[derive(Debug, Clone, Copy)]
struct Outcome {
    /// Whether it uses amplitudes alone, without phases.
    amplitudes: bool,
    /// Residual variance of a point for the preferred loss model, with no negative loss.
    variance: f64,
}

impl Outcome {
    fn of(d: &FittedModels) -> Self {
        let preferred = d.comparison.preferred();
        let variance = preferred.map_or(f64::INFINITY, |f| d.comparison.noise.residual_variance(&f.bounded));
        Self { amplitudes: d.phases_ignored, variance }
    }
}

/// The hypothesis that explains what the plain curve cannot; `None` for the plain curve.
fn select(plain: &PlainOutcome, others: &[Outcome], c: &SelectionCriteria) -> Option<usize> {
    let least = |amplitudes: bool| {
        let of_kind = (0..others.len()).filter(|&i| others[i].amplitudes == amplitudes);
        of_kind.min_by(|&i, &j| others[i].variance.total_cmp(&others[j].variance))
    };
    let left = |i: Option<usize>| i.map_or(f64::INFINITY, |i| others[i].variance);
    let (instrument, amplitudes) = (least(false), least(true));
    if plain.implausible(c) && left(instrument) < plain.variance_to_replace_plain(left(amplitudes), c) {
        return instrument;
    }
    if plain.phases_are_wrong(left(amplitudes), c) {
        return amplitudes;
    }
    let better = plain.insufficient(c) && left(instrument) < c.together * plain.variance;
    instrument.filter(|_| better)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(variance: f64, more_terms: bool) -> PlainOutcome {
        PlainOutcome {
            complex: true,
            height: 1.0,
            variation: 0.1,
            first_variance: variance,
            variance,
            noise_variance: 1e-6,
            more_terms,
        }
    }

    fn instrument(variance: f64) -> Outcome {
        Outcome { amplitudes: false, variance }
    }

    fn amplitudes(variance: f64) -> Outcome {
        Outcome { amplitudes: true, variance }
    }

    #[test]
    fn a_curve_that_fits_asks_for_nothing_else() {
        let c = SelectionCriteria::default();
        let plain = plain(1e-6, true);
        assert!(!plain.implausible(&c));
        assert!(!plain.insufficient(&c));
        assert_eq!(select(&plain, &[], &c), None);
    }

    #[test]
    fn a_fit_that_leaves_the_curve_as_it_is_explains_nothing() {
        let c = SelectionCriteria::default();
        // A narrow peak on a high background: the residuals are small compared with its height.
        let left = PlainOutcome { variation: 0.004, ..plain(0.004, false) };
        assert!(left.implausible(&c));
        assert_eq!(select(&left, &[instrument(1e-6)], &c), Some(0));
        assert!(!PlainOutcome { variation: 0.4, ..left }.implausible(&c));
    }

    #[test]
    fn phases_that_fit_no_resonance_are_ignored_where_the_amplitudes_fit() {
        let c = SelectionCriteria::default();
        let plain = plain(0.1, false);
        assert!(plain.implausible(&c));
        assert_eq!(select(&plain, &[instrument(0.02), amplitudes(1e-6)], &c), Some(1));
        // Phases that fit with a background and a delay double the data.
        assert_eq!(select(&plain, &[instrument(0.02), instrument(1.5e-6), amplitudes(1e-6)], &c), Some(1));
        // Amplitudes that fit hardly better are no evidence against the phases.
        assert_eq!(select(&plain, &[instrument(0.02), amplitudes(0.011)], &c), Some(0));
        assert_eq!(select(&plain, &[instrument(0.06), amplitudes(0.05)], &c), None);
    }

    #[test]
    fn terms_together_must_leave_clearly_less_than_one_by_one() {
        let c = SelectionCriteria::default();
        let plain = plain(1e-4, true);
        assert!(plain.insufficient(&c));
        assert_eq!(select(&plain, &[instrument(0.9e-4)], &c), None);
        assert_eq!(select(&plain, &[instrument(0.9e-4), instrument(0.7e-4)], &c), Some(1));
    }
}

//! From fits to reported values: estimates inside their limits, candidates, correlations.

use super::comparison::{Candidate, Correlation, SlidingEvidence, Values};
use super::parameter::Parameter;
use super::quantity::Quantity;
use super::warning::Warning;
use crate::inference::Z_95;
use crate::inference::bounded::minimise_bounded;
use crate::inference::least_squares::{Fit, LeastSquares, STEP_TOLERANCE};
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::noise::NoiseModel;
use crate::inference::profile::{Estimate, Profile};
use crate::inference::quadratic::conditional_minimum;
use crate::model::loss::{LossModel, LossTerm};
use crate::numeric::order::sort_by_value;
use std::borrow::Cow;

/// A fit whose loss coefficients are reported.
pub(crate) struct LossFit<'a> {
    pub(crate) problem: &'a dyn LeastSquares,
    pub(crate) unbounded: &'a Fit,
    pub(crate) noise: NoiseModel,
    /// [`ReportCriteria::near_limit`](super::ReportCriteria::near_limit).
    pub(crate) near_limit: f64,
    /// Other minima of the same sum of squares.
    pub(crate) other_minima: &'a [Fit],
}

impl LossFit<'_> {
    /// Estimate and interval of the coefficient in `slot`, which lies between zero and `most`. The coefficients in
    /// `others` of the same fit are kept non-negative; `curved` requests the profile also far from zero.
    ///
    /// The value is that of the constrained optimum. If another coefficient is at or near its limit, the sum of squares
    /// has a kink there, and the interval is taken from the profile. `None` if no such optimum is reached, or if the
    /// sum of squares does not rise from it: no data show that a loss is exactly zero.
    pub(crate) fn estimate(
        &self,
        slot: usize,
        others: &[usize],
        most: Option<f64>,
        curved: bool,
    ) -> Option<Estimate> {
        let Self { problem, unbounded, noise, other_minima, .. } = *self;
        let constrained = constrained(problem, unbounded, others)?;
        let near = self.is_near_limit(others);
        let most = most.map_or(f64::INFINITY, |m| m.max(constrained.parameters[slot]));
        let range = [0.0, most];
        let profile = Profile {
            problem,
            fit: &constrained,
            unbounded,
            noise,
            range,
            non_negative: others,
            other_minima,
        };
        let mut found = profile.non_negative(slot, curved || near);
        found.interval[1] = found.interval[1].min(most);
        if !(found.interval[1] > 0.0) {
            return None;
        }
        if near {
            // Near the kink the standard error follows from the interval, not from the optimum on the limit.
            found.std_error = found.std_error.max(error_of_interval(found.value, found.interval));
        }
        Some(found)
    }

    /// Whether one of these coefficients is at or near its limit.
    pub(crate) fn is_near_limit(&self, slots: &[usize]) -> bool {
        let Self { unbounded, noise, near_limit, .. } = *self;
        let near = |i: usize| !(unbounded.parameters[i] > near_limit * noise.std_error(unbounded, i));
        slots.iter().any(|&i| unbounded.free.contains(&i) && near(i))
    }
}

/// The fit with these coefficients kept non-negative.
pub(crate) fn constrained<'a>(
    problem: &dyn LeastSquares,
    unbounded: &'a Fit,
    non_negative: &[usize],
) -> Option<Cow<'a, Fit>> {
    let negative = |i: usize| unbounded.parameters[i] < 0.0;
    let below: Vec<(usize, f64)> =
        non_negative.iter().copied().filter(|&i| negative(i)).map(|i| (i, 0.0)).collect();
    if below.is_empty() {
        return Some(Cow::Borrowed(unbounded));
    }
    // Setting such a coefficient to its limit shifts the others.
    let start =
        conditional_minimum(unbounded, &below).map_or_else(|| unbounded.parameters.clone(), |(_, p)| p);
    // If another coefficient is held at its limit, a negative coefficient may become positive.
    minimise_bounded(problem, &start, &unbounded.free, non_negative, STEP_TOLERANCE).map(Cow::Owned)
}

/// Estimate of a coefficient that was not fitted.
pub(crate) fn unknown() -> Estimate {
    Estimate { value: 0.0, unbounded: 0.0, std_error: f64::INFINITY, interval: [0.0, f64::INFINITY] }
}

/// Estimate of a coefficient whose standard error the data do not determine: anything from zero to `most`.
pub(crate) fn undetermined(value: f64, most: Option<f64>) -> Estimate {
    let interval = [0.0, most.map_or(f64::INFINITY, |m| m.max(value))];
    Estimate { value, unbounded: value, std_error: error_of_interval(value, interval), interval }
}

/// Standard error that corresponds to a 95 % interval: half of its width over 1.96, or the whole width over 1.96 if the
/// value is at the lower end, which is a limit.
pub(crate) fn error_of_interval(value: f64, [lower, upper]: [f64; 2]) -> f64 {
    let half = if value <= lower { upper - lower } else { 0.5 * (upper - lower) };
    half / Z_95
}

/// Reported form of a value that cannot be negative. If the chosen model has no such term (`present` is false), the
/// value is zero and the interval runs from zero to the upper end found with the term. At zero the standard error is at
/// least that of the interval, because the curvature there is that of the optimum on the limit.
pub(crate) fn non_negative(found: Estimate, present: bool, unit: String) -> Quantity {
    let value = if present { found.value.max(0.0) } else { 0.0 };
    let [low, high] = found.interval.map(|v| v.max(0.0));
    let interval_95 = [if present { low } else { 0.0 }, high];
    let mut std_error = found.std_error;
    if value == 0.0 && interval_95[1].is_finite() {
        std_error = std_error.max(error_of_interval(value, interval_95));
    }
    Quantity { value, std_error, interval_95, unbounded_value: found.unbounded, unit }
}

/// `Q = omega_0/(2 delta)`, the viscous part only, with `omega_0` as a function of the decay rate; infinite if no
/// viscous loss is found.
pub(crate) fn q_factor(delta: &Quantity, omega_0: impl Fn(f64) -> f64) -> Quantity {
    // An infinite rate is replaced by the largest number: `omega_0` and the rate grow in the same proportion.
    let q = |d: f64| if d > 0.0 { omega_0(d.min(f64::MAX)) / d.min(f64::MAX) / 2.0 } else { f64::INFINITY };
    let value = q(delta.value);
    let [least, most] = delta.interval_95;
    Quantity {
        value,
        std_error: if value.is_finite() { value * delta.std_error / delta.value } else { f64::INFINITY },
        // Rounding may interchange ends that are close to the value.
        interval_95: [q(most).min(value), q(least).max(value)],
        unbounded_value: omega_0(delta.unbounded_value) / (2.0 * delta.unbounded_value),
        unit: String::new(),
    }
}

/// A parameter of a fit in another unit, with a symmetric interval: `factor (p + offset)`.
pub(crate) fn symmetric(
    noise: NoiseModel,
    fit: &Fit,
    slot: usize,
    [factor, offset]: [f64; 2],
    unit: impl Into<String>,
) -> Quantity {
    let error = noise.std_error(fit, slot);
    let mut q = Quantity::normal((fit.parameters[slot] + offset) * factor, error * factor.abs(), unit);
    let half = Z_95 * error * noise.student_factor(fit) * factor.abs();
    q.interval_95 = [q.value - half, q.value + half];
    q
}

/// Warning about the choice of the model: the requested model is not determined by the data or has a BIC higher by more
/// than `bic`, or a rival is as good as the preferred model to within `bic`.
pub(crate) fn model_choice(
    comparison: &ModelComparison,
    asked: Option<LossModel>,
    bic: f64,
) -> Option<Warning> {
    let preferred = comparison.preferred()?;
    if let Some(asked) = asked {
        let chosen = comparison.largest_within(asked)?;
        if chosen.model != asked {
            return Some(Warning::ModelUndetermined { asked, reported: chosen.model });
        }
        let worse = chosen.bic - preferred.bic;
        let preferred = preferred.model;
        return (asked != preferred && worse > bic).then_some(Warning::ModelNotPreferred {
            asked,
            preferred,
            delta_bic: worse,
        });
    }
    let rival = comparison.rival(bic)?;
    let delta_bic = rival.bic - preferred.bic;
    Some(Warning::AmbiguousModel { chosen: preferred.model, rival: rival.model, delta_bic })
}

/// All models for the table of candidates, best first; `rms` and `values` describe one fit.
pub(crate) fn candidates(
    comparison: &ModelComparison,
    rms: impl Fn(&ModelFit) -> f64,
    values: impl Fn(&ModelFit) -> Values,
) -> Vec<Candidate> {
    let best = comparison.lowest_bic();
    let candidate = |f: &ModelFit| Candidate {
        model: f.model,
        bic: f.bic,
        delta_bic: f.bic - best,
        rms: rms(f),
        free_parameters: f.unbounded.free.len(),
        converged: f.unbounded.converged,
        at_limit: f.at_limit.map(Parameter::Loss),
        values: values(f),
    };
    let mut list: Vec<Candidate> = comparison.fits.iter().map(candidate).collect();
    by_bic(&mut list);
    list
}

fn by_bic(list: &mut [Candidate]) {
    sort_by_value(list, |c| c.bic);
}

/// Correlations of those named parameters that are free, in the given order.
pub(crate) fn correlations(fit: &Fit, named: &[(usize, Parameter)]) -> Vec<Correlation> {
    let free: Vec<_> = named.iter().filter(|(slot, _)| fit.free.contains(slot)).collect();
    let pairs = free.iter().enumerate().flat_map(|(i, a)| free[i + 1..].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| Correlation { parameters: [a.1, b.1], value: fit.correlation(a.0, b.0) }).collect()
}

/// The evidence for sliding friction, with the shares of the loss in the chosen model.
pub(crate) fn sliding_evidence(
    comparison: &ModelComparison,
    chosen: &ModelFit,
    [share_at_highest, share_at_lowest]: [f64; 2],
) -> SlidingEvidence {
    let (p_value, delta_bic) = comparison.sliding_evidence();
    let viscous_only_p_value = comparison.viscous_only(chosen.model);
    let detected = comparison.criteria.detected;
    SlidingEvidence {
        detected: p_value < detected && delta_bic > 0.0,
        p_value,
        delta_bic,
        share_at_highest,
        share_at_lowest,
        dominates_from_s: None,
        viscous_only_p_value,
        viscous_only_excluded: viscous_only_p_value < detected,
    }
}

/// The fit that determines a loss coefficient, and whether the chosen model has that loss.
pub(crate) fn fit_of<'a>(
    comparison: &'a ModelComparison,
    chosen: &'a ModelFit,
    term: LossTerm,
) -> (Option<&'a ModelFit>, bool) {
    let present = chosen.model.has(term);
    (if present { Some(chosen) } else { comparison.fit_with(chosen, term) }, present)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_q_beyond_all_numbers_has_no_limit_and_an_order() {
        let q = q_factor(&Quantity::normal(1e-10, 1e-11, "1/s"), |_| 1e301);
        assert_eq!(q.value, f64::INFINITY);
        assert_eq!(q.std_error, f64::INFINITY);
        assert!(q.interval_95[0] <= q.interval_95[1], "{q:?}");
    }
}

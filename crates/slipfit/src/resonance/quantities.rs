//! The parameters of the answer, with intervals that respect the limits.

use super::alternatives::Alternative;
use super::averaged;
use super::bias;
use super::fitted_models::FittedModels;
use super::paper::Lorentzian;
use super::problem::Problem;
use super::response::{BG_RE, DUFFING, FLOOR, OFFSET, OMEGA, X_0, X_F, slot};
use super::{Curve, DriveSource, Options};
use crate::Quantity;
use crate::answer::averaged::{absent_losses, widening};
use crate::answer::calibration::physical;
use crate::answer::describe::{LossFit, fit_of, non_negative, q_factor, symmetric, undetermined, unknown};
use crate::answer::{Parameter, Parameters};
use crate::inference::least_squares::{Fit, minimise};
use crate::inference::model_selection::ModelFit;
use crate::inference::profile::{Estimate, Profile};
use crate::model::loss::{LossModel, LossTerm};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

fn loss_fit<'a>(d: &FittedModels, problem: &'a Problem, unbounded: &'a Fit) -> LossFit<'a> {
    LossFit { problem, unbounded, noise: d.comparison.noise, near_limit: d.near_limit, other_minima: &[] }
}

/// The coefficient of a loss term, from the chosen model or from that model with the term added.
fn loss_term(d: &FittedModels, chosen: &ModelFit, term: LossTerm, unit: &str) -> Quantity {
    let (fit, present) = fit_of(&d.comparison, chosen, term);
    let found = fit.map_or_else(unknown, |fit| {
        let problem = d.problem_of(fit);
        // No loss exceeds its value in the model with this loss alone.
        let most = d.comparison.most(term, slot(term)).filter(|_| !on_background(chosen));
        let found = loss_fit(d, &problem, &fit.unbounded).estimate(
            slot(term),
            &fit.other_slots(term, slot),
            most,
            bends(d),
        );
        let found = found.unwrap_or_else(|| undetermined(fit.bounded.parameters[slot(term)], most));
        let by = if present { unbiased(d, chosen, &problem, &fit.unbounded) } else { None };
        by.map_or(found, |by| moved(found, by[slot(term)], d.criteria.most_correction))
    });
    non_negative(found, present, Parameter::Loss(term).unit(unit))
}

/// Bias correction for an uncertain fit; not at a limit, which causes a bias of its own.
fn unbiased(d: &FittedModels, chosen: &ModelFit, problem: &Problem, fit: &Fit) -> Option<Vec<f64>> {
    let noise = d.comparison.noise;
    let most = d.criteria.vague_friction * chosen.unbounded.parameters[X_0];
    let vague = noise.std_error(&chosen.unbounded, X_F) > most;
    let wanted = vague && chosen.at_limit.is_none() && chosen.model.has_sliding();
    let variance = noise.variance(fit);
    if wanted { bias::correction(problem, fit, variance) } else { None }
}

/// Shifts the estimate by at most `most` standard errors and not out of its interval.
fn moved(e: Estimate, by: f64, most: f64) -> Estimate {
    let [low, high] = e.interval;
    let most = most * e.std_error;
    let by = by.max(-most).min(most);
    Estimate { value: (e.value + by).max(low).min(high), unbounded: e.unbounded + by, ..e }
}

/// Whether the sum of squares is far from a parabola: with the drive free, height and width give one quantity less than
/// there are parameters.
fn bends(d: &FittedModels) -> bool {
    d.source != DriveSource::Known || d.problem.prior.is_some()
}

/// Standard errors of the quantities compared in a series, for fixed instrument terms, and not smaller than those
/// without limits, because a series uses the values without limits.
pub(super) fn given_terms(used: &Curve, d: &FittedModels, chosen: &ModelFit) -> Vec<(Parameter, f64)> {
    let noise = d.comparison.noise;
    let frequency = symmetric(noise, &chosen.bounded, OMEGA, [1.0 / TAU, d.problem.centre], "Hz");
    let lifted = |q: Quantity, k: usize| {
        let own = noise.std_error(&chosen.unbounded, k);
        if chosen.unbounded.free.contains(&k) { q.std_error.max(own) } else { q.std_error }
    };
    let of_loss = |term: LossTerm| lifted(loss_term(d, chosen, term, used.unit()), slot(term));
    let losses = [LossTerm::Viscous, LossTerm::Sliding, LossTerm::Drag];
    let losses = losses.into_iter().filter(|term| *term != LossTerm::Drag || chosen.model.has(*term));
    losses
        .map(|term| (Parameter::Loss(term), of_loss(term)))
        .chain([
            (Parameter::NaturalFrequency, frequency.std_error),
            (Parameter::DriveAmplitude, lifted(drive_amplitude(d, chosen, used.unit()), X_0)),
        ])
        .collect()
}

/// The parameters, and the losses absent from the model that widen their intervals noticeably.
pub(super) fn parameters(
    used: &Curve,
    options: &Options,
    d: &FittedModels,
    chosen: &ModelFit,
) -> (Parameters, Option<LossModel>) {
    let unit = used.unit();
    let noise = d.comparison.noise;
    let mut list = Parameters::default();
    let bounded = &chosen.bounded;
    let omega_0 = d.problem.centre + bounded.parameters[OMEGA];
    let to_hz = [1.0 / TAU, d.problem.centre];
    let frequency = symmetric(noise, bounded, OMEGA, to_hz, "Hz");
    let centre = d.problem.centre;
    let mut noticed: Vec<LossTerm> = Vec::new();
    // The intervals account for losses that the data do not exclude, unless a model was requested.
    let mut widened =
        |q: Quantity, of_term: Option<LossTerm>, gradient: &[(usize, f64)], of: &dyn Fn(&[f64]) -> f64| {
            let is_frequency = of_term.is_none() && gradient.iter().all(|(k, _)| *k == OMEGA);
            let weight: fn(&Alternative) -> f64 =
                if is_frequency { |a| a.frequency_weight } else { |a| a.weight };
            let counted = options.model.is_none() && of_term.is_none_or(|term| chosen.model.has(term));
            if !counted {
                return averaged::widened(d, q, &[], weight, of);
            }
            let (terms, absent) = absent_losses(&d.comparison, chosen, of_term, gradient, &q, slot);
            if widening(&q, &absent) > d.mentioned_widening {
                noticed.extend(terms);
            }
            averaged::widened(d, q, &absent, weight, of)
        };
    let of_frequency = |p: &[f64]| (centre + p[OMEGA]) / TAU;
    list.set(Parameter::NaturalFrequency, widened(frequency, None, &[(OMEGA, 1.0 / TAU)], &of_frequency));
    let coefficient = |term: LossTerm| {
        let k = slot(term);
        widened(loss_term(d, chosen, term, unit), Some(term), &[(k, 1.0)], &|p| p[k])
    };
    let [delta, x_f] = [LossTerm::Viscous, LossTerm::Sliding].map(coefficient);
    list.set(Parameter::DECAY_RATE, delta.clone());
    list.set(Parameter::QFactor, q_factor(&delta, |_| omega_0));
    list.set(Parameter::FRICTION_DISPLACEMENT, x_f.clone());
    let x_0 = drive_amplitude(d, chosen, unit);
    let x_0 = if bounded.free.contains(&X_0) { widened(x_0, None, &[(X_0, 1.0)], &|p| p[X_0]) } else { x_0 };
    let beta = friction_ratio(d, chosen, &x_f, &x_0);
    let by_drive = 1.0 / (FRAC_PI_4 * x_0.value);
    let by_both = [(X_F, by_drive), (X_0, -beta.value / x_0.value)];
    let gradient = if x_0.std_error > 0.0 { &by_both[..] } else { &by_both[..1] };
    list.set(Parameter::DriveAmplitude, x_0);
    let of_ratio = |p: &[f64]| p[X_F] / (FRAC_PI_4 * p[X_0]);
    let beta = widened(beta, Some(LossTerm::Sliding), gradient, &of_ratio);
    list.set(Parameter::FrictionRatio, below_one(beta));
    for term in chosen.model.terms().filter(|t| !is_exact(*t)) {
        list.set(Parameter::Loss(term), loss_term(d, chosen, term, unit));
    }
    if bounded.free.contains(&DUFFING) {
        let unit = Parameter::DuffingCoefficient.unit(unit);
        list.set(Parameter::DuffingCoefficient, symmetric(noise, bounded, DUFFING, [1.0 / TAU, 0.0], unit));
    }
    calibrated(&mut list, options, omega_0, unit, &delta, &x_f);
    (list, LossModel::from_terms(&noticed))
}

/// Limits the upper end to one, or to the value itself: at larger ratios friction leaves no peak at the resonance.
fn below_one(mut ratio: Quantity) -> Quantity {
    let most = ratio.value.max(1.0);
    ratio.interval_95[1] = ratio.interval_95[1].min(most);
    ratio
}

/// Adds friction force and viscous coefficient if a stiffness or mass is known.
fn calibrated(
    list: &mut Parameters,
    options: &Options,
    omega_0: f64,
    unit: &str,
    delta: &Quantity,
    x_f: &Quantity,
) {
    if let Some(calibration) = options.calibration {
        for (parameter, quantity) in physical(calibration, omega_0, unit, delta, x_f) {
            list.set(parameter, quantity);
        }
    }
}

/// Whether a background, an offset or a noise floor is included: then no smaller model bounds the coefficients of the
/// chosen one.
fn on_background(chosen: &ModelFit) -> bool {
    [BG_RE, OFFSET, FLOOR].iter().any(|k| chosen.unbounded.free.contains(k))
}

fn drive_amplitude(d: &FittedModels, chosen: &ModelFit, unit: &str) -> Quantity {
    let (noise, bounded) = (d.comparison.noise, &chosen.bounded);
    if !bounded.free.contains(&X_0) {
        return Quantity::normal(bounded.parameters[X_0], 0.0, unit);
    }
    let problem = d.problem.with(&bounded.free);
    // From the shape alone: between no friction and friction alone.
    let end = |model: LossModel, side: f64| {
        d.comparison
            .get(model)
            .map(|f| f.bounded.parameters[X_0] + side * 4.0 * noise.std_error(&f.bounded, X_0))
            .filter(|v| v.is_finite())
    };
    let low = end(LossModel::VISCOUS, -1.0).filter(|v| *v > 0.0).unwrap_or(0.0);
    let high = end(LossModel::SLIDING, 1.0).unwrap_or(f64::INFINITY);
    let value = bounded.parameters[X_0];
    let range = if d.source == DriveSource::Shape && !on_background(chosen) {
        [low.min(value), high.max(value)]
    } else {
        [0.0, f64::INFINITY]
    };
    let losses: Vec<usize> = chosen.model.terms().map(slot).collect();
    let mut found = Profile {
        problem: &problem,
        fit: bounded,
        unbounded: &chosen.unbounded,
        noise,
        range,
        non_negative: &losses,
        other_minima: &[],
    }
    .two_sided(X_0, bends(d));
    let mut unbounded_value = chosen.unbounded.parameters[X_0];
    if let Some(by) = unbiased(d, chosen, &problem, bounded) {
        found = moved(found, by[X_0], d.criteria.most_correction);
        unbounded_value = found.value;
    }
    Quantity {
        value: found.value,
        std_error: found.std_error,
        interval_95: found.interval,
        unbounded_value,
        unit: unit.into(),
    }
}

/// `beta = 4 x_F/(pi x_0)`; with the drive free, from a fit with the ratio as a parameter.
fn friction_ratio(d: &FittedModels, chosen: &ModelFit, x_f: &Quantity, x_0: &Quantity) -> Quantity {
    let scaled = x_f.scaled(1.0 / (FRAC_PI_4 * x_0.value), "");
    if x_0.std_error == 0.0 {
        return scaled;
    }
    let (with, present) = fit_of(&d.comparison, chosen, LossTerm::Sliding);
    let found = with.and_then(|with| {
        let mut problem = d.problem_of(with);
        problem.ratio = true;
        let mut start = with.unbounded.parameters.clone();
        start[X_F] /= FRAC_PI_4 * start[X_0];
        let fit = minimise(&problem, &start, &with.unbounded.free)?;
        let most = (d.source == DriveSource::Shape).then_some(4.0 / PI);
        let others = with.other_slots(LossTerm::Sliding, slot);
        let found = loss_fit(d, &problem, &fit).estimate(X_F, &others, most, true)?;
        let by = if present { unbiased(d, chosen, &problem, &fit) } else { None };
        Some(non_negative(
            by.map_or(found, |by| moved(found, by[X_F], d.criteria.most_correction)),
            present,
            String::new(),
        ))
    });
    found.unwrap_or(scaled)
}

/// The parameters by the inversion of a Lorentzian according to the paper.
pub(super) fn papers_parameters(
    used: &Curve,
    options: &Options,
    d: &FittedModels,
    chosen: &ModelFit,
    lorentzian: &Lorentzian,
) -> Parameters {
    let unit = used.unit();
    let x_0 = drive_amplitude(d, chosen, unit);
    let found = lorentzian.invert(x_0.value);
    let [q_std, x_f_std, beta_std] = lorentzian.std_errors(x_0.value, x_0.std_error);
    let omega_0 = lorentzian.omega_0();
    let delta = omega_0 / (2.0 * found.q);
    let limited = |value: f64, std: f64, unit: &str| {
        let mut q = Quantity::normal(value, std, unit);
        q.value = value.max(0.0);
        q.interval_95 = q.interval_95.map(|v| v.max(0.0));
        q
    };
    let delta = limited(delta, delta * q_std / found.q, "1/s");
    let x_f = limited(found.x_f, x_f_std, unit);
    // If the inversion is outside its range, the curve has no viscous loss.
    let q = if found.q > 0.0 { Quantity::normal(found.q, q_std, "") } else { q_factor(&delta, |_| omega_0) };
    let hz = Quantity::normal(omega_0 / TAU, lorentzian.omega_0_std() / TAU, "Hz");
    let mut list: Parameters = [
        (Parameter::NaturalFrequency, hz),
        (Parameter::DECAY_RATE, delta.clone()),
        (Parameter::QFactor, q),
        (Parameter::FRICTION_DISPLACEMENT, x_f.clone()),
        (Parameter::DriveAmplitude, x_0),
        (Parameter::FrictionRatio, limited(found.beta, beta_std, "")),
    ]
    .into_iter()
    .collect();
    calibrated(&mut list, options, omega_0, unit, &delta, &x_f);
    list
}

/// Whether a loss is one of the two included in the exact response.
pub(super) fn is_exact(term: LossTerm) -> bool {
    matches!(term, LossTerm::Viscous | LossTerm::Sliding)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_friction_ratio_above_one_leaves_a_peak() {
        let ratio = |value: f64, high: f64| {
            let q = Quantity { interval_95: [0.0, high], ..Quantity::normal(value, 0.5, "") };
            below_one(q).interval_95
        };
        assert_eq!(ratio(0.3, 1.4), [0.0, 1.0]);
        assert_eq!(ratio(0.3, f64::INFINITY), [0.0, 1.0]);
        assert_eq!(ratio(0.3, 0.7), [0.0, 0.7]);
        // If the motion stops, the value itself may exceed the limit.
        assert_eq!(ratio(1.1, 1.2), [0.0, 1.1]);
    }
}

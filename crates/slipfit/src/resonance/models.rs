//! Fit of every loss model together with the terms of the chosen hypothesis.

use super::criteria::Criteria;
use super::fitted_models::{ColumnsSetAside, FittedModels, oscillator_amplitudes};
use super::hypothesis::Kind;
use super::hypothesis_fit::HypothesisFit;
use super::peak;
use super::prepared::PreparedCurve;
use super::problem::Problem;
use super::residuals::{Autocorrelation, autocorrelation};
use super::response::{BG_IM, DELTA, X_0, X_F, slot};
use super::search::{best_of, rss};
use super::{DriveSource, Method, Options, alternatives};
use crate::Error;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::model_selection::ModelComparison;
use crate::inference::noise::NoiseModel;
use crate::model::loss::{LossModel, LossTerm};

/// Start value of the friction displacement over the drive if it is the only loss.
const SLIDING_ALONE: f64 = 0.7;

/// Compares the loss models on the points as treated by the hypothesis.
pub(super) fn compare(curve: &PreparedCurve, mut chosen: HypothesisFit) -> Result<FittedModels, Error> {
    let (options, criteria) = (chosen.options, chosen.criteria);
    if let Some([value, _]) = chosen.problem.prior {
        let error = options.drive_amplitude.map_or(1.0, |d| d.std_error);
        chosen.problem.prior = Some([value, chosen.variance() / (error * error)]);
    }
    let (mut comparison, mut residuals) = loss_models(&chosen);
    if chosen.background_instead_of_drag(&comparison) {
        (comparison, residuals) = loss_models(&chosen);
    }
    let Some(first) = comparison.fits.first() else {
        return Err(Error::NoFit { reason: "no fit to the curve converged" });
    };
    let noise = comparison.noise;
    let HypothesisFit { problem, fit, mut minima, .. } = chosen;
    let alternatives = if options.method == Method::Exact {
        alternatives::weighted(chosen.others, &comparison, &criteria.answer)
    } else {
        Vec::new()
    };
    let most = criteria.models.equal_minima * noise.variance(&first.bounded);
    let least = minima.iter().map(|m| m.rss).fold(f64::INFINITY, f64::min);
    minima.retain(|m| m.rss - least < most);
    let source = match (options.drive_amplitude, &problem.reference) {
        (Some(_), _) => DriveSource::Known,
        (None, Some(_)) => DriveSource::Reference,
        (None, None) => DriveSource::Shape,
    };
    let seen = oscillator_amplitudes(&problem, &fit.parameters).and_then(|b| peak::find(&b));
    let hypothesis = chosen.hypothesis;
    Ok(FittedModels {
        source,
        peak: seen.unwrap_or(hypothesis.peak),
        comparison,
        conjugated: hypothesis.conjugated,
        phases_ignored: hypothesis.kind == Kind::Amplitudes,
        all: curve.all.as_ref().map(|all| hypothesis.view(all)),
        left_out: chosen.outliers,
        spikes: 0,
        neighbour_noise: residuals.neighbour_noise,
        autocorrelation: residuals.rho,
        minima,
        alternatives,
        free_gain: None,
        proportional_noise: None,
        set_aside: ColumnsSetAside::default(),
        criteria: criteria.answer.clone(),
        near_limit: criteria.report.near_limit,
        mentioned_widening: criteria.report.mentioned_widening,
        problem,
    })
}

/// Fits the loss models together with the chosen terms, and returns the residuals by which they are judged.
fn loss_models(chosen: &HypothesisFit) -> (ModelComparison, Autocorrelation) {
    let HypothesisFit { options, criteria, problem, fit, minima, .. } = chosen;
    let mut residuals = autocorrelation(problem, fit, &criteria.residuals);
    let inflated = |variance_inflation: f64| NoiseModel {
        variance_inflation,
        ..NoiseModel::white(problem.observations())
    };
    let starts: Vec<Vec<f64>> = std::iter::once(fit)
        .chain(minima)
        .map(|f| f.parameters.clone())
        .chain(chosen.starts.iter().cloned())
        .collect();
    let tries = criteria.search.tries + 2 * minima.len();
    let noise = inflated(residuals.variance_inflation);
    let fits = fit_models(problem, &starts, &fit.free, noise, tries, options, criteria);
    // Residuals of a single loss term are not noise; the autocorrelation is therefore taken from the fit with all
    // terms.
    let all_terms =
        options.model.unwrap_or(LossModel::VISCOUS_DRAG).with(LossTerm::Viscous).with(LossTerm::Sliding);
    let richest = fits.iter().find(|(m, f)| *m == all_terms && f.converged);
    let more_is_possible = all_terms != LossModel::VISCOUS_SLIDING;
    if let Some((_, f)) = richest.filter(|_| residuals.variance_inflation > 1.0 && more_is_possible) {
        residuals = autocorrelation(&problem.with(&f.free), f, &criteria.residuals);
    }
    let viscous_is_sure = surely_viscous(&fits, LossModel::VISCOUS_SLIDING, noise, criteria);
    let noise = inflated(residuals.variance_inflation);
    let comparison = ModelComparison::new(&fits, slot, noise, &criteria.inference);
    (ModelComparison { viscous_is_sure, ..comparison }, residuals)
}

/// Whether the viscous loss of a model is so far from zero that no data require a model without it.
fn surely_viscous(
    fits: &[(LossModel, Fit)],
    model: LossModel,
    noise: NoiseModel,
    criteria: &Criteria,
) -> bool {
    let fit = fits.iter().find(|(m, _)| *m == model).map(|(_, f)| f);
    fit.is_some_and(|f| f.parameters[DELTA] > criteria.models.surely_viscous * noise.std_error(f, DELTA))
}

/// Fits every loss model, started from related models; `free` are the parameters of the fit so far.
fn fit_models(
    problem: &Problem,
    starts: &[Vec<f64>],
    free: &[usize],
    noise: NoiseModel,
    tries: usize,
    options: &Options,
    criteria: &Criteria,
) -> Vec<(LossModel, Fit)> {
    let losses: Vec<usize> = LossTerm::ALL.iter().map(|t| slot(*t)).collect();
    let others: Vec<usize> = free.iter().copied().filter(|k| !losses.contains(k)).collect();
    // The richer model of two comes first: its solution is a start for the smaller ones. A model with drag or a further
    // loss alone has no start: the exact response requires viscous or sliding loss.
    let has_start = |m: &LossModel| m.has(LossTerm::Viscous) || m.has(LossTerm::Sliding);
    let simpler_first =
        LossModel::compared(options.model).filter(|m| has_start(m) && *m != LossModel::VISCOUS_SLIDING);
    let order = std::iter::once(LossModel::VISCOUS_SLIDING).chain(simpler_first);
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let is_further = |model: LossModel| !model.is_within(LossModel::VISCOUS_SLIDING);
    let surely_viscous = |fits: &[(LossModel, Fit)], model| surely_viscous(fits, model, noise, criteria);
    let add = |fits: &mut Vec<(LossModel, Fit)>, model: LossModel| {
        let terms: Vec<usize> = model.terms().map(slot).collect();
        let mut free: Vec<usize> = others.iter().chain(&terms).copied().collect();
        free.sort_unstable();
        if (problem.observations() as usize) <= free.len() {
            return;
        }
        let mut from: Vec<Vec<f64>> =
            fits.iter().map(|(_, f)| f.parameters.clone()).chain(starts.iter().cloned()).collect();
        for p in &mut from {
            for &k in &losses {
                if !terms.contains(&k) {
                    p[k] = 0.0;
                }
            }
            // With sliding loss alone the height at resonance is not limited by the loss; the friction must be
            // comparable with the drive.
            let alone = terms.iter().all(|&k| k == X_F || p[k] <= 0.0);
            if !model.has(LossTerm::Viscous) && model.has_sliding() && alone {
                p[X_F] = p[X_F].max(SLIDING_ALONE * p[X_0]);
            }
        }
        from.dedup();
        let own = problem.with(&free);
        if let Some(mut fit) = best_of(&own, &from, &free, tries, &criteria.search) {
            // No model can fit worse than one within it, or than a richer one whose additional terms are zero: a start
            // followed with fewer points may have led to another minimum.
            for start in from.iter().take(fits.len()) {
                if rss(&own, start, fit.rss).is_some_and(|left| left < fit.rss)
                    && let Some(better) = minimise(&own, start, &free).filter(|f| f.rss < fit.rss)
                {
                    fit = better;
                }
            }
            if model == LossModel::VISCOUS && !problem.main.complex && fit.parameters[DELTA] < 0.0 {
                // Amplitudes are equally described by the mirror image, whose loss is positive.
                let mut mirrored = fit.parameters.clone();
                (mirrored[DELTA], mirrored[BG_IM]) = (-mirrored[DELTA], -mirrored[BG_IM]);
                fit = minimise(&own, &mirrored, &free).filter(|f| f.parameters[DELTA] > 0.0).unwrap_or(fit);
            }
            fits.push((model, fit));
        }
    };
    let mut left_out = Vec::new();
    for model in order {
        let needless = !model.has(LossTerm::Viscous) && surely_viscous(&fits, LossModel::VISCOUS_SLIDING);
        if needless && options.model != Some(model) {
            left_out.push(model);
        } else {
            add(&mut fits, model);
        }
    }
    // With a further loss the viscous loss may be zero after all; the model within the limits is then one without it.
    for model in left_out {
        let with = model.with(LossTerm::Viscous);
        if is_further(model) && !surely_viscous(&fits, with) {
            add(&mut fits, model);
            // Such a model may have no minimum; a fit that did not converge is removed.
            fits.pop_if(|(added, fit)| *added == model && !fit.converged);
        }
    }
    fits
}

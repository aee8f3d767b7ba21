//! Fits of every loss model to the data of one decay.

use super::envelope::{A0, DELTA, DRAG, X_F};
use crate::inference::criteria::InferenceCriteria;
use crate::inference::least_squares::{
    Fit, LeastSquares, Normal, minimise, minimise_near, minimise_roughly, minimise_until,
};
use crate::inference::model_selection::ModelComparison;
use crate::inference::noise::NoiseModel;
use crate::inference::quadratic::conditional_minimum;
use crate::model::loss::{LossModel, LossTerm};
use crate::motion::decay::parameters::{first_shape, shape_slot};
use crate::numeric::order::sort_by_value;
use std::f64::consts::PI;

/// Index of the coefficient of a loss term in the parameters of every fit of a decay.
pub(crate) fn slot(term: LossTerm) -> usize {
    match term {
        LossTerm::Sliding => X_F,
        LossTerm::Viscous => DELTA,
        LossTerm::Drag => DRAG,
        // Further terms follow in the order of their list.
        #[allow(unreachable_patterns, reason = "there may be none")]
        further => A0 + 1 + further as usize,
    }
}

/// Indices of the initial amplitude and of the coefficients of all loss terms compared, given the requested
/// model.
pub(crate) fn loss_parameters(asked: Option<LossModel>) -> Vec<usize> {
    let mut list: Vec<usize> = std::iter::once(A0).chain(LossTerm::compared(asked).flat_map(slots)).collect();
    list.sort_unstable();
    list
}

/// Index of the coefficient of a loss term, and of its shape parameter if it has one.
pub(crate) fn slots(term: LossTerm) -> impl Iterator<Item = usize> {
    std::iter::once(slot(term)).chain(shape_slot(term))
}

/// Share of the loss that a term with a shape parameter has at the start of a search.
const SHAPED_SHARE: f64 = 0.5;

/// Includes those terms of the requested model that have a shape parameter in the start values: if such a
/// term causes no loss, the data carry no information about its shape.
pub(crate) fn with_shape_starts(start: &[f64], asked: Option<LossModel>) -> Vec<f64> {
    let mut offered = start.to_vec();
    for term in LossTerm::further_of(asked) {
        let Some((shape, first)) = shape_slot(term).zip(first_shape(term)) else { continue };
        if offered[shape] == 0.0 {
            offered[shape] = first;
            offered[slot(term)] = SHAPED_SHARE * start[DELTA].max(f64::MIN_POSITIVE);
            offered[DELTA] *= 1.0 - SHAPED_SHARE;
        }
    }
    offered
}

/// Free parameters of a model: amplitude, its loss terms, the nuisance parameters.
fn free_parameters(model: LossModel, nuisance: &[usize]) -> Vec<usize> {
    let mut free: Vec<usize> =
        [A0].into_iter().chain(model.terms().flat_map(slots)).chain(nuisance.iter().copied()).collect();
    free.sort_unstable();
    free
}

/// Whether a fit with these free parameters is a fit of the model, i.e. without losses that the model lacks.
fn is_fit_of(fit: &Fit, model: LossModel, free: &[usize]) -> bool {
    let absent = LossTerm::ALL.iter().filter(|term| !model.has(**term));
    fit.free == free && absent.copied().all(|term| fit.parameters[slot(term)] == 0.0)
}

/// Coefficients for which a single term accounts for the whole loss at a given amplitude.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WholeLoss {
    decay_rate: f64,
    friction_displacement: f64,
    amplitude: f64,
}

impl WholeLoss {
    /// The coefficients for a loss of `decay_rate` per second of the `amplitude` at `omega`.
    pub(crate) fn new(decay_rate: f64, amplitude: f64, omega: f64) -> Self {
        Self { decay_rate, friction_displacement: decay_rate * amplitude * PI / (2.0 * omega), amplitude }
    }

    /// The coefficient of a term that accounts for the whole loss.
    fn of(&self, term: LossTerm) -> f64 {
        match term {
            LossTerm::Viscous => self.decay_rate,
            LossTerm::Sliding => self.friction_displacement,
            shaped if shaped.is_shaped() => self.decay_rate,
            other => self.decay_rate / (other.shape(self.amplitude) / self.amplitude),
        }
    }
}

/// Settings of the comparison.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    /// The requested model, whose terms are included.
    pub(crate) asked: Option<LossModel>,
    pub(crate) models: Models,
    /// The fit that gave the start values.
    pub(crate) begun: Option<&'a Fit>,
    /// Whether there may be several minima.
    pub(crate) side_minima: bool,
    /// The exact problems for the final comparison if the problem itself is an approximation.
    pub(crate) last: Option<LastSteps<'a>>,
    pub(crate) criteria: &'a InferenceCriteria,
}

/// The problem without approximations.
#[derive(Clone, Copy)]
pub(crate) struct LastSteps<'a> {
    /// Accurate to far below a standard error.
    pub(crate) accurate: &'a dyn LeastSquares,
    /// Accurate to rounding.
    pub(crate) exact: &'a dyn LeastSquares,
}

/// Which models are compared.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Models {
    All,
    /// Without models predicted to exceed the residual sum of squares of a larger one by more than this many
    /// noise variances: none of them can become the preferred one.
    Rivals {
        within: f64,
    },
}

/// Shares of sliding friction in the loss at the first amplitude used as starts of the search.
const SLIDING_SHARES: [f64; 4] = [0.1, 0.35, 0.65, 0.9];

/// Fits every model to be compared, given the requested one, from several starts and keeps the lowest sum of
/// squares for each.
///
/// `start` contains the amplitude, the loss coefficients and the nuisance parameters; `whole` gives the
/// coefficient that each term would have if it accounted for the whole loss at the first amplitude. If
/// friction stops the motion inside the record, the sum of squares has a minimum for every number of half
/// cycles: with `side_minima` viscous and sliding loss are also started at [`SLIDING_SHARES`] of the loss.
/// Models with more terms start from that fit. Models with fewer terms start at the minimum of the quadratic
/// form of a larger model with the absent terms set to zero, or with the whole loss in one of their terms.
pub(crate) fn compare(
    problem: &dyn LeastSquares,
    start: &[f64],
    nuisance: &[usize],
    noise: NoiseModel,
    whole: WholeLoss,
    Search { asked, models, begun, side_minima, last, criteria }: Search,
) -> ModelComparison {
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    // Models whose fits serve as starts for the others.
    let largest = LossModel::compared(asked).last().unwrap_or(LossModel::VISCOUS_SLIDING);
    let first = [LossModel::VISCOUS_SLIDING, largest];
    let fit_one = |model: LossModel, fits: &[(LossModel, Fit)]| {
        let free = free_parameters(model, nuisance);
        if (noise.observations as usize) <= free.len() {
            return None;
        }
        if let Some(fit) = begun.filter(|fit| !side_minima && is_fit_of(fit, model, &free)) {
            return Some(fit.clone());
        }
        if let Some(far) = DistantModel::predicted(model, fits, criteria.no_rival, noise) {
            if matches!(models, Models::Rivals { within } if far.rise > within) {
                return None;
            }
            if let Some(fit) = far.fit(problem) {
                return Some(fit);
            }
        }
        let starts = starts(model, fits, start, &whole, side_minima);
        // The largest model with a shape is fitted first; the others start from it.
        let new_shape = |term: &&LossTerm| model.has(**term) && fits.iter().all(|(m, _)| !m.has(**term));
        let starts = match LossTerm::shaped().iter().find(new_shape) {
            Some(_) => fitted_at_fixed_shapes(problem, starts, &free),
            None => starts,
        };
        let tried = if side_minima { FITTED_STARTS } else { 1 };
        best_of(problem, &starts, &free, tried)
    };
    for model in first.into_iter().chain(LossModel::compared(asked)) {
        if fits.iter().all(|(m, _)| *m != model) {
            fits.extend(fit_one(model, &fits).map(|fit| (model, fit)));
        }
    }
    // If the largest model has negative losses, it is also fitted without them.
    let mut model = largest;
    while let Some(inside) = without_negative(&fits, model) {
        if fits.iter().all(|(m, _)| *m != inside) {
            let Some(fit) = fit_one(inside, &fits) else { break };
            fits.push((inside, fit));
        }
        model = inside;
    }
    // No model may fit worse than a model nested in it.
    for i in 0..fits.len() {
        let (model, rss) = (fits[i].0, fits[i].1.rss);
        let within =
            fits.iter().filter(|(m, f)| m.is_within(model) && f.rss < rss * (1.0 - NESTED_TOLERANCE));
        let Some((_, better)) = within.min_by(|a, b| a.1.rss.total_cmp(&b.1.rss)) else { continue };
        if let Some(fit) = minimise(problem, &better.parameters, &free_parameters(model, nuisance)) {
            fits[i].1 = fit;
        }
    }
    fits.sort_by_key(|(model, _)| model.place());
    let known = last.map(|last| take_last_steps(&mut fits, last, (begun, side_minima), noise, criteria));
    let comparison = ModelComparison::new(&fits, slot, noise, criteria);
    let Some((known, last)) = known.zip(last) else { return comparison };
    let reported = [comparison.preferred(), comparison.reported()].into_iter().flatten();
    let left: Vec<LossModel> = reported.map(|fit| fit.model).filter(|model| !known.contains(model)).collect();
    for (_, fit) in fits.iter_mut().filter(|(model, _)| left.contains(model)) {
        let closer = minimise_near(last.exact, &fit.parameters, &fit.free, FIT_TOLERANCE, 0.0);
        *fit = closer.unwrap_or_else(|| fit.clone());
    }
    if left.is_empty() { comparison } else { ModelComparison::new(&fits, slot, noise, criteria) }
}

/// The table contains fits of the approximate problem; the last step is taken with the exact one. Returns the
/// models that need no further step: viscous and sliding loss, unless they are far above the best one.
fn take_last_steps(
    fits: &mut [(LossModel, Fit)],
    LastSteps { accurate, exact }: LastSteps,
    (begun, side_minima): (Option<&Fit>, bool),
    noise: NoiseModel,
    criteria: &InferenceCriteria,
) -> Vec<LossModel> {
    let least = fits.iter().map(|(_, fit)| fit.rss).fold(f64::INFINITY, f64::min);
    let is_begun = |fit: &Fit| begun.is_some_and(|b| b.parameters == fit.parameters);
    let mut known: Vec<LossModel> = fits.iter().filter(|(_, f)| is_begun(f)).map(|(m, _)| *m).collect();
    for (model, fit) in fits.iter_mut().filter(|(_, fit)| !is_begun(fit)) {
        // For a model far above the best one, one step is enough to determine the difference.
        let rise = fit.rss - least;
        let far = rise > criteria.no_rival * noise.residual_variance(fit);
        let reported = model.is_within(LossModel::VISCOUS_SLIDING) && !far;
        let problem = if reported { exact } else { accurate };
        let closer = if side_minima {
            minimise_until(problem, &fit.parameters, &fit.free, FIT_TOLERANCE, true)
        } else {
            let most = if far { FAR_STEP * rise } else { 0.0 };
            minimise_near(problem, &fit.parameters, &fit.free, FIT_TOLERANCE, most)
        };
        *fit = closer.unwrap_or_else(|| fit.clone());
        known.extend(reported.then_some(*model));
    }
    known
}

/// A fitted model without its negative losses; `None` if it has none, or only negative ones.
fn without_negative(fits: &[(LossModel, Fit)], model: LossModel) -> Option<LossModel> {
    let (_, fit) = fits.iter().find(|(m, _)| *m == model)?;
    let negative: Vec<LossTerm> = model.terms().filter(|t| fit.parameters[slot(*t)] < 0.0).collect();
    if negative.is_empty() { None } else { model.without(&negative) }
}

/// A model whose sum of squares, predicted from the quadratic form of a larger fit, exceeds that fit's by
/// more than `no_rival` noise variances.
struct DistantModel {
    free: Vec<usize>,
    start: Vec<f64>,
    /// Sum of squares of the larger fit.
    rss: f64,
    /// Predicted rise above the larger fit, in noise variances.
    rise: f64,
    /// Rise of the sum of squares above which the model is no rival.
    least: f64,
}

impl DistantModel {
    fn predicted(
        model: LossModel,
        fits: &[(LossModel, Fit)],
        no_rival: f64,
        noise: NoiseModel,
    ) -> Option<Self> {
        let (larger, fit) = fits.iter().find(|(m, _)| model.is_within(*m))?;
        let absent = || larger.terms().filter(|t| !model.has(*t));
        let fixed: Vec<(usize, f64)> = absent().map(|t| (slot(t), 0.0)).collect();
        let (rise, start) = conditional_minimum(fit, &fixed)?;
        let variance = noise.residual_variance(fit);
        let rise = rise / variance;
        let is_absent = |slot: &usize| absent().flat_map(slots).any(|s| s == *slot);
        (rise > no_rival).then(|| Self {
            free: fit.free.iter().copied().filter(|slot| !is_absent(slot)).collect(),
            start: without_shapes(model, start),
            rss: fit.rss,
            rise,
            least: no_rival * variance,
        })
    }

    /// Fit started only at the minimum of the quadratic form, and accurate to a standard error: neither
    /// another minimum nor a closer fit would make the model a rival. `None` if it turns out to be one.
    fn fit(&self, problem: &dyn LeastSquares) -> Option<Fit> {
        let found = minimise_roughly(problem, &self.start, &self.free, FAR_TOLERANCE)?;
        (found.rss - self.rss > self.least).then_some(found)
    }
}

/// Tolerance, in standard errors, to which such a model is fitted.
const FAR_TOLERANCE: f64 = 1.0;

/// Fraction of its rise above the best model by which the last step may improve such a model.
const FAR_STEP: f64 = 0.1;

/// Relative difference of sums of squares that is attributed to rounding.
const NESTED_TOLERANCE: f64 = 1e-9;

/// Start values of the search for the minimum of a model.
fn starts(
    model: LossModel,
    fits: &[(LossModel, Fit)],
    start: &[f64],
    whole: &WholeLoss,
    side_minima: bool,
) -> Vec<Vec<f64>> {
    let with_losses = |losses: &[(LossTerm, f64)]| {
        let mut p = start.to_vec();
        for &term in LossTerm::ALL {
            p[slot(term)] = losses.iter().find(|(t, _)| *t == term).map_or(0.0, |(_, c)| *c);
        }
        without_shapes(model, p)
    };
    if model == LossModel::VISCOUS_SLIDING {
        let begun = with_losses(&[(LossTerm::Viscous, start[DELTA]), (LossTerm::Sliding, start[X_F])]);
        let others = if side_minima { sliding_starts(&begun, whole).to_vec() } else { Vec::new() };
        return [vec![begun], others].concat();
    }
    let mut list: Vec<Vec<f64>> = Vec::new();
    let of_larger = fits.iter().find(|(m, _)| model.is_within(*m)).and_then(|(larger, fit)| {
        let absent: Vec<(usize, f64)> =
            larger.terms().filter(|t| !model.has(*t)).map(|t| (slot(t), 0.0)).collect();
        conditional_minimum(fit, &absent).map(|(rise, p)| (fit.rss + rise, without_shapes(model, p)))
    });
    if let Some((_, smaller)) = fits.iter().rfind(|(m, _)| m.is_within(model)) {
        let lower = of_larger.as_ref().is_some_and(|(rss, _)| *rss < smaller.rss);
        // If there is a single minimum, the better start is enough.
        if side_minima || !lower {
            list.push(smaller.parameters.clone());
        }
    }
    let of_larger = of_larger.map(|(_, p)| p);
    // The fit of the larger model has already tried every shape.
    let shapes_tried = of_larger.is_some() && LossModel::further_named(Some(model)) > 1;
    if !shapes_tried {
        let viscous = with_losses(&[(LossTerm::Viscous, whole.decay_rate)]);
        list.extend(shaped_starts(model, fits, &viscous, whole));
    }
    list.extend(of_larger);
    if model.terms().any(|term| !term.is_compared() && !term.is_shaped()) {
        // The search for the motion already had the requested terms free.
        let found: Vec<(LossTerm, f64)> = model.terms().map(|term| (term, start[slot(term)])).collect();
        list.push(with_losses(&found));
    }
    let alone = LossTerm::ALL.iter().filter(|term| model.terms().eq([**term]) && !term.is_shaped());
    list.extend(alone.map(|term| with_losses(&[(*term, whole.of(*term))])));
    if list.is_empty() {
        list.push(with_losses(&[(LossTerm::Viscous, whole.decay_rate)]));
    }
    list
}

/// Starts of viscous and sliding loss in other minima: [`SLIDING_SHARES`] of the loss at the first amplitude, all
/// with the half-life of the whole loss, `A/A_0 = (1 + r) exp(-delta t) - r` with `r = share/(1 - share)`.
pub(crate) fn sliding_starts(start: &[f64], whole: &WholeLoss) -> [Vec<f64>; SLIDING_SHARES.len()] {
    SLIDING_SHARES.map(|share| {
        let r = share / (1.0 - share);
        let decay_rate = whole.decay_rate * ((1.0 + r) / (0.5 + r)).log2();
        let mut p = start.to_vec();
        p[DELTA] = decay_rate;
        p[X_F] = r * decay_rate / whole.decay_rate * whole.friction_displacement;
        p
    })
}

/// Start values without the shape parameters of terms that the model lacks.
fn without_shapes(model: LossModel, mut p: Vec<f64>) -> Vec<f64> {
    for slot in LossTerm::shaped().iter().filter(|t| !model.has(**t)).filter_map(|t| shape_slot(*t)) {
        p[slot] = 0.0;
    }
    p
}

/// Starts of a model with a term that has a shape parameter: the fit of the model without that term, or
/// viscous loss, transfers a share of its losses to the term, for each start value of the shape.
fn shaped_starts(
    model: LossModel,
    fits: &[(LossModel, Fit)],
    viscous: &[f64],
    whole: &WholeLoss,
) -> Vec<Vec<f64>> {
    let mut list = Vec::new();
    for term in model.terms().filter(|t| t.is_shaped()) {
        let Some((shape, parameter)) = shape_slot(term).zip(term.shape_parameter()) else { continue };
        let others: Vec<LossTerm> = model.terms().filter(|t| *t != term).collect();
        let rest = LossModel::from_terms(&others);
        let fitted = rest.and_then(|rest| fits.iter().find(|(m, _)| *m == rest));
        let base = fitted.map_or(viscous, |(_, fit)| &fit.parameters);
        let left = if rest.is_some() { 1.0 - SHAPED_SHARE } else { 0.0 };
        for s in parameter.starts {
            let mut p = base.to_vec();
            LossTerm::ALL.iter().for_each(|t| p[slot(*t)] *= left);
            p[slot(term)] = (1.0 - left) * whole.of(term);
            p[shape] = *s;
            list.push(p);
        }
    }
    list
}

/// Starts with all parameters but the shapes fitted: the sum of squares falls along a curved valley from one
/// shape to another, and the final fit starts from its lowest point.
fn fitted_at_fixed_shapes(
    problem: &dyn LeastSquares,
    starts: Vec<Vec<f64>>,
    free: &[usize],
) -> Vec<Vec<f64>> {
    let is_shape = |slot: &usize| LossTerm::shaped().iter().any(|t| shape_slot(*t) == Some(*slot));
    let fixed: Vec<usize> = free.iter().copied().filter(|slot| !is_shape(slot)).collect();
    if fixed.len() == free.len() || starts.len() < 2 {
        return starts;
    }
    let settled = |start: Vec<f64>| {
        minimise_until(problem, &start, &fixed, FIXED_SHAPE_TOLERANCE, true)
            .map_or(start, |fit| fit.parameters)
    };
    let settled: Vec<Vec<f64>> = starts.into_iter().map(settled).collect();
    // A shape far off is often compensated by negative losses, in a separate minimum.
    let possible = |p: &&Vec<f64>| LossTerm::ALL.iter().all(|t| p[slot(*t)] >= 0.0);
    let within: Vec<Vec<f64>> = settled.iter().filter(possible).cloned().collect();
    if within.is_empty() { settled } else { within }
}

/// Tolerance, in standard errors, to which all parameters but the shape are fitted at the start of a search.
const FIXED_SHAPE_TOLERANCE: f64 = 1.0;

/// Tolerance, in standard errors, to which a model is fitted; the last step, which is smaller, is still
/// taken.
const FIT_TOLERANCE: f64 = 0.03;

/// Number of starts, those with the lowest sums of squares, from which a model with several minima is fitted.
const FITTED_STARTS: usize = 2;

/// Number of further starts tried in place of those that reach no minimum.
const SPARE_STARTS: usize = 3;

/// The lowest minimum reached from the `tried` starts with the lowest sums of squares, or from the next ones
/// if some of these reach none.
pub(crate) fn best_of(
    problem: &dyn LeastSquares,
    starts: &[Vec<f64>],
    free: &[usize],
    tried: usize,
) -> Option<Fit> {
    let minimise = |start: &[f64]| minimise_until(problem, start, free, FIT_TOLERANCE, true);
    if let [start] = starts {
        return minimise(start);
    }
    let mut sums = Normal::zeros(problem.parameters());
    let mut at = |p: &[f64]| problem.normal_of(p, &[], &mut sums, f64::INFINITY).then_some(sums.rss);
    let mut ranked: Vec<(f64, &Vec<f64>)> = starts.iter().filter_map(|s| Some((at(s)?, s))).collect();
    sort_by_value(&mut ranked, |r| r.0);
    let few = ranked.iter().take(tried + SPARE_STARTS);
    few.filter_map(|(_, start)| minimise(start)).take(tried).min_by(|a, b| a.rss.total_cmp(&b.rss))
}

//! Intervals that account for the uncertainty of the choice of model.

use super::describe::error_of_interval;
use crate::Quantity;
use crate::inference::Z_95;
use crate::inference::coefficient::AbsentCoefficient;
pub(crate) use crate::inference::coefficient::WeightedEstimate;
use crate::inference::criteria::InferenceCriteria;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::quadratic::conditional_minimum;
use crate::model::loss::{LossModel, LossTerm};
use crate::numeric::roots::root;
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// Widens the interval to account for other models: each end moves out to the point beyond which the tails of all
/// estimates, weighted by their probabilities, contain 2.5 % (Turek and Fletcher 2012, Computational Statistics and
/// Data Analysis 56, 2809), and never inside the interval of the estimate itself. The standard error is raised to at
/// least that of the interval.
pub(crate) fn widened(mut q: Quantity, others: &[WeightedEstimate]) -> Quantity {
    let known = |o: &&WeightedEstimate| o.value.is_finite() && o.std_error.is_finite() && o.std_error > 0.0;
    let others: Vec<WeightedEstimate> = others.iter().filter(known).copied().collect();
    let [low, high] = q.interval_95;
    if others.is_empty() || !high.is_finite() || !low.is_finite() {
        return q;
    }
    let (lower, upper) = (end(&q, &others, -1.0), end(&q, &others, 1.0));
    let lower = if low >= 0.0 { lower.max(0.0) } else { lower };
    q.interval_95 = [lower.min(low), upper.max(high)];
    if q.interval_95 != [low, high] {
        q.std_error = q.std_error.max(error_of_interval(q.value, q.interval_95));
    }
    q
}

/// Factor by which other models widen an interval.
pub(crate) fn widening(q: &Quantity, others: &[WeightedEstimate]) -> f64 {
    let width = |q: &Quantity| q.interval_95[1] - q.interval_95[0];
    width(&widened(q.clone(), others)) / width(q)
}

/// One end of an interval: the upper one if `side` is 1, the lower one if it is -1.
fn end(q: &Quantity, others: &[WeightedEstimate], side: f64) -> f64 {
    let end = if side < 0.0 { q.interval_95[0] } else { q.interval_95[1] };
    let all: f64 = others.iter().map(|o| o.weight).sum();
    let own = (1.0 - all).max(0.0);
    // Normal tails; the width on each side is that of the end on that side.
    let width = side * (end - q.value) / Z_95;
    let tail = |at: f64| {
        let beyond = |value: f64, width: f64| 0.5 * erfc(side * (at - value) / (width * SQRT_2));
        let mine = if width > 0.0 { own * beyond(q.value, width) } else { 0.0 };
        mine + others.iter().map(|o| o.weight * beyond(o.value, o.std_error)).sum::<f64>()
    };
    let reach = Z_95 * all.max(1.0);
    let ends = others.iter().map(|o| o.value + side * reach * o.std_error);
    let far = side * ends.map(|e| side * e).fold(side * end, f64::max);
    if far == end || tail(end) <= 0.025 { end } else { root(end, far, |at| tail(at) - 0.025) }
}

/// A loss that the reported model does not have and that the data do not exclude: its probability and its coefficient,
/// with which the other parameters are correlated.
///
/// The prior of the coefficient is uniform between zero and the value at which it would replace all viscous loss. So
/// wide a prior gives a weak loss hardly any weight, although in a precise record a weak loss may shift the other
/// parameters by many standard errors. Therefore a second prior, with smaller odds, is confined to a small part of this
/// range.
#[derive(Debug, Clone, Copy)]
struct AbsentLoss<'a> {
    comparison: &'a ModelComparison,
    with: &'a ModelFit,
    slot: usize,
    coefficient: AbsentCoefficient,
    /// Standard error of the coefficient without limits.
    std_error: f64,
}

impl<'a> AbsentLoss<'a> {
    /// Adds `term` to those terms of the chosen model that are `kept`; one result for each of the two prior ranges of
    /// its coefficient. `None` if the model already has the term or no fit with it exists.
    fn of_ranges(
        comparison: &'a ModelComparison,
        chosen: &ModelFit,
        term: LossTerm,
        kept: impl Fn(&LossTerm) -> bool,
        slot: impl Fn(LossTerm) -> usize,
    ) -> Option<[Self; 2]> {
        if chosen.model.has(term) {
            return None;
        }
        let terms: Vec<LossTerm> = chosen.model.terms().filter(kept).chain([term]).collect();
        let with = comparison.get(LossModel::from_terms(&terms)?)?;
        let without_viscous: Vec<LossTerm> =
            terms.iter().copied().filter(|t| *t != LossTerm::Viscous).collect();
        let replaced = LossModel::from_terms(&without_viscous).and_then(|model| comparison.get(model));
        let viscous = slot(LossTerm::Viscous);
        let slot = slot(term);
        let most = match replaced {
            Some(fit) if !comparison.viscous_is_sure => fit.unbounded.parameters[slot],
            _ => conditional_minimum(&with.unbounded, &[(viscous, 0.0)])?.1[slot],
        };
        let std_error = comparison.noise.std_error(&with.unbounded, slot);
        if !(std_error > 0.0 && std_error.is_finite() && most > 0.0) {
            return None;
        }
        let estimate = with.unbounded.parameters[slot];
        let InferenceCriteria { weak_loss, weak_loss_odds, .. } = comparison.criteria;
        let of_range = |[part, prior]: [f64; 2]| {
            let coefficient = AbsentCoefficient::within(estimate, std_error, part * most, prior);
            Self { comparison, with, slot, coefficient, std_error }
        };
        Some([[1.0, 1.0], [weak_loss, weak_loss_odds]].map(of_range))
    }

    /// Change of a quantity with this `gradient` (with respect to the parameters) per unit of the coefficient.
    fn slope(&self, gradient: &[(usize, f64)]) -> f64 {
        let covariance = |i: usize, j: usize| self.with.unbounded.unit_covariance[(i, j)];
        let along: f64 = gradient.iter().map(|(i, g)| g * covariance(*i, self.slot)).sum();
        along / covariance(self.slot, self.slot)
    }

    /// Estimate, by the model with the loss, of a quantity with this `gradient` with respect to the parameters. Each
    /// value of the coefficient shifts it along the covariance from its value `without` the loss; the variance
    /// conditional on the coefficient is added. `total`: sum of the odds of all models.
    fn weighted_estimate(&self, gradient: &[(usize, f64)], without: f64, total: f64) -> WeightedEstimate {
        let fit = &self.with.unbounded;
        let covariance = |i: usize, j: usize| fit.unit_covariance[(i, j)];
        let slope = self.slope(gradient);
        let own =
            |(i, a): &(usize, f64)| -> f64 { gradient.iter().map(|(j, b)| a * b * covariance(*i, *j)).sum() };
        let whole = gradient.iter().map(own).sum::<f64>() * self.comparison.noise.variance(fit);
        let given = (whole - slope * slope * self.std_error * self.std_error).max(0.0);
        let by = self.coefficient.weighted_estimate(without, slope, given, total);
        WeightedEstimate { std_error: by.std_error * self.comparison.noise.student_factor(fit), ..by }
    }
}

/// Losses that the chosen model does not have and the data do not exclude, with the estimates by the models that have
/// them for a quantity with this `gradient` with respect to the parameters. `of`: the loss term whose coefficient the
/// quantity is, if any.
pub(crate) fn absent_losses(
    comparison: &ModelComparison,
    chosen: &ModelFit,
    of: Option<LossTerm>,
    gradient: &[(usize, f64)],
    q: &Quantity,
    slot: impl Fn(LossTerm) -> usize + Copy,
) -> (Vec<LossTerm>, Vec<WeightedEstimate>) {
    let at_limit = |t: &LossTerm| Some(*t) != of && chosen.bounded.parameters[slot(*t)] <= 0.0;
    let limited: Vec<LossTerm> = chosen.model.terms().filter(at_limit).collect();
    let absent = |t, kept: &dyn Fn(&LossTerm) -> bool| {
        AbsentLoss::of_ranges(comparison, chosen, t, kept, slot).into_iter().flatten()
    };
    let alone = LossTerm::compared(None)
        .flat_map(|t| absent(t, &|t| !at_limit(t)).map(move |loss| (t, loss, q.value)));
    // A loss that is zero on its own may be present together with another one of opposite effect.
    let all_kept = LossTerm::compared(None).filter(|_| !limited.is_empty());
    let all_kept = all_kept.flat_map(|t| absent(t, &|_| true).map(move |loss| (t, loss)));
    let beside = all_kept.filter_map(|(t, loss)| {
        let estimate = &loss.with.unbounded.parameters;
        let moved = |(i, g): &(usize, f64)| g * (estimate[*i] - chosen.bounded.parameters[*i]);
        let with = q.value + gradient.iter().map(moved).sum::<f64>();
        let without = with - loss.slope(gradient) * estimate[loss.slot];
        limited.iter().all(|l| estimate[slot(*l)] > 0.0).then_some((t, loss, without))
    });
    let found: Vec<(LossTerm, AbsentLoss, f64)> = alone.chain(beside).collect();
    let total = 1.0 + found.iter().map(|(_, loss, _)| loss.coefficient.odds).sum::<f64>();
    found.iter().map(|(t, loss, without)| (*t, loss.weighted_estimate(gradient, *without, total))).unzip()
}

/// Estimates of a quantity by the models that have another loss in place of viscous damping; `value` returns the
/// quantity and its standard error for a fit. Empty if the chosen model has no viscous damping.
///
/// A model with both losses gives little weight to the limiting case of zero viscous loss, whereas the model with the
/// other loss alone has as many parameters as the chosen one and is equally probable a priori.
pub(crate) fn exchanged_losses(
    comparison: &ModelComparison,
    chosen: &ModelFit,
    value: impl Fn(&ModelFit) -> (f64, f64),
) -> (Vec<LossTerm>, Vec<WeightedEstimate>) {
    if !chosen.model.has(LossTerm::Viscous) {
        return Default::default();
    }
    let exchanged = |term: LossTerm| {
        let others = chosen.model.terms().filter(|t| *t != LossTerm::Viscous).chain([term]);
        let fit = comparison.get(LossModel::from_terms(&others.collect::<Vec<_>>())?)?;
        let odds = (-0.5 * (fit.bic - chosen.bic)).exp();
        let (value, std_error) = value(fit);
        let weight = if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 };
        Some((term, WeightedEstimate { weight, value, std_error }))
    };
    LossTerm::compared(None).filter(|t| !chosen.model.has(*t)).filter_map(exchanged).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_stretched_to_where_all_tails_hold_their_share() {
        let q = Quantity::normal(1.0, 0.1, "");
        let same = WeightedEstimate { weight: 0.5, value: 1.0, std_error: 0.1 };
        let [low, high] = widened(q.clone(), &[same]).interval_95;
        assert!((low - q.interval_95[0]).abs() < 1e-6, "{low}");
        assert!((high - q.interval_95[1]).abs() < 1e-6, "{high}");
        let aside = WeightedEstimate { weight: 0.5, value: 2.0, std_error: 0.1 };
        let found = widened(q.clone(), &[aside]);
        // Half of the weight: its upper 5 %, i.e. 1.645 of its standard errors.
        assert!((found.interval_95[1] - 2.1645).abs() < 1e-3, "{:?}", found.interval_95);
        assert_eq!(found.interval_95[0], q.interval_95[0]);
        // A weight of 1 % lies beyond, which leaves 1.5 % for the tail of the estimate itself.
        let unlikely = WeightedEstimate { weight: 0.01, ..aside };
        let end = widened(q.clone(), &[unlikely]).interval_95[1];
        let own = 0.99 * 0.5 * erfc((end - 1.0) / (0.1 * SQRT_2));
        assert!((own - 0.015).abs() < 1e-6, "{end}");
    }
}

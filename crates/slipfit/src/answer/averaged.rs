//! Intervals that count the choice of model.

use super::describe::error_of_interval;
use crate::Quantity;
use crate::inference::Z_95;
use crate::inference::coefficient::AbsentCoefficient;
pub(crate) use crate::inference::coefficient::Weighed;
use crate::inference::criteria::InferenceCriteria;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::quadratic::given;
use crate::model::loss::{LossModel, LossTerm};
use crate::numeric::roots::root;
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// The interval stretched by what other models say: to the end beyond which the tails of all estimates, each
/// by its weight, hold 2.5 % (Turek and Fletcher 2012, Computational Statistics and Data Analysis 56, 2809);
/// not inside the interval of the estimate itself. The standard error becomes at least that of the interval.
pub(crate) fn stretched(mut q: Quantity, others: &[Weighed]) -> Quantity {
    let known = |o: &&Weighed| o.value.is_finite() && o.std_error.is_finite() && o.std_error > 0.0;
    let others: Vec<Weighed> = others.iter().filter(known).copied().collect();
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

/// By which factor other models widen an interval.
pub(crate) fn widening(q: &Quantity, others: &[Weighed]) -> f64 {
    let width = |q: &Quantity| q.interval_95[1] - q.interval_95[0];
    width(&stretched(q.clone(), others)) / width(q)
}

/// The end of an interval, the upper one for a `side` of 1.
fn end(q: &Quantity, others: &[Weighed], side: f64) -> f64 {
    let end = if side < 0.0 { q.interval_95[0] } else { q.interval_95[1] };
    let all: f64 = others.iter().map(|o| o.weight).sum();
    let own = (1.0 - all).max(0.0);
    // Normal tails, each half with the width that its end has.
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

/// A loss that the reported model has not, and that the data do not exclude: its probability and its
/// coefficient, which moves the other parameters along.
///
/// Before the data the coefficient lies anywhere between zero and what would take the place of all viscous loss. A range
/// as wide leaves hardly any weight on a weak loss, which moves the others by many of the errors of a precise record: with
/// smaller odds the coefficient lies within a small part of it.
#[derive(Debug, Clone, Copy)]
struct AbsentLoss<'a> {
    comparison: &'a ModelComparison,
    with: &'a ModelFit,
    slot: usize,
    coefficient: AbsentCoefficient,
    /// Of the coefficient, without limits.
    std_error: f64,
}

impl<'a> AbsentLoss<'a> {
    /// The `term` beside those terms of the chosen model that are `kept`; `None` where the model has it or no fit
    /// with it was made. One for each of the ranges that its coefficient may lie in.
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
            _ => given(&with.unbounded, &[(viscous, 0.0)])?.1[slot],
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

    /// By which the coefficient moves a quantity with this `gradient` by the parameters.
    fn slope(&self, gradient: &[(usize, f64)]) -> f64 {
        let covariance = |i: usize, j: usize| self.with.unbounded.unit_covariance[(i, j)];
        let along: f64 = gradient.iter().map(|(i, g)| g * covariance(*i, self.slot)).sum();
        along / covariance(self.slot, self.slot)
    }

    /// What the model with the loss says of a quantity whose `gradient` by the parameters is given: each value of its
    /// coefficient moves it along the covariance from what it is `without`, and leaves the error that it has given that
    /// value. `total`: the odds of all models.
    fn weighed(&self, gradient: &[(usize, f64)], without: f64, total: f64) -> Weighed {
        let fit = &self.with.unbounded;
        let covariance = |i: usize, j: usize| fit.unit_covariance[(i, j)];
        let slope = self.slope(gradient);
        let own =
            |(i, a): &(usize, f64)| -> f64 { gradient.iter().map(|(j, b)| a * b * covariance(*i, *j)).sum() };
        let whole = gradient.iter().map(own).sum::<f64>() * self.comparison.noise.variance(fit);
        let given = (whole - slope * slope * self.std_error * self.std_error).max(0.0);
        let by = self.coefficient.weighed(without, slope, given, total);
        Weighed { std_error: by.std_error * self.comparison.noise.student_factor(fit), ..by }
    }
}

/// The losses that the chosen model has not and the data do not exclude, and what the models with them say of a
/// quantity with this `gradient` by the parameters: the coefficient of the term `of`, or of none.
pub(crate) fn absent_losses(
    comparison: &ModelComparison,
    chosen: &ModelFit,
    of: Option<LossTerm>,
    gradient: &[(usize, f64)],
    q: &Quantity,
    slot: impl Fn(LossTerm) -> usize + Copy,
) -> (Vec<LossTerm>, Vec<Weighed>) {
    let at_limit = |t: &LossTerm| Some(*t) != of && chosen.bounded.parameters[slot(*t)] <= 0.0;
    let limited: Vec<LossTerm> = chosen.model.terms().filter(at_limit).collect();
    let absent = |t, kept: &dyn Fn(&LossTerm) -> bool| {
        AbsentLoss::of_ranges(comparison, chosen, t, kept, slot).into_iter().flatten()
    };
    let alone = LossTerm::compared(None)
        .flat_map(|t| absent(t, &|t| !at_limit(t)).map(move |loss| (t, loss, q.value)));
    // A loss that is nothing by itself may be there beside another one that opposes it.
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
    found.iter().map(|(t, loss, without)| (*t, loss.weighed(gradient, *without, total))).unzip()
}

/// What the models that have another loss in place of viscous damping say of a quantity; `value` gives the
/// quantity and its standard error for a fit. Nothing where the chosen model has no viscous damping.
///
/// A model with the other loss beside viscous loss leaves little weight on their end, where viscous loss is nothing:
/// the one with as many parameters is as probable before the data.
pub(crate) fn exchanged_losses(
    comparison: &ModelComparison,
    chosen: &ModelFit,
    value: impl Fn(&ModelFit) -> (f64, f64),
) -> (Vec<LossTerm>, Vec<Weighed>) {
    if !chosen.model.has(LossTerm::Viscous) {
        return Default::default();
    }
    let exchanged = |term: LossTerm| {
        let others = chosen.model.terms().filter(|t| *t != LossTerm::Viscous).chain([term]);
        let fit = comparison.get(LossModel::from_terms(&others.collect::<Vec<_>>())?)?;
        let odds = (-0.5 * (fit.bic - chosen.bic)).exp();
        let (value, std_error) = value(fit);
        let weight = if odds.is_finite() { odds / (1.0 + odds) } else { 1.0 };
        Some((term, Weighed { weight, value, std_error }))
    };
    LossTerm::compared(None).filter(|t| !chosen.model.has(*t)).filter_map(exchanged).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_stretched_to_where_all_tails_hold_their_share() {
        let q = Quantity::normal(1.0, 0.1, "");
        let same = Weighed { weight: 0.5, value: 1.0, std_error: 0.1 };
        let [low, high] = stretched(q.clone(), &[same]).interval_95;
        assert!((low - q.interval_95[0]).abs() < 1e-6, "{low}");
        assert!((high - q.interval_95[1]).abs() < 1e-6, "{high}");
        let aside = Weighed { weight: 0.5, value: 2.0, std_error: 0.1 };
        let found = stretched(q.clone(), &[aside]);
        // Half of 5 % beyond: 1.645 of its errors.
        assert!((found.interval_95[1] - 2.1645).abs() < 1e-3, "{:?}", found.interval_95);
        assert_eq!(found.interval_95[0], q.interval_95[0]);
        // One in a hundred beyond: 1.5 % of the rest are left for the own tail.
        let unlikely = Weighed { weight: 0.01, ..aside };
        let end = stretched(q.clone(), &[unlikely]).interval_95[1];
        let own = 0.99 * 0.5 * erfc((end - 1.0) / (0.1 * SQRT_2));
        assert!((own - 0.015).abs() < 1e-6, "{end}");
    }
}

//! Intervals that count the choice of model.

use super::describe::error_of_interval;
use crate::Quantity;
use crate::inference::Z_95;
use crate::inference::criteria::InferenceCriteria;
use crate::inference::model_selection::{ModelComparison, ModelFit};
use crate::inference::quadratic::given;
use crate::model::loss::{LossModel, LossTerm};
use crate::numeric::roots::root;
use statrs::function::erf::erfc;
use std::f64::consts::{PI, SQRT_2};

/// What another model says of a parameter, and how probable it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighed {
    /// Probability of the model beside the one reported; those of several kinds of models may sum to more than one.
    pub(crate) weight: f64,
    pub(crate) value: f64,
    pub(crate) std_error: f64,
}

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

/// Odds that count as certainty.
const MOST_ODDS: f64 = 1e12;

/// A loss that the reported model has not, and that the data do not exclude: its probability and its
/// coefficient, which moves the other parameters along.
///
/// Before the data the coefficient lies anywhere between zero and what would take the place of all viscous loss. Its
/// likelihood beside the terms of the model being normal, with estimate `a` and standard error `s`, the odds
/// of the model with the loss are `s sqrt(2 pi)/most exp(z²/2) [Phi(z) - Phi(z - most/s)]`, `z = a/s`. Unlike
/// the BIC, whose prior is as wide as the information of one sample, this leaves weight on a loss that the
/// record could not have shown. A range as wide leaves hardly any on a weak loss, which moves the others by many of the
/// errors of a precise record: with smaller odds the coefficient lies within a small part of it.
#[derive(Debug, Clone, Copy)]
struct AbsentLoss<'a> {
    comparison: &'a ModelComparison,
    with: &'a ModelFit,
    slot: usize,
    /// Probability of the model with it over that without.
    odds: f64,
    /// Of the coefficient, within its limits.
    mean: f64,
    variance: f64,
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
        let estimate = with.unbounded.parameters[slot] / std_error;
        let InferenceCriteria { weak_loss, weak_loss_odds, .. } = comparison.criteria;
        let of_range = |[part, prior]: [f64; 2]| {
            let most = part * most;
            let truncated = Truncated::new(estimate, most / std_error);
            let odds = prior * std_error * (2.0 * PI).sqrt() / most * truncated.likelihood;
            let (mean, variance) = (truncated.mean * std_error, truncated.variance * std_error * std_error);
            Self { comparison, with, slot, odds: odds.min(MOST_ODDS), mean, variance, std_error }
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
        Weighed {
            weight: self.odds / total,
            value: without + slope * self.mean,
            std_error: (given + slope * slope * self.variance).sqrt()
                * self.comparison.noise.student_factor(fit),
        }
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
    let total = 1.0 + found.iter().map(|(_, loss, _)| loss.odds).sum::<f64>();
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

/// A normal distribution of unit width about `z`, between zero and `most`.
struct Truncated {
    /// `exp(z²/2)` times its content.
    likelihood: f64,
    mean: f64,
    variance: f64,
}

impl Truncated {
    fn new(z: f64, most: f64) -> Self {
        if z <= most {
            return Self::below(z, most);
        }
        // Seen from the upper end it is one about a value below zero.
        let mirrored = Self::below(most - z, most);
        Self {
            likelihood: (most * (z - 0.5 * most)).exp() * mirrored.likelihood,
            mean: most - mirrored.mean,
            ..mirrored
        }
    }

    /// That of a `z` that is not above `most`.
    fn below(z: f64, most: f64) -> Self {
        let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
        let beyond = |x: f64| 0.5 * erfc(x / SQRT_2);
        // Far below zero it is an exponential of rate -z.
        if z < -30.0 {
            let left = (z * most).exp_m1();
            let behind = most * (1.0 + left) / left;
            let mean = behind - 1.0 / z;
            return Self {
                likelihood: left / z / (2.0 * PI).sqrt(),
                mean,
                variance: (1.0 / (z * z) - most * behind / left).max(0.0),
            };
        }
        let top = most - z;
        let content = beyond(-z) - beyond(top);
        let shift = (density(z) - density(top)) / content;
        let square = (-z * density(z) - top * density(top)) / content;
        Self {
            likelihood: (0.5 * z * z).exp() * content,
            mean: z + shift,
            variance: (1.0 + square - shift * shift).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate;

    #[test]
    fn a_truncated_normal_has_the_moments_of_its_integral() {
        let cases = [
            (-5.0, 3.0),
            (-1.0, 10.0),
            (0.3, 0.5),
            (2.0, 30.0),
            (4.0, 5.0),
            (9.0, 1.0),
            (9.5, 1.0),
            (12.0, 3.0),
        ];
        for (z, most) in cases {
            let moment = |k: i32| {
                integrate(&|x: f64| x.powi(k) * (z * x - 0.5 * x * x).exp() / (2.0 * PI).sqrt(), 0.0, most)
            };
            let found = Truncated::new(z, most);
            let mean = moment(1) / moment(0);
            let variance = moment(2) / moment(0) - mean * mean;
            assert!((found.likelihood / moment(0) - 1.0).abs() < 1e-6, "{z} {most}");
            assert!((found.mean / mean - 1.0).abs() < 1e-5, "{z} {most}: {} {mean}", found.mean);
            assert!((found.variance / variance - 1.0).abs() < 1e-3, "{z} {most}: {}", found.variance);
        }
        for (z, most) in [(-31.0, 0.02), (-29.0, 0.02)] {
            let found = Truncated::new(z, most);
            let mean = 1.0 / -z - most / ((-z * most).exp() - 1.0);
            assert!((found.mean / mean - 1.0).abs() < 2e-3, "{z}: {} for {mean}", found.mean);
        }
        let narrow = Truncated::new(-8.0, 0.05);
        assert!((narrow.mean - (0.025 - 8.0 * 0.05 * 0.05 / 12.0)).abs() < 1e-5, "{}", narrow.mean);
        assert!((narrow.variance * 12.0 / (0.05 * 0.05) - 1.0).abs() < 0.05, "{}", narrow.variance);
        let far = Truncated::new(-40.0, 5.0);
        assert!((far.mean * 40.0 - 1.0).abs() < 0.01, "{}", far.mean);
        assert!(far.likelihood.is_finite());
    }

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

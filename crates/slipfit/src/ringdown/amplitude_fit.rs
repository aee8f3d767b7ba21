//! Fit of the loss laws to the amplitudes of the blocks.

use super::cluster_jackknife::inflation_of_amplitudes;
use super::compare::{
    Models, Search, WholeLoss, best_of, compare, loss_parameters, sliding_starts, slot, with_shape_starts,
};
use super::criteria::{AmplitudeCriteria, Criteria};
use super::envelope::{A0, DELTA, EnvelopeProblem, FLOOR, X_F};
use super::lowpass::Kernel;
use super::measured::{BELOW_NOISE, MeasuredDecay};
use super::options::Options;
use super::window_fit::{Problem, WindowFit};
use crate::answer::describe::constrained;
use crate::inference::bounded::minimise_bounded;
use crate::inference::least_squares::{Fit, LeastSquares, STEP_TOLERANCE, minimise};
use crate::inference::noise::{NoiseModel, autocorrelation, significant_inflation};
use crate::numeric::{robust, roots};
use crate::signal::blocks::Block;
use crate::{Error, LossTerm};
use std::borrow::Cow;

/// Rounds of outlier rejection, and of estimating the error of the law.
const ROUNDS: usize = 3;
const WEIGHTINGS: usize = 4;
/// Rounds of reweighting mean squares by their fitted law.
const REWEIGHTINGS: usize = 3;
/// Relative change of the error of the law below which its iteration ends.
const TOLERANCE: f64 = 0.05;
/// The last 1/`LAST_PART` of the amplitudes is averaged to find how far they fell.
const LAST_PART: usize = 16;
/// Ratio of that mean to the first amplitude below which the motion may have stopped.
const NEAR_ZERO: f64 = 0.2;
/// Lower bound of a squared amplitude relative to the first one, which keeps its weight finite.
pub(super) const LEAST_SQUARED_AMPLITUDE: f64 = 1e-6;

/// Fits every loss model to the amplitudes of the blocks. Blocks at the end where the averaged law does not
/// hold are discarded.
pub(crate) fn fit_amplitudes<'a>(
    measured: &mut MeasuredDecay,
    options: &Options,
    criteria: &Criteria,
) -> Result<WindowFit<'a>, Error> {
    let too_few = Error::NoFit { reason: "fewer than three amplitudes of a falling oscillation remain" };
    if measured.points.len() < criteria.blocks.least_blocks {
        return Err(too_few);
    }
    let c = &criteria.amplitude;
    let origin = measured.start_s();
    let mut problem = amplitude_problem(measured, options);
    if measured.law.walk_in_cycles > 0.0 && scatter_differs(&problem, measured, options, criteria) {
        measured.law.walk_in_cycles = 0.0;
        problem = amplitude_problem(measured, options);
    }
    let has_floor = measured.root_mean_squares && last_to_first_ratio(&problem) < c.floor_visible;
    let nuisance: &[usize] = if has_floor { &[FLOOR] } else { &[] };
    let mut start = start_values(&problem);
    if measured.root_mean_squares && !has_floor {
        // A floor too small to be fitted still raises every amplitude.
        start[FLOOR] = 2.0 * measured.noise_rms.powi(2);
    }
    let full = [&loss_parameters(options.model)[..], nuisance].concat();
    let offered = with_shape_starts(&start, options.model);
    let least_deviation = if measured.root_mean_squares { 0.0 } else { measured.noise_rms };
    let unit_weight = 1.0 / measured.points[0].unit_variance;
    if measured.root_mean_squares {
        weigh_by_law(&mut problem, &start, nuisance, unit_weight);
    }
    let losses: Vec<usize> = LossTerm::compared(options.model).map(slot).collect();
    let (outliers, known) = drop_outliers(&mut problem, &offered, &full, &losses, least_deviation, c);
    let (viscous, mut known) = known.unzip();
    let viscous = viscous.filter(|_| offered == start);
    if !measured.root_mean_squares
        && let Some(kept) = end_of_law(&problem, &start, viscous, c)
    {
        known = None;
        retain(&mut problem, |i| i < kept);
        let last = problem.elapsed[kept - 1];
        measured.points.retain(|b| b.time_s - origin <= last + 1e-9 * b.span_s);
    }
    let n = problem.value.len();
    if n < criteria.blocks.least_blocks {
        return Err(too_few);
    }
    if measured.root_mean_squares && outliers > 0 {
        known = None;
        weigh_by_law(&mut problem, &start, nuisance, unit_weight);
    }
    let noise = measured.noise_rms.powi(2);
    let noise_weights = problem.weight.clone();
    let significance = criteria.inference.excess_significance;
    let law_has_error = add_law_error(&mut problem, &offered, (&full, known), noise, significance, c);
    let mut noise_model = NoiseModel::white(n as f64);
    let whole = WholeLoss::new(start[DELTA], start[A0], problem.omega);
    let asked = options.model;
    let search = Search {
        asked,
        models: Models::All,
        begun: None,
        side_minima: true,
        last: None,
        criteria: &criteria.inference,
    };
    let comparison = compare(&problem, &start, nuisance, noise_model, whole, search);
    // If no law can be fitted, the first amplitude has no standard error that it could exceed.
    let best = comparison.preferred().ok_or(Error::NotARingDown {
        cycles: measured.cycles(),
        needed: criteria.blocks.least_cycles,
        reason: BELOW_NOISE,
    })?;
    let residuals = problem.residuals(&best.bounded.parameters);
    let autocorrelation = autocorrelation(&residuals);
    let mut excess = 1.0;
    let dof = (n as f64 - best.bounded.free.len() as f64).max(1.0);
    if !measured.root_mean_squares {
        // Compared with the noise alone, without the error admitted for the law.
        let chi_squared: f64 =
            residuals.iter().zip(&problem.weight).zip(&noise_weights).map(|((r, w), v)| r * r / w * v).sum();
        excess = (chi_squared / dof / noise.max(f64::MIN_POSITIVE)).min(f64::MAX.sqrt());
        if !law_has_error && (excess - 1.0).abs() < significance * (2.0 / dof).sqrt() {
            noise_model.known_variance = Some(noise);
        }
    }
    let serial_inflation = significant_inflation(autocorrelation, n, significance);
    noise_model.variance_inflation = serial_inflation;
    // Misfit of the law shifts the clusters too, but is not noise: another law may describe it.
    if excess < c.most_cluster_excess {
        let largest = comparison.largest().map_or(&best.bounded, |fit| &fit.bounded);
        let variance = noise_model.residual_variance(largest);
        let from_cluster_to_cluster =
            inflation_of_amplitudes(&problem, largest, variance, criteria.inference.cluster_significance);
        noise_model.variance_inflation = serial_inflation.max(from_cluster_to_cluster);
    }
    Ok(WindowFit {
        comparison: comparison.with_noise(noise_model),
        problem: Problem::Envelope(problem),
        origin,
        end: measured.end_s(),
        excess,
        excess_freedom: dof,
        autocorrelation,
        serial_inflation,
        wandering: None,
        harmonics: None,
        several_minima: false,
        other_minima: Vec::new(),
        outliers,
    })
}

/// The amplitudes with weights from the noise alone.
pub(crate) fn amplitude_problem(measured: &MeasuredDecay, options: &Options) -> EnvelopeProblem {
    let points = &measured.points;
    let origin = measured.start_s();
    let squared = measured.root_mean_squares;
    let value: Vec<f64> =
        points.iter().map(|b| if squared { b.amplitude * b.amplitude } else { b.amplitude }).collect();
    let mut weight: Vec<f64> =
        points.iter().map(|b| 1.0 / (b.unit_variance + walk_variance(b, measured))).collect();
    if squared {
        // var(R²) = 4 sigma² (A² + sigma²): in units of sigma².
        let least = LEAST_SQUARED_AMPLITUDE * value[0].max(f64::MIN_POSITIVE);
        for (w, v) in weight.iter_mut().zip(&value) {
            *w /= 4.0 * v.max(least);
        }
    }
    EnvelopeProblem {
        elapsed: points.iter().map(|b| b.time_s - origin).collect(),
        value,
        weight,
        omega: measured.law.reference_omega(),
        backbone: measured.law.backbone(),
        squared,
        time_variance_s2: measured.time_variance_s2,
        lowpass: options.lockin.map(Kernel::new),
    }
}

/// Variance of a block's amplitude due to a random walk of the phase with variance `q` per second, in units
/// of the noise variance of a sample: `A² q/(4 omega² T)`, the part of the walk at twice the frequency, over
/// a block of length `T`.
fn walk_variance(block: &Block, measured: &MeasuredDecay) -> f64 {
    let relative = measured.law.walk_in_cycles / (4.0 * block.omega.powi(2) * block.span_s);
    let variance = relative * block.amplitude.powi(2) / measured.noise_rms.powi(2);
    if variance.is_finite() { variance } else { 0.0 }
}

/// Whether the amplitudes scatter by less or by more than noise and a random walk of the phase predict. An
/// apparent walk that leaves the amplitudes unaffected is slower than a cycle, i.e. a wandering frequency. If
/// the amplitudes scatter more, the law is in error, and that error is estimated from the amplitudes
/// themselves.
fn scatter_differs(
    problem: &EnvelopeProblem,
    measured: &MeasuredDecay,
    options: &Options,
    criteria: &Criteria,
) -> bool {
    let full = loss_parameters(options.model);
    let start = with_shape_starts(&start_values(problem), options.model);
    let Some(fit) = fit_from_viscous(problem, &start, &full) else { return false };
    // If the law ends before the amplitudes do, most amplitudes are still informative.
    let Some(deviation) = robust::deviation(problem.residuals(&fit.parameters).into_iter()) else {
        return false;
    };
    let ratio = (deviation / measured.noise_rms).powi(2);
    let error = ROBUST_ERROR / (problem.value.len() as f64).sqrt();
    (ratio - 1.0).abs() > criteria.inference.excess_significance * error
}

/// Relative standard error of the squared robust deviation of `n` values, times the square root of `n`.
const ROBUST_ERROR: f64 = 2.33;

/// Weights mean squares, each of the same number of samples, by the law fitted to them,
/// `var(R²) = 4 sigma² (A² + sigma²)`. If weighted by their own values, those that the noise made small would
/// get the largest weights and pull the tail down as friction does. Viscous and sliding loss, neither below
/// zero, are close enough to any law for this purpose.
fn weigh_by_law(problem: &mut EnvelopeProblem, start: &[f64], nuisance: &[usize], unit_weight: f64) {
    let least = LEAST_SQUARED_AMPLITUDE * problem.value[0].max(f64::MIN_POSITIVE);
    let free = [&[A0, DELTA, X_F][..], nuisance].concat();
    for _ in 0..REWEIGHTINGS {
        let Some(fit) = fit_from_viscous(problem, start, &free) else { return };
        let Some(fit) = constrained(problem, &fit, &[DELTA, X_F]) else { return };
        let half_floor = 0.5 * fit.parameters[FLOOR].max(0.0);
        let amplitudes = problem.amplitudes(&fit.parameters);
        for (weight, a) in problem.weight.iter_mut().zip(&amplitudes) {
            *weight = unit_weight / (4.0 * (a.max(0.0).powi(2) + half_floor).max(least));
        }
    }
}

/// Amplitude and decay rate from the upper half of the fall, where every law is an exponential.
pub(crate) fn start_values(problem: &EnvelopeProblem) -> Vec<f64> {
    let root = |v: f64| if problem.squared { v.max(0.0).sqrt() } else { v };
    let first = root(problem.value[0]).max(f64::MIN_POSITIVE);
    let half =
        problem.value.iter().position(|&v| root(v) < 0.5 * first).unwrap_or(problem.value.len() - 1).max(1);
    let span = (problem.elapsed[half] - problem.elapsed[0]).max(f64::MIN_POSITIVE);
    let delta = (first / root(problem.value[half]).max(1e-3 * first)).ln() / span;
    let mut start = vec![0.0; problem.parameters()];
    start[A0] = first * (delta * problem.elapsed[0]).exp();
    start[DELTA] = delta.max(1e-12 / span);
    start
}

/// The best fit with all of `free`, started from the viscous law; the viscous law itself if no other is
/// found.
///
/// If the amplitudes end near zero, the motion may have stopped within them, and the sum of squares has other
/// minima: the most likely of them is tried as well.
pub(crate) fn fit_from_viscous(problem: &EnvelopeProblem, start: &[f64], free: &[usize]) -> Option<Fit> {
    fit_from_given_viscous(problem, start, &viscous_law(problem, start)?, free)
}

fn viscous_law(problem: &EnvelopeProblem, start: &[f64]) -> Option<Fit> {
    minimise(problem, start, &[A0, DELTA])
}

/// [`fit_from_viscous`] with the viscous law given.
fn fit_from_given_viscous(
    problem: &EnvelopeProblem,
    start: &[f64],
    viscous: &Fit,
    free: &[usize],
) -> Option<Fit> {
    let fit = minimise(problem, &viscous.parameters, free).filter(|f| f.rss.is_finite());
    let fit = fit.unwrap_or_else(|| viscous.clone());
    if !(free.contains(&X_F) && may_stop(problem)) {
        return Some(fit);
    }
    let whole = WholeLoss::new(start[DELTA], start[A0], problem.omega);
    let other = best_of(problem, &sliding_starts(start, &whole), free, 1);
    Some(other.filter(|other| other.rss < fit.rss).unwrap_or(fit))
}

/// Whether the last amplitudes are near zero compared with the first one.
fn may_stop(problem: &EnvelopeProblem) -> bool {
    last_to_first_ratio(problem) < NEAR_ZERO
}

/// Mean of the last amplitudes (root mean square if they are squared) relative to the first one. A single
/// amplitude near the noise may be twice the level of those around it.
fn last_to_first_ratio(problem: &EnvelopeProblem) -> f64 {
    let n = problem.value.len();
    let last = &problem.value[n - n.div_ceil(LAST_PART)..];
    let ratio = last.iter().sum::<f64>() / last.len() as f64 / problem.value[0];
    if problem.squared { ratio.max(0.0).sqrt() } else { ratio }
}

/// If the amplitudes scatter about the full law by more than their noise, the law itself is in error by some
/// fraction of the amplitude. That fraction is added to the errors, so that the early amplitudes, known to
/// 1e-4, do not outweigh the late ones, which distinguish sliding from viscous loss. Returns whether an error
/// was added.
fn add_law_error(
    problem: &mut EnvelopeProblem,
    start: &[f64],
    (full, mut known): (&[usize], Option<Fit>),
    noise: f64,
    significance: f64,
    criteria: &AmplitudeCriteria,
) -> bool {
    let noise_weights = problem.weight.clone();
    let dof = problem.value.len() as f64 - full.len() as f64;
    if dof < 3.0 {
        return false;
    }
    // The end of the motion follows no friction law: the error never falls below that of a small amplitude.
    let base = (criteria.law_error_base * problem.value[0]).powi(2);
    let mut relative = 0.0;
    let mut from = start.to_vec();
    for _ in 0..WEIGHTINGS {
        let found = match relative {
            0.0 => known.take().or_else(|| fit_from_viscous(problem, &from, full)),
            _ => minimise(problem, &from, full),
        };
        let Some(fit) = found else { break };
        from.clone_from(&fit.parameters);
        // Squared residual, variance of the noise, squared amplitude.
        let parts: Vec<(f64, f64, f64)> = problem
            .residuals(&fit.parameters)
            .iter()
            .zip(&problem.weight)
            .zip(noise_weights.iter().zip(&problem.value))
            .map(|((r, w), (v, a))| (r * r / w, noise / v, a * a + base))
            .collect();
        let chi_squared =
            |e: f64| parts.iter().map(|(r, v, a)| r / (v + e * e * a).max(f64::MIN_POSITIVE)).sum::<f64>();
        if chi_squared(0.0) < dof + significance * (2.0 * dof).sqrt() {
            break;
        }
        let before = relative;
        (_, relative) = roots::border(0.0, 1.0, |e| chi_squared(e) > dof);
        for (w, (_, v, a)) in problem.weight.iter_mut().zip(&parts) {
            *w = noise.max(f64::MIN_POSITIVE) / (v + relative * relative * a).max(f64::MIN_POSITIVE);
        }
        if (relative - before).abs() < TOLERANCE * relative {
            break;
        }
    }
    relative > 0.0
}

/// Removes blocks that deviate from the full law by many robust standard deviations, and counts them. Also
/// returns the viscous and the full law fitted to the remaining blocks, if known.
fn drop_outliers(
    problem: &mut EnvelopeProblem,
    start: &[f64],
    full: &[usize],
    losses: &[usize],
    least_deviation: f64,
    criteria: &AmplitudeCriteria,
) -> (usize, Option<(Fit, Fit)>) {
    let mut dropped = 0;
    for _ in 0..ROUNDS {
        if problem.value.len() < full.len() + criteria.outlier_spare {
            break;
        }
        let Some(viscous) = viscous_law(problem, start) else { break };
        let Some(fit) = fit_from_given_viscous(problem, start, &viscous, full) else { break };
        let mut off = outliers(problem, &fit, least_deviation, criteria);
        if off.is_empty() && losses.iter().any(|&i| fit.parameters[i] < 0.0) {
            // With losses below zero the law bends towards the outliers.
            let within = constrained(problem, &fit, losses).map(Cow::into_owned);
            let afresh = || minimise_bounded(problem, start, full, losses, STEP_TOLERANCE);
            let Some(within) = within.or_else(afresh) else { break };
            off = outliers(problem, &within, least_deviation, criteria);
        }
        if off.is_empty() {
            return (dropped, Some((viscous, fit)));
        }
        dropped += off.len();
        retain(problem, |i| !off.contains(&i));
    }
    (dropped, None)
}

/// The amplitudes that deviate from a law by many robust standard deviations. None if there are many of them:
/// a law that misses many amplitudes is wrong, and they are evidence against it.
fn outliers(
    problem: &EnvelopeProblem,
    law: &Fit,
    least_deviation: f64,
    criteria: &AmplitudeCriteria,
) -> Vec<usize> {
    let residuals = problem.residuals_for_outliers(&law.parameters);
    let deviation = robust::deviation(residuals.iter().copied()).unwrap_or(0.0).max(least_deviation);
    let far = |r: f64| !(r.abs() <= criteria.outlier_deviations * deviation || deviation == 0.0);
    let mut off: Vec<usize> = (0..residuals.len()).filter(|&i| far(residuals[i])).collect();
    if off.len() * criteria.outlier_part > residuals.len() {
        off.clear();
    }
    off
}

/// Number of amplitudes before the averaged law ends, some cycles before the stop: at amplitudes of a few
/// `x_F` the motion is not an ellipse. `None` if all are before it.
fn end_of_law(
    problem: &EnvelopeProblem,
    start: &[f64],
    viscous: Option<Fit>,
    criteria: &AmplitudeCriteria,
) -> Option<usize> {
    let n = problem.value.len();
    if n < criteria.rest_blocks {
        return None;
    }
    let viscous = viscous.or_else(|| viscous_law(problem, start))?;
    let fit = fit_from_given_viscous(problem, start, &viscous, &[A0, DELTA, X_F])?;
    let least = criteria.least_frictions * fit.parameters[X_F];
    let kept = problem.amplitudes(&fit.parameters).iter().position(|&a| a < least)?;
    Some(kept.max(criteria.rest_kept)).filter(|kept| *kept < n)
}

/// Keeps the amplitudes whose index satisfies `keep`.
fn retain(problem: &mut EnvelopeProblem, keep: impl Fn(usize) -> bool) {
    for list in [&mut problem.elapsed, &mut problem.value, &mut problem.weight] {
        let mut index = 0..;
        list.retain(|_| index.next().is_some_and(&keep));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ringdown::direct::tests::noise;

    /// Motion sustained by a drive and switched on with a beat: losses below zero would fit that beat.
    #[test]
    fn amplitudes_off_a_law_without_gain_are_left_out() {
        let criteria = Criteria::default();
        let losses: Vec<usize> = LossTerm::compared(None).map(slot).collect();
        let full = loss_parameters(None);
        for seed in 0..20 {
            let mut value: Vec<f64> = (0..44).map(|i| 0.139 + 0.001 * noise(44 * seed + i)).collect();
            (value[0], value[1], value[2]) = (0.168, 0.142, 0.126);
            let mut problem = EnvelopeProblem {
                elapsed: (0..44).map(|i| 2.5 * i as f64).collect(),
                weight: vec![14.0; 44],
                value,
                omega: 2.48,
                backbone: [0.0; 2],
                squared: false,
                time_variance_s2: 0.0,
                lowpass: None,
            };
            let start = start_values(&problem);
            let (dropped, _) =
                drop_outliers(&mut problem, &start, &full, &losses, 0.0037, &criteria.amplitude);
            assert_eq!((dropped, problem.value[0]), (2, 0.142), "{seed}");
        }
    }
}

//! Limits of the free decay that become apparent once its law is known.

use super::StartReason;
use crate::inference::least_squares::minimise;
use crate::ringdown::amplitude_fit::{amplitude_problem, fit_from_viscous, start_values};
use crate::ringdown::compare::loss_parameters;
use crate::ringdown::criteria::{LeadInCriteria, WindowCriteria};
use crate::ringdown::envelope::EnvelopeProblem;
use crate::ringdown::measured::MeasuredDecay;
use crate::ringdown::options::Options;
use crate::ringdown::window_fit::{Problem, WindowFit};
use std::ops::Range;

/// Number of splits in the coarse search for a change of law.
const SPLITS: usize = 40;

/// The time until which the first blocks still belong to a drive. The law of the later blocks is extrapolated
/// with its uncertainty, and earlier blocks are accepted one by one until a run of them deviates. `None` if
/// none do.
pub(crate) fn end_of_lead_in(
    fitted: &WindowFit,
    measured: &MeasuredDecay,
    options: &Options,
    criteria: &LeadInCriteria,
) -> Option<f64> {
    let n = measured.points.len();
    if measured.window.start_reason != StartReason::LeadIn || n < criteria.least_blocks {
        return None;
    }
    // The weights use the noise alone: with an error of the law, a drive accepted by mistake would enlarge
    // its own tolerance.
    let problem = amplitude_problem(measured, options);
    let tested = n / criteria.tested_part;
    let best = &fitted.comparison.preferred()?.bounded;
    let free = &best.free;
    let fit = minimise(&part(&problem, tested..n), &best.parameters, free)?;
    let variance = fit.rss / (n - tested - free.len().min(n - tested - 1)) as f64;
    // If the law itself is in error, its extrapolation gives no evidence of a drive.
    if variance > criteria.most_excess * measured.noise_rms.powi(2) {
        return None;
    }
    let predictions = problem.predictions(&fit);
    // Mean residual of a run relative to its standard error, including the common uncertainty of the law.
    let deviation = |run: Range<usize>| {
        let (mut weight, mut sum, mut row) = (0.0, 0.0, vec![0.0; fit.parameters.len()]);
        for j in run {
            let (residual, by) = &predictions[j];
            let w = problem.weight[j];
            weight += w;
            sum += w * residual;
            for (r, b) in row.iter_mut().zip(by) {
                *r += w * b;
            }
        }
        let law: f64 = free
            .iter()
            .flat_map(|&a| free.iter().map(move |&b| (a, b)))
            .map(|(a, b)| row[a] * row[b] * fit.unit_covariance[(a, b)])
            .sum::<f64>()
            / (weight * weight);
        sum / weight / (variance * (1.0 / weight + law.max(0.0))).sqrt()
    };
    let off = |first: usize| {
        deviation(first..(first + criteria.run).min(tested)).abs() > criteria.run_errors
            || deviation(first..first + 1).abs() > criteria.block_errors
    };
    let start = (0..tested).rev().find(|&first| off(first))? + 1;
    // A law with deviations throughout is wrong; a drive affects the first blocks only.
    if start > n / criteria.most_part {
        return None;
    }
    // The deviation began some blocks before it became significant.
    let start = (start + (n / criteria.margin_part).max(2)).min(n - 6);
    Some(fitted.origin + problem.elapsed[start])
}

/// The time at which one law changes to another: the split after which each side has its own law. It is
/// accepted only if the residuals of the earlier side are then close to its noise, which is never the case
/// for a slowly bending law.
pub(crate) fn change_of_law(
    fitted: &WindowFit,
    measured: &MeasuredDecay,
    options: &Options,
    criteria: &WindowCriteria,
) -> Option<f64> {
    let noise = measured.noise_rms.powi(2);
    let n = measured.points.len();
    let least = criteria.kink_blocks;
    // Smaller deviations indicate a bend, not a kink.
    if fitted.excess < criteria.kink_excess || n < 2 * least || noise <= 0.0 {
        return None;
    }
    // Outliers that the fit leaves out would distort the laws here.
    if !matches!(&fitted.problem, Problem::Envelope(used) if used.value.len() == n) {
        return None;
    }
    let problem = amplitude_problem(measured, options);
    let losses = loss_parameters(options.model);
    let left = |range: Range<usize>| -> Option<f64> {
        let mut side = part(&problem, range);
        let origin = side.elapsed[0];
        side.elapsed.iter_mut().for_each(|t| *t -= origin);
        Some(fit_from_viscous(&side, &start_values(&side), &losses)?.rss / noise)
    };
    let best = |splits: &mut dyn Iterator<Item = usize>| {
        splits
            .filter_map(|k| Some((left(0..k)?, left(k..n)?, k)))
            .min_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1)))
            .map(|(earlier, _, k)| (earlier / (k as f64 - losses.len() as f64), k))
    };
    let step = (n / SPLITS).max(1);
    let (_, coarse) = best(&mut (least..n - least).step_by(step))?;
    let near = coarse.saturating_sub(step).max(least)..(coarse + step + 1).min(n - least);
    let (earlier, split) = best(&mut { near })?;
    (earlier < criteria.kink_earlier && fitted.excess > criteria.kink_gain * earlier)
        .then(|| fitted.origin + problem.elapsed[split])
}

/// A subset of the amplitudes.
fn part(problem: &EnvelopeProblem, range: Range<usize>) -> EnvelopeProblem {
    EnvelopeProblem {
        elapsed: problem.elapsed[range.clone()].to_vec(),
        value: problem.value[range.clone()].to_vec(),
        weight: problem.weight[range].to_vec(),
        omega: problem.omega,
        backbone: problem.backbone,
        squared: problem.squared,
        time_variance_s2: problem.time_variance_s2,
        lowpass: problem.lowpass.clone(),
    }
}

//! Where the free decay begins, once its law is known.

use super::amplitude_fit::fit_amplitudes;
use super::envelope::EnvelopeProblem;
use super::fits::{Described, Problem};
use super::measure::{self, Measured, Samples};
use super::options::Options;
use super::waveform_fit::{agrees, fit_samples};
use crate::inference::least_squares::minimise;

/// Gives back first blocks that still belong to a drive: from the law of the
/// later two thirds, extrapolated with its uncertainty, the blocks before are
/// let in one by one until a run of them falls out by four standard errors.
pub(crate) fn trim_lead_in(described: &Described, measured: &mut Measured) -> bool {
    let Problem::Envelope(problem) = &described.problem else { return false };
    // Weights of the noise alone: a drive let in by mistake would excuse itself as an error of the law.
    let problem = EnvelopeProblem {
        elapsed: measured.points.iter().map(|b| b.time_s - described.origin).collect(),
        value: measured
            .points
            .iter()
            .map(|b| if problem.squared { b.amplitude.powi(2) } else { b.amplitude })
            .collect(),
        weight: measured
            .points
            .iter()
            .map(|b| 1.0 / (b.unit_variance * if problem.squared { 4.0 * b.amplitude.powi(2) } else { 1.0 }))
            .collect(),
        ..problem.clone()
    };
    let n = problem.value.len();
    if measured.stretch.start_reason != super::segment::LEAD_IN || n < 60 {
        return false;
    }
    let from = n / 3;
    let later = EnvelopeProblem {
        elapsed: problem.elapsed[from..].to_vec(),
        value: problem.value[from..].to_vec(),
        weight: problem.weight[from..].to_vec(),
        ..problem.clone()
    };
    let Some(best) = described.comparison.preferred() else { return false };
    let free: Vec<usize> = best.bounded.free.clone();
    let Some(fit) = minimise(&later, &best.bounded.parameters, &free) else { return false };
    let variance = fit.rss / (n - from - free.len().min(n - from - 1)) as f64;
    // Where the law itself is off, its extrapolation says nothing about a drive.
    if !measured.squared && variance > 4.0 * measured.noise_rms.powi(2) {
        return false;
    }
    let predicted = problem.predictions(&fit);
    // Mean miss of a run over its standard error, the law's own uncertainty in common.
    let miss = |run: std::ops::Range<usize>| {
        let (mut weight, mut sum, mut row) = (0.0, 0.0, [0.0; 5]);
        for (j, (residual, by)) in predicted[run.clone()].iter().enumerate() {
            let w = problem.weight[run.start + j];
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
    let mut start = from;
    while start > 0 {
        let first = start - 1;
        let run = first..(first + 8).min(from);
        if miss(run).abs() > 4.0 || miss(first..first + 1).abs() > 4.5 {
            break;
        }
        start = first;
    }
    // A law that misses all the way is bent; a drive holds the first blocks only.
    if start == 0 || start > n / 6 {
        return false;
    }
    // The run that fell out began some blocks later than it showed.
    let start = (start + (n / 60).max(2)).min(n - 6);
    let cut_time = described.origin + problem.elapsed[start];
    measured.points.retain(|b| b.time_s >= cut_time - 1e-9 * b.span_s);
    true
}

/// What the amplitudes of single blocks made look like a lead-in may be their
/// noise: where one motion leaves nothing but noise from the first sample on,
/// that is the free decay.
pub(crate) fn from_the_first_sample<'a>(
    samples: &'a Samples,
    options: &Options,
    measured: &Measured,
) -> Option<(Measured, Described<'a>)> {
    let mut whole = measure::from_the_first_block(samples, measured)?;
    let rough = fit_amplitudes(&mut whole, options).ok()?;
    let described = fit_samples(samples, &whole, &rough)?;
    agrees(&described, samples, &whole).then_some((whole, described))
}

/// First blocks that still belong to a drive bend the law a little and hide in
/// it; one motion then no longer leaves nothing but noise. They are given up, a
/// few at a time and at most a quarter, until it does. `None` where none are in
/// the way, or where it never does: then the law is at fault.
pub(crate) fn past_the_lead_in<'a>(
    samples: &'a Samples,
    options: &Options,
    (measured, described): &(Measured, Described<'_>),
) -> Option<(Measured, Described<'a>)> {
    let n = measured.points.len();
    // Of a few blocks none can be spared.
    if n < 40 || agrees(described, samples, measured) {
        return None;
    }
    [50, 25, 16, 12, 8, 6, 4].into_iter().map(|part| n.div_ceil(part)).find_map(|gone| {
        let mut later = measured.clone();
        later.points.drain(..gone);
        let rough = fit_amplitudes(&mut later, options).ok()?;
        let described = fit_samples(samples, &later, &rough)?;
        agrees(&described, samples, &later).then_some((later, described))
    })
}

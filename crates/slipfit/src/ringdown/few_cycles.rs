//! Records of few cycles: the exact motion is fitted to every sample, from its own start values.
//!
//! They are too short for amplitudes of whole cycles, or contain a decay of fewer than
//! [`most_cycles`](FewCyclesCriteria::most_cycles) (8) cycles that the waveform fit started from its
//! amplitudes does not describe.

use super::compare::Models;
use super::criteria::{AgreementCriteria, Criteria, FewCyclesCriteria};
use super::envelope::{A0, DELTA, X_F, law_of};
use super::hypotheses::FittedDecay;
use super::measured::MeasuredDecay;
use super::samples::Samples;
use super::waveform::{COUNT, OFFSET, OMEGA, PHASE, RestLevel, Waveform};
use super::waveform_fit::fit_waveform;
use super::window::by_waveform::is_noise;
use super::window::{DecayWindow, EndReason, StartReason};
use super::window_fit::Problem;
use crate::inference::least_squares::{LeastSquares, Normal, minimise_until};
use crate::model::loss::LossModel;
use crate::numeric::order::sort_by_value;
use crate::numeric::robust::neighbour_noise;
use crate::signal::blocks::Block;
use crate::signal::phase::PhaseLaw;
use std::f64::consts::PI;

/// Maximum number of samples in the search for start values; more bring no gain.
const SEARCH_SAMPLES: usize = 400;
/// Maximum number of half cycles shown.
const MOST_HALF_CYCLES: i32 = 1000;

/// Fits the motion of a record of a few cycles, from its first sample or from its largest deflection on.
/// `None` if the fit does not describe the samples, or if the motion swings back too little to be called an
/// oscillation.
pub(crate) fn fit_few_cycles<'a>(
    samples: &'a Samples,
    asked: Option<LossModel>,
    criteria: &Criteria,
) -> Option<FittedDecay<'a>> {
    let c = &criteria.few_cycles;
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let n = signal.len();
    if n > c.most_samples {
        return None;
    }
    let tail = &signal[n - (n / c.tail_part).max(2)..];
    let rest = tail.iter().sum::<f64>() / tail.len() as f64;
    let release = (0..n).max_by(|&a, &b| (signal[a] - rest).abs().total_cmp(&(signal[b] - rest).abs()))?;
    let top = signal[release] - rest;
    let crossing = (release..n).find(|&i| (signal[i] - rest) * top <= 0.0)?;
    let quarter = time[crossing] - time[release];
    if n - release < c.least_samples || quarter <= 0.0 {
        return None;
    }
    let noise_rms = neighbour_noise(signal[release..].windows(3)).unwrap_or(0.0);
    let first_half_cycle = FirstHalfCycle { top, rest, quarter, noise_rms };
    // The largest sample is partly noise: the motion starts where the signal leaves that level.
    let leaves = (release..crossing)
        .rev()
        .find(|&i| (signal[i] - rest).abs() >= top.abs() - c.release_noise * noise_rms)
        .unwrap_or(release);
    let from_release = fit_from(samples, leaves, &first_half_cycle, asked, criteria)?;
    if leaves == 0 {
        return Some(from_release);
    }
    // Most records begin with the release, so their first samples are included if they agree.
    let whole = fit_from(samples, 0, &first_half_cycle, asked, criteria);
    let agreeing = whole.filter(|w| describes(w, &from_release, leaves, &criteria.agreement));
    agreeing.or(Some(from_release))
}

/// The first half cycle of a motion after its release.
struct FirstHalfCycle {
    /// Largest deflection, signed.
    top: f64,
    /// Rest position.
    rest: f64,
    /// Time from the largest deflection to the rest position, s.
    quarter: f64,
    noise_rms: f64,
}

/// Whether the residuals of the fit from the first sample are noise, both before and after `leaves`, compared
/// with the fit of the later samples.
fn describes(whole: &FittedDecay, later: &FittedDecay, leaves: usize, criteria: &AgreementCriteria) -> bool {
    let Problem::Waveform(problem) = &whole.fit.problem else { return false };
    let Some(best) = whole.fit.comparison.preferred() else { return false };
    let residual = problem.residuals(&best.bounded.parameters);
    let variance = later.measured.noise_rms.powi(2);
    residual.len() > leaves
        && is_noise(&residual[..leaves], variance, criteria)
        && is_noise(&residual[leaves..], variance, criteria)
}

/// The fit of the motion from sample `release` on.
fn fit_from<'a>(
    samples: &'a Samples,
    release: usize,
    first_half_cycle: &FirstHalfCycle,
    asked: Option<LossModel>,
    criteria: &Criteria,
) -> Option<FittedDecay<'a>> {
    let c = &criteria.few_cycles;
    let n = samples.len();
    let count = (n - release) as f64;
    if n - release < c.least_samples {
        return None;
    }
    let start = start_values(samples, release, first_half_cycle)?;
    let mut measured = MeasuredDecay {
        all: Vec::new(),
        window: DecayWindow {
            first: 0,
            end: 0,
            start_reason: if release == 0 { StartReason::RecordStart } else { StartReason::LeadIn },
            end_reason: EndReason::RecordEnd,
            disturbed: false,
        },
        points: Vec::new(),
        law: PhaseLaw { omega: start[OMEGA], mean_omega: start[OMEGA], ..PhaseLaw::default() },
        phase_follows_law: true,
        noise_rms: first_half_cycle.noise_rms,
        root_mean_squares: false,
        time_variance_s2: 0.0,
        periodogram: None,
    };
    let mut fit = fit_waveform(samples, &measured, release..n, start, (asked, Models::All), criteria)?;
    let best = fit.comparison.preferred()?.bounded.clone();
    let p = &best.parameters;
    let sigma = (best.rss / count).sqrt();
    let law = law_of(p, p[OMEGA]);
    let duration = fit.end - fit.origin;
    let back = law.amplitude(PI / p[OMEGA]);
    let visible = c.return_errors * sigma / (first_half_cycle.quarter / duration * count).sqrt();
    if sigma > c.most_residual * first_half_cycle.noise_rms || back < c.least_return * p[A0] || back < visible
    {
        return None;
    }
    let Problem::Waveform(problem) = &fit.problem else { return None };
    measured.points = half_cycles(problem, p, release, sigma, c);
    // Differences of neighbouring samples overestimate the noise if there are few samples per cycle.
    measured.noise_rms = sigma.min(first_half_cycle.noise_rms);
    // There are no blocks from which to compute the residual fundamental.
    fit.excess = (sigma / measured.noise_rms).powi(2);
    fit.excess_freedom = (count - best.free.len() as f64).max(1.0);
    if p[X_F] > 0.0 && law.stop_time_s().is_some_and(|stop| stop < duration) {
        measured.window.end_reason = EndReason::Rest;
    }
    measured.all.clone_from(&measured.points);
    measured.window.end = measured.points.len();
    (measured.points.len() >= 2).then_some(FittedDecay { measured, fit })
}

/// The best of a coarse grid of frequencies, decay rates and frictions, each of which is fitted.
fn start_values(samples: &Samples, release: usize, first_half_cycle: &FirstHalfCycle) -> Option<Vec<f64>> {
    let (time, signal) = (&samples.time[release..], &samples.signal[release..]);
    let &FirstHalfCycle { top, rest, quarter, .. } = first_half_cycle;
    let stride = (time.len() / SEARCH_SAMPLES).max(1);
    let thin = |v: &[f64]| v.iter().step_by(stride).copied().collect::<Vec<f64>>();
    let (time, signal) = (thin(time), thin(signal));
    let free = [A0, X_F, DELTA, PHASE, OMEGA, OFFSET];
    let problem = Waveform {
        time: &time,
        signal: &signal,
        observable: samples.observable,
        guard: None,
        origin: time[0],
        duration: time[time.len() - 1] - time[0],
        backbone: None,
        rest: RestLevel::Exact,
        rounding_rms: 0.0,
        active: free.to_vec(),
        gathered: None,
    };
    let mut starts = Vec::new();
    for slower in [0.8, 1.0, 1.25] {
        let omega = PI / (2.0 * quarter * slower);
        for damping in [0.02, 0.1, 0.3] {
            for friction in [0.0, 0.05, 0.15] {
                let mut start = vec![0.0; COUNT];
                start[A0] = top.abs();
                start[X_F] = friction * top.abs();
                start[DELTA] = damping * omega;
                start[PHASE] = if top > 0.0 { 0.0 } else { PI } - samples.observable.phase_lead();
                start[OMEGA] = omega;
                start[OFFSET] = rest;
                starts.push(start);
            }
        }
    }
    let mut sums = Normal::zeros(COUNT);
    let mut rss = |p: &[f64]| problem.normal_of(p, &[], &mut sums, f64::INFINITY).then_some(sums.rss);
    let mut ranked: Vec<(f64, Vec<f64>)> =
        starts.into_iter().map(|start| (rss(&start).unwrap_or(f64::INFINITY), start)).collect();
    sort_by_value(&mut ranked, |r| r.0);
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut found_again = 0;
    for (_, start) in ranked {
        let Some(fit) = minimise_until(&problem, &start, &free, SEARCH_TOLERANCE, true) else { continue };
        let lowest = best.as_ref().map_or(f64::INFINITY, |b| b.0);
        if (fit.rss / lowest - 1.0).abs() < SAME_MINIMUM {
            found_again += 1;
        } else if fit.rss < lowest {
            found_again = 0;
        }
        if fit.rss < lowest {
            best = Some((fit.rss, fit.parameters));
        }
        if found_again == SAME_MINIMUM_COUNT {
            break;
        }
    }
    best.map(|b| b.1)
}

/// Tolerance, in standard errors, to which a start is fitted: the result serves only as a start for the fits
/// of the models.
const SEARCH_TOLERANCE: f64 = 0.1;
/// Relative difference of sums of squares that belong to the same minimum, and how often it must be found
/// again to end the search.
const SAME_MINIMUM: f64 = 1e-3;
const SAME_MINIMUM_COUNT: usize = 4;

/// Amplitudes of the half cycles, measured along the fitted motion.
fn half_cycles(
    problem: &Waveform,
    p: &[f64],
    first: usize,
    sigma: f64,
    criteria: &FewCyclesCriteria,
) -> Vec<Block> {
    let law = law_of(p, p[OMEGA]);
    let half = PI / p[OMEGA];
    let residual = problem.residuals(p);
    let mut blocks: Vec<Block> = Vec::new();
    // At the limits of the parameters the model may not exist.
    if residual.iter().any(|r| r.is_nan()) {
        return blocks;
    }
    let mut from = 0;
    let mut index = 0;
    while from < residual.len() {
        index += 1;
        let limit = problem.origin + f64::from(index) * half;
        let to = from + problem.time[from..].partition_point(|&t| t < limit);
        let middle = (f64::from(index) - 0.5) * half;
        let amplitude = law.amplitude(middle);
        if amplitude <= 0.0 || index > MOST_HALF_CYCLES {
            break;
        }
        if to - from >= criteria.half_cycle_samples {
            let model: Vec<f64> = (from..to).map(|i| problem.signal[i] - residual[i] - p[OFFSET]).collect();
            let power: f64 = model.iter().map(|m| m * m).sum();
            let gain: f64 = model.iter().zip(&residual[from..to]).map(|(m, r)| m * r).sum::<f64>() / power;
            let rss: f64 = residual[from..to].iter().map(|r| r * r).sum();
            blocks.push(Block {
                first: first + from,
                end: first + to,
                time_s: problem.origin + middle,
                span_s: half,
                amplitude: amplitude * (1.0 + gain),
                quadrature: 0.0,
                phase: p[PHASE] + problem.observable.phase_lead() + p[OMEGA] * middle,
                omega: p[OMEGA],
                offset: p[OFFSET],
                unit_variance: amplitude * amplitude / power.max(f64::MIN_POSITIVE),
                rss,
                dof: (to - from) as f64,
            });
        }
        from = to.max(from + 1);
        if sigma > 0.0 && amplitude < criteria.half_cycle_noise * sigma {
            break;
        }
    }
    blocks
}

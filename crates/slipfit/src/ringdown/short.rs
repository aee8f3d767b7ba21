//! Records of one to three cycles: too short for amplitudes of whole cycles,
//! long enough for the exact motion to be fitted to every sample.

use super::envelope::{A0, DELTA, X_F, law_of};
use super::fits::{Described, Problem};
use super::measure::{Measured, Samples};
use super::segment::{LEAD_IN, RECORD_END, RECORD_START, REST, Stretch};
use super::waveform::{COUNT, OFFSET, OMEGA, PHASE, Waveform};
use super::waveform_fit::fit_waveform_window;
use crate::inference::least_squares::minimise;
use crate::numeric::robust::neighbour_noise;
use crate::signal::blocks::Block;
use crate::signal::phase::PhaseLaw;
use std::f64::consts::PI;

/// Longest record looked at: the search tries many starts.
const MOST: usize = 20_000;

/// Fits the motion from its largest deflection on. `None` where it does not
/// describe the samples, or swings back too little to be called an oscillation.
pub(crate) fn short<'a>(samples: &'a Samples) -> Option<(Measured, Described<'a>)> {
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let n = signal.len();
    if n > MOST {
        return None;
    }
    let tail = &signal[n - (n / 10).max(2)..];
    let rest = tail.iter().sum::<f64>() / tail.len() as f64;
    let release = (0..n).max_by(|&a, &b| (signal[a] - rest).abs().total_cmp(&(signal[b] - rest).abs()))?;
    let top = signal[release] - rest;
    let crossing = (release..n).find(|&i| (signal[i] - rest) * top <= 0.0)?;
    let quarter = time[crossing] - time[release];
    if n - release < 12 || quarter <= 0.0 {
        return None;
    }
    let noise = neighbour_noise(signal[release..].windows(3)).unwrap_or(0.0);
    // The largest sample owes part of its size to the noise: begin where the motion leaves it.
    let leaves = (release..crossing)
        .rev()
        .find(|&i| (signal[i] - rest).abs() >= top.abs() - 2.0 * noise)
        .unwrap_or(release);
    match begun_at(samples, leaves, (top, rest, quarter), noise) {
        // Most records begin with the release: their first samples count as well.
        Some(later) if leaves > 0 => {
            let whole = begun_at(samples, 0, (top, rest, quarter), noise)
                .filter(|whole| describes(whole, &later, leaves));
            whole.or(Some(later))
        }
        found => found,
    }
}

/// Whether the fit from the first sample on leaves no more of the samples
/// before `leaves` than noise, and of the later ones no more than their own fit.
fn describes(whole: &(Measured, Described<'_>), later: &(Measured, Described<'_>), leaves: usize) -> bool {
    let Problem::Waveform(problem) = &whole.1.problem else { return false };
    let Some(best) = whole.1.comparison.preferred() else { return false };
    let residual = problem.residuals(&best.bounded.parameters);
    let variance = later.0.noise_rms.powi(2);
    let calm = |r: &[f64]| {
        let n = r.len() as f64;
        r.iter().map(|r| r * r).sum::<f64>() / n <= variance * (1.0 + 4.0 * (2.0 / n).sqrt())
    };
    residual.len() > leaves && calm(&residual[..leaves]) && calm(&residual[leaves..])
}

/// The motion from sample `release` on, fitted.
fn begun_at<'a>(
    samples: &'a Samples,
    release: usize,
    (top, rest, quarter): (f64, f64, f64),
    noise: f64,
) -> Option<(Measured, Described<'a>)> {
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let n = signal.len();
    if n - release < 12 {
        return None;
    }
    let origin = time[release];
    let duration = time[n - 1] - origin;
    let start = best_start(&time[release..], &signal[release..], top, rest, quarter)?;
    let mut measured = Measured {
        all: Vec::new(),
        stretch: Stretch {
            first: 0,
            end: 0,
            start_reason: if release == 0 { RECORD_START } else { LEAD_IN },
            end_reason: RECORD_END,
            slow_tail: false,
            disturbed: false,
        },
        points: Vec::new(),
        law: PhaseLaw { omega: start[OMEGA], mean_omega: start[OMEGA], ..PhaseLaw::default() },
        lawful: true,
        noise_rms: noise,
        squared: false,
    };
    let described = fit_waveform_window(samples, &measured, release..n, origin, duration, start)?;
    let best = &described.comparison.preferred()?.bounded;
    let sigma = (best.rss / (n - release) as f64).sqrt();
    let p = best.parameters.clone();
    let law = law_of(&p, p[OMEGA]);
    let back = law.amplitude(PI / p[OMEGA]);
    let visible = 3.0 * sigma / (quarter / duration * (n - release) as f64).sqrt();
    if sigma > 2.0 * noise || back < 0.2 * p[A0] || back < visible {
        return None;
    }
    let Problem::Waveform(problem) = &described.problem else { return None };
    measured.points = half_cycles(problem, &p, release, sigma);
    measured.noise_rms = sigma;
    if p[X_F] > 0.0 && law.stop_time() < duration {
        measured.stretch.end_reason = REST;
    }
    measured.all.clone_from(&measured.points);
    measured.stretch.end = measured.points.len();
    (measured.points.len() >= 2).then_some((measured, described))
}

/// The best of a coarse net of frequencies, decay rates and frictions, each fitted.
fn best_start(time: &[f64], signal: &[f64], top: f64, rest: f64, quarter: f64) -> Option<Vec<f64>> {
    let stride = (time.len() / 400).max(1);
    let thin = |v: &[f64]| v.iter().step_by(stride).copied().collect::<Vec<f64>>();
    let (time, signal) = (thin(time), thin(signal));
    let free = [A0, X_F, DELTA, PHASE, OMEGA, OFFSET];
    let problem = Waveform {
        time: &time,
        signal: &signal,
        origin: time[0],
        duration: time[time.len() - 1] - time[0],
        bend: None,
        rest_tells: true,
        active: free.to_vec(),
    };
    let mut best: Option<(f64, Vec<f64>)> = None;
    for stretch in [0.8, 1.0, 1.25] {
        let omega = PI / (2.0 * quarter * stretch);
        for damping in [0.02, 0.1, 0.3] {
            for friction in [0.0, 0.05, 0.15] {
                let mut start = vec![0.0; COUNT];
                start[A0] = top.abs();
                start[X_F] = friction * top.abs();
                start[DELTA] = damping * omega;
                start[PHASE] = if top > 0.0 { 0.0 } else { PI };
                start[OMEGA] = omega;
                start[OFFSET] = rest;
                let Some(fit) = minimise(&problem, &start, &free) else { continue };
                if best.as_ref().is_none_or(|b| fit.rss < b.0) {
                    best = Some((fit.rss, fit.parameters));
                }
            }
        }
    }
    best.map(|b| b.1)
}

/// Amplitudes of the half cycles, measured along the fitted motion.
fn half_cycles(problem: &Waveform, p: &[f64], first: usize, sigma: f64) -> Vec<Block> {
    let law = law_of(p, p[OMEGA]);
    let half = PI / p[OMEGA];
    let residual = problem.residuals(p);
    let mut blocks: Vec<Block> = Vec::new();
    let mut from = 0;
    let mut index = 0;
    while from < residual.len() {
        index += 1;
        let limit = problem.origin + f64::from(index) * half;
        let to = from + problem.time[from..].partition_point(|&t| t < limit);
        let middle = (f64::from(index) - 0.5) * half;
        let amplitude = law.amplitude(middle);
        if amplitude <= 0.0 || index > 1000 {
            break;
        }
        if to - from >= 3 {
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
                phase: p[PHASE] + p[OMEGA] * middle,
                omega: p[OMEGA],
                offset: p[OFFSET],
                unit_variance: amplitude * amplitude / power.max(f64::MIN_POSITIVE),
                rss,
                dof: (to - from) as f64,
            });
        }
        from = to.max(from + 1);
        if sigma > 0.0 && amplitude < 0.3 * sigma {
            break;
        }
    }
    blocks
}

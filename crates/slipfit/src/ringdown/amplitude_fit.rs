//! The amplitudes of the blocks against the loss laws.

use super::compare::compare;
use super::envelope::{A0, DELTA, EnvelopeProblem, FLOOR, X_F};
use super::fits::{Described, FULL, Problem};
use super::lowpass::Kernel;
use super::measure::Measured;
use super::options::Options;
use crate::Error;
use crate::inference::least_squares::minimise;
use crate::inference::noise::{NoiseModel, autocorrelation, significant_inflation};
use crate::numeric::{robust::deviation, roots::border};
use std::f64::consts::PI;

/// Fits the amplitudes of the blocks.
pub(crate) fn fit_amplitudes<'a>(measured: &mut Measured, options: &Options) -> Result<Described<'a>, Error> {
    let points = &measured.points;
    if points.len() < 3 {
        return Err(Error::NoFit { reason: "fewer than three amplitudes of a falling oscillation remain" });
    }
    let origin = points[0].time_s - 0.5 * points[0].span_s;
    let omega = if measured.law.drift == 0.0 { measured.law.omega } else { measured.law.mean_omega };
    let mut problem = EnvelopeProblem {
        elapsed: points.iter().map(|b| b.time_s - origin).collect(),
        value: points
            .iter()
            .map(|b| if measured.squared { b.amplitude * b.amplitude } else { b.amplitude })
            .collect(),
        weight: points.iter().map(|b| 1.0 / b.unit_variance).collect(),
        omega,
        backbone: measured.law.backbone(),
        squared: measured.squared,
        lowpass: options.lockin.map(Kernel::new),
    };
    if measured.squared {
        // var(R²) = 4 sigma² (A² + sigma²): in units of sigma², and never less than the late scatter.
        let floor = 0.01 * problem.value[0].max(f64::MIN_POSITIVE) * 1e-4;
        for (w, v) in problem.weight.iter_mut().zip(&problem.value) {
            *w /= 4.0 * v.max(floor);
        }
    }
    let nuisance: &[usize] = if measured.squared && has_floor(measured) { &[FLOOR] } else { &[] };
    let start = envelope_start(&problem);
    let full: Vec<usize> = FULL.iter().chain(nuisance).copied().collect();
    let outliers = drop_outliers(&mut problem, &start, &full, measured);
    if !measured.squared {
        stop_short_of_rest(&mut problem, &start, measured);
    }
    let n = problem.value.len();
    if n < 3 {
        return Err(Error::NoFit { reason: "fewer than three amplitudes of a falling oscillation remain" });
    }
    let noise = (!measured.squared).then(|| measured.noise_rms.powi(2));
    let noise_weights = problem.weight.clone();
    let law_error = admit_law_error(&mut problem, &start, &full, measured.noise_rms.powi(2));
    let mut model = NoiseModel::white(n as f64);
    let comparison = compare(&problem, &start, nuisance, model, sliding_start(&problem));
    let best = comparison.preferred().ok_or(Error::NoFit { reason: "no model converged" })?;
    let residuals = problem.residuals(&best.bounded.parameters);
    let dof = (n as f64 - best.bounded.free.len() as f64).max(1.0);
    // Against the noise alone, whatever the law was forgiven.
    let chi_squared: f64 =
        residuals.iter().zip(&problem.weight).zip(&noise_weights).map(|((r, w), v)| r * r / w * v).sum();
    let excess = noise.map_or(1.0, |v| (chi_squared / dof / v.max(f64::MIN_POSITIVE)).min(f64::MAX.sqrt()));
    if noise.is_some() && law_error == 0.0 && (excess - 1.0).abs() < 2.6 * (2.0 / dof).sqrt() {
        model.known_variance = noise;
    }
    let autocorrelation = autocorrelation(&residuals);
    model.variance_inflation = significant_inflation(autocorrelation, n);
    let last = measured.points[measured.points.len() - 1];
    let end = last.time_s + 0.5 * last.span_s;
    Ok(Described {
        problem: Problem::Envelope(problem),
        comparison: comparison.with_noise(model),
        origin,
        end,
        excess,
        autocorrelation,
        outliers,
    })
}

/// Where the amplitudes scatter about the full law by more than their noise,
/// the law itself is off by some part of the amplitude: that part joins the
/// errors, so that the early amplitudes, known to 1e-4, do not drown the late
/// ones, which tell sliding from viscous loss. Returns the relative error.
fn admit_law_error(problem: &mut EnvelopeProblem, start: &[f64], full: &[usize], noise: f64) -> f64 {
    let noise_weights = problem.weight.clone();
    let n = problem.value.len();
    let dof = n as f64 - full.len() as f64;
    if dof < 3.0 {
        return 0.0;
    }
    // The law errs by a part of the amplitude, but never by less than that part
    // of a twentieth of the first one: what ends the motion is no friction law.
    let base = (0.05 * problem.value[0]).powi(2);
    let mut relative = 0.0;
    let mut from = start.to_vec();
    for _ in 0..4 {
        let Some(fit) = minimise(problem, &from, &[A0, DELTA])
            .filter(|_| relative == 0.0)
            .or_else(|| minimise(problem, &from, full))
            .and_then(|v| minimise(problem, &v.parameters, full).or(Some(v)))
        else {
            return relative;
        };
        from.clone_from(&fit.parameters);
        let misses: Vec<(f64, f64, f64)> = problem
            .residuals(&fit.parameters)
            .iter()
            .zip(&problem.weight)
            .zip(noise_weights.iter().zip(&problem.value))
            .map(|((r, w), (v, a))| (r * r / w, noise / v, a * a + base))
            .collect();
        let chi_squared =
            |e: f64| misses.iter().map(|(r, v, a)| r / (v + e * e * a).max(f64::MIN_POSITIVE)).sum::<f64>();
        if chi_squared(0.0) < dof + 2.6 * (2.0 * dof).sqrt() {
            break;
        }
        let (_, high) = border(0.0, 1.0, |e| chi_squared(e) > dof);
        let before = relative;
        relative = high;
        for ((w, v), (_, _, a)) in problem.weight.iter_mut().zip(&noise_weights).zip(&misses) {
            *w = noise.max(f64::MIN_POSITIVE) / (noise / v + high * high * a).max(f64::MIN_POSITIVE);
        }
        if (relative - before).abs() < 0.05 * relative {
            break;
        }
    }
    relative
}

fn has_floor(measured: &Measured) -> bool {
    // The floor shows where the record goes on below the last amplitude used, or falls far.
    let top = measured.points[0].amplitude;
    measured.points[measured.points.len() - 1].amplitude < 0.2 * top
}

fn envelope_start(problem: &EnvelopeProblem) -> Vec<f64> {
    let root = |v: f64| if problem.squared { v.max(0.0).sqrt() } else { v };
    let first = root(problem.value[0]).max(f64::MIN_POSITIVE);
    // Decay rate over the upper half of the fall, where every law is an exponential.
    let j =
        problem.value.iter().position(|&v| root(v) < 0.5 * first).unwrap_or(problem.value.len() - 1).max(1);
    let span = problem.elapsed[j] - problem.elapsed[0];
    let delta = (first / root(problem.value[j]).max(1e-3 * first)).ln() / span.max(f64::MIN_POSITIVE);
    let amplitude = first * (delta * problem.elapsed[0]).exp();
    vec![amplitude, 0.0, delta.max(1e-12 / span.max(f64::MIN_POSITIVE)), 0.0, 0.0]
}

/// Friction displacement that alone would explain the mean fall.
fn sliding_start(problem: &EnvelopeProblem) -> f64 {
    let start = envelope_start(problem);
    0.5 * start[A0] * start[DELTA] * PI / (2.0 * problem.omega)
}

/// Takes out blocks further than eight robust standard deviations from the full law.
fn drop_outliers(problem: &mut EnvelopeProblem, start: &[f64], full: &[usize], measured: &Measured) -> usize {
    let mut dropped = 0;
    for _ in 0..3 {
        if problem.value.len() < full.len() + 6 {
            break;
        }
        let Some(viscous) = minimise(problem, start, &[A0, DELTA]) else { break };
        let fit = minimise(problem, &viscous.parameters, full).unwrap_or(viscous);
        let residuals = problem.residuals(&fit.parameters);
        let robust = deviation(residuals.iter().copied()).unwrap_or(0.0).max(if measured.squared {
            0.0
        } else {
            measured.noise_rms
        });
        let keep: Vec<bool> = residuals.iter().map(|r| r.abs() <= 8.0 * robust || robust == 0.0).collect();
        let gone = keep.iter().filter(|k| !**k).count();
        // A law that misses many is wrong; its outliers are evidence.
        if gone == 0 || gone * 10 > keep.len() {
            break;
        }
        dropped += gone;
        for list in [&mut problem.elapsed, &mut problem.value, &mut problem.weight] {
            let mut k = keep.iter();
            list.retain(|_| k.next().copied().unwrap_or(true));
        }
    }
    dropped
}

/// The averaged law ends some cycles before the stop: below two x_F the motion is no ellipse.
fn stop_short_of_rest(problem: &mut EnvelopeProblem, start: &[f64], measured: &mut Measured) {
    if problem.value.len() < 8 {
        return;
    }
    let Some(fit) = minimise(problem, start, &[A0, DELTA])
        .and_then(|v| minimise(problem, &v.parameters, &[A0, DELTA, X_F]))
    else {
        return;
    };
    let x_f = fit.parameters[X_F];
    let n = problem.value.len();
    let amplitudes = problem.amplitudes(&fit.parameters);
    let keep = amplitudes.iter().position(|&a| a < 2.0 * x_f).unwrap_or(n).max(6.min(n));
    if keep < n {
        let last = problem.elapsed[keep - 1];
        for list in [&mut problem.elapsed, &mut problem.value, &mut problem.weight] {
            list.truncate(keep);
        }
        let origin = measured.points[0].time_s - 0.5 * measured.points[0].span_s;
        let points =
            measured.points.iter().take_while(|b| b.time_s - origin <= last + 1e-9 * b.span_s).count();
        measured.points.truncate(points.max(1));
    }
}

/// The instant where one law gives way to another: the split after which each
/// side has a law of its own. It counts only if the earlier side then holds
/// nearly to its noise, which a law that bends slowly away never does.
pub(crate) fn change_of_law(described: &Described, measured: &Measured) -> Option<f64> {
    let Problem::Envelope(problem) = &described.problem else { return None };
    let noise = measured.noise_rms.powi(2);
    let n = problem.value.len();
    // Ten times the noise and thirty blocks a side: less is a bend, not a kink.
    if described.excess < 100.0 || n < 60 || problem.squared || noise <= 0.0 {
        return None;
    }
    let full = |from: usize, to: usize| -> Option<f64> {
        let origin = problem.elapsed[from];
        let part = EnvelopeProblem {
            elapsed: problem.elapsed[from..to].iter().map(|t| t - origin).collect(),
            value: problem.value[from..to].to_vec(),
            weight: measured.points[from..to].iter().map(|b| 1.0 / b.unit_variance).collect(),
            ..problem.clone()
        };
        let start = envelope_start(&part);
        let viscous = minimise(&part, &start, &[A0, DELTA])?;
        Some(
            minimise(&part, &viscous.parameters, &FULL).map_or(viscous.rss, |f| f.rss.min(viscous.rss))
                / noise,
        )
    };
    // Blocks left out as outliers would shift the two lists against each other.
    if measured.points.len() != n {
        return None;
    }
    let least = 30;
    let step = (n / 40).max(1);
    let best = |splits: &mut dyn Iterator<Item = usize>| {
        splits
            .filter_map(|k| Some((full(0, k)?, full(k, n)?, k)))
            .min_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1)))
            .map(|(first, _, k)| (first / (k as f64 - 4.0), k))
    };
    let (_, coarse) = best(&mut (least..n - least).step_by(step))?;
    let near = coarse.saturating_sub(step).max(least)..(coarse + step + 1).min(n - least);
    let (first, split) = best(&mut { near })?;
    (first < 4.0 && described.excess > 5.0 * first).then(|| described.origin + problem.elapsed[split])
}

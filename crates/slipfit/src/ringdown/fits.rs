//! Which description carries the answer: the amplitudes of the blocks with the
//! phase left free, or every sample against the exact motion.

use super::compare::{Comparison, Scale, compare};
use super::envelope::{A0, DELTA, DRAG, EnvelopeProblem, FLOOR, X_F};
use super::lowpass::Kernel;
use super::measure::{Measured, Samples};
use super::options::Options;
use super::waveform::{BEND, Bend, CHIRP, COUNT, OFFSET, OMEGA, PHASE, Waveform};
use crate::Error;
use crate::estimate::least_squares::{Fit, LeastSquares, Normal, minimise, promised_gain};
use crate::signal::blocks::{self, Block};
use std::f64::consts::PI;

/// The data as one least-squares problem, all models fitted to it.
pub(crate) struct Described<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) comparison: Comparison,
    pub(crate) scale: Scale,
    /// Window start the parameters refer to, s.
    pub(crate) origin: f64,
    pub(crate) end: f64,
    /// Residual variance of the fundamental over that of the noise.
    pub(crate) excess: f64,
    pub(crate) autocorrelation: f64,
    /// Blocks left out because they lie far off every law.
    pub(crate) outliers: usize,
}

/// Either description.
pub(crate) enum Problem<'a> {
    /// Amplitudes of blocks.
    Envelope(EnvelopeProblem),
    /// Every sample.
    Waveform(Waveform<'a>),
}

impl Problem<'_> {
    pub(crate) fn least_squares(&self) -> &dyn LeastSquares {
        match self {
            Problem::Envelope(p) => p,
            Problem::Waveform(p) => p,
        }
    }

    pub(crate) fn method(&self) -> &'static str {
        match self {
            Problem::Envelope(_) => "envelope",
            Problem::Waveform(_) => "waveform",
        }
    }
}

const FULL: [usize; 4] = [A0, X_F, DELTA, DRAG];

/// Fits the amplitudes of the blocks.
pub(crate) fn envelope<'a>(measured: &mut Measured, options: &Options) -> Result<Described<'a>, Error> {
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
    let mut scale = Scale { observations: n as f64, variance: None, widening: 1.0 };
    let comparison = compare(&problem, &start, nuisance, scale, sliding_start(&problem));
    let best = comparison.best().ok_or(Error::NoFit { reason: "no model converged" })?;
    let residuals = problem.residuals(&best.bounded.parameters);
    let dof = (n as f64 - best.bounded.free.len() as f64).max(1.0);
    // Against the noise alone, whatever the law was forgiven.
    let chi_squared: f64 =
        residuals.iter().zip(&problem.weight).zip(&noise_weights).map(|((r, w), v)| r * r / w * v).sum();
    let excess = noise.map_or(1.0, |v| (chi_squared / dof / v.max(f64::MIN_POSITIVE)).min(f64::MAX.sqrt()));
    if noise.is_some() && law_error == 0.0 && (excess - 1.0).abs() < 2.6 * (2.0 / dof).sqrt() {
        scale.variance = noise;
    }
    let autocorrelation = first_autocorrelation(&residuals);
    scale.widening = widening(autocorrelation, n);
    let last = measured.points[measured.points.len() - 1];
    let end = last.time_s + 0.5 * last.span_s;
    let comparison = rescored(comparison, scale);
    Ok(Described {
        problem: Problem::Envelope(problem),
        comparison,
        scale,
        origin,
        end,
        excess,
        autocorrelation,
        outliers,
    })
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
        let (mut low, mut high) = (0.0f64, 1.0f64);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if chi_squared(middle) > dof { low = middle } else { high = middle }
        }
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
    let Some(best) = described.comparison.best() else { return false };
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

fn has_floor(measured: &Measured) -> bool {
    // The floor shows where the record goes on below the last amplitude used, or falls far.
    let top = measured.points[0].amplitude;
    measured.points[measured.points.len() - 1].amplitude < 0.2 * top
}

fn rescored(mut comparison: Comparison, scale: Scale) -> Comparison {
    for entry in &mut comparison.entries {
        entry.bic = scale.bic(entry.bounded.rss, entry.fit.free.len());
    }
    comparison
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
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let robust =
            (sizes[sizes.len() / 2] / 0.674_49).max(if measured.squared { 0.0 } else { measured.noise_rms });
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

pub(crate) fn first_autocorrelation(residuals: &[f64]) -> f64 {
    let n = residuals.len() as f64;
    let mean = residuals.iter().sum::<f64>() / n;
    let (mut c0, mut c1) = (0.0, 0.0);
    for (i, r) in residuals.iter().enumerate() {
        c0 += (r - mean).powi(2);
        if i > 0 {
            c1 += (r - mean) * (residuals[i - 1] - mean);
        }
    }
    if c0 > 0.0 { c1 / c0 } else { 0.0 }
}

/// Variance factor of an AR(1) residual on a slowly varying derivative; one unless significant.
pub(crate) fn widening(autocorrelation: f64, n: usize) -> f64 {
    if autocorrelation > 2.6 / (n as f64).sqrt() {
        let r = autocorrelation.min(0.95);
        (1.0 + r) / (1.0 - r)
    } else {
        1.0
    }
}

/// Longest window fitted sample by sample; beyond it the blocks hold the same information.
const MOST_SAMPLES: usize = 300_000;

/// With less lost per cycle the motion is an ellipse to 1e-4 and the blocks lose nothing either.
const LEAST_LOSS_A_CYCLE: f64 = 1e-3;

/// Fits every sample, starting from what the amplitudes told. `None` where the
/// waveform cannot be followed.
pub(crate) fn waveform<'a>(
    samples: &'a Samples,
    measured: &Measured,
    rough: &Described,
) -> Option<Described<'a>> {
    let first = measured.points.first()?;
    let last = measured.points.last()?;
    let (from, to) = (first.first, last.end);
    let best = rough.comparison.best()?;
    let law = super::envelope::law_of(&best.bounded.parameters, measured.law.omega);
    let loss_per_cycle = law.rate(law.amplitude_0) / law.amplitude_0 * 2.0 * PI / measured.law.omega;
    if to - from > MOST_SAMPLES || !measured.lawful || loss_per_cycle < LEAST_LOSS_A_CYCLE {
        return None;
    }
    // A record that ends in free decay is used to its last sample, not its last whole block.
    let ends_free = measured.all.last().is_some_and(|b| b.end == last.end);
    let to = if ends_free { samples.time.len() } else { to };
    let origin = samples.time[from];
    let duration = samples.time[to - 1] - origin;
    let from_envelope = |p: &[f64]| -> Vec<f64> {
        let mut start = vec![0.0; COUNT];
        start[..4].copy_from_slice(&p[..4]);
        start[OMEGA] = measured.law.omega;
        // Phase at the origin from the first block's, with the backbone on the way.
        start[PHASE] = blocks::wrap(first.phase - first.omega * (first.time_s - origin));
        start[OFFSET] = measured.points.iter().map(|b| b.offset).sum::<f64>() / measured.points.len() as f64;
        start
    };
    let start = from_envelope(&best.bounded.parameters);
    let found = fit_waveform_window(samples, measured, from..to, origin, duration, start)?;
    let fades = [super::segment::FLOOR, super::segment::REST].contains(&measured.stretch.end_reason);
    if !fades || ends_free {
        return Some(found);
    }
    // Below the noise of single blocks the samples still know: go on while they agree.
    let longer = agreeing_end(samples, measured, &found, from, to)?;
    if longer <= to {
        return Some(found);
    }
    let start = found.comparison.best()?.bounded.parameters.clone();
    let duration = samples.time[longer - 1] - origin;
    fit_waveform_window(samples, measured, from..longer, origin, duration, start).or(Some(found))
}

/// Last sample up to which the fitted motion, followed on, leaves nothing but noise.
fn agreeing_end(
    samples: &Samples,
    measured: &Measured,
    found: &Described,
    from: usize,
    to: usize,
) -> Option<usize> {
    let Problem::Waveform(problem) = &found.problem else { return None };
    let best = &found.comparison.best()?.bounded;
    let law = super::envelope::law_of(&best.parameters, best.parameters[OMEGA]);
    let variance = found.scale.variance_of(best);
    // Block by block, then what is left behind the last whole one.
    let rest = measured.all.last().map(|b| (b.end, samples.time.len()));
    let pieces = measured.all.iter().map(|b| (b.first, b.end)).filter(|p| p.0 >= to).chain(rest);
    let mut end = to;
    for (first, last) in pieces.filter(|p| p.1 > p.0) {
        let elapsed = samples.time[first] - found.origin;
        // Some thousandths of the start, or the last swing before a stop, carry no more.
        if first > end || law.amplitude(elapsed) < (2e-3 * law.amplitude_0).max(1.2 * best.parameters[X_F]) {
            break;
        }
        let part = Waveform {
            time: &samples.time[from..last],
            signal: &samples.signal[from..last],
            ..problem.clone()
        };
        let residual = part.residuals(&best.parameters);
        let here = &residual[first - from..];
        let n = here.len() as f64;
        let mean_square = here.iter().map(|r| r * r).sum::<f64>() / n;
        if mean_square > variance * (1.0 + 4.0 * (2.0 / n).sqrt()) {
            break;
        }
        end = last;
    }
    Some(end)
}

pub(crate) fn fit_waveform_window<'a>(
    samples: &'a Samples,
    measured: &Measured,
    range: std::ops::Range<usize>,
    origin: f64,
    duration: f64,
    mut start: Vec<f64>,
) -> Option<Described<'a>> {
    let n = range.len();
    let law = super::envelope::law_of(&start, start[OMEGA]);
    let bend = Bend::along(|t| law.amplitude(t), duration);
    let always = [PHASE, OMEGA, OFFSET];
    let optional = [BEND, CHIRP, OFFSET + 1, OFFSET + 2];
    let mut problem = Waveform {
        time: &samples.time[range.clone()],
        signal: &samples.signal[range.clone()],
        origin,
        duration,
        bend: None,
        active: FULL.iter().chain(&always).copied().collect(),
    };
    let mut nuisance: Vec<usize> = always.to_vec();
    // A bend already seen in the block phases starts inside.
    if measured.law.quadratic != 0.0 || measured.law.quartic != 0.0 {
        problem.bend = Some(bend.clone());
        start[BEND] = measured.law.quadratic * measured.law.omega;
        nuisance.push(BEND);
    }
    if measured.law.drift != 0.0 {
        start[CHIRP] = measured.law.drift * measured.law.omega;
        nuisance.push(CHIRP);
    }
    let all: Vec<usize> = FULL.iter().chain(&always).chain(&optional).copied().collect();
    problem.active.clone_from(&all);
    let free = |nuisance: &[usize]| -> Vec<usize> {
        let mut f: Vec<usize> = [A0, X_F, DELTA].iter().chain(nuisance).copied().collect();
        f.sort_unstable();
        f
    };
    let mut fit = minimise(&problem, &start, &free(&nuisance))?;
    // Far above the noise no nuisance will mend it: the phase wanders.
    if fit.rss / n as f64 > 4.0 * measured.noise_rms.powi(2) {
        return None;
    }
    // Nuisances one by one, each only if the data pay for it; also the ones started with.
    let threshold = (n as f64).ln() + 6.0;
    let mut sums = Normal::zeros(COUNT);
    for _ in 0..optional.len() {
        if problem.bend.is_none() {
            problem.bend = Some(bend.clone());
        }
        if !problem.normal(&fit.parameters, &mut sums) {
            return None;
        }
        let variance = sums.rss / (n as f64 - fit.free.len() as f64).max(1.0);
        let gain = |extra: usize| {
            let mut wider = free(&nuisance);
            wider.push(extra);
            wider.push(DRAG);
            let mut base = free(&nuisance);
            base.push(DRAG);
            Some((promised_gain(&sums, &wider)? - promised_gain(&sums, &base)?) / variance)
        };
        let candidate = optional
            .into_iter()
            .filter(|o| !nuisance.contains(o))
            .filter(|&o| o != OFFSET + 2 || nuisance.contains(&(OFFSET + 1)))
            .filter_map(|o| Some((o, gain(o)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, g)| *g > threshold);
        let Some((extra, _)) = candidate else { break };
        let mut wider = nuisance.clone();
        wider.push(extra);
        let Some(next) = minimise(&problem, &fit.parameters, &free(&wider)) else { break };
        nuisance = wider;
        fit = next;
    }
    // What was started with must also pay.
    for extra in [CHIRP, BEND] {
        if !nuisance.contains(&extra) {
            continue;
        }
        let fewer: Vec<usize> = nuisance.iter().copied().filter(|&o| o != extra).collect();
        let mut start = fit.parameters.clone();
        start[extra] = 0.0;
        if let Some(without) = minimise(&problem, &start, &free(&fewer)) {
            let variance = fit.rss / (n as f64 - fit.free.len() as f64).max(1.0);
            if (without.rss - fit.rss) / variance < threshold {
                nuisance = fewer;
                fit = without;
            }
        }
    }
    if !nuisance.contains(&BEND) {
        problem.bend = None;
    }
    problem.active = {
        let mut a: Vec<usize> = FULL.iter().chain(&nuisance).copied().collect();
        a.sort_unstable();
        a
    };
    let mut scale = Scale { observations: n as f64, variance: None, widening: 1.0 };
    let sliding = {
        let span = 1.0 / fit.parameters[DELTA].abs().max(1e-3 / duration);
        0.5 * fit.parameters[A0] * PI / (2.0 * fit.parameters[OMEGA] * span)
    };
    let comparison = compare(&problem, &fit.parameters, &nuisance, scale, sliding);
    let best = comparison.best()?;
    let (excess, autocorrelation, count) =
        residual_scatter(&problem, samples, &best.bounded, &measured.points, range.start);
    if excess > 1.0 + 2.6 * (2.0 / count.max(1) as f64).sqrt() {
        scale.widening = excess;
    }
    scale.widening *= widening(autocorrelation, count);
    let comparison = rescored(comparison, scale);
    Some(Described {
        problem: Problem::Waveform(problem),
        comparison,
        scale,
        origin,
        end: origin + duration,
        excess,
        autocorrelation,
        outliers: 0,
    })
}

/// The residual's own fundamental: its variance over that of white noise, and
/// how it hangs together from block to block.
fn residual_scatter(
    problem: &Waveform,
    samples: &Samples,
    fit: &Fit,
    points: &[Block],
    first: usize,
) -> (f64, f64, usize) {
    let residual = problem.residuals(&fit.parameters);
    let n = residual.len() as f64;
    let variance = fit.rss / (n - fit.free.len() as f64).max(1.0);
    let shifted: Vec<Block> = points
        .iter()
        .filter(|b| b.first >= first && b.end <= first + residual.len())
        .map(|b| Block { first: b.first - first, end: b.end - first, ..*b })
        .collect();
    let phases: Vec<_> = shifted.iter().map(|b| problem.phase_at(&fit.parameters, b.time_s)).collect();
    let found =
        blocks::demodulate(&samples.time[first..first + residual.len()], &residual, &shifted, &phases);
    let scaled: Vec<f64> = found.iter().map(|b| b.amplitude / b.unit_variance.sqrt()).collect();
    let count = scaled.len();
    // The loss parameters already took their share of these blocks.
    let dof = (count as f64 - 3.0).max(1.0);
    let excess = scaled.iter().map(|s| s * s).sum::<f64>() / dof / variance.max(f64::MIN_POSITIVE);
    (excess, first_autocorrelation(&scaled), count)
}

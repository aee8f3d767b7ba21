//! Every sample against the exact motion, in the widest window it describes.

use super::compare::compare;
use super::envelope::{A0, DELTA, DRAG, X_F};
use super::fits::{Described, FULL, Problem};
use super::measure::{Measured, Samples};
use super::waveform::{BEND, Bend, CHIRP, COUNT, OFFSET, OMEGA, PHASE, Waveform, rest_tells};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise, promised_gain};
use crate::inference::noise::{NoiseModel, autocorrelation, significant_inflation};
use crate::signal::blocks::{self, Block};
use std::f64::consts::PI;

/// Longest window fitted sample by sample; beyond it the blocks hold the same information.
const MOST_SAMPLES: usize = 300_000;

/// With less lost per cycle the motion is an ellipse to 1e-4 and the blocks lose nothing either.
const LEAST_LOSS_A_CYCLE: f64 = 1e-3;

/// Fits every sample, starting from what the amplitudes told. `None` where the
/// waveform cannot be followed.
pub(crate) fn fit_samples<'a>(
    samples: &'a Samples,
    measured: &Measured,
    rough: &Described,
) -> Option<Described<'a>> {
    let first = measured.points.first()?;
    let last = measured.points.last()?;
    let (from, to) = (first.first, last.end);
    let best = rough.comparison.preferred()?;
    let law = super::envelope::law_of(&best.bounded.parameters, measured.law.omega);
    let loss_per_cycle = law.rate(law.amplitude_0) / law.amplitude_0 * 2.0 * PI / measured.law.omega;
    if to - from > MOST_SAMPLES || !measured.lawful || loss_per_cycle < LEAST_LOSS_A_CYCLE {
        return None;
    }
    // A record that ends in free decay is used to its last sample, not its last whole block.
    let ends_free = measured.all.last().is_some_and(|b| b.end == last.end);
    let to = if ends_free { samples.time.len() } else { to };
    let origin = samples.time[from];
    let mut start = vec![0.0; COUNT];
    start[..4].copy_from_slice(&best.bounded.parameters[..4]);
    start[OMEGA] = measured.law.omega;
    // Phase at the origin from the first block's, with the backbone on the way.
    start[PHASE] = blocks::wrap(first.phase - first.omega * (first.time_s - origin));
    start[OFFSET] = measured.points.iter().map(|b| b.offset).sum::<f64>() / measured.points.len() as f64;
    let fit = |to: usize, start: Vec<f64>| {
        fit_waveform_window(samples, measured, from..to, origin, samples.time[to - 1] - origin, start)
    };
    let found = fit(to, start)?;
    let fades = [super::segment::FLOOR, super::segment::REST].contains(&measured.stretch.end_reason);
    if !fades || ends_free {
        return Some(found);
    }
    // Below the noise of single blocks the samples still know, and so does the place of rest:
    // all of them where one motion agrees with all, else as far as it does.
    let start = found.comparison.preferred()?.bounded.parameters.clone();
    let n = samples.time.len();
    if n - from <= MOST_SAMPLES
        && let Some(whole) = fit(n, start.clone()).filter(|w| agrees(w, samples, measured))
    {
        return Some(whole);
    }
    let longer = agreeing_end(samples, measured, &found, from, to)?;
    if longer <= to {
        return Some(found);
    }
    fit(longer, start).or(Some(found))
}

/// Whether nothing but noise is left of every block in the window: in single
/// blocks, in runs of them, in phase and in quadrature.
pub(crate) fn agrees(described: &Described, samples: &Samples, measured: &Measured) -> bool {
    let Problem::Waveform(problem) = &described.problem else { return false };
    let Some(best) = described.comparison.preferred() else { return false };
    let variance = measured.noise_rms.powi(2);
    let first = samples.time.partition_point(|&t| t < problem.origin);
    let residual = problem.residuals(&best.bounded.parameters);
    let scatter = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>() / r.len() as f64;
    let tolerated = |n: usize| variance * (1.0 + 4.0 * (2.0 / n as f64).sqrt());
    if scatter(&residual) > tolerated(residual.len()) {
        return false;
    }
    let left = left_over(problem, samples, &residual, &best.bounded, &measured.all, first);
    let unit = variance.sqrt();
    // Four and a half standard errors: one in 1e5 by chance, whatever the number of blocks.
    const MOST: f64 = 4.5;
    let calm = |part: fn(&(f64, f64)) -> f64| {
        let values: Vec<f64> = left.iter().map(|v| part(v) / unit).collect();
        values.iter().all(|v| v.abs() < MOST)
            && values.windows(8).all(|w| (w.iter().sum::<f64>() / 8f64.sqrt()).abs() < MOST)
    };
    calm(|v| v.0) && calm(|v| v.1)
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
    let best = &found.comparison.preferred()?.bounded;
    let law = super::envelope::law_of(&best.parameters, best.parameters[OMEGA]);
    let variance = found.comparison.noise.residual_variance(best);
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
    let mut problem = Waveform {
        time: &samples.time[range.clone()],
        signal: &samples.signal[range.clone()],
        origin,
        duration,
        bend: None,
        rest_tells: rest_tells(start[X_F], measured.noise_rms, n),
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
    let all: Vec<usize> = FULL.iter().chain(&always).chain(&OPTIONAL).copied().collect();
    problem.active.clone_from(&all);
    let mut fit = minimise(&problem, &start, &freed(&nuisance))?;
    // The price leaves one in 1e5 to chance: in a record of a cycle or two an offset that
    // drifts by chance would cost most of what is known about the loss.
    let price = (n as f64).ln() + 14.0;
    problem.bend.get_or_insert(bend);
    add_nuisances(&problem, &mut fit, &mut nuisance, price)?;
    // Still far above the noise: the phase wanders.
    if fit.rss / n as f64 > 4.0 * measured.noise_rms.powi(2) {
        return None;
    }
    // What was started with must also pay.
    for extra in [CHIRP, BEND] {
        drop_nuisance(&problem, &mut fit, &mut nuisance, extra, price);
    }
    if !nuisance.contains(&BEND) {
        problem.bend = None;
    }
    problem.active = {
        let mut a: Vec<usize> = FULL.iter().chain(&nuisance).copied().collect();
        a.sort_unstable();
        a
    };
    let mut noise = NoiseModel::white(n as f64);
    let sliding = {
        let span = 1.0 / fit.parameters[DELTA].abs().max(1e-3 / duration);
        0.5 * fit.parameters[A0] * PI / (2.0 * fit.parameters[OMEGA] * span)
    };
    let comparison = compare(&problem, &fit.parameters, &nuisance, noise, sliding);
    let best = comparison.preferred()?;
    let (excess, autocorrelation, count) =
        residual_scatter(&problem, samples, &best.bounded, &measured.points, range.start);
    if excess > 1.0 + 2.6 * (2.0 / count.max(1) as f64).sqrt() {
        noise.variance_inflation = excess;
    }
    noise.variance_inflation *= significant_inflation(autocorrelation, count);
    Some(Described {
        problem: Problem::Waveform(problem),
        comparison: comparison.with_noise(noise),
        origin,
        end: origin + duration,
        excess,
        autocorrelation,
        outliers: 0,
    })
}

/// Disturbances of phase and offset, in the model only where the data pay for them.
const OPTIONAL: [usize; 4] = [BEND, CHIRP, OFFSET + 1, OFFSET + 2];

/// Viscous and sliding loss and the nuisances, in order.
fn freed(nuisance: &[usize]) -> Vec<usize> {
    let mut free: Vec<usize> = [A0, X_F, DELTA].iter().chain(nuisance).copied().collect();
    free.sort_unstable();
    free
}

/// Adds the nuisance that promises most, as long as one pays its price.
fn add_nuisances(problem: &Waveform, fit: &mut Fit, nuisance: &mut Vec<usize>, price: f64) -> Option<()> {
    let n = problem.time.len() as f64;
    let mut sums = Normal::zeros(COUNT);
    for _ in 0..OPTIONAL.len() {
        if !problem.normal(&fit.parameters, &mut sums) {
            return None;
        }
        let variance = sums.rss / (n - fit.free.len() as f64).max(1.0);
        // Beside drag, which may explain the same.
        let promised = |nuisance: &[usize]| {
            let mut free = freed(nuisance);
            free.push(DRAG);
            promised_gain(&sums, &free)
        };
        let with = |extra: usize| -> Vec<usize> { nuisance.iter().copied().chain([extra]).collect() };
        let Some(alone) = promised(nuisance) else { break };
        let candidate = OPTIONAL
            .into_iter()
            .filter(|o| !nuisance.contains(o))
            .filter(|&o| o != OFFSET + 2 || nuisance.contains(&(OFFSET + 1)))
            .filter_map(|o| Some((o, (promised(&with(o))? - alone) / variance)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, gain)| *gain > price);
        let Some((extra, _)) = candidate else { break };
        let wider = with(extra);
        let Some(next) = minimise(problem, &fit.parameters, &freed(&wider)) else { break };
        *nuisance = wider;
        *fit = next;
    }
    Some(())
}

/// Leaves a nuisance out again if the fit without it is worse by less than its price.
fn drop_nuisance(problem: &Waveform, fit: &mut Fit, nuisance: &mut Vec<usize>, extra: usize, price: f64) {
    if !nuisance.contains(&extra) {
        return;
    }
    let fewer: Vec<usize> = nuisance.iter().copied().filter(|&o| o != extra).collect();
    let mut start = fit.parameters.clone();
    start[extra] = 0.0;
    let Some(without) = minimise(problem, &start, &freed(&fewer)) else { return };
    let variance = fit.rss / (problem.time.len() as f64 - fit.free.len() as f64).max(1.0);
    if (without.rss - fit.rss) / variance < price {
        *nuisance = fewer;
        *fit = without;
    }
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
    let left = left_over(problem, samples, &residual, fit, points, first);
    let scaled: Vec<f64> = left.iter().map(|v| v.0).collect();
    let count = scaled.len();
    // The loss parameters already took their share of these blocks.
    let dof = (count as f64 - 3.0).max(1.0);
    let excess = scaled.iter().map(|s| s * s).sum::<f64>() / dof / variance.max(f64::MIN_POSITIVE);
    (excess, autocorrelation(&scaled), count)
}

/// Fundamental left in the residual of each block, in phase and in quadrature,
/// scaled so that white noise gives each its own variance.
fn left_over(
    problem: &Waveform,
    samples: &Samples,
    residual: &[f64],
    fit: &Fit,
    points: &[Block],
    first: usize,
) -> Vec<(f64, f64)> {
    let shifted: Vec<Block> = points
        .iter()
        .filter(|b| b.first >= first && b.end <= first + residual.len())
        .map(|b| Block { first: b.first - first, end: b.end - first, ..*b })
        .collect();
    let phases: Vec<_> = shifted.iter().map(|b| problem.phase_at(&fit.parameters, b.time_s)).collect();
    let found = blocks::demodulate(&samples.time[first..first + residual.len()], residual, &shifted, &phases);
    found
        .iter()
        .map(|b| (b.amplitude / b.unit_variance.sqrt(), b.quadrature / b.unit_variance.sqrt()))
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    /// Recorded on for two fifths of the motion after it stopped: the stop and the rest are part
    /// of what is fitted and may not pull the friction along.
    #[test]
    fn a_rest_at_the_end_leaves_the_friction_where_it_is() {
        for (q, share, noise) in [(50.0, 0.1, 0.007), (50.0, 0.5, 0.07), (1000.0, 0.5, 0.007)] {
            let delta = PI / q;
            let x_f = share / (1.0 - share) * delta / 4.0;
            let oscillator = Oscillator::kinematic(TAU, delta, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let end = 1.4 * decay.stop().expect("stops").time_s;
            let rate = (400.0 / end).max(8.3);
            let time: Vec<f64> = (0..(end * rate) as usize).map(|i| i as f64 / rate).collect();
            const REPEATS: usize = 12;
            let z: Vec<f64> = (0..REPEATS)
                .map(|repeat| {
                    let first = repeat * time.len();
                    let noisy = |(i, &t): (usize, &f64)| decay.displacement(t) + noise * jitter(first + i, 0);
                    let signal = time.iter().enumerate().map(noisy).collect();
                    let record = Record::new(time.clone(), signal).expect("valid");
                    let answer = analyse(&record, &Options::default()).expect("fits");
                    let found = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("sliding found");
                    (found.unbounded_value - x_f) / found.std_error
                })
                .collect();
            let mean = z.iter().sum::<f64>() / REPEATS as f64;
            assert!(mean.abs() < 4.0 / (REPEATS as f64).sqrt(), "Q {q}, share {share}: {z:.1?}");
            assert!(z.iter().all(|z| z.abs() < 4.0), "Q {q}, share {share}: {z:.1?}");
        }
    }
}

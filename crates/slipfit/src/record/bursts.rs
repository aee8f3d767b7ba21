//! Clocks of samples delivered in bursts, each with the stamp of its delivery.

use super::Clock;
use super::criteria::ClockCriteria;
use crate::numeric::robust::median;

/// A clock that replaces one stamp per burst.
pub(super) struct Rebuilt {
    pub(super) clock: Clock,
    /// Usual number of samples per burst.
    pub(super) samples: usize,
    /// Half width of the range of sampling rates compatible with the scatter of the stamps, over the rate.
    pub(super) rate_error: f64,
}

/// A stamp, its first sample and its number of samples.
#[derive(Clone, Copy)]
struct Burst {
    stamp_s: f64,
    first: usize,
    samples: usize,
}

/// The clock behind stamps that stand for bursts of samples: a uniform clock if the stamps are proportional to the
/// number of samples, otherwise the samples of each burst are spread over the time since the previous one. `None` if
/// the stamps do not come in bursts, or if a burst has one value throughout.
pub(super) fn rebuild(time_s: &[f64], signal: &[f64], c: &ClockCriteria) -> Option<Rebuilt> {
    let bursts = bursts(time_s);
    let n = time_s.len();
    if bursts.len() < c.bursts || ((n - bursts.len()) as f64) < c.burst_repeated * n as f64 {
        return None;
    }
    let varies = |b: &&Burst| signal[b.first..b.first + b.samples].windows(2).any(|w| w[0] != w[1]);
    if bursts.iter().filter(varies).count() * 2 < bursts.len() {
        return None;
    }
    let mut lengths: Vec<f64> = bursts.iter().map(|b| b.samples as f64).collect();
    let usual = median(&mut lengths)?;
    let mut steps: Vec<f64> =
        bursts.windows(2).map(|b| (b[1].stamp_s - b[0].stamp_s) / b[1].samples as f64).collect();
    let step_s = median(&mut steps).filter(|step| *step > 0.0 && step.is_finite())?;
    let samples = usual.round() as usize;
    if let Some((clock, rate_error)) = even(&bursts, c.burst_off * usual * step_s) {
        return Some(Rebuilt { clock, samples, rate_error });
    }
    let steady = bursts.iter().filter(|b| (b.samples as f64 - usual).abs() <= c.burst_length * usual).count();
    if (steady as f64) < c.burst_steady * bursts.len() as f64 {
        return None;
    }
    let mut stamps = Vec::with_capacity(n);
    let mut before = None;
    for burst in &bursts {
        let own = before.map_or(step_s, |before: f64| (burst.stamp_s - before) / burst.samples as f64);
        let step = if own > c.burst_lost * step_s { step_s } else { own };
        stamps.extend((0..burst.samples).rev().map(|left| burst.stamp_s - left as f64 * step));
        before = Some(burst.stamp_s);
    }
    Some(Rebuilt { clock: Clock::Stamps(stamps), samples, rate_error: 0.0 })
}

fn bursts(time_s: &[f64]) -> Vec<Burst> {
    let mut first = 0;
    time_s
        .chunk_by(|a, b| a == b)
        .map(|same| {
            let burst = Burst { stamp_s: same[0], first, samples: same.len() };
            first += same.len();
            burst
        })
        .collect()
}

/// The uniform clock whose time at the last sample of each burst is its stamp; no stamp deviates by more than
/// `most_s`.
fn even(bursts: &[Burst], most_s: f64) -> Option<(Clock, f64)> {
    let n = bursts.len() as f64;
    let at = |b: &Burst| (b.first + b.samples - 1) as f64;
    let mean_i = bursts.iter().map(at).sum::<f64>() / n;
    let mean_t = bursts.iter().map(|b| b.stamp_s).sum::<f64>() / n;
    let ii: f64 = bursts.iter().map(|b| (at(b) - mean_i).powi(2)).sum();
    let it: f64 = bursts.iter().map(|b| (at(b) - mean_i) * (b.stamp_s - mean_t)).sum();
    let interval_s = it / ii;
    let start_s = mean_t - interval_s * mean_i;
    if !(interval_s > 0.0 && interval_s.is_finite() && start_s.is_finite()) {
        return None;
    }
    let off = |b: &Burst| b.stamp_s - start_s - interval_s * at(b);
    if !bursts.iter().all(|b| off(b).abs() <= most_s) {
        return None;
    }
    let variance = bursts.iter().map(|b| off(b).powi(2)).sum::<f64>() / (n - 2.0);
    // A uniform distribution with that standard deviation.
    let rate_error = (3.0 * variance / ii).sqrt() / interval_s;
    Some((Clock::Uniform { start_s, interval_s }, rate_error))
}

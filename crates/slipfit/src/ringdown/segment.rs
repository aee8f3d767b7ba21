//! Which stretch of the record is free decay.
//!
//! Along a free decay the loss is a function of the amplitude alone. A driven
//! lead-in, a hand, a jolt, a rest all break that: the stretch is grown from a
//! sure core for as long as one amplitude law predicts the next blocks.

use super::envelope::{A0, DELTA, DRAG, EnvelopeProblem, X_F};
use crate::inference::least_squares::minimise;
use crate::signal::blocks::Block;

/// Blocks `first..end` are free decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) first: usize,
    pub(crate) end: usize,
    pub(crate) start_reason: &'static str,
    pub(crate) end_reason: &'static str,
    /// The amplitude after the end stays above what the law predicts: a slow tail.
    pub(crate) slow_tail: bool,
    /// The end is a jump of the amplitude.
    pub(crate) disturbed: bool,
}

pub(crate) const RECORD_START: &str = "the record starts";
pub(crate) const RECORD_END: &str = "the record ends";
pub(crate) const LEAD_IN: &str = "before it the motion is driven or disturbed";
pub(crate) const CLIPPED: &str = "before it samples are clipped";
pub(crate) const FLOOR: &str = "the oscillation reaches the noise";
pub(crate) const REST: &str = "the motion comes to rest";
pub(crate) const JOLT: &str = "a disturbance";
pub(crate) const OTHER_LAW: &str = "the amplitude leaves the law of the earlier decay";
pub(crate) const ASKED: &str = "asked for";
pub(crate) const LEAST: &str = "the least amplitude asked for";

/// Amplitude and its error for each block, and the amplitude below which nothing is seen.
#[derive(Debug, Clone)]
pub(crate) struct Seen<'a> {
    pub(crate) blocks: &'a [Block],
    pub(crate) amplitude: Vec<f64>,
    pub(crate) error: Vec<f64>,
    pub(crate) floor: Vec<f64>,
    pub(crate) omega: f64,
}

impl Seen<'_> {
    fn median3(&self) -> Vec<f64> {
        let a = &self.amplitude;
        (0..a.len())
            .map(|i| {
                if i == 0 || i + 1 == a.len() {
                    return a[i];
                }
                let (x, y, z) = (a[i - 1], a[i], a[i + 1]);
                x.max(y).min(x.min(y).max(z))
            })
            .collect()
    }
}

/// Finds the free decay among the blocks.
pub(crate) fn find(seen: &Seen) -> Option<Stretch> {
    let smooth = seen.median3();
    let (first, end) = best_run(seen, &smooth)?;
    Some(grow(seen, &smooth, first, end))
}

/// The run of falling amplitude with the largest fall: a new maximum ends a run.
fn best_run(seen: &Seen, smooth: &[f64]) -> Option<(usize, usize)> {
    let n = smooth.len();
    let mut best: Option<(f64, usize, usize)> = None;
    let mut i = 0;
    while i < n {
        if smooth[i] <= seen.floor[i] {
            i += 1;
            continue;
        }
        let mut least = smooth[i];
        let mut top = (i, smooth[i]);
        let mut j = i + 1;
        while j < n && smooth[j] > seen.floor[j] && smooth[j] <= 1.1 * least + 4.0 * seen.error[j] {
            least = least.min(smooth[j]);
            if smooth[j] > top.1 {
                top = (j, smooth[j]);
            }
            j += 1;
        }
        // The first block within the noise of the top: a slow fall hides its own maximum.
        let from = (i..=top.0).find(|&k| smooth[k] >= 0.98 * top.1 - 3.0 * seen.error[k]).unwrap_or(top.0);
        if j - from >= 2 {
            let fall = (top.1 / smooth[j - 1].max(f64::MIN_POSITIVE)).ln();
            let score = fall * (1.0 + (j - from) as f64).ln();
            if best.is_none_or(|b| score > b.0) {
                best = Some((score, from, j));
            }
        }
        i = j;
    }
    best.map(|b| (b.1, b.2))
}

/// Grows the stretch from its core in both directions.
fn grow(seen: &Seen, smooth: &[f64], first: usize, end: usize) -> Stretch {
    let n = smooth.len();
    let top = smooth[first];
    // Core: from where the fall is under way down to a part of it.
    let mut a = (first..end).rev().find(|&i| smooth[i] >= 0.9 * top).map_or(first, |i| i + 1);
    if let Some(after) = step_down(smooth, first, a, end) {
        // Switching off a drive that leaks into the signal takes its share away at once.
        a = after;
    }
    let start = smooth[a.min(end - 1)];
    let mut b = (a..end).find(|&i| smooth[i] < 0.15 * start).unwrap_or(end);
    if b < a + 5 {
        b = (a + 8).min(end);
    }
    if b < a + 5 {
        a = first;
        b = end;
    }
    if b - a < 5 {
        return Stretch {
            first,
            end,
            start_reason: if first == 0 { RECORD_START } else { LEAD_IN },
            end_reason: end_reason(seen, smooth, end),
            slow_tail: false,
            disturbed: false,
        };
    }
    let mut law = Core::fit(seen, a, b);
    let mut refit_at = b - a;
    // Forward.
    let mut misses = 0;
    let mut sign = 0.0;
    let mut left_law = false;
    let mut j = b;
    while j < end {
        let miss = law.as_ref().map_or(0.0, |l| l.miss(seen, j, 0.3));
        if miss.abs() > 1.0 {
            misses += 1;
            sign += miss.signum();
        } else {
            misses = 0;
            sign = 0.0;
            b = j + 1;
        }
        if misses >= 3 {
            left_law = true;
            break;
        }
        if b - a > refit_at + refit_at / 4 && misses == 0 {
            law = Core::fit(seen, a, b).or(law);
            refit_at = b - a;
        }
        j += 1;
    }
    if left_law {
        // The last blocks let pass may already bend away: take back those that do.
        law = Core::fit(seen, a, b - (b - a) / 8).or(law);
        while b > a + 8 && law.as_ref().is_some_and(|l| l.miss(seen, b - 1, 0.08).abs() > 1.0) {
            b -= 1;
        }
    } else {
        b = end;
    }
    // Backward, and only now: the start is where a drive would bend the law.
    law = Core::fit(seen, a, b).or(law);
    let mut start_reason = if first == 0 { RECORD_START } else { LEAD_IN };
    refit_at = b - a;
    while a > first {
        let miss = |j: usize| law.as_ref().map_or(0.0, |l| l.miss(seen, j, 0.02).abs());
        if miss(a - 1) > 1.0 && (a < first + 2 || miss(a - 2) > 1.0) {
            start_reason = LEAD_IN;
            // The block beside a change of regime holds some of both.
            a = (a + if b - a > 20 { 2 } else { 1 }).min(b - 4);
            break;
        }
        a -= 1;
        if b - a > refit_at + refit_at / 8 {
            law = Core::fit(seen, a, b).or(law);
            refit_at = b - a;
        }
    }
    let reason = if left_law { OTHER_LAW } else { end_reason(seen, smooth, b) };
    if reason == FLOOR {
        b = into_the_noise(seen, a, b);
    }
    let disturbed = !left_law && b < n && smooth[b] > 1.1 * smooth[b - 1] + 4.0 * seen.error[b];
    Stretch {
        first: a,
        end: b,
        start_reason,
        end_reason: reason,
        slow_tail: left_law && sign > 0.0,
        disturbed,
    }
}

/// Follows the law on into the noise, where single blocks say little but many
/// together still do: as long as each agrees with it and it predicts at least a
/// third of a block's error.
fn into_the_noise(seen: &Seen, a: usize, mut b: usize) -> usize {
    let Some(law) = Core::fit(seen, a, b) else { return b };
    while b < seen.blocks.len() {
        let (predicted, error) = (law.predict(seen, b), seen.error[b]);
        // The modulus of signal and noise together scatters below A + 4 sigma.
        if predicted < 0.3 * error
            || seen.amplitude[b] > predicted + 4.0 * error
            || seen.amplitude[b] < predicted - 4.0 * error
        {
            break;
        }
        b += 1;
    }
    b
}

/// The block after a sudden loss near the start, many times the loss that follows.
fn step_down(smooth: &[f64], first: usize, a: usize, end: usize) -> Option<usize> {
    let drop = |i: usize| (smooth[i] / smooth[i + 1].max(f64::MIN_POSITIVE)).ln();
    (first..(a + 6).min(end.saturating_sub(14)))
        .rev()
        .find(|&i| {
            let mut later: Vec<f64> = (i + 3..i + 13).map(drop).collect();
            later.sort_by(f64::total_cmp);
            drop(i) > 0.1 && drop(i) > 8.0 * later[5].max(0.0) && later[5] > 0.0
        })
        .map(|i| i + 2)
}

fn end_reason(seen: &Seen, smooth: &[f64], end: usize) -> &'static str {
    let n = smooth.len();
    if end >= n {
        return RECORD_END;
    }
    if smooth[end] > 1.1 * smooth[end - 1] + 4.0 * seen.error[end] {
        return JOLT;
    }
    // A stop takes the amplitude away within a block or two; noise is reached slowly.
    let back = end.saturating_sub(3);
    if smooth[back] > 4.0 * seen.floor[end.min(n - 1)] { REST } else { FLOOR }
}

/// An amplitude law through a few blocks, to judge their neighbours by.
struct Core {
    problem: EnvelopeProblem,
    parameters: Vec<f64>,
    origin: f64,
    scatter: f64,
}

impl Core {
    fn fit(seen: &Seen, a: usize, b: usize) -> Option<Self> {
        // A hundred points say enough.
        let stride = ((b - a) / 100).max(1);
        let index: Vec<usize> = (a..b).step_by(stride).collect();
        let origin = seen.blocks[a].time_s;
        let top = seen.amplitude[a];
        let problem = EnvelopeProblem {
            elapsed: index.iter().map(|&i| seen.blocks[i].time_s - origin).collect(),
            value: index.iter().map(|&i| seen.amplitude[i]).collect(),
            // Errors in proportion to the amplitude keep the late blocks in the vote.
            weight: index
                .iter()
                .map(|&i| {
                    1.0 / (seen.error[i].powi(2) + (0.01 * seen.amplitude[i]).powi(2) + 1e-8 * top * top)
                })
                .collect(),
            omega: seen.omega,
            backbone: [0.0; 2],
            squared: false,
            lowpass: None,
        };
        let last = index[index.len() - 1];
        let span = (seen.blocks[last].time_s - origin).max(f64::MIN_POSITIVE);
        let delta = ((top / seen.amplitude[last].max(1e-6 * top)).ln() / span).max(1e-9 / span);
        let start = [top, 0.0, delta, 0.0, 0.0];
        let free: &[usize] = match index.len() {
            0..=4 => &[A0, DELTA],
            5..=7 => &[A0, DELTA, X_F],
            _ => &[A0, DELTA, X_F, DRAG],
        };
        let viscous = minimise(&problem, &start, &[A0, DELTA])?;
        let fit =
            minimise(&problem, &viscous.parameters, free).filter(|f| f.rss.is_finite()).unwrap_or(viscous);
        let scatter = (fit.rss / (index.len() as f64 - fit.free.len() as f64).max(1.0)).sqrt().max(1.0);
        Some(Self { problem, parameters: fit.parameters, origin, scatter })
    }

    /// Amplitude the law gives block `j`.
    fn predict(&self, seen: &Seen, j: usize) -> f64 {
        let one =
            EnvelopeProblem { elapsed: vec![seen.blocks[j].time_s - self.origin], ..self.problem.clone() };
        one.amplitudes(&self.parameters)[0].max(0.0)
    }

    /// Distance of block `j` from the law in units of what is tolerated; signed.
    fn miss(&self, seen: &Seen, j: usize, relative: f64) -> f64 {
        let predicted = self.predict(seen, j);
        let a = seen.amplitude[j];
        let unit = (seen.error[j].powi(2) + (0.01 * a).powi(2)).sqrt() * self.scatter.min(20.0);
        (a - predicted) / (5.0 * seen.error[j] + relative * a + 2.0 * unit).max(f64::MIN_POSITIVE)
    }
}

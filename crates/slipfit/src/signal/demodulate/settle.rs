//! Settling detection: the time at which a transient has decayed.

use std::f64::consts::TAU;

use super::criteria::Criteria;
use crate::inference::least_squares;
use crate::motion::steady::Phasor;

/// Phasor of a number of whole cycles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub(super) phasor: Phasor,
    pub(super) samples: usize,
    /// Index of its first sample.
    pub(super) first: usize,
    /// Time of its middle relative to the first sample, s.
    pub(super) middle_s: f64,
}

/// Beginning of the steady part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Settled {
    /// Index of its first sample.
    pub(super) first: usize,
    /// Whether the motion settled, i.e. the two halves of the steady part agree.
    pub(super) settled: bool,
}

impl Settled {
    pub(super) fn at_once() -> Self {
        Self { first: 0, settled: true }
    }
}

/// Phasors of successive groups of whole cycles relative to a common phase.
pub(super) fn phasors(time: &[f64], values: &[f64], omega: f64, c: &Criteria) -> Option<Vec<Block>> {
    let (start, end) = (*time.first()?, *time.last()?);
    let period = TAU / omega;
    let cycles = (end - start) / period;
    let per_cycle = time.len() as f64 / cycles;
    let whole =
        (c.block_samples as f64 / per_cycle).ceil().max((cycles / c.most_blocks as f64).ceil()).max(1.0);
    let length = whole * period;
    let count = ((end - start) / length + 1e-9).floor() as usize;
    let mut blocks = Vec::with_capacity(count);
    for k in 0..count {
        let from = time.partition_point(|t| *t < start + k as f64 * length);
        let to = time.partition_point(|t| *t < start + (k + 1) as f64 * length);
        // A gap contains too few samples.
        if to - from < 5 {
            continue;
        }
        let rows = (from..to).map(|i| {
            let (sin, cos) = (omega * (time[i] - start)).sin_cos();
            (vec![cos, sin, 1.0], values[i], 1.0)
        });
        if let Some((found, _, _)) = least_squares::linear(rows, 3) {
            let middle_s = 0.5 * (time[from] + time[to - 1]) - start;
            blocks.push(Block {
                phasor: Phasor::new(found[0], -found[1]),
                samples: to - from,
                first: from,
                middle_s,
            });
        }
    }
    (blocks.len() >= 2).then_some(blocks)
}

/// The time from which the response is steady.
pub(super) fn find(
    time: &[f64],
    response: &[f64],
    drive: Option<&[f64]>,
    omega: f64,
    c: &Criteria,
) -> Settled {
    let Some(blocks) = phasors(time, response, omega, c) else { return Settled::at_once() };
    let blocks = match drive {
        None => blocks,
        // Relative to the drive at the same time: if the exciter's speed drifts, the response follows it, and only
        // the remaining change is a transient.
        Some(drive) => {
            let Some(driving) = phasors(time, drive, omega, c) else { return Settled::at_once() };
            let mean = driving.iter().map(|d| d.phasor.norm()).sum::<f64>() / driving.len() as f64;
            let against = |block: &Block| {
                let at = driving.binary_search_by_key(&block.first, |d| d.first).ok()?;
                // A drive that is not yet on gives a huge ratio, as it should.
                let drive = driving[at].phasor.norm().max(1e-6 * mean);
                let turn = driving[at].phasor.arg();
                Some(Block { phasor: block.phasor * Phasor::from_polar(mean / drive, -turn), ..*block })
            };
            blocks.iter().filter_map(against).collect()
        }
    };
    of_blocks(&blocks, c)
}

fn of_blocks(blocks: &[Block], c: &Criteria) -> Settled {
    let n = blocks.len();
    if n == 0 {
        return Settled::at_once();
    }
    if n < c.settling_blocks {
        // Too short for settling detection: the second half is the better choice.
        return Settled { first: blocks[n / 2].first, settled: false };
    }
    let tail = &blocks[n - (n / 3).max(3)..];
    let sigma = scatter(tail);
    let mut begin = n - tail.len();
    let mut held: Phasor = tail.iter().map(|b| b.phasor).sum();
    while begin > 0 {
        let count = (n - begin) as f64;
        let far = (blocks[begin - 1].phasor - held / count).norm();
        if far > c.far * sigma * (1.0 + 1.0 / count).sqrt() {
            break;
        }
        begin -= 1;
        held += blocks[begin].phasor;
    }
    let steady = held / (n - begin) as f64;
    if begin > 0 {
        let guard = (c.guard * decay_blocks(&blocks[..begin], steady, sigma, c)).ceil() as usize;
        // At least half of the apparently steady part is kept.
        begin += guard.min((n - begin) / 2);
    }
    Settled {
        first: if begin == 0 { 0 } else { blocks[begin].first },
        settled: halves_agree(&blocks[begin..], c),
    }
}

/// Standard deviation of one phasor about the mean, modulus.
fn scatter(blocks: &[Block]) -> f64 {
    let n = blocks.len() as f64;
    let mean = blocks.iter().map(|b| b.phasor).sum::<Phasor>() / n;
    let sum: f64 = blocks.iter().map(|b| (b.phasor - mean).norm_sqr()).sum();
    let largest = blocks.iter().map(|b| b.phasor.norm()).fold(0.0, f64::max);
    // Without noise, rounding and the limited accuracy of the frequency remain.
    (sum / (n - 1.0)).sqrt().max(1e-6 * largest)
}

/// Number of blocks in which the transient falls by 1/e, from the slope of its logarithm.
fn decay_blocks(blocks: &[Block], steady: Phasor, sigma: f64, c: &Criteria) -> f64 {
    let mut seen: Vec<(f64, f64)> = Vec::new();
    for (k, block) in blocks.iter().enumerate() {
        let far = (block.phasor - steady).norm();
        if far > c.seen * sigma {
            seen.push((k as f64, far.ln()));
        }
    }
    let n = seen.len() as f64;
    let (mk, ml) = (seen.iter().map(|s| s.0).sum::<f64>() / n, seen.iter().map(|s| s.1).sum::<f64>() / n);
    let kk: f64 = seen.iter().map(|s| (s.0 - mk).powi(2)).sum();
    let kl: f64 = seen.iter().map(|s| (s.0 - mk) * (s.1 - ml)).sum();
    let slope = kl / kk;
    // A single block, or a transient that does not fall, gives no rate: the observed length is assumed.
    let fallback = blocks.len() as f64 / c.guard;
    if slope < 0.0 { (-1.0 / slope).min(fallback.max(1.0)) } else { fallback }
}

/// Whether the means of both halves agree within their scatter.
fn halves_agree(blocks: &[Block], c: &Criteria) -> bool {
    let half = blocks.len() / 2;
    if half < 2 {
        return false;
    }
    let (a, b) = (&blocks[..half], &blocks[blocks.len() - half..]);
    let mean = |part: &[Block]| part.iter().map(|b| b.phasor).sum::<Phasor>() / part.len() as f64;
    let difference = (mean(a) - mean(b)).norm();
    let error = (scatter(a).powi(2) + scatter(b).powi(2)).sqrt() / (half as f64).sqrt();
    // An insignificant difference is ignored, however small the noise.
    difference < c.halves_differ * error || difference < c.halves_relative * mean(b).norm()
}

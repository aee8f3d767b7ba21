//! Start of the search for a decay: the run with the largest fall, and an amplitude law through its middle.

use crate::inference::least_squares::{LeastSquares, minimise};
use crate::ringdown::block_amplitudes::BlockAmplitudes;
use crate::ringdown::criteria::WindowCriteria;
use crate::ringdown::envelope::{A0, DELTA, DRAG, EnvelopeProblem, X_F};
use std::ops::Range;

/// Maximum number of points of a seed fit; more bring no gain.
const MOST_POINTS: usize = 100;
/// Number of blocks next to a sudden loss that contain part of it.
const STEP_EDGE: usize = 3;
/// Number of later blocks whose median loss is the usual one.
const STEP_LATER: usize = 10;
/// Number of blocks after the start of a seed in which a sudden loss may lie.
const STEP_REACH: usize = 6;

/// Whether the amplitude of a block rises above `least` by more than noise and a slow beat would cause.
pub(super) fn rises(
    amplitudes: &BlockAmplitudes,
    smooth: &[f64],
    block: usize,
    least: f64,
    c: &WindowCriteria,
) -> bool {
    smooth[block] > c.rise_ratio * least + c.rise_errors * amplitudes.error[block]
}

/// The run of falling amplitude with the largest fall; a new maximum ends a run.
pub(super) fn best_run(
    amplitudes: &BlockAmplitudes,
    smooth: &[f64],
    c: &WindowCriteria,
) -> Option<Range<usize>> {
    let n = smooth.len();
    let mut best: Option<(f64, Range<usize>)> = None;
    let mut i = 0;
    while i < n {
        if smooth[i] <= amplitudes.floor[i] {
            i += 1;
            continue;
        }
        let mut least = smooth[i];
        let mut top = (i, smooth[i]);
        let mut end = i + 1;
        while end < n && smooth[end] > amplitudes.floor[end] && !rises(amplitudes, smooth, end, least, c) {
            least = least.min(smooth[end]);
            if smooth[end] > top.1 {
                top = (end, smooth[end]);
            }
            end += 1;
        }
        // In a slow fall the exact position of the maximum is hidden by noise.
        let from = (i..=top.0)
            .find(|&k| smooth[k] >= c.top_ratio * top.1 - c.top_errors * amplitudes.error[k])
            .unwrap_or(top.0);
        if end - from >= 2 {
            let fall = (top.1 / smooth[end - 1].max(f64::MIN_POSITIVE)).ln();
            let score = fall * (1.0 + (end - from) as f64).ln();
            if best.as_ref().is_none_or(|b| score > b.0) {
                best = Some((score, from..end));
            }
        }
        i = end;
    }
    best.map(|b| b.1)
}

/// The part of a run from where the amplitude has clearly begun to fall down to a fraction of the amplitude
/// there. `None` if the run is too short.
pub(super) fn seed(smooth: &[f64], run: &Range<usize>, c: &WindowCriteria) -> Option<Range<usize>> {
    let top = smooth[run.start];
    let falling = run.clone().rev().find(|&i| smooth[i] >= c.seed_from * top).map_or(run.start, |i| i + 1);
    // When a drive that leaks into the signal is switched off, its contribution vanishes at once.
    let start = after_step(smooth, run, falling, c).unwrap_or(falling);
    let first = smooth[start.min(run.end - 1)];
    let mut end = (start..run.end).find(|&i| smooth[i] < c.seed_to * first).unwrap_or(run.end);
    if end < start + c.seed_least {
        end = (start + c.seed_blocks).min(run.end);
    }
    let seed = if end < start + c.seed_least { run.clone() } else { start..end };
    (seed.len() >= c.seed_least).then_some(seed)
}

/// The block after a sudden loss near the start that is many times the loss after it.
fn after_step(smooth: &[f64], run: &Range<usize>, start: usize, c: &WindowCriteria) -> Option<usize> {
    let loss = |i: usize| (smooth[i] / smooth[i + 1].max(f64::MIN_POSITIVE)).ln();
    let last = run.end.saturating_sub(STEP_EDGE + STEP_LATER + 1);
    (run.start..(start + STEP_REACH).min(last))
        .rev()
        .find(|&i| {
            let mut later: Vec<f64> = (i + STEP_EDGE..i + STEP_EDGE + STEP_LATER).map(loss).collect();
            later.sort_by(f64::total_cmp);
            let usual = later[STEP_LATER / 2];
            loss(i) > c.step && loss(i) > c.step_factor * usual.max(0.0) && usual > 0.0
        })
        .map(|i| i + 2)
}

/// An amplitude law fitted to a few blocks, used to judge their neighbours.
pub(super) struct SeedFit<'a> {
    amplitudes: &'a BlockAmplitudes<'a>,
    criteria: &'a WindowCriteria,
    parameters: Vec<f64>,
    origin: f64,
    /// Ratio of the standard deviation about the law to the errors, at least one.
    scatter: f64,
}

impl<'a> SeedFit<'a> {
    pub(super) fn new(
        amplitudes: &'a BlockAmplitudes<'a>,
        blocks: Range<usize>,
        criteria: &'a WindowCriteria,
    ) -> Option<Self> {
        let stride = (blocks.len() / MOST_POINTS).max(1);
        let origin = amplitudes.blocks[blocks.start].time_s;
        let top = amplitudes.of_motion(blocks.start)[0];
        let index: Vec<usize> = blocks.step_by(stride).collect();
        // Errors proportional to the amplitude give the late blocks enough weight.
        let variance = |i: usize| {
            let [amplitude, error] = amplitudes.of_motion(i);
            error.powi(2) + (criteria.law_error * amplitude).powi(2) + 1e-8 * top * top
        };
        let problem = EnvelopeProblem {
            elapsed: index.iter().map(|&i| amplitudes.blocks[i].time_s - origin).collect(),
            value: index.iter().map(|&i| amplitudes.of_motion(i)[0]).collect(),
            weight: index.iter().map(|&i| 1.0 / variance(i)).collect(),
            ..blank(amplitudes.omega)
        };
        let last = index[index.len() - 1];
        let span = (amplitudes.blocks[last].time_s - origin).max(f64::MIN_POSITIVE);
        let delta = ((top / amplitudes.of_motion(last)[0].max(1e-6 * top)).ln() / span).max(1e-9 / span);
        let mut start = vec![0.0; problem.parameters()];
        (start[A0], start[DELTA]) = (top, delta);
        let mut free = vec![A0, DELTA];
        if index.len() >= criteria.sliding_from {
            free.push(X_F);
        }
        if index.len() >= criteria.drag_from {
            free.push(DRAG);
        }
        let viscous = minimise(&problem, &start, &[A0, DELTA])?;
        let fit =
            minimise(&problem, &viscous.parameters, &free).filter(|f| f.rss.is_finite()).unwrap_or(viscous);
        let scatter = (fit.rss / (index.len() as f64 - fit.free.len() as f64).max(1.0)).sqrt().max(1.0);
        Some(Self { amplitudes, criteria, parameters: fit.parameters, origin, scatter })
    }

    /// Amplitude of a block according to the law.
    pub(super) fn predict(&self, block: usize) -> f64 {
        let elapsed = vec![self.amplitudes.blocks[block].time_s - self.origin];
        let one = EnvelopeProblem { elapsed, ..blank(self.amplitudes.omega) };
        one.amplitudes(&self.parameters)[0].max(0.0)
    }

    /// Deviation of a block from the law relative to the tolerance, of which `relative` is the part
    /// proportional to the amplitude; positive above the law.
    pub(super) fn relative_deviation(&self, block: usize, relative: f64) -> f64 {
        let c = self.criteria;
        let (amplitude, error) = (self.amplitudes.amplitude(block), self.amplitudes.error[block]);
        let deviation =
            (error.powi(2) + (c.law_error * amplitude).powi(2)).sqrt() * self.scatter.min(c.most_scatter);
        let tolerated = c.miss_errors * error + relative * amplitude + c.miss_deviations * deviation;
        (amplitude - self.amplitudes.reading(self.predict(block))) / tolerated.max(f64::MIN_POSITIVE)
    }
}

/// The amplitude law without data, at constant frequency.
fn blank(omega: f64) -> EnvelopeProblem {
    EnvelopeProblem {
        elapsed: Vec::new(),
        value: Vec::new(),
        weight: Vec::new(),
        omega,
        backbone: [0.0; 2],
        squared: false,
        time_variance_s2: 0.0,
        lowpass: None,
    }
}

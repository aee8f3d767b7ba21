//! Samples cut off at the ends of a range: the converter's, or a limiter's that moves.

use super::criteria::ClippingCriteria;
use crate::numeric::extremes;
use crate::signal::blocks::Block;
use std::f64::consts::{PI, TAU};

/// Samples whose extremes are found together.
const CHUNK: usize = 1024;

/// Samples stuck at the extremes of the record in runs, and the index after the last.
pub(crate) fn clipped_samples(signal: &[f64], criteria: &ClippingCriteria) -> (usize, usize) {
    let least = criteria.run;
    let extremes: Vec<(f64, f64)> = signal.chunks(CHUNK).map(extremes).collect();
    let (low, high) =
        extremes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), e| (a.min(e.0), b.max(e.1)));
    let (mut count, mut last, mut runs, mut run) = (0, 0, 0, 0);
    for (chunk, _) in extremes.iter().enumerate().filter(|(_, e)| e.0 == low || e.1 == high) {
        let first = chunk * CHUNK;
        for (i, &v) in signal.iter().enumerate().skip(first).take(CHUNK) {
            let stuck = v == high || v == low;
            // A run goes on across the edge of a chunk, for its value is an extreme of both.
            if stuck && (run == 0 || signal[i - 1] == v) {
                run += 1;
            } else {
                run = usize::from(stuck);
            }
            if run == least {
                runs += 1;
            }
            if run >= least {
                count += if run == least { least } else { 1 };
                last = i + 1;
            }
        }
    }
    if runs >= criteria.runs { (count, last) } else { (0, 0) }
}

/// How many of the first blocks are clipped or lie before clipped ones. `None` where there are
/// none, or where too few blocks remain behind them.
pub(crate) fn clipped_blocks(
    blocks: &[Block],
    signal: &[f64],
    converter_step: f64,
    criteria: &ClippingCriteria,
) -> Option<usize> {
    let mut clipped = flattened(blocks, signal, converter_step, criteria);
    if clipped == 0 {
        return None;
    }
    // A stray crest at the very ceiling soon after belongs to it.
    let (_, last) = clipped_samples(signal, criteria);
    let beyond = blocks.partition_point(|b| b.first < last);
    if beyond <= clipped + clipped.div_ceil(criteria.straggler_part) {
        clipped = clipped.max(beyond);
    }
    (blocks.len() >= clipped + criteria.least_after).then_some(clipped)
}

/// Counts the first blocks from the first large one on for as long as their crests are flat. The
/// ceiling may move from block to block, as a limiter's does.
fn flattened(blocks: &[Block], signal: &[f64], converter_step: f64, criteria: &ClippingCriteria) -> usize {
    let top = blocks.iter().fold(0.0f64, |m, b| m.max(b.amplitude));
    let large = criteria.from_amplitude * top;
    let Some(from) = blocks.iter().position(|b| b.amplitude >= large) else { return 0 };
    let mut end = 0;
    for (i, block) in blocks.iter().enumerate().skip(from) {
        if is_flat(block, &signal[block.first..block.end], converter_step, criteria) {
            end = i + 1;
        } else if i >= end.max(from) + criteria.round_blocks {
            break;
        }
    }
    // The last crests to touch the ceiling are too briefly flat to be told from round ones.
    if end == 0 { 0 } else { (end + (end - from).div_ceil(criteria.margin_part)).min(blocks.len()) }
}

/// Whether many crests repeat one value for longer than the crest of a sinusoid on the
/// converter's steps would.
fn is_flat(block: &Block, signal: &[f64], converter_step: f64, criteria: &ClippingCriteria) -> bool {
    let cycles = block.omega * block.span_s / TAU;
    let a = block.amplitude;
    if !(cycles > 0.0 && a > criteria.least_steps * converter_step) {
        return false;
    }
    // cos stays within one step q of its crest for an angle 2 sqrt(2 q/A).
    let natural = signal.len() as f64 / cycles * (2.0 * converter_step / a).sqrt() / PI;
    let least = ((criteria.plateau_ratio * natural) as usize).max(criteria.plateau_samples);
    let crest = criteria.plateau_height * a;
    let plateaus = signal
        .chunk_by(|x, y| x == y)
        .filter(|run| run.len() >= least && (run[0] - block.offset).abs() > crest)
        .count();
    plateaus >= criteria.plateaus && plateaus as f64 >= cycles / criteria.plateau_cycles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_is_counted_across_the_edges_of_chunks() {
        let clipped = |signal: &[f64]| clipped_samples(signal, &ClippingCriteria::default());
        let mut signal: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.37).sin() * 0.9).collect();
        assert_eq!(clipped(&signal), (0, 0));
        signal[1020..1030].fill(1.0);
        signal[3000..3003].fill(1.0);
        signal[3500..3505].fill(-1.0);
        assert_eq!(clipped(&signal), (0, 0), "two runs are no clipping");
        signal[4990..4996].fill(-1.0);
        assert_eq!(clipped(&signal), (10 + 5 + 6, 4996));
    }

    /// A decay through a limiter whose ceiling falls, then free of it.
    #[test]
    fn a_falling_ceiling_clips_and_the_steps_of_a_converter_do_not() {
        let block = |first: usize, amplitude: f64| Block {
            omega: TAU / 100.0,
            span_s: 1000.0,
            amplitude,
            ..Block::of(first, first + 1000, first as f64 + 500.0)
        };
        let criteria = ClippingCriteria::default();
        let step = 1.0 / 128.0;
        let motion = |ceiling: f64| -> Vec<f64> {
            (0..10_000)
                .map(|i| {
                    let t = f64::from(i);
                    let x = (-t / 8000.0).exp() * (TAU * t / 100.0).cos();
                    let limit = ceiling * (1.0 - t / 40_000.0);
                    (x.clamp(-limit, limit) / step).round() * step
                })
                .collect()
        };
        let blocks: Vec<Block> = (0..10).map(|k| block(1000 * k, (-(k as f64 + 0.5) / 8.0).exp())).collect();
        assert_eq!(flattened(&blocks, &motion(2.0), step, &criteria), 0);
        let limited: Vec<Block> =
            blocks.iter().map(|b| Block { amplitude: b.amplitude.min(0.7), ..*b }).collect();
        let found = flattened(&limited, &motion(0.6), step, &criteria);
        // The decay meets the ceiling 0.6 (1 - t/40000) at about 5000.
        assert!((4..=7).contains(&found), "{found}");
    }
}

//! Samples cut off at the ends of a range: the converter's, or a limiter's that moves.

use crate::numeric::extremes;
use crate::signal::blocks::Block;

/// Samples whose extremes are found together.
const CHUNK: usize = 1024;

/// Samples stuck at the extremes of the record in runs of at least four, and the index after the last.
pub(crate) fn clipped(signal: &[f64]) -> (usize, usize) {
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
            if run == 4 {
                runs += 1;
                count += 4;
                last = i + 1;
            } else if run > 4 {
                count += 1;
                last = i + 1;
            }
        }
    }
    if runs >= 3 { (count, last) } else { (0, 0) }
}

/// How many of the first blocks are clipped or lie before clipped ones: from
/// the first large one on, for as long as the crests of the blocks are flat.
/// The ceiling may move from block to block, as a limiter's does.
pub(crate) fn flattened(blocks: &[Block], signal: &[f64], quantum: f64) -> usize {
    let top = blocks.iter().fold(0.0f64, |m, b| m.max(b.amplitude));
    let Some(from) = blocks.iter().position(|b| b.amplitude >= 0.9 * top) else { return 0 };
    let mut end = 0;
    for (i, block) in blocks.iter().enumerate().skip(from) {
        if is_flat(block, &signal[block.first..block.end], quantum) {
            end = i + 1;
        } else if i >= end.max(from) + 2 {
            break;
        }
    }
    // The last crests to touch the ceiling are too briefly flat to be told from round ones.
    if end == 0 { 0 } else { (end + (end - from).div_ceil(20)).min(blocks.len()) }
}

/// Whether one crest in eight or more, and two at least, repeats one value for
/// longer than the crest of a sinusoid on the converter's steps would.
fn is_flat(block: &Block, signal: &[f64], quantum: f64) -> bool {
    let cycles = block.omega * block.span_s / std::f64::consts::TAU;
    let a = block.amplitude;
    if !(cycles > 0.0 && a > 8.0 * quantum) {
        return false;
    }
    // cos stays within one step q of its crest for an angle 2 sqrt(2 q/A).
    let natural = signal.len() as f64 / cycles * (2.0 * quantum / a).sqrt() / std::f64::consts::PI;
    let least = (2.5 * natural).max(4.0) as usize;
    let plateaus = signal
        .chunk_by(|x, y| x == y)
        .filter(|run| run.len() >= least && (run[0] - block.offset).abs() > 0.5 * a)
        .count();
    plateaus >= 2 && plateaus as f64 >= cycles / 8.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_is_counted_across_the_edges_of_chunks() {
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
    fn a_falling_ceiling_is_seen_and_a_converters_steps_are_not() {
        let block = |first: usize, amplitude: f64| Block {
            omega: std::f64::consts::TAU / 100.0,
            span_s: 1000.0,
            amplitude,
            ..Block::of(first, first + 1000, first as f64 + 500.0)
        };
        let step = 1.0 / 128.0;
        let motion = |ceiling: f64| -> Vec<f64> {
            (0..10_000)
                .map(|i| {
                    let t = f64::from(i);
                    let x = (-t / 8000.0).exp() * (std::f64::consts::TAU * t / 100.0).cos();
                    let limit = ceiling * (1.0 - t / 40_000.0);
                    (x.clamp(-limit, limit) / step).round() * step
                })
                .collect()
        };
        let blocks: Vec<Block> = (0..10).map(|k| block(1000 * k, (-(k as f64 + 0.5) / 8.0).exp())).collect();
        assert_eq!(flattened(&blocks, &motion(2.0), step), 0);
        let limited: Vec<Block> =
            blocks.iter().map(|b| Block { amplitude: b.amplitude.min(0.7), ..*b }).collect();
        let found = flattened(&limited, &motion(0.6), step);
        // The decay meets the ceiling 0.6 (1 - t/40000) at about 5000.
        assert!((4..=7).contains(&found), "{found}");
    }
}

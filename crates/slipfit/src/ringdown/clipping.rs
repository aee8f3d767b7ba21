//! Clipping: samples cut off at the ends of the converter's range, or by a limiter whose level moves.

use super::Answer;
use super::criteria::ClippingCriteria;
use super::sampled_signal::{PIECE, SampledSignal};
use super::samples::Samples;
use crate::signal::blocks::{Block, noise_rms};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Number of levels next to an extreme that it is compared with.
const NEXT_LEVELS: usize = 4;

/// The levels beyond which a record has no samples because its range ends there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ceiling {
    low: Option<f64>,
    high: Option<f64>,
}

impl Ceiling {
    fn holds(&self, v: f64) -> bool {
        self.low == Some(v) || self.high == Some(v)
    }

    /// Whether an oscillation of this amplitude about an offset reaches it.
    fn is_reached(&self, offset: f64, amplitude: f64) -> bool {
        self.low.is_some_and(|low| offset - amplitude < low)
            || self.high.is_some_and(|high| offset + amplitude > high)
    }
}

/// An extreme of a record is the end of its range if samples stay at it, or if crests return to it many times
/// and to the next level far less often (the crests of a decay sweep over the levels).
fn ceiling(signal: &SampledSignal, criteria: &ClippingCriteria) -> Option<Ceiling> {
    let (low, high) = signal.extremes();
    let (mut samples, mut runs, mut long_runs) = ([0; 2], [0; 2], 0);
    let (mut length, mut last) = (0, None);
    let mut widest_gap = 0;
    let pieces = signal.extremes_of_pieces().iter().enumerate();
    for (piece, _) in pieces.filter(|(_, e)| e.0 == low || e.1 == high) {
        for (i, &v) in signal.iter().enumerate().skip(piece * PIECE).take(PIECE) {
            if v != high && v != low {
                continue;
            }
            let side = usize::from(v == high);
            samples[side] += 1;
            // A run continues across the edge of a piece, since its value is an extreme of both pieces.
            let same_run = last.is_some_and(|last| last + 1 == i && signal[last] == v);
            length = if same_run { length + 1 } else { 1 };
            if !same_run {
                widest_gap = widest_gap.max(last.map_or(0, |last| i - last));
            }
            runs[side] += usize::from(!same_run);
            long_runs += usize::from(length == criteria.run);
            last = Some(i);
        }
    }
    let stays = long_runs >= criteria.runs;
    // A single sample at an extreme is no evidence of clipping on that side.
    let repeated: Vec<usize> = (0..2).filter(|&side| samples[side] > 1).collect();
    let returns: usize = repeated.iter().map(|&side| runs[side]).sum();
    let returned: usize = repeated.iter().map(|&side| samples[side]).sum();
    // Crests follow each other; a few glitches do not.
    let one_after_another = widest_gap * returns < criteria.gap_ratio * returned;
    let least = if one_after_another { criteria.crest_runs } else { criteria.return_runs };
    let comes_back = returns >= least
        && returned >= criteria.returns
        && repeated.iter().all(|&side| {
            let next = most_at_next_levels(signal, [-1.0, 1.0][side]);
            samples[side] as f64 >= criteria.return_ratio * next as f64
        });
    let found = |side: usize, level: f64| (stays || comes_back && samples[side] > 1).then_some(level);
    let found = Ceiling { low: found(0, low), high: found(1, high) };
    (found.low.is_some() || found.high.is_some()).then_some(found)
}

/// Largest number of samples at one of the few levels next to the highest (sign 1) or lowest (sign -1).
fn most_at_next_levels(signal: &[f64], sign: f64) -> usize {
    let mut levels = [(f64::NEG_INFINITY, 0); NEXT_LEVELS + 1];
    for v in signal.iter().map(|v| sign * v) {
        if v < levels[NEXT_LEVELS].0 {
            continue;
        }
        match levels.iter().position(|(level, _)| v >= *level) {
            Some(k) if levels[k].0 == v => levels[k].1 += 1,
            Some(k) => {
                levels[k..].rotate_right(1);
                levels[k] = (v, 1);
            }
            None => {}
        }
    }
    levels[1..].iter().map(|(_, count)| *count).max().unwrap_or(0)
}

/// Number of samples at the ends of the range, and whether some of them lie in a window.
pub(crate) fn clipped_samples(
    signal: &SampledSignal,
    window: Range<usize>,
    criteria: &ClippingCriteria,
) -> (usize, bool) {
    let Some(ceiling) = ceiling(signal, criteria) else { return (0, false) };
    let clipped = |v: &&f64| ceiling.holds(**v);
    (signal.iter().filter(clipped).count(), signal[window].iter().any(|v| clipped(&v)))
}

/// Clipped crests detected with the fitted motion: two or three are too few to establish the range by
/// themselves, but the motion fitted to samples at its end exceeds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClippedCrests {
    pub(crate) samples: usize,
    /// Time of the last of them.
    pub(crate) end_s: f64,
}

/// Samples of the fitted window that stay at an extreme of the record while the fitted motion exceeds this
/// extreme by more than the noise.
pub(crate) fn clipped_crests(
    samples: &Samples,
    answer: &Answer,
    criteria: &ClippingCriteria,
) -> Option<ClippedCrests> {
    let (_, high) = samples.signal.extremes();
    let window = answer.segment.start_s..=answer.segment.end_s;
    let mut found = ClippedCrests { samples: 0, end_s: f64::NEG_INFINITY };
    let (mut beyond, mut runs) = (0.0, 0);
    let mut from = 0;
    while let Some(first) = samples.signal.next_extreme(from) {
        let level = samples.signal[first];
        let length = samples.signal[first..].iter().take_while(|x| **x == level).count();
        from = first + length;
        let side = if level == high { 1.0 } else { -1.0 };
        if length < criteria.cut_run {
            continue;
        }
        let times = samples.time[first..from].iter().filter(|t| window.contains(t));
        let before = found.samples;
        for &t in times {
            beyond += side * (answer.fit.signal_at(t) - level);
            (found.samples, found.end_s) = (found.samples + 1, t);
        }
        runs += usize::from(found.samples > before);
    }
    let margin = criteria.cut_errors * answer.diagnostics.noise_rms;
    (runs >= criteria.cut_runs && beyond > margin * found.samples as f64).then_some(found)
}

/// Number of first blocks that are clipped or precede clipped ones. `None` if there are none, or if too few
/// blocks remain after them.
pub(crate) fn clipped_blocks(
    blocks: &[Block],
    signal: &SampledSignal,
    converter_step: f64,
    criteria: &ClippingCriteria,
) -> Option<usize> {
    let mut clipped = flattened(blocks, signal, converter_step, criteria);
    if let Some(ceiling) = ceiling(signal, criteria) {
        let first = first_large(blocks, signal, criteria)?;
        // A crest clipped for one or two samples looks round, but touches the ceiling.
        let mut reach = clipped.max(first);
        for (i, block) in blocks.iter().enumerate().skip(reach) {
            let part = reach.saturating_sub(first).div_ceil(criteria.straggler_part);
            if i > reach + part.max(criteria.round_blocks) {
                break;
            }
            if signal[block.first..block.end].iter().any(|v| ceiling.holds(*v)) {
                (clipped, reach) = (i + 1, i + 1);
            }
        }
        if clipped > 0 {
            // Of the crests near the ceiling, only those lowered by noise have not touched it.
            let margin = criteria.margin_errors * noise_rms(&blocks[clipped.min(blocks.len() - 1)..]);
            let near = |b: &&Block| ceiling.is_reached(b.offset, b.amplitude + margin);
            clipped += blocks[clipped..].iter().take_while(near).count();
        }
    }
    (clipped > 0 && blocks.len() >= clipped + criteria.least_after).then_some(clipped)
}

/// The first block about as large as the largest, ignoring noise blocks whose amplitude exceeds what the
/// range of the samples allows: the fundamental of a square wave is `4/pi` of half its range.
fn first_large(blocks: &[Block], signal: &SampledSignal, criteria: &ClippingCriteria) -> Option<usize> {
    let (low, high) = signal.extremes();
    let most = 2.0 / PI * (high - low);
    let amplitudes = blocks.iter().map(|b| b.amplitude).filter(|a| *a <= most);
    let large = criteria.from_amplitude * amplitudes.fold(0.0, f64::max);
    blocks.iter().position(|b| b.amplitude >= large && b.amplitude <= most)
}

/// Counts the blocks from the first large one as long as their crests are flat. The ceiling may move from
/// block to block, as that of a limiter does.
fn flattened(
    blocks: &[Block],
    signal: &SampledSignal,
    converter_step: f64,
    criteria: &ClippingCriteria,
) -> usize {
    let Some(from) = first_large(blocks, signal, criteria) else { return 0 };
    let mut end = 0;
    for (i, block) in blocks.iter().enumerate().skip(from) {
        if is_flat(block, &signal[block.first..block.end], converter_step, criteria) {
            end = i + 1;
        } else if i >= end.max(from) + criteria.round_blocks {
            break;
        }
    }
    // The last crests that touch the ceiling are clipped for only one or two samples and look round.
    if end == 0 { 0 } else { (end + (end - from).div_ceil(criteria.margin_part)).min(blocks.len()) }
}

/// Whether many crests repeat one value for longer than the crest of a sinusoid quantised in the converter's
/// steps would.
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
    use crate::answer::Warning;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::window::StartReason;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Parameter, Record};

    #[test]
    fn clipping_is_counted_across_the_edges_of_chunks() {
        let within = |signal: &[f64], window| {
            clipped_samples(&SampledSignal::new(signal), window, &ClippingCriteria::default())
        };
        let clipped = |signal: &[f64]| within(signal, 0..signal.len());
        let mut signal: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.37).sin() * 0.9).collect();
        assert_eq!(clipped(&signal), (0, false));
        signal[1020..1030].fill(1.0);
        signal[3000..3003].fill(1.0);
        signal[3500..3505].fill(-1.0);
        assert_eq!(clipped(&signal), (0, false), "two runs are no clipping");
        signal[4990..4996].fill(-1.0);
        assert_eq!(clipped(&signal), (10 + 3 + 5 + 6, true));
        assert_eq!(within(&signal, 4995..4996), (24, true));
        for outside in [0..1020, 3505..4990, 4996..5000] {
            assert_eq!(within(&signal, outside.clone()), (24, false), "{outside:?}");
        }
    }

    /// Two clipped crests of six cycles, three samples each: too few to establish a range until the fitted
    /// motion exceeds it.
    #[test]
    fn two_clipped_crests_are_left_out() {
        let (q, x_f, noise) = (30.0, 0.026, 0.01);
        let oscillator = Oscillator::kinematic(TAU * 1.7, PI * 1.7 / q, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let record = |repeat: usize| {
            let at = |i: usize| decay.displacement(i as f64 / 51.0) + noise * jitter(700 * repeat + i, 5);
            Record::uniform(51.0, (0..700).map(|i| at(i).clamp(-0.85, 0.85)).collect()).expect("valid")
        };
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, x_f);
        let answer = analyse(&record(0), &Options::default()).expect("fits");
        assert_eq!(answer.segment.start_reason, StartReason::Clipped);
        let warning = answer.warnings.iter().find(|w| matches!(w, Warning::Clipped { .. }));
        assert!(matches!(warning, Some(Warning::Clipped { samples: 4..=12, inside: false })), "{warning:?}");
    }

    /// Crests that touch the ceiling for one or two samples, as with few samples per cycle.
    #[test]
    fn a_level_that_crests_come_back_to_is_the_end_of_the_range() {
        let criteria = ClippingCriteria::default();
        let motion = |ceiling: f64, step: f64| {
            let x = |t: f64| (-t / 3000.0).exp() * (1.7 * t).cos() + 0.01 * (0.7 * t * t).sin();
            let read = |x: f64| if step > 0.0 { (x / step).round() * step } else { x };
            let values = (0..3000).map(|i| read(x(f64::from(i)).clamp(-2.0, ceiling)));
            SampledSignal::new(values.collect::<Vec<f64>>())
        };
        for step in [0.0, 1e-3, 0.02, 0.1] {
            assert_eq!(clipped_samples(&motion(2.0, step), 0..3000, &criteria), (0, false), "step {step}");
        }
        let signal = motion(0.8, 0.0);
        let at_ceiling = signal.iter().filter(|v| **v == 0.8).count();
        let end = signal.iter().rposition(|v| *v == 0.8).map_or(0, |i| i + 1);
        let (count, near_its_end) = clipped_samples(&signal, end - 1..end, &criteria);
        assert_eq!((count, near_its_end), (at_ceiling, true));
        assert!(!clipped_samples(&signal, end..3000, &criteria).1);
        assert!(count > 50, "{count} samples to {end}");
        assert!(end > 600, "{count} samples to {end}");
    }

    /// A decay through a limiter whose ceiling falls, later unclipped.
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
        let motion = |ceiling: f64| {
            let value = |i: i32| {
                let t = f64::from(i);
                let x = (-t / 8000.0).exp() * (TAU * t / 100.0).cos();
                let limit = ceiling * (1.0 - t / 40_000.0);
                (x.clamp(-limit, limit) / step).round() * step
            };
            SampledSignal::new((0..10_000).map(value).collect::<Vec<f64>>())
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

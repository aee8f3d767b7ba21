//! Extension of the decay from its seed as long as one amplitude law predicts the next blocks.

use super::seed::{SeedFit, best_run, rises, seed};
use super::{DecayWindow, EndReason, StartReason};
use crate::ringdown::block_amplitudes::BlockAmplitudes;
use crate::ringdown::criteria::WindowCriteria;
use std::ops::Range;

/// Finds the free decay among the blocks.
pub(super) fn find(amplitudes: &BlockAmplitudes, c: &WindowCriteria) -> Option<DecayWindow> {
    let smooth = amplitudes.smooth();
    let run = best_run(amplitudes, &smooth, c)?;
    let start_reason = if run.start == 0 { StartReason::RecordStart } else { StartReason::LeadIn };
    let Some(seed) = seed(&smooth, &run, c) else {
        let end_reason = end_reason(amplitudes, &smooth, run.end, c);
        return Some(DecayWindow {
            first: run.start,
            end: run.end,
            start_reason,
            end_reason,
            disturbed: false,
        });
    };
    let search = Search { amplitudes, c, run, law: SeedFit::new(amplitudes, seed.clone(), c) };
    Some(search.extend(seed, &smooth, start_reason))
}

/// The law of the blocks found so far, and the run within which they may be extended.
struct Search<'a> {
    amplitudes: &'a BlockAmplitudes<'a>,
    c: &'a WindowCriteria,
    run: Range<usize>,
    law: Option<SeedFit<'a>>,
}

impl Search<'_> {
    fn extend(mut self, seed: Range<usize>, smooth: &[f64], start_reason: StartReason) -> DecayWindow {
        let (mut end, left) = self.later(seed.clone());
        // Extended backward last, since a drive at the start would distort the law.
        self.refit(seed.start..end);
        let (first, start_reason) = self.earlier(seed.start, end, start_reason);
        let end_reason = left.unwrap_or_else(|| end_reason(self.amplitudes, smooth, end, self.c));
        if end_reason == EndReason::Noise {
            end = self.follow_into_noise(first..end);
        }
        let disturbed = left.is_none()
            && end < smooth.len()
            && rises(self.amplitudes, smooth, end, smooth[end - 1], self.c);
        DecayWindow { first, end, start_reason, end_reason, disturbed }
    }

    fn refit(&mut self, blocks: Range<usize>) {
        if let Some(law) = SeedFit::new(self.amplitudes, blocks, self.c) {
            self.law = Some(law);
        }
    }

    fn relative_deviation(&self, block: usize, tolerance: f64) -> f64 {
        self.law.as_ref().map_or(0.0, |law| law.relative_deviation(block, tolerance))
    }

    /// Accepts later blocks until several in a row deviate from the law; returns the end and how the law was
    /// left.
    fn later(&mut self, seed: Range<usize>) -> (usize, Option<EndReason>) {
        let Range { start, end: seed_end } = seed;
        let mut end = seed_end;
        let mut fitted = end - start;
        let (mut misses, mut balance) = (0, 0.0);
        for j in seed_end..self.run.end {
            let deviation = self.relative_deviation(j, self.c.later_tolerance);
            if deviation.abs() > 1.0 {
                misses += 1;
                balance += deviation.signum();
            } else {
                (misses, balance) = (0, 0.0);
                end = j + 1;
            }
            if misses >= self.c.misses {
                let left = if balance > 0.0 { EndReason::SlowTail } else { EndReason::LawChange };
                return (self.take_back(start..end), Some(left));
            }
            if end - start > fitted + fitted / 4 && misses == 0 {
                self.refit(start..end);
                fitted = end - start;
            }
        }
        (self.run.end, None)
    }

    /// Removes blocks accepted shortly before the law was left that already deviate from it.
    fn take_back(&mut self, blocks: Range<usize>) -> usize {
        let Range { start, mut end } = blocks;
        self.refit(start..end - (end - start) / 8);
        while end > start + self.c.seed_blocks
            && self.relative_deviation(end - 1, self.c.last_tolerance).abs() > 1.0
        {
            end -= 1;
        }
        end
    }

    /// Accepts earlier blocks until two in a row deviate from the law.
    fn earlier(&mut self, start: usize, end: usize, reason: StartReason) -> (usize, StartReason) {
        let mut first = start;
        let mut fitted = end - first;
        while first > self.run.start {
            let off = |block: usize| self.relative_deviation(block, self.c.earlier_tolerance).abs() > 1.0;
            if off(first - 1) && (first < self.run.start + 2 || off(first - 2)) {
                // The block next to a change of regime contains some of both.
                let margin = if end - first > self.c.lead_in_margin { 2 } else { 1 };
                return ((first + margin).min(end - 4), StartReason::LeadIn);
            }
            first -= 1;
            if end - first > fitted + fitted / 8 {
                self.refit(first..end);
                fitted = end - first;
            }
        }
        (first, reason)
    }

    /// Follows the law into the noise, where single blocks carry little information but many together do, as
    /// long as each block agrees with it and the prediction exceeds a given fraction of a block's error.
    fn follow_into_noise(&self, blocks: Range<usize>) -> usize {
        let mut end = blocks.end;
        let Some(law) = SeedFit::new(self.amplitudes, blocks, self.c) else { return end };
        while end < self.amplitudes.blocks.len() {
            let (predicted, error) = (law.predict(end), self.amplitudes.error[end]);
            let off = self.amplitudes.amplitude(end) - self.amplitudes.reading(predicted);
            // The modulus of signal plus noise scatters below A + 4 sigma.
            if predicted < self.c.noise_prediction * error || off.abs() > self.c.noise_errors * error {
                break;
            }
            end += 1;
        }
        end
    }
}

fn end_reason(amplitudes: &BlockAmplitudes, smooth: &[f64], end: usize, c: &WindowCriteria) -> EndReason {
    if end >= smooth.len() {
        return EndReason::RecordEnd;
    }
    if rises(amplitudes, smooth, end, smooth[end - 1], c) {
        return EndReason::Disturbance;
    }
    // A stop reduces the amplitude to zero within one or two blocks; noise is reached gradually.
    let back = end.saturating_sub(c.stop_blocks);
    if smooth[back] > c.stop_ratio * amplitudes.floor[end] { EndReason::Rest } else { EndReason::Noise }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;
    use crate::signal::blocks::Block;

    const NOISE: f64 = 1e-3;

    /// The window found among amplitudes at intervals of one second, with the noise of a modulus.
    fn window(amplitude: impl Fn(f64) -> f64) -> DecayWindow {
        let block = |i: usize| Block {
            amplitude: (amplitude(i as f64) + NOISE * jitter(i, 0)).hypot(NOISE * jitter(i, 1)),
            span_s: 1.0,
            unit_variance: 1.0,
            ..Block::of(100 * i, 100 * i + 100, i as f64 + 0.5)
        };
        let blocks: Vec<Block> = (0..200).map(block).collect();
        let amplitudes = BlockAmplitudes::with_floor(&blocks, 60.0, NOISE, |error| 4.0 * error);
        find(&amplitudes, &WindowCriteria::default()).expect("a decay")
    }

    #[test]
    fn a_decay_is_followed_from_the_start_of_the_record_into_noise() {
        let found = window(|t| (-t / 20.0).exp());
        assert_eq!(found.start_reason, StartReason::RecordStart);
        assert_eq!(found.end_reason, EndReason::Noise);
        assert_eq!(found.first, 0);
        // The law falls to four standard errors after 110 s.
        assert!(found.end > 110, "{}", found.end);
    }

    #[test]
    fn a_driven_lead_in_is_left_out() {
        let found = window(|t| if t < 40.0 { 1.0 } else { ((40.0 - t) / 20.0).exp() });
        assert_eq!(found.start_reason, StartReason::LeadIn);
        assert!((39..=43).contains(&found.first), "{}", found.first);
    }

    #[test]
    fn a_jolt_ends_the_decay() {
        let found = window(|t| if t < 60.0 { (-t / 40.0).exp() } else { 0.6 * ((60.0 - t) / 400.0).exp() });
        assert_eq!(found.end_reason, EndReason::Disturbance);
        assert_eq!(found.end, 60);
        assert!(found.disturbed);
    }

    #[test]
    fn a_stop_ends_the_decay_at_rest() {
        let found = window(|t| (1.0 - t / 100.0).max(0.0));
        assert_eq!(found.end_reason, EndReason::Rest);
        assert!((98..=100).contains(&found.end), "{}", found.end);
    }

    #[test]
    fn a_tail_above_the_law_ends_the_decay() {
        let found = window(|t| if t < 95.0 { 1.0 - t / 100.0 } else { 0.05 * ((95.0 - t) / 1000.0).exp() });
        assert_eq!(found.end_reason, EndReason::SlowTail);
        assert!((94..=102).contains(&found.end), "{}", found.end);
    }
}

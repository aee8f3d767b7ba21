//! The decay extended from its seed for as long as one amplitude law predicts the next blocks.

use super::seed::{SeedFit, best_run, rises, seed};
use super::{DecayWindow, EndReason, StartReason};
use crate::ringdown::block_amplitudes::BlockAmplitudes;
use crate::ringdown::criteria::WindowCriteria;
use std::ops::Range;

/// Finds the free decay among the blocks.
pub(super) fn find(seen: &BlockAmplitudes, c: &WindowCriteria) -> Option<DecayWindow> {
    let smooth = seen.smooth();
    let run = best_run(seen, &smooth, c)?;
    let start_reason = if run.start == 0 { StartReason::RecordStart } else { StartReason::LeadIn };
    let Some(seed) = seed(&smooth, &run, c) else {
        let end_reason = end_reason(seen, &smooth, run.end, c);
        return Some(DecayWindow {
            first: run.start,
            end: run.end,
            start_reason,
            end_reason,
            disturbed: false,
        });
    };
    let search = Search { seen, c, run, law: SeedFit::new(seen, seed.clone(), c) };
    Some(search.extend(seed, &smooth, start_reason))
}

/// The law of the blocks found so far, and the run that they may be extended in.
struct Search<'a> {
    seen: &'a BlockAmplitudes<'a>,
    c: &'a WindowCriteria,
    run: Range<usize>,
    law: Option<SeedFit<'a>>,
}

impl Search<'_> {
    fn extend(mut self, seed: Range<usize>, smooth: &[f64], start_reason: StartReason) -> DecayWindow {
        let (mut end, left) = self.later(seed.clone());
        // Backward only now: the start is where a drive would bend the law.
        self.refit(seed.start..end);
        let (first, start_reason) = self.earlier(seed.start, end, start_reason);
        let end_reason = left.unwrap_or_else(|| end_reason(self.seen, smooth, end, self.c));
        if end_reason == EndReason::Noise {
            end = self.into_the_noise(first..end);
        }
        let disturbed =
            left.is_none() && end < smooth.len() && rises(self.seen, smooth, end, smooth[end - 1], self.c);
        DecayWindow { first, end, start_reason, end_reason, disturbed }
    }

    fn refit(&mut self, blocks: Range<usize>) {
        if let Some(law) = SeedFit::new(self.seen, blocks, self.c) {
            self.law = Some(law);
        }
    }

    fn miss(&self, block: usize, tolerance: f64) -> f64 {
        self.law.as_ref().map_or(0.0, |law| law.miss(block, tolerance))
    }

    /// Lets later blocks in until several in a row leave the law: the end, and how it was left.
    fn later(&mut self, seed: Range<usize>) -> (usize, Option<EndReason>) {
        let Range { start, mut end } = seed;
        let mut fitted = end - start;
        let (mut misses, mut balance) = (0, 0.0);
        for j in end..self.run.end {
            let miss = self.miss(j, self.c.later_tolerance);
            if miss.abs() > 1.0 {
                misses += 1;
                balance += miss.signum();
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

    /// The last blocks let in before the law was left may already lie off it.
    fn take_back(&mut self, blocks: Range<usize>) -> usize {
        let Range { start, mut end } = blocks;
        self.refit(start..end - (end - start) / 8);
        while end > start + self.c.seed_blocks && self.miss(end - 1, self.c.last_tolerance).abs() > 1.0 {
            end -= 1;
        }
        end
    }

    /// Lets earlier blocks in until two in a row leave the law.
    fn earlier(&mut self, start: usize, end: usize, reason: StartReason) -> (usize, StartReason) {
        let mut first = start;
        let mut fitted = end - first;
        while first > self.run.start {
            let off = |block: usize| self.miss(block, self.c.earlier_tolerance).abs() > 1.0;
            if off(first - 1) && (first < self.run.start + 2 || off(first - 2)) {
                // The block beside a change of regime holds some of both.
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

    /// Follows the law on into the noise, where single blocks say little but many together still
    /// do: as long as each agrees with it and it predicts a part of a block's error.
    fn into_the_noise(&self, blocks: Range<usize>) -> usize {
        let mut end = blocks.end;
        let Some(law) = SeedFit::new(self.seen, blocks, self.c) else { return end };
        while end < self.seen.blocks.len() {
            let (predicted, error) = (law.predict(end), self.seen.error[end]);
            // The modulus of signal and noise together scatters below A + 4 sigma.
            if predicted < self.c.noise_prediction * error
                || (self.seen.amplitude(end) - predicted).abs() > self.c.noise_errors * error
            {
                break;
            }
            end += 1;
        }
        end
    }
}

fn end_reason(seen: &BlockAmplitudes, smooth: &[f64], end: usize, c: &WindowCriteria) -> EndReason {
    if end >= smooth.len() {
        return EndReason::RecordEnd;
    }
    if rises(seen, smooth, end, smooth[end - 1], c) {
        return EndReason::Disturbance;
    }
    // A stop takes the amplitude away within a block or two; noise is reached slowly.
    let back = end.saturating_sub(c.stop_blocks);
    if smooth[back] > c.stop_ratio * seen.floor[end] { EndReason::Rest } else { EndReason::Noise }
}

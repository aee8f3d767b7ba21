//! The window among all blocks, with clipped blocks left out and the requested limits applied.

use super::extend::find;
use super::{DecayWindow, EndReason, StartReason};
use crate::Error;
use crate::ringdown::Options;
use crate::ringdown::block_amplitudes::BlockAmplitudes;
use crate::ringdown::clipping;
use crate::ringdown::criteria::{BlockCriteria, Criteria};
use crate::ringdown::samples::Samples;
use crate::signal::blocks::Block;
use std::f64::consts::TAU;

/// The free decay among the blocks of an oscillation, with the amplitudes used to find it.
pub(crate) fn of_oscillation<'a>(
    blocks: &'a [Block],
    samples: &Samples,
    frequency_hz: f64,
    options: &Options,
    criteria: &Criteria,
) -> Result<(DecayWindow, BlockAmplitudes<'a>), Error> {
    let step = samples.converter_step(criteria.blocks.distinct_values);
    let amplitudes_of = |blocks: &'a [Block]| {
        BlockAmplitudes::of_oscillation(
            blocks,
            TAU * frequency_hz,
            step,
            samples.noise_rms(blocks),
            &criteria.blocks,
        )
    };
    let after_clipping = || {
        let clipped = clipping::clipped_blocks(blocks, &samples.signal, step, &criteria.clipping)?;
        let found = find(&amplitudes_of(&blocks[clipped..]), &criteria.window)?;
        let start_reason = if found.first == 0 { StartReason::Clipped } else { found.start_reason };
        Some(DecayWindow { first: found.first + clipped, end: found.end + clipped, start_reason, ..found })
    };
    let amplitudes = amplitudes_of(blocks);
    let found = if options.start_s.is_none() { after_clipping() } else { None };
    let window =
        found.or_else(|| find(&amplitudes, &criteria.window)).ok_or_else(|| Error::NotARingDown {
            cycles: 0.0,
            needed: criteria.blocks.least_cycles,
            reason: if grows(blocks, &criteria.blocks) {
                "the amplitude grows along the record; a decay must fall"
            } else {
                NOTHING_FALLS
            },
        })?;
    Ok((limited(window, &amplitudes, options), amplitudes))
}

/// The free decay among blocks of recorded amplitudes.
pub(crate) fn of_amplitudes(
    amplitudes: &BlockAmplitudes,
    options: &Options,
    criteria: &Criteria,
) -> Result<DecayWindow, Error> {
    let window = find(amplitudes, &criteria.window).ok_or(Error::NotARingDown {
        cycles: 0.0,
        needed: criteria.blocks.least_cycles,
        reason: NOTHING_FALLS,
    })?;
    Ok(limited(window, amplitudes, options))
}

const NOTHING_FALLS: &str = "no falling amplitude stands out of the noise";

/// Whether the amplitude in the last third of the record is clearly larger than in the first.
fn grows(blocks: &[Block], criteria: &BlockCriteria) -> bool {
    let third = (blocks.len() / 3).max(1);
    let mean = |part: &[Block]| part.iter().map(|b| b.amplitude).sum::<f64>() / part.len() as f64;
    mean(&blocks[blocks.len() - third..]) > criteria.growth_ratio * mean(&blocks[..third])
}

/// The window with the requested limits applied.
fn limited(mut window: DecayWindow, amplitudes: &BlockAmplitudes, options: &Options) -> DecayWindow {
    if options.start_s.is_some() {
        (window.first, window.start_reason) = (0, StartReason::Requested);
    }
    if options.end_s.is_some() {
        (window.end, window.end_reason) = (amplitudes.blocks.len(), EndReason::Requested);
        window.disturbed = false;
    }
    let least = options.min_amplitude.unwrap_or(0.0);
    if let Some(end) = (window.first..window.end).find(|&i| amplitudes.amplitude(i) < least) {
        (window.end, window.end_reason) = (end, EndReason::LeastAmplitude);
        window.disturbed = false;
    }
    window
}

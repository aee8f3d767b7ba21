//! The free decay among the blocks: the decisions on where it starts and where it ends.
//!
//! Along a free decay the loss is a function of the amplitude alone. A driven lead-in, a hand, a jolt and a
//! rest all violate this. The decisions, in order:
//!
//! 1. [`seed`]: the run of blocks with the largest fall, and an amplitude law through its middle;
//! 2. [`extend`]: the seed, extended as long as its law predicts the next blocks;
//! 3. [`decide`]: clipped blocks left out, and the requested limits;
//! 4. [`by_law`]: once the law is known, first blocks that belong to a drive, and a time at which
//!    one law changes to another;
//! 5. [`by_waveform`]: the window in which the residuals of the exact motion are noise.

pub(crate) mod by_law;
pub(crate) mod by_waveform;
pub(crate) mod decide;
mod extend;
mod reason;
mod seed;

pub use reason::{EndReason, StartReason};

/// Blocks `first..end` are the free decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DecayWindow {
    pub(crate) first: usize,
    pub(crate) end: usize,
    pub(crate) start_reason: StartReason,
    pub(crate) end_reason: EndReason,
    /// Whether the amplitude jumps up after the end.
    pub(crate) disturbed: bool,
}

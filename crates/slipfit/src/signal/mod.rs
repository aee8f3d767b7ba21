//! From samples to amplitude and phase.

pub(crate) mod blocks;
pub(crate) mod phase;
pub(crate) mod spectrum;
pub(crate) mod trig;
pub(crate) mod wide;

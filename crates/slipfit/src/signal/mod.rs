//! From samples to amplitude and phase.

pub(crate) mod blocks;
pub(crate) mod criteria;
pub mod demodulate;
mod fourier;
pub(crate) mod noise_density;
pub(crate) mod phase;
pub(crate) mod phase_step;
pub(crate) mod phase_walk;
pub(crate) mod spectrum;
mod transform;

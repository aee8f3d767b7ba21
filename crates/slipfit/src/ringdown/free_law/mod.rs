//! The model-free law: loss against amplitude as determined by the amplitudes alone.

mod answer;
pub(super) mod criteria;
mod curve;
mod estimate;
mod measured;
mod problem;

pub use answer::{FreeLaw, FreeLossPoint};
pub(super) use measured::free_law;

//! The law without a model: loss against amplitude as the amplitudes themselves give it.

mod answer;
pub(super) mod criteria;
mod curve;
mod estimate;
mod measured;
mod problem;

pub use answer::{FreeLaw, FreeLossPoint};
pub(super) use measured::free_law;

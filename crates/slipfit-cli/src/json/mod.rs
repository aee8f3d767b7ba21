//! The JSON contract: what it holds is written down in docs/schema.

mod contract;
mod curve;
mod layout;
mod levels;
mod node;
mod resonance;
mod ringdown;
mod series;

pub(crate) use layout::write;
pub(crate) use levels::levels;
pub(crate) use resonance::{method, resonance};
pub(crate) use ringdown::ringdown;
pub(crate) use series::series;

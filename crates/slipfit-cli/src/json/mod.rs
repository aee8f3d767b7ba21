//! The JSON contract: what it holds is written down in docs/schema.

mod contract;
mod layout;
mod ringdown;

pub(crate) use layout::write;
pub(crate) use ringdown::ringdown;

//! The JSON contract: what it holds is written down in docs/schema.

mod contract;
mod curve;
mod layout;
mod levels;
mod node;
mod resonance;
mod ringdown;
mod series;

pub use layout::write;
pub use levels::levels;
pub(crate) use resonance::method;
pub use resonance::resonance;
pub use ringdown::ringdown;
pub use series::series;

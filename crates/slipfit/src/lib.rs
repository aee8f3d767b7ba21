//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.
pub mod error;
pub mod record;

pub use error::Error;
pub use record::{Record, SignalKind};
pub mod estimate;
pub mod format;
pub mod quantity;
pub mod ringdown;

pub use quantity::Quantity;

//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.

pub mod decay;
pub mod error;
pub mod estimate;
pub mod oscillator;
pub mod quantity;
pub mod record;
pub mod ringdown;
pub(crate) mod signal;

pub use error::Error;
pub use quantity::Quantity;
pub use record::{Clock, ClockReport, Gap, Record, SignalKind};

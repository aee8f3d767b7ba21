//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.
pub mod decay;
mod double_double;
pub mod error;
pub mod oscillator;
pub mod record;

pub use error::Error;
pub use oscillator::Oscillator;
pub use record::{Record, SignalKind};

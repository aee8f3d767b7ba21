//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.

pub mod decay;
pub mod demodulate;
mod double_double;
pub mod error;
pub mod estimate;
pub mod format;
pub mod levels;
#[cfg(test)]
mod noise;
pub mod oscillator;
pub mod paper;
mod physical;
mod quadrature;
pub mod quantity;
pub mod record;
pub mod resonance;
pub mod ringdown;
pub mod series;
mod signal;
pub mod simulate;
pub mod steady;

pub use error::Error;
pub use oscillator::Oscillator;
pub use quantity::Quantity;
pub use record::{Clock, ClockReport, Gap, Record, SignalKind};

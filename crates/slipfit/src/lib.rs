//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.
pub mod error;
pub mod record;

pub use error::Error;
pub use record::{Clock, ClockReport, Record, SignalKind};

//! Tells sliding (Coulomb, dry) friction from viscous damping in any oscillator.

pub mod answer;
pub mod error;
mod inference;
pub mod levels;
pub mod model;
pub mod motion;
#[cfg(test)]
mod noise;
mod numeric;
pub mod paper;
pub mod record;
pub mod resonance;
pub mod ringdown;
pub mod series;
pub mod signal;

pub use answer::calibration::Calibration;
pub use answer::quantity::Quantity;
pub use answer::{Parameter, Parameters};
pub use error::Error;
pub use inference::criteria::{Criterion, InferenceCriteria};
pub use model::loss::{LossModel, LossTerm};
pub use model::oscillator::Oscillator;
pub use record::{Clock, ClockReport, Gap, Record, SignalKind};

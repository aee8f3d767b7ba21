//! Ring-down: from samples of a free decay to how much of the loss is viscous
//! and how much is sliding.

mod answer;
mod fitted;
pub(crate) mod law;
mod model;
mod options;
#[cfg(test)]
mod sample;
mod sentence;
mod warning;

pub use answer::{
    Answer, Backbone, Candidate, Diagnostics, EnvelopePoint, LossPoint, OtherMode, Parameter, Segment,
    SlidingEvidence, Stop,
};
pub use fitted::FittedMotion;
pub use model::LossModel;
pub use options::{Calibration, LowPass, Options};
pub use warning::Warning;

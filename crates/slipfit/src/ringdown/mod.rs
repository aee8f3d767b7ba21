//! Ring-down: from samples of a free decay to how much of the loss is viscous
//! and how much is sliding.

mod along;
mod amplitude_fit;
mod analyse;
mod answer;
mod assemble;
mod clipping;
mod compare;
mod direct;
mod doubts;
mod envelope;
mod fits;
mod fitted;
pub(crate) mod law;
mod lead_in;
mod lowpass;
mod measure;
mod options;
mod quantities;
#[cfg(test)]
mod sample;
mod segment;
mod sentence;
mod short;
mod warning;
mod waveform;
mod waveform_fit;

pub use analyse::analyse;
pub use answer::{
    Answer, Backbone, Diagnostics, Distortion, EnvelopePoint, LossPoint, OtherMode, Segment, Stop,
};
pub use direct::{Decay, DecayFit, EnvelopeFit, EnvelopeStart, fit_envelope, fit_waveform};
pub use fitted::FittedMotion;
pub use options::{LowPass, Options};
pub use warning::Warning;

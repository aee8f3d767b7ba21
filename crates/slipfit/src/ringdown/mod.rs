//! Ring-down: determines from the samples of a free decay how much of the loss is viscous and how much is
//! sliding.

mod active_part;
mod amplitude_fit;
mod analyse;
mod answer;
mod assemble;
mod band;
mod baseline;
mod block_amplitudes;
mod clipping;
mod cluster_jackknife;
mod coloured_noise;
mod compare;
pub mod criteria;
mod curve_estimate;
mod decay_series;
mod described;
mod direct;
mod envelope;
mod evidence;
mod few_cycles;
mod fitted;
mod free_law;
mod further_laws;
mod gathered;
mod hypotheses;
mod last_swing;
mod level;
pub(crate) mod lowpass;
mod measured;
mod misfit;
mod nuisance_selection;
mod options;
mod oscillation;
mod other_motion;
mod quantities;
mod recorded_amplitudes;
mod release;
mod residuals;
mod sampled_signal;
mod samples;
mod second_mode;
mod sensor_curve;
mod sensor_nonlinearity;
mod spikes;
mod squared_reading;
mod steady_line;
mod stop;
mod two_modes;
mod unresolved;
mod wandering_phase;
mod warnings;
mod waveform;
mod waveform_fit;
mod window;
mod window_fit;

pub use analyse::{analyse, analyse_with};
pub use answer::{
    Answer, Backbone, Diagnostics, Distortion, EnvelopePoint, LossPoint, Mode, OtherMode, Segment, Stop,
};
pub use criteria::{Criteria, TraceCriteria};
pub use direct::{
    AmplitudeFit, Decay, DecayFit, EnvelopeFit, EnvelopeStart, EvenTraces, Sampling, fit_amplitudes,
    fit_envelope, fit_waveform,
};
pub use fitted::FittedMotion;
pub use free_law::{FreeLaw, FreeLossPoint};
pub use options::{LawOption, LowPass, Options};
pub use sensor_curve::SensorCurve;
pub use window::{EndReason, StartReason};

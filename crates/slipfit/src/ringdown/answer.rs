//! The answer to a ring-down: parameters, evidence, warnings.

use super::free_law::FreeLaw;
use super::sensor_curve::SensorCurve;
use super::window::{EndReason, StartReason};
use crate::Quantity;
use crate::answer::columns::columns;
use crate::answer::comparison::correlation;
use crate::answer::{Candidate, Correlation, Misfit, Parameter, Parameters, SlidingEvidence, Warning};
use crate::model::loss::LossModel;

/// The part of the record used as free decay, and the reasons for its limits.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Segment {
    /// First instant used, s on the record's clock.
    pub start_s: f64,
    /// Last instant used, s on the record's clock.
    pub end_s: f64,
    /// Number of samples in the segment.
    pub samples: usize,
    /// Why it starts there.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub start_reason: StartReason,
    /// Why it ends there.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub end_reason: EndReason,
    /// Number of cycles in the segment; zero for bare envelopes and lock-in records, whose samples show none.
    pub cycles: f64,
}

/// Amplitude of one short stretch of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EnvelopePoint {
    /// Middle of the stretch, s on the record's clock.
    pub time_s: f64,
    /// Measured amplitude, signal unit.
    pub amplitude: f64,
    /// Its standard error from noise alone.
    pub std_error: f64,
    /// Amplitude of the chosen model, evaluated for this stretch of the fitted motion; NaN outside the
    /// segment.
    pub fitted: f64,
    /// Local frequency, Hz; NaN if it cannot be determined.
    pub frequency_hz: f64,
    /// Whether the point lies in the fitted segment.
    pub used: bool,
}

/// Loss per cycle against amplitude, measured and predicted by the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LossPoint {
    /// Amplitude, signal unit.
    pub amplitude: f64,
    /// Measured amplitude lost per cycle, signal unit.
    pub loss_per_cycle: f64,
    /// Standard error of it.
    pub std_error: f64,
    /// Total loss per cycle of the model.
    pub fitted: f64,
    /// Sliding part of the model's loss per cycle.
    pub fitted_sliding: f64,
}

/// Frequency against amplitude, `f(A) = f_0 (1 + c2 A² + c4 A⁴)`.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Backbone {
    /// Frequency at vanishing amplitude, Hz.
    pub frequency_at_zero_hz: f64,
    /// Frequency at the first amplitude used, Hz.
    pub frequency_at_start_hz: f64,
    /// Relative change per squared amplitude, c2; zero when none is needed.
    pub quadratic: f64,
    /// Relative change per fourth power, c4; zero when none is needed.
    pub quartic: f64,
    /// Relative change of frequency with time, 1/s; zero when none is needed.
    pub drift_per_s: f64,
}

/// Where and when the motion came to rest, if the record shows it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Stop {
    /// Instant of the last turning point, s on the record's clock.
    pub time_s: f64,
    /// Rest position minus the centre of the oscillation, signal unit.
    pub position: f64,
    /// Standard error of the position.
    pub position_std_error: f64,
    /// Lower and upper bound of the static friction displacement F_s/k, if the record shows them (last moving
    /// and first resting turning point), signal unit.
    pub static_displacement: Option<[f64; 2]>,
}

/// How well the model describes the data.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnostics {
    /// `waveform` (every sample against the exact motion) or `envelope`
    /// (phase left free, amplitudes of short stretches).
    pub method: &'static str,
    /// Noise of one sample as estimated inside short stretches, signal unit; the residual rms of the motion
    /// if it is less than half of that estimate.
    pub noise_rms: f64,
    /// Ratio of the noise variance near the frequency of the motion to that inside short stretches; 1 if the
    /// amplitudes scatter by no more. The intervals include it.
    pub noise_inflation: f64,
    /// Losses that the reported model lacks and the data do not exclude; the intervals include them. `None`
    /// if they widen none of the intervals by a tenth, or if the model was requested.
    pub counted_losses: Option<LossModel>,
    /// Rms residual of the chosen model, signal unit.
    pub residual_rms: f64,
    /// Ratio of the variance of the fundamental's residual to that expected for white noise; the intervals
    /// are widened by its square root if it exceeds one.
    pub residual_excess: f64,
    /// Probability that white noise alone gives such an excess, given the number of residuals.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) excess_by_chance: f64,
    /// Lag-one autocorrelation of the residuals.
    pub residual_autocorrelation: f64,
    /// Size and shape of the amplitudes' deviation from the law, if it is above the noise.
    pub misfit: Option<Misfit>,
    /// Root mean square of the motion at the start relative to the noise, dB.
    pub signal_to_noise_db: f64,
    /// Decay times recorded: ln of the ratio of the first to the last amplitude used; the latter is limited
    /// from below to its standard error.
    pub decay_times: f64,
    /// Whether the amplitude falls at all, judged by the decay times.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub falls: bool,
    /// Whether a law describes the amplitudes at all; evidence for friction requires it.
    pub law_holds: bool,
    /// Number of short stretches left out because they lie far from every law (glitches).
    pub left_out: usize,
    /// Number of samples of an acceleration record that were not counted because they lie next to a turning
    /// point, where friction makes the acceleration jump.
    pub samples_at_turns: usize,
    /// Other modes not explained by noise: frequency (Hz) and strength relative to the main one.
    pub other_modes: Vec<OtherMode>,
    /// Strongest harmonic of the motion, up to the fifth, if it can be distinguished from the main line and
    /// from noise.
    pub distortion: Option<Distortion>,
}

/// Another oscillation in the record.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OtherMode {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude relative to the main mode's.
    pub relative_amplitude: f64,
}

/// A viscous mode in addition to the analysed motion.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Mode {
    /// Frequency.
    pub frequency: Quantity,
    /// Decay rate.
    pub decay_rate: Quantity,
    /// Amplitude at the start of the free decay.
    pub amplitude: Quantity,
}

/// A harmonic of the motion, caused by nonlinear sensors, hardening springs or joints that hit stops.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Distortion {
    /// Multiple of the frequency.
    pub order: usize,
    /// Amplitude relative to the fundamental's.
    pub relative_amplitude: f64,
}

columns! {
    envelope_columns of crate::ringdown::EnvelopePoint {
        time_s: f64, amplitude: f64, std_error: f64, fitted: f64, frequency_hz: f64, used: bool,
    }
}
columns! {
    loss_columns of crate::ringdown::LossPoint {
        amplitude: f64, loss_per_cycle: f64, std_error: f64, fitted: f64, fitted_sliding: f64,
    }
}

/// Result of [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// The model reported.
    pub model: LossModel,
    /// The simplest model that the data support: the one of lowest BIC. Unless a model was requested, the
    /// reported model also has viscous and sliding loss, at zero if the data do not require them, so that the
    /// error of each includes the uncertainty of the other.
    pub preferred_model: LossModel,
    /// Parameters by name, in reading order.
    pub parameters: Parameters,
    /// All models, best first.
    pub comparison: Vec<Candidate>,
    /// Evidence for sliding friction.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::answer::serialise::decay_evidence"))]
    #[cfg_attr(feature = "schema", schemars(with = "crate::answer::serialise::DecayEvidence"))]
    pub sliding: SlidingEvidence,
    /// Correlations between the estimated parameters, by pairs of names.
    pub correlations: Vec<Correlation>,
    /// The stretch used.
    pub segment: Segment,
    /// Amplitudes along the whole record.
    #[cfg_attr(feature = "serde", serde(serialize_with = "envelope_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "envelope_columns::Columns"))]
    pub envelope: Vec<EnvelopePoint>,
    /// Loss per cycle against amplitude.
    #[cfg_attr(feature = "serde", serde(serialize_with = "loss_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "loss_columns::Columns"))]
    pub loss: Vec<LossPoint>,
    /// Loss against amplitude without a model for it, if requested.
    pub free_law: Option<FreeLaw>,
    /// Frequency against amplitude; `None` for a bare envelope.
    pub backbone: Option<Backbone>,
    /// The stop, if the record shows it.
    pub stop: Option<Stop>,
    /// A second, weaker mode if one mode does not describe the record: every other field is about the
    /// stronger one, with this one subtracted.
    pub second_mode: Option<Mode>,
    /// Nonlinearity of the sensor, if the motion shows it: amplitudes and friction displacement are those of
    /// the straightened reading.
    pub sensor_curve: Option<SensorCurve>,
    /// Quality of the fit.
    pub diagnostics: Diagnostics,
    /// What limits the answer.
    pub warnings: Vec<Warning>,
    /// Unit of the signal.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub signal_unit: String,
    /// The fitted waveform, to be evaluated at any instant.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub fit: super::FittedMotion,
    /// Standard errors with no loss constrained; the correlations refer to these.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) unbounded_errors: Vec<(Parameter, f64)>,
}

impl Answer {
    /// The standard error of a loss without the constraints on its sign.
    pub(crate) fn unbounded_error(&self, parameter: Parameter) -> Option<f64> {
        self.unbounded_errors.iter().find(|(known, _)| *known == parameter).map(|(_, error)| *error)
    }

    /// The value of a parameter, if the analysis reports it.
    pub fn parameter(&self, parameter: Parameter) -> Option<&Quantity> {
        self.parameters.get(parameter)
    }

    /// The correlation of two estimated parameters, in either order.
    pub fn correlation(&self, a: Parameter, b: Parameter) -> Option<f64> {
        correlation(&self.correlations, a, b)
    }
}

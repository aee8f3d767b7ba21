//! The answer to a ring-down: parameters, evidence, warnings.

use super::free_law::FreeLaw;
use super::sensor_curve::SensorCurve;
use super::window::{EndReason, StartReason};
use crate::Quantity;
use crate::answer::columns::columns;
use crate::answer::comparison::correlation;
use crate::answer::{Candidate, Correlation, Misfit, Parameter, Parameters, SlidingEvidence, Warning};
use crate::model::loss::LossModel;

/// The part of the record taken as free decay, and why it starts and ends where it does.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Segment {
    /// First instant used, s on the record's clock.
    pub start_s: f64,
    /// Last instant used, s on the record's clock.
    pub end_s: f64,
    /// Samples inside.
    pub samples: usize,
    /// Why it starts there.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub start_reason: StartReason,
    /// Why it ends there.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub end_reason: EndReason,
    /// Cycles inside; zero for bare envelopes and lock-in records, whose samples show none.
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
    /// Amplitude of the chosen model, as this stretch of the fitted motion has it; NaN outside the segment.
    pub fitted: f64,
    /// Local frequency, Hz; NaN where none can be told.
    pub frequency_hz: f64,
    /// Whether the point lies in the fitted segment.
    pub used: bool,
}

/// Loss per cycle against amplitude, measured and by the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LossPoint {
    /// Amplitude, signal unit.
    pub amplitude: f64,
    /// Measured amplitude lost per cycle, signal unit.
    pub loss_per_cycle: f64,
    /// Standard error of it.
    pub std_error: f64,
    /// The model's: total.
    pub fitted: f64,
    /// The model's: the sliding part.
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

/// Where and when the motion came to rest, when the record shows it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Stop {
    /// Instant of the last turning point, s on the record's clock.
    pub time_s: f64,
    /// Rest position less the middle of the oscillation, signal unit.
    pub position: f64,
    /// Standard error of the position.
    pub position_std_error: f64,
    /// Static friction displacement F_s/k lies between these, if the record
    /// tells (last moving and first resting turning point), signal unit.
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
    /// Noise of one sample as estimated inside short stretches, signal unit; that which the motion leaves where it leaves
    /// less than half of it.
    pub noise_rms: f64,
    /// Variance of the noise about the frequency of the motion over that inside short stretches; 1
    /// where the amplitudes scatter by no more. Intervals count it.
    pub noise_inflation: f64,
    /// Losses that the reported model has not and the data do not exclude: the intervals count them. None
    /// where they widen none of them by a tenth, or the model was asked for.
    pub counted_losses: Option<LossModel>,
    /// Residual of the chosen model, signal unit.
    pub residual_rms: f64,
    /// Variance of the fundamental's residual over what white noise gives; the
    /// intervals are widened by its root where it exceeds one.
    pub residual_excess: f64,
    /// Probability that white noise alone leaves as much, by the number of residuals.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) excess_by_chance: f64,
    /// First autocorrelation of the residuals.
    pub residual_autocorrelation: f64,
    /// How far the amplitudes lie off the law and in what shape, where that is above the noise.
    pub misfit: Option<Misfit>,
    /// Root mean square of the motion at the start over the noise, dB.
    pub signal_to_noise_db: f64,
    /// Decay times recorded: ln of the first over the last amplitude used, which counts no lower than its
    /// standard error.
    pub decay_times: f64,
    /// Whether the amplitude falls at all by them.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub falls: bool,
    /// Whether a law describes the amplitudes at all; evidence for friction rests on it.
    pub law_holds: bool,
    /// Short stretches left out because they lie far off every law (glitches).
    pub left_out: usize,
    /// Samples of an acceleration that did not count because they lie beside a turning point, where friction makes
    /// it jump.
    pub samples_at_turns: usize,
    /// Other modes that noise does not explain: frequency (Hz) and strength relative to the main one.
    pub other_modes: Vec<OtherMode>,
    /// Strongest harmonic of the motion, up to the fifth, where it can be told
    /// from the main line and from noise.
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

/// A viscous mode beside the motion that is analysed.
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

/// A harmonic of the motion: sensors bend, springs harden, joints hit stops.
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

/// Everything [`analyse`](super::analyse) found out.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// The model reported.
    pub model: LossModel,
    /// The simplest model that the data support: that of lowest BIC. Without a model asked for, the one
    /// reported has viscous and sliding loss besides, at zero where the data want none, so that the
    /// error of each counts what is not known of the other.
    pub preferred_model: LossModel,
    /// Parameters by name, in the order they should be read.
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
    /// Loss against amplitude without a model of it, where it was asked for.
    pub free_law: Option<FreeLaw>,
    /// Frequency against amplitude; `None` for a bare envelope.
    pub backbone: Option<Backbone>,
    /// The stop, if the record shows it.
    pub stop: Option<Stop>,
    /// A second, weaker mode where one does not describe the record: every other field is about the
    /// stronger one, with this one subtracted.
    pub second_mode: Option<Mode>,
    /// How the sensor bends, where the motion shows it: amplitudes and friction displacement are those of the
    /// straightened reading.
    pub sensor_curve: Option<SensorCurve>,
    /// Quality of the description.
    pub diagnostics: Diagnostics,
    /// What limits the answer.
    pub warnings: Vec<Warning>,
    /// Unit of the signal.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub signal_unit: String,
    /// The fitted waveform, to be evaluated at any instant.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub fit: super::FittedMotion,
    /// Standard errors with no loss limited, which belong to the correlations.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) unbounded_errors: Vec<(Parameter, f64)>,
}

impl Answer {
    /// The standard error of a loss with the limits lifted.
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

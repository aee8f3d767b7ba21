//! The answer to a resonance curve: parameters, evidence, warnings.

use super::Method;
use super::fitted::FittedCurve;
use crate::Quantity;
use crate::answer::columns::columns;
use crate::answer::comparison::correlation;
use crate::answer::{Candidate, Correlation, Parameter, Parameters, SlidingEvidence, Warning};
use crate::model::loss::LossModel;

/// Where the drive amplitude came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum DriveSource {
    /// Given.
    Known,
    /// From the friction-free reference curve.
    Reference,
    /// From the shape of this curve alone.
    Shape,
}

impl DriveSource {
    /// Machine-readable name.
    pub fn name(self) -> &'static str {
        match self {
            DriveSource::Known => "known",
            DriveSource::Reference => "reference",
            DriveSource::Shape => "shape",
        }
    }
}

/// What the instrument adds: measured is
/// `Z e^(i (phase_offset - (omega - omega_c) delay)) + background`.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Instrument {
    /// Phase offset, rad; `None` where not fitted.
    pub phase_offset_rad: Option<Quantity>,
    /// Delay, s; `None` where not fitted.
    pub delay_s: Option<Quantity>,
    /// Background, real and imaginary part, response unit; `None` where not fitted.
    pub background: Option<[Quantity; 2]>,
    /// The delay is the background's too; the background is then that at `centre_hz`.
    pub background_delayed: bool,
    /// A constant in every amplitude, as a detector's zero, response unit; `None` where not fitted.
    pub amplitude_offset: Option<Quantity>,
    /// A noise floor that adds to every amplitude in squares, response unit; `None` where not fitted.
    pub noise_floor: Option<Quantity>,
    /// The phases given run the other way (`e^(-i omega t)`) and were conjugated.
    pub phase_was_conjugated: bool,
    /// The frequency `omega_c/2 pi` about which the delay turns, Hz.
    pub centre_hz: f64,
}

/// One measured point beside the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CurvePoint {
    /// Index in the order of measurement.
    pub index: usize,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Measured amplitude, response unit.
    pub amplitude: f64,
    /// Measured phase against the drive, rad in (-pi, pi], sign convention mended, as
    /// measured otherwise; `None` without phases.
    pub phase_rad: Option<f64>,
    /// Standard error of the amplitude.
    pub std_error: f64,
    /// Fitted amplitude, instrument terms included.
    pub fitted_amplitude: f64,
    /// Fitted phase, rad, instrument terms included.
    pub fitted_phase_rad: f64,
    /// Measured less fitted: amplitude, or the real part along the fitted phase.
    pub residual: f64,
    /// Residual across the fitted phase, response unit; zero without phases.
    pub residual_across: f64,
    /// Stops in a cycle of the exact motion, at least: 0 for many turning points, and where nothing moves.
    pub stops: usize,
    /// Relative drive level of this point (1 without a drive column).
    pub drive: f64,
}

/// Force balance at one point, without a model; "forces" are over the stiffness, in the
/// response's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForcePoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the oscillator, instrument terms taken off.
    pub amplitude: f64,
    /// Dissipative force `x_0 sin(lag)`.
    pub dissipative: f64,
    /// Its standard error.
    pub dissipative_std_error: f64,
    /// Elastic force `x_0 cos(lag) + (omega/omega_0)² |Z|`.
    pub elastic: f64,
    /// Its standard error.
    pub elastic_std_error: f64,
}

/// The line through the dissipative forces: `x_0 sin(lag) = 4 x_F/pi + (2 delta/omega_0) |Z| omega/omega_0`.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForceLine {
    /// Friction displacement from the intercept.
    pub friction_displacement: Quantity,
    /// Decay rate from the slope, 1/s.
    pub decay_rate_per_s: Quantity,
    /// Chi square over its degrees of freedom.
    pub reduced_chi_square: f64,
    /// Points used.
    pub points: usize,
}

/// The paper's way for the same data: eq. (14) fitted, inverted with `a = 4/3`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PaperEstimate {
    /// Effective quality factor `Q_f`.
    pub effective_q_factor: f64,
    /// Effective drive `x_f` of the paper.
    pub effective_drive: f64,
    /// Centre, Hz.
    pub natural_frequency_hz: f64,
    /// Q by eq. (12); `None` where the drive is not known, which the inversion needs.
    pub q_factor: Option<f64>,
    /// Friction displacement by eqs. (12) and (13).
    pub friction_displacement: Option<f64>,
    /// Friction ratio.
    pub friction_ratio: Option<f64>,
    /// Relative bias of Q by this inversion, from the same fit to the exact curve of the
    /// answer's parameters at the same frequencies.
    pub q_factor_bias: Option<f64>,
    /// Relative bias of the friction displacement, likewise.
    pub friction_bias: Option<f64>,
}

/// The friction-free reference, fitted jointly.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferenceFit {
    /// Its natural frequency, Hz.
    pub natural_frequency_hz: Quantity,
    /// Its decay rate, 1/s.
    pub decay_rate_per_s: Quantity,
    /// Its points beside the fit.
    #[cfg_attr(feature = "serde", serde(rename = "curve", serialize_with = "curve_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "curve_columns::Columns"))]
    pub points: Vec<CurvePoint>,
    /// p value of sliding friction in the reference itself, `x_0` free: small means it is
    /// not free of friction.
    pub sliding_p_value: f64,
}

/// How well the model describes the data.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnostics {
    /// Points used.
    pub points: usize,
    /// Points outside the band asked for.
    pub outside_band: usize,
    /// Points left out because they lie far off every law (glitches).
    pub left_out: usize,
    /// Noise of one point (one quadrature) as estimated between neighbours, response unit.
    pub noise_rms: f64,
    /// Losses that the reported model has not and the data do not exclude: the intervals count them. None
    /// where they widen none of them by a tenth, or the model was asked for.
    pub counted_losses: Option<LossModel>,
    /// Residual of the chosen model, response unit; by the paper's method that of the effective Lorentzian, as are
    /// then the residuals of the points.
    pub residual_rms: f64,
    /// Noise of an amplitude over the amplitude, where the noise was found to grow with it: every point
    /// then has its own standard error, and `noise_rms` and `residual_rms` are those of a typical
    /// one. `None` where it is constant, or the errors of the points were given.
    pub proportional_noise: Option<f64>,
    /// Factor on variances for autocorrelated residuals; 1 where they are white.
    pub residual_excess: f64,
    /// First autocorrelation of the residuals along the frequency.
    pub residual_autocorrelation: f64,
    /// False where friction would be claimed by its p value, but explains less than what is left of the curve beyond the
    /// noise, or that is a large part of the height: then nothing is said about friction.
    pub law_holds: bool,
    /// Highest amplitude over the noise of one quadrature, dB.
    pub signal_to_noise_db: f64,
    /// Span of the frequencies over the full width of the line at 1/√2 of its height.
    pub line_widths: f64,
    /// Points within that width.
    pub points_in_line: usize,
    /// Points where the exact motion has stops.
    pub points_with_stops: usize,
}

impl Diagnostics {
    /// Residual over the noise between neighbours: one where the model leaves no more than noise. Next to the least
    /// noise there is, the largest number.
    #[must_use]
    pub fn residual_ratio(&self) -> f64 {
        (self.residual_rms / self.noise_rms.max(f64::MIN_POSITIVE)).min(f64::MAX)
    }
}

columns! {
    curve_columns of crate::resonance::CurvePoint {
        index: usize, frequency_hz: f64, amplitude: f64, phase_rad: Option<f64>, std_error: f64,
        fitted_amplitude: f64, fitted_phase_rad: f64, residual: f64, residual_across: f64, stops: usize,
        drive: f64,
    }
}
columns! {
    force_columns of crate::resonance::ForcePoint {
        frequency_hz: f64, amplitude: f64, dissipative: f64, dissipative_std_error: f64, elastic: f64,
        elastic_std_error: f64,
    }
}

/// Everything [`analyse`](super::analyse) found out.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// The loss model reported.
    pub model: LossModel,
    /// The simplest model that the data support: that of lowest BIC. Without a model asked for, the one
    /// reported has viscous and sliding loss besides, at zero where the data want none, so that the
    /// error of each counts what is not known of the other.
    pub preferred_model: LossModel,
    /// How the response was computed.
    pub method: Method,
    /// Where the drive amplitude came from.
    pub drive_source: DriveSource,
    /// Parameters by name, in the order they should be read.
    pub parameters: Parameters,
    /// All models, best first.
    pub comparison: Vec<Candidate>,
    /// Evidence for sliding friction.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::answer::serialise::curve_evidence"))]
    #[cfg_attr(feature = "schema", schemars(with = "crate::answer::serialise::CurveEvidence"))]
    pub sliding: SlidingEvidence,
    /// Correlations between the estimated parameters, by pairs of names.
    pub correlations: Vec<Correlation>,
    /// Instrument terms.
    pub instrument: Instrument,
    /// Mean of the drive column, in its unit: the drive amplitude given or found is the one there.
    /// `None` without such a column.
    pub mean_drive: Option<f64>,
    /// The points used beside the fit, by rising frequency.
    #[cfg_attr(feature = "serde", serde(rename = "curve", serialize_with = "curve_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "curve_columns::Columns"))]
    pub points: Vec<CurvePoint>,
    /// Force balance without a model; empty without phases.
    #[cfg_attr(feature = "serde", serde(serialize_with = "force_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "force_columns::Columns"))]
    pub force: Vec<ForcePoint>,
    /// The line through it.
    pub force_line: Option<ForceLine>,
    /// The paper's way; `None` where its Lorentzian finds no peak.
    pub paper: Option<PaperEstimate>,
    /// The reference curve, if one was given.
    pub reference: Option<ReferenceFit>,
    /// Quality of the description.
    pub diagnostics: Diagnostics,
    /// What limits the answer.
    pub warnings: Vec<Warning>,
    /// Unit of the response.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub unit: String,
    /// The fitted curve, to be evaluated at any frequency.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub fit: FittedCurve,
    /// Standard errors of the parameters given the terms of the instrument, which belong to the
    /// correlations; the errors reported count the choice of the terms besides.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) given_terms: Vec<(Parameter, f64)>,
}

impl Answer {
    /// The standard error of a parameter given the terms of the instrument.
    pub(crate) fn error_given_terms(&self, parameter: Parameter) -> Option<f64> {
        let found = self.given_terms.iter().find(|(known, _)| *known == parameter);
        found.map(|(_, error)| *error).or_else(|| self.parameter(parameter).map(|q| q.std_error))
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

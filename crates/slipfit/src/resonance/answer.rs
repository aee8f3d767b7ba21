//! The answer to a resonance curve: parameters, evidence, warnings.

use super::Method;
use super::fitted::FittedCurve;
use crate::Quantity;
use crate::answer::columns::columns;
use crate::answer::comparison::correlation;
use crate::answer::{Candidate, Correlation, Parameter, Parameters, SlidingEvidence, Warning};
use crate::model::loss::LossModel;

/// Source of the drive amplitude.
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

/// Instrument terms: the measured response is `Z e^(i (phase_offset - (omega - omega_c) delay)) + background`.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Instrument {
    /// Phase offset, rad; `None` if not fitted.
    pub phase_offset_rad: Option<Quantity>,
    /// Delay, s; `None` if not fitted.
    pub delay_s: Option<Quantity>,
    /// Background, real and imaginary part, response unit; `None` if not fitted.
    pub background: Option<[Quantity; 2]>,
    /// Whether the delay also applies to the background, which is then that at `centre_hz`.
    pub background_delayed: bool,
    /// A constant in every amplitude, such as the zero of a detector, response unit; `None` if not fitted.
    pub amplitude_offset: Option<Quantity>,
    /// A noise floor that adds to every amplitude in quadrature, response unit; `None` if not fitted.
    pub noise_floor: Option<Quantity>,
    /// Whether the given phases have the opposite sign (`e^(-i omega t)`) and were conjugated.
    pub phase_was_conjugated: bool,
    /// The frequency `omega_c/2 pi` at which the delay does not change the phase, Hz.
    pub centre_hz: f64,
}

/// One measured point with its fitted value.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CurvePoint {
    /// Index in the order of measurement.
    pub index: usize,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Measured amplitude, response unit.
    pub amplitude: f64,
    /// Measured phase relative to the drive, rad in (-pi, pi], with the sign convention corrected but otherwise as
    /// measured; `None` without phases.
    pub phase_rad: Option<f64>,
    /// Standard error of the amplitude.
    pub std_error: f64,
    /// Fitted amplitude, instrument terms included.
    pub fitted_amplitude: f64,
    /// Fitted phase, rad, instrument terms included.
    pub fitted_phase_rad: f64,
    /// Measured minus fitted: amplitude, or the component along the fitted phase.
    pub residual: f64,
    /// Component of the residual perpendicular to the fitted phase, response unit; zero without phases.
    pub residual_across: f64,
    /// Lower limit of the number of stops per cycle of the exact motion; 0 for motions with many turning points, and if
    /// nothing moves.
    pub stops: usize,
    /// Relative drive level of this point (1 without a drive column).
    pub drive: f64,
}

/// Force balance at one point, without a model; forces are divided by the stiffness, in the unit of the response.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForcePoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude of the oscillator, with the instrument terms removed.
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

/// Result of the method of the paper for the same data: eq. (14) fitted, inverted with `a = 4/3`.
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
    /// Q by eq. (12); `None` if the drive, which the inversion requires, is not known.
    pub q_factor: Option<f64>,
    /// Friction displacement by eqs. (12) and (13).
    pub friction_displacement: Option<f64>,
    /// Friction ratio.
    pub friction_ratio: Option<f64>,
    /// Relative bias of Q by this inversion, from the same fit to the exact curve for the parameters of the answer at
    /// the same frequencies.
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
    /// Its points with their fitted values.
    #[cfg_attr(feature = "serde", serde(rename = "curve", serialize_with = "curve_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "curve_columns::Columns"))]
    pub points: Vec<CurvePoint>,
    /// p value of no sliding friction in the reference itself, with `x_0` free; a small value means that the reference
    /// is not free of friction.
    pub sliding_p_value: f64,
}

/// Quality of the description of the data by the model.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnostics {
    /// Points used.
    pub points: usize,
    /// Points outside the requested band.
    pub outside_band: usize,
    /// Points left out because they are far from every law (glitches).
    pub left_out: usize,
    /// Noise of one point (one quadrature) estimated from differences between neighbours, response unit.
    pub noise_rms: f64,
    /// Losses absent from the reported model that the data do not exclude and that the intervals take into account.
    /// `None` if they widen no interval by a tenth, or if a model was requested.
    pub counted_losses: Option<LossModel>,
    /// Root mean square of the residuals of the chosen model, response unit; with the method of the paper, of the
    /// effective Lorentzian, to which the residuals of the points then refer as well.
    pub residual_rms: f64,
    /// Ratio of the noise to the amplitude, if the noise was found to grow with the amplitude: every point then has its
    /// own standard error, and `noise_rms` and `residual_rms` refer to a typical point. `None` if the noise is
    /// constant, or if the errors of the points were given.
    pub proportional_noise: Option<f64>,
    /// Variance inflation for autocorrelated residuals; 1 if they are white.
    pub residual_excess: f64,
    /// Lag-one autocorrelation of the residuals along the frequency.
    pub residual_autocorrelation: f64,
    /// False if friction would be detected by its p value but explains less than the residuals beyond the noise, or if
    /// these are a large fraction of the height: then nothing is concluded about friction.
    pub law_holds: bool,
    /// Highest amplitude over the noise of one quadrature, dB.
    pub signal_to_noise_db: f64,
    /// Ratio of the frequency span to the full width of the line at 1/√2 of its height.
    pub line_widths: f64,
    /// Points within that width.
    pub points_in_line: usize,
    /// Points where the exact motion has stops.
    pub points_with_stops: usize,
}

impl Diagnostics {
    /// Ratio of the residuals to the noise between neighbours: one if the residuals are only noise. Limited to the
    /// largest number for vanishing noise.
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

/// Complete result of [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Answer {
    /// The loss model reported.
    pub model: LossModel,
    /// The simplest model that the data support: that of lowest BIC. Unless a model was requested, the reported one
    /// also has viscous and sliding loss, at zero if the data do not require them, so that the standard error of each
    /// accounts for the uncertainty of the other.
    pub preferred_model: LossModel,
    /// How the response was computed.
    pub method: Method,
    /// Source of the drive amplitude.
    pub drive_source: DriveSource,
    /// Parameters by name, in reading order.
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
    /// Mean of the drive column, in its unit; the drive amplitude, given or fitted, refers to this mean. `None` without
    /// such a column.
    pub mean_drive: Option<f64>,
    /// The points used with their fitted values, in order of increasing frequency.
    #[cfg_attr(feature = "serde", serde(rename = "curve", serialize_with = "curve_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "curve_columns::Columns"))]
    pub points: Vec<CurvePoint>,
    /// Force balance without a model; empty without phases.
    #[cfg_attr(feature = "serde", serde(serialize_with = "force_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "force_columns::Columns"))]
    pub force: Vec<ForcePoint>,
    /// The line through the force balance.
    pub force_line: Option<ForceLine>,
    /// Result of the method of the paper; `None` if its Lorentzian finds no peak.
    pub paper: Option<PaperEstimate>,
    /// The reference curve, if one was given.
    pub reference: Option<ReferenceFit>,
    /// Quality of the fit.
    pub diagnostics: Diagnostics,
    /// What limits the validity of the answer.
    pub warnings: Vec<Warning>,
    /// Unit of the response.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub unit: String,
    /// The fitted curve, which can be evaluated at any frequency.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub fit: FittedCurve,
    /// Standard errors of the parameters for fixed terms of the instrument, which correspond to the correlations; the
    /// reported errors also account for the choice of the terms.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) given_terms: Vec<(Parameter, f64)>,
}

impl Answer {
    /// The standard error of a parameter for fixed terms of the instrument.
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

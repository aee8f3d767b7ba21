//! Options of the analysis.

use super::Curve;
use crate::Error;
use crate::answer::calibration::Calibration;
use crate::model::loss::{LossModel, LossTerm};

/// Options for [`analyse`](super::analyse). By default everything is determined automatically.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Only points between these frequencies are used, in Hz.
    pub band_hz: Option<[f64; 2]>,
    /// How the response is computed.
    pub method: Method,
    /// Reports this loss model, whichever model the data prefer.
    pub model: Option<LossModel>,
    /// The drive amplitude `x_0`, if known, in the unit of the response.
    pub drive_amplitude: Option<DriveAmplitude>,
    /// A friction-free curve of the same oscillator at the same drive, fitted jointly, which determines `x_0`. It has
    /// its own frequency, viscous damping, phase and background; delay, drag and Duffing term are shared.
    pub reference: Option<Curve>,
    /// Terms of the instrument and of the spring.
    pub terms: Terms,
    /// Mechanical constant that converts displacements into forces.
    pub calibration: Option<Calibration>,
}

/// How the response of the oscillator is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum Method {
    /// The exact fundamental, including stops.
    #[default]
    Exact,
    /// The leading term, eq. (8) of the paper.
    Leading,
    /// The effective Lorentzian of the paper, eq. (14), inverted with `a = 4/3`; its known bias is reported with the
    /// answer.
    Paper,
}

/// A known drive amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveAmplitude {
    /// `x_0`, in the unit of the response.
    pub value: f64,
    /// Its standard error; zero if exact.
    pub std_error: f64,
}

/// Terms in addition to the oscillator. `None`: used if the data require it; `Some`: as specified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Terms {
    /// A constant complex background (crosstalk, feed-through), which gives a Fano shape.
    pub background: Option<bool>,
    /// A delay of the signal chain (a phase that decreases linearly with frequency). Requires phases.
    pub delay: Option<bool>,
    /// A constant added to every amplitude, positive or negative: the zero of a detector that reads amplitudes (rms,
    /// peak). For curves without phases.
    pub amplitude_offset: Option<bool>,
    /// A noise floor added to every amplitude in quadrature, `sqrt(A² + n²)`: of a spectrum analyser, of averaged
    /// squares, of the R output of a lock-in amplifier at a low signal. For curves without phases, and together with a
    /// constant only if both are requested.
    pub noise_floor: Option<bool>,
    /// A constant phase offset. Requires phases; always fitted unless `Some(false)`.
    pub phase_offset: Option<bool>,
    /// A natural frequency that changes with the square of the amplitude (Duffing).
    pub duffing: Option<bool>,
}

impl Options {
    /// Checks all given numbers.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if let Some([low, high]) = self.band_hz.filter(|b| !(b[0] >= 0.0 && b[0] < b[1])) {
            return Err(Error::Band { low_hz: low, high_hz: high });
        }
        if self.model.is_some_and(|m| m.terms().any(LossTerm::is_shaped)) {
            return Err(Error::DoesNotHold {
                method: "the model asked for",
                why: "the shape of a loss can be fitted to free decays only",
            });
        }
        if let Some(drive) = self.drive_amplitude {
            crate::model::oscillator::above_zero("drive_amplitude", drive.value)?;
            if !(drive.std_error >= 0.0 && drive.std_error.is_finite()) {
                let range = "the non-negative numbers";
                return Err(Error::Parameter {
                    name: "drive_amplitude std_error",
                    value: drive.std_error,
                    range,
                });
            }
            if self.reference.is_some() {
                return Err(Error::ConflictingParameters { first: "drive_amplitude", second: "reference" });
            }
        }
        self.calibration.map_or(Ok(()), Calibration::check)
    }
}

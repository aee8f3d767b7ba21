//! What a caller may fix before the analysis.

use super::Curve;
use crate::Error;
use crate::answer::calibration::Calibration;
use crate::model::loss::{LossModel, LossTerm};

/// Choices for [`analyse`](super::analyse). The default finds everything by itself.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Only points between these frequencies count, in Hz.
    pub band_hz: Option<[f64; 2]>,
    /// How the response is computed.
    pub method: Method,
    /// Report this loss model, whichever the data prefer.
    pub model: Option<LossModel>,
    /// The drive amplitude `x_0`, when it is known, in the response's unit.
    pub drive_amplitude: Option<DriveAmplitude>,
    /// A friction-free curve of the same oscillator at the same drive, fitted jointly: it gives `x_0`. It has
    /// frequency, viscous damping, phase and background of its own; delay, drag and Duffing term are shared.
    pub reference: Option<Curve>,
    /// Terms of the instrument, and of the spring.
    pub terms: Terms,
    /// Mechanical constant that turns displacements into forces.
    pub calibration: Option<Calibration>,
}

/// How the response of the oscillator is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum Method {
    /// The exact fundamental, stops included.
    #[default]
    Exact,
    /// The leading term, the paper's eq. (8).
    Leading,
    /// The paper's effective Lorentzian, eq. (14), inverted with `a = 4/3`; its known bias
    /// stands beside the answer.
    Paper,
}

/// The drive amplitude as known from elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveAmplitude {
    /// `x_0`, in the response's unit.
    pub value: f64,
    /// Its standard error; zero when exact.
    pub std_error: f64,
}

/// Terms beside the oscillator. `None`: used when the data need it; `Some`: as said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Terms {
    /// A constant complex background (crosstalk, feed-through), which gives a Fano shape.
    pub background: Option<bool>,
    /// A delay of the signal chain (phase falling linearly with frequency). Needs phases.
    pub delay: Option<bool>,
    /// A constant that adds to every amplitude, above or below zero: the zero of a detector that reads
    /// amplitudes (rms, peak). Of curves without phases.
    pub amplitude_offset: Option<bool>,
    /// A noise floor that adds to every amplitude in squares, `sqrt(A² + n²)`: of a spectrum analyser, of averaged squares, of
    /// a lock-in's R at a low signal. Of curves without phases, and beside a constant only if both are asked for.
    pub noise_floor: Option<bool>,
    /// A constant phase offset. Needs phases; always fitted unless `Some(false)`.
    pub phase_offset: Option<bool>,
    /// A frequency that moves with the square of the amplitude (Duffing).
    pub duffing: Option<bool>,
}

impl Options {
    /// Checks every number given.
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

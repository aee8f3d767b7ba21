//! What a caller may fix before the analysis.

use super::LossModel;
use crate::Quantity;

/// Choices for [`analyse`](super::analyse). The default finds everything by
/// itself.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// First instant used, in s on the record's clock.
    pub start_s: Option<f64>,
    /// Last instant used, in s on the record's clock.
    pub end_s: Option<f64>,
    /// The decay is followed down to this amplitude only, in the signal's unit.
    pub min_amplitude: Option<f64>,
    /// Only oscillations between these frequencies count, in Hz.
    pub band_hz: Option<[f64; 2]>,
    /// Report this model, whichever the data prefer.
    pub model: Option<LossModel>,
    /// Low-pass of the lock-in amplifier that recorded the amplitude.
    pub lockin: Option<LowPass>,
    /// Mechanical constant that turns displacements into forces.
    pub calibration: Option<Calibration>,
}

/// A lock-in's output filter: `order` equal first-order stages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Time constant of one stage, in s.
    pub time_constant_s: f64,
    /// Number of stages, 1 to 8.
    pub order: u32,
}

/// The one mechanical constant a displacement record cannot give.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Calibration {
    /// Stiffness `k` in N/m (or torsion stiffness in N m/rad for angles), with its standard error.
    Stiffness {
        /// Value.
        value: f64,
        /// Standard error; zero when exact.
        std_error: f64,
    },
    /// Mass `m` in kg (or moment of inertia in kg m² for angles), with its standard error.
    Mass {
        /// Value.
        value: f64,
        /// Standard error; zero when exact.
        std_error: f64,
    },
}

impl Calibration {
    /// Value and standard error as a quantity.
    pub fn quantity(self) -> Quantity {
        let (value, std_error, unit) = match self {
            Calibration::Stiffness { value, std_error } => (value, std_error, "N/m"),
            Calibration::Mass { value, std_error } => (value, std_error, "kg"),
        };
        Quantity::normal(value, std_error, unit)
    }
}

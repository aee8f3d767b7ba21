//! Conversion from displacements to forces.

use super::parameter::Parameter;
use super::quantity::Quantity;
use crate::Error;
use crate::model::displacement::{Coordinate, DisplacementUnit, before_time};
use crate::model::oscillator::{above_zero, at_least_zero};

/// The mechanical constant that a displacement record cannot determine.
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
    /// # Errors
    /// [`Error::Parameter`] if the constant is not positive and finite, or its standard error is negative.
    pub(crate) fn check(self) -> Result<(), Error> {
        let (Self::Stiffness { value, std_error } | Self::Mass { value, std_error }) = self;
        above_zero("calibration", value)?;
        at_least_zero("calibration std_error", std_error)
    }

    /// The same constant, known exactly.
    pub(crate) fn exact(self) -> Self {
        match self {
            Self::Stiffness { value, .. } => Self::Stiffness { value, std_error: 0.0 },
            Self::Mass { value, .. } => Self::Mass { value, std_error: 0.0 },
        }
    }

    /// Relative standard error.
    pub(crate) fn relative_error(self) -> f64 {
        let (Self::Stiffness { value, std_error } | Self::Mass { value, std_error }) = self;
        std_error / value
    }

    /// Value and standard error as a quantity.
    pub fn quantity(self) -> Quantity {
        let (value, std_error, unit) = match self {
            Calibration::Stiffness { value, std_error } => (value, std_error, "N/m"),
            Calibration::Mass { value, std_error } => (value, std_error, "kg"),
        };
        Quantity::normal(value, std_error, unit)
    }
}

/// `gamma = 2 m delta` and `F = k x_F`, with `k = m omega_0²`. If the displacement has no unit, or a unit of unknown
/// length, the force is in N/m times that unit.
pub(crate) fn physical(
    calibration: Calibration,
    omega_0: f64,
    unit: &str,
    delta: &Quantity,
    x_f: &Quantity,
) -> [(Parameter, Quantity); 2] {
    let square = omega_0 * omega_0;
    let relative = calibration.relative_error();
    let (mass, stiffness) = match calibration {
        Calibration::Stiffness { value, .. } => (value / square, value),
        Calibration::Mass { value, .. } => (value, value * square),
    };
    let (length, angle) = length_in_metres(unit);
    let (gamma_unit, force_unit) = match (length, angle) {
        (_, true) => ("N m s".to_owned(), "N m".to_owned()),
        (Some(_), _) => ("N s/m".to_owned(), "N".to_owned()),
        (None, _) if unit.trim().is_empty() => ("N s/m".to_owned(), "N/m × signal unit".to_owned()),
        (None, _) => ("N s/m".to_owned(), format!("N/m × {unit}")),
    };
    [
        (Parameter::ViscousCoefficient, delta.scaled(2.0 * mass, gamma_unit).widened(relative)),
        (
            Parameter::CoulombForce,
            x_f.scaled(stiffness * length.unwrap_or(1.0), force_unit).widened(relative),
        ),
    ]
}

/// Factor to metres or radians (for a rate or an acceleration, to metres or radians per s or s²), and whether the unit
/// is an angle. The factor is `None` for any other unit.
fn length_in_metres(unit: &str) -> (Option<f64>, bool) {
    let unit = before_time(unit);
    match DisplacementUnit::named(&unit) {
        Some(known) => (Some(known.si), known.coordinate == Coordinate::Angle),
        None => ((unit == "g").then_some(9.806_65), false),
    }
}

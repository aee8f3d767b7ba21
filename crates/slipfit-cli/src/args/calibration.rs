//! A mechanical constant that converts displacements to forces.

use super::value::{Inertia, Mass, Stiffness, TorsionStiffness, Uncertain};
use crate::failure::Failure;
use clap::Args;
use slipfit::Calibration;
use slipfit::answer::hint::Analysis;
use slipfit::model::displacement::{Coordinate, DisplacementUnit};

/// At most one mechanical constant.
#[derive(Debug, Args)]
#[group(multiple = false)]
pub(crate) struct CalibrationArgs {
    /// Stiffness k [N/m], for a displacement in m: 12000, 12000±300, 12000(300)
    #[arg(long, value_name = "K", help_heading = "Forces")]
    stiffness: Option<Stiffness>,

    /// Mass m [kg], for a displacement in m
    #[arg(long, value_name = "M", help_heading = "Forces")]
    mass: Option<Mass>,

    /// Torsion stiffness [N m/rad], for an angle
    #[arg(long, value_name = "K", help_heading = "Forces")]
    torsion_stiffness: Option<TorsionStiffness>,

    /// Moment of inertia [kg m²], for an angle
    #[arg(long, value_name = "I", help_heading = "Forces")]
    inertia: Option<Inertia>,
}

impl CalibrationArgs {
    fn given(&self) -> Option<(&'static str, Coordinate)> {
        [
            (self.stiffness.is_some(), "--stiffness", Coordinate::Length),
            (self.mass.is_some(), "--mass", Coordinate::Length),
            (self.torsion_stiffness.is_some(), "--torsion-stiffness", Coordinate::Angle),
            (self.inertia.is_some(), "--inertia", Coordinate::Angle),
        ]
        .into_iter()
        .find_map(|(given, flag, coordinate)| given.then_some((flag, coordinate)))
    }

    /// Checks that the constant applies to a signal in `unit`.
    pub(crate) fn check(&self, unit: &str) -> Result<(), Failure> {
        let Some((flag, coordinate)) = self.given() else { return Ok(()) };
        coordinate.check_unit(unit).map_err(|error| {
            let message = error.to_string().replacen("the constant", flag, 1);
            Failure::new(message).hints(&error.hints(Analysis::Ringdown))
        })
    }

    /// A note for the case that the constant is given and the unit of the signal is unknown or no length.
    pub(crate) fn unit_note(&self, unit: &str) -> Option<String> {
        let (flag, _) = self.given().filter(|_| !DisplacementUnit::gives_forces(unit))?;
        Some(match unit.trim() {
            "" => format!(
                "{flag}: the unit of the signal is unknown, so the force is in N/m times it; --unit gives it"
            ),
            unit => format!(
                "{flag}: the signal is in {unit}, which is not a length, so the force is in N/m times {unit}; --unit \
                 gives the unit of a displacement"
            ),
        })
    }

    pub(crate) fn constant(&self) -> Option<Calibration> {
        let stiffness = self.stiffness.map(|k| k.0).or(self.torsion_stiffness.map(|k| k.0));
        let mass = self.mass.map(|m| m.0).or(self.inertia.map(|i| i.0));
        let of_stiffness = |k: Uncertain| Calibration::Stiffness { value: k.value, std_error: k.std_error };
        let of_mass = |m: Uncertain| Calibration::Mass { value: m.value, std_error: m.std_error };
        stiffness.map(of_stiffness).or_else(|| mass.map(of_mass))
    }
}

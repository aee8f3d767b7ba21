//! Units of displacements: lengths and angles.

use crate::Error;
use std::f64::consts::TAU;

/// What a displacement is measured along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// A length; the SI unit is m.
    Length,
    /// An angle; the SI unit is rad.
    Angle,
}

/// A unit of displacements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacementUnit {
    /// The unit in m or rad.
    pub si: f64,
    /// Whether it is one of lengths or of angles.
    pub coordinate: Coordinate,
}

impl DisplacementUnit {
    /// The unit of this name; `None` for what is neither a length nor an angle.
    ///
    /// ```
    /// use slipfit::model::displacement::{Coordinate, DisplacementUnit};
    /// let mm = DisplacementUnit::named("mm").unwrap();
    /// assert_eq!((mm.si, mm.coordinate), (1e-3, Coordinate::Length));
    /// assert_eq!(DisplacementUnit::named("V"), None);
    /// ```
    #[must_use]
    pub fn named(unit: &str) -> Option<Self> {
        use Coordinate::{Angle, Length};
        let (si, coordinate) = match unit.trim() {
            "m" => (1.0, Length),
            "dm" => (0.1, Length),
            "cm" => (1e-2, Length),
            "mm" => (1e-3, Length),
            "um" | "µm" | "μm" => (1e-6, Length),
            "nm" => (1e-9, Length),
            "pm" => (1e-12, Length),
            "fm" => (1e-15, Length),
            "rad" => (1.0, Angle),
            "mrad" => (1e-3, Angle),
            "urad" | "µrad" | "μrad" => (1e-6, Angle),
            "deg" | "°" | "degrees" => (1f64.to_radians(), Angle),
            "rev" | "turn" | "turns" => (TAU, Angle),
            _ => return None,
        };
        Some(Self { si, coordinate })
    }

    /// The factor that turns numbers in the unit `from` into numbers in the unit `to`.
    ///
    /// # Errors
    /// [`Error::UnitMismatch`] where they are neither equal nor of one coordinate.
    pub fn factor(from: &str, to: &str) -> Result<f64, Error> {
        if from == to {
            return Ok(1.0);
        }
        match (Self::named(from), Self::named(to)) {
            (Some(a), Some(b)) if a.coordinate == b.coordinate => Ok(a.si / b.si),
            _ => Err(Error::UnitMismatch { found: from.to_owned(), expected: to.to_owned() }),
        }
    }
}

impl Coordinate {
    /// Whether a mechanical constant of this coordinate can turn displacements in `unit` into
    /// forces: a stiffness in N/m says nothing about an angle, nor a torsion stiffness about a length.
    ///
    /// # Errors
    /// [`Error::WrongCoordinate`] where the unit is known to be one of the other coordinate.
    pub fn check_unit(self, unit: &str) -> Result<(), Error> {
        match DisplacementUnit::named(unit) {
            Some(known) if known.coordinate != self => {
                Err(Error::WrongCoordinate { expected: self.words(), unit: unit.to_owned() })
            }
            _ => Ok(()),
        }
    }

    /// `a displacement` or `an angle`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Length => "a displacement",
            Self::Angle => "an angle",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_one_coordinate_are_converted() {
        assert!((DisplacementUnit::factor("rev", "deg").unwrap() - 360.0).abs() < 1e-9);
        assert_eq!(DisplacementUnit::factor("V", "V"), Ok(1.0));
        for [from, to] in [["mm", "rad"], ["V", "m"], ["", "m"]] {
            assert!(DisplacementUnit::factor(from, to).is_err(), "{from} {to}");
        }
    }

    #[test]
    fn a_constant_belongs_to_its_coordinate() {
        assert_eq!(Coordinate::Length.check_unit("mm"), Ok(()));
        assert_eq!(Coordinate::Angle.check_unit("V"), Ok(()), "nobody knows");
        assert!(Coordinate::Length.check_unit("deg").is_err());
        assert!(Coordinate::Angle.check_unit("nm").is_err());
    }
}

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
    /// Names of angles count in any case, as `Deg`; `Grad` is German for degrees.
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
        let unit = unit.trim();
        if let Some(si) = angle(unit) {
            return Some(Self { si, coordinate: Angle });
        }
        let (si, coordinate) = match unit {
            "m" => (1.0, Length),
            "dm" => (0.1, Length),
            "cm" => (1e-2, Length),
            "mm" => (1e-3, Length),
            "um" | "µm" | "μm" => (1e-6, Length),
            "nm" => (1e-9, Length),
            "pm" => (1e-12, Length),
            "fm" => (1e-15, Length),
            _ => return None,
        };
        Some(Self { si, coordinate })
    }

    /// What the numbers of a drive are in the unit of the response, where both are lengths or both are angles; `None`
    /// where nothing says so. Equal units of anything else say nothing: a voltage that drives and one that a sensor
    /// gives are not one quantity.
    ///
    /// ```
    /// use slipfit::model::displacement::DisplacementUnit;
    /// assert_eq!(DisplacementUnit::gain("mm", "mm"), Some(1.0));
    /// assert_eq!(DisplacementUnit::gain("V", "V"), None);
    /// ```
    #[must_use]
    pub fn gain(drive: &str, response: &str) -> Option<f64> {
        /// Lengths in files that have no SI unit here, or none at all; of one unit they are one quantity.
        const OTHERS: [&str; 10] =
            ["in", "inch", "inches", "ft", "mil", "px", "pixel", "pixels", "metre", "meter"];
        let (drive, response) = (drive.trim(), response.trim());
        let is_other = OTHERS.iter().any(|other| other.eq_ignore_ascii_case(drive));
        let is_known = Self::named(drive).is_some() || is_other && drive.eq_ignore_ascii_case(response);
        if !is_known {
            return None;
        }
        if is_other { Some(1.0) } else { Self::factor(drive, response).ok() }
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

/// The angle of this name in rad. Prefixes keep their case: `MRad` is not `mrad`.
fn angle(unit: &str) -> Option<f64> {
    let radians = |name: &str| name.eq_ignore_ascii_case("rad");
    let prefixes = [("m", 1e-3), ("u", 1e-6), ("µ", 1e-6), ("μ", 1e-6), ("n", 1e-9)];
    Some(match unit.to_lowercase().as_str() {
        "rad" | "radian" | "radians" => 1.0,
        "deg" | "°" | "degree" | "degrees" | "grad" => 1f64.to_radians(),
        "arcmin" => 1f64.to_radians() / 60.0,
        "arcsec" => 1f64.to_radians() / 3600.0,
        "rev" | "revs" | "turn" | "turns" => TAU,
        _ => prefixes.into_iter().find(|(prefix, _)| unit.strip_prefix(prefix).is_some_and(radians))?.1,
    })
}

/// The unit of which `unit` may be a rate or an acceleration: `deg` of `deg/s`.
pub(crate) fn before_time(unit: &str) -> &str {
    unit.split(['/', ' ', '·']).next().unwrap_or("")
}

impl Coordinate {
    /// Whether a mechanical constant of this coordinate can turn displacements in `unit`, or their
    /// rates and accelerations, into forces: a stiffness in N/m says nothing about an angle, nor a
    /// torsion stiffness about a length.
    ///
    /// A constant of angles needs a unit known as one. That of lengths takes unknown units too, for
    /// forces in N/m times them, but no capacitance, which has no force.
    ///
    /// # Errors
    /// [`Error::WrongCoordinate`] where the unit does not fit.
    pub fn check_unit(self, unit: &str) -> Result<(), Error> {
        let base = before_time(unit.trim());
        let fits = match (self, DisplacementUnit::named(base)) {
            (_, Some(known)) => known.coordinate == self,
            (Self::Angle, None) => false,
            (Self::Length, None) => !is_capacitance(base),
        };
        if fits {
            Ok(())
        } else {
            Err(Error::WrongCoordinate { expected: self.words(), unit: unit.to_owned() })
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

/// Whether a unit is one of capacitances: `F`, `pF`.
fn is_capacitance(unit: &str) -> bool {
    unit.strip_suffix('F').is_some_and(|prefix| ["", "m", "u", "µ", "μ", "n", "p", "f"].contains(&prefix))
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
    fn lengths_and_angles_alone_prove_a_gain() {
        for (drive, response, gain) in
            [("mm", "mm", 1.0), ("mm", "cm", 0.1), ("mm", "nm", 1e6), ("px", "px", 1.0), ("rad", "mrad", 1e3)]
        {
            let found = DisplacementUnit::gain(drive, response).unwrap();
            assert!((found / gain - 1.0).abs() < 1e-12, "{drive} {response}: {found}");
        }
        for [drive, response] in [
            ["V", "V"],
            ["Vrms", "Vrms"],
            ["", ""],
            ["\u{221a}mW"; 2],
            ["g", "g"],
            ["mm", "rad"],
            ["px", "mm"],
        ] {
            assert_eq!(DisplacementUnit::gain(drive, response), None, "{drive} {response}");
        }
    }

    #[test]
    fn a_constant_belongs_to_its_coordinate() {
        assert_eq!(Coordinate::Length.check_unit("mm"), Ok(()));
        assert_eq!(Coordinate::Length.check_unit("V"), Ok(()), "nobody knows");
        assert!(Coordinate::Length.check_unit("deg").is_err());
        assert!(Coordinate::Angle.check_unit("nm").is_err());
        for unit in ["deg", "Deg", "°/s", "rad/s^2", "rad s^-2", "mrad"] {
            assert_eq!(Coordinate::Angle.check_unit(unit), Ok(()), "{unit}");
            assert!(Coordinate::Length.check_unit(unit).is_err(), "{unit}");
        }
        for unit in ["", "V", "horse", "m/s^2", "g", "MRad"] {
            assert!(Coordinate::Angle.check_unit(unit).is_err(), "{unit}");
        }
        for unit in ["F", "pF"] {
            assert!(Coordinate::Length.check_unit(unit).is_err(), "{unit}");
        }
    }

    #[test]
    fn names_of_angles_count_in_any_case_and_prefixes_in_theirs() {
        let degree = 1f64.to_radians();
        for (unit, si) in [
            ("Deg", degree),
            ("DEG", degree),
            ("Degrees", degree),
            ("Grad", degree),
            ("Rad", 1.0),
            ("RAD", 1.0),
            ("mRad", 1e-3),
            ("µrad", 1e-6),
            ("Turns", TAU),
        ] {
            let wanted = DisplacementUnit { si, coordinate: Coordinate::Angle };
            assert_eq!(DisplacementUnit::named(unit), Some(wanted), "{unit}");
        }
        for unit in ["MRad", "MRAD", "M", "MM", "degC", "rad^2", "prad"] {
            assert_eq!(DisplacementUnit::named(unit), None, "{unit}");
        }
    }
}

//! Units of displacements: lengths and angles.

use crate::Error;
use std::f64::consts::TAU;

/// Kind of quantity that a displacement is.
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
    /// Whether it is a unit of lengths or of angles.
    pub coordinate: Coordinate,
}

impl DisplacementUnit {
    /// The unit with this name; `None` if it is neither a length nor an angle. Names of angles (such as `Deg`) and
    /// words for lengths (such as `Inches`) are case-insensitive; `Grad` is German for degrees.
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
        length(unit).map(|si| Self { si, coordinate: Length })
    }

    /// Factor that converts the numbers of a drive into the unit of the response, if both are lengths or both are
    /// angles; otherwise `None`. Equal units of other kinds give no factor: a drive voltage and a sensor voltage are
    /// not the same quantity.
    ///
    /// ```
    /// use slipfit::model::displacement::DisplacementUnit;
    /// assert_eq!(DisplacementUnit::gain("mm", "mm"), Some(1.0));
    /// assert_eq!(DisplacementUnit::gain("V", "V"), None);
    /// ```
    #[must_use]
    pub fn gain(drive: &str, response: &str) -> Option<f64> {
        /// Units of length in files that have no SI equivalent; they can be compared only with themselves.
        const OTHERS: [&str; 3] = ["px", "pixel", "pixels"];
        let (drive, response) = (drive.trim(), response.trim());
        let is_other = OTHERS.iter().any(|other| other.eq_ignore_ascii_case(drive));
        let is_known = Self::named(drive).is_some() || is_other && drive.eq_ignore_ascii_case(response);
        if !is_known {
            return None;
        }
        if is_other { Some(1.0) } else { Self::factor(drive, response).ok() }
    }

    /// Whether displacements in `unit`, or their rates and accelerations, are lengths or angles, so that a mechanical
    /// constant gives forces in newtons or torques in newton metres.
    ///
    /// ```
    /// use slipfit::model::displacement::DisplacementUnit;
    /// assert!(DisplacementUnit::gives_forces("mm/s") && DisplacementUnit::gives_forces("deg"));
    /// assert!(!DisplacementUnit::gives_forces("V") && !DisplacementUnit::gives_forces(""));
    /// ```
    #[must_use]
    pub fn gives_forces(unit: &str) -> bool {
        Self::named(&before_time(unit.trim())).is_some()
    }

    /// The unit with this name, in which a force over a stiffness can be given.
    ///
    /// # Errors
    /// [`Error::NeitherLengthNorAngle`] for any other.
    ///
    /// ```
    /// use slipfit::model::displacement::DisplacementUnit;
    /// // 15 nN over 10 kN/m in nm.
    /// let nm = DisplacementUnit::of_forces("nm")?;
    /// assert!((nm.under_force(15e-9, 1e4) - 1.5e-3).abs() < 1e-15);
    /// assert!(DisplacementUnit::of_forces("dB").is_err());
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    pub fn of_forces(unit: &str) -> Result<Self, Error> {
        Self::named(unit).ok_or_else(|| Error::NeitherLengthNorAngle { unit: unit.to_owned() })
    }

    /// The displacement `F/k` in this unit for a force in N and a stiffness in N/m; for an angle, a torque in N m and
    /// a torsion stiffness in N m/rad.
    #[must_use]
    pub fn under_force(self, force: f64, stiffness: f64) -> f64 {
        force / stiffness / self.si
    }

    /// The force `k x` at a displacement in this unit, in N; for an angle the torque in N m.
    #[must_use]
    pub fn force(self, displacement: f64, stiffness: f64) -> f64 {
        stiffness * displacement * self.si
    }

    /// Factor that converts numbers in the unit `from` into numbers in the unit `to`.
    ///
    /// # Errors
    /// [`Error::UnitMismatch`] if they are neither equal nor of the same coordinate.
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

/// Units of mechanical constants and forces, as used in answers and simulated records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct MechanicalUnits {
    /// Unit of the mass, or of the moment of inertia.
    pub mass: &'static str,
    /// Unit of the stiffness.
    pub stiffness: &'static str,
    /// Unit of the viscous coefficient.
    pub viscous_coefficient: &'static str,
    /// Unit of forces, or of torques.
    pub force: &'static str,
}

/// The angle with this name in rad. Prefixes are case-sensitive: `MRad` is not `mrad`.
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

/// Case-insensitive words for units, by symbol.
const WORDS: &[(&str, &[&str])] = &[
    ("m", &["meter", "metre", "meters", "metres"]),
    ("dm", &["decimeter", "decimetre", "decimeters", "decimetres"]),
    ("cm", &["centimeter", "centimetre", "centimeters", "centimetres"]),
    ("mm", &["millimeter", "millimetre", "millimeters", "millimetres"]),
    ("µm", &["micrometer", "micrometre", "micrometers", "micrometres", "micron", "microns"]),
    ("nm", &["nanometer", "nanometre", "nanometers", "nanometres"]),
    ("Å", &["angstrom", "angstroms", "ångström", "å"]),
    ("in", &["in", "inch", "inches"]),
    ("ft", &["ft", "feet"]),
    ("mil", &["mil", "mils"]),
    ("rad", &["radian", "radians"]),
    ("deg", &["degree", "degrees"]),
];

/// The symbol of a unit that may be written as a word.
fn symbol(unit: &str) -> &str {
    let lower = unit.to_lowercase();
    let of_word = WORDS.iter().find(|(_, words)| words.contains(&lower.as_str()));
    of_word.map_or(unit, |(symbol, _)| symbol)
}

/// The length with this name in m.
fn length(unit: &str) -> Option<f64> {
    Some(match symbol(unit) {
        "m" => 1.0,
        "dm" => 0.1,
        "cm" => 1e-2,
        "mm" => 1e-3,
        "um" | "µm" | "μm" => 1e-6,
        "nm" => 1e-9,
        "pm" => 1e-12,
        "fm" => 1e-15,
        "Å" => 1e-10,
        "in" => 0.0254,
        "ft" => 0.3048,
        "mil" => 25.4e-6,
        _ => return None,
    })
}

/// The unit whose time derivative this unit is, and the order of the derivative: `m` and 2 for `m/s^2`, `m s⁻²`,
/// `ms⁻²`, `m·s**-2`, `metre / second ** 2` and `m/s/s`; `deg` and 1 for `deg/sec` and `dps`. `None` for anything
/// else.
///
/// ```
/// use slipfit::model::displacement::derivative;
/// assert_eq!(derivative("mm s^-2"), Some(("mm".to_owned(), 2)));
/// assert_eq!(derivative("ms"), None);
/// ```
#[must_use]
pub fn derivative(unit: &str) -> Option<(String, u8)> {
    let unit = unit.trim();
    if unit.eq_ignore_ascii_case("dps") {
        return Some(("deg".to_owned(), 1));
    }
    let mut factors = factors(unit)?;
    // `ms⁻²` is not milliseconds to the power -2.
    if let [(name, power @ -2..=-1)] = &factors[..]
        && let Some(base) = name.strip_suffix('s').filter(|base| DisplacementUnit::named(base).is_some())
    {
        factors = vec![(base.to_owned(), 1), ("s".to_owned(), *power)];
    }
    let is_second = |name: &str| {
        ["s", "sec", "secs", "second", "seconds"].iter().any(|known| known.eq_ignore_ascii_case(name))
    };
    let (times, others): (Vec<_>, Vec<_>) = factors.into_iter().partition(|(name, _)| is_second(name));
    let order = match times.iter().map(|(_, power)| power).sum() {
        -1 => 1,
        -2 => 2,
        _ => return None,
    };
    let [(base, 1)] = &others[..] else { return None };
    Some((symbol(base).to_owned(), order))
}

/// The unit with powers written as `^-2`, products as blanks and quotients as `/`.
fn plain_marks(unit: &str) -> String {
    let mut plain = String::with_capacity(unit.len());
    let mut raised = false;
    for c in unit.replace("**", "^").chars() {
        let power = match c {
            '⁻' => Some('-'),
            '¹' => Some('1'),
            '²' => Some('2'),
            '³' => Some('3'),
            _ => None,
        };
        if power.is_some() && !raised {
            plain.push('^');
        }
        raised = power.is_some();
        plain.push(match (power, c) {
            (Some(power), _) => power,
            (None, '·' | '⋅' | '∙' | '•' | '*' | '.') => ' ',
            (None, '−' | '–') => '-',
            (None, '∕' | '⁄') => '/',
            (None, other) => other,
        });
    }
    plain
}

/// The factors of a unit and their powers, whatever notation is used for products, quotients and powers; `None` if it
/// is not a product of names.
///
/// ```
/// use slipfit::model::displacement::factors;
/// assert_eq!(factors("N m/rad"), Some(vec![("N".into(), 1), ("m".into(), 1), ("rad".into(), -1)]));
/// assert_eq!(factors("1/s"), Some(vec![("s".into(), -1)]));
/// assert_eq!(factors("10 m"), None);
/// ```
#[must_use]
pub fn factors(unit: &str) -> Option<Vec<(String, i32)>> {
    factors_of(&plain_marks(unit))
}

fn factors_of(unit: &str) -> Option<Vec<(String, i32)>> {
    let mut found: Vec<(String, i32)> = Vec::new();
    let inverse = || {
        unit.trim()
            .strip_prefix('1')?
            .trim_start()
            .strip_prefix('/')
            .map(str::trim_start)
            .filter(|below| !below.is_empty())
    };
    let (mut rest, mut sign) = inverse().map_or((unit.trim(), 1), |below| (below, -1));
    while !rest.is_empty() {
        if let Some(inner) = rest.strip_prefix('(') {
            let (inner, after) = inner.split_once(')')?;
            found.extend(factors_of(inner)?.into_iter().map(|(name, power)| (name, sign * power)));
            rest = after;
        } else {
            let is_letter = |c: char| c.is_alphabetic() || matches!(c, '°' | '%');
            let end = rest.find(|c: char| !is_letter(c)).unwrap_or(rest.len());
            let (name, after) = rest.split_at(end);
            let (power, after) = power(after)?;
            if name.is_empty() {
                return None;
            }
            found.push((name.to_owned(), sign * power));
            rest = after;
        }
        let next = rest.trim_start();
        (rest, sign) = match next.strip_prefix('/') {
            Some(after) if !after.trim_start().is_empty() => (after.trim_start(), -1),
            Some(_) => return None,
            // Two names must be separated by a product or quotient sign.
            None if next.len() == rest.len() && !next.is_empty() => return None,
            None => (next, 1),
        };
    }
    (found.len() <= 4).then_some(found)
}

/// The power at the start of the text after a name, 1 if there is none: `^-2`, ` ^ 2`, `-2`, `2`.
fn power(text: &str) -> Option<(i32, &str)> {
    let spaced = text.trim_start();
    let (marked, digits) = match spaced.strip_prefix('^') {
        Some(rest) => (true, rest.trim_start()),
        None => (false, text),
    };
    let (bracketed, digits) = match digits.strip_prefix('(').filter(|_| marked) {
        Some(inner) => (true, inner),
        None => (false, digits),
    };
    let (sign, number) = match digits.strip_prefix('-') {
        Some(number) => (-1, number),
        None => (1, digits),
    };
    let end = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
    if end == 0 {
        return (!marked && sign == 1).then_some((1, text));
    }
    let value: i32 = number[..end].parse().ok().filter(|value| *value < 10)?;
    let after = &number[end..];
    Some((sign * value, if bracketed { after.strip_prefix(')')? } else { after }))
}

/// The unit whose rate or acceleration `unit` may be: `deg` for `deg/s`.
pub(crate) fn before_time(unit: &str) -> String {
    let before = || unit.split(['/', ' ', '·']).next().unwrap_or("").to_owned();
    derivative(unit).map_or_else(before, |(base, _)| base)
}

impl Coordinate {
    /// Checks whether a mechanical constant of this coordinate can convert displacements in `unit`, or their rates
    /// and accelerations, into forces: a stiffness in N/m does not apply to an angle, nor a torsion stiffness to a
    /// length.
    ///
    /// A constant for angles requires a known angular unit. A constant for lengths also accepts unknown units, which
    /// gives forces in N/m times that unit, but not capacitances, which have no force.
    ///
    /// # Errors
    /// [`Error::WrongCoordinate`] if the unit does not fit.
    pub fn check_unit(self, unit: &str) -> Result<(), Error> {
        let base = before_time(unit.trim());
        let fits = match (self, DisplacementUnit::named(&base)) {
            (_, Some(known)) => known.coordinate == self,
            (Self::Angle, None) => false,
            (Self::Length, None) => !is_capacitance(&base),
        };
        if fits {
            Ok(())
        } else {
            Err(Error::WrongCoordinate { expected: self.words(), unit: unit.to_owned() })
        }
    }

    /// Units of the mechanical constants for this coordinate.
    #[must_use]
    pub const fn mechanical_units(self) -> MechanicalUnits {
        match self {
            Self::Length => {
                MechanicalUnits { mass: "kg", stiffness: "N/m", viscous_coefficient: "kg/s", force: "N" }
            }
            Self::Angle => MechanicalUnits {
                mass: "kg m²",
                stiffness: "N m/rad",
                viscous_coefficient: "N m s/rad",
                force: "N m",
            },
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
    fn derivatives_are_known_by_many_spellings() {
        for unit in [
            "m/s^2",
            "m/s²",
            "m/s2",
            "m/s**2",
            "m/s/s",
            "m/sec^2",
            "m/(s^2)",
            "m/(s·s)",
            "m s^-2",
            "m s-2",
            "m s⁻²",
            "m·s⁻²",
            "m*s^-2",
            "m s**-2",
            "m.s-2",
            "ms⁻²",
            "ms^-2",
            "ms-2",
            "meter / second ** 2",
            "metre/second^2",
            "m / s ^ 2",
            "m s^(-2)",
            "(m/s)/s",
            "(m/s^2)",
            "s^-2 m",
            "m s\u{2212}2",
        ] {
            assert_eq!(derivative(unit), Some(("m".to_owned(), 2)), "{unit}");
        }
        for (unit, base) in [
            ("rad/s", "rad"),
            ("rad s-1", "rad"),
            ("rads⁻¹", "rad"),
            ("rad/sec", "rad"),
            ("°/s", "°"),
            ("deg / sec", "deg"),
            ("dps", "deg"),
            ("ms⁻¹", "m"),
            ("mms-1", "mm"),
            ("m s-1", "m"),
            ("V/s", "V"),
            ("µm/s", "µm"),
            ("inches/s", "in"),
            ("Å/s", "Å"),
            ("microns/second", "µm"),
            ("px/s", "px"),
            ("MM/S", "MM"),
        ] {
            assert_eq!(derivative(unit), Some((base.to_owned(), 1)), "{unit}");
        }
        for unit in [
            "",
            "m",
            "s",
            "ms",
            "1/s",
            "s^-1",
            "s-1",
            "ms^2",
            "m s",
            "V/m/s",
            "V/(m/s)",
            "m/s/N",
            "g",
            "m/s^3",
            "kg m/s^2",
            "nm/√Hz",
            "m/",
            "/s",
            "m//s",
            "m^2/s",
            "((m/s",
            "ps^-1",
            "m/s^",
            "m-/s",
            "s s^-2",
            "S^-1",
            "m/s)",
            "mm^99999999999/s",
            "m/s-2",
        ] {
            assert_eq!(derivative(unit), None, "{unit}");
        }
    }

    #[test]
    fn a_constant_belongs_to_its_coordinate() {
        assert_eq!(Coordinate::Length.check_unit("mm"), Ok(()));
        assert_eq!(Coordinate::Length.check_unit("V"), Ok(()), "nobody knows");
        assert!(Coordinate::Length.check_unit("deg").is_err());
        assert!(Coordinate::Angle.check_unit("nm").is_err());
        for unit in ["deg", "Deg", "°/s", "rad/s^2", "rad s^-2", "rads⁻²", "mrad"] {
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

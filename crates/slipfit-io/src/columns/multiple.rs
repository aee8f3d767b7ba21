//! Units of frequency with a number in front.

use super::units::hertz;

/// Value in Hz of a number with a unit, such as `80.1 Hz`, the reference of a column of ratios.
pub(super) fn number_of_hertz(unit: &str) -> Option<f64> {
    let unit = unit.trim();
    let letters = unit.find(|c: char| c.is_alphabetic())?;
    let number: f64 = unit[..letters].trim().parse().ok()?;
    let hz = number * hertz(&unit[letters..])?;
    (hz.is_finite() && hz > 0.0).then_some(hz)
}

/// Factor to Hz of numbers in a multiple of a unit: `1000 Hz`, `x1000 Hz`, `10^3 Hz`.
pub(super) fn multiple_of_hertz(unit: &str) -> Option<f64> {
    let unit = unit.trim().trim_start_matches(['x', '\u{d7}', '*', ' ']);
    number_of_hertz(unit).or_else(|| {
        let (power, unit) = unit.strip_prefix("10^")?.split_once(' ')?;
        let power: i32 = power.parse().ok().filter(|power: &i32| power.abs() < 13)?;
        Some(10f64.powi(power) * hertz(unit)?)
    })
}

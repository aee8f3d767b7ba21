//! Ratios of units that are products: `N/mm` in `N/m`, `kg/s^2` in `N/m`.

use slipfit::model::displacement::factors;

/// Exponents of length, mass, time, voltage and current.
type Powers = [i32; 5];

/// Names that may be factors of a product.
const NAMES: [(&str, Powers); 7] = [
    ("s", [0, 0, 1, 0, 0]),
    ("m", [1, 0, 0, 0, 0]),
    ("kg", [0, 1, 0, 0, 0]),
    ("N", [1, 1, -2, 0, 0]),
    ("rad", [0, 0, 0, 0, 0]),
    ("V", [0, 0, 0, 1, 0]),
    ("A", [0, 0, 0, 0, 1]),
];

/// Factor from numbers in one product to numbers in another of the same quantity; `of_names` converts its factors.
pub(super) fn ratio(from: &str, to: &str, of_names: fn(&str, &str) -> Option<f64>) -> Option<f64> {
    let ((from, of), (to, wanted)) = (size(from, of_names)?, size(to, of_names)?);
    (of == wanted).then_some(from / to)
}

/// Size of a unit relative to the SI unit of its quantity, and its exponents; 1 is the unit of pure numbers.
fn size(unit: &str, of_names: fn(&str, &str) -> Option<f64>) -> Option<(f64, Powers)> {
    let found = if unit == "1" { Vec::new() } else { factors(unit)? };
    found.iter().try_fold((1.0, Powers::default()), |(size, powers), (name, power)| {
        let (factor, of) = NAMES.iter().find_map(|(si, of)| Some((of_names(name, si)?, of)))?;
        let sum = std::array::from_fn(|k| powers[k] + power * of[k]);
        Some((size * factor.powi(*power), sum))
    })
}

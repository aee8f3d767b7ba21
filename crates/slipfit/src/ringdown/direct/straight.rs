//! Series for decays that are close to straight lines.

/// Number of decay times in a trace below which `(1 - e^(-x u))/x` is computed as a series: sums of
/// exponentials lose digits in proportion to its square.
pub(super) const STRAIGHT: f64 = 0.25;

/// Coefficients of `(e^z - 1)/z = sum z^j/(j+1)!`; twelve of them are exact to rounding below a quarter.
pub(super) const SHARE: [f64; 12] = series(false);
/// Those of its derivative, `sum (j+1) z^j/(j+2)!`.
pub(super) const BEND: [f64; 12] = series(true);

const fn series(derivative: bool) -> [f64; 12] {
    let mut out = [0.0; 12];
    let (mut j, mut factorial) = (0, 1.0);
    while j < 12 {
        let next = (j + 1) as f64;
        factorial *= next;
        out[j] = if derivative { next / (factorial * (next + 1.0)) } else { 1.0 / factorial };
        j += 1;
    }
    out
}

//! Whether the residuals of the law are noise.

use crate::numeric::trig::exp;

/// Number of parts of a trace whose mean residuals are tested.
const PARTS: usize = 10;
/// Number of samples below which the parts contain too few for a noise estimate.
const FEWEST: usize = 2 * PARTS;
/// Number of unknowns of the law.
pub(super) const UNKNOWNS: usize = 3;
/// Number of decay times below which `1 - e^(-z)` loses digits that its series retains.
const GENTLE: f64 = 1e-3;
/// Residuals below this fraction of the signal's power are those of rounded samples.
const EXACT: f64 = 1e-12;

/// Ratio of the variance of the mean residuals of ten parts to that within the parts, and its degrees of
/// freedom.
pub(super) fn lack_of_fit(
    elapsed: impl Fn(usize) -> f64,
    amplitude: &[f64],
    [initial, slope, rate]: [f64; 3],
) -> [f64; 2] {
    let n = amplitude.len();
    if n < FEWEST {
        return [0.0; 2];
    }
    let gentle = (rate * elapsed(n - 1)).abs() < GENTLE;
    let (mut between, mut all, mut power) = (0.0, 0.0, 0.0);
    for part in 0..PARTS {
        let range = part * n / PARTS..(part + 1) * n / PARTS;
        let count = range.len() as f64;
        let mut sum = 0.0;
        for i in range {
            let u = elapsed(i);
            let z = rate * u;
            let gain = if gentle {
                u * (1.0 - z / 2.0 * (1.0 - z / 3.0 * (1.0 - z / 4.0)))
            } else {
                (1.0 - exp(-z)) / rate
            };
            let residual = amplitude[i] - (initial - slope * gain);
            sum += residual;
            all += residual * residual;
            power += amplitude[i] * amplitude[i];
        }
        between += sum * sum / count;
    }
    if all > EXACT * power { ratio(between, all, PARTS, n) } else { [0.0; 2] }
}

/// The ratio of variances and the numerator's degrees of freedom, for residuals with sum of squares `all`, of
/// which `slow` lies in the slow part of the given number of dimensions.
#[inline(always)]
pub(super) fn ratio(slow: f64, all: f64, dimensions: usize, samples: usize) -> [f64; 2] {
    let freedom = (dimensions - UNKNOWNS) as f64;
    let noise = (all - slow) / (samples - dimensions) as f64;
    // Without noise there is nothing to compare with.
    if noise > 0.0 && slow > 0.0 { [slow / freedom / noise, freedom] } else { [0.0, freedom] }
}

//! Feldman-Cousins intervals of a parameter that cannot be below zero.
//!
//! A loss coefficient cannot be negative. For an estimate `z` standard errors above the limit (below it if negative)
//! the interval is that of Feldman and Cousins (1998), Phys. Rev. D 57, 3873: it covers 95 % for every true value, is
//! never empty, and changes continuously from two-sided to an upper limit.

use super::Z_95;
use crate::numeric::roots::root;
use statrs::function::erf::erf;

fn phi(x: f64) -> f64 {
    0.5 * (1.0 + erf(x / std::f64::consts::SQRT_2))
}

/// Point of the normal distribution below which 95 % of the probability lies.
const Z_95_BELOW: f64 = 1.644_853_626_951_472_2;
/// Smallest true value considered in the search for the end of an interval.
const FLOOR: f64 = 1e-6;

/// Probability of an estimate between `below` and `above` standard errors from the true value.
fn between(below: f64, above: f64) -> f64 {
    phi(above) - phi(below)
}

/// The interval for the true value, in standard errors above the limit, given an estimate `z` standard errors above it.
///
/// The estimates in the acceptance region of a true value `mu` are ranked by their likelihood ratio against the best
/// allowed value, `ln R = -(x - mu)²/2` for `x >= 0` and `x mu - mu²/2` for `x < 0`. The region extends up to `mu + h`
/// and down to the estimate of equal rank, `mu - h` if that is not negative and `(mu² - h²)/(2 mu)` otherwise; `h`
/// gives it a probability of 95 %. The ends of the interval are the true values for which `z` is at an edge of the
/// region; both edges increase with `mu`.
pub(crate) fn bounded_interval(z: f64) -> [f64; 2] {
    [lower_end(z), upper_end(z)]
}

/// The true value whose acceptance region has `z` as its upper edge.
fn lower_end(z: f64) -> f64 {
    if !(z > Z_95_BELOW + FLOOR) {
        return 0.0;
    }
    if z >= 2.0 * Z_95 {
        return z - Z_95;
    }
    let content = |h: f64| {
        let mu = z - h;
        between(if h <= mu { -h } else { -(mu * mu + h * h) / (2.0 * mu) }, h)
    };
    z - root(1.0, z, |h| content(h) - 0.95)
}

/// The true value whose acceptance region has `z` as its lower edge.
fn upper_end(z: f64) -> f64 {
    if z >= 0.0 {
        return z + Z_95;
    }
    // Equal rank: h² = mu² - 2 mu z.
    let content = |mu: f64| between(z - mu, (mu * (mu - 2.0 * z)).sqrt());
    if content(FLOOR) >= 0.95 { FLOOR } else { root(FLOOR, Z_95, |mu| content(mu) - 0.95) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability, summed over a fine grid of estimates, that the interval covers the true value.
    #[test]
    fn covers_95_percent_at_and_beside_the_limit() {
        for mu in [0.0, 0.3, 1.0, 1.7, 2.5, 4.0] {
            let step = 0.005;
            let covered: f64 = (-1200..2400)
                .map(|i| (i as f64 + 0.5) * step)
                .filter(|&x| {
                    let [low, high] = bounded_interval(x);
                    low <= mu && mu <= high
                })
                .map(|x| step * (-0.5 * (x - mu) * (x - mu)).exp() / (2.0 * std::f64::consts::PI).sqrt())
                .sum();
            assert!((covered - 0.95).abs() < 0.003, "truth {mu}: {covered}");
        }
    }

    /// Ends computed directly from the acceptance region of each true value.
    #[test]
    fn ends_are_those_of_the_acceptance() {
        let acceptance = |mu: f64| {
            let lower = |h: f64| if h <= mu { mu - h } else { (mu * mu - h * h) / (2.0 * mu) };
            let h = root(1.0, 3.0, |h| between(lower(h) - mu, h) - 0.95);
            [lower(h), mu + h]
        };
        for k in -60..80 {
            let z = 0.1 * f64::from(k) + 0.013;
            let [low, high] = bounded_interval(z);
            let solved = |edge: usize| root(FLOOR, 12.0, |mu| acceptance(mu)[edge] - z);
            let expected = if z <= Z_95_BELOW { 0.0 } else { solved(1) };
            assert!((low - expected).abs() < 1e-9, "{z}: {low} for {expected}");
            assert!((high - solved(0)).abs() < 1e-9, "{z}: {high} for {}", solved(0));
        }
        assert_eq!(bounded_interval(-1e9), [0.0, FLOOR]);
    }

    #[test]
    fn turns_into_an_upper_limit_by_itself() {
        assert_eq!(bounded_interval(0.0)[0], 0.0);
        assert!((bounded_interval(0.0)[1] - 1.96).abs() < 0.01);
        assert!(bounded_interval(-3.0)[1] > 0.1);
        assert!(bounded_interval(2.0)[0] > 0.0);
    }

    #[test]
    fn is_the_usual_interval_far_from_the_limit() {
        let [a, b] = bounded_interval(5.9);
        assert!((a - (5.9 - Z_95)).abs() < 1e-3);
        assert!((b - (5.9 + Z_95)).abs() < 1e-3);
    }
}

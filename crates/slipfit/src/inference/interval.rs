//! Confidence intervals that stay honest beside a physical limit.
//!
//! A loss coefficient cannot be negative. For an estimate `z` standard errors
//! above the limit (below it when negative) the interval is that of Feldman and
//! Cousins (1998), Phys. Rev. D 57, 3873: it covers 95 % for every true value,
//! is never empty, and turns from two-sided to an upper limit by itself.

use super::Z_95;
use crate::numeric::roots::root;
use statrs::function::erf::erf;

fn phi(x: f64) -> f64 {
    0.5 * (1.0 + erf(x / std::f64::consts::SQRT_2))
}

/// Acceptance interval of the estimate for a true value `mu` (in standard errors): the
/// estimates ranked first by likelihood ratio against the best value allowed.
fn acceptance(mu: f64) -> (f64, f64) {
    // ln R = -(x-mu)²/2 for x >= 0, x mu - mu²/2 for x < 0. With half width h above mu the
    // lower edge of equal rank is mu - h while that is >= 0, else (mu² - h²)/(2 mu).
    let lower = |h: f64| if h <= mu { mu - h } else { (mu * mu - h * h) / (2.0 * mu) };
    let content = |h: f64| phi(h) - phi(lower(h) - mu);
    let h = root(1.0, 3.0, |h| content(h) - 0.95);
    (lower(h), mu + h)
}

/// The interval for the true value, in standard errors above the limit, given
/// an estimate `z` standard errors above it.
pub(crate) fn bounded_interval(z: f64) -> [f64; 2] {
    if z > 6.0 {
        return [z - Z_95, z + Z_95];
    }
    // The edges of acceptance rise with mu.
    let solve = |edge: fn((f64, f64)) -> f64, a: f64, b: f64| root(a, b, |mu| edge(acceptance(mu)) - z);
    let floor = 1e-6;
    let low = if acceptance(floor).1 >= z { 0.0 } else { solve(|e| e.1, floor, 8.0) };
    let high = solve(|e| e.0, floor, 12.0);
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability, summed over a fine grid of estimates, that the interval holds the truth.
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

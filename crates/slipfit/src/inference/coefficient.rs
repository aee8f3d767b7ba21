//! A coefficient that the reported model does not have and that the data do not exclude.

use statrs::function::erf::erfc;
use std::f64::consts::{PI, SQRT_2};

/// Estimate of a parameter by another model, and the probability of that model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightedEstimate {
    /// Probability of the model relative to the reported one; the weights of several kinds of models may sum to more
    /// than one.
    pub(crate) weight: f64,
    pub(crate) value: f64,
    pub(crate) std_error: f64,
}

/// Odds above which a model counts as certain.
const MOST_ODDS: f64 = 1e12;

/// A coefficient that the model does not have: its probability, and its value if it is present.
///
/// Its prior is uniform between zero and `most`. With a normal likelihood of estimate `a` and standard error `s`, the
/// odds of the model with it are `s sqrt(2 pi)/most exp(z²/2) [Phi(z) - Phi(z - most/s)]`, `z = a/s`. Unlike the BIC,
/// whose prior is as wide as the information of one observation, this leaves weight on values that the data could not
/// have detected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AbsentCoefficient {
    /// Odds of the model with it against the model without it.
    pub(crate) odds: f64,
    /// Posterior mean of the coefficient, within its limits.
    mean: f64,
    variance: f64,
}

impl AbsentCoefficient {
    /// From an estimate without limits and its standard error. `most` is negative if the coefficient cannot be
    /// positive; `prior` are the prior odds.
    pub(crate) fn within(estimate: f64, std_error: f64, most: f64, prior: f64) -> Self {
        let unit = std_error.copysign(most);
        let truncated = Truncated::new(estimate / unit, most / unit);
        let odds = prior * unit * (2.0 * PI).sqrt() / most * truncated.likelihood;
        Self {
            odds: odds.min(MOST_ODDS),
            mean: truncated.mean * unit,
            variance: truncated.variance * unit * unit,
        }
    }

    /// Estimate, by the model with the coefficient, of a quantity whose value is `without` at zero coefficient and
    /// changes by `slope` times the coefficient, with conditional variance `given`; `total` is the sum of the odds of
    /// all models.
    pub(crate) fn weighted_estimate(
        &self,
        without: f64,
        slope: f64,
        given: f64,
        total: f64,
    ) -> WeightedEstimate {
        WeightedEstimate {
            weight: self.odds / total,
            value: without + slope * self.mean,
            std_error: (given + slope * slope * self.variance).sqrt(),
        }
    }
}

/// A normal distribution of unit width about `z`, truncated to the range from zero to `most`.
struct Truncated {
    /// `exp(z²/2)` times its integral.
    likelihood: f64,
    mean: f64,
    variance: f64,
}

impl Truncated {
    fn new(z: f64, most: f64) -> Self {
        if z <= most {
            return Self::below(z, most);
        }
        // Reflected about the upper end it is centred at a negative value.
        let mirrored = Self::below(most - z, most);
        Self {
            likelihood: (most * (z - 0.5 * most)).exp() * mirrored.likelihood,
            mean: most - mirrored.mean,
            ..mirrored
        }
    }

    /// For a `z` not above `most`.
    fn below(z: f64, most: f64) -> Self {
        let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
        let beyond = |x: f64| 0.5 * erfc(x / SQRT_2);
        // Far below zero the distribution is exponential with rate -z.
        if z < -30.0 {
            let left = (z * most).exp_m1();
            let behind = most * (1.0 + left) / left;
            let mean = behind - 1.0 / z;
            return Self {
                likelihood: left / z / (2.0 * PI).sqrt(),
                mean,
                variance: (1.0 / (z * z) - most * behind / left).max(0.0),
            };
        }
        let top = most - z;
        let content = beyond(-z) - beyond(top);
        let shift = (density(z) - density(top)) / content;
        let square = (-z * density(z) - top * density(top)) / content;
        Self {
            likelihood: (0.5 * z * z).exp() * content,
            mean: z + shift,
            variance: (1.0 + square - shift * shift).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate;

    #[test]
    fn a_truncated_normal_has_the_moments_of_its_integral() {
        let cases = [
            (-5.0, 3.0),
            (-1.0, 10.0),
            (0.3, 0.5),
            (2.0, 30.0),
            (4.0, 5.0),
            (9.0, 1.0),
            (9.5, 1.0),
            (12.0, 3.0),
        ];
        for (z, most) in cases {
            let moment = |k: i32| {
                integrate(&|x: f64| x.powi(k) * (z * x - 0.5 * x * x).exp() / (2.0 * PI).sqrt(), 0.0, most)
            };
            let found = Truncated::new(z, most);
            let mean = moment(1) / moment(0);
            let variance = moment(2) / moment(0) - mean * mean;
            assert!((found.likelihood / moment(0) - 1.0).abs() < 1e-6, "{z} {most}");
            assert!((found.mean / mean - 1.0).abs() < 1e-5, "{z} {most}: {} {mean}", found.mean);
            assert!((found.variance / variance - 1.0).abs() < 1e-3, "{z} {most}: {}", found.variance);
        }
        for (z, most) in [(-31.0, 0.02), (-29.0, 0.02)] {
            let found = Truncated::new(z, most);
            let mean = 1.0 / -z - most / ((-z * most).exp() - 1.0);
            assert!((found.mean / mean - 1.0).abs() < 2e-3, "{z}: {} for {mean}", found.mean);
        }
        let narrow = Truncated::new(-8.0, 0.05);
        assert!((narrow.mean - (0.025 - 8.0 * 0.05 * 0.05 / 12.0)).abs() < 1e-5, "{}", narrow.mean);
        assert!((narrow.variance * 12.0 / (0.05 * 0.05) - 1.0).abs() < 0.05, "{}", narrow.variance);
        let far = Truncated::new(-40.0, 5.0);
        assert!((far.mean * 40.0 - 1.0).abs() < 0.01, "{}", far.mean);
        assert!(far.likelihood.is_finite());
    }

    #[test]
    fn limits_below_zero_mirror_those_above() {
        let [above, below] = [1.0, -1.0].map(|s| AbsentCoefficient::within(0.3 * s, 0.2, 0.9 * s, 0.5));
        assert!((above.odds - below.odds).abs() < 1e-15);
        assert_eq!([above.mean, above.variance], [-below.mean, below.variance]);
    }
}

//! The noise model: converts a sum of squares into standard errors, tests and criteria.

use super::evidence::{bic, one_sided_p_value, student_factor};
use super::least_squares::Fit;

/// Variance of the weighted observations, known or estimated from the residuals, and its inflation if the residuals are
/// autocorrelated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoiseModel {
    /// Number of observations in the sum of squares.
    pub(crate) observations: f64,
    /// Variance of one weighted observation if known; `None` if it is estimated from the residuals.
    pub(crate) known_variance: Option<f64>,
    /// Variance inflation for autocorrelated residuals; 1 for white ones.
    pub(crate) variance_inflation: f64,
}

impl NoiseModel {
    /// White noise whose variance is estimated from the residuals.
    pub(crate) fn white(observations: f64) -> Self {
        Self { observations, known_variance: None, variance_inflation: 1.0 }
    }

    /// Variance of one weighted observation, without inflation.
    pub(crate) fn residual_variance(&self, fit: &Fit) -> f64 {
        let dof = (self.observations - fit.free.len() as f64).max(1.0);
        self.known_variance.unwrap_or(fit.rss / dof)
    }

    /// Variance of one weighted observation, as used in standard errors.
    pub(crate) fn variance(&self, fit: &Fit) -> f64 {
        self.residual_variance(fit) * self.variance_inflation
    }

    /// Degrees of freedom of the variance.
    ///
    /// The squares of AR(1) residuals have a correlation of rho², so that the effective fraction is
    /// `(1 - rho²)/(1 + rho²)`, with `variance_inflation = (1 + rho)/(1 - rho)`.
    fn degrees_of_freedom(&self, fit: &Fit) -> f64 {
        if self.known_variance.is_some() {
            return f64::INFINITY;
        }
        let inflation = self.variance_inflation;
        let share = 2.0 * inflation / (1.0 + inflation * inflation);
        ((self.observations - fit.free.len() as f64) * share).max(1.0)
    }

    /// Bayesian information criterion, with the autocorrelation taken into account.
    pub(crate) fn bic(&self, rss: f64, parameters: usize) -> f64 {
        let effective = (self.observations / self.variance_inflation).max(2.0);
        match self.known_variance {
            // If the noise is known, the likelihood does not require an estimate of it.
            Some(v) => {
                (rss / (v * self.variance_inflation).max(f64::MIN_POSITIVE)).min(f64::MAX)
                    + parameters as f64 * effective.ln()
            }
            None => bic(rss, self.observations, effective, parameters),
        }
    }

    /// One-sided p value of one additional term that cannot be negative. `large` is the fit with the term within its
    /// limits, `unbounded` the unbounded fit with all parameters.
    pub(crate) fn p_value(&self, small_rss: f64, large: &Fit, unbounded: &Fit) -> f64 {
        one_sided_p_value((small_rss - large.rss) / self.variance(large), self.degrees_of_freedom(unbounded))
    }

    /// Standard error of one parameter.
    pub(crate) fn std_error(&self, fit: &Fit, parameter: usize) -> f64 {
        fit.unit_std(parameter) * self.variance(fit).sqrt()
    }

    /// Half width of a 95 % interval over `1.96` standard errors, which exceeds 1 for few observations.
    pub(crate) fn student_factor(&self, fit: &Fit) -> f64 {
        student_factor(self.degrees_of_freedom(fit))
    }
}

/// Lag-one autocorrelation of residuals.
pub(crate) fn autocorrelation(residuals: &[f64]) -> f64 {
    let n = residuals.len() as f64;
    let mean = residuals.iter().sum::<f64>() / n;
    let (mut c0, mut c1) = (0.0, 0.0);
    for (i, r) in residuals.iter().enumerate() {
        c0 += (r - mean).powi(2);
        if i > 0 {
            c1 += (r - mean) * (residuals[i - 1] - mean);
        }
    }
    if c0 > 0.0 { c1 / c0 } else { 0.0 }
}

/// [`ar1_variance_inflation`] of `n` residuals if their autocorrelation exceeds `significance` standard errors
/// (`1/sqrt(n)` for white residuals), otherwise 1.
pub(crate) fn significant_inflation(rho: f64, n: usize, significance: f64) -> f64 {
    if rho > significance / (n as f64).sqrt() { ar1_variance_inflation(rho) } else { 1.0 }
}

/// Variance inflation `(1 + rho)/(1 - rho)` of AR(1) residuals about a slowly varying model.
pub(crate) fn ar1_variance_inflation(rho: f64) -> f64 {
    let rho = rho.min(MOST_AUTOCORRELATION);
    (1.0 + rho) / (1.0 - rho)
}

/// Above this autocorrelation the residuals are a misfit rather than noise, and no variance inflation accounts for it.
const MOST_AUTOCORRELATION: f64 = 0.95;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alternating_residuals_have_an_autocorrelation_of_minus_one() {
        let residuals: Vec<f64> = (0..1000).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert!((autocorrelation(&residuals) + 1.0).abs() < 2e-3);
        assert_eq!(autocorrelation(&[2.0; 5]), 0.0);
    }

    #[test]
    fn inflation_is_that_of_the_mean_of_an_ar1_series() {
        assert_eq!(ar1_variance_inflation(0.0), 1.0);
        assert!((ar1_variance_inflation(0.5) - 3.0).abs() < 1e-12);
        assert!((ar1_variance_inflation(0.999) - 39.0).abs() < 1e-9);
    }
}

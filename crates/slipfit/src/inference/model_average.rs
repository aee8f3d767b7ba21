//! Averages over models, each weighted by its probability.

use nalgebra::DMatrix;

/// Probabilities of the models compared; their sum is one.
pub(crate) struct ModelWeights(Vec<f64>);

impl ModelWeights {
    /// From the prior odds of each model and minus twice the logarithm of its likelihood.
    pub(crate) fn new(models: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let models: Vec<[f64; 2]> = models.into_iter().collect();
        let least = models.iter().map(|[_, deviance]| *deviance).fold(f64::INFINITY, f64::min);
        let of = |[odds, deviance]: &[f64; 2]| odds * (-0.5 * (deviance - least)).exp();
        let total: f64 = models.iter().map(of).sum();
        Self(models.iter().map(|model| of(model) / total).collect())
    }

    /// Weighted mean over the models of a quantity.
    pub(crate) fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.0.iter().enumerate().map(|(model, weight)| weight * of(model)).sum()
    }

    /// Mean of the estimates of the models, and their covariance: within the models plus between the models (Hoeting et
    /// al. 1999, Statistical Science 14, 382, eqs. 3 and 4).
    pub(crate) fn moments<'a>(
        &self,
        estimates: impl Fn(usize) -> &'a [f64],
        covariance: impl Fn(usize, (usize, usize)) -> f64,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let n = estimates(0).len();
        let mean: Vec<f64> = (0..n).map(|k| self.mean(|model| estimates(model)[k])).collect();
        let off = |model: usize, k: usize| estimates(model)[k] - mean[k];
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            self.mean(|model| covariance(model, (i, j)) + off(model, i) * off(model, j))
        });
        (mean, covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_has_the_moments_of_its_parts() {
        // Equal likelihoods, prior odds of three to one: about 1 with variance 4, and about 5 with variance 2.
        let weights = ModelWeights::new([[3.0, 7.0], [1.0, 7.0]]);
        let estimates = [[1.0], [5.0]];
        let (mean, covariance) = weights.moments(|m| &estimates[m], |m, _| [4.0, 2.0][m]);
        assert!((mean[0] - 2.0).abs() < 1e-14);
        assert!((covariance[(0, 0)] - (0.75 * (4.0 + 1.0) + 0.25 * (2.0 + 9.0))).abs() < 1e-13);
    }

    #[test]
    fn a_model_far_less_likely_counts_for_nothing() {
        let weights = ModelWeights::new([[1.0, 1e4], [1.0, 2e4]]);
        assert_eq!(weights.mean(|m| m as f64), 0.0);
    }
}

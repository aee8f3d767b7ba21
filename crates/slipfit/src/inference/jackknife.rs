//! Variance of fitted parameters between clusters of observations: the delete-one-cluster jackknife.
//!
//! `σ² (JᵀJ)⁻¹` assumes independent errors of equal variance. This is violated by noise that changes along a record, a
//! converter whose steps span several samples, and small disturbances. If the observations of a cluster `c` are left
//! out, the parameters change by
//!
//! ```text
//! -(A - A_c)⁻¹ g_c,   A = JᵀJ,   g_c = J_cᵀ r_c
//! ```
//!
//! which under white noise has the variance `σ² [(A - A_c)⁻¹ - A⁻¹]`. The sum of the squared changes over the sum of
//! these variances is the ratio of the variance of a parameter to that under white noise, whichever observations
//! determine the parameter (J. G. MacKinnon, M. Ø. Nielsen and M. D. Webb, *J. Appl. Econometrics* 38, 671, 2023).

use nalgebra::{DMatrix, DVector};

/// Largest and smallest number of clusters.
pub(crate) const MOST_CLUSTERS: usize = 32;
const LEAST_CLUSTERS: usize = 4;

/// `J_cᵀ J_c` and `J_cᵀ r_c` of the observations of a cluster, at the minimum of the sum over all clusters.
#[derive(Debug, Clone)]
pub(crate) struct Cluster {
    products: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Cluster {
    /// From the products of the derivatives with respect to the parameters and the residual, row by row of the lower
    /// triangle.
    pub(crate) fn from_rows(parameters: usize, rows: &[f64]) -> Self {
        let at = |a: usize, b: usize| rows[a.max(b) * (a.max(b) + 1) / 2 + a.min(b)];
        Self {
            products: DMatrix::from_fn(parameters, parameters, at),
            gradient: DVector::from_fn(parameters, |a, _| at(parameters, a)),
        }
    }

    /// From the weighted derivatives and the weighted residual of each observation.
    pub(crate) fn from_observations(
        parameters: usize,
        observations: impl Iterator<Item = (DVector<f64>, f64)>,
    ) -> Self {
        let none =
            Self { products: DMatrix::zeros(parameters, parameters), gradient: DVector::zeros(parameters) };
        observations.fold(none, |mut sum, (derivatives, residual)| {
            sum.products += &derivatives * derivatives.transpose();
            sum.gradient += derivatives * residual;
            sum
        })
    }
}

/// Variance inflation of the parameter (among the given indices) that the clusters change most: the ratio of its
/// variance to that under white noise of the given `variance`. 1 if white noise exceeds the ratio with at least the
/// probability that a normal variable exceeds `significance`.
pub(crate) fn variance_inflation(
    clusters: &[Cluster],
    parameters: &[usize],
    variance: f64,
    significance: f64,
) -> f64 {
    let Some((first, others)) = clusters.split_first() else { return 1.0 };
    let all = others.iter().fold(first.products.clone(), |sum, cluster| sum + &cluster.products);
    let Some(whole) = all.clone().cholesky() else { return 1.0 };
    let unit = |k: usize| DVector::from_fn(all.nrows(), |a, _| if a == k { 1.0 } else { 0.0 });
    let known: Vec<f64> = parameters.iter().map(|k| whole.solve(&unit(*k))[*k]).collect();
    let mut sums = vec![ParameterChange::default(); parameters.len()];
    for cluster in clusters {
        // If one cluster alone determines a parameter, it is skipped.
        let Some(without) = (&all - &cluster.products).cholesky() else { continue };
        let moved = without.solve(&cluster.gradient);
        for ((sum, &k), known) in sums.iter_mut().zip(parameters).zip(&known) {
            sum.add(moved[k], variance * (without.solve(&unit(k))[k] - known));
        }
    }
    sums.iter().filter_map(|sum| sum.inflation(significance)).fold(1.0, f64::max)
}

/// Accumulated changes of one parameter over the clusters.
#[derive(Debug, Clone, Copy, Default)]
struct ParameterChange {
    clusters: usize,
    squares: f64,
    expected_variance: f64,
    expected_squares: f64,
}

impl ParameterChange {
    fn add(&mut self, moved: f64, expected: f64) {
        self.clusters += 1;
        self.squares += moved * moved;
        self.expected_variance += expected;
        self.expected_squares += expected * expected;
    }

    fn inflation(&self, significance: f64) -> Option<f64> {
        let ratio = self.squares / self.expected_variance;
        let freedom = self.expected_variance * self.expected_variance / self.expected_squares;
        // Quantile of chi square over its degrees of freedom (E. B. Wilson and M. M. Hilferty, PNAS 17, 684, 1931).
        let width = 2.0 / (9.0 * freedom);
        let white = (1.0 - width + significance * width.sqrt()).powi(3);
        (self.clusters >= LEAST_CLUSTERS && ratio > white && ratio.is_finite()).then_some(ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    /// The clusters of a straight line through 96 observations with errors of 1, `scale` times as large in the first
    /// quarter, and the variance of its residuals.
    fn line(repeat: usize, scale: f64) -> (Vec<Cluster>, f64) {
        const N: usize = 96;
        let row = |i: usize| DVector::from_vec(vec![1.0, i as f64 / N as f64]);
        let error = |i: usize| if i < N / 4 { scale } else { 1.0 } * jitter(repeat * N + i, 11);
        let all = Cluster::from_observations(2, (0..N).map(|i| (row(i), error(i))));
        let fit = all.products.clone().cholesky().expect("regular").solve(&all.gradient);
        let left = |i: usize| error(i) - row(i).dot(&fit);
        let variance = (0..N).map(|i| left(i).powi(2)).sum::<f64>() / (N - 2) as f64;
        let cluster =
            |k: usize| Cluster::from_observations(2, (8 * k..8 * (k + 1)).map(|i| (row(i), left(i))));
        ((0..N / 8).map(cluster).collect(), variance)
    }

    #[test]
    fn white_noise_inflates_nothing() {
        let inflated = (0..200).filter(|repeat| {
            let (clusters, variance) = line(*repeat, 1.0);
            variance_inflation(&clusters, &[0, 1], variance, 2.6) > 1.0
        });
        assert!(inflated.count() < 10);
    }

    /// The intercept is determined where the errors are large: its variance inflation relative to the mean variance of
    /// the errors is that of repeated fits.
    #[test]
    fn errors_of_unequal_variance_count_where_they_act() {
        let mean = |of: &dyn Fn(usize) -> f64| (0..200).map(of).sum::<f64>() / 200.0;
        let ratio = mean(&|repeat| {
            let (clusters, variance) = line(repeat, 5.0);
            variance_inflation(&clusters, &[0], variance, 0.0)
        });
        // (JᵀJ)⁻¹ Jᵀ V J (JᵀJ)⁻¹ over the mean of V times (JᵀJ)⁻¹, for the intercept.
        let row = |i: usize| DVector::from_vec(vec![1.0, i as f64 / 96.0]);
        let weight = |i: usize| if i < 24 { 5.0 } else { 1.0 };
        let products = |of: &dyn Fn(usize) -> f64| {
            Cluster::from_observations(2, (0..96).map(|i| (row(i) * of(i), 0.0))).products
        };
        let inverse = products(&|_| 1.0).try_inverse().expect("regular");
        let sandwich = &inverse * products(&weight) * &inverse;
        let mean_variance = (0..96).map(|i| weight(i).powi(2)).sum::<f64>() / 96.0;
        let expected = sandwich[(0, 0)] / (mean_variance * inverse[(0, 0)]);
        assert!((ratio / expected - 1.0).abs() < 0.15, "{ratio} for {expected}");
    }
}

//! Quadratic approximation of the sum of squares near its minimum, with parameters that cannot be negative.

use super::least_squares::Fit;
use nalgebra::{DMatrix, DVector};

/// The quadratic form of a fit in one parameter, minimised over all others.
pub(crate) struct QuadraticProfile<'a> {
    fit: &'a Fit,
    parameter: usize,
    /// Free parameters that cannot be negative.
    limited: Vec<usize>,
}

/// Minimum of the quadratic form for one value of the parameter.
pub(crate) struct Conditional {
    /// Increase of the sum of squares over that of the fit.
    pub(crate) rise: f64,
    /// All parameters of the fit.
    pub(crate) parameters: Vec<f64>,
    /// Parameters at their limit.
    pub(crate) on_limit: Vec<usize>,
}

impl<'a> QuadraticProfile<'a> {
    pub(crate) fn new(fit: &'a Fit, parameter: usize, non_negative: &[usize]) -> Self {
        let limited = non_negative.iter().copied().filter(|i| *i != parameter && fit.free.contains(i));
        Self { fit, parameter, limited: limited.collect() }
    }

    /// Minimum of the form with the parameter at `value`. `None` if the covariance is singular.
    ///
    /// If a set `B` of parameters is fixed, the form increases by `d' C_BB^-1 d`, with `d` their displacements, and the
    /// others change by `C_iB C_BB^-1 d`. Every subset of limited parameters at their limits is tried.
    pub(crate) fn at(&self, value: f64) -> Option<Conditional> {
        (0..1u32 << self.limited.len())
            .filter_map(|set| {
                let chosen = self.limited.iter().enumerate().filter(|(i, _)| set & (1 << i) != 0);
                let on_limit: Vec<usize> = chosen.map(|(_, &p)| p).collect();
                let mut fixed = vec![(self.parameter, value)];
                fixed.extend(on_limit.iter().map(|&i| (i, 0.0)));
                let (rise, parameters) = conditional_minimum(self.fit, &fixed)?;
                let allowed = self.limited.iter().all(|&i| on_limit.contains(&i) || parameters[i] >= 0.0);
                allowed.then_some(Conditional { rise, parameters, on_limit })
            })
            .min_by(|a, b| a.rise.total_cmp(&b.rise))
    }
}

/// The parameters of a fit with some of them fixed at other values, and the increase of the sum of squares, both in the
/// quadratic approximation.
pub(crate) fn conditional_minimum(fit: &Fit, fixed: &[(usize, f64)]) -> Option<(f64, Vec<f64>)> {
    let covariance = |i: usize, j: usize| fit.unit_covariance[(i, j)];
    let n = fixed.len();
    // Scaled to unit diagonal first, because rates and lengths differ by many orders of magnitude.
    let scale = |i: usize| covariance(fixed[i].0, fixed[i].0).sqrt();
    let block = DMatrix::from_fn(n, n, |i, j| covariance(fixed[i].0, fixed[j].0) / (scale(i) * scale(j)));
    let moved = DVector::from_fn(n, |i, _| (fixed[i].1 - fit.parameters[fixed[i].0]) / scale(i));
    let solved = block.cholesky()?.solve(&moved);
    let mut parameters = fit.parameters.clone();
    for &i in &fit.free {
        parameters[i] += (0..n).map(|k| covariance(i, fixed[k].0) / scale(k) * solved[k]).sum::<f64>();
    }
    for &(i, value) in fixed {
        parameters[i] = value;
    }
    let rise = moved.dot(&solved);
    (rise.is_finite() && parameters.iter().all(|p| p.is_finite())).then_some((rise, parameters))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::covariance::Covariance;

    fn fit() -> Fit {
        Fit {
            parameters: vec![1.0, -0.5],
            unit_covariance: Covariance::new(
                DMatrix::from_row_slice(2, 2, &[1.0, -0.8, -0.8, 1.0]),
                &[0, 1],
                2,
            ),
            rss: 10.0,
            free: vec![0, 1],
            converged: true,
        }
    }

    #[test]
    fn the_others_follow_by_their_correlation() {
        let (rise, p) = conditional_minimum(&fit(), &[(0, 2.0)]).unwrap();
        assert!((rise - 1.0).abs() < 1e-12);
        assert_eq!(p[0], 2.0);
        assert!((p[1] + 1.3).abs() < 1e-12);
    }

    #[test]
    fn a_limited_parameter_stays_on_its_limit() {
        let fit = fit();
        let free = QuadraticProfile::new(&fit, 0, &[1]);
        // Far below, the other parameter becomes positive without being held.
        let inside = free.at(-2.0).unwrap();
        assert!(inside.on_limit.is_empty(), "{:?}", inside.on_limit);
        assert!(inside.parameters[1] > 0.0, "{:?}", inside.parameters);
        let outside = free.at(2.0).unwrap();
        assert_eq!(outside.on_limit, [1]);
        assert_eq!(outside.parameters[1], 0.0);
        // d' C^-1 d with d = (1, 0.5): (1 + 0.8 + 0.25)/0.36.
        assert!((outside.rise - 2.05 / 0.36).abs() < 1e-12);
    }
}

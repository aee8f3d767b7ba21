//! Normal equations: the sums provided by a model, and their solution.
//!
//! No N × p Jacobian is stored: a model passes over its samples once per step and returns `JᵀJ`, `Jᵀr` and `rᵀr` for a
//! few parameters.

use super::covariance::Covariance;
use nalgebra::{DMatrix, DVector};

/// Sums over the samples for one parameter vector; `r = data - model`,
/// `J = d model / d parameter`.
#[derive(Debug, Clone)]
pub(crate) struct Normal {
    pub(crate) jtj: DMatrix<f64>,
    pub(crate) jtr: DVector<f64>,
    pub(crate) rss: f64,
}

impl Normal {
    pub(crate) fn zeros(parameters: usize) -> Self {
        Self { jtj: DMatrix::zeros(parameters, parameters), jtr: DVector::zeros(parameters), rss: 0.0 }
    }

    pub(crate) fn clear(&mut self) {
        self.jtj.as_mut_slice().fill(0.0);
        self.jtr.as_mut_slice().fill(0.0);
        self.rss = 0.0;
    }

    /// Adds one weighted row; only the lower triangle is stored.
    pub(crate) fn add_row(&mut self, row: &[f64], residual: f64, weight: f64) {
        let rows = self.jtj.nrows();
        // Column by column, because columns are contiguous.
        let columns = self.jtj.as_mut_slice().chunks_exact_mut(rows.max(1));
        for (j, ((column, jtr), &b)) in columns.zip(self.jtr.as_mut_slice()).zip(row).enumerate() {
            let wb = weight * b;
            *jtr += wb * residual;
            for (sum, a) in column[j..].iter_mut().zip(&row[j..]) {
                *sum += wb * a;
            }
        }
        self.rss += weight * residual * residual;
    }
}

/// A model together with its data.
pub(crate) trait LeastSquares {
    /// Number of parameters, fixed ones included.
    fn parameters(&self) -> usize;

    /// Number of observations.
    fn observations(&self) -> f64;

    /// The part of the sum of squares due to the rounding of times and motion, included whether or not it is
    /// significant.
    fn rounding(&self) -> f64 {
        0.0
    }

    /// Accumulates the normal equations at `p` into `out` (cleared here; the lower triangle of `jtj` suffices). `false`
    /// if the model does not exist.
    fn normal(&self, p: &[f64], out: &mut Normal) -> bool;

    /// The same, but may stop and return `false` once the sum of squares exceeds `limit`, because a step to this point
    /// is rejected anyway.
    fn normal_within(&self, p: &[f64], out: &mut Normal, _limit: f64) -> bool {
        self.normal(p, out)
    }

    /// The same, but may omit the sums of parameters that are not `free`.
    fn normal_of(&self, p: &[f64], _free: &[usize], out: &mut Normal, limit: f64) -> bool {
        self.normal_within(p, out, limit)
    }

    /// Whether the work allowed for the search is used up; the model is then reported as non-existent everywhere.
    fn is_spent(&self) -> bool {
        false
    }

    /// Limits of a parameter outside which the model does not exist; it exists at both of them.
    fn range(&self, _parameter: usize) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// The parameter that has no influence if another one is zero, such as the exponent of a loss that is absent, and
    /// its initial value for the search.
    fn without_influence(&self, _zero: usize) -> Option<(usize, f64)> {
        None
    }
}

/// Solves `(JᵀJ + damping diag) step = Jᵀr` in scaled variables; also returns the predicted decrease of rss.
pub(crate) fn solve(sums: &Normal, free: &[usize], damping: f64) -> Option<(Vec<f64>, f64)> {
    if free.len() <= FEW {
        return solve_few(sums, free, damping);
    }
    let (a, scale) = scaled(sums, free)?;
    let m = free.len();
    let g = DVector::from_fn(m, |k, _| sums.jtr[free[k]] * scale[k]);
    let mut damped = a.clone();
    for k in 0..m {
        damped[(k, k)] += damping;
    }
    let step = damped.cholesky()?.solve(&g);
    let predicted = 2.0 * step.dot(&g) - step.dot(&(&a * &step));
    Some(((0..m).map(|k| step[k] * scale[k]).collect(), predicted))
}

/// Largest number of parameters whose equations are solved on the stack: for few samples an allocation takes as long as
/// the solution.
const FEW: usize = 10;

fn solve_few(sums: &Normal, free: &[usize], damping: f64) -> Option<(Vec<f64>, f64)> {
    let m = free.len();
    let (mut a, mut scale, mut g) = ([[0.0; FEW]; FEW], [0.0; FEW], [0.0; FEW]);
    for (k, &i) in free.iter().enumerate() {
        let d = sums.jtj[(i, i)];
        if !(d > 0.0 && d.is_finite()) {
            return None;
        }
        scale[k] = 1.0 / d.sqrt();
        g[k] = sums.jtr[i] * scale[k];
        for (l, &j) in free[..=k].iter().enumerate() {
            a[k][l] = sums.jtj[(i.max(j), i.min(j))] * scale[k] * scale[l];
        }
    }
    // Cholesky factor, then both triangular systems.
    let mut factor = a;
    for k in 0..m {
        for l in 0..=k {
            let inner: f64 = (0..l).map(|n| factor[k][n] * factor[l][n]).sum();
            let left = factor[k][l] - inner + if k == l { damping } else { 0.0 };
            if k == l && !(left > 0.0) {
                return None;
            }
            factor[k][l] = if k == l { left.sqrt() } else { left / factor[l][l] };
        }
    }
    let mut step = g;
    for k in 0..m {
        let inner: f64 = (0..k).map(|n| factor[k][n] * step[n]).sum();
        step[k] = (step[k] - inner) / factor[k][k];
    }
    for k in (0..m).rev() {
        let inner: f64 = (k + 1..m).map(|n| factor[n][k] * step[n]).sum();
        step[k] = (step[k] - inner) / factor[k][k];
    }
    let mut predicted = 0.0;
    for k in 0..m {
        let row: f64 = (0..m).map(|l| a[k.max(l)][k.min(l)] * step[l]).sum();
        predicted += step[k] * (2.0 * g[k] - row);
    }
    Some((step[..m].iter().zip(scale).map(|(s, scale)| s * scale).collect(), predicted))
}

/// The full step `(JᵀJ)⁻¹ Jᵀr` of the free parameters.
pub(crate) fn newton_step(sums: &Normal, free: &[usize]) -> Option<Vec<f64>> {
    solve(sums, free, 0.0).map(|(step, _)| step)
}

/// Predicted decrease of `rᵀr` when these parameters are freed, from one set of sums.
pub(crate) fn predicted_gain(sums: &Normal, free: &[usize]) -> Option<f64> {
    solve(sums, free, 0.0).map(|(_, gain)| gain)
}

/// `ln det(JᵀJ)` of the free parameters.
pub(crate) fn log_determinant(sums: &Normal, free: &[usize]) -> Option<f64> {
    let (a, scale) = scaled(sums, free)?;
    let factor = a.cholesky()?;
    let diagonal: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
    Some(2.0 * (diagonal - scale.iter().map(|s| s.ln()).sum::<f64>()))
}

/// `(JᵀJ)⁻¹` of the free ones among `p` parameters.
pub(crate) fn invert(sums: &Normal, free: &[usize], p: usize) -> Option<Covariance> {
    let (a, scale) = scaled(sums, free)?;
    let mut inverse = a.cholesky()?.inverse();
    for (i, by_row) in scale.iter().enumerate() {
        for (j, by_column) in scale.iter().enumerate() {
            inverse[(i, j)] = inverse[(i, j)] * by_row * by_column;
        }
    }
    Some(Covariance::new(inverse, free, p))
}

/// The block of the free parameters of `JᵀJ`, scaled to unit diagonal, and the scale factors.
fn scaled(sums: &Normal, free: &[usize]) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let mut scale = Vec::with_capacity(free.len());
    for &i in free {
        let d = sums.jtj[(i, i)];
        if !(d > 0.0 && d.is_finite()) {
            return None;
        }
        scale.push(1.0 / d.sqrt());
    }
    let a = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        let (r, c) = (free[i].max(free[j]), free[i].min(free[j]));
        sums.jtj[(r, c)] * scale[i] * scale[j]
    });
    Some((a, scale))
}

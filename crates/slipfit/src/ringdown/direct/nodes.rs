//! The Gauss rule of evenly spaced samples, and what takes samples to its nodes.

use nalgebra::{SMatrix, SymmetricEigen};

/// Nodes of the rule: polynomials below this degree are known by their values there.
pub(super) const NODES: usize = 16;
/// Nodes lie symmetric about the middle.
pub(super) const PAIRS: usize = NODES / 2;

/// Nodes and weights of the rule with `sum_i f(s_i) = sum_m w_m f(s_m)` for polynomials of degree below
/// 32, over samples at `s_i = (2 i - n + 1)/(n - 1)`; and the table with which the projection of samples
/// on polynomials of degree below 16 has the values
///
/// ```text
/// z_m = sum_i y_i sum_k q_k(s_m) q_k(s_i)
/// ```
///
/// with the polynomials `q_k` that are orthonormal over the samples (Gram's, or discrete Chebyshev's).
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// Times of the nodes, from 0 at the first sample to 1 at the last.
    pub(super) place: [f64; NODES],
    pub(super) weight: [f64; NODES],
    /// The table: for each sample of the first half the first half of nodes, `k` even, then `k` odd.
    pub(super) table: Vec<[f64; NODES]>,
    pub(super) samples: f64,
}

impl Nodes {
    /// For this many samples, at least twice the nodes.
    pub(super) fn new(samples: usize) -> Self {
        let n = samples as f64;
        // b_k of s q_(k-1) = b_k q_k + b_(k-1) q_(k-2): k²(n² - k²)/(4(4k² - 1)) of whole steps.
        let scale = 2.0 / (n - 1.0);
        let mut recurrence = [0.0; NODES];
        for (k, b) in recurrence.iter_mut().enumerate().skip(1) {
            let k = (k * k) as f64;
            *b = scale * (k * (n * n - k) / (4.0 * (4.0 * k - 1.0))).sqrt();
        }
        // Golub and Welsch: nodes are the eigenvalues of the recurrence.
        let mut jacobi = SMatrix::<f64, NODES, NODES>::zeros();
        for k in 1..NODES {
            jacobi[(k, k - 1)] = recurrence[k];
            jacobi[(k - 1, k)] = recurrence[k];
        }
        let mut found: [f64; NODES] = SymmetricEigen::new(jacobi).eigenvalues.into();
        found.sort_by(f64::total_cmp);
        let (mut node, mut weight) = ([0.0; NODES], [0.0; NODES]);
        for m in 0..PAIRS {
            // Symmetric to the last bit.
            let s = 0.5 * (found[m] - found[NODES - 1 - m]);
            (node[m], node[NODES - 1 - m]) = (s, -s);
            // A weight is one over the sum of the squares of the polynomials.
            let w = 1.0 / orthonormal(s, n, &recurrence).iter().map(|q| q * q).sum::<f64>();
            (weight[m], weight[NODES - 1 - m]) = (w, w);
        }
        let at_nodes: [[f64; NODES]; PAIRS] = std::array::from_fn(|m| orthonormal(node[m], n, &recurrence));
        let row = |i: usize| {
            let here = orthonormal((2.0 * i as f64 - n + 1.0) / (n - 1.0), n, &recurrence);
            let of = |column: usize| -> f64 {
                let at = &at_nodes[column % PAIRS];
                (column / PAIRS..NODES).step_by(2).map(|k| at[k] * here[k]).sum()
            };
            std::array::from_fn(of)
        };
        let table = (0..samples.div_ceil(2)).map(row).collect();
        let place = node.map(|s| 0.5 * (1.0 + s));
        Self { place, weight, table, samples: n }
    }
}

/// The polynomials at a place, by their recurrence.
fn orthonormal(s: f64, samples: f64, recurrence: &[f64; NODES]) -> [f64; NODES] {
    let mut q = [0.0; NODES];
    q[0] = 1.0 / samples.sqrt();
    q[1] = s * q[0] / recurrence[1];
    for k in 2..NODES {
        q[k] = (s * q[k - 1] - recurrence[k - 1] * q[k - 2]) / recurrence[k];
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_below_32_are_summed_as_over_the_samples() {
        for n in [32, 33, 100, 512, 4097] {
            let nodes = Nodes::new(n);
            for power in 0..32 {
                let over_samples: f64 = (0..n).map(|i| (i as f64 / (n - 1) as f64).powi(power)).sum();
                let over_nodes: f64 =
                    nodes.place.iter().zip(&nodes.weight).map(|(u, w)| w * u.powi(power)).sum();
                assert!((over_nodes / over_samples - 1.0).abs() < 1e-12, "{n}, {power}");
            }
        }
    }

    #[test]
    fn a_polynomial_is_taken_to_its_values() {
        for n in [32, 51, 512] {
            let nodes = Nodes::new(n);
            let f = |u: f64| (1.0 - 2.3 * u + 0.4 * u.powi(7) - u.powi(15)) * 3.0;
            let y: Vec<f64> = (0..n).map(|i| f(i as f64 / (n - 1) as f64)).collect();
            for m in 0..PAIRS {
                let mut sums = [0.0; 2];
                for i in 0..n {
                    // A sample of the second half is the mirror of one of the first.
                    let (row, sign) = if i < n.div_ceil(2) { (i, 1.0) } else { (n - 1 - i, -1.0) };
                    let (even, odd) = (nodes.table[row][m], sign * nodes.table[row][PAIRS + m]);
                    sums[0] += y[i] * (even + odd);
                    sums[1] += y[i] * (even - odd);
                }
                assert!((sums[0] - f(nodes.place[m])).abs() < 1e-12, "{n}, {m}");
                assert!((sums[1] - f(nodes.place[NODES - 1 - m])).abs() < 1e-12, "{n}, {m}");
            }
        }
    }
}

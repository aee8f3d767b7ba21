//! Sums of products of rows of numbers, many at a time.

use pulp::Simd;
use std::ops::{Deref, DerefMut};

/// Numbers per row.
pub(crate) const WIDTH: usize = 64;
const LANES: usize = 16;

/// A row aligned to cache lines, so that no register load crosses two of them.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct Row([f64; WIDTH]);

impl Deref for Row {
    type Target = [f64; WIDTH];

    #[inline]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Row {
    #[inline]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// The sum for a pair of rows, lane by lane.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Sum([f64; LANES]);

/// `Σ row_a row_c` for every pair of rows, over pieces of the data.
#[derive(Debug, Clone)]
pub(crate) struct Products {
    pub(crate) rows: Vec<Row>,
    sums: Vec<Sum>,
}

impl Products {
    /// Sums for this many rows.
    pub(crate) fn new(count: usize) -> Self {
        let rows = vec![Row([0.0; WIDTH]); count];
        Self { rows, sums: vec![Sum([0.0; LANES]); count * (count + 1) / 2] }
    }

    /// Adds the products of whole rows.
    #[inline(always)]
    pub(crate) fn add<S: Simd>(&mut self, simd: S) {
        self.add_pieces::<S, { WIDTH / LANES }>(simd);
    }

    /// Adds the products of the first halves of the rows.
    #[inline(always)]
    pub(crate) fn add_halves<S: Simd>(&mut self, simd: S) {
        self.add_pieces::<S, { WIDTH / LANES / 2 }>(simd);
    }

    #[inline(always)]
    fn add_pieces<S: Simd, const PIECES: usize>(&mut self, simd: S) {
        let registers = LANES / S::F64_LANES;
        for a in 0..self.rows.len() {
            let (one, _) = S::as_simd_f64s(&self.rows[a].0);
            let sums = &mut self.sums[a * (a + 1) / 2..][..=a];
            for l in 0..registers {
                // Part of a row is kept in registers for all its partners.
                let mut part = [simd.splat_f64s(0.0); PIECES];
                for j in 0..PIECES {
                    part[j] = one[j * registers + l];
                }
                for (c, sum) in sums.iter_mut().enumerate() {
                    let (other, _) = S::as_simd_f64s(&self.rows[c].0);
                    let sum = &mut S::as_mut_simd_f64s(&mut sum.0).0[l];
                    let mut added = *sum;
                    for j in 0..PIECES {
                        added = simd.mul_add_e_f64s(part[j], other[j * registers + l], added);
                    }
                    *sum = added;
                }
            }
        }
    }

    /// Returns the sums so far and resets them: row by row of the lower triangle.
    #[inline(always)]
    pub(crate) fn taken<S: Simd>(&mut self, simd: S) -> Vec<f64> {
        let mut totals = Vec::with_capacity(self.sums.len());
        for sum in &mut self.sums {
            let (registers, _) = S::as_mut_simd_f64s(&mut sum.0);
            let mut all = simd.splat_f64s(0.0);
            for register in registers {
                all = simd.add_f64s(all, *register);
                *register = simd.splat_f64s(0.0);
            }
            totals.push(simd.reduce_sum_f64s(all));
        }
        totals
    }

    /// The sum for a pair of rows.
    pub(crate) fn total(&self, a: usize, c: usize) -> f64 {
        let (a, c) = (a.max(c), a.min(c));
        // Pairwise summation: sixteen additions in a row would wait for each other.
        let mut all = self.sums[a * (a + 1) / 2 + c].0;
        let mut half = LANES / 2;
        while half > 0 {
            for l in 0..half {
                all[l] += all[l + half];
            }
            half /= 2;
        }
        all[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Add<'a>(&'a mut Products, bool);

    impl pulp::WithSimd for Add<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            if self.1 { self.0.add_halves(simd) } else { self.0.add(simd) }
        }
    }

    #[test]
    fn every_pair_is_summed_over_all_pieces() {
        let mut p = Products::new(3);
        for piece in 0..2 {
            for a in 0..3 {
                for k in 0..WIDTH {
                    p.rows[a][k] = if k < 20 { (a * 100 + piece * 20 + k) as f64 } else { 0.0 };
                }
            }
            crate::numeric::dispatch(Add(&mut p, piece == 1));
        }
        for (a, c) in [(0, 0), (2, 1), (0, 2)] {
            let expected: f64 = (0..40).map(|k| ((a * 100 + k) * (c * 100 + k)) as f64).sum();
            assert_eq!(p.total(a, c), expected);
        }
    }
}

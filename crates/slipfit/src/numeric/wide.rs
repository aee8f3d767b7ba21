//! The functions of [`trig`](super::trig) on whole vector registers, and a way to run a sum over samples register by
//! register.

use super::trig::{COSINE, PI_A, PI_B, PI_C, SINE};
use pulp::Simd;
use std::f64::consts::FRAC_1_PI;

/// Ones for the lanes of the last, partly filled register that contain a sample.
const ONES: [f64; 16] = [1.0; 16];

/// Two slices register by register: the values of both, and a weight that is zero in lanes without a sample.
///
/// A loop over it, unlike a closure, is compiled with the instructions of `S`.
pub(crate) struct Pairs<'a, S: Simd> {
    simd: S,
    x: &'a [S::f64s],
    y: &'a [S::f64s],
    x_tail: &'a [f64],
    y_tail: &'a [f64],
}

impl<'a, S: Simd> Pairs<'a, S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, x: &'a [f64], y: &'a [f64]) -> Self {
        let n = x.len().min(y.len());
        let ((x, x_tail), (y, y_tail)) = (S::as_simd_f64s(&x[..n]), S::as_simd_f64s(&y[..n]));
        Self { simd, x, y, x_tail, y_tail }
    }
}

impl<S: Simd> Iterator for Pairs<'_, S> {
    type Item = (S::f64s, S::f64s, S::f64s);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let simd = self.simd;
        if let ([x, x_rest @ ..], [y, y_rest @ ..]) = (self.x, self.y) {
            (self.x, self.y) = (x_rest, y_rest);
            return Some((*x, *y, simd.splat_f64s(1.0)));
        }
        if self.x_tail.is_empty() {
            return None;
        }
        let (x, y) = (self.x_tail, self.y_tail);
        (self.x_tail, self.y_tail) = (&[], &[]);
        let weight = simd.partial_load_f64s(&ONES[..x.len()]);
        Some((simd.partial_load_f64s(x), simd.partial_load_f64s(y), weight))
    }
}

/// Polynomial by Horner's rule.
#[inline(always)]
pub(crate) fn horner<S: Simd, const N: usize>(simd: S, x: S::f64s, coefficients: &[f64; N]) -> S::f64s {
    let mut sum = simd.splat_f64s(coefficients[N - 1]);
    for k in (0..N - 1).rev() {
        sum = simd.mul_add_e_f64s(sum, x, simd.splat_f64s(coefficients[k]));
    }
    sum
}

/// Sine and cosine for `|r| <= pi/2`, as [`half_turn`](super::trig::half_turn).
#[inline(always)]
pub(crate) fn half_turn<S: Simd>(simd: S, r: S::f64s) -> (S::f64s, S::f64s) {
    let z = simd.mul_f64s(r, r);
    (simd.mul_f64s(r, horner(simd, z, &SINE)), horner(simd, z, &COSINE))
}

/// Sine and cosine, absolute error below 4e-16 for `|x| < 2e8`.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let n = round(simd, simd.mul_f64s(x, simd.splat_f64s(FRAC_1_PI)));
    let r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(PI_A), x);
    let r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(PI_B), r);
    let r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(PI_C), r);
    let half = round(simd, simd.mul_f64s(n, simd.splat_f64s(0.5)));
    let odd = simd.abs_f64s(simd.negate_mul_add_e_f64s(half, simd.splat_f64s(2.0), n));
    let sign = simd.negate_mul_add_e_f64s(odd, simd.splat_f64s(2.0), simd.splat_f64s(1.0));
    let (sin, cos) = half_turn(simd, r);
    (simd.mul_f64s(sign, sin), simd.mul_f64s(sign, cos))
}

/// Nearest integer for |x| < 2^51, by adding and subtracting a magic number.
#[inline(always)]
fn round<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let magic = simd.splat_f64s(6_755_399_441_055_744.0);
    simd.sub_f64s(simd.add_f64s(x, magic), magic)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Both<'a>(&'a [f64]);

    impl pulp::WithSimd for Both<'_> {
        type Output = f64;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            let mut worst = 0.0f64;
            for (x, _, w) in Pairs::new(simd, self.0, self.0) {
                let (sin, cos) = sin_cos(simd, x);
                for (value, exact) in [(sin, f64::sin as fn(f64) -> f64), (cos, f64::cos)] {
                    let mut left = [0.0; 16];
                    let mut at = [0.0; 16];
                    let mut weight = [0.0; 16];
                    simd.partial_store_f64s(&mut left[..S::F64_LANES], value);
                    simd.partial_store_f64s(&mut at[..S::F64_LANES], x);
                    simd.partial_store_f64s(&mut weight[..S::F64_LANES], w);
                    for k in 0..S::F64_LANES {
                        let error = weight[k] * (left[k] - exact(at[k])).abs() / (1.0 + at[k].abs() * 1e-9);
                        worst = worst.max(error);
                    }
                }
            }
            worst
        }
    }

    #[test]
    fn agree_with_the_standard_library_whatever_the_length() {
        let x: Vec<f64> = (0..20_011).map(|i| (f64::from(i) - 10_000.0) * 12.345_67).collect();
        for length in [x.len(), 1000, 37, 3, 1, 0] {
            let worst = crate::numeric::dispatch(Both(&x[..length]));
            assert!(worst < 4e-16, "{worst:e}");
        }
    }
}

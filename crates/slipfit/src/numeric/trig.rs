//! Sine, cosine and exponential without branches or calls, so that loops over them can be vectorised.

use std::f64::consts::LOG2_E;

// pi in three parts, the first two with trailing zeros: n times each is exact for |n| < 2^26.
pub(crate) const PI_A: f64 = 3.141592651605606;
pub(crate) const PI_B: f64 = 1.9841871479187034e-09;
pub(crate) const PI_C: f64 = 1.1442377452219664e-17;

/// `a b + c`; with `FUSED` as one instruction, which the processor must support.
#[inline(always)]
pub(crate) fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Whether [`fused`] is one instruction if `S` is the widest instruction set.
pub(crate) const fn has_fused<S: pulp::Simd>() -> bool {
    !S::IS_SCALAR && !cfg!(target_family = "wasm")
}

/// Sine and cosine for `|r| <= pi/2`, by their Taylor series: the first omitted term is below 1e-17.
#[inline(always)]
pub(crate) fn half_turn(r: f64) -> (f64, f64) {
    half_turn_as::<false>(r)
}

#[inline(always)]
fn half_turn_as<const FUSED: bool>(r: f64) -> (f64, f64) {
    let z = r * r;
    (r * horner::<FUSED, _>(z, &SINE), horner::<FUSED, _>(z, &COSINE))
}

/// Limit for the `SHORT` series of [`quarter_turns`], [`small_sinh`] and [`small_cosh`], in quarter turns: up to it
/// six terms have a truncation error below 1e-17.
pub(crate) const SHORT_OF_A_QUARTER: f64 = 0.125;
const SHORT_TERMS: usize = 6;

/// Sine and cosine of `pi x/2` up to a common sign, for `|x| < 2^50`, which is sufficient for their squares and
/// product. With `SHORT` for `|x| <= 1/8`.
#[inline(always)]
pub(crate) fn quarter_turns<const FUSED: bool, const SHORT: bool>(x: f64) -> (f64, f64) {
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    if SHORT {
        let r = x * std::f64::consts::FRAC_PI_2;
        let z = r * r;
        return (
            r * horner::<FUSED, SHORT_TERMS>(z, const { &alternating(inverse_factorials(1, 2)) }),
            horner::<FUSED, SHORT_TERMS>(z, const { &alternating(inverse_factorials(0, 2)) }),
        );
    }
    let whole = (0.5 * x + MAGIC) - MAGIC;
    half_turn_as::<FUSED>((x - 2.0 * whole) * std::f64::consts::FRAC_PI_2)
}

/// Sine and cosine, absolute error below 4e-16 for `|x| < 2e8`.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let n = (x * std::f64::consts::FRAC_1_PI + MAGIC) - MAGIC;
    let (sin, cos) = half_turn(((x - n * PI_A) - n * PI_B) - n * PI_C);
    let odd = (n - 2.0 * ((0.5 * n + MAGIC) - MAGIC)).abs();
    let sign = 1.0 - 2.0 * odd;
    (sign * sin, sign * cos)
}

/// Hyperbolic sine for `|y| <= pi/2`, by its Taylor series: the first omitted term is below 1e-17; with `SHORT` for
/// `|y| <= pi/16`.
#[inline(always)]
pub(crate) fn small_sinh<const FUSED: bool, const SHORT: bool>(y: f64) -> f64 {
    let z = y * y;
    if SHORT {
        y * horner::<FUSED, SHORT_TERMS>(z, const { &inverse_factorials(1, 2) })
    } else {
        y * horner::<FUSED, 11>(z, const { &inverse_factorials(1, 2) })
    }
}

/// `sinh(y)/y` for `|y| <= pi/2`, by the same series.
#[inline(always)]
pub(crate) fn sinh_over(y: f64) -> f64 {
    horner::<false, 11>(y * y, const { &inverse_factorials(1, 2) })
}

/// `sin(r)/r` and `cos(r)` for `|r| <= pi/2`, by their Taylor series.
#[inline(always)]
pub(crate) fn sin_over_and_cos(r: f64) -> (f64, f64) {
    let z = r * r;
    (horner::<false, _>(z, &SINE), horner::<false, _>(z, &COSINE))
}

/// Hyperbolic cosine, likewise.
#[inline(always)]
pub(crate) fn small_cosh<const FUSED: bool, const SHORT: bool>(y: f64) -> f64 {
    let z = y * y;
    if SHORT {
        horner::<FUSED, SHORT_TERMS>(z, const { &inverse_factorials(0, 2) })
    } else {
        horner::<FUSED, 11>(z, const { &inverse_factorials(0, 2) })
    }
}

/// Hyperbolic sine and cosine for `|y| < 300`, relative error below 2e-15.
#[inline(always)]
pub(crate) fn sinh_cosh<const FUSED: bool>(y: f64) -> (f64, f64) {
    let e = 0.5 * exp(y);
    let back = 0.25 / e;
    let near = y.abs() <= std::f64::consts::FRAC_PI_2;
    // The series is accurate where it is used.
    let small = small_sinh::<FUSED, false>(if near { y } else { 0.0 });
    (if near { small } else { e - back }, e + back)
}

/// Coefficients of `sin(r)/r` and `cos(r)` in powers of `r²`, and of `exp(r)` in powers of `r`.
pub(super) const SINE: [f64; 11] = alternating(inverse_factorials(1, 2));
pub(super) const COSINE: [f64; 11] = alternating(inverse_factorials(0, 2));
const EXPONENTIAL: [f64; 13] = inverse_factorials(0, 1);

/// `1/first!`, `1/(first + step)!` …: coefficients of a Taylor series.
pub(crate) const fn inverse_factorials<const N: usize>(first: usize, step: usize) -> [f64; N] {
    let mut out = [0.0; N];
    let mut factorial = 1.0;
    let mut of = 1;
    let mut k = 0;
    while k < N {
        let target = first + k * step;
        while of < target {
            of += 1;
            factorial *= of as f64;
        }
        out[k] = 1.0 / factorial;
        k += 1;
    }
    out
}

const fn alternating<const N: usize>(mut list: [f64; N]) -> [f64; N] {
    let mut k = 1;
    while k < N {
        list[k] = -list[k];
        k += 2;
    }
    list
}

/// Polynomial by Horner's rule.
#[inline(always)]
fn horner<const FUSED: bool, const N: usize>(x: f64, coefficients: &[f64; N]) -> f64 {
    let mut sum = coefficients[N - 1];
    for k in (0..N - 1).rev() {
        sum = fused::<FUSED>(sum, x, coefficients[k]);
    }
    sum
}

/// Exponential for `-700 < x < 700`, relative error below 1e-15.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    const LN_2_HIGH: f64 = 0.6931471803691238;
    const LN_2_LOW: f64 = 1.9082149292705877e-10;
    let x = x.clamp(-700.0, 700.0);
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let shifted = x * LOG2_E + MAGIC;
    let n = shifted - MAGIC;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let p = horner::<false, _>(r, &EXPONENTIAL);
    // The low bits of the shifted sum hold n: move them into the exponent.
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    p * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_the_standard_library() {
        for i in 0..200_000 {
            let x = (i as f64 - 100_000.0) * 1.234_567;
            let r = x / 123_456.7 * std::f64::consts::FRAC_PI_2;
            let (s, c) = half_turn(r);
            assert!((s - r.sin()).abs() < 4e-16, "sin {r}");
            assert!((c - r.cos()).abs() < 4e-16, "cos {r}");
            let y = x * 5e-3;
            assert!((exp(y) / y.exp() - 1.0).abs() < 1e-15, "exp {y}");
            let (s, c) = sin_cos(x);
            assert!((s - x.sin()).abs() < 4e-16 + 1e-25 * x.abs(), "sin {x}");
            assert!((c - x.cos()).abs() < 4e-16 + 1e-25 * x.abs(), "cos {x}");
            assert!((small_sinh::<false, false>(r) - r.sinh()).abs() <= 1e-15 * r.sinh().abs(), "sinh {r}");
            assert!((small_cosh::<false, false>(r) / r.cosh() - 1.0).abs() < 1e-15, "cosh {r}");
            let y = r * SHORT_OF_A_QUARTER;
            assert!((small_sinh::<false, true>(y) - y.sinh()).abs() <= 4e-16 * y.sinh().abs(), "sinh {y}");
            assert!((small_cosh::<false, true>(y) / y.cosh() - 1.0).abs() < 4e-16, "cosh {y}");
            let (s, c) = quarter_turns::<false, true>(y * std::f64::consts::FRAC_2_PI);
            assert!((s - y.sin()).abs() <= 8e-16 * y.abs(), "sin {y}");
            assert!((c - y.cos()).abs() < 4e-16, "sin {y}");
            let y = r * 100.0;
            let (sinh, cosh) = sinh_cosh::<false>(y);
            assert!((sinh - y.sinh()).abs() <= 2e-15 * y.sinh().abs(), "sinh {y}");
            assert!((cosh / y.cosh() - 1.0).abs() < 2e-15, "cosh {y}");
            // 20 periods of the product.
            let quarter = r * 25.0;
            let (s, c) = quarter_turns::<false, false>(quarter);
            let whole = quarter * std::f64::consts::PI;
            assert!((2.0 * s * c - whole.sin()).abs() < 3e-14);
            assert!((1.0 - 2.0 * s * s - whole.cos()).abs() < 3e-14);
        }
    }
}

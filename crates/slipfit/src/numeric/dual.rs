//! Dual numbers, real and complex, which carry their derivatives.

use std::ops::{Add, Mul, Neg, Sub};

/// A value and its derivatives with respect to `N` variables.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual<const N: usize> {
    pub(crate) value: f64,
    pub(crate) d: [f64; N],
}

impl<const N: usize> Dual<N> {
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, d: [0.0; N] }
    }

    pub(crate) fn variable(value: f64, index: usize) -> Self {
        let mut d = [0.0; N];
        d[index] = 1.0;
        Self { value, d }
    }

    /// A function of this number, given its value and slope.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, d: self.d.map(|d| d * slope) }
    }

    pub(crate) fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, 0.5 / r)
    }

    pub(crate) fn recip(self) -> Self {
        let r = 1.0 / self.value;
        self.chain(r, -r * r)
    }

    pub(crate) fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }

    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }

    pub(crate) fn scale(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, d: std::array::from_fn(|i| self.d[i] + o.d[i]) }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.scale(-1.0)
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule is a sum")]
impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self {
            value: self.value * o.value,
            d: std::array::from_fn(|i| self.d[i] * o.value + self.value * o.d[i]),
        }
    }
}

/// Complex number of such parts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<const N: usize> {
    pub(crate) re: Dual<N>,
    pub(crate) im: Dual<N>,
}

impl<const N: usize> Pair<N> {
    pub(crate) fn new(re: Dual<N>, im: Dual<N>) -> Self {
        Self { re, im }
    }

    pub(crate) fn conj(self) -> Self {
        Self { re: self.re, im: -self.im }
    }

    pub(crate) fn recip(self) -> Self {
        let n = (self.re * self.re + self.im * self.im).recip();
        Self { re: self.re * n, im: -self.im * n }
    }

    pub(crate) fn times(self, factor: Dual<N>) -> Self {
        Self { re: self.re * factor, im: self.im * factor }
    }

    pub(crate) fn scale(self, factor: f64) -> Self {
        Self { re: self.re.scale(factor), im: self.im.scale(factor) }
    }

    /// `i` times this number.
    pub(crate) fn turned(self) -> Self {
        Self { re: -self.im, im: self.re }
    }

    pub(crate) fn exp(self) -> Self {
        let (s, c) = self.im.sin_cos();
        Self { re: c, im: s }.times(self.re.exp())
    }

    /// `(e^z - 1)/z`, accurate also at zero.
    pub(crate) fn exp_quotient(self) -> Self {
        let one = Self { re: Dual::constant(1.0), im: Dual::constant(0.0) };
        if self.re.value.hypot(self.im.value) > 0.5 {
            return (self.exp() - one) * self.recip();
        }
        // Σ z^n/(n+1)!; 0.5^15/16! is below the rounding.
        let mut sum = one.scale(1.0 / 15.0);
        for n in (1..15).rev() {
            sum = sum * self + one;
            sum = sum.scale(1.0 / f64::from(n));
        }
        sum
    }
}

impl<const N: usize> Add for Pair<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { re: self.re + o.re, im: self.im + o.im }
    }
}

impl<const N: usize> Sub for Pair<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self { re: self.re - o.re, im: self.im - o.im }
    }
}

impl<const N: usize> Mul for Pair<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quotient_is_the_same_on_both_sides_of_its_switch() {
        let at = |r: f64| {
            let z = Pair::<1>::new(Dual::variable(-0.6 * r, 0), Dual::constant(0.8 * r)).exp_quotient();
            [z.re.value, z.im.value, z.re.d[0], z.im.d[0]]
        };
        for (a, b) in at(0.5 - 1e-12).iter().zip(at(0.5 + 1e-12)) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
        assert_eq!(at(0.0)[..3], [1.0, 0.0, 0.5]);
    }
}

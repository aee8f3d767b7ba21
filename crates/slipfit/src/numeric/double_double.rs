//! Double-double arithmetic: 106 bits, for phases that would drift with 53.
//!
//! After ten thousand half cycles a phase of 3e4 rad in one double is uncertain by 4e-12; in double-double precision
//! the uncertainty is negligible.

/// An unevaluated sum `hi + lo` with `|lo|` at most half an ulp of `hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dd {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

/// pi to 107 bits.
pub(crate) const PI: Dd = Dd { hi: std::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 };

/// `a + b` and its rounding error (Knuth).
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> Dd {
    let s = a + b;
    let t = s - a;
    Dd { hi: s, lo: (a - (s - t)) + (b - t) }
}

/// `a * b` and its rounding error (Dekker's splitting; no fused multiply-add needed).
///
/// Beyond 1e150 the splitting itself would overflow; there the error term is
/// dropped.
#[inline(always)]
pub(crate) fn two_product(a: f64, b: f64) -> Dd {
    let p = a * b;
    let (ah, al) = split(a);
    let (bh, bl) = split(b);
    let e = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
    Dd { hi: p, lo: if e.is_finite() { e } else { 0.0 } }
}

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let h = c - (c - a);
    (h, a - h)
}

impl Dd {
    pub(crate) const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    #[inline(always)]
    pub(crate) fn from_f64(a: f64) -> Self {
        Self { hi: a, lo: 0.0 }
    }

    #[inline(always)]
    fn renorm(hi: f64, lo: f64) -> Self {
        let s = hi + lo;
        Self { hi: s, lo: lo - (s - hi) }
    }

    #[inline(always)]
    pub(crate) fn value(self) -> f64 {
        self.hi + self.lo
    }

    #[inline(always)]
    pub(crate) fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        Self::renorm(s.hi, s.lo + (self.lo + b.lo))
    }

    #[inline(always)]
    pub(crate) fn sub(self, b: Self) -> Self {
        self.add(Self { hi: -b.hi, lo: -b.lo })
    }

    #[inline(always)]
    pub(crate) fn scale(self, b: f64) -> Self {
        let p = two_product(self.hi, b);
        Self::renorm(p.hi, p.lo + self.lo * b)
    }

    #[inline(always)]
    pub(crate) fn mul(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        Self::renorm(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }

    pub(crate) fn div(self, b: Self) -> Self {
        let q = self.hi / b.hi;
        let r = self.sub(b.scale(q));
        Self::renorm(q, r.value() / b.hi)
    }

    pub(crate) fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::ZERO;
        }
        let s = self.hi.sqrt();
        let r = self.sub(two_product(s, s));
        Self::renorm(s, r.value() / (2.0 * s))
    }

    /// Pieces of 26 bits, the last with the remainder: their products with integers below 2^27 are exact.
    pub(crate) fn thirds(self) -> [f64; 3] {
        let cut = |x: f64| f64::from_bits(x.to_bits() & !((1 << 27) - 1));
        let a = cut(self.hi);
        let b = cut((self.hi - a) + self.lo);
        [a, b, ((self.hi - a) - b) + self.lo]
    }

    /// `sqrt((a - b)(a + b))`, free of cancellation.
    pub(crate) fn root_of_difference_of_squares(a: f64, b: f64) -> Self {
        two_sum(a, -b).mul(two_sum(a, b)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_keeps_its_rounding_error() {
        let p = two_product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON);
        assert_eq!(p.lo, f64::EPSILON * f64::EPSILON);
    }

    #[test]
    fn dividing_and_multiplying_back_returns_the_number() {
        let three = Dd::from_f64(3.0);
        let back = PI.div(three).mul(three).sub(PI);
        assert!(back.value().abs() < 1e-31);
    }

    #[test]
    fn a_root_squares_back() {
        let two = Dd::from_f64(2.0);
        let r = two.sqrt();
        assert!(r.mul(r).sub(two).value().abs() < 1e-31);
    }
}

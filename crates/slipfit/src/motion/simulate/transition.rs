//! The propagator of the free motion and its response to a drive: exponentials, their integrals, and their
//! convolutions, without cancellation.

use crate::model::oscillator::Oscillator;
use crate::numeric::double_double::{self as dd, Dd};

pub(super) type C64 = nalgebra::Complex<f64>;

/// Constants of the oscillator that an arc needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Constants {
    pub(super) omega_0: f64,
    pub(super) square: f64,
    pub(super) delta: f64,
    pub(super) omega_d: f64,
    /// Rounding error of `omega_d`, which would be noticeable over a thousand cycles.
    omega_d_rest: f64,
    pub(super) lambda: C64,
    inverse_lambda: C64,
    pub(super) half_period: Dd,
    /// Maximum duration of an arc, after which a new arc is begun.
    pub(super) reach: f64,
}

impl Constants {
    pub(crate) fn new(o: &Oscillator) -> Self {
        let omega_d = Dd::root_of_difference_of_squares(o.omega_0(), o.decay_rate_per_s());
        let lambda = C64::new(-o.decay_rate_per_s(), omega_d.hi);
        Self {
            omega_0: o.omega_0(),
            square: o.omega_0() * o.omega_0(),
            delta: o.decay_rate_per_s(),
            omega_d: omega_d.hi,
            omega_d_rest: omega_d.lo,
            lambda,
            inverse_lambda: lambda.inv(),
            half_period: dd::PI.div(omega_d),
            reach: 4.0 / o.omega_0(),
        }
    }
}

impl Constants {
    /// `e^(lambda u)`.
    #[inline(always)]
    pub(super) fn fade(&self, u: f64) -> C64 {
        let (sin, cos) = (self.omega_d * u).sin_cos();
        let rest = self.omega_d_rest * u;
        C64::new(cos - sin * rest, sin + cos * rest) * (-self.delta * u).exp()
    }

    /// `∫_0^u e^(lambda s) ds`.
    #[inline(always)]
    pub(super) fn ramp(&self, u: f64, e_lambda: C64) -> C64 {
        convolve(-self.lambda, -self.inverse_lambda, u, C64::new(1.0, 0.0), e_lambda)
    }
}

/// Square root of a complex number with an angle in `[0, 2 pi)`: its angle is half of that.
#[inline]
pub(super) fn half_way(z: C64) -> C64 {
    let size = z.norm_sqr().sqrt();
    // Both radicands are non-negative apart from rounding.
    let (re, im) = ((0.5 * (size + z.re)).max(0.0).sqrt(), (0.5 * (size - z.re)).max(0.0).sqrt());
    C64::new(if z.im < 0.0 { -re } else { re }, im)
}

/// `(e^y - 1)/y` for |y| below 0.7, accurate to rounding.
#[inline]
fn phi_1(y: C64) -> C64 {
    let size = y.norm_sqr();
    let terms = if size < 1e-8 {
        5
    } else if size < 1e-2 {
        10
    } else {
        15
    };
    let mut sum = C64::new(1.0, 0.0);
    for k in (2..=terms).rev() {
        sum = C64::new(1.0, 0.0) + y * sum * INVERSE[k];
    }
    sum
}

/// `(e^y - 1 - y)/y²` for |y| below 0.7, accurate to rounding.
#[inline]
pub(super) fn phi_2(y: C64) -> C64 {
    let terms = if y.norm_sqr() < 1e-2 { 11 } else { 16 };
    let mut sum = C64::new(1.0, 0.0);
    for k in (3..=terms).rev() {
        sum = C64::new(1.0, 0.0) + y * sum * INVERSE[k];
    }
    sum * 0.5
}

const INVERSE: [f64; 17] = {
    let mut table = [0.0; 17];
    let mut k = 1;
    while k < 17 {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// `∫_0^u e^(lambda (u - s)) e^(mu s) ds` with `z = mu - lambda`; the two exponentials are given.
#[inline]
pub(super) fn convolve(z: C64, inverse_z: C64, u: f64, e_mu: C64, e_lambda: C64) -> C64 {
    let y = z * u;
    if y.norm_sqr() < 0.49 { e_lambda * phi_1(y) * u } else { (e_mu - e_lambda) * inverse_z }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_way_round_is_a_root_of_the_half_angle() {
        for i in 0..400 {
            let (size, angle) = (0.3 + 0.01 * f64::from(i % 7), std::f64::consts::TAU * f64::from(i) / 400.0);
            let half = half_way(C64::from_polar(size, angle));
            // If one part vanishes, the error is the square root of a rounding error.
            assert!((half - C64::from_polar(size.sqrt(), 0.5 * angle)).norm() < 2e-8, "{angle}");
        }
    }
}

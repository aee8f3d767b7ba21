//! Quadratic drag within a half cycle: its effect on the shape and duration of the swing.
//!
//! Between two turning points drag `c v|v|` gives the equation of the swing `y = Y f` about `±x_F`
//!
//! ```text
//! f'' + 2 l f' + f = epsilon f'²,   f(0) = 1,   f'(0) = 0;   epsilon = c Y/m,   l = delta/omega
//! ```
//!
//! which has no closed form. In powers of `epsilon` and `l` (Poincaré and Lindstedt) the solution differs from the
//! damped cosine with the same turning points by `epsilon (S + epsilon P + l R)`, where `epsilon` is taken at the
//! geometric mean of the swings before and after, and with `phi = theta - pi/2`
//!
//! ```text
//! S = (1 + sin phi)²/3 - (4/(3 pi)) (theta sin phi + cos phi)
//! P = cos² phi sin phi/6 + (8/(9 pi²)) [(phi² - pi²/4) sin phi + 2 phi cos phi]
//! R = -phi (4 - 2 cos² phi)/3 - (4/9) sin phi cos phi + (pi/3 + 4 phi²/(3 pi)) sin phi
//!     + (8/(9 pi)) phi cos phi
//! ```
//!
//! All of them and their slopes vanish at both turning points. `S` has a quadrature component, `-2/(9 pi)`: under
//! drag the phase of the fundamental depends on the amplitude. The swing lasts
//! `(pi/omega_d) [1 + (16/(9 pi)) epsilon l + epsilon²/6]`. All of this holds to second order in the loss per half
//! cycle; the amplitudes, whose loss is odd in time, obey the amplitude law to that order.

use pulp::Simd;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// `4/(3 pi)`: decrement of a half cycle over `pi epsilon`.
const LOSS: f64 = 4.0 / (3.0 * PI);

/// `c/m`, the force over the mass and the squared velocity: `3 pi a2/(4 omega)`.
#[inline(always)]
pub(crate) fn strength(drag_rate: f64, omega: f64) -> f64 {
    3.0 * FRAC_PI_4 * drag_rate / omega
}

/// Reduction of the phase rate by drag, `omega [(16/(9 pi)) epsilon l + epsilon²/6]`, rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Slowing {
    pub(crate) rate: f64,
    pub(crate) by_amplitude: f64,
    pub(crate) by_decay: f64,
    pub(crate) by_drag: f64,
}

impl Slowing {
    /// The reduction at an amplitude, for a decay rate and a drag rate.
    #[inline(always)]
    pub(crate) fn new(amplitude: f64, [decay_rate, drag_rate]: [f64; 2], omega: f64) -> Self {
        let u = amplitude / omega;
        let cross = 4.0 / 3.0 * u;
        let square = 3.0 * PI * PI / 32.0 * amplitude * u;
        Self {
            rate: drag_rate * (cross * decay_rate + square * drag_rate),
            by_amplitude: drag_rate * (4.0 / 3.0 * decay_rate / omega + 3.0 * PI * PI / 16.0 * u * drag_rate),
            by_decay: drag_rate * cross,
            by_drag: cross * decay_rate + 2.0 * square * drag_rate,
        }
    }
}

/// Change of the shape of a half cycle by drag, over `epsilon`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Shape {
    /// At the geometric mean of both swings.
    pub(crate) epsilon: f64,
    pub(crate) l: f64,
}

impl Shape {
    /// Shape from the product of the swings before and after, the decay rate and the drag rate.
    #[inline(always)]
    pub(crate) fn new(product: f64, [decay_rate, drag_rate]: [f64; 2], omega: f64) -> Self {
        Self { epsilon: strength(drag_rate, omega) * product.sqrt(), l: decay_rate / omega }
    }

    /// The `order`-th derivative (at most the second) with respect to the phase since the turning point.
    pub(crate) fn value(&self, order: i32, theta: f64) -> f64 {
        let (s, c) = (theta - FRAC_PI_2).sin_cos();
        self.derivative(pulp::Scalar::new(), order, theta, s, c).0
    }

    /// The `order`-th derivative of [`at`](Self::at) with respect to the phase, at most the second.
    #[inline(always)]
    pub(super) fn derivative<S: Simd>(
        &self,
        simd: S,
        order: i32,
        theta: S::f64s,
        s: S::f64s,
        c: S::f64s,
    ) -> (S::f64s, S::f64s) {
        if order == 0 {
            return self.at(simd, theta, s, c);
        }
        let v = |x: f64| simd.splat_f64s(x);
        let mul = |a, b| simd.mul_f64s(a, b);
        let add = |a, b| simd.add_f64s(a, b);
        let sub = |a, b| simd.sub_f64s(a, b);
        let times = |x: f64, a| simd.mul_f64s(v(x), a);
        let phi = add(theta, v(-FRAC_PI_2));
        let (ss, cc, sc) = (mul(s, s), mul(c, c), mul(s, c));
        // S' = c B with B = 2 (1 + s)/3 - LOSS theta, B' = E.
        let b = sub(times(2.0 / 3.0, add(v(1.0), s)), times(LOSS, theta));
        let e = sub(times(2.0 / 3.0, c), v(LOSS));
        let second = sub(mul(c, e), mul(s, b));
        let k = 2.0 / 3.0 / PI * LOSS;
        let square = add(mul(phi, phi), v(2.0 - FRAC_PI_2 * FRAC_PI_2));
        let curved = add(v(PI / 3.0), times(LOSS, mul(phi, phi)));
        let (first, slope, by_epsilon, by_l);
        if order == 1 {
            (first, slope) = (mul(c, b), second);
            let cubic = mul(c, sub(cc, add(ss, ss)));
            by_epsilon = add(times(1.0 / 6.0, cubic), times(k, mul(square, c)));
            let mut sum = sub(times(2.0 / 3.0, cc), v(4.0 / 3.0));
            sum = sub(sum, times(4.0 / 3.0, mul(phi, sc)));
            sum = sub(sum, times(4.0 / 9.0, sub(cc, ss)));
            sum = add(sum, add(times(2.0 * LOSS, mul(phi, s)), mul(curved, c)));
            by_l = add(sum, times(2.0 / 3.0 * LOSS, sub(c, mul(phi, s))));
        } else {
            let twice = add(mul(s, e), mul(s, e));
            first = second;
            slope = sub(v(0.0), add(add(mul(c, b), twice), times(2.0 / 3.0, sc)));
            let cubic = mul(s, sub(add(ss, ss), times(7.0, cc)));
            let bracket = sub(times(2.0, mul(phi, c)), mul(square, s));
            by_epsilon = add(times(1.0 / 6.0, cubic), times(k, bracket));
            let mut sum = times(16.0 / 9.0 - 8.0 / 3.0, sc);
            sum = sub(sum, times(4.0 / 3.0, mul(phi, sub(cc, ss))));
            sum = add(sum, times(2.0 * LOSS, add(s, times(2.0, mul(phi, c)))));
            sum = sub(sum, mul(curved, s));
            by_l = sub(sum, times(2.0 / 3.0 * LOSS, add(times(2.0, s), mul(phi, c))));
        }
        let second_order = add(times(self.epsilon, by_epsilon), times(self.l, by_l));
        (add(first, second_order), slope)
    }

    /// The value, and the slope of its leading part, at the phases `theta`; `s` and `c` are the sine and cosine of
    /// `theta - pi/2`.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, simd: S, theta: S::f64s, s: S::f64s, c: S::f64s) -> (S::f64s, S::f64s) {
        let v = |x: f64| simd.splat_f64s(x);
        let mul = |a, b| simd.mul_f64s(a, b);
        let add = |a, b| simd.add_f64s(a, b);
        let fma = |a, b, c| simd.mul_add_e_f64s(a, b, c);
        let phi = add(theta, v(-FRAC_PI_2));
        let (square, phi_square, phi_c) = (mul(c, c), mul(phi, phi), mul(phi, c));
        let fallen = mul(v(1.0 / 3.0), add(v(1.0), s));
        let first = fma(v(-LOSS), fma(theta, s, c), fma(fallen, s, fallen));
        let slope = mul(c, fma(v(-LOSS), theta, add(fallen, fallen)));
        let bracket = fma(add(phi_square, v(-FRAC_PI_2 * FRAC_PI_2)), s, add(phi_c, phi_c));
        let by_epsilon = fma(v(2.0 / 3.0 / PI * LOSS), bracket, mul(v(1.0 / 6.0), mul(square, s)));
        let cubic = mul(fma(v(2.0 / 3.0), square, v(-4.0 / 3.0)), phi);
        let odd = fma(fma(v(LOSS), phi_square, v(PI / 3.0)), s, cubic);
        let by_l = fma(v(2.0 / 3.0 * LOSS), phi_c, fma(v(-4.0 / 9.0), mul(s, c), odd));
        (fma(v(self.epsilon), by_epsilon, fma(v(self.l), by_l, first)), slope)
    }
}

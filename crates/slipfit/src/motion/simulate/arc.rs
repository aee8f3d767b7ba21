//! Motion between two events: linear, so closed.
//!
//! With `lambda = -delta + i omega_d` and `psi = v + (delta + i omega_d) y`, where
//! `y` is the displacement since the arc began, the equation of motion is
//!
//! ```text
//! psi' = lambda psi + f(u),     y = Im psi / omega_d,   v = Re psi - delta y
//! f(u) = f_0 + omega_0² (U(u) - U(0)),   f_0 = omega_0² (U(0) - x_start ∓ x_F)
//! ```
//!
//! so `psi(u) = e^(lambda u) v_start + ∫ e^(lambda (u - s)) f(s) ds`. Counting from
//! the arc's own start, with the integrals written as `(e^z - 1)/z`, leaves no
//! large steady part for a transient to cancel, neither at resonance nor in a
//! slip of a millionth of a period.

use super::certify::first_zero;
use super::local::{Local, first_turn_of};
use crate::model::oscillator::Oscillator;
use crate::numeric::double_double::{self as dd, Dd};

pub(super) type C64 = nalgebra::Complex<f64>;

/// What an arc needs to know of the oscillator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Constants {
    pub(super) omega_0: f64,
    pub(super) square: f64,
    pub(super) delta: f64,
    pub(super) omega_d: f64,
    /// What `omega_d` lost by rounding: over a thousand cycles it would show.
    omega_d_rest: f64,
    pub(super) lambda: C64,
    inverse_lambda: C64,
    pub(super) half_period: Dd,
    /// Furthest an arc may reach before it is begun anew.
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
    fn fade(&self, u: f64) -> C64 {
        let (sin, cos) = (self.omega_d * u).sin_cos();
        let rest = self.omega_d_rest * u;
        C64::new(cos - sin * rest, sin + cos * rest) * (-self.delta * u).exp()
    }

    /// `∫_0^u e^(lambda s) ds`.
    #[inline(always)]
    fn ramp(&self, u: f64, e_lambda: C64) -> C64 {
        convolve(-self.lambda, -self.inverse_lambda, u, C64::new(1.0, 0.0), e_lambda)
    }
}

/// The root of a number of an angle in `[0, 2 pi)`, given as a phasor: that of half the angle.
#[inline]
fn half_way(z: C64) -> C64 {
    let size = z.norm_sqr().sqrt();
    // Both under the roots are at least zero but for rounding.
    let (re, im) = ((0.5 * (size + z.re)).max(0.0).sqrt(), (0.5 * (size - z.re)).max(0.0).sqrt());
    C64::new(if z.im < 0.0 { -re } else { re }, im)
}

/// Sliding in one direction under a known drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    pub(super) start: f64,
    pub(super) velocity: f64,
    pub(super) direction: f64,
    /// Acceleration at the start, less the viscous part.
    pub(super) pull: f64,
}

/// Displacement since the start and three derivatives, all at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) moved: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
}

/// `(e^y - 1)/y` for |y| below 0.7, to rounding.
#[inline]
pub(super) fn phi_1(y: C64) -> C64 {
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

/// `(e^y - 1 - y)/y²` for |y| below 0.7, to rounding.
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

/// `∫_0^u e^(lambda (u - s)) e^(mu s) ds` with `z = mu - lambda`, the two exponentials given.
#[inline]
pub(super) fn convolve(z: C64, inverse_z: C64, u: f64, e_mu: C64, e_lambda: C64) -> C64 {
    let y = z * u;
    if y.norm_sqr() < 0.49 { e_lambda * phi_1(y) * u } else { (e_mu - e_lambda) * inverse_z }
}

impl Arc {
    /// The state `u` seconds into the arc.
    #[inline]
    pub(crate) fn at(&self, k: &Constants, drive: &Local, u: f64) -> Point {
        let e_lambda = k.fade(u);
        let one = k.ramp(u, e_lambda);
        let forced =
            if drive.is_constant() { Default::default() } else { drive.convolved(k, u, e_lambda, one) };
        self.point(k, e_lambda, one, forced)
    }

    /// From the exponentials and what the drive adds.
    #[inline(always)]
    fn point(&self, k: &Constants, e_lambda: C64, one: C64, (forced, rise, slope): (C64, f64, f64)) -> Point {
        let psi = e_lambda * self.velocity + one * self.pull + forced * k.square;
        let moved = psi.im / k.omega_d;
        let velocity = psi.re - k.delta * moved;
        let acceleration = self.pull + k.square * (rise - moved) - 2.0 * k.delta * velocity;
        let jerk = k.square * (slope - velocity) - 2.0 * k.delta * acceleration;
        Point { moved, velocity, acceleration, jerk }
    }

    /// Bound on the third derivative of velocity up to `reach`.
    fn bound(&self, k: &Constants, drive: &Local, reach: f64) -> f64 {
        let [swing, d1, d2, _] = drive.bounds(reach);
        // psi about the equilibrium the pull alone would have.
        let centre = self.pull / k.square;
        let psi =
            C64::new(self.velocity - k.delta * centre, -k.omega_d * centre).norm() + k.square * swing * reach;
        let first = k.omega_0 * psi + k.square * swing;
        let second = k.omega_0 * first + k.square * d1;
        let third = k.omega_0 * second + k.square * d2;
        // v = Re psi - delta Im psi/omega_d; a hair of slack covers rounding.
        third * (k.omega_0 / k.omega_d) * 1.000_001
    }

    /// The first turn of a slip from rest under one harmonic, and the displacement up to it,
    /// begun from a guess; `None` where the turn found may not be the first.
    ///
    /// Velocity obeys `L v = v'' + 2 delta v' + omega_0² v = omega_0² U'`, and on less than
    /// `pi/omega_d` the operator `L` is disconjugate: between two zeros that near to each other
    /// a positive `v` needs `L v < 0` somewhere, a negative one `L v > 0`. `v` leaves zero along
    /// `s` and passes down through the root found. Were there zeros in between, an even number,
    /// the signs of `s L v` would have to run `-, +, -` on the way: two changes of the sign of
    /// `U'`, which a harmonic has at known times. A longer slip is cut at some `a` with
    /// `s v(a) > 0`: before it only `-, +`, after it only `+, -` could hide zeros.
    pub(crate) fn turn_near(&self, k: &Constants, drive: &Local, guess: f64) -> Option<(f64, f64)> {
        use std::f64::consts::{PI, TAU};
        let tone = drive.only_tone()?;
        let (omega, phase) = (tone.omega, tone.angle());
        let s = self.direction;
        let window = 0.999 * PI / k.omega_d;
        let leaves = s * self.pull > 0.0 || (self.pull == 0.0 && s * drive.slope_at_start() > 0.0);
        if !(leaves && guess > 0.0 && guess < 2.0 * window) {
            return None;
        }
        let steep = 1e-6 * (self.pull.abs() + k.square * drive.strength());
        let (mut u, mut moved, mut found) = (guess, 0.0, false);
        // The last time computed, and its exponentials.
        let mut last = (u, C64::default(), C64::default());
        for _ in 0..6 {
            let e_lambda = k.fade(u);
            let one = k.ramp(u, e_lambda);
            let (sin, cos) = (omega * u).sin_cos();
            let e = C64::new(cos, sin);
            let p = self.point(k, e_lambda, one, tone.convolved(u, e, e_lambda, one));
            last = (u, e_lambda, e);
            // Halley's method; the last step is too short for what it leaves out.
            let step = p.velocity / (p.acceleration - 0.5 * p.velocity * p.jerk / p.acceleration);
            if !(s * p.acceleration < -steep && step.abs() < 0.1 * guess) {
                return None;
            }
            u -= step;
            moved = p.moved - step * (p.velocity - 0.5 * step * (p.acceleration - step * p.jerk / 3.0));
            if step.abs() < 1e-6 * u {
                found = true;
                break;
            }
        }
        if !found || u >= 2.0 * window {
            return None;
        }
        // s U' goes as sin(omega u + theta).
        let theta = first_turn_of(phase + if s > 0.0 { PI } else { 0.0 });
        if u < window {
            let changes = ((theta + omega * u) / PI).floor() - (theta / PI).floor();
            return (changes <= 1.0).then_some((u, moved));
        }
        let rising = (TAU - theta) / omega;
        let falls = ((theta + omega * u - PI) / TAU).floor();
        let falling = if falls >= 0.0 { (PI + TAU * falls - theta) / omega } else { 0.0 };
        let (low, high) = ((u - window).max(falling), window.min(rising));
        let (at, e_lambda, e) = last;
        let middle = 0.5 * at;
        if low < middle && middle < high && omega * at < TAU {
            // Half way the exponentials are roots; near zero theirs would be too rough a sign.
            let (e_lambda, e) = (half_way(e_lambda), half_way(e));
            let one = k.ramp(middle, e_lambda);
            let p = self.point(k, e_lambda, one, tone.convolved(middle, e, e_lambda, one));
            if s * p.velocity > steep * u {
                return Some((u, moved));
            }
        }
        let above = |at: f64| s * self.at(k, drive, at).velocity > steep * 1e-6 * u;
        if low < high {
            return above(0.5 * (low + high)).then_some((u, moved));
        }
        // A stretch is left that the signs cannot clear: it is searched.
        let clear = above(high)
            && above(low)
            && self.search(k, drive, high, 0.25 * k.reach, low, self.bound(k, drive, low)).is_none();
        clear.then_some((u, moved))
    }

    /// First time up to `reach` at which velocity comes to zero; `None` if it keeps its sign.
    pub(crate) fn first_turn(&self, k: &Constants, drive: &Local, reach: f64) -> Option<f64> {
        let m3 = self.bound(k, drive, reach);
        let s = self.direction;
        let (mut u, mut trust) = (0.0, reach);
        if self.velocity == 0.0 {
            // g(0) = 0: leave along g' u + g'' u²/2 - M u³/6, positive up to its root.
            let g1 = (s * self.pull).max(0.0);
            let g2 = 0.5 * s * (k.square * drive.slope_at_start() - 2.0 * k.delta * self.pull);
            let root = (g2 * g2 + m3 / 1.5 * g1).sqrt();
            u = if g2 >= 0.0 { 3.0 * (g2 + root) / m3 } else { 2.0 * g1 / (root - g2) };
            if u.is_nan() || u <= 0.0 {
                return Some(0.0);
            }
            trust = trust.min(2.0 * u);
        }
        self.search(k, drive, u, trust, reach, m3)
    }

    fn search(
        &self,
        k: &Constants,
        drive: &Local,
        start: f64,
        trust: f64,
        reach: f64,
        m3: f64,
    ) -> Option<f64> {
        let s = self.direction;
        // Rounding of velocity: what has acted so far, not what will.
        let force = self.pull.abs() + k.square * drive.strength();
        first_zero(start, trust, reach, m3, |u| {
            let p = self.at(k, drive, u);
            let noise = 1e-16 * (self.velocity.abs() + u * force);
            [s * p.velocity, s * p.acceleration, s * p.jerk, noise]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_way_round_is_a_root_of_the_half_angle() {
        for i in 0..400 {
            let (size, angle) = (0.3 + 0.01 * f64::from(i % 7), std::f64::consts::TAU * f64::from(i) / 400.0);
            let half = half_way(C64::from_polar(size, angle));
            // A square root of a rounding is left where one part vanishes.
            assert!((half - C64::from_polar(size.sqrt(), 0.5 * angle)).norm() < 2e-8, "{angle}");
        }
    }
}

//! Motion between two events, which is linear and therefore has a closed form.
//!
//! With `lambda = -delta + i omega_d` and `psi = v + (delta + i omega_d) y`, where
//! `y` is the displacement since the arc began, the equation of motion is
//!
//! ```text
//! psi' = lambda psi + f(u),     y = Im psi / omega_d,   v = Re psi - delta y
//! f(u) = f_0 + omega_0² (U(u) - U(0)),   f_0 = omega_0² (U(0) - x_start ∓ x_F)
//! ```
//!
//! so `psi(u) = e^(lambda u) v_start + ∫ e^(lambda (u - s)) f(s) ds`. Because displacements are counted from the
//! start of the arc and the integrals are written as `(e^z - 1)/z`, there is no large steady part to be cancelled by
//! a transient, neither at resonance nor in a slip of a millionth of a period.

use super::certify::first_zero;
use super::local::{Local, first_turn_of};
use super::transition::{C64, Constants, half_way};

/// Sliding in one direction under a known drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    pub(super) start: f64,
    pub(super) velocity: f64,
    pub(super) direction: f64,
    /// Acceleration at the start without the viscous part.
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

    /// The state from the exponentials and the contribution of the drive.
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
        // psi about the equilibrium position under the pull alone.
        let centre = self.pull / k.square;
        let psi =
            C64::new(self.velocity - k.delta * centre, -k.omega_d * centre).norm() + k.square * swing * reach;
        let first = k.omega_0 * psi + k.square * swing;
        let second = k.omega_0 * first + k.square * d1;
        let third = k.omega_0 * second + k.square * d2;
        // v = Re psi - delta Im psi/omega_d; a small margin covers rounding.
        third * (k.omega_0 / k.omega_d) * 1.000_001
    }

    /// The first turning point of a slip from rest under one harmonic, and the displacement up to it, starting from a
    /// guess; `None` if the turning point found may not be the first.
    ///
    /// Velocity obeys `L v = v'' + 2 delta v' + omega_0² v = omega_0² U'`, and on less than `pi/omega_d` the operator
    /// `L` is disconjugate: between two zeros within this distance, a positive `v` requires `L v < 0` somewhere, and
    /// a negative one `L v > 0`. `v` leaves zero along `s` and falls through the root found. If there were zeros in
    /// between (an even number), the signs of `s L v` would have to be `-, +, -` in sequence: two sign changes of
    /// `U'`, which a harmonic has at known times. A longer slip is divided at some `a` with `s v(a) > 0`: before it
    /// only the sequence `-, +`, after it only `+, -` could hide zeros.
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
            // Halley's method; the last step is so short that the neglected terms do not matter.
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
        // s U' varies as sin(omega u + theta).
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
            // At half the time the exponentials are square roots; near zero these roots would be too inaccurate for a
            // sign.
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
        // The interval for which the signs give no proof is searched.
        let clear = above(high)
            && above(low)
            && self.search(k, drive, high, 0.25 * k.reach, low, self.bound(k, drive, low)).is_none();
        clear.then_some((u, moved))
    }

    /// First time up to `reach` at which the velocity becomes zero; `None` if it keeps its sign.
    pub(crate) fn first_turn(&self, k: &Constants, drive: &Local, reach: f64) -> Option<f64> {
        let m3 = self.bound(k, drive, reach);
        let s = self.direction;
        let (mut u, mut trust) = (0.0, reach);
        if self.velocity == 0.0 {
            // g(0) = 0: start along g' u + g'' u²/2 - M u³/6, which is positive up to its root.
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
        // Rounding error of the velocity, from the forces up to now only.
        let force = self.pull.abs() + k.square * drive.strength();
        first_zero(start, trust, reach, m3, |u| {
            let p = self.at(k, drive, u);
            let noise = 1e-16 * (self.velocity.abs() + u * force);
            [s * p.velocity, s * p.acceleration, s * p.jerk, noise]
        })
    }
}

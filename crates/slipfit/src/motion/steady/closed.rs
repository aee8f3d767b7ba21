//! The closed form with two turning points per cycle at one frequency, with its derivatives. The code has no
//! branches, so that a loop over it can be vectorised.

use super::Phasor;
use super::response::{Fundamental, Point, Regime};
use crate::numeric::trig;
use std::f64::consts::PI;

pub(super) const KAPPA: f64 = 4.0 / PI;

/// Result of [`closed_form`]; NaN if the root has no real value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Closed {
    pub(crate) value: Phasor,
    /// Derivatives with respect to `omega_0`, `delta`, `x_0`, `x_F`.
    pub(crate) by: [Phasor; 4],
    pub(super) p: f64,
    pub(super) q: f64,
    /// `G x_F`.
    pub(super) g_x: f64,
    pub(super) omega_d: f64,
    pub(super) d: Phasor,
}

/// Functions of the angle `pi (omega - omega_d)/(2 omega)` and of the decay `pi delta/(2 omega)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Halves {
    /// Sine and cosine; a common sign is arbitrary.
    pub(crate) sin: f64,
    pub(crate) cos: f64,
    /// Hyperbolic sine and cosine.
    pub(crate) sinh: f64,
    pub(crate) cosh: f64,
}

/// `omega - omega_d`; divided by `omega` and times a quarter turn, it is the angle of [`Halves`].
#[inline(always)]
pub(crate) fn excess(at: &Point) -> f64 {
    let omega_d = ((at.omega_0 - at.delta) * (at.omega_0 + at.delta)).sqrt();
    at.detuning + at.delta * at.delta / (at.omega_0 + omega_d)
}

/// ```text
/// Z = x_0/D - i (4/pi) (x_F/x_0) (D*/D) (p + i q),   q = H x_F,   p = sqrt((x_0/|D|)² - q²)
/// ```
#[inline(always)]
pub(crate) fn closed_form(at: &Point, over_omega: f64, halves: Halves) -> Closed {
    let Point { omega, omega_0, detuning, delta, x_0, x_f } = *at;
    let Halves { sin: h, cos: k, sinh: g, cosh } = halves;
    let omega_d = ((omega_0 - delta) * (omega_0 + delta)).sqrt();
    let over_d = 1.0 / omega_d;
    let over_0 = 1.0 / omega_0;
    let (sin, cos) = (2.0 * h * k, 1.0 - 2.0 * h * h);
    let sinh = 2.0 * g * cosh;
    let over_2 = over_0 * over_0;
    let d = Phasor::new(-detuning * (omega_0 + omega) * over_2, 2.0 * delta * omega * over_2);
    // One division instead of two.
    let (n, d_squared) = (g * g + h * h, d.norm_sqr());
    let over = 1.0 / (n * d_squared);
    let (over_n, c_squared) = (0.5 * over * d_squared, over * n);
    let front = omega_0 * omega_0 * over_omega * over_d;
    let hh = front * sin * over_n;
    // d/d(omega_0) and d/d(delta): omega_d changes by omega_0/omega_d and -delta/omega_d.
    let (wd_0, wd_1) = (omega_0 * over_d, -delta * over_d);
    let (e_0, e_1) = (-PI * wd_0 * over_omega, -PI * wd_1 * over_omega);
    let part = front * over_n;
    let n_0 = sin * e_0;
    let n_1 = sin * e_1 + sinh * (PI * over_omega);
    let h_0 = hh * (2.0 * over_0 - wd_0 * over_d - n_0 * over_n) + part * cos * e_0;
    let h_1 = hh * (-wd_1 * over_d - n_1 * over_n) + part * cos * e_1;

    let d_0 = Phasor::new(2.0 * omega * omega * over_2 * over_0, -2.0 * d.im * over_0);
    let d_1 = 2.0 * omega * over_2;
    let c = d.conj() * c_squared;
    // Relative changes of D: magnitude and angle.
    let m_0 = d_0 * c;
    let m_1 = Phasor::new(-c.im, c.re) * d_1;
    let turn = d.conj() * c;

    let q = hh * x_f;
    let (q_0, q_1) = (h_0 * x_f, h_1 * x_f);
    let reach = x_0 * x_0 * c_squared;
    let p = (reach - q * q).sqrt();
    let over = 1.0 / (p * x_0);
    let (over_p, over_x_0) = (over * x_0, over * p);
    let (reach, back) = (reach * over_p, q * over_p);
    let p_0 = -reach * m_0.re - back * q_0;
    let p_1 = -reach * m_1.re - back * q_1;
    let p_3 = -back * hh;

    // -i (p + i q) = q - i p; D*/D rotates back by twice the angle of D.
    let each = KAPPA * over_x_0;
    let ratio = each * x_f;
    let free = c * x_0;
    let value = free + turn * Phasor::new(q * ratio, -p * ratio);
    let by = |q_k: f64, p_k: f64, m: Phasor| {
        let twice = 2.0 * m.im;
        turn * Phasor::new((q_k - twice * p) * ratio, -(p_k + twice * q) * ratio) - free * m
    };
    let by_x_f = turn * Phasor::new(q * each + hh * ratio, -(p * each + p_3 * ratio));
    Closed {
        value,
        by: [
            by(q_0, p_0, m_0),
            by(q_1, p_1, m_1),
            // Scaling drive and friction together only changes the scale of the motion.
            (value - by_x_f * x_f) * over_x_0,
            by_x_f,
        ],
        p,
        q,
        g_x: (sinh - delta * over_d * sin) * over_n * x_f,
        omega_d,
        d,
    }
}

impl Closed {
    /// Excess of the drive over spring and friction at the turning point; the mass moves on at once if this is not
    /// negative. NaN if there is no turning point.
    #[inline(always)]
    pub(crate) fn push(&self, x_f: f64) -> f64 {
        let amplitude = self.p - self.g_x;
        let push = amplitude - x_f - (self.p * self.d.re + self.q * self.d.im);
        if amplitude > 0.0 { push } else { f64::NAN }
    }

    /// Non-negative if the closed form has a value at all.
    #[inline(always)]
    pub(crate) fn turned(&self) -> f64 {
        if self.p > 0.0 { self.p } else { f64::NAN }
    }

    /// The fundamental of a motion that slides all the time.
    pub(super) fn fundamental(&self) -> Fundamental {
        let [by_omega_0, by_delta, by_x_0, by_x_f] = self.by;
        Fundamental { value: self.value, by_omega_0, by_delta, by_x_0, by_x_f, regime: Regime::Sliding }
    }

    pub(super) fn turn_amplitude(&self) -> f64 {
        self.p - self.g_x
    }
}

/// Frequency over `omega_0` above which a mass that moves on keeps its direction for half a cycle (Den Hartog: only a
/// drive much slower than the oscillator makes it turn in between).
pub(crate) const NEVER_TURNS: f64 = 0.75;

/// Whether it also keeps its direction below that frequency.
pub(super) fn keeps_direction(at: &Point, t: &Closed) -> bool {
    let (w, delta, omega) = (t.omega_d, at.delta, at.omega);
    let a = -at.x_f - t.g_x;
    let b = (delta * a - omega * t.q) / w;
    let steps = (32.0 * at.omega_0 / omega).clamp(32.0, 4096.0) as u32;
    let h = PI / omega / f64::from(steps);
    // v = Im of a rotating phasor plus Re of a rotating and decaying phasor.
    let steady = Phasor::new(-omega * t.p, omega * t.q);
    let free = Phasor::new(w * b - delta * a, -(w * a + delta * b));
    let mut walk = Walk::new([omega, w, delta], h, steady, free);
    walk.until_not_negative(steps - 1, 0.0).is_none()
}

/// `Im(s e^(i omega u)) + Re(f e^(-(delta + i w) u))` at equal steps of `u`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    pub(super) steady: Phasor,
    pub(super) free: Phasor,
    pub(super) turn: Phasor,
    pub(super) fade: Phasor,
}

/// Number of steps between two attempts to leap.
const STEPS_BETWEEN_LEAPS: u32 = 24;
/// Cost of a leap, in steps.
const LEAST_LEAP: f64 = 24.0;

impl Walk {
    #[inline(always)]
    pub(super) fn new([omega, w, delta]: [f64; 3], h: f64, steady: Phasor, free: Phasor) -> Self {
        let left = trig::exp(-delta * h);
        let ((sin, cos), (s, c)) = (trig::sin_cos(omega * h), trig::sin_cos(w * h));
        Self { steady, free, turn: Phasor::new(cos, sin), fade: Phasor::new(left * c, -left * s) }
    }

    /// Takes one step and returns the value there.
    #[inline]
    pub(super) fn step(&mut self) -> f64 {
        self.steady *= self.turn;
        self.free *= self.fade;
        self.value()
    }

    fn value(&self) -> f64 {
        self.steady.im + self.free.re
    }

    /// Leaps over the steps in which the negative steady part outweighs the remaining free part; at most `most`
    /// steps. Returns their number.
    fn leap(&mut self, most: u32) -> u32 {
        let (size, left) = (self.steady.norm_sqr().sqrt(), self.free.norm_sqr().sqrt());
        // The free part must not grow.
        if !(left < size && self.fade.norm_sqr() <= 1.0) {
            return 0;
        }
        let margin = (left / size).asin();
        let here = -self.steady.arg();
        let steps = ((here - margin) / self.turn.arg()).min(f64::from(most));
        if !(here < PI - margin && steps >= LEAST_LEAP) {
            return 0;
        }
        let steps = steps as u32;
        self.steady *= self.turn.powu(steps);
        self.free *= self.fade.powu(steps);
        steps
    }

    /// The first of the next `most` steps at which the value is no longer negative, with the values there and one
    /// step earlier, starting from `before`; `None` if there is none.
    pub(super) fn until_not_negative(&mut self, most: u32, mut before: f64) -> Option<(u32, [f64; 2])> {
        let mut k = 0;
        while k < most {
            let chunk = (k + STEPS_BETWEEN_LEAPS).min(most);
            while k < chunk {
                k += 1;
                let here = self.step();
                if !(here < 0.0) {
                    return Some((k, [before, here]));
                }
                before = here;
            }
            let leapt = if f64::from(most - k) > LEAST_LEAP { self.leap(most - k) } else { 0 };
            if leapt > 0 {
                k += leapt;
                before = self.value();
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slide from rest under a drive far slower than the oscillator, checked at every single step.
    #[test]
    fn leaps_miss_no_end_of_a_slide() {
        let mut long = 0;
        for (omega, delta) in [(0.5, 0.2), (0.05, 0.1), (0.01, 0.02), (0.01, 0.5), (0.002, 0.05)] {
            for angle in [0.3, 1.2, 2.0, 2.9] {
                let steady = Phasor::from_polar(1.0, -angle);
                let walk = Walk::new([omega, 1.0, delta], PI / 12.0, steady, Phasor::new(-steady.im, -0.3));
                let mut stepped = walk;
                stepped.step();
                let mut leapt = stepped;
                let most = 100_000;
                let expected = (1..=most).find(|_| !(stepped.step() < 0.0));
                let found = leapt.until_not_negative(most, -1.0).map(|(k, _)| k);
                assert_eq!(found, expected, "{omega} {delta} {angle}");
                long += usize::from(found.is_some_and(|k| k > 200));
            }
        }
        assert!(long > 5, "{long}");
    }
}

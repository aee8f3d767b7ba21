//! Symmetric motion with one stop each half cycle: two equations in two unknowns.
//!
//! Let go downwards at the phase `phi`, where the drive falls below spring less friction,
//!
//! ```text
//! X = x_0 cos phi + x_F,
//! ```
//!
//! the mass slides for a time `u` until its velocity vanishes, and must then be at `-X`. Both
//! conditions are solved by Newton's method; their derivatives by the parameters follow from
//! the implicit functions. While it slides friction is `x_F`, while it is held it is what drive
//! and spring leave, so that its fundamental, and with it the response, needs nothing more than
//! the two phases:
//!
//! ```text
//! D Z = x_0 - (2/pi) ∫ f e^(-i psi) d psi          over half a cycle
//! ```
//!
//! Lengths are in units of `x_0`: response and drive only scale together.

use super::Phasor;
use super::closed::Walk;
use super::response::{Fundamental, Point, Regime};
use std::f64::consts::PI;

/// Phase of the release downwards, and how long the slide lasts, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip {
    phase: f64,
    duration: f64,
}

/// The oscillator at one frequency.
struct Law {
    omega: f64,
    omega_0: f64,
    delta: f64,
    omega_d: f64,
    /// Response to the drive alone, `1/D`.
    g: Phasor,
    x_f: f64,
}

/// Free motion from rest at one and from zero at speed one, and their rates.
struct Free {
    a: f64,
    b: f64,
    a_rate: f64,
    b_rate: f64,
    /// `e^(-delta u)` times sine and cosine of `omega_d u`.
    sin: f64,
    cos: f64,
}

/// The two conditions (speed, place) and what they depend on.
struct Balance {
    value: [f64; 2],
    by_phase: [f64; 2],
    by_duration: [f64; 2],
    crest: Phasor,
    steady: Phasor,
    turn: Phasor,
    free: Free,
}

impl Law {
    fn new(at: &Point) -> Self {
        let over = 1.0 / (at.omega_0 * at.omega_0);
        let d = Phasor::new(-at.detuning * (at.omega_0 + at.omega) * over, 2.0 * at.delta * at.omega * over);
        Self {
            omega: at.omega,
            omega_0: at.omega_0,
            delta: at.delta,
            omega_d: ((at.omega_0 - at.delta) * (at.omega_0 + at.delta)).sqrt(),
            g: d.conj() / d.norm_sqr(),
            x_f: at.x_f / at.x_0,
        }
    }

    fn free(&self, u: f64) -> Free {
        let e = (-self.delta * u).exp();
        let (s, c) = (self.omega_d * u).sin_cos();
        let (sin, cos) = (e * s, e * c);
        let b = sin / self.omega_d;
        let b_rate = cos - self.delta * b;
        Free {
            a: b_rate + 2.0 * self.delta * b,
            b,
            a_rate: -self.omega_0 * self.omega_0 * b,
            b_rate,
            sin,
            cos,
        }
    }

    fn balance(&self, at: Slip) -> Balance {
        let w = self.omega;
        let (sin, cos) = at.phase.sin_cos();
        let crest = Phasor::new(cos, sin);
        let steady = self.g * crest;
        let (s, c) = (w * at.duration).sin_cos();
        let turn = Phasor::new(c, s);
        let there = steady * turn;
        let free = self.free(at.duration);
        let (from, speed) = (cos - steady.re, w * steady.im);
        let moved = steady.im - sin;
        // x'' = -2 delta x' - omega_0² x of the free part.
        let fall = |x: f64, v: f64| -2.0 * self.delta * v - self.omega_0 * self.omega_0 * x;
        let v = -w * there.im + from * free.a_rate + speed * free.b_rate;
        let x = there.re + from * free.a + speed * free.b;
        Balance {
            value: [v, 2.0 * self.x_f + cos + x],
            by_phase: [
                -w * there.re + moved * free.a_rate + w * steady.re * free.b_rate,
                -sin - there.im + moved * free.a + w * steady.re * free.b,
            ],
            by_duration: [
                -w * w * there.re + from * fall(free.a, free.a_rate) + speed * fall(free.b, free.b_rate),
                v,
            ],
            crest,
            steady,
            turn,
            free,
        }
    }

    /// The velocity of a slide from its start, at even steps.
    fn walk(&self, steady: Phasor, crest: Phasor, h: f64) -> Walk {
        let (a, v) = (crest.re - steady.re, self.omega * steady.im);
        let b = (self.delta * a + v) / self.omega_d;
        let free = Phasor::new(self.omega_d * b - self.delta * a, -(self.omega_d * a + self.delta * b));
        Walk::new([self.omega, self.omega_d, self.delta], h, steady * -self.omega, free)
    }

    /// Steps short enough that no turn hides between two.
    fn step(&self) -> f64 {
        PI / self.omega.max(self.omega_d) / 12.0
    }
}

impl Slip {
    pub(super) fn new(phase: f64, duration: f64) -> Self {
        Self { phase, duration }
    }

    /// Let go at an amplitude, and sliding until it first turns.
    pub(super) fn from_amplitude(at: &Point, amplitude: f64) -> Option<Self> {
        let law = Law::new(at);
        let level = ((amplitude / at.x_0).max(0.0) - law.x_f).clamp(-0.999, 0.999);
        let phase = level.acos();
        let crest = Phasor::new(level, phase.sin());
        let h = law.step();
        let mut walk = law.walk(law.g * crest, crest, h);
        // Its first step may lie before the drive has pulled it off.
        let mut before = walk.step();
        let most = PI / at.omega / h;
        if !most.is_finite() {
            return None;
        }
        let most = (most as u32).saturating_add(2);
        for k in 2..=most {
            let here = walk.step();
            if here >= 0.0 {
                let t = if before < 0.0 { before / (before - here) } else { 0.5 };
                return Some(Self { phase, duration: h * (f64::from(k) - 1.0 + t) });
            }
            before = here;
        }
        Some(Self { phase, duration: 0.95 * PI / at.omega })
    }
}

/// How many roundings the response may be off.
#[derive(Debug, Clone, Copy)]
pub(super) enum Digits {
    Twelve = 10_000,
    /// Where no other way to a symmetric motion led.
    Eight = 100_000_000,
}

/// Newton's steps before another way is taken.
const MOST_STEPS: usize = 14;

/// The fundamental of the motion with one stop near `near`, if there is one.
pub(super) fn fundamental(at: &Point, near: Slip, digits: Digits) -> Option<(Fundamental, Slip)> {
    let law = Law::new(at);
    let half = PI / law.omega;
    let mut here = near;
    let mut found = false;
    for _ in 0..MOST_STEPS {
        let b = law.balance(here);
        let [by_phase, by_duration] = solve(&b, [-b.value[0], -b.value[1]]);
        if !(by_phase.is_finite() && by_duration.is_finite()) {
            return None;
        }
        here.phase += by_phase.clamp(-0.4, 0.4);
        here.duration += by_duration.clamp(-0.3 * half, 0.3 * half);
        if !(here.phase > 0.0 && here.phase < PI && here.duration > 0.0 && here.duration < 1.2 * half) {
            return None;
        }
        // A weak difference of drive and friction is left with the error many times over.
        let step = by_phase.abs().max(by_duration.abs() / half);
        found = step < 1e-8;
        if step < 1e-11 {
            break;
        }
    }
    if !found {
        return None;
    }
    let b = law.balance(here);
    law.is_motion(here, &b).then_some(())?;
    let f = law.response(at, here, &b, digits)?;
    Some((f, here))
}

fn solve(b: &Balance, [v, x]: [f64; 2]) -> [f64; 2] {
    let over = 1.0 / (b.by_phase[0] * b.by_duration[1] - b.by_phase[1] * b.by_duration[0]);
    [(v * b.by_duration[1] - x * b.by_duration[0]) * over, (b.by_phase[0] * x - b.by_phase[1] * v) * over]
}

impl Law {
    /// Whether the mass slides downwards all the time, is then held, and is next let go upwards.
    fn is_motion(&self, slip: Slip, b: &Balance) -> bool {
        const ROUNDING: f64 = 1e-12;
        if slip.duration > (1.0 + ROUNDING) * PI / self.omega {
            return false;
        }
        let amplitude = b.crest.re + self.x_f;
        let end = b.crest * b.turn;
        if (end.re + amplitude).abs() > self.x_f + ROUNDING {
            return false;
        }
        // The drive may pass its trough while the mass is held.
        let stop = slip.phase + self.omega * slip.duration;
        if stop < PI && amplitude - 1.0 < -self.x_f {
            return false;
        }
        let h = self.step();
        let mut walk = self.walk(b.steady, b.crest, h);
        let steps = (slip.duration / h - 1e-6).max(0.0) as u32;
        (0..steps).all(|_| walk.step() < 0.0)
    }

    fn response(&self, at: &Point, slip: Slip, b: &Balance, digits: Digits) -> Option<Fundamental> {
        let (w, g, x_f) = (self.omega, self.g, self.x_f);
        let (cos, sin) = (b.crest.re, b.crest.im);
        let begin = b.crest.conj();
        let end = begin * b.turn.conj();
        let (begin_2, end_2) = (begin * begin, end * end);
        let i = |z: Phasor| Phasor::new(-z.im, z.re);
        let reach = 2.0 * x_f + cos;
        let friction = 2.0 / PI;
        let sum = Phasor::new(0.5 * (PI - w * slip.duration), 0.0) + i(begin_2 - end_2) * 0.25
            - i(end * reach + begin * cos);
        let value = g * (Phasor::new(1.0, 0.0) - sum * friction);
        // The phases are good to a rounding times |g|, their weak difference from the drive to one
        // times |g|²: at resonance the way by velocities keeps its digits.
        if !(g.norm_sqr() < digits as u32 as f64 * value.norm()) {
            return None;
        }
        let by_phase = (begin_2 - end_2) * 0.5 + i(end + begin) * sin - end * reach - begin * cos;
        let by_duration = -(Phasor::new(0.5, 0.0) + end_2 * 0.5 + end * reach) * w;
        let by_x_f = i(end) * -2.0;

        let free = &b.free;
        let (from, speed) = (cos - b.steady.re, w * b.steady.im);
        let moved = |d: [f64; 2], own: Phasor, d_g: Phasor| {
            let [d_phase, d_duration] = solve(b, [-d[0], -d[1]]);
            let d_sum = by_phase * d_phase + by_duration * d_duration + own;
            (d_g * value) / g - g * d_sum * friction
        };
        // By omega_0 and delta: through 1/D, and through the free motion.
        let over_2 = 1.0 / (self.omega_0 * self.omega_0);
        let over_d = 1.0 / self.omega_d;
        let minus_g2 = -(g * g);
        let lag = slip.duration * free.cos - free.sin * over_d;
        let lag_rate = -self.delta * lag - slip.duration * self.omega_d * free.sin;
        let through = |d_g: Phasor, d_b: f64, d_b_rate: f64, d_omega_0: f64, d_delta: f64| {
            let d_steady = d_g * b.crest;
            let d_there = d_steady * b.turn;
            let (d_from, d_speed) = (-d_steady.re, w * d_steady.im);
            let d_a = d_b_rate + 2.0 * (self.delta * d_b + free.b * d_delta);
            let d_a_rate = -self.omega_0 * (self.omega_0 * d_b + 2.0 * free.b * d_omega_0);
            let v = -w * d_there.im
                + d_from * free.a_rate
                + from * d_a_rate
                + d_speed * free.b_rate
                + speed * d_b_rate;
            let x = d_there.re + d_from * free.a + from * d_a + d_speed * free.b + speed * d_b;
            moved([v, x], Phasor::default(), d_g)
        };
        let d_0 = Phasor::new(2.0 * w * w, -4.0 * self.delta * w) * (over_2 / self.omega_0);
        let stretch = self.omega_0 * over_d * over_d;
        let by_omega_0 = through(minus_g2 * d_0, stretch * lag, stretch * lag_rate, 1.0, 0.0);
        let stretch = -self.delta * over_d * over_d;
        let by_delta = through(
            minus_g2 * Phasor::new(0.0, 2.0 * w * over_2),
            stretch * lag - slip.duration * free.b,
            stretch * lag_rate - free.b - slip.duration * free.b_rate,
            0.0,
            1.0,
        );
        let by_ratio = moved([0.0, 2.0], by_x_f, Phasor::default());
        let f = Fundamental {
            value: value * at.x_0,
            by_omega_0: by_omega_0 * at.x_0,
            by_delta: by_delta * at.x_0,
            by_x_0: value - by_ratio * x_f,
            by_x_f: by_ratio,
            regime: Regime::OneStop,
        };
        let all = [f.value, f.by_omega_0, f.by_delta, f.by_x_f];
        all.iter().all(|z| z.re.is_finite() && z.im.is_finite()).then_some(f)
    }
}

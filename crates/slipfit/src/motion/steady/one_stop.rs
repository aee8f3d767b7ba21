//! Symmetric motion with one stop per half cycle: two equations in two unknowns.
//!
//! The mass is released downwards at the phase `phi` at which the drive falls below the spring force less friction,
//!
//! ```text
//! X = x_0 cos phi + x_F,
//! ```
//!
//! It slides for a time `u` until its velocity vanishes, and must then be at `-X`. Both conditions are solved by
//! Newton's method; the derivatives with respect to the parameters follow from the implicit function theorem. While
//! the mass slides, friction is `x_F`; while it is held, friction balances drive and spring. The fundamental of the
//! friction force, and with it the response, therefore depends only on the two phases:
//!
//! ```text
//! D Z = x_0 - (2/pi) ∫ f e^(-i psi) d psi          over half a cycle
//! ```
//!
//! Lengths are in units of `x_0`, because response and drive scale together.

use super::Phasor;
use super::closed::Walk;
use super::response::{Fundamental, Point, Regime};
use crate::numeric::trig;
use std::f64::consts::PI;

/// Phase of the downward release, and duration of the slide, s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slip {
    pub(super) phase: f64,
    pub(super) duration: f64,
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

/// Free motion from unit displacement at rest and from zero at unit speed, and their rates.
struct Free {
    a: f64,
    b: f64,
    a_rate: f64,
    b_rate: f64,
    /// `e^(-delta u)` times sine and cosine of `omega_d u`.
    sin: f64,
    cos: f64,
}

/// The two conditions (speed, position) and the quantities they depend on.
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
    #[inline(always)]
    fn new(at: &Point) -> Self {
        let over = 1.0 / (at.omega_0 * at.omega_0);
        let d = Phasor::new(-at.detuning * (at.omega_0 + at.omega) * over, 2.0 * at.delta * at.omega * over);
        Self {
            omega: at.omega,
            omega_0: at.omega_0,
            delta: at.delta,
            omega_d: ((at.omega_0 - at.delta) * (at.omega_0 + at.delta)).sqrt(),
            g: d.conj() * (1.0 / d.norm_sqr()),
            x_f: at.x_f / at.x_0,
        }
    }

    #[inline(always)]
    fn free(&self, u: f64) -> Free {
        let e = trig::exp(-self.delta * u);
        let (s, c) = trig::sin_cos(self.omega_d * u);
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

    #[inline(always)]
    fn balance(&self, at: Slip) -> Balance {
        let w = self.omega;
        let (sin, cos) = trig::sin_cos(at.phase);
        let crest = Phasor::new(cos, sin);
        let steady = self.g * crest;
        let (s, c) = trig::sin_cos(w * at.duration);
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

    /// The velocity of a slide from its start, at equal steps.
    #[inline(always)]
    fn walk(&self, steady: Phasor, crest: Phasor, h: f64) -> Walk {
        let (a, v) = (crest.re - steady.re, self.omega * steady.im);
        let b = (self.delta * a + v) / self.omega_d;
        let free = Phasor::new(self.omega_d * b - self.delta * a, -(self.omega_d * a + self.delta * b));
        Walk::new([self.omega, self.omega_d, self.delta], h, steady * -self.omega, free)
    }

    /// Step short enough that no turning point lies hidden between two.
    #[inline(always)]
    fn step(&self) -> f64 {
        PI / self.omega.max(self.omega_d) / 12.0
    }
}

impl Slip {
    pub(super) fn new(phase: f64, duration: f64) -> Self {
        Self { phase, duration }
    }

    /// Linear extrapolation from `before` through this slip, by `part` of the distance between them; phases are
    /// extrapolated as angles.
    pub(super) fn beyond(self, before: Self, part: f64, [omega_before, omega, next]: [f64; 3]) -> Self {
        let slid = [before.duration * omega_before, self.duration * omega];
        let on = |a: f64, b: f64| b + part * (b - a);
        Self { phase: on(before.phase, self.phase), duration: on(slid[0], slid[1]) / next }
    }

    /// Release at an amplitude, and slide until the first turning point.
    pub(super) fn from_amplitude(at: &Point, amplitude: f64) -> Option<Self> {
        let law = Law::new(at);
        let level = ((amplitude / at.x_0).max(0.0) - law.x_f).clamp(-0.999, 0.999);
        let phase = level.acos();
        let crest = Phasor::new(level, phase.sin());
        let h = law.step();
        let mut walk = law.walk(law.g * crest, crest, h);
        // The first step may lie before the drive has released the mass.
        let before = walk.step();
        let most = PI / at.omega / h;
        if !most.is_finite() {
            return None;
        }
        let most = (most as u32).saturating_add(2);
        if let Some((k, [before, here])) = walk.until_not_negative(most - 1, before) {
            let t = if before < 0.0 { before / (before - here) } else { 0.5 };
            return Some(Self { phase, duration: h * (f64::from(k) + t) });
        }
        Some(Self { phase, duration: 0.95 * PI / at.omega })
    }
}

/// Error allowed for the response, in units of rounding errors.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Accuracy {
    /// Twelve digits.
    Fine = 10_000,
    /// Eight digits, for fits and for motions to which no other method led.
    Coarse = 100_000_000,
}

/// Number of Newton steps before another method is tried.
const MOST_STEPS: usize = 14;
/// Step size, in rad or half cycles, after which the next step only changes the rounding.
const LAST_STEP: f64 = 1e-9;
/// The same if rounding errors keep the step from decreasing: a small difference of drive and friction amplifies the
/// error many times.
const LARGEST_LAST_STEP: f64 = 1e-8;

/// The fundamental of the motion with one stop near `near`, if there is one.
pub(super) fn fundamental(at: &Point, near: Slip, accuracy: Accuracy) -> Option<(Fundamental, Slip)> {
    let law = Law::new(at);
    let mut here = near;
    for round in 1..=MOST_STEPS {
        let mut b = law.balance(here);
        let ([by_phase, by_duration], size) = law.newton(&b, &mut here);
        if !law.in_range(here) {
            return None;
        }
        if size < LAST_STEP || round == MOST_STEPS && size < LARGEST_LAST_STEP {
            match accuracy {
                Accuracy::Fine => b = law.balance(here),
                // The angles are updated to second order in the step; the slopes of a fit do not need this update.
                Accuracy::Coarse => {
                    b.crest *= Phasor::new(1.0, by_phase);
                    b.turn *= Phasor::new(1.0, law.omega * by_duration);
                    b.steady = law.g * b.crest;
                }
            }
            law.is_motion(here, &b).then_some(())?;
            let f = law.response(at, here, &b);
            return (law.is_precise(f.value / at.x_0, accuracy) && is_finite(&f)).then_some((f, here));
        }
    }
    None
}

#[inline(always)]
fn solve(b: &Balance, [v, x]: [f64; 2]) -> [f64; 2] {
    let over = 1.0 / (b.by_phase[0] * b.by_duration[1] - b.by_phase[1] * b.by_duration[0]);
    [(v * b.by_duration[1] - x * b.by_duration[0]) * over, (b.by_phase[0] * x - b.by_phase[1] * v) * over]
}

impl Law {
    /// One step of Newton's method, and its size in rad or half cycles.
    #[inline(always)]
    fn newton(&self, b: &Balance, here: &mut Slip) -> ([f64; 2], f64) {
        let half = PI / self.omega;
        let [by_phase, by_duration] = solve(b, [-b.value[0], -b.value[1]]);
        here.phase += by_phase.clamp(-0.4, 0.4);
        here.duration += by_duration.min(0.3 * half).max(-0.3 * half);
        // NaN if either is NaN.
        let size =
            if by_phase.abs() > by_duration.abs() / half { by_phase.abs() } else { by_duration.abs() / half };
        ([by_phase, by_duration], size + 0.0 * by_phase)
    }

    #[inline(always)]
    fn in_range(&self, slip: Slip) -> bool {
        (slip.phase > 0.0)
            & (slip.phase < PI)
            & (slip.duration > 0.0)
            & (slip.duration * self.omega < 1.2 * PI)
    }

    /// Whether the mass slides downwards all the time, is then held, and is next released upwards.
    fn is_motion(&self, slip: Slip, b: &Balance) -> bool {
        if !self.is_held(slip, b) {
            return false;
        }
        let h = self.step();
        let mut walk = self.walk(b.steady, b.crest, h);
        let steps = (slip.duration / h - 1e-6).max(0.0) as u32;
        walk.until_not_negative(steps, 0.0).is_none()
    }

    /// Whether it is held from the end of its slide until it is released upwards.
    #[inline(always)]
    fn is_held(&self, slip: Slip, b: &Balance) -> bool {
        const ROUNDING: f64 = 1e-12;
        let amplitude = b.crest.re + self.x_f;
        let end = b.crest * b.turn;
        // The drive may pass its trough while the mass is held.
        let stop = slip.phase + self.omega * slip.duration;
        let pulled_off = (stop < PI) & (amplitude - 1.0 < -self.x_f);
        (slip.duration * self.omega <= (1.0 + ROUNDING) * PI)
            & ((end.re + amplitude).abs() <= self.x_f + ROUNDING)
            & !pulled_off
    }

    /// The phases are accurate to a rounding error times `|g|`, and their small difference from the drive to one
    /// times `|g|²`: at resonance the method based on velocities keeps its accuracy.
    #[inline(always)]
    fn is_precise(&self, value: Phasor, accuracy: Accuracy) -> bool {
        self.g.norm_sqr() < accuracy as u32 as f64 * value.norm_sqr().sqrt()
    }

    #[inline(always)]
    fn response(&self, at: &Point, slip: Slip, b: &Balance) -> Fundamental {
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
        let by_phase = (begin_2 - end_2) * 0.5 + i(end + begin) * sin - end * reach - begin * cos;
        let by_duration = -(Phasor::new(0.5, 0.0) + end_2 * 0.5 + end * reach) * w;
        let by_x_f = i(end) * -2.0;

        let free = &b.free;
        let (from, speed) = (cos - b.steady.re, w * b.steady.im);
        let over_g = g.conj() * (1.0 / g.norm_sqr());
        let moved = |d: [f64; 2], own: Phasor, d_g: Phasor| {
            let [d_phase, d_duration] = solve(b, [-d[0], -d[1]]);
            let d_sum = by_phase * d_phase + by_duration * d_duration + own;
            d_g * value * over_g - g * d_sum * friction
        };
        // With respect to omega_0 and delta: through 1/D, and through the free motion.
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
        Fundamental {
            value: value * at.x_0,
            by_omega_0: by_omega_0 * at.x_0,
            by_delta: by_delta * at.x_0,
            by_x_0: value - by_ratio * x_f,
            by_x_f: by_ratio,
            regime: Regime::OneStop,
        }
    }
}

fn is_finite(f: &Fundamental) -> bool {
    let all = [f.value, f.by_omega_0, f.by_delta, f.by_x_f];
    all.iter().all(|z| z.re.is_finite() && z.im.is_finite())
}

/// Number of frequencies for which the motion is computed side by side, on vector lanes.
pub(crate) const GROUP: usize = 8;

pub(crate) type Row = [f64; GROUP];

/// Oscillators at several frequencies of their drives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Group {
    pub(crate) omega: Row,
    pub(crate) omega_0: Row,
    pub(crate) detuning: Row,
    pub(crate) delta: Row,
    pub(crate) x_0: Row,
    pub(crate) x_f: Row,
}

/// A slip at each of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slips {
    pub(super) phase: Row,
    pub(super) duration: Row,
}

/// Their fundamentals, real and imaginary parts, and the derivatives with respect to `omega_0`, `delta`, `x_0`,
/// `x_F`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupResponse {
    pub(crate) value: [Row; 2],
    pub(crate) by: [[Row; 2]; 4],
}

/// Number of Newton steps in a group before its points are computed one by one.
const MOST_GROUP_STEPS: usize = 8;
/// Maximum number of steps of the walk along a slide in a group; slides longer than four swings are computed one by
/// one, with leaps.
const MOST_WALK: f64 = 48.0;

impl Group {
    #[inline(always)]
    fn at(&self, k: usize) -> Point {
        Point {
            omega: self.omega[k],
            omega_0: self.omega_0[k],
            detuning: self.detuning[k],
            delta: self.delta[k],
            x_0: self.x_0[k],
            x_f: self.x_f[k],
        }
    }

    /// Iterates the slips to their conditions; the points that are `wanted` decide when the iteration ends.
    #[inline(always)]
    pub(crate) fn settle(&self, slips: &mut Slips, wanted: &[bool; GROUP]) {
        for _ in 0..MOST_GROUP_STEPS {
            let mut size = [0.0; GROUP];
            for k in 0..GROUP {
                let law = Law::new(&self.at(k));
                let mut here = Slip { phase: slips.phase[k], duration: slips.duration[k] };
                let b = law.balance(here);
                let (_, step) = law.newton(&b, &mut here);
                let good = law.in_range(here);
                slips.phase[k] = if good { here.phase } else { f64::NAN };
                slips.duration[k] = here.duration;
                size[k] = if good { step } else { 0.0 };
            }
            let mut open = false;
            for k in 0..GROUP {
                open |= wanted[k] & !(size[k] < LAST_STEP);
            }
            if !open {
                return;
            }
        }
    }

    /// The fundamentals for these slips, and which of them are valid motions.
    #[inline(always)]
    pub(crate) fn respond(
        &self,
        slips: &Slips,
        accuracy: Accuracy,
        out: &mut GroupResponse,
    ) -> [bool; GROUP] {
        let mut motion = [false; GROUP];
        let mut walks = [[0.0; GROUP]; 8];
        let mut steps = [0.0; GROUP];
        for k in 0..GROUP {
            let at = self.at(k);
            let law = Law::new(&at);
            let mut here = Slip { phase: slips.phase[k], duration: slips.duration[k] };
            let b = law.balance(here);
            let f = law.response(&at, here, &b);
            for (row, z) in out.by.iter_mut().zip([f.by_omega_0, f.by_delta, f.by_x_0, f.by_x_f]) {
                (row[0][k], row[1][k]) = (z.re, z.im);
            }
            (out.value[0][k], out.value[1][k]) = (f.value.re, f.value.im);
            let all = f.value + f.by_omega_0 + f.by_delta + f.by_x_f;
            let finite = (all.re + all.im).abs() < f64::INFINITY;
            let h = law.step();
            steps[k] = here.duration / h - 1e-6;
            motion[k] = law.is_held(here, &b)
                & law.is_precise(f.value * (1.0 / at.x_0), accuracy)
                & (law.newton(&b, &mut here).1 < LAST_STEP)
                & finite
                & (steps[k] < MOST_WALK);
            let w = law.walk(b.steady, b.crest, h);
            for (row, z) in [w.steady, w.free, w.turn, w.fade].into_iter().enumerate() {
                (walks[2 * row][k], walks[2 * row + 1][k]) = (z.re, z.im);
            }
        }
        let mut longest = 0.0f64;
        for k in 0..GROUP {
            longest = if motion[k] { longest.max(steps[k]) } else { longest };
        }
        // The largest speed; it must not be upwards.
        let mut fastest = [f64::NEG_INFINITY; GROUP];
        for step in 1..=longest as u32 {
            let step = f64::from(step);
            for k in 0..GROUP {
                let [s, t, f, g, c, d, l, m] = std::array::from_fn(|row| walks[row][k]);
                let (steady, free) = ([s * c - t * d, s * d + t * c], [f * l - g * m, f * m + g * l]);
                [walks[0][k], walks[1][k]] = steady;
                [walks[2][k], walks[3][k]] = free;
                let v = if step <= steps[k] { steady[1] + free[0] } else { f64::NEG_INFINITY };
                fastest[k] = if v > fastest[k] { v } else { fastest[k] };
            }
        }
        std::array::from_fn(|k| motion[k] & (fastest[k] < 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each single point is compared in `fundamental` with the motion followed from stop to stop.
    #[test]
    fn a_group_is_its_points_one_by_one() {
        let mut compared = 0;
        for delta in [0.03, 0.3, 0.75] {
            for x_f in [0.06, 0.11, 0.15, 0.18] {
                for first in 0..60 {
                    let omega: Row =
                        std::array::from_fn(|k| 1.2 + 0.05 * f64::from(first) + 0.004 * k as f64);
                    let group = Group {
                        omega,
                        omega_0: [3.0; GROUP],
                        detuning: omega.map(|w| w - 3.0),
                        delta: [delta; GROUP],
                        x_0: [0.2; GROUP],
                        x_f: [x_f; GROUP],
                    };
                    let cold = |k: u32| Slip::from_amplitude(&group.at(0), 0.02 * f64::from(k));
                    let one = (0..20).find_map(|k| fundamental(&group.at(0), cold(k)?, Accuracy::Fine));
                    let Some((_, slip)) = one else { continue };
                    let mut slips = Slips { phase: [slip.phase; GROUP], duration: [slip.duration; GROUP] };
                    group.settle(&mut slips, &[true; GROUP]);
                    let zero = [0.0; GROUP];
                    let mut out = GroupResponse { value: [zero; 2], by: [[zero; 2]; 4] };
                    let found = group.respond(&slips, Accuracy::Fine, &mut out);
                    for k in (0..GROUP).filter(|&k| found[k]) {
                        let near = Slip { phase: slips.phase[k], duration: slips.duration[k] };
                        let (f, _) = fundamental(&group.at(k), near, Accuracy::Fine).unwrap();
                        let pairs = [
                            (f.value, out.value, 1e-11),
                            (f.by_omega_0, out.by[0], 1e-8),
                            (f.by_delta, out.by[1], 1e-8),
                            (f.by_x_0, out.by[2], 1e-8),
                            (f.by_x_f, out.by[3], 1e-8),
                        ];
                        for (one, rows, tolerance) in pairs {
                            let error = (Phasor::new(rows[0][k], rows[1][k]) - one).norm() / one.norm();
                            assert!(error < tolerance, "{:?}: {error:e}", group.at(k));
                        }
                        compared += 1;
                    }
                }
            }
        }
        assert!(compared > 500, "{compared}");
    }
}

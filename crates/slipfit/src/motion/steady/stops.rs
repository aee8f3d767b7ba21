//! Symmetric motion with any number of stops: slides in closed form between releases.
//!
//! A stop erases the velocity, so that half a cycle maps one number, the position of the stop, to the next. The fixed
//! point of this map and all quantities derived from it are computed with their derivatives.

use super::Phasor;
use super::closed::Walk;
use super::one_stop::Slip;
use super::response::{Fundamental, Point, Regime};
use crate::numeric::dual::{Dual, Pair};
use std::f64::consts::{PI, TAU};

/// Maximum number of slides in half a cycle.
const MOST_SLIDES: usize = 64;

/// The oscillator with the requested number of derivatives.
struct Law<const N: usize> {
    omega: f64,
    delta: Dual<N>,
    x_0: Dual<N>,
    x_f: Dual<N>,
    omega_d: Dual<N>,
    /// `omega_d - omega`, given separately for accuracy.
    slow: Dual<N>,
    d: Pair<N>,
}

impl<const N: usize> Law<N> {
    fn new(at: &Point) -> Self {
        // With derivatives, these are the first four variables.
        let variable =
            |value: f64, k: usize| if N > k { Dual::variable(value, k) } else { Dual::constant(value) };
        let omega_0 = variable(at.omega_0, 0);
        let delta = variable(at.delta, 1);
        let mut gap = omega_0;
        gap.value = -at.detuning;
        let over = (omega_0 * omega_0).recip();
        let omega = Dual::constant(at.omega);
        let omega_d = ((omega_0 - delta) * (omega_0 + delta)).sqrt();
        Self {
            omega: at.omega,
            delta,
            x_0: variable(at.x_0, 2),
            x_f: variable(at.x_f, 3),
            omega_d,
            slow: gap - delta * delta * (omega_0 + omega_d).recip(),
            d: Pair::new(gap * (omega_0 + omega) * over, (delta * over).scale(2.0 * at.omega)),
        }
    }

    fn slide(&self, x: Dual<N>, phase: Dual<N>, direction: f64) -> Slide<'_, N> {
        let (s, c) = phase.sin_cos();
        let crest = Pair::new(c, s);
        let steady = crest.times(self.x_0) * self.d.recip();
        let centre = self.x_f.scale(-direction);
        let a = x - centre - steady.re;
        let b = (self.delta * a + steady.im.scale(self.omega)) * self.omega_d.recip();
        Slide {
            law: self,
            centre,
            crest,
            steady,
            a,
            b,
            big_a: self.omega_d * b - self.delta * a,
            big_b: -(self.omega_d * a + self.delta * b),
        }
    }
}

/// Motion in one direction, from rest.
struct Slide<'a, const N: usize> {
    law: &'a Law<N>,
    centre: Dual<N>,
    /// `e^(i phase)` at its start.
    crest: Pair<N>,
    steady: Pair<N>,
    a: Dual<N>,
    b: Dual<N>,
    big_a: Dual<N>,
    big_b: Dual<N>,
}

impl<const N: usize> Slide<'_, N> {
    /// Speed and its rate at the time `u` after the start.
    fn speed(&self, u: f64) -> (f64, f64) {
        let l = self.law;
        let (s, c) = (l.omega * u).sin_cos();
        let (sd, cd) = (l.omega_d.value * u).sin_cos();
        let e = (-l.delta.value * u).exp();
        let (re, im) = (self.steady.re.value, self.steady.im.value);
        let (a, b, w, delta) = (self.big_a.value, self.big_b.value, l.omega_d.value, l.delta.value);
        (
            -l.omega * (re * s + im * c) + e * (a * cd + b * sd),
            -l.omega * l.omega * (re * c - im * s)
                + e * ((w * b - delta * a) * cd - (w * a + delta * b) * sd),
        )
    }

    /// Position and speed at the time `u` after the start.
    fn at(&self, u: Dual<N>) -> (Dual<N>, Dual<N>) {
        let l = self.law;
        let (s, c) = u.scale(l.omega).sin_cos();
        let here = self.steady * Pair::new(c, s);
        let (sd, cd) = (l.omega_d * u).sin_cos();
        let e = (-(l.delta * u)).exp();
        (
            self.centre + here.re + e * (self.a * cd + self.b * sd),
            here.im.scale(-l.omega) + e * (self.big_a * cd + self.big_b * sd),
        )
    }

    /// Time at which the speed is zero again, with derivatives; `None` if not within `longest`.
    fn duration(&self, direction: f64, longest: f64) -> Option<Dual<N>> {
        let l = self.law;
        let step = (PI / l.omega).min(PI / l.omega_d.value) / 12.0;
        let steady = Phasor::new(self.steady.re.value, self.steady.im.value) * -l.omega;
        let free = Phasor::new(self.big_a.value, self.big_b.value);
        let mut walk = Walk::new([l.omega, l.omega_d.value, l.delta.value], step, steady, free);
        // Within the first step it may not have moved yet.
        walk.step();
        let mut high = 2.0 * step;
        while walk.step() * direction > 0.0 {
            high += step;
            if high > longest + 2.0 * step {
                return None;
            }
        }
        let mut low = high - step;
        let mut u = 0.5 * (low + high);
        for _ in 0..60 {
            let (v, rate) = self.speed(u);
            if v * direction > 0.0 {
                low = u;
            } else {
                high = u;
            }
            let next = u - v / rate;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let moved = (next - u).abs();
            u = next;
            // The step after such a small one would only change the rounding.
            if moved < 1e-9 * u {
                break;
            }
        }
        if N == 0 {
            return Some(Dual::constant(u));
        }
        // du = -dv/v'.
        let slope = self.speed(u).1;
        let v = self.at(Dual::constant(u)).1;
        Some(Dual { value: u, d: v.d.map(|d| -d / slope) })
    }

    /// `e^(-i phase) ∫ v e^(-i omega u) du`.
    fn share(&self, u: Dual<N>) -> Pair<N> {
        let l = self.law;
        let v = self.steady.turned().scale(l.omega);
        let zero = Dual::constant(0.0);
        let back = Pair::new(zero, u.scale(-2.0 * l.omega));
        let steady = (v + v.conj() * back.exp_quotient()).times(u).scale(0.5);
        let own = Pair::new(self.big_a, -self.big_b).scale(0.5);
        let fade = -(l.delta * u);
        let forward = Pair::new(fade, l.slow * u);
        let backward = Pair::new(fade, -((l.omega_d + Dual::constant(l.omega)) * u));
        let free = (own * forward.exp_quotient() + own.conj() * backward.exp_quotient()).times(u);
        (steady + free) * self.crest.conj()
    }
}

/// Half a cycle: final stop position, fundamental, number of slides, and phase of the last release after the first.
struct Half<const N: usize> {
    end: Dual<N>,
    fundamental: Pair<N>,
    slides: usize,
    turned: f64,
    /// Duration of the last slide, s.
    duration: f64,
}

/// Motion from the downward release at `x` to the next upward release.
fn half<const N: usize>(law: &Law<N>, x: Dual<N>) -> Option<Half<N>> {
    let over = law.x_0.recip();
    let begin = acos((x - law.x_f) * over)?;
    let (mut x, mut phase, mut direction) = (x, begin, -1.0);
    let zero = Dual::constant(0.0);
    let mut sum = Pair::new(zero, zero);
    for slides in 1..=MOST_SLIDES {
        let slide = law.slide(x, phase, direction);
        let u = slide.duration(direction, TAU / law.omega)?;
        sum = sum + slide.share(u);
        x = slide.at(u).0;
        phase = phase + u.scale(law.omega);
        let force = law.x_0.value * phase.value.cos() - x.value;
        if force.abs() > law.x_f.value {
            direction = force.signum();
            continue;
        }
        // Held until the force leaves the zone: falling through -x_F or rising through x_F.
        let down = acos((x - law.x_f) * over).map(|a| after(a, phase.value));
        let up = acos((x + law.x_f) * over).map(|a| after(-a, phase.value));
        let (release, next) = match (down, up) {
            (Some(d), Some(u)) if d.value < u.value => (d, -1.0),
            (_, Some(u)) => (u, 1.0),
            (Some(d), None) => (d, -1.0),
            (None, None) => return None,
        };
        (phase, direction) = (release, next);
        if direction > 0.0 {
            let fundamental = sum.turned().scale(-2.0 / PI);
            return Some(Half {
                end: x,
                fundamental,
                slides,
                turned: phase.value - begin.value,
                duration: u.value,
            });
        }
    }
    None
}

fn acos<const N: usize>(level: Dual<N>) -> Option<Dual<N>> {
    let root = (1.0 - level.value * level.value).sqrt();
    if !(root > 0.0) {
        return None;
    }
    Some(Dual { value: level.value.acos(), d: level.d.map(|d| -d / root) })
}

/// The same angle plus full turns, such that it lies after `phase`.
fn after<const N: usize>(mut angle: Dual<N>, phase: f64) -> Dual<N> {
    // A release right at the stop may lie before it by rounding.
    angle.value += TAU * ((phase - 1e-12 - angle.value) / TAU).ceil();
    angle
}

/// The fundamental of a symmetric motion with stops, if there is one; `guess` is a start value for the amplitude.
/// With one stop, the slip is returned as a start value for a neighbouring frequency. The number of slides computed
/// is added to `count`.
pub(super) fn fundamental(at: &Point, guess: f64, count: &mut u64) -> Option<(Fundamental, Option<Slip>)> {
    let plain = Law::<0>::new(at);
    let (low, high) = (at.x_f - at.x_0, at.x_f + at.x_0);
    let margin = 1e-9 * at.x_0;
    let inside = |x: f64| x.clamp(low + margin, high - margin);
    let mut map = |x: f64| {
        let half = half(&plain, Dual::constant(x));
        // A half cycle that does not end counts as the maximum number of slides.
        *count += half.as_ref().map_or(MOST_SLIDES, |h| h.slides) as u64;
        half.map(|h| -h.end.value)
    };
    // X = -end(X), by secant steps from one iteration of the map.
    let mut x0 = inside(if guess > 0.0 { guess } else { at.x_0 });
    let mut g0 = map(x0)? - x0;
    let mut x = inside(x0 + g0);
    let mut best = (g0.abs(), x0);
    for _ in 0..50 {
        let g = map(x)? - x;
        if g.abs() < best.0 {
            best = (g.abs(), x);
        }
        if g.abs() < 1e-15 * at.x_0 || x == x0 {
            break;
        }
        let slope = (g - g0) / (x - x0);
        let mut next = if slope.abs() > 1e-6 { x - g / slope } else { x + g };
        if !(next.is_finite() && (next - x).abs() < at.x_0) {
            next = x + g;
        }
        (x0, g0, x) = (x, g, inside(next));
    }
    let (gap, x) = best;
    if gap > 1e-9 * at.x_0 {
        return None;
    }
    let law = Law::<5>::new(at);
    let h = half(&law, Dual::variable(x, 4))?;
    if (h.turned - PI).abs() > 1e-6 {
        return None;
    }
    // dx/d(parameters) from x + end(x) = 0.
    let gain = -1.0 / (1.0 + h.end.d[4]);
    let mut out =
        Pair::<4>::new(Dual::constant(h.fundamental.re.value), Dual::constant(h.fundamental.im.value));
    for i in 0..4 {
        let x_i = gain * h.end.d[i];
        out.re.d[i] = h.fundamental.re.d[i] + h.fundamental.re.d[4] * x_i;
        out.im.d[i] = h.fundamental.im.d[i] + h.fundamental.im.d[4] * x_i;
    }
    let regime = if h.slides == 1 { Regime::OneStop } else { Regime::ManyStops };
    let f = Fundamental::of_pair(&out, regime);
    let all = [f.value, f.by_omega_0, f.by_delta, f.by_x_0, f.by_x_f];
    let slip = (h.slides == 1).then(|| Slip::new(((x - at.x_f) / at.x_0).acos(), h.duration));
    all.iter().all(|z| z.re.is_finite() && z.im.is_finite()).then_some((f, slip))
}

//! The exact free decay.

use crate::error::Error;
use crate::model::oscillator::{Oscillator, finite, moderate};
use crate::numeric::double_double::{self as dd, Dd};

/// Half cycles up to which `(n + 1/2) T` is formed without rounding.
pub(super) const COUNTABLE: f64 = 6e7;

/// Free decay with viscous and sliding friction, in closed form.
///
/// Between two turning points the friction force is constant, so the motion is a damped cosine about `± x_F`. With
/// `omega_d² = omega_0² - delta²`, half period `T = pi/omega_d` and `lambda = delta T`, a turning point at `X` is
/// followed after `T` by
///
/// ```text
/// X' = -sgn(X) [e^-lambda |X| - (1 + e^-lambda) x_F]
/// |X_n| = |X_0| e^(-n lambda) - x_F coth(lambda/2) (1 - e^(-n lambda))
/// ```
///
/// until `|X_n| <= F_s/k`, where the mass stays. The frequency is `omega_d` at every amplitude. Eq. (16) of Vitorino,
/// Vieira and Rodrigues approximates this motion; see [`averaged`](super::averaged).
///
/// The motion may start from any state: a start in motion is followed to its first turning point by the same closed
/// form. Turning points are counted from there; for a start at rest, the release itself is number 0.
///
/// Rounding errors stay below 1e-14 of the initial amplitude after ten thousand half cycles, because phases are
/// reduced in double-double precision.
///
/// ```
/// # use slipfit::{Oscillator, motion::decay::FreeDecay};
/// let sliding_only = Oscillator::kinematic(1.0, 0.0, 0.5)?;
/// let decay = FreeDecay::from_rest(&sliding_only, 9.8)?;
/// assert_eq!(decay.turning_point(1).position, -8.8); // each half cycle takes 2 x_F
/// let stop = decay.stop().expect("sliding friction stops it");
/// assert_eq!(stop.index, 10);
/// assert!((stop.position + 0.2).abs() < 1e-14 || (stop.position - 0.2).abs() < 1e-14);
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeDecay {
    oscillator: Oscillator,
    start: TurningPoint,
    start_velocity: f64,
    /// Time from the start to the first turning point, if the start is in motion.
    lead_in: f64,
    first: f64,
    pub(super) first_time: Dd,
    pub(super) half_period: Dd,
    pub(super) lambda: f64,
    /// The decay offset `C`.
    offset: f64,
    /// `|X_0| + C`, the quantity that decays exponentially; infinite without viscous damping.
    span: f64,
    stop: Option<Stop>,
}

/// A turning point of a free decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningPoint {
    /// Number of the turning point; the first is 0.
    pub index: u64,
    /// Time, s.
    pub time_s: f64,
    /// Position, with its sign.
    pub position: f64,
}

/// End of a free decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Number of the turning point at which the mass stays.
    pub index: u64,
    /// Time, s.
    pub time_s: f64,
    /// The remaining offset, `|position| <= F_s/k`.
    pub position: f64,
}

/// Energy lost between two turning points, over the stiffness.
///
/// Multiply by `k` for joules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfCycleLoss {
    /// Energy lost to viscous damping, over the stiffness.
    pub viscous: f64,
    /// Energy lost to sliding friction, over the stiffness.
    pub sliding: f64,
}

impl FreeDecay {
    /// Decay from rest at `position` at time zero.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `position` is not finite.
    pub fn from_rest(oscillator: &Oscillator, position: f64) -> Result<Self, Error> {
        Self::from_state(oscillator, 0.0, position, 0.0)
    }

    /// Decay from any state: `position` and `velocity` (per s) at `time_s`.
    ///
    /// # Errors
    /// [`Error::Parameter`] if an argument is not finite, or larger than 1e100.
    pub fn from_state(
        oscillator: &Oscillator,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        finite("time_s", time_s)?;
        moderate("position", position)?;
        moderate("velocity", velocity)?;
        moderate("velocity / omega_0", velocity / oscillator.omega_0())?;
        let (omega_0, delta) = (oscillator.omega_0(), oscillator.decay_rate_per_s());
        let omega_d = Dd::root_of_difference_of_squares(omega_0, delta);
        let half_period = dd::PI.div(omega_d);
        let lambda = half_period.scale(delta).value();
        let (mut lead_in, mut first) = (0.0, position);
        if velocity != 0.0 {
            let s = velocity.signum();
            let x_f = oscillator.friction_displacement();
            let (w, y) = (omega_d.hi, position + s * x_f);
            // The velocity varies as e^(-delta u) cos(theta + omega_d u): its next zero.
            lead_in = f64::atan2(w * velocity * s, (omega_0 * omega_0 * y + delta * velocity) * s) / w;
            let amplitude = f64::hypot(velocity + delta * y, w * y) / omega_0;
            first = s * ((-delta * lead_in).exp() * amplitude - x_f);
        }
        let mut decay = Self {
            oscillator: *oscillator,
            start: TurningPoint { index: 0, time_s, position },
            start_velocity: velocity,
            lead_in,
            first,
            first_time: dd::two_sum(time_s, lead_in),
            half_period,
            lambda,
            offset: oscillator.decay_offset(),
            span: first.abs() + oscillator.decay_offset(),
            stop: None,
        };
        decay.stop = decay.find_stop();
        Ok(decay)
    }

    /// The oscillator.
    pub fn oscillator(&self) -> &Oscillator {
        &self.oscillator
    }

    /// Amplitude of turning point `n` without a stop: `|X_n|` before the stop, meaningless (and eventually negative)
    /// after it.
    #[inline(always)]
    pub(super) fn amplitude(&self, n: f64) -> f64 {
        let x_f = self.oscillator.friction_displacement();
        let first = self.first.abs();
        // Below this, e^(-n lambda) is 1 for every n that can be counted.
        if self.lambda < 1e-40 {
            return first - 2.0 * n * x_f;
        }
        // The form that does not subtract numbers larger than the result's parts is used: if the offset is small, the
        // first form keeps its relative accuracy at the end of the decay.
        if self.offset < first {
            (-n * self.lambda).exp() * self.span - self.offset
        } else {
            first + (-n * self.lambda).exp_m1() * self.span
        }
    }

    /// Sign of the position at turning point `n`.
    #[inline(always)]
    pub(super) fn sign(&self, n: f64) -> f64 {
        // 0 or 1, also for very large integers.
        let odd = n - 2.0 * (0.5 * n).floor();
        if odd == 0.0 { self.first.signum() } else { -self.first.signum() }
    }

    /// Turning point `n`, without computing those before it; beyond the stop, the stop itself (with its own index).
    pub fn turning_point(&self, n: u64) -> TurningPoint {
        let n = self.stop.map_or(n, |s| n.min(s.index));
        let sign = if n.is_multiple_of(2) { self.first.signum() } else { -self.first.signum() };
        TurningPoint {
            index: n,
            time_s: self.first_time.add(self.half_period.scale(n as f64)).value(),
            // If the motion stops at its first turning point, that point keeps its own sign.
            position: if n == 0 { self.first } else { sign * self.amplitude(n as f64) },
        }
    }

    /// All turning points in order. The last is the stop; without a stop the sequence is endless.
    pub fn turning_points(&self) -> TurningPoints {
        TurningPoints {
            next: self.first,
            index: 0,
            count: 0.0,
            // Beyond 2^53 their indices could not be distinguished.
            last: self.stop.map_or(1 << 53, |s| s.index),
            keep: (-self.lambda).exp(),
            loss: (1.0 + (-self.lambda).exp()) * self.oscillator.friction_displacement(),
            thirds: self.half_period.thirds(),
            decay: *self,
            done: false,
        }
    }

    /// Where the motion ends: the first turning point with `|X_n| <= F_s/k`.
    ///
    /// `None` if it never does (no sliding friction), or not within 2^53 half cycles.
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }

    fn find_stop(&self) -> Option<Stop> {
        let x_s = self.oscillator.static_displacement();
        let first = self.first.abs();
        let at = |n: f64| Stop {
            index: n as u64,
            time_s: self.first_time.add(self.half_period.scale(n)).value(),
            position: if n == 0.0 { self.first } else { self.sign(n) * self.amplitude(n) },
        };
        if first <= x_s {
            return Some(at(0.0));
        }
        if x_s == 0.0 {
            return None;
        }
        // (|X_0| + C) e^(-n lambda) = x_S + C, with c = lambda C finite as lambda -> 0.
        let x_f = self.oscillator.friction_displacement();
        let (l, over) = (self.lambda, first - x_s);
        let n = if l < 1e-40 {
            over / (2.0 * x_f)
        } else {
            let c = x_f * l / (0.5 * l).tanh();
            (l * over / (l * x_s + c)).ln_1p() / l
        };
        let mut n = n.ceil();
        if n.is_nan() || n > 9e15 {
            return None;
        }
        // Rounding may shift the index by one; the turning points themselves decide. The limit on the count only
        // guards against an endless loop.
        let mut left = 10_000;
        while n > 1.0 && self.amplitude(n - 1.0) <= x_s && left > 0 {
            n -= 1.0;
            left -= 1;
        }
        n = n.max(1.0);
        while self.amplitude(n) > x_s && left > 0 {
            n += 1.0;
            left -= 1;
        }
        Some(at(n))
    }

    /// Displacement and velocity at `time_s`; before the start, the start position at rest; after the stop, the
    /// position at which the mass rests.
    pub fn state(&self, time_s: f64) -> (f64, f64) {
        let since = Dd::from_f64(time_s).sub(self.first_time);
        if since.hi < 0.0 || time_s < self.start.time_s {
            return self.lead_in_state(time_s);
        }
        if let Some(stop) = self.stop
            && time_s >= stop.time_s
        {
            return (stop.position, 0.0);
        }
        let (n, u) = self.half_cycle(since);
        let sign = self.sign(n);
        let x_f = self.oscillator.friction_displacement();
        let (a, omega_0) = (self.amplitude(n) - x_f, self.oscillator.omega_0());
        let (w, delta) = (self.oscillator.omega_d(), self.oscillator.decay_rate_per_s());
        let (sin, cos) = (w * u).sin_cos();
        let e = (-delta * u).exp();
        (sign * (x_f + a * e * (cos + delta / w * sin)), -sign * a * e * (omega_0 * (omega_0 / w)) * sin)
    }

    /// Number of the half cycle and the time since its beginning.
    fn half_cycle(&self, since: Dd) -> (f64, f64) {
        let mut n = (since.hi / self.half_period.hi).floor();
        if let Some(stop) = self.stop {
            n = n.min(stop.index as f64 - 1.0);
        }
        n = n.max(0.0);
        (n, since.sub(self.half_period.scale(n)).value())
    }

    pub(super) fn lead_in_state(&self, time_s: f64) -> (f64, f64) {
        let u = time_s - self.start.time_s;
        let (x, v) = (self.start.position, self.start_velocity);
        if v == 0.0 || u < 0.0 || u.is_nan() {
            return (x, 0.0);
        }
        let (omega_0, delta) = (self.oscillator.omega_0(), self.oscillator.decay_rate_per_s());
        let (w, c) = (self.oscillator.omega_d(), -v.signum() * self.oscillator.friction_displacement());
        let y = x - c;
        let (sin, cos) = (w * u).sin_cos();
        let e = (-delta * u).exp();
        let sin = sin / w;
        (c + e * (y * cos + (v + delta * y) * sin), e * (v * cos - (delta * v + omega_0 * omega_0 * y) * sin))
    }

    /// Displacement at `time_s`; see [`FreeDecay::state`].
    pub fn displacement(&self, time_s: f64) -> f64 {
        self.state(time_s).0
    }

    /// Velocity at `time_s`, per s; see [`FreeDecay::state`].
    pub fn velocity(&self, time_s: f64) -> f64 {
        self.state(time_s).1
    }

    /// Energy lost from turning point `n` to the next, over the stiffness, split into the two losses:
    /// `x_F (|X_n| + |X_n+1|)` to sliding friction, the rest of `(X_n² - X_n+1²)/2` to viscous damping. Zero after
    /// the stop.
    pub fn loss(&self, n: u64) -> HalfCycleLoss {
        if self.stop.is_some_and(|s| n >= s.index) {
            return HalfCycleLoss { viscous: 0.0, sliding: 0.0 };
        }
        let x_f = self.oscillator.friction_displacement();
        let a = self.amplitude(n as f64);
        let fall = -(-self.lambda).exp_m1();
        // The last half cycle may end on the same side on which it began: b keeps its sign.
        let b = (1.0 - fall) * a - (2.0 - fall) * x_f;
        HalfCycleLoss { viscous: 0.5 * (a + b) * fall * (a - x_f), sliding: x_f * (a + b) }
    }
}

/// Iterator over the turning points of a [`FreeDecay`], with one multiplication per point.
///
/// Rounding errors grow to about `n` times 1e-16 of the amplitude at turning point `n`; [`FreeDecay::turning_point`]
/// has no such growth.
#[derive(Debug, Clone)]
pub struct TurningPoints {
    decay: FreeDecay,
    next: f64,
    index: u64,
    /// The index as a float, from which the time is computed.
    count: f64,
    last: u64,
    keep: f64,
    loss: f64,
    /// The half period in pieces whose multiples are exact.
    thirds: [f64; 3],
    done: bool,
}

impl Iterator for TurningPoints {
    type Item = TurningPoint;

    #[inline]
    fn next(&mut self) -> Option<TurningPoint> {
        if self.done {
            return None;
        }
        let d = &self.decay;
        if self.index == self.last {
            self.done = true;
            return d.stop.map(|s| TurningPoint { index: s.index, time_s: s.time_s, position: s.position });
        }
        let n = self.count;
        let time_s = if n < COUNTABLE {
            let [a, b, c] = self.thirds;
            let sum = dd::two_sum(d.first_time.hi, n * a);
            sum.hi + (n * b + (sum.lo + (d.first_time.lo + n * c)))
        } else {
            d.first_time.add(d.half_period.scale(n)).value()
        };
        let point = TurningPoint { index: self.index, time_s, position: self.next };
        self.next = -(self.keep * self.next - self.loss.copysign(self.next));
        self.index += 1;
        self.count += 1.0;
        // Without sliding friction there is no stop; underflow ends the sequence.
        self.done = self.next == 0.0;
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_decay() -> impl Strategy<Value = FreeDecay> {
        let loss = prop_oneof![Just(f64::INFINITY), 0.6..5.0f64, (0.0..7.0f64).prop_map(|e| 10f64.powf(e))];
        let friction = prop_oneof![Just(0.0), 1e-4..0.3f64];
        (0.1..50.0f64, loss, friction, 1.0..1.5f64, -2.0..2.0f64, -2.0..2.0f64, any::<bool>()).prop_map(
            |(omega_0, q, x_f, ratio, x, v, rest)| {
                let o = Oscillator::builder()
                    .omega_0(omega_0)
                    .q_factor(q.max(0.6))
                    .friction_displacement(x_f)
                    .static_displacement(x_f * ratio)
                    .build()
                    .unwrap();
                FreeDecay::from_state(&o, -3.0, x, if rest { 0.0 } else { v * omega_0 }).unwrap()
            },
        )
    }

    proptest! {
        #[test]
        fn the_closed_form_of_turning_points_equals_the_map_iterated(decay in any_decay()) {
            for p in decay.turning_points().take(200) {
                let q = decay.turning_point(p.index);
                prop_assert!((p.position - q.position).abs() < 1e-13 * 4.0, "{p:?} {q:?}");
                prop_assert_eq!(p.time_s, q.time_s);
            }
        }

        #[test]
        fn motion_is_continuous_and_turns_where_it_says(decay in any_decay()) {
            let h = 1e-6 / decay.oscillator().omega_0();
            let scale = 4.0 * decay.oscillator().omega_0();
            for p in decay.turning_points().take(20) {
                for t in [p.time_s - h, p.time_s, p.time_s + h] {
                    let (x, v) = decay.state(t);
                    prop_assert!((x - p.position).abs() < 1e-10, "{x} {p:?}");
                    prop_assert!(v.abs() < 1e-5 * scale);
                }
            }
        }

        #[test]
        fn the_stop_is_the_first_turning_point_inside_the_zone(decay in any_decay()) {
            let x_s = decay.oscillator().static_displacement();
            if let Some(stop) = decay.stop() {
                prop_assert!(stop.position.abs() <= x_s);
                if stop.index > 0 {
                    prop_assert!(decay.turning_point(stop.index - 1).position.abs() > x_s);
                }
                prop_assert_eq!(decay.state(stop.time_s + 1.0), (stop.position, 0.0));
            } else {
                prop_assert_eq!(x_s, 0.0);
            }
        }

        #[test]
        fn velocity_is_the_slope_and_the_equation_holds(decay in any_decay(), phase in 0.05..30.0f64) {
            let o = *decay.oscillator();
            let (t, h) = (-3.0 + phase / o.omega_0(), 1e-4 / o.omega_0());
            // Keep away from kinks, so that the three points lie in one half cycle.
            let near = decay.turning_points().take(40).any(|p| (p.time_s - t).abs() < 3.0 * h);
            prop_assume!(!near);
            let (x, v) = decay.state(t);
            let ((xl, vl), (xr, vr)) = (decay.state(t - h), decay.state(t + h));
            let (w, scale) = (o.omega_0(), 4.0);
            prop_assert!(((xr - xl) / (2.0 * h) - v).abs() < 1e-7 * scale * w);
            if v != 0.0 {
                let a = -2.0 * o.decay_rate_per_s() * v - w * w * (x + o.friction_displacement() * v.signum());
                prop_assert!(((vr - vl) / (2.0 * h) - a).abs() < 1e-6 * scale * w * w);
            }
        }

        #[test]
        fn the_energy_lost_is_the_energy_missing(decay in any_decay()) {
            for p in decay.turning_points().take(30) {
                let next = decay.turning_point(p.index + 1);
                let loss = decay.loss(p.index);
                prop_assert!(loss.viscous >= 0.0, "{loss:?}");
                prop_assert!(loss.sliding >= 0.0, "{loss:?}");
                let missing = 0.5 * (p.position * p.position - next.position * next.position);
                prop_assert!((loss.viscous + loss.sliding - missing).abs() < 1e-12, "{loss:?} {missing}");
            }
        }
    }

    #[test]
    fn ten_thousand_half_cycles_lose_exactly_two_x_f_each() {
        let o = Oscillator::kinematic(1.0, 0.0, 1e-5).unwrap();
        let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
        assert!((decay.turning_point(10_000).position - 0.8).abs() < 1e-15);
        let nearly = Oscillator::kinematic(1.0, 1e-18, 1e-5).unwrap();
        let nearly = FreeDecay::from_rest(&nearly, 1.0).unwrap();
        assert!((nearly.turning_point(10_000).position - 0.8).abs() < 1e-13);
    }

    #[test]
    fn the_faintest_friction_stops_where_its_logarithm_says() {
        for (delta, x_f) in [(1e-12, 5e-27), (1e-3, 1e-25), (0.1, 1e-200), (1e-9, 1e-18), (0.0, 1e-14)] {
            let o = Oscillator::kinematic(1.0, delta, x_f).unwrap();
            let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
            let stop = decay.stop().unwrap();
            assert!(stop.position.abs() <= x_f);
            let lambda = o.half_cycle_decrement();
            let offset = o.decay_offset();
            let expected = if delta == 0.0 { 0.5 / x_f } else { (1.0 / (offset + x_f)).ln_1p() / lambda };
            assert!((stop.index as f64 / expected - 1.0).abs() < 0.01, "{stop:?} {expected}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_refused() {
        let o = Oscillator::kinematic(1.0, 0.1, 0.1).unwrap();
        assert!(FreeDecay::from_rest(&o, f64::NAN).is_err());
        assert!(FreeDecay::from_state(&o, f64::INFINITY, 1.0, 0.0).is_err());
        assert!(FreeDecay::from_state(&o, 0.0, 1.0, 1e300).is_err());
    }
}

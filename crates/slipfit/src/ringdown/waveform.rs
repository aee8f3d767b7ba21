//! Every sample against the exact motion, as a least-squares problem.
//!
//! The sums over the samples are those of the [half-cycle kernel](crate::motion::decay::half_cycle).

use super::gathered::Gathered;
use crate::inference::least_squares::{LeastSquares, Normal};
use crate::motion::decay::closed_sums;
use crate::motion::decay::parameters::{A0, DELTA, X_F, law_of, shapes_exist};
use crate::motion::decay::window::Window;
use nalgebra::DVector;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

pub(crate) use crate::motion::decay::parameters::{BEND, CHIRP, COUNT, OFFSET, OMEGA, PHASE};
pub(crate) use crate::motion::decay::window::{Bend, Observable};

/// Parameters of the phase, in the order of [`Window::phase`].
pub(crate) const PHASE_SLOTS: [usize; 4] = [PHASE, OMEGA, BEND, CHIRP];

/// Samples of one window and the shape of the model.
#[derive(Debug, Clone)]
pub(crate) struct Waveform<'a> {
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    pub(crate) observable: Observable,
    /// Samples closer to a turn than this, rad, do not count: friction makes an acceleration jump there.
    pub(crate) guard: f64,
    /// Start of the window, s; parameters refer to it.
    pub(crate) origin: f64,
    pub(crate) duration: f64,
    /// Shape of the backbone; `None` leaves [`BEND`] without effect.
    pub(crate) bend: Option<Bend>,
    pub(crate) rest: RestLevel,
    /// Parameters whose derivatives are wanted.
    pub(crate) active: Vec<usize>,
    /// Sums near a reference motion, where they were gathered.
    pub(crate) gathered: Option<Arc<Gathered>>,
}

/// The parameters of the closed motion, in the order of its sums.
const CLOSED: [usize; 6] = [A0, X_F, DELTA, PHASE, OMEGA, OFFSET];

/// What the level of the samples at rest says of the motion before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RestLevel {
    /// It tells which swing was the last.
    Exact,
    /// It lies anywhere within `±x_F`: its derivative by the loss holds over no step that a fit could
    /// take.
    Bounded,
    /// Nothing: the offset wanders.
    Free,
}

/// Whether friction of this displacement leaves the mass at a place that tells the last swing:
/// swings end `2 x_F` apart, and the last one is known to some three standard errors of an
/// amplitude from all `n` samples shared by six parameters.
pub(crate) fn rest_tells(x_f: f64, noise_rms: f64, n: usize) -> bool {
    x_f > 8.0 * noise_rms * (12.0 / n.max(1) as f64).sqrt()
}

impl Waveform<'_> {
    /// Whether the samples at rest tell where: velocities and accelerations are zero there.
    fn at_rest_somewhere(&self) -> bool {
        self.observable == Observable::Displacement
    }

    fn window<'a>(&'a self, active: &'a [usize]) -> Window<'a> {
        Window {
            time: self.time,
            signal: self.signal,
            observable: self.observable,
            guard: self.guard,
            origin: self.origin,
            duration: self.duration,
            bend: self.bend.as_ref(),
            rest_tells: self.rest == RestLevel::Exact && self.at_rest_somewhere(),
            active,
        }
    }

    /// Sums of the `active` parameters and residuals; `false` where the model does not exist.
    fn pass(
        &self,
        p: &[f64],
        active: &[usize],
        out: &mut Normal,
        mut residuals: Option<&mut Vec<f64>>,
    ) -> bool {
        if residuals.is_none()
            && let Some(at_rest) = self.closed_pass(p, active, out)
        {
            if self.rest != RestLevel::Exact && at_rest < self.time.len() {
                self.level_of_rest(p, active, at_rest, out, None);
            }
            return out.rss.is_finite();
        }
        let found = self.window(active).sums(p, residuals.as_deref_mut());
        let Some((sums, at_rest)) = found else { return false };
        let n = active.len();
        for (i, &a) in active.iter().enumerate() {
            out.jtr[a] = sums.total(n, i);
            for (j, &b) in active[..=i].iter().enumerate() {
                out.jtj[(a.max(b), a.min(b))] = sums.total(i, j);
            }
        }
        out.rss = sums.total(n, n);
        if self.rest != RestLevel::Exact && self.at_rest_somewhere() && at_rest < self.time.len() {
            self.level_of_rest(p, active, at_rest, out, residuals);
        }
        out.rss.is_finite()
    }

    /// The same problem with its sums gathered about a motion near its minimum, where they can be.
    pub(crate) fn gathered_about(self, p: &[f64]) -> Self {
        let gathered = Gathered::about(&self.window(&self.active), p).map(Arc::new);
        Self { gathered, ..self }
    }

    /// The sums near the motion about which they were gathered; whether they could be had.
    fn gathered_pass(&self, gathered: &Gathered, p: &[f64], free: &[usize], out: &mut Normal) -> bool {
        let sums = |from: usize, from_s: f64, p: &[f64], active: &[usize], out: &mut Normal| {
            let (time, signal) = (&self.time[from..], &self.signal[from..]);
            let origin = self.origin + from_s;
            let behind = Waveform {
                time,
                signal,
                observable: self.observable,
                guard: self.guard,
                origin,
                duration: self.duration,
                bend: None,
                rest: self.rest,
                active: Vec::new(),
                gathered: None,
            };
            behind.pass(p, active, out, None)
        };
        gathered.normal_of(p, free, out, &sums).is_some()
    }

    /// The same problem, every sum taken sample by sample.
    pub(crate) fn exact(&self) -> Self {
        Self { gathered: None, ..self.clone() }
    }

    /// The sums where viscous and sliding loss act alone on a phase and an offset without disturbances, and the first
    /// sample at rest; `None` elsewhere.
    fn closed_pass(&self, p: &[f64], active: &[usize], out: &mut Normal) -> Option<usize> {
        let others = p.iter().enumerate().filter(|(k, _)| !CLOSED.contains(k));
        if self.observable != Observable::Displacement
            || !active.iter().all(|k| CLOSED.contains(k))
            || others.into_iter().any(|(_, v)| *v != 0.0)
        {
            return None;
        }
        let (time, signal, origin) = (self.time, self.signal, self.origin);
        let (p, rest_tells) = (&CLOSED.map(|k| p[k]), self.rest == RestLevel::Exact);
        let pass = closed_sums::Pass { time, signal, origin, p, stops: true, rest_tells };
        let sums = crate::numeric::dispatch(pass)?;
        for (i, &a) in CLOSED.iter().enumerate().filter(|(_, a)| active.contains(a)) {
            out.jtr[a] = sums.jtr[i];
            for (j, &b) in CLOSED[..=i].iter().enumerate().filter(|(_, b)| active.contains(b)) {
                out.jtj[(a, b)] = sums.jtj[i][j];
            }
        }
        out.rss = sums.rss;
        Some(sums.at_rest)
    }

    /// Gives the samples at rest a level of their own: their sums with the mean of what is left of
    /// them, or with `±x_F` where the level is bounded and that mean lies beyond.
    fn level_of_rest(
        &self,
        p: &[f64],
        active: &[usize],
        from: usize,
        out: &mut Normal,
        residuals: Option<&mut Vec<f64>>,
    ) {
        let inverse_duration = 1.0 / self.duration.max(f64::MIN_POSITIVE);
        let (mut sums, mut left) = ([0.0; 3], 0.0);
        for (t, x) in self.time[from..].iter().zip(&self.signal[from..]) {
            let v = (t - self.origin) * inverse_duration;
            let powers = [1.0, v, v * v];
            left += x - powers.iter().zip(&p[OFFSET..]).map(|(v, c)| v * c).sum::<f64>();
            sums.iter_mut().zip(powers).for_each(|(s, v)| *s += v);
        }
        let n = (self.time.len() - from) as f64;
        let x_f = p[X_F].max(0.0);
        let most = if self.rest == RestLevel::Free { f64::INFINITY } else { x_f };
        let level = (left / n).clamp(-most, most);
        let offsets = || active.iter().copied().filter(|i| (OFFSET..OFFSET + 3).contains(i));
        for i in offsets() {
            out.jtr[i] -= sums[i - OFFSET] * level;
        }
        if level == left / n {
            for i in offsets() {
                for j in offsets().filter(|j| *j <= i) {
                    out.jtj[(i, j)] -= sums[i - OFFSET] * sums[j - OFFSET] / n;
                }
            }
        } else if active.contains(&X_F) {
            let sign = left.signum();
            out.jtr[X_F] += sign * (left - n * level);
            out.jtj[(X_F, X_F)] += n;
            for i in offsets() {
                out.jtj[(i.max(X_F), i.min(X_F))] += sign * sums[i - OFFSET];
            }
        }
        // Of exact samples the difference is all rounding, of either sign.
        let rounding = f64::EPSILON.powi(2) * n * level * level;
        out.rss = (out.rss + n * level * level - 2.0 * level * left).max(rounding);
        if let Some(list) = residuals {
            list[from..].iter_mut().for_each(|r| *r -= level);
        }
    }
}

impl LeastSquares for Waveform<'_> {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.time.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_of(p, &self.active, out, f64::INFINITY)
    }

    fn normal_of(&self, p: &[f64], free: &[usize], out: &mut Normal, _limit: f64) -> bool {
        out.clear();
        let omega = p[OMEGA];
        // Slowest phase rate in the window must stay positive: the motion has an order.
        let slowest =
            [0.0, self.duration].map(|t| self.window(free).phase(p, t).1).into_iter().fold(omega, f64::min);
        if !(p[A0] > 0.0 && omega > 0.0 && slowest > 0.1 * omega && shapes_exist(p)) {
            return false;
        }
        // Each half cycle is walked: across a gap of millions of them there is nothing to compare with.
        if omega * self.duration > 100.0 * PI * self.time.len() as f64 {
            return false;
        }
        let gathered = self.gathered.as_ref();
        gathered.is_some_and(|sums| self.gathered_pass(sums, p, free, out)) || self.pass(p, free, out, None)
    }
}

impl Waveform<'_> {
    /// Data less model, sample by sample; NaN where the model does not exist.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(self.time.len());
        self.pass(p, &[], &mut Normal::zeros(COUNT), Some(&mut residuals));
        residuals.resize(self.time.len(), f64::NAN);
        residuals
    }

    /// How many samples do not count because they are so close to a turn.
    pub(crate) fn at_turns(&self, p: &[f64]) -> usize {
        if self.guard == 0.0 {
            return 0;
        }
        let every = Self { guard: 0.0, ..self.clone() }.residuals(p);
        self.residuals(p).iter().zip(every).filter(|(kept, all)| **kept == 0.0 && *all != 0.0).count()
    }

    /// Time for which the mass moves inside the window, s.
    pub(crate) fn moving_s(&self, p: &[f64]) -> f64 {
        let stop = law_of(p, p[OMEGA]).stop_time_s().unwrap_or(f64::INFINITY);
        stop.min(self.duration).max(f64::MIN_POSITIVE)
    }

    /// Mean phase rate as long as the mass moves, as a combination of parameters.
    pub(crate) fn mean_rate(&self, p: &[f64]) -> [(usize, f64); 3] {
        let t = self.moving_s(p);
        let [_, _, bend, chirp] = self.window(&[]).phase(p, t).2;
        [(OMEGA, 1.0), (BEND, bend / t), (CHIRP, chirp / t)]
    }

    /// Derivatives of the phase by some of its parameters, at a time on the record's clock.
    pub(crate) fn phase_by(&self, p: &[f64], slots: &[usize], time_s: f64) -> Vec<f64> {
        let by = self.window(&[]).phase(p, time_s - self.origin).2;
        slots.iter().filter_map(|s| PHASE_SLOTS.iter().position(|k| k == s)).map(|k| by[k]).collect()
    }

    /// Products of the derivatives by `free` parameters with that by the phase, summed over some of the samples;
    /// `None` where the model does not exist.
    pub(crate) fn along_phase(&self, p: &[f64], free: &[usize], range: Range<usize>) -> Option<DVector<f64>> {
        let part =
            Window { time: &self.time[range.clone()], signal: &self.signal[range], ..self.window(free) };
        let (sums, _) = part.sums(p, None)?;
        let phase = free.iter().position(|f| *f == PHASE)?;
        Some(DVector::from_fn(free.len(), |i, _| sums.total(i.max(phase), i.min(phase))))
    }

    /// Phase of the signal of the model at a time on the record's clock.
    pub(crate) fn phase_at(&self, p: &[f64], time_s: f64) -> crate::signal::blocks::PhaseAt {
        let (phase, omega, _) = self.window(&[]).phase(p, time_s - self.origin);
        let phase = phase + self.observable.phase_lead();
        crate::signal::blocks::PhaseAt { phase, omega, chirp: 0.0, loss: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;
    use crate::inference::least_squares::minimise;
    use crate::motion::decay::FreeDecay;
    use crate::motion::decay::parameters::DRAG;
    use crate::motion::decay::path::SHAPE;
    use crate::motion::simulate::Drive;
    use crate::motion::simulate::smooth::{self, SmoothMotion};

    fn wave<'a>(time: &'a [f64], signal: &'a [f64], bend: Option<Bend>) -> Waveform<'a> {
        let duration = time[time.len() - 1];
        Waveform {
            time,
            signal,
            observable: Observable::Displacement,
            guard: 0.0,
            origin: 0.0,
            duration,
            bend,
            rest: RestLevel::Exact,
            active: (0..OFFSET + 3).collect(),
            gathered: None,
        }
    }

    fn residuals(wave: &Waveform, p: &[f64]) -> f64 {
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(p, &mut out));
        out.rss
    }

    #[test]
    fn is_the_exact_free_decay() {
        for (q, x_f) in [(3.0, 0.02), (50.0, 0.01), (1000.0, 0.0), (1e6, 0.001)] {
            let omega_0 = 7.0;
            let delta = omega_0 / (2.0 * q);
            let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let time: Vec<f64> = (0..400).map(|i| i as f64 * 0.021).collect();
            let end = decay.stop().map_or(f64::INFINITY, |s| s.time_s);
            let time: Vec<f64> = time.into_iter().filter(|&t| t < end).collect();
            let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t) + 0.3).collect();
            let mut p = [0.0; COUNT];
            (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, delta, oscillator.omega_d(), 0.3);
            let rms = (residuals(&wave(&time, &signal, None), &p) / time.len() as f64).sqrt();
            assert!(rms < 1e-13, "Q {q}: {rms:e}");
        }
    }

    /// Velocities and accelerations of the exact decay, over `omega` and its square, to the stop and at rest.
    #[test]
    fn is_its_velocity_and_its_acceleration() {
        for (q, x_f) in [(3.0, 0.02), (8.0, 0.05), (50.0, 0.01), (1000.0, 0.0)] {
            let (omega_0, h) = (7.0, 1e-4);
            let delta = omega_0 / (2.0 * q);
            let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
            let omega = oscillator.omega_d();
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let time: Vec<f64> = (0..800).map(|i| f64::from(i) * 0.011).collect();
            let mut p = [0.0; COUNT];
            (p[DELTA], p[OMEGA], p[OFFSET]) = (delta, omega, 0.3);
            let rms = |observable: Observable, signal: &dyn Fn(f64) -> f64, p: &[f64; COUNT]| {
                let signal: Vec<f64> = time.iter().map(|t| signal(*t)).collect();
                let wave = Waveform { observable, ..wave(&time, &signal, None) };
                let residuals = wave.residuals(p);
                // A difference across a turn is none.
                let turns = |t: f64| ((t - h) * omega / PI).floor() != ((t + h) * omega / PI).floor();
                let inside = residuals.iter().zip(&time).filter(|(_, t)| !turns(**t));
                (inside.map(|(r, _)| r * r).sum::<f64>() / time.len() as f64).sqrt()
            };
            (p[A0], p[X_F]) = (omega, omega * x_f);
            let velocity = rms(Observable::Velocity, &|t| decay.velocity(t) + 0.3, &p);
            assert!(velocity < 1e-12, "Q {q}: {velocity:e}");
            (p[A0], p[X_F]) = (omega * omega, omega * omega * x_f);
            let slope = |t: f64| (decay.velocity(t + h) - decay.velocity(t - h)) / (2.0 * h);
            let acceleration = rms(Observable::Acceleration, &|t| slope(t) + 0.3, &p);
            assert!(acceleration < 1e-5, "Q {q}: {acceleration:e}");
        }
    }

    /// Beside the turns samples do not count, and are counted; at rest every one does.
    #[test]
    fn samples_beside_a_turn_do_not_count() {
        let oscillator = Oscillator::kinematic(7.0, 0.4, 0.03).expect("valid");
        let stop = FreeDecay::from_rest(&oscillator, 1.0).expect("valid").stop().expect("stops").time_s;
        let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 0.0123).collect();
        let lifted = vec![0.1; time.len()];
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA]) = (1.0, 0.03, 0.4, oscillator.omega_d());
        let all = Waveform { observable: Observable::Acceleration, ..wave(&time, &lifted, None) };
        let guarded = Waveform { guard: 0.05, ..all.clone() };
        let (every, kept) = (all.residuals(&p), guarded.residuals(&p));
        let left_out = kept.iter().filter(|r| **r == 0.0).count();
        assert!(left_out > 5 && left_out == guarded.at_turns(&p), "{left_out}");
        assert_eq!(all.at_turns(&p), 0);
        for ((t, all), kept) in time.iter().zip(every).zip(kept) {
            assert!(kept == all || kept == 0.0 && *t < stop, "{t}: {kept} for {all}");
        }
    }

    /// Against the integrated motion: with drag a half cycle is known to second order in the loss, and what is
    /// left after all of them falls with its square.
    #[test]
    fn is_the_motion_with_drag_to_second_order() {
        for (x_f, viscous) in [(0.0, 0.0), (0.0, 1.0), (0.5, 0.3)] {
            let left = [8.0, 30.0, 120.0].map(|q| {
                let omega_0 = 7.0;
                let whole = omega_0 / (2.0 * q);
                let (delta, drag, x_f) = (viscous * whole, whole, x_f * whole * PI / (2.0 * omega_0));
                let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
                let law = smooth::drag(drag * 3.0 * PI / (4.0 * omega_0.powi(3))).expect("valid");
                let drive = Drive::none();
                let mut motion = SmoothMotion::new(&oscillator, law, drive, 0.0, 1.0, 0.0).expect("valid");
                let duration = 1.5 / whole;
                let time: Vec<f64> = (0..600).map(|i| f64::from(i) * duration / 600.0).collect();
                let mut states = |&t: &f64| motion.state_at(t).expect("moves");
                let states: Vec<_> = time.iter().map(&mut states).collect();
                let signal: Vec<f64> = states.iter().map(|state| state.position).collect();
                let free = [A0, PHASE, OMEGA, X_F, DELTA, DRAG];
                let mut p = vec![0.0; COUNT];
                (p[A0], p[X_F], p[DELTA], p[DRAG], p[OMEGA]) = (1.0, x_f, delta, drag, oscillator.omega_d());
                let position = wave(&time, &signal, None);
                let fit = minimise(&position, &p, &free).expect("fits");
                let velocity: Vec<f64> = states.iter().map(|state| state.velocity).collect();
                let mut in_signal = p.clone();
                in_signal[..2].iter_mut().for_each(|length| *length *= p[OMEGA]);
                in_signal[DRAG] /= p[OMEGA];
                let velocity = Waveform { observable: Observable::Velocity, ..wave(&time, &velocity, None) };
                [residuals(&position, &p), fit.rss, residuals(&velocity, &in_signal) / p[OMEGA].powi(2)]
                    .map(|rss| (rss / 600.0).sqrt())
            });
            // Four times the quality factor, a sixteenth of what is left.
            for [here, there] in [[left[0], left[1]], [left[1], left[2]]] {
                assert!(there.iter().zip(here).all(|(there, here)| *there < here / 14.0), "{left:?}");
            }
            assert!(left[1][0] < 2e-5 && left[1][1] < 3e-6 && left[1][2] < 4e-5, "{left:?}");
        }
    }

    /// With the level of the rest free, lifting all samples there changes nothing, and the
    /// gradient by the offsets is that of what is left.
    #[test]
    fn the_samples_at_rest_have_their_own_level() {
        let oscillator = Oscillator::kinematic(7.0, 0.02, 0.01).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let stop = decay.stop().expect("stops").time_s;
        let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 1.5 * stop / 900.0).collect();
        let signal: Vec<f64> =
            time.iter().map(|&t| decay.displacement(t) + 0.003 * (31.0 * t).sin()).collect();
        let lifted = |by: f64| -> Vec<f64> {
            time.iter().zip(&signal).map(|(&t, x)| x + if t > stop { by } else { 0.0 }).collect()
        };
        let (inside, outside) = (lifted(0.004), lifted(0.2));
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA]) = (1.0, 0.01, 0.02, oscillator.omega_d());
        (p[OFFSET], p[OFFSET + 1]) = (0.001, 0.002);
        let free = |signal| Waveform { rest: RestLevel::Bounded, ..wave(&time, signal, None) };
        // Anywhere within `±x_F` the level is as good, beyond it is not.
        let rss = residuals(&free(&signal), &p);
        assert!((residuals(&free(&inside), &p) / rss - 1.0).abs() < 1e-9);
        assert!(residuals(&free(&outside), &p) > 2.0 * rss);
        for lifted in [&inside, &outside] {
            let wave = free(lifted);
            let mut out = Normal::zeros(COUNT);
            assert!(wave.normal(&p, &mut out));
            let listed: f64 = wave.residuals(&p).iter().map(|r| r * r).sum();
            assert!((listed / out.rss - 1.0).abs() < 1e-9);
            for k in [OFFSET, OFFSET + 1, OFFSET + 2] {
                let h = 1e-6;
                let (mut up, mut down) = (p, p);
                up[k] += h;
                down[k] -= h;
                let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
                let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
                assert!(error < 1e-6, "parameter {k}: {} against {numeric}", out.jtr[k]);
            }
        }
    }

    /// The level on `±x_F` moves with it: beside the motion before the rest, that is all of the
    /// derivative of the samples at rest.
    #[test]
    fn the_level_on_its_limit_follows_the_friction() {
        let time: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.5).collect();
        let signal: Vec<f64> = time.iter().map(|t| 0.3 + 0.1 * (3.0 * t).sin()).collect();
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA], p[PHASE]) = (1.0, 0.02, 0.01, 7.0, 0.4);
        let sums = |rest: RestLevel| {
            let mut out = Normal::zeros(COUNT);
            assert!(Waveform { rest, ..wave(&time, &signal, None) }.normal(&p, &mut out));
            out
        };
        let out = sums(RestLevel::Bounded);
        let at_rest = |p: &[f64; COUNT]| {
            let wave = Waveform { rest: RestLevel::Bounded, ..wave(&time, &signal, None) };
            let residuals = wave.residuals(p);
            residuals[residuals.len() / 2..].iter().map(|r| r * r).sum::<f64>()
        };
        let h = 1e-7;
        let (mut up, mut down) = (p, p);
        up[X_F] += h;
        down[X_F] -= h;
        let numeric = -(at_rest(&up) - at_rest(&down)) / (4.0 * h);
        // The later half of the samples is at rest for long.
        let half: f64 = signal[100..].iter().map(|x| x - p[X_F]).sum();
        assert!((numeric / half - 1.0).abs() < 1e-6, "{numeric} against {half}");
        assert!(out.jtj[(X_F, X_F)] >= 100.0, "{}", out.jtj[(X_F, X_F)]);
    }

    /// Near the reference the sums gathered are those of all samples, with and without a stop among them; what they
    /// miss is of second order over a twelfth of the window.
    #[test]
    fn sums_that_were_gathered_are_those_of_all_samples() {
        use Observable::{Acceleration, Displacement, Velocity};
        let cases = [(0.004, 1.0, Displacement), (0.02, 1.4, Displacement)];
        // Friction makes an acceleration jump at each turn, which no sum follows from motion to motion.
        let derivatives = [(0.004, 1.0, Velocity), (0.02, 1.4, Velocity), (1e-5, 1.0, Acceleration)];
        for (x_f, length, observable) in cases.into_iter().chain(derivatives) {
            let oscillator = Oscillator::kinematic(7.0, 0.05, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
            let stop = decay.stop().expect("stops").time_s;
            let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * length * stop.min(30.0) / 3000.0).collect();
            let noise = |i: usize| 0.05 * ((i * 7919) % 101) as f64 / 101.0;
            let mut p = [0.0; COUNT];
            (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, 0.05, oscillator.omega_d(), 0.025);
            p[PHASE] = -observable.phase_lead();
            let nothing = vec![0.0; time.len()];
            let model = Waveform { observable, ..wave(&time, &nothing, None) }.residuals(&p);
            let signal: Vec<f64> = model.iter().enumerate().map(|(i, x)| noise(i) - 0.025 - x).collect();
            let exact = Waveform { observable, ..wave(&time, &signal, None) };
            let gathered = exact.clone().gathered_about(&p);
            assert!(gathered.gathered.is_some());
            let free = [A0, X_F, DELTA, DRAG, PHASE, OMEGA, OFFSET];
            let sums = |problem: &Waveform, p: &[f64]| {
                let mut out = Normal::zeros(COUNT);
                assert!(problem.normal_of(p, &free, &mut out, f64::INFINITY));
                out
            };
            let here = sums(&exact, &p);
            let steps = [
                (A0, 3e-3),
                (X_F, 1e-4),
                (DELTA, 5e-4),
                (DRAG, 5e-4),
                (PHASE, 3e-3),
                (OMEGA, 3e-4),
                (OFFSET, 3e-3),
            ];
            for (k, by) in steps {
                let mut q = p;
                q[k] += by;
                let (all, near) = (sums(&exact, &q), sums(&gathered, &q));
                let rise = by * by * here.jtj[(k, k)];
                assert!(
                    (near.rss - all.rss).abs() < 2e-3 * rise,
                    "{observable:?} {k}: {} for {}, {rise}",
                    near.rss,
                    all.rss
                );
                for &i in &free {
                    let scale = (all.jtj[(i, i)] * rise).sqrt();
                    let miss = (near.jtr[i] - all.jtr[i]).abs() / scale;
                    assert!(miss < 0.02, "{k} {i}: {miss}");
                    assert!((near.jtj[(i, i)] / all.jtj[(i, i)] - 1.0).abs() < 3e-3, "{k} {i}");
                }
            }
            // Far motions are summed sample by sample.
            let mut far = p;
            far[OMEGA] += 0.2;
            assert_eq!(sums(&gathered, &far).rss, sums(&exact, &far).rss);
        }
    }

    /// `Jᵀr` is minus half the gradient of `rᵀr`.
    #[test]
    fn the_gradient_holds_for_every_parameter() {
        let time: Vec<f64> = (0..300).map(|i| i as f64 * 0.05 + 0.003 * (i % 7) as f64).collect();
        let signal: Vec<f64> = time.iter().map(|t| (-0.1 * t).exp() * (5.1 * t + 0.3).cos() + 0.1).collect();
        let bend = Bend::along(|t| 1.1 * (-0.12 * t).exp(), 15.1);
        for observable in [Observable::Displacement, Observable::Velocity, Observable::Acceleration] {
            let wave = Waveform { observable, ..wave(&time, &signal, Some(bend.clone())) };
            let mut p = [0.0; COUNT];
            p[..SHAPE].fill(0.01);
            p[SHAPE..PHASE].fill(1.5);
            p[..4].copy_from_slice(&[1.1, 0.02, 0.08, 0.03]);
            p[PHASE..].copy_from_slice(&[0.7, 5.0, 0.0, 0.002, 0.05, 0.02, -0.03]);
            let mut out = Normal::zeros(COUNT);
            assert!(wave.normal(&p, &mut out));
            for k in 0..COUNT {
                let h = 1e-6;
                let (mut up, mut down) = (p, p);
                up[k] += h;
                down[k] -= h;
                let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
                // The backbone also bends the loss terms, which its derivative leaves out;
                // inside a half cycle the shapes are straight lines.
                let tolerance = match k {
                    BEND => 0.2,
                    CHIRP => 2e-3,
                    // The shape's own derivative is curved inside a half cycle.
                    k if (SHAPE..PHASE).contains(&k) => 2e-4,
                    _ => 2e-5,
                };
                // Nor does the change of the rate of the phase inside a half cycle enter those of a derivative.
                let tolerance =
                    if observable == Observable::Displacement { tolerance } else { 10.0 * tolerance };
                let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
                assert!(error < tolerance, "{observable:?} {k}: {} against {numeric}", out.jtr[k]);
            }
        }
    }
}

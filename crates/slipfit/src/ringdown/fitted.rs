//! The fitted motion, for plotting or subtraction.

use super::level::Baseline;
use super::residuals::Harmonics;
use super::sensor_curve::SensorCurve;
use super::two_modes::ViscousMode;
use crate::motion::decay::amplitude::AmplitudeLaw;
use crate::motion::decay::drag;
use crate::motion::decay::path::{AmplitudePath, Carried};
use crate::motion::decay::window::Observable;
use crate::numeric::roots::border;
use std::f64::consts::PI;

/// Number of points of the amplitude table.
const TABLE: usize = 2048;

/// One knot of the phase and the offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Knot {
    pub(crate) time_s: f64,
    /// Phase, rad; turning points are at multiples of pi.
    pub(crate) phase: f64,
    /// Rate of the phase, rad/s.
    pub(crate) omega: f64,
    pub(crate) offset: f64,
}

/// The motion of the chosen model: turning points on the amplitude law, joined
/// by damped half cycles about `±x_F`.
///
/// Between two turning points `X_n` and `X_{n+1}` of signs `s`, `-s` the exact
/// motion with sliding friction is, with `theta` the phase since the turn and
/// `rho = (|X_{n+1}| + x_F)/(|X_n| - x_F)`,
///
/// ```text
/// x = s { x_F + (|X_n| - x_F) rho^(theta/pi) [cos theta - (ln rho/pi) sin theta] }
/// ```
///
/// which is the closed form of a free decay with viscous and sliding friction if the frequency is constant,
/// and joins the turning points smoothly if frequency or loss law change slowly. For a velocity or
/// acceleration record its derivative is used.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedMotion {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) law: AmplitudeLaw,
    pub(crate) friction_displacement: f64,
    /// Observable that the signal represents, and the frequency at vanishing amplitude, rad/s.
    observable: (Observable, f64),
    /// Empty for a bare envelope.
    pub(crate) knots: Vec<Knot>,
    /// Relative frequency shift per A² and A⁴, which also affects the loss.
    pub(crate) backbone: [f64; 2],
    /// Amplitudes on an even grid if there is no closed form because of backbone or further losses.
    table: Vec<f64>,
    /// Noise floor of an envelope, added in quadrature: `R² = A² + floor²`.
    pub(crate) noise_floor: f64,
    /// Turning point at which sliding friction stops the mass, if it does within the stretch.
    rest: Option<Rest>,
    /// A second mode that is added to the motion.
    pub(crate) second_mode: Option<ViscousMode>,
    /// Wandering of the level about which the motion oscillates, in addition to its offset.
    pub(crate) baseline: Option<Baseline>,
    /// Harmonics in addition to those of the motion itself.
    pub(crate) harmonics: Option<Harmonics>,
    /// Nonlinearity of the sensor; amplitudes are those of the straightened reading.
    pub(crate) sensor_curve: Option<SensorCurve>,
}

/// The turning point from which on the mass is at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rest {
    time_s: f64,
    /// Relative to the centre of the oscillation.
    displacement: f64,
}

impl FittedMotion {
    pub(crate) fn new(
        start_s: f64,
        end_s: f64,
        law: AmplitudeLaw,
        backbone: [f64; 2],
        friction_displacement: f64,
        knots: Vec<Knot>,
        noise_floor: f64,
    ) -> Self {
        let table = if backbone == [0.0; 2] && law.is_closed() {
            Vec::new()
        } else {
            let step = (end_s - start_s) / (TABLE - 1) as f64;
            let mut path = AmplitudePath::new(law, backbone).carrying(Carried::None);
            (0..TABLE)
                .map(|i| {
                    if i > 0 {
                        path.advance(step);
                    }
                    path.amplitude
                })
                .collect()
        };
        let mut motion = Self {
            start_s,
            end_s,
            law,
            friction_displacement,
            observable: (Observable::Displacement, 1.0),
            knots,
            backbone,
            table,
            noise_floor,
            rest: None,
            second_mode: None,
            baseline: None,
            harmonics: None,
            sensor_curve: None,
        };
        motion.rest = motion.find_rest();
        motion
    }

    /// Makes the motion a derivative of the displacement; `omega` is the frequency at vanishing amplitude,
    /// rad/s.
    pub(crate) fn observed_as(mut self, observable: Observable, omega: f64) -> Self {
        self.observable = (observable, omega);
        self
    }

    /// The first turning point within the stick zone, `|X_n| <= x_F`.
    fn find_rest(&self) -> Option<Rest> {
        let stuck = |elapsed: f64| self.amplitude_extended(elapsed) <= self.friction_displacement;
        let duration = self.end_s - self.start_s;
        if !(self.friction_displacement > 0.0 && duration > 0.0 && !stuck(0.0) && stuck(duration)) {
            return None;
        }
        // The amplitude decreases monotonically.
        let (resting, _) = border(duration, 0.0, stuck);
        let knot = self.phase_at(self.start_s + resting)?;
        let turns = (knot.phase / PI).ceil();
        let elapsed = resting + (turns * PI - knot.phase) / knot.omega;
        let sign = if turns.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        let displacement = sign * self.amplitude_extended(elapsed);
        (elapsed.is_finite() && displacement.is_finite())
            .then_some(Rest { time_s: self.start_s + elapsed, displacement })
    }

    fn amplitude_extended(&self, elapsed: f64) -> f64 {
        if self.table.is_empty() {
            return self.law.after(self.law.initial, elapsed);
        }
        let x = (elapsed / (self.end_s - self.start_s) * (TABLE - 1) as f64).clamp(-1.0, TABLE as f64);
        let i = (x.max(0.0) as usize).min(TABLE - 2);
        let u = x - i as f64;
        self.table[i] + u * (self.table[i + 1] - self.table[i])
    }

    /// First and last instant of the fitted stretch, s.
    pub fn range_s(&self) -> [f64; 2] {
        [self.start_s, self.end_s]
    }

    /// Time from which on the mass is at rest, s; `None` if it moves until the end.
    pub fn rest_s(&self) -> Option<f64> {
        self.rest.map(|rest| rest.time_s)
    }

    /// Amplitude of the model at a given time, signal unit; zero after the stop, NaN outside the fitted
    /// stretch.
    ///
    /// For an envelope record this is the bare amplitude, without the noise floor.
    pub fn amplitude_at(&self, time_s: f64) -> f64 {
        if !(self.start_s..=self.end_s).contains(&time_s) {
            return f64::NAN;
        }
        self.amplitude_extended(time_s - self.start_s).max(0.0)
    }

    /// Value of the signal at a given time, signal unit. Outside the fitted stretch an oscillation is
    /// continued by its law; an envelope is NaN there, and inside it is the amplitude with the noise floor.
    /// If the record contains two modes, both are included.
    pub fn signal_at(&self, time_s: f64) -> f64 {
        let level = self.baseline.as_ref().map_or(0.0, |baseline| baseline.value(time_s));
        let first_mode = self.first_mode_at(time_s);
        let read = self.sensor_curve.map_or(first_mode, |curve| curve.reading(first_mode));
        read + self.second_mode.map_or(0.0, |mode| mode.at(time_s)) + level
    }

    /// The motion without a second mode, continued up to `end_s`, to its stop or as far as a closed-form law
    /// allows.
    pub(super) fn continued_to(&self, end_s: f64) -> Self {
        let mut motion = Self { second_mode: None, ..self.clone() };
        if motion.table.is_empty() {
            motion.end_s = motion.end_s.max(end_s);
            motion.rest = motion.rest.or_else(|| motion.find_rest());
        }
        motion
    }

    /// The motion at any time, extrapolated by the law before the fitted stretch; NaN for a bare envelope.
    pub(super) fn extrapolated_motion(&self, time_s: f64) -> f64 {
        self.first_mode_at(time_s)
    }

    fn first_mode_at(&self, time_s: f64) -> f64 {
        let amplitude = self.amplitude_at(time_s);
        let Some(knot) = self.phase_at(time_s) else {
            return amplitude.hypot(self.noise_floor);
        };
        if let Some(rest) = self.rest.filter(|rest| time_s >= rest.time_s) {
            let moves_none = self.observable.0 != Observable::Displacement;
            return knot.offset + if moves_none { 0.0 } else { rest.displacement };
        }
        let theta = knot.phase.rem_euclid(PI);
        let sign = if (knot.phase / PI).floor().rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        let since = theta / knot.omega;
        let half_period = PI / knot.omega;
        let elapsed = time_s - self.start_s - since;
        let before = self.amplitude_extended(elapsed);
        let after = self.amplitude_extended(elapsed + half_period);
        let x_f = self.friction_displacement;
        let bulge = self
            .drag_shape(before, after, knot.omega)
            .map_or(0.0, |(height, shape)| height * shape.value(self.observable.0.order(), theta));
        let (observable, omega) = self.observable;
        let rate = (knot.omega / omega).powi(observable.order());
        let shape = half_cycle(before, after, x_f, theta, observable);
        knot.offset + sign * rate * (shape + bulge)
    }

    /// Contribution of drag to the shape of a half cycle between two amplitudes.
    fn drag_shape(&self, before: f64, after: f64, omega: f64) -> Option<(f64, drag::Shape)> {
        let x_f = self.friction_displacement;
        let square = (before - x_f) * (after + x_f);
        (self.law.a2 != 0.0 && square > 0.0).then(|| {
            let shape = drag::Shape::new(square, [self.law.a1, self.law.a2], omega);
            (shape.epsilon * square.sqrt(), shape)
        })
    }

    pub(super) fn phase_at(&self, time_s: f64) -> Option<Knot> {
        if has_no_amplitude(&self.knots) {
            return None;
        }
        let right = self.knots.partition_point(|k| k.time_s < time_s).clamp(1, self.knots.len() - 1);
        Some(interpolate(&self.knots[right - 1], &self.knots[right], time_s))
    }
}

fn has_no_amplitude(knots: &[Knot]) -> bool {
    knots.len() < 2
}

/// Cubic Hermite in phase, linear in offset; extends past the ends with the last rate.
pub(crate) fn interpolate(a: &Knot, b: &Knot, time_s: f64) -> Knot {
    let h = b.time_s - a.time_s;
    let u = (time_s - a.time_s) / h;
    let slope = (b.phase - a.phase) / h;
    // Newton form: exact for the cubic through both phases and both rates.
    let p = (slope - a.omega) / h;
    let q = (a.omega + b.omega - 2.0 * slope) / (h * h);
    let (d, e) = (time_s - a.time_s, time_s - b.time_s);
    if u < 0.0 {
        return Knot { time_s, phase: a.phase + a.omega * d, omega: a.omega, offset: a.offset };
    }
    if u > 1.0 {
        return Knot { time_s, phase: b.phase + b.omega * e, omega: b.omega, offset: b.offset };
    }
    Knot {
        time_s,
        phase: a.phase + a.omega * d + p * d * d + q * d * d * e,
        omega: a.omega + 2.0 * p * d + q * (2.0 * d * e + d * d),
        offset: a.offset + u * (b.offset - a.offset),
    }
}

/// Displacement, or its derivative with respect to phase, at phase `theta` in `[0, pi]` after the turning
/// point `before`, on the way to `-after` (both as positive amplitudes).
fn half_cycle(before: f64, after: f64, x_f: f64, theta: f64, observable: Observable) -> f64 {
    let swing = before - x_f;
    let ratio = (after + x_f) / swing;
    let moves = swing > 0.0 && ratio > 0.0;
    let lambda = if moves { ratio.ln() / PI } else { 0.0 };
    let (sin, cos) = theta.sin_cos();
    let curved = -swing * (1.0 + lambda * lambda) * (lambda * theta).exp();
    match observable {
        // At rest inside the stick zone.
        Observable::Displacement if !moves => before,
        _ if !moves => 0.0,
        Observable::Displacement => x_f + swing * (lambda * theta).exp() * (cos - lambda * sin),
        Observable::Velocity => curved * sin,
        Observable::Acceleration => curved * (cos + lambda * sin),
    }
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record, SignalKind};

    #[test]
    fn the_fitted_motion_of_a_derivative_is_the_derivative() {
        let (omega_0, delta, x_f) = (5.0, 0.3, 0.01);
        let oscillator = Oscillator::kinematic(omega_0, delta, x_f).unwrap();
        let decay = FreeDecay::from_rest(&oscillator, 0.3).unwrap();
        let stop_s = decay.stop().unwrap().time_s;
        let velocity = |t: f64| decay.velocity(t);
        let acceleration = |t: f64| {
            let (x, v) = (decay.displacement(t), decay.velocity(t));
            if t < stop_s { -omega_0.powi(2) * (x + x_f * v.signum()) - 2.0 * delta * v } else { 0.0 }
        };
        let kinds = [(SignalKind::Velocity, 1.5), (SignalKind::Acceleration, 7.5)];
        for (kind, most) in kinds {
            let truth: &dyn Fn(f64) -> f64 =
                if kind == SignalKind::Velocity { &velocity } else { &acceleration };
            let noise = 0.005 * most;
            let time_s: Vec<f64> = (0..600).map(|i| 0.0213 * f64::from(i)).collect();
            let noisy = |(i, t): (usize, &f64)| truth(*t) + noise * jitter(i, 3);
            let signal = time_s.iter().enumerate().map(noisy).collect();
            let record = Record::new(time_s.clone(), signal).unwrap().with_kind(kind);
            let answer = analyse(&record, &Options::default()).unwrap();
            assert_eq!(answer.diagnostics.method, "waveform");
            let [start, end] = answer.fit.range_s();
            let off: Vec<f64> = time_s
                .iter()
                .filter(|t| (start..=end).contains(*t))
                .map(|t| (answer.fit.signal_at(*t) - truth(*t)).abs())
                .collect();
            let far = off.iter().filter(|off| **off > noise).count();
            // A sample next to a jump may lie on the other side of it.
            assert!(far <= usize::from(kind == SignalKind::Acceleration), "{kind:?}: {far} of {}", off.len());
        }
    }

    #[test]
    fn the_fitted_motion_rests_where_friction_stops_it() {
        let oscillator = Oscillator::kinematic(5.0, 0.028, 0.002).unwrap();
        let decay = FreeDecay::from_rest(&oscillator, 0.3).unwrap();
        let stop_s = decay.stop().unwrap().time_s;
        let noise = 1e-3;
        let time_s: Vec<f64> = (0..3000).map(|i| 0.02 * f64::from(i)).collect();
        let signal = time_s
            .iter()
            .enumerate()
            .map(|(i, &t)| decay.displacement(t) + 1.4 * noise * (7.7 * (i * i) as f64).sin())
            .collect();
        let record = Record::new(time_s, signal).unwrap();
        let fit = analyse(&record, &Options::default()).unwrap().fit;
        let [start, end] = fit.range_s();
        assert!(end > stop_s + 10.0, "the rest belongs to the stretch: {stop_s} s of {end} s");
        // The deviation is less than the noise of one sample, both in motion and at rest.
        for i in 0..=2000 {
            let t = start + (end - start) * f64::from(i) / 2000.0;
            let off = fit.signal_at(t) - decay.displacement(t);
            assert!(off.abs() < noise, "{off} at {t} s; the stop is at {stop_s} s");
        }
    }
}

//! Friction that depends on speed (drag, power laws, Stribeck, any law), and optionally on position.
//!
//! ```text
//! m x'' + gamma x' + k x + F sgn(x') + f(x, x') = k u(t)
//! ```
//!
//! There is no closed form, so each slip is integrated by a Runge-Kutta method of order eight (Dormand and Prince),
//! with the same events as [`Motion`]: stops and releases are decided by the oscillator's static friction, and
//! turning points are bracketed and refined by integrating up to them.

use super::drive::Drive;
use super::event::{Event, Friction, State};
use super::local::Local;
use super::motion::Motion;
use crate::error::Error;
use crate::model::oscillator::{Oscillator, above_zero, at_least_zero};
use crate::numeric::roots::root;
use differential_equations::interpolate::Interpolation;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;

/// A friction law: the magnitude of the force over the stiffness; the force opposes the motion.
///
/// Every function of the speed is a law; [`AtPosition`] converts a function of position and speed into one.
pub trait Law {
    /// The force at a position and a speed `>= 0`, in units of displacement.
    fn force(&self, position: f64, speed: f64) -> f64;
}

impl<F: Fn(f64) -> f64> Law for F {
    fn force(&self, _: f64, speed: f64) -> f64 {
        self(speed)
    }
}

/// A law of position and speed.
#[derive(Debug, Clone, Copy)]
pub struct AtPosition<F>(F);

impl<F: Fn(f64, f64) -> f64> Law for AtPosition<F> {
    fn force(&self, position: f64, speed: f64) -> f64 {
        (self.0)(position, speed)
    }
}

/// A motion under the oscillator's own friction and an additional law `f(v)/k`, or `f(x, v)/k`
/// ([`with_position`](SmoothMotion::with_position)).
///
/// The law is given for `v >= 0` as a displacement (force over stiffness) that opposes the motion, and is extended as
/// an odd function; `f(0)` should be zero, because the oscillator already has sliding friction.
///
/// The accuracy is the tolerance per step, 1e-13 of the motion by default. Turning points are searched for at eight
/// points within each step, and wherever the acceleration shows that the speed has a minimum between two of them: two
/// turning points are found however close they are. Only a law that makes the acceleration itself change sign twice
/// within a ninth of a step could hide a pair, unlike in [`Motion`], where a bound excludes it.
///
/// ```
/// # use slipfit::{Oscillator, motion::simulate::{Drive, smooth::{SmoothMotion, drag}}};
/// let o = Oscillator::kinematic(1.0, 0.0, 0.01)?;
/// let mut motion = SmoothMotion::new(&o, drag(0.2)?, Drive::none(), 0.0, 1.0, 0.0)?;
/// let first = motion.next_event(10.0)?.expect("a turn");
/// assert!((-1.0..-0.7).contains(&first.position));
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SmoothMotion<F> {
    core: Motion,
    oscillator: Oscillator,
    friction: Friction,
    law: F,
    tolerance: f64,
    /// Next step of the integrator, s; zero lets it choose.
    step: f64,
}

/// Drag `c v|v|`; `coefficient` is `c/k`, in displacement per velocity squared.
///
/// # Errors
/// [`Error::Parameter`] unless the coefficient is at least zero and finite.
pub fn drag(coefficient: f64) -> Result<impl Fn(f64) -> f64 + Clone, Error> {
    at_least_zero("drag coefficient", coefficient)?;
    Ok(move |v: f64| coefficient * v * v)
}

/// Power law `c |v|^p sgn v`; `coefficient` is `c/k`, and `p > 0`.
///
/// # Errors
/// [`Error::Parameter`] unless `c >= 0` and `p > 0`, both finite.
pub fn power(coefficient: f64, exponent: f64) -> Result<impl Fn(f64) -> f64 + Clone, Error> {
    at_least_zero("power-law coefficient", coefficient)?;
    above_zero("power-law exponent", exponent)?;
    Ok(move |v: f64| coefficient * v.powf(exponent))
}

/// Stribeck weakening: friction falls by `drop` (as a displacement) from its value at rest as the speed exceeds
/// `stribeck_velocity`, `-drop (1 - exp(-(v/v_s)²))`.
///
/// The oscillator's kinetic friction must be set to the friction at rest.
///
/// # Errors
/// [`Error::Parameter`] unless `drop >= 0` and `v_s > 0`, both finite.
pub fn stribeck(drop: f64, stribeck_velocity: f64) -> Result<impl Fn(f64) -> f64 + Clone, Error> {
    at_least_zero("Stribeck drop", drop)?;
    above_zero("Stribeck velocity", stribeck_velocity)?;
    Ok(move |v: f64| drop * (-(v / stribeck_velocity).powi(2)).exp_m1())
}

/// Right-hand side while sliding in one direction. The state is the displacement since the slip began, so that a pull
/// that barely exceeds friction is not lost in the rounding of the position.
struct Sliding<'a, F> {
    omega_squared: f64,
    two_delta: f64,
    /// Acceleration at the start, without the terms that depend on velocity.
    pull: f64,
    /// Position at the start.
    from: f64,
    drive: &'a Local,
    law: &'a F,
}

impl<L: Law> Sliding<'_, L> {
    fn acceleration(&self, t: f64, moved: f64, v: f64) -> f64 {
        let size = self.law.force(self.from + moved, v.abs());
        let law = if v < 0.0 { -size } else { size };
        self.pull + self.omega_squared * (self.drive.rise(t)[0] - moved - law) - self.two_delta * v
    }
}

impl<L: Law> ODE<f64, [f64; 2]> for Sliding<'_, L> {
    fn diff(&self, t: f64, y: &[f64; 2], dydt: &mut [f64; 2]) {
        *dydt = [y[1], self.acceleration(t, y[0], y[1])];
    }
}

/// End of an integrated stretch.
enum Reached {
    Turn { at: f64, position: f64 },
    End { position: f64, velocity: f64 },
}

impl<F: Fn(f64) -> f64> SmoothMotion<F> {
    /// A motion that starts at `time_s` from `position` and `velocity`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a value that is not finite or beyond 1e100.
    pub fn new(
        oscillator: &Oscillator,
        law: F,
        drive: Drive,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        Self::with_friction(oscillator, Friction::of(oscillator), law, drive, time_s, position, velocity)
    }

    /// The same with sliding friction that differs between the directions; the law remains odd.
    ///
    /// # Errors
    /// As [`SmoothMotion::new`].
    pub fn with_friction(
        oscillator: &Oscillator,
        friction: Friction,
        law: F,
        drive: Drive,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        let core = Motion::with_friction(oscillator, friction, drive, time_s, position, velocity)?;
        Ok(Self { core, oscillator: *oscillator, friction, law, tolerance: 1e-13, step: 0.0 })
    }
}

impl<F: Fn(f64, f64) -> f64> SmoothMotion<AtPosition<F>> {
    /// A motion under a law of position and speed, `f(x, v)/k`.
    ///
    /// # Errors
    /// As [`SmoothMotion::new`].
    pub fn with_position(
        oscillator: &Oscillator,
        law: F,
        drive: Drive,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        let friction = Friction::of(oscillator);
        let core = Motion::with_friction(oscillator, friction, drive, time_s, position, velocity)?;
        let law = AtPosition(law);
        Ok(Self { core, oscillator: *oscillator, friction, law, tolerance: 1e-13, step: 0.0 })
    }
}

impl<L: Law> SmoothMotion<L> {
    /// Relative tolerance per step, 1e-15 to 1e-3.
    ///
    /// # Errors
    /// [`Error::Parameter`] outside that range.
    pub fn with_tolerance(mut self, tolerance: f64) -> Result<Self, Error> {
        if !(1e-15..=1e-3).contains(&tolerance) {
            return Err(Error::Parameter { name: "tolerance", value: tolerance, range: "1e-15 to 1e-3" });
        }
        self.tolerance = tolerance;
        Ok(self)
    }

    /// State reached.
    pub fn state(&self) -> State {
        self.core.state()
    }

    /// The next event up to `until_s`; if there is none, `None`, and the state is then that at `until_s`.
    ///
    /// # Errors
    /// [`Error::DoesNotHold`] if the integrator fails: the law is too stiff, or not finite.
    pub fn next_event(&mut self, until_s: f64) -> Result<Option<Event>, Error> {
        loop {
            if self.core.direction() == 0.0 {
                let event = self.core.next_event(until_s);
                self.step = 0.0;
                if event.is_none() && until_s > self.core.state().time_s {
                    // Still at rest: nothing to integrate, the core keeps the position.
                    return Ok(None);
                }
                return Ok(event);
            }
            let left = self.core.until(until_s);
            if left.is_nan() || left <= 0.0 {
                return Ok(None);
            }
            let end = self.core.local().end;
            let stage_ends = self.core.local().stage_ends && end <= left;
            let reach = left.min(end).min(1e3 / self.oscillator.omega_0());
            match self.slide(reach)? {
                Reached::Turn { at, position } => {
                    self.core.place(at, position, 0.0);
                    self.step = 0.0;
                    return Ok(Some(self.core.turn_here()));
                }
                Reached::End { position, velocity } => {
                    self.core.place(reach, position, velocity);
                    if stage_ends && reach == end {
                        return Ok(Some(self.core.drive_changed()));
                    }
                }
            }
        }
    }

    /// State at `time_s`; successive times must not decrease.
    ///
    /// # Errors
    /// As [`SmoothMotion::next_event`]; [`Error::Parameter`] if `time_s` lies in the past.
    pub fn state_at(&mut self, time_s: f64) -> Result<State, Error> {
        while self.next_event(time_s)?.is_some() {}
        if self.core.direction() == 0.0 {
            return self.core.state_at(time_s);
        }
        let state = self.core.state();
        if state.time_s > time_s + 4e-16 * time_s.abs() {
            return Err(Error::Parameter {
                name: "time_s",
                value: time_s,
                range: "not before the last time reached",
            });
        }
        Ok(State { time_s, ..state })
    }

    /// Integrates from the core's state until the velocity becomes zero, for at most `reach`.
    fn slide(&mut self, reach: f64) -> Result<Reached, Error> {
        let state = self.core.state();
        let s = self.core.direction();
        let o = &self.oscillator;
        let omega_0 = o.omega_0();
        let ode = Sliding {
            omega_squared: omega_0 * omega_0,
            two_delta: 2.0 * o.decay_rate_per_s(),
            pull: self.core.pull_here(),
            from: state.position,
            drive: self.core.local(),
            law: &self.law,
        };
        let pull = s * ode.acceleration(0.0, 0.0, state.velocity);
        if state.velocity == 0.0 && pull <= 0.0 && s * self.core.drive_slope() <= 0.0 {
            // Held at the border of the sticking zone: no slip.
            return Ok(Reached::Turn { at: 0.0, position: state.position });
        }
        let mut h = if self.step > 0.0 { self.step } else { 1e-3 / omega_0 };
        if state.velocity == 0.0 {
            // A slip may be short: its length scales as the drive's slope over its curvature.
            let [_, slope, curvature, _] = self.core.local().bounds(h);
            let own = self.core.drive_slope().abs();
            if slope > 0.0 && pull <= 1e-9 * ode.omega_squared * slope / omega_0 {
                h = h.min(own / curvature.max(slope * omega_0)).max(1e-12 / omega_0);
            }
        }
        let size = state.position.abs() + state.velocity.abs() / omega_0;
        let [up, down] = self.friction.holding();
        let smallest = 1e-3 * self.tolerance * (size + up.max(down));
        let y0 = [0.0, state.velocity];
        let make = |h: f64| {
            ExplicitRungeKutta::dop853()
                .rtol(self.tolerance)
                .atol(smallest.max(f64::MIN_POSITIVE))
                .max_steps(usize::MAX)
                .h0(h)
        };
        if !pull.is_finite() {
            return Err(integration_failed());
        }
        let mut rejected = 0;
        let mut solver = make(h.min(reach));
        solver.init(&ode, 0.0, reach, &y0).map_err(|_| integration_failed())?;
        loop {
            let left = reach - solver.t();
            if left <= 4e-16 * reach {
                self.step = solver.h().max(h);
                let y = *solver.y();
                return Ok(Reached::End { position: state.position + y[0], velocity: y[1] });
            }
            let wanted = solver.h();
            if wanted > left {
                solver.set_h(left);
            }
            solver.step(&ode).map_err(|_| integration_failed())?;
            if matches!(solver.status(), Status::RejectedStep) {
                rejected += 1;
                if rejected > 60 || !solver.h().is_finite() {
                    return Err(integration_failed());
                }
                continue;
            }
            rejected = 0;
            if !(solver.y()[0].is_finite() && solver.y()[1].is_finite()) {
                return Err(integration_failed());
            }
            if wanted <= left {
                h = wanted;
            }
            let (a, b) = (solver.t_prev(), solver.t());
            let speed_at_end = s * solver.y()[1];
            let mut speed_and_rise = |t: f64| {
                solver
                    .interpolate(t)
                    .map_or([f64::NAN; 2], |y| [s * y[1], s * ode.acceleration(t, y[0], y[1])])
            };
            let Some((low, high)) = bracket(&mut speed_and_rise, a, b, speed_at_end) else { continue };
            let mut at = root(low, high, |t| speed_and_rise(t)[0]);
            // Integrate up to it, and correct by Newton's method applied to the integration itself.
            let from = *solver.y_prev();
            let mut y = from;
            for _ in 0..4 {
                y = from;
                if at > a {
                    let mut fine = make(at - a);
                    fine.init(&ode, a, at, &from).map_err(|_| integration_failed())?;
                    let mut steps = 0;
                    while at - fine.t() > 4e-16 * at.abs() {
                        steps += 1;
                        if steps > 1000 {
                            return Err(integration_failed());
                        }
                        if fine.h() > at - fine.t() {
                            fine.set_h(at - fine.t());
                        }
                        fine.step(&ode).map_err(|_| integration_failed())?;
                    }
                    y = *fine.y();
                }
                let slope = ode.acceleration(at, y[0], y[1]);
                let shift = y[1] / slope;
                if !shift.is_finite() || shift.abs() > 0.1 * (b - a) || shift.abs() <= 1e-15 * at {
                    break;
                }
                at = (at - shift).clamp(a, reach);
            }
            return Ok(Reached::Turn { at, position: state.position + y[0] });
        }
    }
}

fn integration_failed() -> Error {
    Error::DoesNotHold {
        method: "the integration of a smooth friction law",
        why: "the law is too stiff, or its value is not a finite number",
    }
}

/// Two times between which the speed first passes from above zero to zero or below.
fn bracket(
    speed_and_rise: &mut impl FnMut(f64) -> [f64; 2],
    a: f64,
    b: f64,
    at_end: f64,
) -> Option<(f64, f64)> {
    const PLACES: u32 = 8;
    let t = |i: u32| a + (b - a) * f64::from(i) / f64::from(PLACES + 1);
    let mut rising = speed_and_rise(a)[1] >= 0.0;
    for i in 1..=PLACES + 1 {
        let [inside, rise] = speed_and_rise(t(i));
        let value = if i > PLACES { at_end } else { inside };
        // At the start the speed may be zero and increasing.
        if value <= 0.0 {
            return Some((t(i - 1), t(i)));
        }
        let rises = rise >= 0.0;
        if !rising && rises {
            // The speed has a minimum here, and may have reached zero.
            let lowest = root(t(i - 1), t(i), |t| speed_and_rise(t)[1]);
            if speed_and_rise(lowest)[0] <= 0.0 {
                return Some((t(i - 1), lowest));
            }
        }
        rising = rises;
    }
    None
}

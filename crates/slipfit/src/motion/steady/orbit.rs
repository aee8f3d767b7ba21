//! Periodic motion with any number of stops, by shooting with the event machine, and its stability.

use super::{HarmonicDrive, Phasor};
use crate::error::Error;
use crate::model::oscillator::Oscillator;
use crate::motion::simulate::{Drive, Event, EventKind, Friction, Motion};
use crate::numeric::quadrature::integrate;
use std::f64::consts::PI;

/// A motion with the period of the drive, with any turning points and stops.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    drive: HarmonicDrive,
    oscillator: Oscillator,
    friction: Friction,
    start: (f64, f64),
    /// Each segment at its start.
    segments: Vec<Motion>,
    events: Vec<Event>,
    multipliers: [Phasor; 2],
    residual: f64,
    cycles: u32,
}

/// Result of the search.
struct Found {
    start: (f64, f64),
    matrix: [[f64; 2]; 2],
    residual: f64,
    cycles: u32,
}

/// Options of the search for an orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitOptions {
    /// Start of the search: position and velocity at the drive's crest; `None` starts from rest.
    pub start: Option<(f64, f64)>,
    /// Number of drive cycles run before shooting begins.
    pub settle_cycles: u32,
    /// Number of cycles after which the search gives up.
    pub max_cycles: u32,
}

impl Default for OrbitOptions {
    fn default() -> Self {
        Self { start: None, settle_cycles: 4, max_cycles: 4000 }
    }
}

/// Slowest drive relative to the natural frequency: its cycle has as many events as natural periods.
const SLOWEST: f64 = 1e-5;
/// Number of start values tried if the one from rest leads to no orbit, and the number of cycles for each.
const OTHER_STARTS: u32 = 256;
const OTHER_START_CYCLES: u32 = 200;

/// Start values spread evenly over three drive amplitudes either way (the additive recurrence of the plastic number):
/// with static friction above kinetic friction the event map is discontinuous, and an orbit may be reached from some
/// start values only.
fn other_starts(amplitude: f64, omega_0: f64) -> impl Iterator<Item = (f64, f64)> {
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    (1..=OTHER_STARTS).map(move |k| {
        let [x, v] = STEP.map(|a| 3.0 * amplitude * (2.0 * (f64::from(k) * a).fract() - 1.0));
        (x, v * omega_0)
    })
}

/// The map over one cycle of the drive, and its scales.
struct Sought<'a> {
    begin: &'a dyn Fn((f64, f64)) -> Result<Motion, Error>,
    period: f64,
    amplitude: f64,
    omega_0: f64,
}

impl Sought<'_> {
    /// The orbit reached from a start value, if any.
    fn from(&self, mut z: (f64, f64), settle_cycles: u32, max_cycles: u32) -> Result<Option<Found>, Error> {
        let cycle = |z: (f64, f64)| Ok::<_, Error>((self.begin)(z)?.tangent(self.period));
        let mut cycles = 0;
        while cycles < settle_cycles {
            let s = cycle(z)?.state;
            z = (s.position, s.velocity);
            cycles += 1;
        }
        let size = |d: (f64, f64)| d.0.abs().max(d.1.abs() / self.omega_0);
        let mut best = f64::INFINITY;
        while cycles < max_cycles {
            let t = cycle(z)?;
            cycles += 1;
            let gap = (t.state.position - z.0, t.state.velocity - z.1);
            let scale = size(z).max(self.amplitude * 1e-3).max(size((t.state.position, t.state.velocity)));
            let residual = size(gap) / scale;
            if residual < 4e-15 || (residual < 1e-12 && residual >= 0.5 * best) {
                return Ok(Some(Found { start: z, matrix: t.matrix, residual, cycles }));
            }
            let [[a, b], [c, d]] = t.matrix;
            let det = (a - 1.0) * (d - 1.0) - b * c;
            let step = (-((d - 1.0) * gap.0 - b * gap.1) / det, -((a - 1.0) * gap.1 - c * gap.0) / det);
            let newton = (z.0 + step.0, z.1 + step.1);
            z = (t.state.position, t.state.velocity);
            if newton.0.is_finite() && newton.1.is_finite() && size(newton) < 1e90 {
                let n = cycle(newton)?.state;
                cycles += 1;
                let there = size((n.position - newton.0, n.velocity - newton.1)) / scale;
                if there < residual {
                    z = newton;
                }
            }
            best = best.min(residual);
        }
        Ok(None)
    }

    /// Whether the motion, continued from a start value, settles to a period of two to eight cycles.
    fn repeats_later(&self, start: (f64, f64), settle_cycles: u32) -> Result<bool, Error> {
        let mut motion = (self.begin)(start)?;
        let mut at = |cycle: u32| motion.state_at(f64::from(cycle) * self.period);
        let then = at(settle_cycles)?;
        for cycle in 1..=8 {
            let now = at(settle_cycles + cycle)?;
            let gap = (now.position - then.position).abs();
            if gap.max((now.velocity - then.velocity).abs() / self.omega_0) < 1e-9 * self.amplitude {
                return Ok(cycle > 1);
            }
        }
        Ok(false)
    }
}

impl PeriodicOrbit {
    /// Finds a periodic orbit by Newton's method on the map over one cycle of the drive, with the exact Jacobian of
    /// the map; if this fails, by running on.
    ///
    /// An orbit that sticks for the full cycle is found too: any position inside the zone then repeats, and the one
    /// reached is returned. If several orbits exist, the one reached from `start` is returned. Without a `start`, the
    /// search begins from rest; if that leads to no orbit, it begins from other start values spread over the plane,
    /// and a stable orbit is preferred to an unstable one ([`PeriodicOrbit::is_stable`]).
    ///
    /// # Errors
    /// [`Error::DoesNotHold`] if none was found within `max_cycles`: no damping at resonance, or a period other than
    /// the drive's (if static friction exceeds kinetic friction, one random case in 100 000 settles to two or three
    /// cycles and has no orbit of one); [`Error::Parameter`] for a drive slower than 1e-5 of the natural frequency.
    pub fn find(
        oscillator: &Oscillator,
        drive: &HarmonicDrive,
        options: OrbitOptions,
    ) -> Result<Self, Error> {
        let friction = Friction::of(oscillator);
        Self::find_with_friction(oscillator, friction, drive, options)
    }

    /// The same with friction that differs between the directions.
    ///
    /// # Errors
    /// As [`PeriodicOrbit::find`].
    pub(crate) fn find_with_friction(
        oscillator: &Oscillator,
        friction: Friction,
        drive: &HarmonicDrive,
        options: OrbitOptions,
    ) -> Result<Self, Error> {
        let slowest = SLOWEST * oscillator.omega_0();
        if drive.omega() < slowest {
            return Err(Error::Parameter {
                name: "omega",
                value: drive.omega(),
                range: "with stops, at least 1e-5 of the natural frequency",
            });
        }
        let period = 2.0 * PI / drive.omega();
        let tone = Drive::harmonic(drive.amplitude(), drive.omega())?;
        let begin = |(x, v): (f64, f64)| Motion::with_friction(oscillator, friction, tone.clone(), 0.0, x, v);
        let collect = |found: &Found| -> Result<Self, Error> {
            Ok(Self::collect(oscillator, friction, drive, begin(found.start)?, found))
        };
        let sought =
            Sought { begin: &begin, period, amplitude: drive.amplitude(), omega_0: oscillator.omega_0() };
        let first =
            sought.from(options.start.unwrap_or((0.0, 0.0)), options.settle_cycles, options.max_cycles)?;
        if let Some(found) = first {
            return collect(&found);
        }
        let mut unstable = None;
        if options.start.is_none() {
            for start in other_starts(drive.amplitude(), oscillator.omega_0()) {
                let Some(found) = sought.from(start, 0, OTHER_START_CYCLES)? else { continue };
                let orbit = collect(&found)?;
                if orbit.is_stable() {
                    return Ok(orbit);
                }
                unstable.get_or_insert(orbit);
            }
        }
        if let Some(orbit) = unstable {
            return Ok(orbit);
        }
        let start = options.start.unwrap_or((0.0, 0.0));
        let why = if sought.repeats_later(start, options.max_cycles)? {
            "the motion settled to one that repeats only after two cycles of the drive or more"
        } else {
            "none was found: there is no damping at resonance, or the period is a different one"
        };
        Err(Error::DoesNotHold { method: "a motion that repeats with the drive", why })
    }

    fn collect(
        oscillator: &Oscillator,
        friction: Friction,
        drive: &HarmonicDrive,
        mut motion: Motion,
        found: &Found,
    ) -> Self {
        let period = 2.0 * PI / drive.omega();
        let (mut segments, mut events) = (Vec::new(), Vec::new());
        loop {
            let (length, _) = motion.segment_end();
            segments.push(motion.clone());
            if length.is_infinite() || length >= motion.until(period) {
                break;
            }
            events.extend(motion.advance());
        }
        let [[a, b], [c, d]] = found.matrix;
        let (half, det) = (0.5 * (a + d), a * d - b * c);
        let root = Phasor::new(half * half - det, 0.0).sqrt();
        Self {
            drive: *drive,
            oscillator: *oscillator,
            friction,
            start: found.start,
            segments,
            events,
            multipliers: [root + half, -root + half],
            residual: found.residual,
            cycles: found.cycles,
        }
    }

    /// Position and velocity at the drive's crest.
    pub fn start(&self) -> (f64, f64) {
        self.start
    }

    /// Events of one cycle, with time counted from the drive's crest.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Number of stops per cycle.
    pub fn stops(&self) -> usize {
        self.events.iter().filter(|e| matches!(e.kind, EventKind::Stop | EventKind::Rest)).count()
    }

    /// Floquet multipliers: the factors by which a small disturbance grows per cycle. The orbit is stable if both are
    /// below one in magnitude. A stop makes one of them zero.
    pub fn multipliers(&self) -> [Phasor; 2] {
        self.multipliers
    }

    /// Whether small disturbances decay (false for a full stick, which preserves them).
    pub fn is_stable(&self) -> bool {
        self.multipliers.iter().all(|m| m.norm() < 1.0)
    }

    /// Closure error of the orbit: largest difference of position and velocity/omega_0 after a cycle, relative to the
    /// motion.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Number of drive cycles run to find it.
    pub fn cycles(&self) -> u32 {
        self.cycles
    }

    /// Displacement and velocity, with time counted from the drive's crest.
    pub fn state(&self, time_s: f64) -> (f64, f64) {
        let t = time_s.rem_euclid(2.0 * PI / self.drive.omega());
        let i = self.segments.partition_point(|m| m.state().time_s <= t).saturating_sub(1);
        let mut motion = self.segments[i].clone();
        let u = motion.until(t).max(0.0);
        motion.peek(u)
    }

    /// Turning points of one cycle, with time counted from the drive's crest.
    pub fn turning_points(&self) -> Vec<(f64, f64)> {
        let turned = |e: &&Event| matches!(e.kind, EventKind::Turn | EventKind::Stop | EventKind::Rest);
        self.events.iter().filter(turned).map(|e| (e.time_s, e.position)).collect()
    }

    /// `∫ f(t, x, v) dt` over a cycle.
    pub(super) fn integral(&self, f: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let period = 2.0 * PI / self.drive.omega();
        let mut sum = 0.0;
        for (i, m) in self.segments.iter().enumerate() {
            let from = m.state().time_s;
            let to = self.segments.get(i + 1).map_or(period, |n| n.state().time_s);
            let m = std::cell::RefCell::new(m.clone());
            sum += integrate(
                &|u: f64| {
                    let (x, v) = m.borrow_mut().peek(u);
                    f(from + u, x, v)
                },
                0.0,
                to - from,
            );
        }
        sum
    }

    /// Phasor of harmonic `n`, with time counted from the drive's crest; `n = 0` gives the mean.
    pub fn harmonic(&self, n: u32) -> Phasor {
        self.harmonic_counted(n).0
    }

    /// [`Self::harmonic`] and the number of states evaluated for its integrals.
    pub(super) fn harmonic_counted(&self, n: u32) -> (Phasor, u64) {
        let omega = self.drive.omega();
        let w = f64::from(n) * omega;
        let factor = if n == 0 { 0.5 } else { 1.0 } * omega / PI;
        let states = std::cell::Cell::new(0);
        let counted = |value: f64| {
            states.set(states.get() + 1);
            value
        };
        let re = self.integral(|t, x, _| counted(x * (w * t).cos()));
        let im = self.integral(|t, x, _| counted(-x * (w * t).sin()));
        (Phasor::new(re, im) * factor, states.get())
    }

    /// Friction force on the mass over the stiffness, sliding or sticking, positive along positive `x`; time is
    /// counted from the drive's crest.
    ///
    /// While sliding it is `-F sgn(x')`; while sticking it is the force that keeps the mass in place, `k (x - u)`, at
    /// most `F_s`. It jumps at turning points, stops and (for `F_s > F`) releases.
    pub fn friction(&self, time_s: f64) -> f64 {
        let t = time_s.rem_euclid(2.0 * PI / self.drive.omega());
        let i = self.segments.partition_point(|m| m.state().time_s <= t).saturating_sub(1);
        self.friction_in(&self.segments[i], t)
    }

    fn friction_in(&self, segment: &Motion, time_s: f64) -> f64 {
        let [up, down] = self.friction.kinetic();
        match segment.direction() {
            d if d > 0.0 => -up,
            d if d < 0.0 => down,
            _ => segment.state().position - self.drive.amplitude() * (self.drive.omega() * time_s).cos(),
        }
    }

    /// Phasor of harmonic `n` of the friction force over the stiffness, with time counted from the drive's crest;
    /// `n = 0` gives the mean.
    ///
    /// This is the Fourier series of friction with sticking: Vitorino, Vieira and Rodrigues suggest, after their eq.
    /// (8), that static friction "can also be treated using an appropriate Fourier series", without carrying it out.
    /// Without stops it is the square wave of eq. (1). With `D(n omega)` the dynamic stiffness, each harmonic of the
    /// motion responds to its own harmonic of the force: `X_n = (U_n + f_n) k/D(n omega)`.
    pub fn friction_harmonic(&self, n: u32) -> Phasor {
        let omega = self.drive.omega();
        let period = 2.0 * PI / omega;
        let [up, down] = self.friction.kinetic();
        let mut sum = Phasor::default();
        for (i, m) in self.segments.iter().enumerate() {
            let from = m.state().time_s;
            let to = self.segments.get(i + 1).map_or(period, |next| next.state().time_s);
            // ∫ e^(-i k omega t) dt over the segment.
            let wave = |k: i64| {
                let w = k as f64 * omega;
                let half = 0.5 * (to - from);
                let sinc = if w == 0.0 { 1.0 } else { (w * half).sin() / (w * half) };
                Phasor::from_polar(2.0 * half * sinc, -w * (from + half))
            };
            let n = i64::from(n);
            sum += match m.direction() {
                d if d > 0.0 => wave(n) * -up,
                d if d < 0.0 => wave(n) * down,
                _ => {
                    wave(n) * m.state().position
                        - (wave(n - 1) + wave(n + 1)) * (0.5 * self.drive.amplitude())
                }
            };
        }
        let factor = if n == 0 { 0.5 } else { 1.0 } * omega / PI;
        sum * factor
    }

    /// The friction of this orbit.
    pub(crate) fn friction_law(&self) -> Friction {
        self.friction
    }

    /// The oscillator.
    pub fn oscillator(&self) -> &Oscillator {
        &self.oscillator
    }
}

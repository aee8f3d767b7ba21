//! The event machine: arcs of sliding, rests, and the events that separate them.

use super::arc::Arc;
use super::certify::first_zero;
use super::drive::Drive;
use super::event::{Event, EventKind, Friction, State};
use super::local::Local;
use super::transition::Constants;
use crate::error::Error;
use crate::model::oscillator::{Oscillator, finite, moderate};
use crate::numeric::double_double::Dd;

/// Any motion of `m x'' + gamma x' + k x + F sgn(x') = k u(t)`, event by event.
///
/// Between events the motion has a closed form; there is no time step and no tolerance. Events are found by steps
/// that are proved free of zeros by a bound on the derivatives, so that two events are both found, however close they
/// are; a stop lasts exactly as long as `|k (u - x)| <= F_s`. Nothing is stored: events and states are computed on
/// request.
///
/// Rounding adds a few 1e-16 of the amplitude per event.
///
/// ```
/// # use slipfit::{Oscillator, motion::simulate::{Drive, EventKind, Motion}};
/// let o = Oscillator::kinematic(1.0, 0.01, 0.1)?;
/// let mut motion = Motion::new(&o, Drive::harmonic(1.0, 0.3)?, 0.0, 0.0, 0.0)?;
/// let stops = motion.events(100.0).filter(|e| e.kind == EventKind::Stop).count();
/// assert!(stops > 5); // slow drive: the mass sticks and slips
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Motion {
    k: Constants,
    friction: Friction,
    drive: Drive,
    time: Dd,
    position: f64,
    velocity: f64,
    /// 1, -1, or 0 at rest.
    direction: f64,
    /// Acceleration at the start if known more accurately than from the state: at a release.
    pull: Option<f64>,
    local: Local,
    segment: Option<Segment>,
    /// Number of successive segments of zero duration, and how often time was advanced to end such a sequence.
    stalls: u32,
    leaps: u32,
    /// Time since the current slip began from rest, s, and the duration of the last slip in each direction.
    sliding_for: f64,
    slips: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    arc: Option<Arc>,
    length: f64,
    /// Length in double-double precision, if known.
    exact: Option<Dd>,
    /// Displacement over the segment, if already known.
    moved: Option<f64>,
    end: End,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    Turn,
    Release(f64),
    Continue,
    Drive,
}

impl Motion {
    /// A motion that starts at `time_s` from `position` and `velocity`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a value that is not finite or beyond 1e100.
    pub fn new(
        oscillator: &Oscillator,
        drive: Drive,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        Self::with_friction(oscillator, Friction::of(oscillator), drive, time_s, position, velocity)
    }

    /// The same with friction that differs between the directions.
    ///
    /// # Errors
    /// As [`Motion::new`].
    pub fn with_friction(
        oscillator: &Oscillator,
        friction: Friction,
        drive: Drive,
        time_s: f64,
        position: f64,
        velocity: f64,
    ) -> Result<Self, Error> {
        finite("time_s", time_s)?;
        for (name, value) in [
            ("position", position),
            ("velocity", velocity),
            ("velocity / omega_0", velocity / oscillator.omega_0()),
        ] {
            moderate(name, value)?;
        }
        let mut motion = Self {
            k: Constants::new(oscillator),
            friction,
            drive,
            time: Dd::from_f64(time_s),
            position,
            velocity,
            direction: if velocity == 0.0 { 0.0 } else { velocity.signum() },
            pull: None,
            local: Local::default(),
            segment: None,
            stalls: 0,
            leaps: 0,
            sliding_for: 0.0,
            slips: [0.0; 2],
        };
        motion.localise();
        if velocity == 0.0 {
            motion.decide();
        }
        Ok(motion)
    }

    /// Time and state reached: the start of the current segment.
    pub fn state(&self) -> State {
        State { time_s: self.time.value(), position: self.position, velocity: self.velocity }
    }

    /// The next event up to `until_s`; `None` if there is none.
    pub fn next_event(&mut self, until_s: f64) -> Option<Event> {
        loop {
            let segment = self.segment();
            // A rest without end has no end time to compare.
            if segment.length.is_infinite() || until_s.is_nan() {
                return None;
            }
            if self.time.add(Dd::from_f64(segment.length)).hi > until_s {
                return None;
            }
            if let Some(event) = self.commit(segment) {
                return Some(event);
            }
        }
    }

    /// Events up to `until_s`, one at a time.
    pub fn events(&mut self, until_s: f64) -> impl Iterator<Item = Event> {
        std::iter::from_fn(move || self.next_event(until_s))
    }

    /// State at `time_s`; successive times must not decrease.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `time_s` lies before the segment already reached, or is
    /// not finite.
    pub fn state_at(&mut self, time_s: f64) -> Result<State, Error> {
        finite("time_s", time_s)?;
        loop {
            let segment = self.segment();
            let u = Dd::from_f64(time_s).sub(self.time).value();
            // Event times are rounded when returned: allow a step back by that much.
            if u < -4e-16 * time_s.abs() {
                return Err(Error::Parameter {
                    name: "time_s",
                    value: time_s,
                    range: "not before the last event reached",
                });
            }
            if u <= segment.length {
                let u = u.max(0.0);
                return Ok(match segment.arc {
                    None => State { time_s, position: self.position, velocity: 0.0 },
                    Some(arc) => {
                        let p = arc.at(&self.k, &self.local, u);
                        State { time_s, position: arc.start + p.moved, velocity: p.velocity }
                    }
                });
            }
            self.commit(segment);
        }
    }

    /// Displacement at non-decreasing times.
    ///
    /// # Errors
    /// As [`Motion::state_at`]; [`Error::Length`] unless `out` is as long as `time_s`.
    pub fn fill(&mut self, time_s: &[f64], out: &mut [f64]) -> Result<(), Error> {
        if time_s.len() != out.len() {
            return Err(Error::Length { name: "out", found: out.len(), expected: time_s.len() });
        }
        for (t, x) in time_s.iter().zip(out) {
            *x = self.state_at(*t)?.position;
        }
        Ok(())
    }

    /// Length of the current segment, and for a slip its final acceleration.
    pub(crate) fn segment_end(&mut self) -> (f64, Option<(f64, Constants)>) {
        let segment = self.segment();
        let last = segment.arc.map(|a| (a.at(&self.k, &self.local, segment.length).acceleration, self.k));
        (segment.length, last)
    }

    /// Seconds from the start of the current segment to `time_s`.
    pub(crate) fn until(&self, time_s: f64) -> f64 {
        Dd::from_f64(time_s).sub(self.time).value()
    }

    /// Position and velocity at the time `u` in the current segment; the motion does not advance.
    pub(crate) fn peek(&mut self, u: f64) -> (f64, f64) {
        match self.segment().arc {
            None => (self.position, 0.0),
            Some(arc) => {
                let p = arc.at(&self.k, &self.local, u);
                (arc.start + p.moved, p.velocity)
            }
        }
    }

    /// Advances to the next segment.
    pub(crate) fn advance(&mut self) -> Option<Event> {
        let segment = self.segment();
        self.commit(segment)
    }

    /// Acceleration at the start of the current slip, without its viscous part.
    pub(crate) fn pull_here(&self) -> f64 {
        let s = self.direction;
        let x_f = self.friction.kinetic[Friction::side(s)];
        self.pull.unwrap_or(self.k.square * (self.local.value - self.position - s * x_f))
    }

    /// Slope of the drive at the start of the current segment, per s.
    pub(crate) fn drive_slope(&self) -> f64 {
        self.local.slope_at_start()
    }

    /// Direction of motion: 1, -1, or 0 at rest.
    pub fn direction(&self) -> f64 {
        self.direction
    }

    fn segment(&mut self) -> Segment {
        if let Some(segment) = self.segment {
            return segment;
        }
        let segment = if self.direction == 0.0 { self.rest_segment() } else { self.slip_segment() };
        self.segment = Some(segment);
        segment
    }

    fn localise(&mut self) {
        self.drive.localise(&self.k, self.time, &mut self.local);
    }

    /// At zero velocity: decides whether the mass sticks or slides, and in which direction.
    fn decide(&mut self) {
        let e = self.local.value - self.position;
        self.velocity = 0.0;
        self.direction = if e > self.friction.holding[0] {
            1.0
        } else if -e > self.friction.holding[1] {
            -1.0
        } else {
            0.0
        };
    }

    fn slip_segment(&mut self) -> Segment {
        let s = self.direction;
        let x_f = self.friction.kinetic[Friction::side(s)];
        let pull = self.pull.take().unwrap_or(self.k.square * (self.local.value - self.position - s * x_f));
        let arc = Arc { start: self.position, velocity: self.velocity, direction: s, pull };
        let segment = |length, exact, end| Segment { arc: Some(arc), length, exact, moved: None, end };
        let drive_end = if self.local.stage_ends { End::Drive } else { End::Continue };
        if self.local.is_constant() {
            let (length, exact) = if self.velocity == 0.0 {
                (self.k.half_period.hi, Some(self.k.half_period))
            } else {
                let (w, v) = (self.k.omega_d, self.velocity);
                (f64::atan2(w * v * s, (self.k.delta * v - pull) * s) / w, None)
            };
            if length > self.local.end {
                return segment(self.local.end, None, drive_end);
            }
            return segment(length, exact, End::Turn);
        }
        let last_time = self.slips[Friction::side(s)];
        if self.velocity == 0.0
            && let Some((length, moved)) = arc.turn_near(&self.k, &self.local, last_time)
            && length < self.local.end
        {
            return Segment { arc: Some(arc), length, exact: None, moved: Some(moved), end: End::Turn };
        }
        let reach = self.local.end.min(self.k.reach);
        match arc.first_turn(&self.k, &self.local, reach) {
            // If numbers underflow, a slip may have zero length: time must advance nevertheless.
            Some(u) if self.stalls > 8 => segment(u.max(self.leap().min(reach)), None, End::Turn),
            Some(u) => segment(u, None, End::Turn),
            None if reach < self.local.end => segment(reach, None, End::Continue),
            None => segment(reach, None, drive_end),
        }
    }

    /// Duration of the rest: until the pull leaves `[-F_s-, F_s+]`.
    fn rest_segment(&mut self) -> Segment {
        let [up, down] = self.friction.holding;
        let e = self.local.value - self.position;
        let drive_end = if self.local.stage_ends { End::Drive } else { End::Continue };
        let stay = |length, end| Segment { arc: None, length, exact: None, moved: None, end };
        if self.local.is_constant() || self.never_slips() {
            return stay(self.local.end, drive_end);
        }
        if self.stalls <= 3
            && let Some((u, s)) = self.local.first_exit(e, [up, down])
        {
            // One harmonic: the time has a closed form and recurs each period.
            return if u < self.local.end {
                stay(u, End::Release(s))
            } else {
                stay(self.local.end, drive_end)
            };
        }
        // Look a few periods ahead at a time, not to infinity.
        let [swing, d1, d2, d3] = self.local.bounds(self.k.reach);
        let span = (64.0 * self.k.reach).max(if d2 > 0.0 { 64.0 * d1 / d2 } else { 0.0 });
        let reach = self.local.end.min(span);
        let noise = 2e-16 * (self.local.value.abs() + self.position.abs() + swing);
        // A slip of zero duration between two rests would repeat forever.
        let start = if self.stalls > 3 { self.leap().min(reach) } else { 0.0 };
        let d3 = d3.max(f64::MIN_POSITIVE);
        let trust = 0.25 * self.k.reach.min(if d2 > 0.0 { d1 / d2 } else { reach });
        let mut length = reach;
        let mut end = if reach < self.local.end { End::Continue } else { drive_end };
        for (s, limit) in [(1.0, up), (-1.0, down)] {
            let found = first_zero(start, trust, length, d3, |u| {
                let [rise, slope, curvature] = self.local.rise(u);
                [limit - s * (e + rise), -s * slope, -s * curvature, noise]
            });
            if let Some(u) = found {
                length = u;
                end = End::Release(s);
            }
        }
        stay(length, end)
    }

    /// Time to skip if events would repeat without time passing; it grows with each use.
    fn leap(&self) -> f64 {
        self.k.reach * (1e-9 * f64::from(self.leaps.min(30)).exp2()).min(0.05)
    }

    fn never_slips(&self) -> bool {
        let (low, high) = self.local.range;
        let [up, down] = self.friction.holding;
        high - self.position <= up && self.position - low <= down
    }

    fn commit(&mut self, segment: Segment) -> Option<Event> {
        if let Some(arc) = segment.arc {
            let begun = if arc.velocity == 0.0 { 0.0 } else { self.sliding_for };
            self.sliding_for = begun + segment.length;
            if segment.end == End::Turn {
                self.slips[Friction::side(arc.direction)] = self.sliding_for;
            }
            if let Some(moved) = segment.moved {
                (self.position, self.velocity) = (arc.start + moved, 0.0);
            } else {
                let end = arc.at(&self.k, &self.local, segment.length);
                (self.position, self.velocity) = (arc.start + end.moved, end.velocity);
            }
        }
        if segment.length <= 1e-12 * self.k.reach {
            self.stalls += 1;
        } else if self.stalls > 3 {
            (self.stalls, self.leaps) = (0, self.leaps + 1);
        } else {
            self.stalls = 0;
            if segment.length > 0.1 * self.k.reach {
                self.leaps = 0;
            }
        }
        self.time = match self.local.end_time {
            Some(at) if segment.length == self.local.end => Dd::from_f64(at),
            _ => self.time.add(segment.exact.unwrap_or(Dd::from_f64(segment.length))),
        };
        self.segment = None;
        self.localise();
        let kind = match segment.end {
            End::Continue => return None,
            End::Drive => {
                if self.velocity == 0.0 {
                    self.decide();
                }
                EventKind::DriveChange
            }
            End::Release(s) => {
                let i = Friction::side(s);
                self.direction = s;
                self.pull = Some(self.k.square * s * (self.friction.holding[i] - self.friction.kinetic[i]));
                EventKind::Release
            }
            End::Turn => self.turned(),
        };
        Some(self.event(kind))
    }

    /// Decides what follows after the velocity has become zero.
    fn turned(&mut self) -> EventKind {
        self.decide();
        if self.direction != 0.0 {
            EventKind::Turn
        } else if self.never_slips() {
            EventKind::Rest
        } else {
            EventKind::Stop
        }
    }

    fn event(&self, kind: EventKind) -> Event {
        Event {
            kind,
            time_s: self.time.value(),
            position: self.position,
            velocity: self.velocity,
            direction: self.direction,
            drive: self.local.value,
        }
    }

    /// The drive relative to the present time.
    #[cfg(feature = "smooth-laws")]
    pub(super) fn local(&self) -> &Local {
        &self.local
    }

    /// Sets the state `u` later, reached by other means while sliding.
    #[cfg(feature = "smooth-laws")]
    pub(super) fn place(&mut self, u: f64, position: f64, velocity: f64) {
        self.time = match self.local.end_time {
            Some(at) if u == self.local.end => Dd::from_f64(at),
            _ => self.time.add(Dd::from_f64(u)),
        };
        (self.position, self.velocity) = (position, velocity);
        self.pull = None;
        self.segment = None;
        self.localise();
    }

    /// Records a turning point here: the mass sticks, or slides back.
    #[cfg(feature = "smooth-laws")]
    pub(super) fn turn_here(&mut self) -> Event {
        let kind = self.turned();
        self.event(kind)
    }

    /// Records the change to the drive's next stage.
    #[cfg(feature = "smooth-laws")]
    pub(super) fn drive_changed(&mut self) -> Event {
        if self.velocity == 0.0 {
            self.decide();
        }
        self.event(EventKind::DriveChange)
    }
}

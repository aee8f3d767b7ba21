//! Events of a motion, and the friction that decides between them.

use crate::error::Error;
use crate::model::oscillator::Oscillator;

/// Sliding friction that may differ between the two directions, as displacements `F/k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    pub(super) kinetic: [f64; 2],
    pub(super) holding: [f64; 2],
}

impl Friction {
    /// The oscillator's own friction, equal in both directions.
    pub fn of(oscillator: &Oscillator) -> Self {
        let (f, s) = (oscillator.friction_displacement(), oscillator.static_displacement());
        Self { kinetic: [f, f], holding: [s, s] }
    }

    /// Kinetic friction against motion to positive and to negative `x`, and static friction against a pull to
    /// positive and to negative `x`.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `0 <= kinetic <= static < infinity` in both directions.
    pub fn asymmetric(kinetic: [f64; 2], holding: [f64; 2]) -> Result<Self, Error> {
        for i in 0..2 {
            crate::model::oscillator::at_least_zero("kinetic friction displacement", kinetic[i])?;
            if !(kinetic[i]..=1e100).contains(&holding[i]) {
                return Err(Error::Parameter {
                    name: "static friction displacement",
                    value: holding[i],
                    range: "kinetic <= static <= 1e100 (F_s >= F)",
                });
            }
        }
        Ok(Self { kinetic, holding })
    }

    /// Kinetic friction displacements `F/k` against motion to positive and to negative `x`.
    pub fn kinetic(&self) -> [f64; 2] {
        self.kinetic
    }

    /// Static friction displacements `F_s/k` against a pull to positive and to negative `x`.
    pub fn holding(&self) -> [f64; 2] {
        self.holding
    }

    #[inline]
    pub(super) fn side(direction: f64) -> usize {
        usize::from(direction < 0.0)
    }
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum EventKind {
    /// Velocity changed sign without a stop.
    Turn,
    /// The mass stopped; it may be released later.
    Stop,
    /// The mass stopped, and the remaining drive will not release it.
    Rest,
    /// The pull exceeded static friction and the mass began to slide.
    Release,
    /// The drive passed to its next stage.
    DriveChange,
}

/// One event of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Kind of the event.
    pub kind: EventKind,
    /// Time, s.
    pub time_s: f64,
    /// Displacement.
    pub position: f64,
    /// Velocity, per s: zero except at a drive change.
    pub velocity: f64,
    /// Direction of motion after the event: 1, -1, or 0 at rest.
    pub direction: f64,
    /// Position of the base.
    pub drive: f64,
}

/// State of the motion at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// s
    pub time_s: f64,
    /// Displacement.
    pub position: f64,
    /// Its derivative, per s; exactly zero while sticking.
    pub velocity: f64,
}

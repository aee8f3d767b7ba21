//! Disturbances of simulated curves beyond an oscillator with viscous and sliding loss and white noise.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use slipfit::motion::steady::Phasor;
use slipfit::motion::steady::fundamental::{Point, fundamental};

/// One disturbance of a curve, and of its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Disturbance {
    /// White noise only.
    Nothing,
    /// A constant phasor of this part of the highest amplitude, at a random angle.
    Background(f64),
    /// A phase turn of this many degrees across the window.
    Delay(f64),
    /// Both of them.
    DelayAndBackground(f64, f64),
    /// A signal proportional to the drive and in phase with it.
    Crosstalk(f64),
    /// Noise proportional to each amplitude by the first factor, and a floor of the second factor times the highest
    /// amplitude.
    ProportionalNoise(f64, f64),
    /// A drag whose loss at the highest amplitude is this part of the viscous loss.
    Drag(f64),
    /// A shift of the natural frequency that is, at amplitude `Q x_0`, this part of the half width of the line.
    Duffing(f64),
}

/// Proportional noise and its floor.
pub(super) const PROPORTIONAL: [f64; 2] = [0.004, 2e-4];

pub(super) const DISTURBANCES: [Disturbance; 9] = [
    Disturbance::Nothing,
    Disturbance::Background(0.015),
    Disturbance::Background(0.05),
    Disturbance::Delay(60.0),
    Disturbance::DelayAndBackground(60.0, 0.05),
    Disturbance::Crosstalk(0.03),
    Disturbance::ProportionalNoise(PROPORTIONAL[0], PROPORTIONAL[1]),
    Disturbance::Drag(0.3),
    Disturbance::Duffing(0.5),
];

impl Disturbance {
    pub(super) fn name(self) -> String {
        let percent = |part: f64| format!("{} %", 100.0 * part);
        match self {
            Self::Nothing => "none".to_owned(),
            Self::Background(part) => format!("background {}", percent(part)),
            Self::Delay(degrees) => format!("delay {degrees}°"),
            Self::DelayAndBackground(degrees, part) => {
                format!("delay {degrees}°, background {}", percent(part))
            }
            Self::Crosstalk(part) => format!("crosstalk {}", percent(part)),
            Self::Drag(part) => format!("drag {}", percent(part)),
            Self::Duffing(part) => format!("Duffing {}", percent(part)),
            Self::ProportionalNoise(part, floor) => {
                format!("noise {} + {}", percent(part), percent(floor))
            }
        }
    }

    /// Whether the term also affects curves of amplitudes alone.
    pub(super) fn is_seen_in_amplitudes(self) -> bool {
        !matches!(self, Self::Delay(_) | Self::DelayAndBackground(..))
    }
}

/// Bisection steps in the search for an amplitude on which loss or frequency depends.
const HALVINGS: usize = 50;

/// The exact response of an oscillator whose loss or natural frequency may depend on the amplitude.
pub(super) struct Motion {
    omega_0: f64,
    delta: f64,
    x_0: f64,
    /// Rate of drag per amplitude, at `omega_0`.
    drag: f64,
    /// Shift of the natural frequency by the squared amplitude.
    duffing: f64,
}

impl Motion {
    /// `highest`: the amplitude at which the drag is the given part of the viscous loss.
    pub(super) fn new(disturbance: Disturbance, [omega_0, delta, x_0]: [f64; 3], highest: f64) -> Self {
        let drag = if let Disturbance::Drag(part) = disturbance { part * delta / highest } else { 0.0 };
        let free = x_0 * omega_0 / (2.0 * delta);
        let duffing =
            if let Disturbance::Duffing(part) = disturbance { part * delta / (free * free) } else { 0.0 };
        Self { omega_0, delta, x_0, drag, duffing }
    }

    /// The lock-in reading at one frequency; `None` if the motion is not of this kind (no fundamental).
    pub(super) fn at(&self, omega: f64, x_f: f64) -> Option<Phasor> {
        let response = |amplitude: f64| {
            let omega_0 = self.omega_0 + self.duffing * amplitude * amplitude;
            // Drag acts as a viscous loss proportional to the speed.
            let delta = self.delta + self.drag * amplitude * omega / self.omega_0;
            let point = Point { omega, omega_0, detuning: omega - omega_0, delta, x_0: self.x_0, x_f };
            fundamental(&point).map(|f| f.value)
        };
        if self.drag == 0.0 && self.duffing == 0.0 {
            return response(0.0);
        }
        let [mut low, mut high] = [0.0, self.x_0 * self.omega_0 / self.delta];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if response(middle)?.norm() > middle { &mut low } else { &mut high }) = middle;
        }
        response(low)
    }
}

/// The random parameters of one simulated instrument.
pub(super) struct Chain {
    pub(super) offset: f64,
    /// As a part of the highest amplitude.
    pub(super) background: Phasor,
    /// Phase turn across half the window, rad.
    pub(super) turn: f64,
}

impl Chain {
    pub(super) fn new(disturbance: Disturbance, rng: &mut ChaCha8Rng) -> Self {
        let angle = rng.random_range(-PI..PI);
        let offset = rng.random_range(-PI..PI);
        let turn = |degrees: f64| 0.5 * f64::to_radians(degrees);
        let none = Phasor::new(0.0, 0.0);
        let (background, turn) = match disturbance {
            Disturbance::Background(part) => (Phasor::from_polar(part, angle), 0.0),
            Disturbance::Crosstalk(part) => (Phasor::from_polar(part, offset), 0.0),
            Disturbance::Delay(degrees) => (none, turn(degrees)),
            Disturbance::DelayAndBackground(degrees, part) => {
                (Phasor::from_polar(part, angle), turn(degrees))
            }
            Disturbance::Nothing
            | Disturbance::ProportionalNoise(..)
            | Disturbance::Drag(_)
            | Disturbance::Duffing(_) => (none, 0.0),
        };
        Self { offset, background, turn }
    }
}

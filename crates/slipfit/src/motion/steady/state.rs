//! The steady motion by any method, with a common interface.

use super::drive::HarmonicDrive;
use super::exact::ClosedForm;
use super::orbit::{OrbitOptions, PeriodicOrbit};
use super::{Phasor, leading, lorentzian, series};
use crate::error::Error;
use crate::model::oscillator::Oscillator;
use crate::numeric::roots::root;
use std::f64::consts::PI;

/// A method for the steady motion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Fourier series, eqs. (1) to (7), with this many odd harmonics.
    Series {
        /// Number of odd harmonics, including the fundamental.
        terms: u32,
    },
    /// Leading term, eq. (8).
    Leading,
    /// Leading term with additional drag `c v|v|`.
    LeadingWithDrag {
        /// `a2 = 4 c omega/(3 pi m)`, per s and displacement.
        drag_rate: f64,
    },
    /// Effective Lorentzian, eq. (14).
    Lorentzian {
        /// The proportionality factor `a`, [`lorentzian::PAPER_A`] in the paper.
        a: f64,
    },
    /// Fourier series of friction with sticking, truncated after harmonic `highest`: the friction force of the exact
    /// motion, harmonic by harmonic ([`PeriodicOrbit::friction_harmonic`]).
    StickingSeries {
        /// The last harmonic kept, 1 or more.
        highest: u32,
    },
    /// Exact, two turning points per cycle and no stop.
    Exact,
    /// Exact, with any number of stops, by shooting.
    WithStops,
}

/// Energy dissipated per cycle over the stiffness; multiply by `k` for joules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleLoss {
    /// By viscous damping.
    pub viscous: f64,
    /// By sliding friction.
    pub sliding: f64,
    /// By drag.
    pub drag: f64,
}

impl CycleLoss {
    /// Sum of all losses.
    pub fn total(&self) -> f64 {
        self.viscous + self.sliding + self.drag
    }
}

/// A steady motion by any [`Method`]; time is counted from the crest of the drive.
#[derive(Debug, Clone)]
pub struct SteadyState {
    oscillator: Oscillator,
    drive: HarmonicDrive,
    method: Method,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    /// Odd harmonics 1, 3, 5 …; empty for a mass at rest.
    Fourier(Vec<Phasor>),
    /// The mean and every harmonic.
    General(Vec<Phasor>),
    Closed(ClosedForm),
    Orbit(Box<PeriodicOrbit>),
}

impl SteadyState {
    /// Computes the steady motion by one method.
    ///
    /// If a method finds no motion (a drive below its threshold), the result is a mass at rest.
    ///
    /// # Errors
    /// [`Error::DoesNotHold`] for [`Method::Exact`] if the motion has stops, and for [`Method::WithStops`] if no
    /// periodic motion was found; [`Error::Parameter`] for zero terms, `a <= 1`, or a negative drag rate.
    pub fn new(oscillator: &Oscillator, drive: &HarmonicDrive, method: Method) -> Result<Self, Error> {
        let fourier = |x: Option<Phasor>| Shape::Fourier(x.into_iter().collect());
        let shape = match method {
            Method::Series { terms: 0 } => {
                return Err(Error::Parameter { name: "terms", value: 0.0, range: "1 or more" });
            }
            Method::Series { terms } => {
                Shape::Fourier(series::solve(oscillator, drive, terms).unwrap_or_default())
            }
            Method::Leading => Shape::Fourier(series::solve(oscillator, drive, 1).unwrap_or_default()),
            Method::LeadingWithDrag { drag_rate } => {
                crate::model::oscillator::at_least_zero("drag_rate", drag_rate)?;
                fourier(leading::with_drag(oscillator, drive, drag_rate))
            }
            Method::Lorentzian { a } => {
                if a.is_nan() || a <= 1.0 {
                    return Err(Error::Parameter { name: "a", value: a, range: "a > 1" });
                }
                fourier(lorentzian::phasor(oscillator, drive, a))
            }
            Method::StickingSeries { highest: 0 } => {
                return Err(Error::Parameter { name: "highest", value: 0.0, range: "1 or more" });
            }
            Method::StickingSeries { highest } => {
                let orbit = PeriodicOrbit::find(oscillator, drive, OrbitOptions::default())?;
                Shape::General(series::sticking(&orbit, drive, highest))
            }
            Method::Exact => {
                let closed = ClosedForm::new(oscillator, drive).filter(ClosedForm::holds);
                Shape::Closed(closed.ok_or(Error::DoesNotHold {
                    method: "the closed form with two turns per cycle",
                    why: "the mass stops on the way, or does not move; use Method::WithStops",
                })?)
            }
            Method::WithStops => {
                let orbit = PeriodicOrbit::find(oscillator, drive, OrbitOptions::default())?;
                Shape::Orbit(Box::new(orbit))
            }
        };
        Ok(Self { oscillator: *oscillator, drive: *drive, method, shape })
    }

    pub(super) fn closed(oscillator: &Oscillator, drive: &HarmonicDrive, closed: ClosedForm) -> Self {
        Self { oscillator: *oscillator, drive: *drive, method: Method::Exact, shape: Shape::Closed(closed) }
    }

    pub(super) fn orbit(drive: &HarmonicDrive, orbit: PeriodicOrbit) -> Self {
        Self {
            oscillator: *orbit.oscillator(),
            drive: *drive,
            method: Method::WithStops,
            shape: Shape::Orbit(Box::new(orbit)),
        }
    }

    /// The method that computed it.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The drive.
    pub fn drive(&self) -> &HarmonicDrive {
        &self.drive
    }

    /// Phasor of harmonic `n`: `x = Re Σ X_n e^(i n omega t)`, the drive's crest at `t = 0`.
    pub fn harmonic(&self, n: u32) -> Phasor {
        match &self.shape {
            Shape::Fourier(x) if n % 2 == 1 => x.get(n as usize / 2).copied().unwrap_or_default(),
            Shape::Fourier(_) => Phasor::default(),
            Shape::General(x) => x.get(n as usize).copied().unwrap_or_default(),
            Shape::Closed(c) => c.harmonic(n),
            Shape::Orbit(o) => o.harmonic(n),
        }
    }

    /// Gain `|X_1|/x_0`: the lock-in amplitude over the drive amplitude.
    pub fn gain(&self) -> f64 {
        self.harmonic(1).norm() / self.drive.amplitude
    }

    /// Phase by which the fundamental lags the drive, rad, 0 to 2 pi.
    pub fn phase_lag(&self) -> f64 {
        (-self.harmonic(1).arg()).rem_euclid(2.0 * PI)
    }

    /// Displacement and velocity.
    pub fn state(&self, time_s: f64) -> (f64, f64) {
        match &self.shape {
            Shape::Fourier(x) => {
                // Horner's scheme in the square of e^(i omega t), for x and for x'.
                let z = Phasor::from_polar(1.0, (self.drive.omega * time_s) % (2.0 * PI));
                let step = z * z;
                let (mut x_sum, mut v_sum) = (Phasor::default(), Phasor::default());
                for (i, c) in x.iter().enumerate().rev() {
                    x_sum = x_sum * step + c;
                    v_sum = v_sum * step + c * (2 * i + 1) as f64;
                }
                ((x_sum * z).re, -self.drive.omega * (v_sum * z).im)
            }
            Shape::General(x) => {
                let z = Phasor::from_polar(1.0, (self.drive.omega * time_s) % (2.0 * PI));
                let (mut x_sum, mut v_sum) = (Phasor::default(), Phasor::default());
                for (n, c) in x.iter().enumerate().rev() {
                    x_sum = x_sum * z + c;
                    v_sum = v_sum * z + c * n as f64;
                }
                (x_sum.re, -self.drive.omega * v_sum.im)
            }
            Shape::Closed(c) => c.state(time_s),
            Shape::Orbit(o) => o.state(time_s),
        }
    }

    /// Displacement.
    pub fn displacement(&self, time_s: f64) -> f64 {
        self.state(time_s).0
    }

    /// Velocity, per s.
    pub fn velocity(&self, time_s: f64) -> f64 {
        self.state(time_s).1
    }

    /// Turning points of one cycle, time and position, starting from the crest of the drive.
    pub fn turning_points(&self) -> Vec<(f64, f64)> {
        match &self.shape {
            Shape::Fourier(x) => self.zeros_of_velocity(x.len()),
            Shape::General(x) => self.zeros_of_velocity(x.len().div_ceil(2)),
            Shape::Closed(c) => {
                let period = self.drive.period_s();
                let one = c.turn_time_s().rem_euclid(period);
                let other = (one + 0.5 * period).rem_euclid(period);
                let (x, y) = (c.amplitude(), -c.amplitude());
                if one < other { vec![(one, x), (other, y)] } else { vec![(other, y), (one, x)] }
            }
            Shape::Orbit(o) => o.turning_points(),
        }
    }

    fn zeros_of_velocity(&self, terms: usize) -> Vec<(f64, f64)> {
        // The acceleration of the series has jumps, the velocity has not: its zeros are few.
        let steps = 32 * terms.clamp(1, 64);
        let period = self.drive.period_s();
        let mut found = Vec::new();
        if terms == 0 {
            return found;
        }
        let mut before = self.velocity(0.0);
        for i in 1..=steps {
            let (a, b) = (period * (i - 1) as f64 / steps as f64, period * i as f64 / steps as f64);
            let after = self.velocity(b);
            if before != 0.0 && (before > 0.0) != (after > 0.0) {
                let turn = root(a, b, |t| self.velocity(t));
                found.push((turn, self.displacement(turn)));
            }
            before = after;
        }
        found
    }

    /// Number of stops per cycle; zero unless the method includes them.
    pub fn stops(&self) -> usize {
        match &self.shape {
            Shape::Orbit(o) => o.stops(),
            _ => 0,
        }
    }

    /// Largest excursion.
    pub fn amplitude(&self) -> f64 {
        match &self.shape {
            Shape::Closed(c) => c.amplitude(),
            Shape::Fourier(x) if x.len() <= 1 => x.first().map_or(0.0, |x| x.norm()),
            _ => self.turning_points().iter().fold(0.0, |m, (_, x)| f64::max(m, x.abs())),
        }
    }

    /// Energy dissipated per cycle, split, over the stiffness: `(2 delta/omega_0²) ∮ v² dt` viscous, `x_F ∮ |dx|`
    /// sliding, and for [`Method::LeadingWithDrag`] its drag, `(2 pi a2 omega/omega_0²) R³`.
    pub fn loss(&self) -> CycleLoss {
        let o = &self.oscillator;
        // In a periodic motion the paths in both directions are equally long.
        let x_f = match &self.shape {
            Shape::Orbit(orbit) => orbit.friction_law().kinetic().iter().sum::<f64>() * 0.5,
            _ => o.friction_displacement(),
        };
        let omega = self.drive.omega;
        let square = match &self.shape {
            Shape::Fourier(x) => {
                let sum: f64 =
                    x.iter().enumerate().map(|(i, c)| ((2 * i + 1) as f64).powi(2) * c.norm_sqr()).sum();
                PI * omega * sum
            }
            Shape::General(x) => {
                let sum: f64 = x.iter().enumerate().map(|(n, c)| (n as f64).powi(2) * c.norm_sqr()).sum();
                PI * omega * sum
            }
            Shape::Closed(c) => c.velocity_square(),
            Shape::Orbit(orbit) => orbit.integral(|_, _, v| v * v),
        };
        let path = match &self.shape {
            Shape::Closed(c) => 4.0 * c.amplitude(),
            _ => {
                let turns = self.turning_points();
                (0..turns.len()).map(|i| (turns[i].1 - turns[(i + 1) % turns.len()].1).abs()).sum()
            }
        };
        let drag = match self.method {
            Method::LeadingWithDrag { drag_rate } => {
                2.0 * PI * drag_rate * omega / o.omega_0().powi(2) * self.harmonic(1).norm().powi(3)
            }
            _ => 0.0,
        };
        CycleLoss {
            viscous: 2.0 * o.decay_rate_per_s() / o.omega_0() * (square / o.omega_0()),
            sliding: x_f * path,
            drag,
        }
    }

    /// Work of the drive per cycle over the stiffness, `pi x_0 |X_1| sin(lag)`: equal to the loss in an exact motion.
    pub fn work(&self) -> f64 {
        -PI * self.drive.amplitude * self.harmonic(1).im
    }
}

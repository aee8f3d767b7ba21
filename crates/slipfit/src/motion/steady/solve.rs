//! The exact steady motion by whichever method holds, and a comparison of the methods.

use super::exact::ClosedForm;
use super::orbit::{OrbitOptions, PeriodicOrbit};
use super::{HarmonicDrive, Phasor, SteadyState};
use crate::error::Error;
use crate::model::oscillator::Oscillator;
use crate::motion::simulate::{Drive, Friction, Motion};

/// The method that gave the exact steady motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SolutionMethod {
    /// Two turning points per cycle and no stop: the closed form.
    ClosedForm,
    /// Shooting on the event map: there are stops, or more turning points.
    Shooting,
    /// The mass never moves: the drive stays within static friction.
    FullStick,
}

impl SolutionMethod {
    /// Name in tables: `closed_form`, `shooting` or `full_stick`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed_form",
            Self::Shooting => "shooting",
            Self::FullStick => "full_stick",
        }
    }
}

/// The exact steady motion and how it was found.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The motion.
    pub state: SteadyState,
    /// The method that holds.
    pub method: SolutionMethod,
    /// Floquet multipliers of the motion.
    pub multipliers: [Phasor; 2],
    /// Relative closure error after one cycle of the event machine.
    pub residual: f64,
}

/// The exact steady motion, by whichever method holds.
///
/// The closed form is tried first and accepted only if the event machine confirms it; otherwise shooting is used,
/// from rest and after a short transient. Every answer is run through one cycle of the event machine, which gives
/// `residual` and `multipliers`.
///
/// # Errors
/// [`Error::DoesNotHold`] if no motion with the period of the drive was found.
///
/// ```
/// # use slipfit::{Oscillator, motion::steady::{HarmonicDrive, SolutionMethod, solve}};
/// let o = Oscillator::kinematic(1.0, 0.01, 0.5)?;
/// assert_eq!(solve(&o, &HarmonicDrive::new(1.0, 1.0)?)?.method, SolutionMethod::ClosedForm);
/// assert_eq!(solve(&o, &HarmonicDrive::new(1.0, 0.2)?)?.method, SolutionMethod::Shooting);
/// assert_eq!(solve(&o, &HarmonicDrive::new(0.4, 1.0)?)?.method, SolutionMethod::FullStick);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn solve(oscillator: &Oscillator, drive: &HarmonicDrive) -> Result<Solution, Error> {
    if let Some(closed) = ClosedForm::new(oscillator, drive).filter(ClosedForm::holds) {
        let state = SteadyState::closed(oscillator, drive, closed);
        // The orbit through the same point, for one cycle.
        let options = OrbitOptions { start: Some(state.state(0.0)), settle_cycles: 0, max_cycles: 4 };
        if let Ok(orbit) = PeriodicOrbit::find(oscillator, drive, options) {
            let (multipliers, residual) = (orbit.multipliers(), orbit.residual());
            return Ok(Solution { state, method: SolutionMethod::ClosedForm, multipliers, residual });
        }
    }
    let orbit = PeriodicOrbit::find(oscillator, drive, OrbitOptions::default())?;
    Ok(shot(drive, orbit))
}

/// [`solve`] with friction that differs between the directions. It uses shooting, because the closed form assumes one
/// friction, or [`solve`] itself if both are the oscillator's own.
///
/// # Errors
/// As [`solve`].
pub fn solve_with_friction(
    oscillator: &Oscillator,
    friction: Friction,
    drive: &HarmonicDrive,
) -> Result<Solution, Error> {
    if friction == Friction::of(oscillator) {
        return solve(oscillator, drive);
    }
    let orbit = PeriodicOrbit::find_with_friction(oscillator, friction, drive, OrbitOptions::default())?;
    Ok(shot(drive, orbit))
}

fn shot(drive: &HarmonicDrive, orbit: PeriodicOrbit) -> Solution {
    let (multipliers, residual) = (orbit.multipliers(), orbit.residual());
    let method = if orbit.events().is_empty() { SolutionMethod::FullStick } else { SolutionMethod::Shooting };
    Solution { state: SteadyState::orbit(drive, orbit), method, multipliers, residual }
}

/// The amplitude at the turning points by each of the three methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodComparison {
    /// Value of the closed form, whether or not it holds; `None` if it has none.
    pub closed_form: Option<f64>,
    /// Value by shooting; `None` if no periodic motion was found.
    pub shooting: Option<f64>,
    /// Largest excursion in the last cycle of a long run from rest at zero.
    pub transient: f64,
    /// The method that holds; `None` if no motion with the period of the drive was found.
    pub holds: Option<SolutionMethod>,
}

/// The steady amplitude by closed form, by shooting and by a run of `cycles`, and which of them holds.
///
/// # Errors
/// [`Error::Parameter`] if `cycles` is zero.
///
/// ```
/// # use slipfit::{Oscillator, motion::steady::{HarmonicDrive, SolutionMethod, compare_methods}};
/// // Driven slowly the mass stops on the way: the closed form has a value, but a wrong one.
/// let o = Oscillator::kinematic(1.0, 0.05, 0.5)?;
/// let w = compare_methods(&o, &HarmonicDrive::new(1.0, 0.3)?, 300)?;
/// assert_eq!(w.holds, Some(SolutionMethod::Shooting));
/// assert!((w.shooting.unwrap() - w.transient).abs() < 1e-12);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn compare_methods(
    oscillator: &Oscillator,
    drive: &HarmonicDrive,
    cycles: u32,
) -> Result<MethodComparison, Error> {
    if cycles == 0 {
        return Err(Error::Parameter { name: "cycles", value: 0.0, range: "1 or more" });
    }
    let shot = PeriodicOrbit::find(oscillator, drive, OrbitOptions::default()).ok();
    let largest = |points: Vec<(f64, f64)>| points.iter().fold(0.0, |m, p| f64::max(m, p.1.abs()));
    let tone = Drive::harmonic(drive.amplitude(), drive.omega())?;
    let mut long = Motion::new(oscillator, tone, 0.0, 0.0, 0.0)?;
    let until = f64::from(cycles) * drive.period_s();
    let last = until - drive.period_s();
    let mut transient: f64 = 0.0;
    while let Some(e) = long.next_event(until) {
        if e.time_s >= last {
            transient = transient.max(e.position.abs());
        }
    }
    Ok(MethodComparison {
        closed_form: ClosedForm::new(oscillator, drive).map(|c| c.amplitude()),
        shooting: shot.map(|o| largest(o.turning_points())),
        transient,
        holds: solve(oscillator, drive).ok().map(|s| s.method),
    })
}

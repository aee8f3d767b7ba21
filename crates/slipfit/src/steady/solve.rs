//! Which exact way holds.

use super::exact::ClosedForm;
use super::orbit::{OrbitOptions, PeriodicOrbit};
use super::{HarmonicDrive, Phasor, SteadyState};
use crate::error::Error;
use crate::oscillator::Oscillator;

/// The way by which the exact steady motion was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Way {
    /// Two turns a cycle and no stop: the closed form.
    ClosedForm,
    /// Shooting on the event map: there are stops, or more turns.
    Shooting,
    /// The mass never moves: the drive stays within static friction.
    FullStick,
}

/// The exact steady motion and how it was found.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The motion.
    pub state: SteadyState,
    /// The way that holds.
    pub way: Way,
    /// Floquet multipliers of the motion.
    pub multipliers: [Phasor; 2],
    /// How well it closes after one cycle of the event machine, relative.
    pub residual: f64,
}

/// The exact steady motion, by whichever way holds.
///
/// The closed form is tried first and believed only if the event machine confirms it;
/// else shooting, from rest and after a short transient. Every answer is run through
/// one cycle of the event machine: `residual` and `multipliers` come from there.
///
/// # Errors
/// [`Error::DoesNotHold`] where no motion repeating with the drive was found.
///
/// ```
/// # use slipfit::{Oscillator, steady::{HarmonicDrive, Way, solve}};
/// let o = Oscillator::kinematic(1.0, 0.01, 0.5)?;
/// assert_eq!(solve(&o, &HarmonicDrive::new(1.0, 1.0)?)?.way, Way::ClosedForm);
/// assert_eq!(solve(&o, &HarmonicDrive::new(1.0, 0.2)?)?.way, Way::Shooting);
/// assert_eq!(solve(&o, &HarmonicDrive::new(0.4, 1.0)?)?.way, Way::FullStick);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn solve(oscillator: &Oscillator, drive: &HarmonicDrive) -> Result<Solution, Error> {
    if let Some(closed) = ClosedForm::new(oscillator, drive).filter(ClosedForm::holds) {
        let state = SteadyState::closed(oscillator, drive, closed);
        // The orbit through the same point, one cycle of it.
        let options = OrbitOptions { start: Some(state.state(0.0)), settle_cycles: 0, max_cycles: 4 };
        if let Ok(orbit) = PeriodicOrbit::find(oscillator, drive, options) {
            let (multipliers, residual) = (orbit.multipliers(), orbit.residual());
            return Ok(Solution { state, way: Way::ClosedForm, multipliers, residual });
        }
    }
    let orbit = PeriodicOrbit::find(oscillator, drive, OrbitOptions::default())?;
    let (multipliers, residual) = (orbit.multipliers(), orbit.residual());
    let way = if orbit.events().is_empty() { Way::FullStick } else { Way::Shooting };
    Ok(Solution { state: SteadyState::orbit(drive, orbit), way, multipliers, residual })
}

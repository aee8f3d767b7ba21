//! Range of validity of each approximation: errors over `Q` and `beta`.

use super::{HarmonicDrive, SolutionMethod, SteadyState, leading, lorentzian, solve, validity};
use crate::error::Error;
use crate::model::oscillator::Oscillator;
use crate::motion::decay::{FreeDecay, averaged};
use std::f64::consts::PI;

/// Extent of the flanks on either side, in half widths of the line.
pub const FLANK_HALF_WIDTHS: f64 = 2.0;
/// Number of frequencies on each flank.
const FLANK_POINTS: i32 = 5;
/// Maximum number of turning points of the ring-down that are compared.
const TURNING_POINTS: u64 = 400;

/// Errors of the approximations of Vitorino, Vieira and Rodrigues at one `Q` and `beta`.
///
/// Errors of amplitudes are relative; those at resonance are signed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Quality factor of the viscous part.
    pub q_factor: f64,
    /// Friction ratio `4F/(pi k x_0)`.
    pub beta: f64,
    /// The exact method that holds at resonance.
    pub method: SolutionMethod,
    /// Exact amplitude at resonance, over `x_0`.
    pub gain: f64,
    /// Error of eq. (8) at resonance.
    pub leading_error: f64,
    /// Largest error of eq. (8) within [`FLANK_HALF_WIDTHS`].
    pub leading_flank_error: f64,
    /// Error of eq. (14), `a = 4/3`, at resonance.
    pub lorentzian_error: f64,
    /// Largest error of eq. (14), `a = 4/3`, within [`FLANK_HALF_WIDTHS`].
    pub lorentzian_flank_error: f64,
    /// Largest error of the amplitude by eq. (16) at the turning points of the ring-down from the driven amplitude,
    /// over the initial amplitude. The stop itself is excluded. `None` if the mass stops at its first turning point
    /// or does not start.
    pub ring_down_error: Option<f64>,
    /// Exact `phi_1` at resonance, rad, which the paper takes as zero.
    pub fundamental_phase: f64,
}

/// Computes one cell, with static friction equal to kinetic friction.
///
/// The half width of the line is `omega_0/(2 Q_f)`, with `Q_f` from eq. (12) for `a = 4/3`; frequencies below a fifth
/// of `omega_0` are omitted.
///
/// # Errors
/// [`Error::Parameter`] unless `q_factor > 1/2` and `0 <= beta < 1`; [`Error::DoesNotHold`] if the drive does not
/// move the mass or no motion with the period of the drive was found.
///
/// ```
/// # use slipfit::motion::steady::atlas;
/// let cell = atlas::cell(50.0, 0.9)?;
/// // Right at resonance, wrong on the flanks.
/// assert!(cell.leading_error.abs() < 1e-3);
/// assert!(cell.leading_flank_error > 0.05);
/// assert!((cell.fundamental_phase - 0.04497).abs() < 1e-4);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn cell(q_factor: f64, beta: f64) -> Result<Cell, Error> {
    if !(0.0..1.0).contains(&beta) {
        return Err(Error::Parameter { name: "beta", value: beta, range: "0 <= beta < 1" });
    }
    let x_f = beta * PI / 4.0;
    let o = Oscillator::builder().omega_0(1.0).q_factor(q_factor).friction_displacement(x_f).build()?;
    let at_resonance = validity(&o, &HarmonicDrive::new(1.0, 1.0)?)?;
    let gain = at_resonance.amplitude;
    if gain <= 0.0 {
        return Err(Error::DoesNotHold { method: "a steady motion at resonance", why: "the mass sticks" });
    }
    let half_width = 0.5 / lorentzian::effective_q_factor(&o, 1.0, lorentzian::PAPER_A);
    let (mut worst_leading, mut worst_lorentzian) = (0.0f64, 0.0f64);
    for i in -FLANK_POINTS..=FLANK_POINTS {
        let omega = 1.0 + half_width * FLANK_HALF_WIDTHS * f64::from(i) / f64::from(FLANK_POINTS);
        if omega < 0.2 {
            continue;
        }
        let drive = HarmonicDrive::new(1.0, omega)?;
        let exact = exact_amplitude(&o, &drive)?;
        if exact > 0.0 {
            let error = |r: f64| (r / exact - 1.0).abs();
            worst_leading = worst_leading.max(error(leading::leading_amplitude(&o, &drive)));
            let by_14 = lorentzian::lorentzian_amplitude(&o, &drive, lorentzian::PAPER_A);
            worst_lorentzian = worst_lorentzian.max(error(by_14));
        }
    }
    Ok(Cell {
        q_factor,
        beta,
        method: at_resonance.method,
        gain,
        leading_error: at_resonance.leading_error,
        leading_flank_error: worst_leading,
        lorentzian_error: at_resonance.lorentzian_error,
        lorentzian_flank_error: worst_lorentzian,
        ring_down_error: ring_down_error(&o, gain)?,
        fundamental_phase: at_resonance.fundamental_phase,
    })
}

/// Uses the closed form without its confirming cycle if it holds, which is the usual case.
fn exact_amplitude(oscillator: &Oscillator, drive: &HarmonicDrive) -> Result<f64, Error> {
    match SteadyState::new(oscillator, drive, super::Method::Exact) {
        Ok(state) => Ok(state.amplitude()),
        Err(Error::DoesNotHold { .. }) => Ok(solve(oscillator, drive)?.state.amplitude()),
        Err(e) => Err(e),
    }
}

/// Compares eq. (16) with the turning points, up to the stop or five decay times.
fn ring_down_error(oscillator: &Oscillator, initial: f64) -> Result<Option<f64>, Error> {
    let decay = FreeDecay::from_rest(oscillator, initial)?;
    let half_cycles = 5.0 / oscillator.half_cycle_decrement();
    // The offset that remains at the stop is arbitrary and not an amplitude.
    let moving = decay.stop().map_or(u64::MAX, |s| s.index.saturating_sub(1));
    let last = moving.min(half_cycles.ceil() as u64);
    if last == 0 {
        return Ok(None);
    }
    let stride = last.div_ceil(TURNING_POINTS);
    let mut worst = 0.0f64;
    for n in (0..=last).step_by(stride as usize) {
        let p = decay.turning_point(n);
        let by_16 = averaged::ring_down_amplitude(oscillator, initial, p.time_s).max(0.0);
        worst = worst.max((by_16 - p.position.abs()).abs());
    }
    Ok(Some(worst / initial))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_friction_only_the_turning_points_of_low_q_are_off() {
        let c = cell(1000.0, 0.0).unwrap();
        assert!(c.leading_flank_error < 1e-9, "{c:?}");
        assert!(c.lorentzian_flank_error < 1e-9, "{c:?}");
        assert!(c.fundamental_phase.abs() < 1e-9, "{c:?}");
        assert!(c.ring_down_error.unwrap() < 1e-5, "{c:?}");
    }

    #[test]
    fn corners_of_the_map_have_numbers() {
        for (q, beta) in [(2.0, 0.0), (2.0, 0.99), (1e5, 0.0), (1e5, 0.99), (6.0, 0.7)] {
            let c = cell(q, beta).unwrap();
            for v in [
                c.gain,
                c.leading_error,
                c.leading_flank_error,
                c.lorentzian_error,
                c.lorentzian_flank_error,
                c.ring_down_error.unwrap_or(0.0),
                c.fundamental_phase,
            ] {
                assert!(v.is_finite(), "{c:?}");
            }
        }
    }

    #[test]
    fn outside_the_map_is_an_error() {
        assert!(cell(0.4, 0.5).is_err());
        assert!(cell(10.0, 1.0).is_err());
        assert!(cell(10.0, f64::NAN).is_err());
    }
}

//! The limits stated by the paper, and the actual errors.

use super::{HarmonicDrive, Method, SolutionMethod, SteadyState, leading, lorentzian, solve};
use crate::error::Error;
use crate::model::oscillator::Oscillator;
use std::f64::consts::PI;

/// Whether the approximations of Vitorino, Vieira and Rodrigues may be used, and their errors in this case.
#[derive(Debug, Clone, PartialEq)]
pub struct Validity {
    /// `4F/(pi k A)` with `A` the exact amplitude; the paper requires it to be below 1.
    pub sliding_ratio: f64,
    /// `Q`; the paper requires it to be above 2.
    pub q_factor: f64,
    /// Exact phase lag of the fundamental relative to the turning point, rad; the paper takes it as zero.
    pub fundamental_phase: f64,
    /// The exact method that holds.
    pub method: SolutionMethod,
    /// Number of stops per cycle of the exact motion.
    pub stops: usize,
    /// Exact amplitude, at the turning points.
    pub amplitude: f64,
    /// Relative error of the amplitude by eq. (8).
    pub leading_error: f64,
    /// Relative error of the amplitude by the series of 30 terms.
    pub series_error: f64,
    /// Relative error of the amplitude by the Lorentzian, eq. (14), with `a = 4/3`.
    pub lorentzian_error: f64,
    /// Error of the phase lag by eq. (8), rad.
    pub leading_phase_error: f64,
    /// Relative error of the offset in the ring-down, eq. (16).
    pub decay_offset_error: f64,
}

impl Validity {
    /// The two conditions of the paper: `4F < pi k A` and `Q > 2`.
    pub fn within_stated_limits(&self) -> bool {
        self.sliding_ratio < 1.0 && self.q_factor > 2.0
    }
}

/// Checks the limits stated in the paper against the exact motion.
///
/// If the mass never moves, the amplitude is zero and the relative errors are infinite, or zero for approximations
/// that also give zero.
///
/// # Errors
/// As [`solve`].
///
/// ```
/// # use slipfit::{Oscillator, motion::steady::{HarmonicDrive, validity}};
/// // Inside both limits of the paper, and yet eq. (8) errs by 9 %.
/// let o = Oscillator::kinematic(1.0, 0.01, 0.9 * std::f64::consts::PI / 4.0)?;
/// let v = validity(&o, &HarmonicDrive::new(1.0, 0.97)?)?;
/// assert!(v.within_stated_limits());
/// assert!(v.leading_error < -0.08);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn validity(oscillator: &Oscillator, drive: &HarmonicDrive) -> Result<Validity, Error> {
    let exact = solve(oscillator, drive)?;
    let amplitude = exact.state.amplitude();
    let relative = |x: f64| if x == amplitude { 0.0 } else { (x - amplitude) / amplitude };
    let by = |method| SteadyState::new(oscillator, drive, method);
    let leading = by(Method::Leading)?;
    let turns = exact.state.turning_points();
    let fundamental_phase = turns
        .iter()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0.0, |top| wrapped(exact.state.phase_lag() - drive.omega() * top.0));
    let offset = oscillator.decay_offset();
    Ok(Validity {
        sliding_ratio: 4.0 * oscillator.friction_displacement() / (PI * amplitude),
        q_factor: oscillator.q_factor(),
        fundamental_phase,
        method: exact.method,
        stops: exact.state.stops(),
        amplitude,
        leading_error: relative(leading::leading_amplitude(oscillator, drive)),
        series_error: relative(by(Method::Series { terms: 30 })?.amplitude()),
        lorentzian_error: relative(lorentzian::lorentzian_amplitude(oscillator, drive, lorentzian::PAPER_A)),
        leading_phase_error: wrapped(leading.phase_lag() - exact.state.phase_lag()),
        decay_offset_error: if offset.is_finite() && offset > 0.0 {
            crate::motion::decay::averaged::decay_offset(oscillator) / offset - 1.0
        } else {
            0.0
        },
    })
}

fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(2.0 * PI) - PI
}

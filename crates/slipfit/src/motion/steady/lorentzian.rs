//! The effective Lorentzian, eqs. (9) to (14) of Vitorino, Vieira and Rodrigues.
//!
//! A resonance curve with sliding friction resembles one without friction, but with another quality factor `Q_f` and
//! another drive `x_f`. Note that the paper's `x_f` is an effective drive amplitude, not a friction displacement.
//!
//! The proportionality factor `a` is not the constant 4/3 found in the paper: it varies from 1.24 to 1.62 with `beta`
//! and with the fitted window. Inverting with 4/3 biases `F` by +53 % (`beta` 0.05, window of 1.5 half line widths)
//! to -3.3 % (`beta` 0.9, window of 10), and `Q` by +3 % to -23 % for the same two cases. Fitting eq. (8) or the
//! exact curve has no such bias.

pub use super::lorentzian_fit::{LorentzianFit, fit};

use super::HarmonicDrive;
use crate::error::Error;
use crate::model::oscillator::{Oscillator, above_zero};
use std::f64::consts::PI;

/// The paper's proportionality factor `a`, "4/3".
pub const PAPER_A: f64 = 4.0 / 3.0;

/// Amplitude at resonance, eq. (9): `R_0 = Q (x_0 - 4F/(pi k))`; zero below the threshold.
pub fn resonance_amplitude(oscillator: &Oscillator, drive_amplitude: f64) -> f64 {
    let excess = drive_amplitude - 4.0 / PI * oscillator.friction_displacement();
    (excess * oscillator.q_factor()).max(0.0)
}

/// Effective damping at amplitude `R`, eq. (10), as a decay rate in 1/s:
/// `gamma_f/2m` with `gamma_f = gamma + 4F/(pi omega_0 R)`.
pub fn effective_decay_rate_at(oscillator: &Oscillator, amplitude: f64) -> f64 {
    let x_f = oscillator.friction_displacement();
    oscillator.decay_rate_per_s() + 2.0 * x_f * oscillator.omega_0() / (PI * amplitude)
}

/// Effective damping as a function of the drive, eq. (11), as a decay rate in 1/s: `delta / (1 - beta/a)`.
pub fn effective_decay_rate(oscillator: &Oscillator, drive_amplitude: f64, a: f64) -> f64 {
    oscillator.decay_rate_per_s() / (1.0 - oscillator.friction_ratio(drive_amplitude) / a)
}

/// Effective quality factor, eq. (12): `Q_f = Q (1 - beta/a)`.
pub fn effective_q_factor(oscillator: &Oscillator, drive_amplitude: f64, a: f64) -> f64 {
    oscillator.q_factor() * (1.0 - oscillator.friction_ratio(drive_amplitude) / a)
}

/// Effective drive amplitude, eq. (13): `x_f = x_0 (1 - beta)/(1 - beta/a)`.
pub fn effective_drive(oscillator: &Oscillator, drive_amplitude: f64, a: f64) -> f64 {
    let beta = oscillator.friction_ratio(drive_amplitude);
    drive_amplitude * (1.0 - beta) / (1.0 - beta / a)
}

/// The effective Lorentzian, eq. (14):
/// `R = x_f omega_0² / sqrt((omega_0² - omega²)² + (omega omega_0/Q_f)²)`.
///
/// Correct at resonance by construction; on the flanks only as accurate as `a`. Zero below the threshold `beta = 1`.
pub fn lorentzian_amplitude(oscillator: &Oscillator, drive: &HarmonicDrive, a: f64) -> f64 {
    phasor(oscillator, drive, a).map_or(0.0, |x| x.norm())
}

pub(super) fn phasor(oscillator: &Oscillator, drive: &HarmonicDrive, a: f64) -> Option<super::Phasor> {
    let x_f = effective_drive(oscillator, drive.amplitude(), a);
    let q_f = effective_q_factor(oscillator, drive.amplitude(), a);
    let (w, omega) = (oscillator.omega_0(), drive.omega());
    let d = super::Phasor::new((w - omega) / w * ((w + omega) / w), omega / (w * q_f));
    (x_f > 0.0 && q_f > 0.0).then(|| d.inv() * x_f)
}

/// Result of the paper's inversion of a fitted Lorentzian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inversion {
    /// Friction ratio `beta = 4F/(pi k x_0)`.
    pub beta: f64,
    /// Friction displacement `x_F = F/k`.
    pub friction_displacement: f64,
    /// Viscous quality factor `Q`.
    pub q_factor: f64,
}

/// `F` and `Q` from a fitted `x_f` and `Q_f`, by solving eqs. (12) and (13) with known `x_0`:
/// `beta = (x_0 - x_f)/(x_0 - x_f/a)`.
///
/// This is how the paper obtains its table, with `a` = [`PAPER_A`]. It is biased as described in the [module](self)
/// and given for comparison.
///
/// # Errors
/// [`Error::Parameter`] unless `0 < x_f <= x_0`, `Q_f > 0` and `a > 1`.
pub fn invert(
    effective_drive: f64,
    effective_q_factor: f64,
    drive_amplitude: f64,
    a: f64,
) -> Result<Inversion, Error> {
    above_zero("effective_q_factor", effective_q_factor)?;
    above_zero("drive_amplitude", drive_amplitude)?;
    if a.is_nan() || a <= 1.0 {
        return Err(Error::Parameter { name: "a", value: a, range: "a > 1" });
    }
    if !(effective_drive > 0.0 && effective_drive <= drive_amplitude) {
        return Err(Error::Parameter {
            name: "effective_drive",
            value: effective_drive,
            range: "0 < x_f <= x_0",
        });
    }
    let beta = (drive_amplitude - effective_drive) / (drive_amplitude - effective_drive / a);
    Ok(Inversion {
        beta,
        friction_displacement: beta * PI * drive_amplitude / 4.0,
        q_factor: effective_q_factor / (1.0 - beta / a),
    })
}

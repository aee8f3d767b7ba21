//! A harmonic drive.

use crate::error::Error;
use std::f64::consts::PI;

/// A harmonic base drive, `x_0 cos(omega t)`; a force `P cos(omega t)` corresponds to `x_0 = P/k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicDrive {
    pub(super) amplitude: f64,
    pub(super) omega: f64,
}

impl HarmonicDrive {
    /// Drive from the amplitude `x_0` and the angular frequency, rad/s.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `1e-150 <= amplitude <= 1e100` and `0 < omega <= 1e50`.
    pub fn new(amplitude: f64, omega: f64) -> Result<Self, Error> {
        if !(1e-150..=1e100).contains(&amplitude) {
            let range = "0 < amplitude, 1e-150 to 1e100";
            return Err(Error::Parameter { name: "drive amplitude", value: amplitude, range });
        }
        if !(omega > 0.0 && omega <= 1e50) {
            return Err(Error::Parameter { name: "omega", value: omega, range: "0 < omega <= 1e50 rad/s" });
        }
        Ok(Self { amplitude, omega })
    }

    /// Amplitude `x_0`.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Angular frequency, rad/s.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Period, s.
    pub fn period_s(&self) -> f64 {
        2.0 * PI / self.omega
    }
}

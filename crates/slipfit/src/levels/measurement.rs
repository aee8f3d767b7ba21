//! Amplitudes over drive levels as they were measured.

use crate::Error;
use crate::answer::calibration::Calibration;
use crate::error::POSITIVE;

/// Amplitude at resonance versus drive level, points in the order of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    drive: Vec<f64>,
    amplitude: Vec<f64>,
    std_error: Option<Vec<f64>>,
    drive_unit: String,
    unit: String,
    not_finite: usize,
}

/// Builds [`Levels`] and checks them.
#[derive(Debug, Clone)]
pub struct LevelsBuilder {
    levels: Levels,
}

/// Options for [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Frequency of the resonance, Hz; required for the decay rate.
    pub frequency_hz: Option<f64>,
    /// Response units per drive unit, which converts drive levels into `x_0`, with its standard error; not needed if
    /// both are lengths or both are angles.
    pub drive_gain: Option<[f64; 2]>,
    /// Quality factor of the viscous part if known, above 0.5, with its standard error; it replaces `drive_gain`.
    pub q_factor: Option<[f64; 2]>,
    /// Mechanical constant that converts displacements into forces.
    pub calibration: Option<Calibration>,
}

impl Levels {
    /// Starts from drive levels and amplitudes.
    pub fn builder(drive: Vec<f64>, amplitude: Vec<f64>) -> LevelsBuilder {
        LevelsBuilder {
            levels: Levels {
                drive,
                amplitude,
                std_error: None,
                drive_unit: String::new(),
                unit: String::new(),
                not_finite: 0,
            },
        }
    }

    /// Drive levels, in the order of measurement.
    pub fn drive(&self) -> &[f64] {
        &self.drive
    }

    /// Amplitudes, in the order of measurement.
    pub fn amplitude(&self) -> &[f64] {
        &self.amplitude
    }

    /// Standard error of each amplitude, if known.
    pub fn std_error(&self) -> Option<&[f64]> {
        self.std_error.as_deref()
    }

    /// Unit of the drive levels.
    pub fn drive_unit(&self) -> &str {
        &self.drive_unit
    }

    /// Unit of the amplitudes.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Points left out because a value is not finite.
    pub fn not_finite(&self) -> usize {
        self.not_finite
    }
}

impl LevelsBuilder {
    /// Standard error of each amplitude.
    #[must_use]
    pub fn std_error(mut self, std_error: Vec<f64>) -> Self {
        self.levels.std_error = Some(std_error);
        self
    }

    /// Unit of the drive levels.
    #[must_use]
    pub fn drive_unit(mut self, unit: impl Into<String>) -> Self {
        self.levels.drive_unit = unit.into();
        self
    }

    /// Unit of the amplitudes.
    #[must_use]
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.levels.unit = unit.into();
        self
    }

    /// Checks and builds; points that are not finite are left out and counted.
    ///
    /// # Errors
    /// [`Error::Length`] for columns of different length; [`Error::PointOutOfRange`] for a negative drive or amplitude,
    /// or a standard error that is not positive; [`Error::TooFewSamples`] for fewer than three points.
    pub fn build(self) -> Result<Levels, Error> {
        let mut l = self.levels;
        let n = l.drive.len();
        for (name, found) in
            [("amplitude", Some(l.amplitude.len())), ("std_error", l.std_error.as_ref().map(Vec::len))]
        {
            if let Some(found) = found.filter(|&f| f != n) {
                return Err(Error::Length { name, found, expected: n });
            }
        }
        let error_at = |i: usize| l.std_error.as_ref().map_or(1.0, |s| s[i]);
        let keep: Vec<usize> = (0..n)
            .filter(|&i| l.drive[i].is_finite() && l.amplitude[i].is_finite() && error_at(i).is_finite())
            .collect();
        for &index in &keep {
            let out = |name, value, range| Err(Error::PointOutOfRange { name, index, value, range });
            if l.drive[index] < 0.0 {
                return out("drive", l.drive[index], "the non-negative numbers");
            }
            if l.amplitude[index] < 0.0 {
                return out("amplitude", l.amplitude[index], "the non-negative numbers");
            }
            if error_at(index) <= 0.0 {
                return out("std_error", error_at(index), POSITIVE);
            }
        }
        if keep.len() < 3 {
            return Err(Error::TooFewSamples { found: keep.len(), needed: 3 });
        }
        l.not_finite = n - keep.len();
        l.drive = keep.iter().map(|&i| l.drive[i]).collect();
        l.amplitude = keep.iter().map(|&i| l.amplitude[i]).collect();
        l.std_error = l.std_error.map(|s| keep.iter().map(|&i| s[i]).collect());
        Ok(l)
    }
}

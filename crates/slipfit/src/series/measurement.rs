//! The input of a series.

use crate::answer::calibration::Calibration;
use crate::model::displacement::Coordinate;
use crate::{Record, levels, resonance, ringdown};

/// The data of one measurement with the options of its analysis.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Data {
    /// A ring-down.
    RingDown {
        /// The record.
        record: Box<Record>,
        /// Options.
        options: Box<ringdown::Options>,
    },
    /// A resonance curve.
    Sweep {
        /// The curve.
        curve: Box<resonance::Curve>,
        /// Options.
        options: Box<resonance::Options>,
    },
    /// A series of drive levels at resonance.
    Levels {
        /// The levels.
        levels: Box<levels::Levels>,
        /// Options.
        options: Box<levels::Options>,
    },
}

/// The quantity that was set during the measurement: a load, a brake current, a pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Label as it should be printed, e.g. `400 mA`.
    pub label: String,
    /// Its value with standard error, if it is a number.
    pub value: Option<[f64; 2]>,
}

/// One measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Name, as in the manifest.
    pub name: String,
    /// Condition under which it was made.
    pub condition: Condition,
    /// Data.
    pub data: Data,
    /// Factor that converts its displacement unit into the common one.
    pub scale: f64,
}

/// Which parameters all measurements of a series share. Decay rate and friction are shared
/// by the measurements of one condition; everything else is free.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Shared {
    /// One natural frequency for all.
    pub natural_frequency: bool,
    /// One drive amplitude for all sweeps.
    pub drive_amplitude: bool,
    /// One viscous decay rate for all conditions.
    pub decay_rate: bool,
}

/// Unit into which the displacements of a series are converted: m or rad if a constant converts them into forces,
/// otherwise the requested unit, otherwise that of the first measurement.
#[must_use]
pub fn common_unit(calibrated: Option<Coordinate>, asked: Option<&str>, first: &str) -> String {
    match (calibrated, asked) {
        (Some(Coordinate::Length), _) => "m",
        (Some(Coordinate::Angle), _) => "rad",
        (None, Some(unit)) => unit.trim(),
        (None, None) => first,
    }
    .to_owned()
}

/// Options of [`analyse`](super::analyse).
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Shared parameters.
    pub shared: Shared,
    /// One stiffness or mass for all: the table is then in N and kg/s.
    pub calibration: Option<Calibration>,
    /// Unit of displacements in the table.
    pub unit: String,
    /// Unit of the condition's value.
    pub condition_unit: String,
}

//! The oscillator and its loss: parameters, units, calibration to forces.

pub(crate) mod calibration;
pub mod oscillator;

//! The oscillator and its loss: parameters, units, calibration to forces.

pub mod calibration;
pub mod loss;
pub mod oscillator;

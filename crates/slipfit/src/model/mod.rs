//! The oscillator and its loss: parameters and units.

pub mod displacement;
pub mod loss;
pub mod oscillator;
pub(crate) mod unit;

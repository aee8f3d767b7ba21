//! Fits of one model from given start values, without the full analysis.

mod amplitudes;
mod by_moments;
mod envelope;
mod even_traces;
mod lack_of_fit;
mod last_turn;
mod many;
mod minimise;
mod moments;
mod samples;
mod straight;
#[cfg(test)]
pub(super) mod tests;
mod waveform;

pub use amplitudes::{AmplitudeFit, Sampling, fit_amplitudes};
pub use envelope::{EnvelopeFit, EnvelopeStart, fit_envelope};
pub use even_traces::EvenTraces;
pub use waveform::{Decay, DecayFit, fit_waveform};

use crate::Error;

fn check_lengths(name: &'static str, times: usize, found: usize, needed: usize) -> Result<(), Error> {
    if found != times {
        return Err(Error::Length { name, found, expected: times });
    }
    if found < needed {
        return Err(Error::TooFewSamples { found, needed });
    }
    Ok(())
}

fn check_finite(name: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(Error::Parameter { name, value, range: "the finite numbers" }),
        None => Ok(()),
    }
}

/// Refuses a time earlier than the preceding one.
fn check_order(time_s: &[f64]) -> Result<(), Error> {
    match time_s.windows(2).position(|w| w[1] < w[0]) {
        Some(i) => Err(Error::TimeBackwards { index: i + 1, previous: time_s[i], next: time_s[i + 1] }),
        None => Ok(()),
    }
}

fn check_start(values: &[(&'static str, f64)]) -> Result<(), Error> {
    values.iter().try_for_each(|&(name, value)| check_finite(name, &[value]))
}

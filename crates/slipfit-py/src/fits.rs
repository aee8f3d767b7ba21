//! The fits of one model from start values, without comparison.

use crate::arrays::Vector;
use crate::failure::core_error;
use crate::interrupt::{interruptible, uninterrupted};
use crate::reading::Curve;
use pyo3::prelude::*;
use slipfit::answer::hint::Analysis;
use slipfit::resonance::{self, CurveFit};
use slipfit::ringdown::{Decay, DecayFit, EnvelopeFit, EnvelopeStart, fit_envelope, fit_waveform};
use std::sync::Arc;

/// Number of samples up to which a fit ends before a signal could be noticed.
const MOST_UNINTERRUPTED_SAMPLES: usize = 1 << 16;

/// Runs a fit of `samples` samples.
fn fitted<T: Send + 'static>(
    py: Python<'_>,
    samples: usize,
    work: impl FnOnce() -> Result<T, slipfit::Error> + Send + 'static,
) -> PyResult<T> {
    let found = if samples <= MOST_UNINTERRUPTED_SAMPLES {
        uninterrupted(py, work)
    } else {
        interruptible(py, work)
    }?;
    found.map_err(|error| core_error(py, Analysis::Ringdown, &error))
}

fn owned(values: &Vector<'_>) -> Vec<f64> {
    values.as_array().to_vec()
}

/// Best values, standard errors, correlations, residual, whether it converged, number of steps.
type Parts = (Vec<f64>, Vec<f64>, Vec<Vec<f64>>, f64, bool, usize);

/// Fits the averaged decay to amplitudes from start values.
#[pyfunction]
pub(crate) fn envelope(
    py: Python<'_>,
    time_s: Vector<'_>,
    amplitude: Vector<'_>,
    start: (f64, f64, f64),
) -> PyResult<Parts> {
    let (time_s, amplitude) = (owned(&time_s), owned(&amplitude));
    let (initial_amplitude, offset_amplitude, decay_rate_per_s) = start;
    let start = EnvelopeStart { initial_amplitude, offset_amplitude, decay_rate_per_s };
    let fit = fitted(py, time_s.len(), move || fit_envelope(&time_s, &amplitude, &start))?;
    let list = |e: &EnvelopeStart| vec![e.initial_amplitude, e.offset_amplitude, e.decay_rate_per_s];
    let EnvelopeFit { best, std_error, correlation, residual_rms, converged, steps } = fit;
    let correlation = correlation.iter().map(|row| row.to_vec()).collect();
    Ok((list(&best), list(&std_error), correlation, residual_rms, converged, steps))
}

/// Fits the exact motion to samples from start values.
#[pyfunction]
pub(crate) fn waveform(
    py: Python<'_>,
    time_s: Vector<'_>,
    signal: Vector<'_>,
    start: (f64, f64, f64, f64, f64, f64),
) -> PyResult<Parts> {
    let (time_s, signal) = (owned(&time_s), owned(&signal));
    let (initial_amplitude, friction_displacement, decay_rate_per_s, phase_rad, frequency_hz, offset) = start;
    let start =
        Decay { initial_amplitude, friction_displacement, decay_rate_per_s, phase_rad, frequency_hz, offset };
    let fit = fitted(py, time_s.len(), move || fit_waveform(&time_s, &signal, &start))?;
    let list = |d: &Decay| {
        vec![
            d.initial_amplitude,
            d.friction_displacement,
            d.decay_rate_per_s,
            d.phase_rad,
            d.frequency_hz,
            d.offset,
        ]
    };
    let DecayFit { best, std_error, correlation, residual_rms, converged, steps } = fit;
    let correlation = correlation.iter().map(|row| row.to_vec()).collect();
    Ok((list(&best), list(&std_error), correlation, residual_rms, converged, steps))
}

/// Fits the exact response to a curve.
#[pyfunction]
#[pyo3(name = "resonance_fit")]
pub(crate) fn curve(
    py: Python<'_>,
    curve: &Curve,
    drive_amplitude: Option<f64>,
) -> PyResult<(Vec<[f64; 2]>, f64, bool)> {
    let reading = Arc::clone(&curve.reading);
    let samples = reading.curve.len();
    let work = move || resonance::fit(&reading.curve, drive_amplitude);
    let found = if samples <= MOST_UNINTERRUPTED_SAMPLES {
        uninterrupted(py, work)
    } else {
        interruptible(py, work)
    }?;
    let fit: CurveFit = found.map_err(|error| core_error(py, Analysis::Resonance, &error))?;
    let list = vec![
        fit.natural_frequency_hz,
        fit.decay_rate_per_s,
        fit.friction_displacement,
        fit.drive_amplitude,
        fit.phase_offset_rad,
    ];
    Ok((list, fit.residual_rms, fit.converged))
}

//! The bare fit of one row.

use crate::answer::{Estimate, Status};
use crate::table::Row;
use crate::trace::{Input, Scratch};
use slipfit::InferenceCriteria;
use slipfit::ringdown::{Sampling, fit_amplitudes};

pub(crate) fn row(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Row {
    fitted(input, row, scratch).unwrap_or_else(Row::failed)
}

fn fitted(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Result<Row, String> {
    let beside = input.beside(row)?;
    let Scratch { signal, quadrature, times } = scratch;
    let mut amplitude = input.signal.get(row, signal).ok_or("the trace is null")?;
    let all = amplitude.len();
    let modulus: Vec<f64>;
    if let Some(y) = &input.quadrature {
        let y = y.get(row, quadrature).ok_or("the quadrature is null")?;
        if y.len() != all {
            return Err(format!("{} values of Y for {all} of X", y.len()));
        }
        modulus = amplitude.iter().zip(y).map(|(x, y)| x.hypot(*y)).collect();
        amplitude = &modulus;
    }
    let mut stamps = input.times(row, all, times)?;
    if let Some(least) = beside.min_amplitude {
        let end = amplitude.iter().position(|a| *a < least).unwrap_or(all);
        amplitude = &amplitude[..end];
        stamps = stamps.map(|t| &t[..end]);
    }
    let sampling = match (stamps, beside.interval_s) {
        (Some(stamps), _) => Sampling::At(stamps),
        (None, interval_s) => Sampling::Every(interval_s.unwrap_or(f64::NAN)),
    };
    let whole = amplitude.iter().chain(stamps.unwrap_or_default()).all(|v| v.is_finite());
    let (fit, used) = if whole {
        (fit_amplitudes(sampling, amplitude), amplitude.len())
    } else {
        // What is missing leaves a gap in the clock.
        let time = |i: usize| match sampling {
            Sampling::Every(interval) => interval * i as f64,
            Sampling::At(stamps) => stamps[i],
        };
        let kept = || amplitude.iter().enumerate().filter(|(i, a)| a.is_finite() && time(*i).is_finite());
        let stamps: Vec<f64> = kept().map(|(i, _)| time(i)).collect();
        let values: Vec<f64> = kept().map(|(_, a)| *a).collect();
        (fit_amplitudes(Sampling::At(&stamps), &values), values.len())
    };
    let fit = fit.map_err(|error| error.to_string())?;
    let p_value = fit.sliding_p_value(used);
    let mut warnings = String::new();
    let mut warn = |code: &str, warned: bool| {
        if warned {
            warnings += if warnings.is_empty() { "" } else { " " };
            warnings += code;
        }
    };
    let [delta, delta_error] = fit.decay_rate_per_s;
    warn("not_converged", !fit.converged);
    warn("not_separable", fit.correlation.abs() > SEPARABLE);
    warn("negative_damping", delta < -UNLIKELY * delta_error);
    warn("negative_friction", fit.sliding_rate[0] < -UNLIKELY * fit.sliding_rate[1]);
    Ok(Row {
        status: if warnings.is_empty() { Status::Done } else { Status::Warned },
        reason: warnings,
        initial_amplitude: Estimate::normal(fit.initial_amplitude),
        decay_rate: Estimate::normal(fit.decay_rate_per_s),
        sliding_rate: Estimate::normal(fit.sliding_rate),
        friction_displacement: beside
            .frequency_hz
            .map_or(Estimate::NONE, |f| Estimate::normal(fit.friction_displacement(f))),
        correlation: fit.correlation,
        residual_rms: fit.residual_rms,
        p_value,
        detected: Some(p_value < InferenceCriteria::default().detected),
        samples: used as i64,
        left_out: (all - used) as i64,
        ..Row::default()
    })
}

/// Correlation of the two losses beyond which the trace does not tell them apart.
const SEPARABLE: f64 = 0.999;
/// Standard errors below zero that chance does not explain, once in 30 000 traces.
const UNLIKELY: f64 = 4.0;

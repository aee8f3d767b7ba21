//! slipfit's side of the fits and of reading text.
//!
//! Each function prepares one task, untimed, and returns the closure to be timed; the closure returns the decay rate
//! (1/s) and the friction displacement.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use slipfit::Parameter;
use slipfit::Record;
use slipfit::ringdown::{Decay, EnvelopeStart, Options, analyse, fit_envelope, fit_waveform};

use super::contest::Task;
use super::signal::{Signal, friction_displacement};
use crate::Failure;

/// Six-parameter fit of every sample, from the peers' start values.
pub(super) fn waveform_fit(signal: &Signal) -> Task<'_> {
    let [initial_amplitude, c, decay_rate_per_s, omega, phase_rad, offset] = signal.waveform_start();
    let start = Decay {
        initial_amplitude,
        friction_displacement: friction_displacement(c, decay_rate_per_s, omega),
        decay_rate_per_s,
        phase_rad,
        frequency_hz: omega / TAU,
        offset,
    };
    Task(Box::new(move || {
        let fit = fit_waveform(&signal.time_s, &signal.values, &start)?;
        Ok(vec![fit.best.decay_rate_per_s, fit.best.friction_displacement])
    }))
}

/// The whole analysis with default options.
pub(super) fn analysis(signal: &Signal) -> Result<Task<'static>, Failure> {
    analyses(std::slice::from_ref(signal))
}

/// The same for each of several signals; the estimates are those of the first.
pub(super) fn analyses(signals: &[Signal]) -> Result<Task<'static>, Failure> {
    let record = |signal: &Signal| Record::new(signal.time_s.clone(), signal.values.clone());
    let records = signals.iter().map(record).collect::<Result<Vec<Record>, _>>()?;
    let options = Options::default();
    Ok(Task(Box::new(move || {
        let mut first = Vec::new();
        for record in &records {
            let answer = std::hint::black_box(analyse(record, &options)?);
            let value = |name| answer.parameter(name).map_or(f64::NAN, |quantity| quantity.value);
            if first.is_empty() {
                first = vec![value(Parameter::DECAY_RATE), value(Parameter::FRICTION_DISPLACEMENT)];
            }
        }
        Ok(first)
    })))
}

/// Three-parameter fit of an amplitude trace, from the peers' start values.
pub(super) fn envelope_fit(signal: &Signal) -> Task<'_> {
    let [initial_amplitude, offset_amplitude, decay_rate_per_s] = signal.envelope_start();
    let start = EnvelopeStart { initial_amplitude, offset_amplitude, decay_rate_per_s };
    Task(Box::new(move || {
        let best = fit_envelope(&signal.time_s, &signal.values, &start)?.best;
        let omega = signal.truth.omega();
        let x_f = friction_displacement(best.offset_amplitude, best.decay_rate_per_s, omega);
        Ok(vec![best.decay_rate_per_s, x_f])
    }))
}

/// Reads a file of two columns.
pub(super) fn text_read(path: &Path) -> Task<'_> {
    Task(Box::new(move || {
        let reading = slipfit_io::read(path, &slipfit_io::ReadOptions::default())?;
        let last = reading.record.len() - 1;
        Ok(vec![reading.record.time_s(last), reading.record.signal()[last]])
    }))
}

/// `cargo xtask bench --read FILE TIMES`, a contestant of line m: seconds of the fastest of TIMES readings.
pub(super) fn read_alone(arguments: &[String]) -> Result<ExitCode, Failure> {
    let [file, times] = arguments else { return Err("--read needs FILE and TIMES".into()) };
    let mut best = f64::INFINITY;
    for _ in 0..times.parse()? {
        let begun = Instant::now();
        let reading = slipfit_io::read(Path::new(file), &slipfit_io::ReadOptions::default())?;
        best = best.min(begun.elapsed().as_secs_f64());
        std::hint::black_box(reading);
    }
    println!("{best}");
    Ok(ExitCode::SUCCESS)
}

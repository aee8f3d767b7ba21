//! slipfit's side: the only file of the benchmark that calls the library.
//!
//! Each function prepares one piece of work, untimed, and returns what is
//! timed; that returns the decay rate (1/s) and the friction displacement.
//! `None` stands for work the library does not offer, which the table shows.

use std::path::Path;

use slipfit::Record;
use slipfit::ringdown::{Options, analyse};

use super::contest::Task;
use super::signal::Signal;
use crate::Failure;

/// Six-parameter fit of every sample.
pub(super) fn waveform_fit(_signal: &Signal) -> Option<Task<'_>> {
    None
}

/// The whole analysis, nothing given.
pub(super) fn analysis(signal: &Signal) -> Result<Option<Task<'_>>, Failure> {
    let record = Record::new(signal.time_s.clone(), signal.values.clone())?;
    let options = Options::default();
    Ok(Some(Task(Box::new(move || {
        let answer = analyse(&record, &options)?;
        let value = |name| answer.parameter(name).map_or(f64::NAN, |quantity| quantity.value);
        Ok(vec![value("decay_rate_per_s"), value("friction_displacement")])
    }))))
}

/// Three-parameter fit of an amplitude trace.
pub(super) fn envelope_fit(_signal: &Signal) -> Option<Task<'_>> {
    None
}

/// Reading a file of two columns.
pub(super) fn text_read(_path: &Path) -> Option<Task<'_>> {
    None
}

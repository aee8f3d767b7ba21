//! slipfit's side: the only file of the benchmark that calls the library.
//!
//! Each function prepares one piece of work, untimed, and returns what is
//! timed; that returns the decay rate (1/s) and the friction displacement.
//! `None` stands for work the library does not offer, which the table shows.

use std::path::Path;

use super::contest::Task;
use super::signal::Signal;

/// Six-parameter fit of every sample, from `start`.
pub(super) fn waveform_fit(_signal: &Signal) -> Option<Task<'_>> {
    None
}

/// The whole analysis, nothing given.
pub(super) fn analysis(_signal: &Signal) -> Option<Task<'_>> {
    None
}

/// Three-parameter fit of an amplitude trace, from `start`.
pub(super) fn envelope_fit(_signal: &Signal) -> Option<Task<'_>> {
    None
}

/// Reading a file of two columns.
pub(super) fn text_read(_path: &Path) -> Option<Task<'_>> {
    None
}

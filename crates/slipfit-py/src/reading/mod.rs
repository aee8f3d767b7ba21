//! Records, curves and levels read from files, bytes and arrays.

mod arrays;
mod choices;
mod origin;
mod values;

pub(crate) use arrays::{curve_of_arrays, levels_of_arrays, record_of_arrays, unit_factor, unit_of_name};

use crate::failure::read_error;
use crate::interrupt::interruptible;
use choices::Choices;
use origin::{Given, Origin, Source};
use pyo3::prelude::*;
use slipfit_io::{LevelReading, ReadError, ReadOptions, Reading, SweepReading};
use std::path::PathBuf;
use std::sync::Arc;

/// A signal over time.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Record {
    pub(crate) reading: Arc<Reading>,
    origin: Origin,
}

/// A response over frequency.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Curve {
    pub(crate) reading: Arc<SweepReading>,
    origin: Origin,
}

/// Amplitudes over drive levels.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Levels {
    pub(crate) reading: Arc<LevelReading>,
    origin: Origin,
}

/// Reads from paths or bytes without the interpreter lock.
fn read<T: Send + 'static>(
    py: Python<'_>,
    origin: &Origin,
    paths: impl FnOnce(&[PathBuf], &ReadOptions) -> Result<T, ReadError> + Send + 'static,
    bytes: impl FnOnce(&[u8], &str, &ReadOptions) -> Result<T, ReadError> + Send + 'static,
) -> PyResult<Arc<T>> {
    let options = origin.choices.clone().options(py)?;
    let source = origin.source.clone();
    let found = interruptible(py, move || match source {
        Source::Paths(list) => paths(&list, &options),
        Source::Bytes(held, name) => bytes(&held, &name, &options),
    })?;
    found.map(Arc::new).map_err(|error| read_error(py, error))
}

fn record(py: Python<'_>, source: Source, choices: Choices) -> PyResult<Record> {
    let origin = Origin { source, choices };
    let reading = read(
        py,
        &origin,
        |paths, options| slipfit_io::read(&paths[0], options),
        |held, name, options| slipfit_io::read_from(held, name, options),
    )?;
    Ok(Record { reading, origin })
}

fn curve(py: Python<'_>, source: Source, choices: Choices) -> PyResult<Curve> {
    let origin = Origin { source, choices };
    let reading = read(py, &origin, slipfit_io::read_sweep, |held, name, options| {
        slipfit_io::read_sweep_from(held, name, options)
    })?;
    Ok(Curve { reading, origin })
}

fn levels(py: Python<'_>, source: Source, choices: Choices) -> PyResult<Levels> {
    let origin = Origin { source, choices };
    let reading = read(
        py,
        &origin,
        |paths, options| slipfit_io::read_levels(&paths[0], options),
        |held, name, options| slipfit_io::read_levels_from(held, name, options),
    )?;
    Ok(Levels { reading, origin })
}

/// Reads a record from a file or from bytes.
#[pyfunction]
pub(crate) fn read_record(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Record> {
    record(py, source.source(py, name, 1)?, choices)
}

/// Reads a curve from a file, from bytes, or from the driven records of several files or a folder.
#[pyfunction]
pub(crate) fn read_curve(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Curve> {
    curve(py, source.source(py, name, usize::MAX)?, choices)
}

/// Reads drive levels from a file or from bytes.
#[pyfunction]
pub(crate) fn read_levels(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Levels> {
    levels(py, source.source(py, name, 1)?, choices)
}

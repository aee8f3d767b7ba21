//! Records, curves and levels as they were read, from files, bytes and arrays.

use crate::arrays::{self, Vector};
use crate::failure::{option_error, read_error, spell};
use crate::interrupt::interruptible;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use slipfit::SignalKind;
use slipfit::resonance::Response;
use slipfit_io::{Format, LevelReading, ReadError, ReadOptions, ReadReport, Reading, SweepReading};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// A signal over time.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Record {
    pub(crate) reading: Arc<Reading>,
}

/// A response over frequency.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Curve {
    pub(crate) reading: Arc<SweepReading>,
}

/// Amplitudes over drive levels.
#[pyclass(frozen, module = "slipfit")]
pub(crate) struct Levels {
    pub(crate) reading: Arc<LevelReading>,
}

/// Where a reading comes from.
enum Source {
    Paths(Vec<PathBuf>),
    Bytes(Vec<u8>, String),
}

/// How a reading is chosen from a file; the fields of [`ReadOptions`] as keywords.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Choices {
    format: Option<String>,
    sheet: Option<String>,
    part: Option<usize>,
    run: Option<usize>,
    time: Option<String>,
    time_unit: Option<String>,
    rate_hz: Option<f64>,
    signal: Option<String>,
    quadrature: Option<String>,
    unit: Option<String>,
    kind: Option<String>,
    most_samples: Option<usize>,
    frequency: Option<String>,
    frequency_unit: Option<String>,
    centre_hz: Option<f64>,
    amplitude: Option<String>,
    phase: Option<String>,
    phase_unit: Option<String>,
    real: Option<String>,
    imaginary: Option<String>,
    std_error: Option<String>,
    drive: Option<String>,
    drive_unit: Option<String>,
}

impl Choices {
    fn options(self, py: Python<'_>) -> PyResult<ReadOptions> {
        let format_named = |word: String| {
            Format::from_str(&word)
                .map_err(|known| option_error(py, "format", format!("format={word:?}: {known}")))
        };
        Ok(ReadOptions {
            format: self.format.map(format_named).transpose()?,
            sheet: self.sheet,
            part: self.part,
            run: self.run,
            time: self.time,
            time_unit: self.time_unit,
            rate_hz: self.rate_hz,
            signal: self.signal,
            quadrature: self.quadrature,
            unit: self.unit,
            kind: self.kind.map(|word| kind_named(py, &word)).transpose()?,
            most_samples: self.most_samples,
            frequency: self.frequency,
            frequency_unit: self.frequency_unit,
            centre_hz: self.centre_hz,
            amplitude: self.amplitude,
            phase: self.phase,
            phase_unit: self.phase_unit,
            real: self.real,
            imaginary: self.imaginary,
            std_error: self.std_error,
            drive: self.drive,
            drive_unit: self.drive_unit,
        })
    }
}

const KINDS: [(&str, SignalKind); 5] = [
    ("displacement", SignalKind::Displacement),
    ("velocity", SignalKind::Velocity),
    ("acceleration", SignalKind::Acceleration),
    ("envelope", SignalKind::Envelope),
    ("lock-in", SignalKind::LockIn),
];

fn kind_named(py: Python<'_>, word: &str) -> PyResult<SignalKind> {
    KINDS.iter().find(|(name, _)| *name == word).map(|(_, kind)| *kind).ok_or_else(|| {
        let known: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
        option_error(py, "kind", format!("kind={word:?}: one of {}", known.join(", ")))
    })
}

/// Reads from paths or bytes without the interpreter's lock.
fn read<T: Send + 'static>(
    py: Python<'_>,
    source: Source,
    options: ReadOptions,
    paths: impl FnOnce(&[PathBuf], &ReadOptions) -> Result<T, ReadError> + Send + 'static,
    bytes: impl FnOnce(&[u8], &str, &ReadOptions) -> Result<T, ReadError> + Send + 'static,
) -> PyResult<Arc<T>> {
    let found = interruptible(py, move || match source {
        Source::Paths(list) => paths(&list, &options),
        Source::Bytes(held, name) => bytes(&held, &name, &options),
    })?;
    found.map(Arc::new).map_err(|error| read_error(py, error))
}

fn record(py: Python<'_>, source: Source, options: ReadOptions) -> PyResult<Record> {
    let reading = read(
        py,
        source,
        options,
        |paths, options| slipfit_io::read(&paths[0], options),
        |held, name, options| slipfit_io::read_from(held, name, options),
    )?;
    Ok(Record { reading })
}

fn curve(py: Python<'_>, source: Source, options: ReadOptions) -> PyResult<Curve> {
    Ok(Curve {
        reading: read(py, source, options, slipfit_io::read_sweep, |held, name, options| {
            slipfit_io::read_sweep_from(held, name, options)
        })?,
    })
}

fn levels(py: Python<'_>, source: Source, options: ReadOptions) -> PyResult<Levels> {
    let reading = read(
        py,
        source,
        options,
        |paths, options| slipfit_io::read_levels(&paths[0], options),
        |held, name, options| slipfit_io::read_levels_from(held, name, options),
    )?;
    Ok(Levels { reading })
}

/// Paths, or bytes with a name.
#[derive(FromPyObject)]
pub(crate) enum Given<'py> {
    #[pyo3(transparent)]
    Bytes(Bound<'py, PyBytes>),
    #[pyo3(transparent)]
    Paths(Vec<PathBuf>),
}

impl Given<'_> {
    fn source(self, py: Python<'_>, name: Option<String>, most: usize) -> PyResult<Source> {
        match self {
            Self::Bytes(bytes) => {
                Ok(Source::Bytes(bytes.as_bytes().to_vec(), name.unwrap_or_else(|| "bytes".to_owned())))
            }
            Self::Paths(list) if list.is_empty() || list.len() > most => {
                Err(option_error(py, "source", format!("{} files where one is read", list.len())))
            }
            Self::Paths(list) => Ok(Source::Paths(list)),
        }
    }
}

/// Reads a record of a file or of bytes.
#[pyfunction]
pub(crate) fn read_record(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Record> {
    record(py, source.source(py, name, 1)?, choices.options(py)?)
}

/// Reads a curve of a file, of bytes, or of the driven records of several files or a folder.
#[pyfunction]
pub(crate) fn read_curve(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Curve> {
    curve(py, source.source(py, name, usize::MAX)?, choices.options(py)?)
}

/// Reads drive levels of a file or of bytes.
#[pyfunction]
pub(crate) fn read_levels(
    py: Python<'_>,
    source: Given<'_>,
    name: Option<String>,
    choices: Choices,
) -> PyResult<Levels> {
    levels(py, source.source(py, name, 1)?, choices.options(py)?)
}

/// Columns that were given, by name, and the number of each as the reader's options take it.
fn numbered<'a, 'py>(
    columns: &'a [(&'static str, Option<Vector<'py>>)],
) -> (Vec<(&'static str, &'a Vector<'py>)>, impl Fn(&str) -> Option<String>) {
    let given: Vec<_> = columns.iter().filter_map(|(name, values)| Some((*name, values.as_ref()?))).collect();
    let names: Vec<&str> = given.iter().map(|(name, _)| *name).collect();
    let number = move |wanted: &str| {
        names.iter().position(|name| *name == wanted).map(|place| (place + 1).to_string())
    };
    (given, number)
}

/// A record of arrays.
#[pyfunction]
#[pyo3(signature = (time_s, signal, quadrature, rate_hz, unit, kind))]
pub(crate) fn record_of_arrays(
    py: Python<'_>,
    time_s: Option<Vector<'_>>,
    signal: Vector<'_>,
    quadrature: Option<Vector<'_>>,
    rate_hz: Option<f64>,
    unit: Option<String>,
    kind: Option<String>,
) -> PyResult<Record> {
    let columns = [("time_s", time_s), ("signal", Some(signal)), ("quadrature", quadrature)];
    let (given, number) = numbered(&columns);
    let bytes = arrays::npy(py, &given)?;
    let options = ReadOptions {
        time: number("time_s"),
        time_unit: number("time_s").map(|_| "s".to_owned()),
        signal: number("signal"),
        quadrature: number("quadrature"),
        rate_hz,
        unit,
        kind: kind.map(|word| kind_named(py, &word)).transpose()?,
        ..ReadOptions::default()
    };
    record(py, Source::Bytes(bytes, arrays::NAME.to_owned()), options)
}

/// A curve of arrays.
#[pyfunction]
#[pyo3(signature = (frequency_hz, amplitude, phase_rad, real, imaginary, std_error, drive, unit, kind))]
#[allow(clippy::too_many_arguments, reason = "the columns a curve may have")]
pub(crate) fn curve_of_arrays(
    py: Python<'_>,
    frequency_hz: Vector<'_>,
    amplitude: Option<Vector<'_>>,
    phase_rad: Option<Vector<'_>>,
    real: Option<Vector<'_>>,
    imaginary: Option<Vector<'_>>,
    std_error: Option<Vector<'_>>,
    drive: Option<Vector<'_>>,
    unit: Option<String>,
    kind: Option<String>,
) -> PyResult<Curve> {
    let columns = [
        ("frequency_hz", Some(frequency_hz)),
        ("amplitude", amplitude),
        ("phase_rad", phase_rad),
        ("real", real),
        ("imaginary", imaginary),
        ("std_error", std_error),
        ("drive", drive),
    ];
    let (given, number) = numbered(&columns);
    let bytes = arrays::npy(py, &given)?;
    let options = ReadOptions {
        frequency: number("frequency_hz"),
        frequency_unit: Some("Hz".to_owned()),
        amplitude: number("amplitude"),
        phase: number("phase_rad"),
        phase_unit: number("phase_rad").map(|_| "rad".to_owned()),
        real: number("real"),
        imaginary: number("imaginary"),
        std_error: number("std_error"),
        drive: number("drive"),
        unit,
        kind: kind.map(|word| kind_named(py, &word)).transpose()?,
        ..ReadOptions::default()
    };
    curve(py, Source::Bytes(bytes, arrays::NAME.to_owned()), options)
}

/// Drive levels of arrays.
#[pyfunction]
#[pyo3(signature = (drive, amplitude, std_error, unit, drive_unit))]
pub(crate) fn levels_of_arrays(
    py: Python<'_>,
    drive: Vector<'_>,
    amplitude: Vector<'_>,
    std_error: Option<Vector<'_>>,
    unit: Option<String>,
    drive_unit: Option<String>,
) -> PyResult<Levels> {
    let columns = [("drive", Some(drive)), ("amplitude", Some(amplitude)), ("std_error", std_error)];
    let (given, number) = numbered(&columns);
    let bytes = arrays::npy(py, &given)?;
    let options = ReadOptions {
        drive: number("drive"),
        amplitude: number("amplitude"),
        std_error: number("std_error"),
        unit,
        drive_unit,
        ..ReadOptions::default()
    };
    levels(py, Source::Bytes(bytes, arrays::NAME.to_owned()), options)
}

fn notes(report: &ReadReport) -> Vec<String> {
    report.notes.iter().map(|note| note.spelled(&spell)).collect()
}

#[pymethods]
impl Record {
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Array<'py> {
        let record = &self.reading.record;
        record.times_s(0..record.len()).into_pyarray(py)
    }

    #[getter]
    fn signal<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.record.signal())
    }

    #[getter]
    fn quadrature<'py>(&self, py: Python<'py>) -> Option<Array<'py>> {
        self.reading.record.quadrature().map(|values| PyArray1::from_slice(py, values))
    }

    #[getter]
    fn unit(&self) -> &str {
        self.reading.record.unit()
    }

    #[getter]
    fn kind(&self) -> &'static str {
        let kind = self.reading.record.kind();
        KINDS.iter().find(|(_, known)| *known == kind).map_or("other", |(name, _)| name)
    }

    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.record.len()
    }

    fn __repr__(&self) -> String {
        format!("<Record of {}: {} samples, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

#[pymethods]
impl Curve {
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.curve.frequency_hz())
    }

    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        let curve = &self.reading.curve;
        let response: &Response = curve.response();
        PyArray1::from_iter(py, (0..curve.len()).map(|i| response.amplitude(i)))
    }

    #[getter]
    fn unit(&self) -> &str {
        self.reading.curve.unit()
    }

    #[getter]
    fn has_phase(&self) -> bool {
        self.reading.curve.is_complex()
    }

    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.curve.len()
    }

    fn __repr__(&self) -> String {
        format!("<Curve of {}: {} points, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

#[pymethods]
impl Levels {
    #[getter]
    fn drive<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.levels.drive())
    }

    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.levels.amplitude())
    }

    #[getter]
    fn unit(&self) -> &str {
        self.reading.levels.unit()
    }

    #[getter]
    fn drive_unit(&self) -> &str {
        self.reading.levels.drive_unit()
    }

    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.levels.drive().len()
    }

    fn __repr__(&self) -> String {
        format!("<Levels of {}: {} points, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

//! The contents of records, curves and levels.

use super::choices::KINDS;
use super::origin::Call;
use super::{Curve, Levels, Record};
use crate::failure::spell;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use slipfit::resonance::Response;
use slipfit_io::ReadReport;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Equal readings have the same bytes.
fn hash(report: &ReadReport) -> u64 {
    let mut hasher = DefaultHasher::new();
    report.sha256.hash(&mut hasher);
    hasher.finish()
}

/// A column: its name, its unit and its numbers.
type Column<'py> = (&'static str, String, Array<'py>);

/// Objects of pandas and matplotlib are made in Python.
fn by_python<'py>(
    read: &Bound<'py, PyAny>,
    function: &str,
    ax: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let module = read.py().import("slipfit._plot")?;
    match ax {
        Some(ax) => module.call_method1(function, (read, ax)),
        None => module.call_method1(function, (read,)),
    }
}

fn notes(report: &ReadReport) -> Vec<String> {
    report.notes.iter().map(|note| note.spelled(&spell)).collect()
}

#[pymethods]
impl Record {
    /// Times of the samples [s].
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Array<'py> {
        let record = &self.reading.record;
        record.times_s(0..record.len()).into_pyarray(py)
    }

    /// The samples, in `unit`; for a lock-in its X output.
    #[getter]
    fn signal<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.record.signal())
    }

    /// Y output of a lock-in; None for anything else.
    #[getter]
    fn quadrature<'py>(&self, py: Python<'py>) -> Option<Array<'py>> {
        self.reading.record.quadrature().map(|values| PyArray1::from_slice(py, values))
    }

    /// Unit of the samples; empty if unknown.
    #[getter]
    fn unit(&self) -> &str {
        self.reading.record.unit()
    }

    /// What was recorded: displacement, velocity, acceleration, envelope or lock-in.
    #[getter]
    fn kind(&self) -> &'static str {
        let kind = self.reading.record.kind();
        KINDS.iter().find(|(_, known)| *known == kind).map_or("other", |(name, _)| name)
    }

    /// The file, or the name that stands for bytes or arrays.
    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    /// SHA-256 of the bytes that were read.
    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    /// What was assumed or left out while reading, in words.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.record.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.reading, &other.reading) || self.reading == other.reading
    }

    fn __hash__(&self) -> u64 {
        hash(&self.reading.report)
    }

    fn __copy__(of: Py<Self>) -> Py<Self> {
        of
    }

    fn __deepcopy__(of: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        of
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Call<'py>> {
        self.origin.call(py, "read_record", &self.reading.report.sha256)
    }

    fn _columns<'py>(&self, py: Python<'py>) -> Vec<Column<'py>> {
        let unit = self.unit().to_owned();
        let mut columns = vec![("time", "s".to_owned(), self.time_s(py))];
        match self.quadrature(py) {
            Some(quadrature) => {
                columns.extend([("x", unit.clone(), self.signal(py)), ("y", unit, quadrature)]);
            }
            None => columns.push((self.kind(), unit, self.signal(py))),
        }
        columns
    }

    /// The samples as a pandas DataFrame.
    ///
    /// Returns
    /// -------
    /// DataFrame
    ///     A row for each sample; columns ``time (s)`` and the kind of the samples with their unit, such as
    ///     ``displacement (rad)``, for a lock-in ``x`` and ``y``.
    fn to_dataframe<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "frame_of", None)
    }

    /// Draws the samples over time with matplotlib.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib Axes, optional
    ///     Where to draw the main panel; if not given, a figure with all panels is made.
    ///
    /// Returns
    /// -------
    /// list of Axes
    ///     The panels drawn.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "plot_read", ax)
    }

    fn __repr__(&self) -> String {
        format!("<Record of {}: {} samples, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

#[pymethods]
impl Curve {
    /// Frequencies of the drive [Hz].
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.curve.frequency_hz())
    }

    /// Amplitude of the response at each frequency, in `unit`.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        let curve = &self.reading.curve;
        let response: &Response = curve.response();
        PyArray1::from_iter(py, (0..curve.len()).map(|i| response.amplitude(i)))
    }

    /// Unit of the response; empty if unknown.
    #[getter]
    fn unit(&self) -> &str {
        self.reading.curve.unit()
    }

    /// Whether the phases were measured.
    #[getter]
    fn has_phase(&self) -> bool {
        self.reading.curve.is_complex()
    }

    /// The file, or the name that stands for bytes or arrays.
    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    /// SHA-256 of the bytes that were read.
    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    /// What was assumed or left out while reading, in words.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.curve.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.reading, &other.reading) || self.reading == other.reading
    }

    fn __hash__(&self) -> u64 {
        hash(&self.reading.report)
    }

    fn __copy__(of: Py<Self>) -> Py<Self> {
        of
    }

    fn __deepcopy__(of: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        of
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Call<'py>> {
        self.origin.call(py, "read_curve", &self.reading.report.sha256)
    }

    fn _columns<'py>(&self, py: Python<'py>) -> Vec<Column<'py>> {
        let curve = &self.reading.curve;
        let mut columns = vec![
            ("frequency", "Hz".to_owned(), self.frequency_hz(py)),
            ("amplitude", self.unit().to_owned(), self.amplitude(py)),
        ];
        if let Response::Complex(phasors) = curve.response() {
            let phases = PyArray1::from_iter(py, phasors.iter().map(|phasor| phasor.arg()));
            columns.push(("phase", "rad".to_owned(), phases));
        }
        columns
    }

    /// The points as a pandas DataFrame.
    ///
    /// Returns
    /// -------
    /// DataFrame
    ///     A row for each point; columns ``frequency (Hz)``, ``amplitude`` with its unit, and ``phase (rad)`` if it was
    ///     measured.
    fn to_dataframe<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "frame_of", None)
    }

    /// Draws the response over frequency with matplotlib.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib Axes, optional
    ///     Where to draw the main panel; if not given, a figure with all panels is made.
    ///
    /// Returns
    /// -------
    /// list of Axes
    ///     The panels drawn.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "plot_read", ax)
    }

    fn __repr__(&self) -> String {
        format!("<Curve of {}: {} points, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

#[pymethods]
impl Levels {
    /// Levels of the drive, in `drive_unit`.
    #[getter]
    fn drive<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.levels.drive())
    }

    /// Amplitude at each level, in `unit`.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Array<'py> {
        PyArray1::from_slice(py, self.reading.levels.amplitude())
    }

    /// Unit of the amplitudes; empty if unknown.
    #[getter]
    fn unit(&self) -> &str {
        self.reading.levels.unit()
    }

    /// Unit of the levels; empty if unknown.
    #[getter]
    fn drive_unit(&self) -> &str {
        self.reading.levels.drive_unit()
    }

    /// The file, or the name that stands for bytes or arrays.
    #[getter]
    fn path(&self) -> &str {
        &self.reading.report.path
    }

    /// SHA-256 of the bytes that were read.
    #[getter]
    fn sha256(&self) -> &str {
        &self.reading.report.sha256
    }

    /// What was assumed or left out while reading, in words.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.reading.report)
    }

    fn __len__(&self) -> usize {
        self.reading.levels.drive().len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.reading, &other.reading) || self.reading == other.reading
    }

    fn __hash__(&self) -> u64 {
        hash(&self.reading.report)
    }

    fn __copy__(of: Py<Self>) -> Py<Self> {
        of
    }

    fn __deepcopy__(of: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        of
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Call<'py>> {
        self.origin.call(py, "read_levels", &self.reading.report.sha256)
    }

    fn _columns<'py>(&self, py: Python<'py>) -> Vec<Column<'py>> {
        vec![
            ("drive", self.drive_unit().to_owned(), self.drive(py)),
            ("amplitude", self.unit().to_owned(), self.amplitude(py)),
        ]
    }

    /// The points as a pandas DataFrame.
    ///
    /// Returns
    /// -------
    /// DataFrame
    ///     A row for each point; columns ``drive`` and ``amplitude`` with their units.
    fn to_dataframe<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "frame_of", None)
    }

    /// Draws amplitudes over the levels of the drive with matplotlib.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib Axes, optional
    ///     Where to draw the main panel; if not given, a figure with all panels is made.
    ///
    /// Returns
    /// -------
    /// list of Axes
    ///     The panels drawn.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        by_python(slf.as_any(), "plot_read", ax)
    }

    fn __repr__(&self) -> String {
        format!("<Levels of {}: {} points, unit {:?}>", self.path(), self.__len__(), self.unit())
    }
}

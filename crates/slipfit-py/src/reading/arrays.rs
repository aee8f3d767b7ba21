//! Records, curves and levels from arrays.

use super::choices::Choices;
use super::origin::Source;
use super::{Curve, Levels, Record, curve, levels, record};
use crate::arrays::{self, Vector};
use pyo3::prelude::*;
use std::sync::Arc;

/// The given columns by name, and the number of each as the reader's options take it.
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

/// The factor that converts numbers from a unit to another of the same quantity; None if it is not known.
#[pyfunction]
pub(crate) fn unit_factor(unit: &str, wanted: &str) -> Option<f64> {
    slipfit_io::unit_factor(unit, wanted)
}

/// The unit in the name of a column; None if it has no known unit.
#[pyfunction]
pub(crate) fn unit_of_name(name: &str) -> Option<String> {
    slipfit_io::unit_of_name(name)
}

/// A record from arrays.
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
    let choices = Choices {
        time: number("time_s"),
        time_unit: number("time_s").map(|_| "s".to_owned()),
        signal: number("signal"),
        quadrature: number("quadrature"),
        rate_hz,
        unit,
        kind,
        ..Choices::default()
    };
    record(py, Source::Bytes(Arc::new(bytes), arrays::NAME.to_owned()), choices)
}

/// A curve from arrays.
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
    let choices = Choices {
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
        kind,
        ..Choices::default()
    };
    curve(py, Source::Bytes(Arc::new(bytes), arrays::NAME.to_owned()), choices)
}

/// Drive levels from arrays.
#[allow(clippy::too_many_arguments, reason = "the columns levels may have")]
#[pyfunction]
#[pyo3(signature = (drive, amplitude, real, imaginary, std_error, unit, drive_unit))]
pub(crate) fn levels_of_arrays(
    py: Python<'_>,
    drive: Vector<'_>,
    amplitude: Option<Vector<'_>>,
    real: Option<Vector<'_>>,
    imaginary: Option<Vector<'_>>,
    std_error: Option<Vector<'_>>,
    unit: Option<String>,
    drive_unit: Option<String>,
) -> PyResult<Levels> {
    let columns = [
        ("drive", Some(drive)),
        ("amplitude", amplitude),
        ("real", real),
        ("imaginary", imaginary),
        ("std_error", std_error),
    ];
    let (given, number) = numbered(&columns);
    let bytes = arrays::npy(py, &given)?;
    let choices = Choices {
        drive: number("drive"),
        amplitude: number("amplitude"),
        real: number("real"),
        imaginary: number("imaginary"),
        std_error: number("std_error"),
        unit,
        drive_unit,
        ..Choices::default()
    };
    levels(py, Source::Bytes(Arc::new(bytes), arrays::NAME.to_owned()), choices)
}

//! Options of reading a file.

use crate::failure::option_error;
use pyo3::prelude::*;
use slipfit::SignalKind;
use slipfit_io::{Format, ReadOptions};
use std::str::FromStr;

/// The fields of [`ReadOptions`] as keywords.
#[derive(FromPyObject, IntoPyObject, Clone, Default)]
#[pyo3(from_item_all)]
pub(crate) struct Choices {
    pub(super) format: Option<String>,
    pub(super) sheet: Option<String>,
    pub(super) part: Option<usize>,
    pub(super) run: Option<usize>,
    pub(super) time: Option<String>,
    pub(super) time_unit: Option<String>,
    pub(super) rate_hz: Option<f64>,
    pub(super) signal: Option<String>,
    pub(super) quadrature: Option<String>,
    pub(super) unit: Option<String>,
    pub(super) kind: Option<String>,
    pub(super) most_samples: Option<usize>,
    pub(super) frequency: Option<String>,
    pub(super) frequency_unit: Option<String>,
    pub(super) centre_hz: Option<f64>,
    pub(super) amplitude: Option<String>,
    pub(super) phase: Option<String>,
    pub(super) phase_unit: Option<String>,
    pub(super) real: Option<String>,
    pub(super) imaginary: Option<String>,
    pub(super) std_error: Option<String>,
    pub(super) drive: Option<String>,
    pub(super) drive_unit: Option<String>,
}

impl Choices {
    pub(super) fn options(self, py: Python<'_>) -> PyResult<ReadOptions> {
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

pub(super) const KINDS: [(&str, SignalKind); 5] = [
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

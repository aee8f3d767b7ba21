//! What a table says of one file.

use serde::{Deserialize, Serialize};
use slipfit::ringdown::Answer;
use slipfit_io::Reading;
use std::path::Path;

/// One row. A value that does not exist is an empty cell.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) file: String,
    /// `done`, `warned` or `failed`.
    pub(crate) status: String,
    /// Codes of the warnings, or why it failed.
    pub(crate) reason: String,
    pub(crate) model: String,
    pub(crate) frequency_hz: Option<f64>,
    pub(crate) frequency_std_error_hz: Option<f64>,
    pub(crate) decay_rate_per_s: Option<f64>,
    pub(crate) decay_rate_low_per_s: Option<f64>,
    pub(crate) decay_rate_high_per_s: Option<f64>,
    pub(crate) friction_displacement: Option<f64>,
    pub(crate) friction_displacement_low: Option<f64>,
    pub(crate) friction_displacement_high: Option<f64>,
    pub(crate) initial_amplitude: Option<f64>,
    pub(crate) unit: String,
    pub(crate) sliding_detected: Option<bool>,
    pub(crate) sliding_p_value: Option<f64>,
    pub(crate) sliding_share_at_start: Option<f64>,
    pub(crate) cycles: Option<f64>,
    pub(crate) start_s: Option<f64>,
    pub(crate) end_s: Option<f64>,
    pub(crate) samples: Option<u64>,
    pub(crate) rows_skipped: Option<u64>,
    pub(crate) signal: String,
    pub(crate) sha256: String,
}

impl Row {
    pub(crate) fn answered(file: &Path, reading: &Reading, answer: &Answer) -> Self {
        let finite = |v: f64| Some(v).filter(|v| v.is_finite());
        let quantity = |name: &str| answer.parameter(name);
        let value = |name: &str| quantity(name).and_then(|q| finite(q.value));
        let limit = |name: &str, end: usize| quantity(name).and_then(|q| finite(q.interval_95[end]));
        let codes: Vec<&str> = answer.warnings.iter().map(slipfit::ringdown::Warning::code).collect();
        Self {
            file: file.display().to_string(),
            status: if codes.is_empty() { "done" } else { "warned" }.to_owned(),
            reason: codes.join(" "),
            model: answer.model.name().to_owned(),
            frequency_hz: value("frequency_hz"),
            frequency_std_error_hz: quantity("frequency_hz").and_then(|q| finite(q.std_error)),
            decay_rate_per_s: value("decay_rate_per_s"),
            decay_rate_low_per_s: limit("decay_rate_per_s", 0),
            decay_rate_high_per_s: limit("decay_rate_per_s", 1),
            friction_displacement: value("friction_displacement"),
            friction_displacement_low: limit("friction_displacement", 0),
            friction_displacement_high: limit("friction_displacement", 1),
            initial_amplitude: value("initial_amplitude"),
            unit: answer.signal_unit.clone(),
            sliding_detected: Some(answer.sliding.detected),
            sliding_p_value: finite(answer.sliding.p_value),
            sliding_share_at_start: finite(answer.sliding.share_at_start),
            cycles: finite(answer.segment.cycles),
            start_s: finite(answer.segment.start_s),
            end_s: finite(answer.segment.end_s),
            samples: Some(reading.record.len() as u64),
            rows_skipped: Some(reading.report.rows_skipped()),
            signal: reading.report.signal.column.header.clone(),
            sha256: reading.report.sha256.clone(),
        }
    }

    pub(crate) fn failed(file: &Path, reason: &str) -> Self {
        Self {
            file: file.display().to_string(),
            status: "failed".to_owned(),
            reason: reason.split_whitespace().collect::<Vec<_>>().join(" "),
            ..Self::default()
        }
    }
}

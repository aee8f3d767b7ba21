//! The row of a resonance curve.

use super::columns::{columns, high, low, std_error, value};
use slipfit::Parameter;
use slipfit::resonance::Answer;
use slipfit_io::SweepReading;
use slipfit_report::row::{Column, Row, Value};
use std::path::Path;

columns! { |reading: &SweepReading, answer: &Answer| {
    text "model" = answer.model.name(),
    number "natural_frequency_hz" = value(answer.parameter(Parameter::NaturalFrequency)),
    number "natural_frequency_std_error_hz" = std_error(answer.parameter(Parameter::NaturalFrequency)),
    number "decay_rate_per_s" = value(answer.parameter(Parameter::DECAY_RATE)),
    number "decay_rate_low_per_s" = low(answer.parameter(Parameter::DECAY_RATE)),
    number "decay_rate_high_per_s" = high(answer.parameter(Parameter::DECAY_RATE)),
    number "friction_displacement" = value(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    number "friction_displacement_low" = low(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    number "friction_displacement_high" = high(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    number "drive_amplitude" = value(answer.parameter(Parameter::DriveAmplitude)),
    number "drive_amplitude_std_error" = std_error(answer.parameter(Parameter::DriveAmplitude)),
    text "drive_source" = answer.drive_source.name(),
    number "friction_ratio" = value(answer.parameter(Parameter::FrictionRatio)),
    text "unit" = &answer.unit,
    flag "sliding_detected" = answer.sliding.detected,
    number "sliding_p_value" = answer.sliding.p_value,
    number "sliding_share_at_peak" = answer.sliding.share_at_highest,
    number "line_widths" = answer.diagnostics.line_widths,
    count "points" = answer.diagnostics.points as u64,
    count "rows_skipped" = reading.report.rows_skipped(),
    text "sha256" = &reading.report.sha256,
} }

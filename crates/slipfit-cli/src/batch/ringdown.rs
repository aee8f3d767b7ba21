//! The row of a ring-down.

use super::columns::{columns, high, low, std_error, value};
use slipfit::Parameter;
use slipfit::ringdown::Answer;
use slipfit_io::Reading;
use slipfit_report::row::{Column, Row, Value};
use std::path::Path;

columns! { |reading: &Reading, answer: &Answer| {
    text "model" = answer.model.name(),
    number "frequency_hz" = value(answer.parameter(Parameter::Frequency)),
    number "frequency_std_error_hz" = std_error(answer.parameter(Parameter::Frequency)),
    number "decay_rate_per_s" = value(answer.parameter(Parameter::DECAY_RATE)),
    number "decay_rate_low_per_s" = low(answer.parameter(Parameter::DECAY_RATE)),
    number "decay_rate_high_per_s" = high(answer.parameter(Parameter::DECAY_RATE)),
    number "friction_displacement" = value(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    number "friction_displacement_low" = low(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    number "friction_displacement_high" = high(answer.parameter(Parameter::FRICTION_DISPLACEMENT)),
    text "friction_unit" = answer.parameter(Parameter::FRICTION_DISPLACEMENT).map_or("", |q| &q.unit),
    number "initial_amplitude" = value(answer.parameter(Parameter::InitialAmplitude)),
    text "unit" = &answer.signal_unit,
    flag "sliding_detected" = answer.sliding.detected,
    number "sliding_p_value" = answer.sliding.p_value,
    number "sliding_share_at_start" = answer.sliding.share_at_highest,
    number "cycles" = answer.segment.cycles,
    number "start_s" = answer.segment.start_s,
    number "end_s" = answer.segment.end_s,
    count "samples" = reading.record.len() as u64,
    count "rows_skipped" = reading.report.rows_skipped(),
    text "signal" = reading.report.column("signal").map_or("", |s| &s.column.header),
    text "sha256" = &reading.report.sha256,
} }

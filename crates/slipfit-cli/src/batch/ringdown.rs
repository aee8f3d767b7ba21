//! The row of a ring-down.

use slipfit::Parameter;
use slipfit::ringdown::Answer;
use slipfit_io::Reading;
use slipfit_report::row::{Column, Row, Value};
use std::path::Path;

pub(crate) const COLUMNS: &[Column] = &[
    Column::text("model"),
    Column::number("frequency_hz"),
    Column::number("frequency_std_error_hz"),
    Column::number("decay_rate_per_s"),
    Column::number("decay_rate_low_per_s"),
    Column::number("decay_rate_high_per_s"),
    Column::number("friction_displacement"),
    Column::number("friction_displacement_low"),
    Column::number("friction_displacement_high"),
    Column::number("initial_amplitude"),
    Column::text("unit"),
    Column::flag("sliding_detected"),
    Column::number("sliding_p_value"),
    Column::number("sliding_share_at_start"),
    Column::number("cycles"),
    Column::number("start_s"),
    Column::number("end_s"),
    Column::count("samples"),
    Column::count("rows_skipped"),
    Column::text("signal"),
    Column::text("sha256"),
];

pub(crate) fn row(file: &Path, reading: &Reading, answer: &Answer) -> Row {
    let codes: Vec<&str> = answer.warnings.iter().map(slipfit::answer::Warning::code).collect();
    let q = |name: Parameter| answer.parameter(name);
    let mut values = vec![Value::text(answer.model.name())];
    values.extend(Value::with_error(q(Parameter::Frequency)));
    values.extend(Value::ranged(q(Parameter::DECAY_RATE)));
    values.extend(Value::ranged(q(Parameter::FRICTION_DISPLACEMENT)));
    values.extend([
        q(Parameter::InitialAmplitude).map_or(Value::None, |q| Value::number(q.value)),
        Value::text(&answer.signal_unit),
        Value::Flag(answer.sliding.detected),
        Value::number(answer.sliding.p_value),
        Value::number(answer.sliding.share_at_highest),
        Value::number(answer.segment.cycles),
        Value::number(answer.segment.start_s),
        Value::number(answer.segment.end_s),
        Value::Count(reading.record.len() as u64),
        Value::Count(reading.report.rows_skipped()),
        Value::text(reading.report.column("signal").map_or("", |s| &s.column.header)),
        Value::text(&reading.report.sha256),
    ]);
    Row::answered(file, &codes, COLUMNS, values)
}

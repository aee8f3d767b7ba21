//! The row of a resonance curve.

use slipfit::Parameter;
use slipfit::resonance::Answer;
use slipfit_io::SweepReading;
use slipfit_report::row::{Column, Row, Value};
use std::path::Path;

pub(crate) const COLUMNS: &[Column] = &[
    Column::text("model"),
    Column::number("natural_frequency_hz"),
    Column::number("natural_frequency_std_error_hz"),
    Column::number("decay_rate_per_s"),
    Column::number("decay_rate_low_per_s"),
    Column::number("decay_rate_high_per_s"),
    Column::number("friction_displacement"),
    Column::number("friction_displacement_low"),
    Column::number("friction_displacement_high"),
    Column::number("drive_amplitude"),
    Column::number("drive_amplitude_std_error"),
    Column::text("drive_source"),
    Column::number("friction_ratio"),
    Column::text("unit"),
    Column::flag("sliding_detected"),
    Column::number("sliding_p_value"),
    Column::number("sliding_share_at_peak"),
    Column::number("line_widths"),
    Column::count("points"),
    Column::count("rows_skipped"),
    Column::text("sha256"),
];

pub(crate) fn row(file: &Path, reading: &SweepReading, answer: &Answer) -> Row {
    let codes: Vec<&str> = answer.warnings.iter().map(slipfit::answer::Warning::code).collect();
    let q = |name: Parameter| answer.parameter(name);
    let mut values = vec![Value::text(answer.model.name())];
    values.extend(Value::with_error(q(Parameter::NaturalFrequency)));
    values.extend(Value::ranged(q(Parameter::DECAY_RATE)));
    values.extend(Value::ranged(q(Parameter::FRICTION_DISPLACEMENT)));
    values.extend(Value::with_error(q(Parameter::DriveAmplitude)));
    values.extend([
        Value::text(answer.drive_source.name()),
        q(Parameter::FrictionRatio).map_or(Value::None, |q| Value::number(q.value)),
        Value::text(&answer.unit),
        Value::Flag(answer.sliding.detected),
        Value::number(answer.sliding.p_value),
        Value::number(answer.sliding.share_at_highest),
        Value::number(answer.diagnostics.line_widths),
        Value::Count(answer.diagnostics.points as u64),
        Value::Count(reading.report.rows_skipped()),
        Value::text(&reading.report.sha256),
    ]);
    Row::answered(file, &codes, COLUMNS, values)
}

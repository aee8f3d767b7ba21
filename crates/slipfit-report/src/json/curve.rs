//! What the answers to curves, levels and series share.

use super::node::{Node, list};
use slipfit::Calibration;
use slipfit::Parameters;
use slipfit_io::{ColumnInfo, ColumnTaken, Skipped, SweepReading};

pub(super) fn parameters(parameters: &Parameters) -> Node {
    Node::Named(parameters.iter().map(|(p, q)| (p.name().to_owned(), q.into())).collect())
}

pub(super) fn calibration(calibration: Option<&Calibration>) -> Node {
    let (kind, value, std_error) = match calibration {
        Some(Calibration::Stiffness { value, std_error }) => ("stiffness", *value, *std_error),
        Some(Calibration::Mass { value, std_error }) => ("mass", *value, *std_error),
        _ => return Node::Null,
    };
    Node::Object(vec![("kind", kind.into()), ("value", value.into()), ("std_error", std_error.into())])
}

pub(super) fn skipped(skipped: &[Skipped]) -> Node {
    list(skipped, |s| {
        Node::Object(vec![
            ("reason", s.reason.as_str().into()),
            ("rows", s.rows.into()),
            ("first_row", s.first_row.into()),
        ])
    })
}

pub(super) fn columns(columns: &[ColumnInfo]) -> Node {
    list(columns, |c| {
        Node::Object(vec![
            ("number", c.number.into()),
            ("header", c.header.as_str().into()),
            ("unit", c.unit.as_str().into()),
        ])
    })
}

pub(super) fn taken(taken: &[(&'static str, ColumnTaken)]) -> Node {
    let one = |t: &ColumnTaken| {
        Node::Object(vec![
            ("number", t.column.number.into()),
            ("header", t.column.header.as_str().into()),
            ("unit", t.unit.as_str().into()),
            ("why", t.why.as_str().into()),
        ])
    };
    Node::Named(taken.iter().map(|(what, t)| ((*what).to_owned(), one(t))).collect())
}

pub(super) fn warnings<W: ToString>(warnings: &[W], code: impl Fn(&W) -> &'static str) -> Node {
    list(warnings, |w| Node::Object(vec![("code", code(w).into()), ("message", w.to_string().into())]))
}

/// How a curve was read.
pub(super) fn input(reading: &SweepReading) -> Node {
    let report = &reading.report;
    let curve = &reading.curve;
    let (low, high) = curve
        .frequency_hz()
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| (l.min(*f), h.max(*f)));
    let runs = list(curve.runs(), |r| {
        Node::Object(vec![
            ("first", r.first.into()),
            ("points", r.points.into()),
            ("direction", super::resonance::direction(r.direction).into()),
        ])
    });
    let records = list(&report.runs, |r| {
        let s = &r.steady;
        Node::Object(vec![
            ("path", r.path.as_str().into()),
            ("sha256", r.sha256.as_str().into()),
            ("samples", r.samples.into()),
            ("frequency_hz", (&s.frequency_hz).into()),
            ("amplitude", (&s.amplitude).into()),
            ("phase_rad", s.phase_rad.as_ref().into()),
            ("drive_amplitude", s.drive_amplitude.as_ref().into()),
            ("frequency_wander_hz", s.frequency_wander_hz.into()),
            ("transient_s", s.transient_s.into()),
            ("time_range_used_s", [s.start_s, s.end_s].into()),
            ("cycles", s.cycles.into()),
            ("settled", s.settled.into()),
            ("residual_rms", s.residual_rms.into()),
        ])
    });
    Node::Object(vec![
        ("path", report.path.as_str().into()),
        ("sha256", report.sha256.as_str().into()),
        ("bytes", report.bytes.into()),
        ("sheet", report.sheet.as_str().into()),
        ("rows_read", report.rows_read.into()),
        ("rows_skipped", report.rows_skipped().into()),
        ("skipped", skipped(&report.skipped)),
        ("columns", columns(&report.columns)),
        ("run", report.column_run.into()),
        ("runs", report.column_runs.into()),
        ("taken", taken(&report.taken)),
        ("kind", super::ringdown::kind(report.kind).into()),
        ("unit", curve.unit().into()),
        ("points", curve.len().into()),
        ("has_phase", curve.is_complex().into()),
        ("frequency_range_hz", [low, high].into()),
        ("sweeps", runs),
        ("records", records),
        ("files_left_out", report.files_left_out.into()),
        ("notes", report.notes.clone().into()),
    ])
}

//! The answer to drive levels: docs/schema/levels-1.json.

use super::curve::{calibration, columns, parameters, skipped, taken, warnings};
use super::layout;
use super::node::{Node, numbers};
use crate::AnalysedLevels;
use crate::Sentence;
use std::io::{self, Write};

/// Writes the whole answer.
pub fn levels(out: &mut dyn Write, analysed: &AnalysedLevels<'_>) -> io::Result<()> {
    layout::write(out, &document(analysed))
}

fn document(analysed: &AnalysedLevels<'_>) -> Node {
    let (a, r, o) = (analysed.answer, analysed.reading, analysed.options);
    let d = &a.diagnostics;
    let breakaway = a.breakaway.as_ref().map(|b| {
        Node::Object(vec![
            ("stuck_below", b.stuck_below.into()),
            ("moving_from", b.moving_from.into()),
            ("stuck_above_threshold", b.stuck_above_threshold.into()),
            ("static_ratio_at_least", b.static_ratio_at_least.into()),
        ])
    });
    Node::Object(vec![
        ("schema", "slipfit/levels-1".into()),
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("command", "levels".into()),
        (
            "input",
            Node::Object(vec![
                ("path", r.path.as_str().into()),
                ("sha256", r.sha256.as_str().into()),
                ("bytes", r.bytes.into()),
                ("rows_read", r.rows_read.into()),
                ("rows_skipped", r.rows_skipped().into()),
                ("skipped", skipped(&r.skipped)),
                ("columns", columns(&r.columns)),
                ("taken", taken(&r.taken)),
                ("unit", a.unit.as_str().into()),
                ("drive_unit", a.drive_unit.as_str().into()),
                ("notes", r.notes.clone().into()),
            ]),
        ),
        (
            "options",
            Node::Object(vec![
                ("frequency_hz", o.frequency_hz.into()),
                ("drive_gain", o.drive_gain.into()),
                ("q_factor", o.q_factor.into()),
                ("calibration", calibration(o.calibration.as_ref())),
            ]),
        ),
        ("sentence", a.sentence().into()),
        ("parameters", parameters(&a.parameters)),
        ("detected", a.detected.into()),
        ("p_value", a.p_value.into()),
        ("correlation", a.correlation.into()),
        ("breakaway", breakaway.into()),
        (
            "diagnostics",
            Node::Object(vec![
                ("points", d.points.into()),
                ("moving", d.moving.into()),
                ("stuck", d.stuck.into()),
                ("residual_rms", d.residual_rms.into()),
                ("bend_p_value", d.bend_p_value.into()),
            ]),
        ),
        ("warnings", warnings(&a.warnings, |w| w.code())),
        (
            "levels",
            Node::Object(vec![
                ("drive", numbers(&a.points, |p| p.drive)),
                ("amplitude", numbers(&a.points, |p| p.amplitude)),
                ("std_error", numbers(&a.points, |p| p.std_error)),
                ("fitted", numbers(&a.points, |p| p.fitted)),
                ("moving", Node::List(a.points.iter().map(|p| p.moving.into()).collect())),
            ]),
        ),
    ])
}

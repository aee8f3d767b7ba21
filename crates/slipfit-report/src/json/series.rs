//! The answer to a series: docs/schema/series-1.json.

use super::curve::{calibration, parameters, warnings};
use super::layout;
use super::node::{Node, list};
use crate::AnalysedSeries;
use crate::Sentence;
use slipfit::series::{Consistency, Estimate, SingleAnswer};
use std::io::{self, Write};

/// Writes the whole answer.
pub fn series(out: &mut dyn Write, analysed: &AnalysedSeries<'_>) -> io::Result<()> {
    layout::write(out, &document(analysed))
}

fn document(analysed: &AnalysedSeries<'_>) -> Node {
    let (a, m) = (analysed.answer, analysed.heading);
    let rows = list(&a.table, |r| {
        Node::Object(vec![
            ("condition", r.condition.as_str().into()),
            ("value", r.value.map(|v| v[0]).into()),
            ("value_std_error", r.value.map(|v| v[1]).into()),
            ("ringdown", cell(r.ring_down.as_ref())),
            ("resonance", cell(r.resonance.as_ref())),
            ("friction_agreement", pair(r.friction.as_ref())),
            ("damping_agreement", pair(r.damping.as_ref())),
            ("p_value", r.p_value.into()),
            ("joint", cell(r.joint.as_ref())),
        ])
    });
    let laws = list(&a.laws, |l| {
        Node::Object(vec![
            ("law", l.law.to_string().into()),
            ("coefficient", (&l.coefficient).into()),
            ("offset", l.offset.as_ref().into()),
            ("chi_square", l.chi_square.into()),
            ("degrees_of_freedom", l.degrees_of_freedom.into()),
            ("p_value", l.p_value.into()),
            ("bic", l.bic.into()),
            ("delta_bic", l.delta_bic.into()),
        ])
    });
    let joint = a.joint.as_ref().map(|j| {
        Node::Object(vec![
            ("natural_frequency_hz", j.natural_frequency_hz.as_ref().into()),
            ("drive_amplitude", j.drive_amplitude.as_ref().into()),
            ("decay_rate_per_s", j.decay_rate_per_s.as_ref().into()),
            ("chi_square", j.chi_square.into()),
            ("degrees_of_freedom", j.degrees_of_freedom.into()),
            ("p_value", j.p_value.into()),
        ])
    });
    let s = m.shared;
    let shared: Vec<&str> = [
        (s.natural_frequency, "natural_frequency"),
        (s.drive_amplitude, "drive_amplitude"),
        (s.decay_rate, "decay_rate"),
    ]
    .into_iter()
    .filter_map(|(is, name)| is.then_some(name))
    .collect();
    Node::Object(vec![
        ("schema", "slipfit/series-1".into()),
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("command", "series".into()),
        ("manifest", m.path.as_str().into()),
        ("title", m.title.as_str().into()),
        ("condition", m.condition.as_str().into()),
        ("condition_unit", m.condition_unit.as_str().into()),
        ("unit", analysed.options.unit.as_str().into()),
        ("shared", shared.into()),
        ("calibration", calibration(analysed.options.calibration.as_ref())),
        ("sentence", a.sentence().into()),
        ("table", rows),
        ("agreement_p_value", a.agreement_p_value.into()),
        ("joint", joint.into()),
        ("laws", laws),
        ("measurements", measurements(analysed)),
        ("warnings", warnings(&a.warnings, |w| w.code())),
    ])
}

fn measurements(analysed: &AnalysedSeries<'_>) -> Node {
    let each = analysed.answer.solo.iter().zip(analysed.inputs).zip(analysed.measurements);
    Node::List(
        each.map(|(((name, solo), input), m)| {
            let (error, sentence, told, doubts) = match solo {
                Ok(SingleAnswer::RingDown(a)) => {
                    (None, a.sentence(), parameters(&a.parameters), warnings(&a.warnings, |w| w.code()))
                }
                Ok(SingleAnswer::Sweep(a)) => {
                    (None, a.sentence(), parameters(&a.parameters), warnings(&a.warnings, |w| w.code()))
                }
                Ok(SingleAnswer::Levels(a)) => {
                    (None, a.sentence(), parameters(&a.parameters), warnings(&a.warnings, |w| w.code()))
                }
                Ok(_) => (None, String::new(), parameters(&Default::default()), Node::List(Vec::new())),
                Err(e) => (
                    Some(e.to_string()),
                    String::new(),
                    parameters(&Default::default()),
                    Node::List(Vec::new()),
                ),
            };
            Node::Object(vec![
                ("name", name.as_str().into()),
                ("kind", input.kind.into()),
                ("condition", m.condition.label.as_str().into()),
                ("path", input.path.as_str().into()),
                ("sha256", input.sha256.as_str().into()),
                ("unit", input.unit.as_str().into()),
                ("scale", m.scale.into()),
                ("error", error.into()),
                ("sentence", sentence.into()),
                ("parameters", told),
                ("warnings", doubts),
                ("notes", input.notes.clone().into()),
            ])
        })
        .collect(),
    )
}

fn cell(cell: Option<&Estimate>) -> Node {
    let Some(cell) = cell else { return Node::Null };
    Node::Object(vec![
        ("friction", (&cell.friction).into()),
        ("damping", (&cell.damping).into()),
        ("correlation", cell.correlation.into()),
    ])
}

fn pair(pair: Option<&Consistency>) -> Node {
    let Some(pair) = pair else { return Node::Null };
    Node::Object(vec![("z", pair.z.into()), ("p_value", pair.p_value.into())])
}

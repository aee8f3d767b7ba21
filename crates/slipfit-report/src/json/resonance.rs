//! The answer to a resonance curve: docs/schema/resonance-1.json.

use super::curve::{calibration, input, parameters, warnings};
use super::layout;
use super::node::{Node, list, numbers};
use crate::AnalysedCurve;
use crate::Sentence;
use slipfit::Parameter;
use slipfit::resonance::{Answer, CurvePoint, Instrument, Method, Options, RunDirection};
use std::io::{self, Write};

/// Writes the whole answer.
pub fn resonance(out: &mut dyn Write, analysed: &AnalysedCurve<'_>) -> io::Result<()> {
    layout::write(out, &document(analysed))
}

fn document(analysed: &AnalysedCurve<'_>) -> Node {
    let a = analysed.answer;
    Node::Object(vec![
        ("schema", "slipfit/resonance-1".into()),
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("command", "resonance".into()),
        ("input", input(analysed.reading)),
        ("reference_input", analysed.reference.map(input).into()),
        ("options", options(analysed.options)),
        ("model", a.model.name().into()),
        ("method", method(a.method).into()),
        ("drive_source", a.drive_source.name().into()),
        ("mean_drive", a.mean_drive.into()),
        ("sentence", a.sentence().into()),
        ("parameters", parameters(&a.parameters)),
        ("comparison", comparison(a)),
        ("sliding", sliding(a)),
        (
            "correlations",
            list(&a.correlations, |c| {
                let names = c.parameters.map(|p| p.name());
                Node::Object(vec![("parameters", names.into()), ("value", c.value.into())])
            }),
        ),
        ("instrument", instrument(&a.instrument)),
        ("paper", paper(a)),
        ("reference", reference(a)),
        ("force_line", force_line(a)),
        ("diagnostics", diagnostics(a)),
        ("warnings", warnings(&a.warnings, |w| w.code())),
        ("curve", points(&a.points)),
        ("force", force(a)),
    ])
}

pub(super) fn direction(direction: RunDirection) -> &'static str {
    match direction {
        RunDirection::Up => "up",
        RunDirection::Down => "down",
        RunDirection::Unordered => "unordered",
    }
}

pub(crate) fn method(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::Leading => "leading",
        Method::Paper => "paper",
        _ => "other",
    }
}

fn options(options: &Options) -> Node {
    let drive = options
        .drive_amplitude
        .map(|d| Node::Object(vec![("value", d.value.into()), ("std_error", d.std_error.into())]));
    let t = options.terms;
    Node::Object(vec![
        ("band_hz", options.band_hz.into()),
        ("method", method(options.method).into()),
        ("model", options.model.map(|m| m.name()).into()),
        ("drive_amplitude", drive.into()),
        ("background", t.background.into()),
        ("delay", t.delay.into()),
        ("phase_offset", t.phase_offset.into()),
        ("duffing", t.duffing.into()),
        ("calibration", calibration(options.calibration.as_ref())),
    ])
}

fn comparison(a: &Answer) -> Node {
    list(&a.comparison, |c| {
        Node::Object(vec![
            ("model", c.model.name().into()),
            ("bic", c.bic.into()),
            ("delta_bic", c.delta_bic.into()),
            ("rms", c.rms.into()),
            ("free_parameters", c.free_parameters.into()),
            ("converged", c.converged.into()),
            ("at_limit", c.at_limit.map(|p| p.name()).into()),
            ("natural_frequency_hz", c.value(Parameter::NaturalFrequency).into()),
            ("decay_rate_per_s", c.value(Parameter::DECAY_RATE).into()),
            ("friction_displacement", c.value(Parameter::FRICTION_DISPLACEMENT).into()),
            ("drive_amplitude", c.value(Parameter::DriveAmplitude).into()),
            ("drag_rate", c.value(Parameter::DRAG_RATE).into()),
        ])
    })
}

fn sliding(a: &Answer) -> Node {
    let s = &a.sliding;
    Node::Object(vec![
        ("detected", s.detected.into()),
        ("p_value", s.p_value.into()),
        ("delta_bic", s.delta_bic.into()),
        ("share_at_highest", s.share_at_highest.into()),
        ("share_at_lowest", s.share_at_lowest.into()),
        ("viscous_only_p_value", s.viscous_only_p_value.into()),
    ])
}

fn instrument(i: &Instrument) -> Node {
    Node::Object(vec![
        ("phase_offset_rad", i.phase_offset_rad.as_ref().into()),
        ("delay_s", i.delay_s.as_ref().into()),
        ("background", i.background.as_ref().map(|b| Node::List(b.iter().map(Node::from).collect())).into()),
        ("background_delayed", i.background_delayed.into()),
        ("phase_was_conjugated", i.phase_was_conjugated.into()),
        ("centre_hz", i.centre_hz.into()),
    ])
}

fn paper(a: &Answer) -> Node {
    let Some(p) = &a.paper else { return Node::Null };
    Node::Object(vec![
        ("effective_q_factor", p.effective_q_factor.into()),
        ("effective_drive", p.effective_drive.into()),
        ("natural_frequency_hz", p.natural_frequency_hz.into()),
        ("q_factor", p.q_factor.into()),
        ("friction_displacement", p.friction_displacement.into()),
        ("friction_ratio", p.friction_ratio.into()),
        ("q_factor_bias", p.q_factor_bias.into()),
        ("friction_bias", p.friction_bias.into()),
    ])
}

fn reference(a: &Answer) -> Node {
    let Some(r) = &a.reference else { return Node::Null };
    Node::Object(vec![
        ("natural_frequency_hz", (&r.natural_frequency_hz).into()),
        ("decay_rate_per_s", (&r.decay_rate_per_s).into()),
        ("sliding_p_value", r.sliding_p_value.into()),
        ("curve", points(&r.points)),
    ])
}

fn force_line(a: &Answer) -> Node {
    let Some(line) = &a.force_line else { return Node::Null };
    Node::Object(vec![
        ("friction_displacement", (&line.friction_displacement).into()),
        ("decay_rate_per_s", (&line.decay_rate_per_s).into()),
        ("reduced_chi_square", line.reduced_chi_square.into()),
        ("points", line.points.into()),
    ])
}

fn diagnostics(a: &Answer) -> Node {
    let d = &a.diagnostics;
    Node::Object(vec![
        ("points", d.points.into()),
        ("outside_band", d.outside_band.into()),
        ("left_out", d.left_out.into()),
        ("noise_rms", d.noise_rms.into()),
        ("residual_rms", d.residual_rms.into()),
        ("residual_excess", d.residual_excess.into()),
        ("residual_autocorrelation", d.residual_autocorrelation.into()),
        ("signal_to_noise_db", d.signal_to_noise_db.into()),
        ("line_widths", d.line_widths.into()),
        ("points_in_line", d.points_in_line.into()),
        ("points_with_stops", d.points_with_stops.into()),
    ])
}

/// Columns rather than rows: a notebook wants arrays.
fn points(points: &[CurvePoint]) -> Node {
    Node::Object(vec![
        ("index", Node::List(points.iter().map(|p| p.index.into()).collect())),
        ("frequency_hz", numbers(points, |p| p.frequency_hz)),
        ("amplitude", numbers(points, |p| p.amplitude)),
        ("phase_rad", numbers(points, |p| p.phase_rad.unwrap_or(f64::NAN))),
        ("std_error", numbers(points, |p| p.std_error)),
        ("fitted_amplitude", numbers(points, |p| p.fitted_amplitude)),
        ("fitted_phase_rad", numbers(points, |p| p.fitted_phase_rad)),
        ("residual", numbers(points, |p| p.residual)),
        ("residual_across", numbers(points, |p| p.residual_across)),
        ("stops", Node::List(points.iter().map(|p| p.stops.into()).collect())),
        ("drive", numbers(points, |p| p.drive)),
    ])
}

fn force(a: &Answer) -> Node {
    let f = &a.force;
    Node::Object(vec![
        ("frequency_hz", numbers(f, |p| p.frequency_hz)),
        ("amplitude", numbers(f, |p| p.amplitude)),
        ("dissipative", numbers(f, |p| p.dissipative)),
        ("dissipative_std_error", numbers(f, |p| p.dissipative_std_error)),
        ("elastic", numbers(f, |p| p.elastic)),
        ("elastic_std_error", numbers(f, |p| p.elastic_std_error)),
    ])
}

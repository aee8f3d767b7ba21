//! The answer to a resonance curve on one screen.

use super::account::{column, counted};
use super::facts::Facts;
use super::parameters::{Told, laid_out, significant};
use super::ringdown::{bic, headed, model_table};
use super::{ANSWER, WIDTH, labelled, wrap};
use crate::AnalysedCurve;
use crate::Sentence;
use crate::format::{Rounded, Scale, p_value, plain};
use slipfit::LossTerm;
use slipfit::Parameter;
use slipfit::Quantity;
use slipfit::answer::Candidate;
use slipfit::resonance::{Answer, DriveSource, Method, RunDirection};
use slipfit_io::{Skipped, SweepReading};
use std::fmt::Write as _;
use std::path::Path;

/// Forces with a chi square above this lie on no straight line.
const NO_LINE: f64 = 3.0;

/// The whole report, styled.
pub fn resonance(analysed: &AnalysedCurve<'_>, written: &[&Path]) -> String {
    let answer = analysed.answer;
    let mut text = String::new();
    for line in wrap(&answer.sentence(), WIDTH) {
        let _ = writeln!(text, "{ANSWER}{line}{ANSWER:#}");
    }
    text.push('\n');
    text += &laid_out(&told(answer));
    text.push('\n');
    text += &models(answer);
    text.push('\n');
    text += &account(analysed).told();
    if !written.is_empty() {
        let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        text += &labelled("wrote", &names.join(", "));
    }
    text
}

/// The parameters that say something.
pub(crate) fn told(answer: &Answer) -> Vec<Told> {
    let is_told = |(p, q): &(Parameter, &Quantity)| match p {
        &Parameter::DRAG_RATE | Parameter::DuffingCoefficient => q.value != 0.0,
        _ => q.value.is_finite(),
    };
    let tell = |(p, q): (Parameter, &Quantity)| match is_absent(answer, p) {
        true => Told::absent(p, q),
        false => Told::new(p, q),
    };
    answer.parameters.iter().filter(is_told).map(tell).collect()
}

/// Whether the model reported has no such term.
fn is_absent(answer: &Answer, parameter: Parameter) -> bool {
    match parameter {
        Parameter::Loss(LossTerm::Drag) => false,
        Parameter::Loss(term) => !answer.model.has(term),
        Parameter::CoulombForce | Parameter::FrictionRatio => !answer.model.has_sliding(),
        Parameter::ViscousCoefficient | Parameter::QFactor => !answer.model.has(LossTerm::Viscous),
        _ => false,
    }
}

fn models(answer: &Answer) -> String {
    let chosen = |i: usize| answer.comparison[i].model == answer.model;
    let settled = answer.comparison.iter().all(|c| c.converged);
    model_table(&model_rows(answer), chosen, settled)
}

/// All models on the same data: a line of headings, then one row each. Columns that say
/// nothing are empty.
pub(crate) fn model_rows(answer: &Answer) -> Vec<Vec<String>> {
    let unit = &answer.unit;
    let most = |of: fn(&Candidate) -> f64| {
        answer.comparison.iter().map(of).filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let rms = Scale::for_size(most(|c| c.rms), unit);
    let x_f = Scale::for_size(most(|c| c.value(Parameter::FRICTION_DISPLACEMENT)), unit);
    let x_0 = Scale::for_size(most(|c| c.value(Parameter::DriveAmplitude)), unit);
    let drag = answer.comparison.iter().any(|c| c.model.has(LossTerm::Drag));
    let mut head = vec![
        // The paper's inversion compares no models: the exact curve does.
        if answer.method == Method::Paper { "exact model" } else { "model" }.to_owned(),
        "ΔBIC".to_owned(),
        headed("rms", &rms),
        headed("δ", &Scale::for_size(1.0, "1/s")),
        headed("x_F", &x_f),
        headed("x₀", &x_0),
    ];
    head.push(if drag { "a₂".to_owned() } else { String::new() });
    let mut rows = vec![head];
    for c in &answer.comparison {
        let settled = if c.converged { "" } else { " *" };
        let term = |term: LossTerm, scale: f64| match c.model.has(term) {
            false => "-".to_owned(),
            true if c.at_limit == Some(Parameter::Loss(term)) => "at 0".to_owned(),
            true => significant(c.value(Parameter::Loss(term)) * scale, 3),
        };
        rows.push(vec![
            format!("{}{settled}", c.model),
            bic(c.delta_bic),
            significant(c.rms * rms.factor, 3),
            term(LossTerm::Viscous, 1.0),
            term(LossTerm::Sliding, x_f.factor),
            significant(c.value(Parameter::DriveAmplitude) * x_0.factor, 3),
            if drag { term(LossTerm::Drag, 1.0) } else { String::new() },
        ]);
    }
    rows
}

/// Where the answer comes from.
pub(crate) fn account(analysed: &AnalysedCurve<'_>) -> Facts {
    let answer = analysed.answer;
    let mut facts = Facts::default();
    source(&mut facts, analysed.reading);
    if let Some(reference) = analysed.reference {
        facts.add("against", read_line(reference));
    }
    let method = match answer.method {
        Method::Exact => "exact fundamental",
        Method::Leading => "leading term, eq. (8)",
        Method::Paper => "effective Lorentzian of the paper, eq. (14)",
        _ => "another way",
    };
    let drive = match answer.drive_source {
        DriveSource::Known => "x₀ as given",
        DriveSource::Reference => "x₀ from the reference",
        DriveSource::Shape => "x₀ from the shape alone",
        _ => "x₀ unknown",
    };
    let level = answer.mean_drive.map(|mean| {
        let taken = analysed.reading.report.taken.iter().find(|t| t.0 == "drive");
        let unit = taken.map_or("", |t| t.1.unit.as_str());
        format!(" (at the mean drive {})", plain(mean, 3, unit))
    });
    let level = level.unwrap_or_default();
    let d = &answer.diagnostics;
    let mut left = Vec::new();
    if d.outside_band > 0 {
        left.push(format!("{} outside the band", d.outside_band));
    }
    if d.left_out > 0 {
        left.push(format!("{} far off left out", d.left_out));
    }
    let left = if left.is_empty() { String::new() } else { format!(" ({})", left.join(", ")) };
    let stops = match d.points_with_stops {
        0 => String::new(),
        n => format!("; {n} points with stops in the cycle"),
    };
    facts.add("fit", format!(
            "{method}, {drive}{level}; {} points{left}, {} within the line, over {:.1} line widths; noise {}, {:.0} dB below \
             the peak; residuals {:.2} times what noise gives{stops}",
            d.points,
            d.points_in_line,
            d.line_widths,
            plain(d.noise_rms, 2, &answer.unit),
            d.signal_to_noise_db,
            d.residual_excess.max(0.0).sqrt()
        ),
    );
    instrument(&mut facts, answer);
    if let Some(line) = &answer.force_line {
        let (x_f, delta) = (&line.friction_displacement, &line.decay_rate_per_s);
        facts.add(
            "forces",
            format!(
                "without a model, those of {} points give x_F = {}, δ = {} (chi square {:.2} a degree of freedom{})",
                line.points,
                Rounded::new(x_f.value, x_f.std_error, &x_f.unit),
                Rounded::new(delta.value, delta.std_error, &delta.unit),
                line.reduced_chi_square,
                if line.reduced_chi_square > NO_LINE { ": no straight line" } else { "" }
            ),
        );
    }
    paper(&mut facts, answer);
    facts
}

fn instrument(facts: &mut Facts, answer: &Answer) {
    let i = &answer.instrument;
    let mut said = Vec::new();
    if let Some(q) = &i.phase_offset_rad {
        said.push(format!("phase offset {}", Rounded::new(q.value, q.std_error, &q.unit)));
    }
    if let Some(q) = &i.delay_s {
        said.push(format!("delay {}", Rounded::new(q.value, q.std_error, &q.unit)));
    }
    if let Some([re, im]) = &i.background {
        let show = |q: &Quantity| Rounded::new(q.value, q.std_error, &q.unit).to_string();
        let delayed = if i.background_delayed { ", behind the same delay" } else { "" };
        said.push(format!("background {} and {} in quadrature{delayed}", show(re), show(im)));
    }
    if i.phase_was_conjugated {
        said.push("phases turned over".to_owned());
    }
    if !said.is_empty() {
        facts.add("besides", said.join(", "));
    }
}

fn paper(facts: &mut Facts, answer: &Answer) {
    let Some(p) = &answer.paper else { return };
    let mut text = format!("a Lorentzian of Q_f = {}", plain(p.effective_q_factor, 4, ""));
    if let (Some(q), Some(x_f)) = (p.q_factor, p.friction_displacement) {
        let _ = write!(
            text,
            ", inverted with a = 4/3: Q = {}, x_F = {}",
            plain(q, 4, ""),
            plain(x_f, 3, &answer.unit)
        );
        if let (Some(dq), Some(df)) = (p.q_factor_bias, p.friction_bias) {
            let _ = write!(
                text,
                "; on a curve like this it is off by {:+.0} % in Q, {:+.0} % in friction",
                100.0 * dq,
                100.0 * df
            );
        }
    }
    facts.add("paper", text);
}

/// What was read and how.
fn source(facts: &mut Facts, reading: &SweepReading) {
    facts.add("read", read_line(reading));
    for (what, taken) in &reading.report.taken {
        facts.add(what, column(taken));
    }
    facts.notes(&reading.report.notes);
}

/// What would be read of a file that is not analysed.
pub(super) fn read_as_curve(reading: &SweepReading) -> Facts {
    let mut facts = Facts::default();
    let curve = &reading.curve;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], v| [low.min(v), high.max(v)])
    };
    let [from, to] = range(&mut curve.frequency_hz().iter().copied());
    let [least, most] = range(&mut (0..curve.len()).map(|i| curve.response().amplitude(i)));
    let unit = curve.unit();
    facts.add(
        "curve",
        format!(
            "{} points between {} and {}, amplitudes from {} to {}, {}",
            curve.len(),
            plain(from, 6, "Hz"),
            plain(to, 6, "Hz"),
            plain(least, 3, unit),
            plain(most, 3, unit),
            if curve.is_complex() { "with phase" } else { "without phase" }
        ),
    );
    source(&mut facts, reading);
    facts
}

fn read_line(reading: &SweepReading) -> String {
    let report = &reading.report;
    let what = if report.runs.is_empty() { "row" } else { "record" };
    let mut text = format!("{}: {}", report.path, counted(report.rows_read, what));
    if !report.skipped.is_empty() {
        let reason = |s: &Skipped| format!("{} {}, first in row {}", s.rows, s.reason, s.first_row);
        let _ =
            write!(text, "; skipped {}", report.skipped.iter().map(reason).collect::<Vec<_>>().join("; "));
    }
    let runs = reading.curve.runs();
    if runs.len() > 1 || runs.iter().any(|r| r.direction != RunDirection::Up) {
        let count = |direction| runs.iter().filter(|r| r.direction == direction).count();
        let (up, down, mixed) =
            (count(RunDirection::Up), count(RunDirection::Down), count(RunDirection::Unordered));
        let mut parts = Vec::new();
        if up > 0 {
            parts.push(format!("{up} up"));
        }
        if down > 0 {
            parts.push(format!("{down} down"));
        }
        if mixed > 0 {
            parts.push("in no order".to_owned());
        }
        let _ = write!(text, "; swept {}", parts.join(", "));
    }
    if report.column_runs > 1 {
        let _ = write!(text, "; curve {} of {} (--run)", report.column_run, report.column_runs);
    }
    text
}

/// Evidence for sliding friction, for sentences of tables.
pub(super) fn p_words(p: f64) -> String {
    p_value(p)
}

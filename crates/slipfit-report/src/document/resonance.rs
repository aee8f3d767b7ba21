//! The report of a resonance curve.

use super::content::{Document, Input, file_name, warnings};
use super::facts::Facts;
use super::method;
use super::models::Comparison;
use super::parameter::ParameterRow;
use super::reading::{column, counted};
use crate::format::{Rounded, percent, plain, signed_percent, times};
use crate::{AnalysedCurve, Sentence, plot};
use slipfit::answer::hint::Spelling;
use slipfit::resonance::{Answer, DriveSource, Method, RunDirection};
use slipfit::{Parameter, Quantity};
use slipfit_io::SweepReading;
use std::fmt::Write as _;

/// Reduced chi square above which the forces do not lie on a straight line.
const MAX_LINE_CHI_SQUARE: f64 = 3.0;

pub(super) fn document<'a>(analysed: &'a AnalysedCurve<'a>, spell: Spelling<'_>) -> Document<'a> {
    let answer = analysed.answer;
    let models = Comparison {
        candidates: &answer.comparison,
        reported: answer.model,
        parameters: &answer.parameters,
        unit: &answer.unit,
        // The paper's inversion compares no models; the comparison is that of the exact curve.
        heading: if answer.method == Method::Paper { "exact model" } else { "model" },
    };
    let input = |r: &SweepReading| Input { path: r.report.path.clone(), sha256: r.report.sha256.clone() };
    Document {
        command: "resonance",
        title: None,
        subject: file_name(&analysed.reading.report.path),
        sentence: answer.sentence(),
        parameters: ParameterRow::list(&answer.parameters, Some(answer.model)),
        tables: vec![models.table(&[Parameter::DriveAmplitude])],
        facts: facts(analysed, spell),
        warnings: warnings(&answer.warnings, spell),
        method: method::of_resonance(answer),
        inputs: std::iter::once(analysed.reading).chain(analysed.reference).map(input).collect(),
        pictures: Box::new(|| plot::resonance_panels(analysed)),
    }
}

/// Where the answer comes from.
fn facts(analysed: &AnalysedCurve<'_>, spell: Spelling<'_>) -> Facts {
    let answer = analysed.answer;
    let mut facts = Facts::default();
    source(&mut facts, analysed.reading, spell);
    if let Some(reference) = analysed.reference {
        facts.add("against", read_line(reference, spell));
    }
    let method = match answer.method {
        Method::Exact => "exact fundamental",
        Method::Leading => "leading term, eq. (8)",
        Method::Paper => "effective Lorentzian of the paper, eq. (14)",
        _ => "another way",
    };
    let drive = match answer.drive_source {
        DriveSource::Known => "x₀ as given",
        DriveSource::Reference => "x₀ from the reference, at the same gain and drive",
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
        left.push(format!("{} far from the curve left out", d.left_out));
    }
    let left = if left.is_empty() { String::new() } else { format!(" ({})", left.join(", ")) };
    let growing = match d.proportional_noise {
        Some(part) => format!("; noise grows with the amplitude, {} of it", percent(part)),
        None => String::new(),
    };
    let stops = match d.points_with_stops {
        0 => String::new(),
        1 => "; 1 point with stops".to_owned(),
        n => format!("; {n} points with stops"),
    };
    facts.add(
        "fit",
        format!(
            "{method}, {drive}{level}; {} points{left} spanning {:.1} line widths, {} of them within the line \
             width; noise {}, {:.0} dB below the peak; residuals {} times the noise{growing}{stops}",
            d.points,
            d.line_widths,
            d.points_in_line,
            plain(d.noise_rms, 2, &answer.unit),
            d.signal_to_noise_db,
            times(d.residual_ratio())
        ),
    );
    facts.counted_losses(d.counted_losses, "curve");
    instrument(&mut facts, answer);
    if let Some(line) = &answer.force_line {
        let (x_f, delta) = (&line.friction_displacement, &line.decay_rate_per_s);
        facts.add(
            "forces",
            format!(
                "the balance of forces at {} points, without a model of the curve, gives x_F = {}, δ = {} (chi \
                 square {:.2} per degree of freedom{})",
                line.points,
                Rounded::new(x_f.value, x_f.std_error, &x_f.unit),
                Rounded::new(delta.value, delta.std_error, &delta.unit),
                line.reduced_chi_square,
                if line.reduced_chi_square > MAX_LINE_CHI_SQUARE { ": not a straight line" } else { "" }
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
        let delayed = if i.background_delayed { ", delayed as well" } else { "" };
        said.push(format!("background {} and {} in quadrature{delayed}", show(re), show(im)));
    }
    if let Some(q) = &i.amplitude_offset {
        said.push(format!(
            "constant {} in every amplitude",
            Rounded::new(q.value, q.std_error, &answer.unit)
        ));
    }
    if let Some(q) = &i.noise_floor {
        said.push(format!(
            "noise floor {} in every amplitude",
            Rounded::new(q.value, q.std_error, &answer.unit)
        ));
    }
    if i.phase_was_conjugated {
        said.push("phases conjugated".to_owned());
    }
    if !said.is_empty() {
        facts.add("fitted", said.join(", "));
    }
}

fn paper(facts: &mut Facts, answer: &Answer) {
    let Some(p) = &answer.paper else { return };
    let mut text = format!("fitted by a Lorentzian of Q_f = {}", plain(p.effective_q_factor, 4, ""));
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
                "; on a curve like this it is biased by {} in Q and {} in friction",
                signed_percent(dq),
                signed_percent(df)
            );
        }
    }
    facts.add("paper", text);
}

/// What was read, and how.
fn source(facts: &mut Facts, reading: &SweepReading, spell: Spelling<'_>) {
    facts.add("read", read_line(reading, spell));
    for (what, taken) in &reading.report.taken {
        facts.add(what, column(taken));
    }
    facts.notes(&reading.report.notes, spell);
}

/// How a file that is not analysed would be read.
pub(crate) fn curve(reading: &SweepReading, spell: Spelling<'_>) -> Facts {
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
    source(&mut facts, reading, spell);
    facts
}

fn read_line(reading: &SweepReading, spell: Spelling<'_>) -> String {
    let report = &reading.report;
    let what = if report.records.is_empty() { "row" } else { "record" };
    let mut text = format!("{}: {}", report.path, counted(report.rows_read, what));
    if !report.skipped.is_empty() {
        let reasons: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
        let _ = write!(text, "; skipped {}", reasons.join("; "));
    }
    let runs = reading.curve.runs();
    if runs.len() > 1 || runs.iter().any(|r| r.direction != RunDirection::Up) {
        let count = |direction| runs.iter().filter(|r| r.direction == direction).count();
        let (up, down, mixed) =
            (count(RunDirection::Up), count(RunDirection::Down), count(RunDirection::Unordered));
        let mut parts = Vec::new();
        for (sweeps, direction) in [(up, "up"), (down, "down")].into_iter().filter(|(sweeps, _)| *sweeps > 0)
        {
            let number = if parts.is_empty() { counted(sweeps as u64, "sweep") } else { sweeps.to_string() };
            parts.push(format!("{number} {direction}"));
        }
        if mixed > 0 {
            parts.push(if parts.is_empty() { "in no order" } else { "the rest unordered" }.to_owned());
        }
        let _ = write!(text, "; {}", parts.join(", "));
    }
    if report.runs > 1 {
        let _ = write!(text, "; curve {} of {} ({})", report.run, report.runs, spell("run", None));
    }
    text
}

//! The answer to a ring-down on one screen.

use super::table::{Align, columns};
use super::{ANSWER, CHOSEN, DIM, HEADING, WIDTH, labelled, wrap};
use crate::command::ringdown::Analysed;
use slipfit::format::{Rounded, Scale, percent, plain};
use slipfit::ringdown::{Answer, Candidate, Parameter};
use slipfit::{ClockReport, Quantity, SignalKind};
use slipfit_io::{ColumnTaken, ReadReport, TimeSource};
use std::fmt::Write as _;
use std::path::Path;

/// An interval this much longer on one side than on the other is printed.
const ASYMMETRY: f64 = 1.15;

/// The whole report, styled.
pub(crate) fn ringdown(analysed: &Analysed<'_>, written: &[&Path]) -> String {
    let answer = analysed.answer;
    let mut text = String::new();
    for line in wrap(&answer.sentence(), WIDTH) {
        let _ = writeln!(text, "{ANSWER}{line}{ANSWER:#}");
    }
    text.push('\n');
    text += &parameters(answer);
    text.push('\n');
    text += &models(answer);
    text.push('\n');
    text += &account(analysed);
    if !written.is_empty() {
        let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        text += &labelled("wrote", &names.join(", "));
    }
    text
}

/// Words and symbol of a parameter.
pub(crate) fn label(name: &str) -> (String, &'static str) {
    let (words, symbol) = match name {
        "frequency_hz" => ("frequency", "f"),
        "decay_rate_per_s" => ("decay rate", "δ"),
        "decay_time_s" => ("decay time", "τ"),
        "friction_displacement" => ("friction displacement", "x_F"),
        "drag_rate" => ("drag rate", "a₂"),
        "q_factor" => ("quality factor, viscous", "Q"),
        "initial_amplitude" => ("initial amplitude", "A₀"),
        "viscous_coefficient" => ("viscous coefficient", "γ"),
        "coulomb_force" => ("sliding friction force", "F"),
        "static_force" => ("static friction force", "F_s"),
        other => return (other.replace('_', " "), ""),
    };
    (words.to_owned(), symbol)
}

fn parameters(answer: &Answer) -> String {
    let rows: Vec<Vec<String>> = answer.parameters.iter().map(parameter_row).collect();
    let align =
        [Align::Left, Align::Left, Align::Right, Align::Left, Align::Left, Align::Left, Align::Right, Align::Left];
    columns(&rows, &align).iter().map(|line| format!("  {line}\n")).collect()
}

fn parameter_row(parameter: &Parameter) -> Vec<String> {
    let (words, symbol) = label(parameter.name);
    let q = &parameter.quantity;
    let shown = Rounded::new(q.value, q.std_error, &q.unit);
    let (sign, uncertainty) = match shown.uncertainty() {
        Some(u) => ("±".to_owned(), u),
        None => (String::new(), String::new()),
    };
    vec![
        words,
        symbol.to_owned(),
        shown.value(),
        sign,
        uncertainty,
        shown.scale.unit.clone(),
        relative(q),
        interval(q, &shown),
    ]
}

fn relative(q: &Quantity) -> String {
    let share = q.std_error / q.value.abs();
    if !share.is_finite() || share <= 0.0 || share >= 10.0 {
        return String::new();
    }
    match share * 100.0 {
        p if p < 0.001 => "<0.001 %".to_owned(),
        p => format!("{} %", plain(p, 2, "")),
    }
}

/// The 95 % interval, where `±` alone would mislead.
fn interval(q: &Quantity, shown: &Rounded) -> String {
    let [low, high] = q.interval_95;
    let (below, above) = (q.value - low, high - q.value);
    let lopsided = below.max(above) > ASYMMETRY * below.min(above);
    if !lopsided || !(low.is_finite() || high.is_finite()) {
        return String::new();
    }
    format!("95 %: {} to {}", shown.also(low), shown.also(high))
}

fn models(answer: &Answer) -> String {
    let has_drag = answer.comparison.iter().any(|c| c.drag_rate > 0.0);
    let unit = &answer.signal_unit;
    let rms_scale = Scale::for_size(answer.comparison.first().map_or(0.0, |c| c.rms), unit);
    let largest = |of: fn(&Candidate) -> f64| answer.comparison.iter().map(of).fold(0.0, f64::max);
    let x_scale = Scale::for_size(largest(|c| c.friction_displacement), unit);
    let delta_scale = Scale::for_size(largest(|c| c.decay_rate_per_s), "1/s");
    let drag_unit = answer.parameter("drag_rate").map_or_else(|| format!("1/(s {unit})"), |q| q.unit.clone());
    let drag_scale = Scale::for_size(largest(|c| c.drag_rate), &drag_unit);
    let headed = |name: &str, scale: &Scale| format!("{name} [{}]", scale.unit.trim_start_matches('×'));

    let mut heading = vec![
        "model".to_owned(),
        "ΔBIC".to_owned(),
        headed("rms", &rms_scale),
        headed("δ", &delta_scale),
        headed("x_F", &x_scale),
    ];
    heading.push(if has_drag { headed("a₂", &drag_scale) } else { String::new() });
    heading.push(String::new());
    let mut rows = vec![heading];
    for c in &answer.comparison {
        let part = |present: bool, value: f64, scale: &Scale| match present {
            true => significant(value * scale.factor, 3),
            false => "-".to_owned(),
        };
        rows.push(vec![
            c.model.to_string(),
            bic(c.delta_bic),
            significant(c.rms * rms_scale.factor, 3),
            part(c.model.has_viscous(), c.decay_rate_per_s, &delta_scale),
            part(c.model.has_sliding(), c.friction_displacement, &x_scale),
            if has_drag { part(c.model.has_drag(), c.drag_rate, &drag_scale) } else { String::new() },
            remark(c),
        ]);
    }
    let align =
        [Align::Left, Align::Right, Align::Right, Align::Right, Align::Right, Align::Right, Align::Left];
    let lines = columns(&rows, &align);
    let styled = lines.iter().enumerate().map(|(i, line)| {
        let chosen = i.checked_sub(1).is_some_and(|i| answer.comparison[i].model == answer.model);
        match (i, chosen) {
            (0, _) => format!("  {HEADING}{line}{HEADING:#}\n"),
            (_, true) => format!("{CHOSEN}> {line}{CHOSEN:#}\n"),
            _ => format!("  {DIM}{line}{DIM:#}\n"),
        }
    });
    styled.collect()
}

fn remark(candidate: &Candidate) -> String {
    match (candidate.converged, candidate.at_limit) {
        (false, _) => "did not converge".to_owned(),
        (true, Some(term)) => format!("{} at zero", label(term).0),
        (true, None) => String::new(),
    }
}

fn bic(delta: f64) -> String {
    if delta < 100.0 { format!("{delta:.1}") } else { format!("{delta:.0}") }
}

fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "?".to_owned() };
    }
    let decade = value.abs().log10().floor() as i64;
    if !(-5..7).contains(&decade) {
        return format!("{value:.*e}", digits - 1);
    }
    format!("{value:.*}", (digits as i64 - 1 - decade).max(0) as usize)
}

/// What was read, what was used, how well it is described.
fn account(analysed: &Analysed<'_>) -> String {
    let report = &analysed.reading.report;
    let answer = analysed.answer;
    let mut text = labelled("read", &rows_read(analysed));
    text += &labelled("time", &time_source(&report.time));
    text += &labelled("signal", &signal_source(report));
    if let Some(q) = &report.quadrature {
        text += &labelled("", &column(q));
    }
    if let Some(clock) = clock(analysed.reading.record.clock_report()) {
        text += &labelled("clock", &clock);
    }
    for note in &report.notes {
        text += &labelled("note", note);
    }
    let s = &answer.segment;
    let cycles = if s.cycles > 0.0 { format!(", {} cycles", plain(s.cycles, 3, "")) } else { String::new() };
    text += &labelled(
        "used",
        &format!(
            "{} to {}{cycles}, {} samples: starts where {}, ends where {}",
            plain(s.start_s, 4, "s"),
            plain(s.end_s, 4, "s"),
            s.samples,
            s.start_reason,
            s.end_reason
        ),
    );
    if let Some(stop) = &answer.stop {
        let position = Rounded::new(stop.position, stop.position_std_error, &answer.signal_unit);
        let hold = stop.static_displacement.map_or_else(String::new, |[low, high]| {
            let unit = &answer.signal_unit;
            format!("; static friction holds between {} and {}", plain(low, 3, unit), plain(high, 3, unit))
        });
        text += &labelled("stop", &format!("at {}, {position} off the middle{hold}", plain(stop.time_s, 4, "s")));
    }
    let d = &answer.diagnostics;
    text += &labelled(
        "fit",
        &format!(
            "{}; noise {}, {:.0} dB below the start; residual {} ({} times the noise); {} decay times",
            d.method,
            plain(d.noise_rms, 2, &answer.signal_unit),
            d.signal_to_noise_db,
            plain(d.residual_rms, 2, &answer.signal_unit),
            plain(d.residual_excess.max(0.0).sqrt(), 2, ""),
            plain(d.decay_times, 2, "")
        ),
    );
    text
}

fn rows_read(analysed: &Analysed<'_>) -> String {
    let report = &analysed.reading.report;
    let mut text = format!("{}: {} rows", analysed.file.display(), report.rows_read);
    if !report.skipped.is_empty() {
        let reasons: Vec<String> =
            report.skipped.iter().map(|s| format!("{} {}, first in row {}", s.rows, s.reason, s.first_row)).collect();
        let _ = write!(text, "; skipped {}", reasons.join("; "));
    }
    let mut choice = Vec::new();
    if report.tables > 1 {
        choice.push(format!("table {} of {} (--table)", report.table, report.tables));
    }
    if report.runs > 1 {
        choice.push(format!("run {} of {} (--run)", report.run, report.runs));
    }
    if !choice.is_empty() {
        let _ = write!(text, "; {}", choice.join(", "));
    }
    text
}

fn column(taken: &ColumnTaken) -> String {
    if taken.unit.is_empty() { taken.why.clone() } else { format!("{}; in {}", taken.why, taken.unit) }
}

fn time_source(source: &TimeSource) -> String {
    match source {
        TimeSource::Column(taken) => column(taken),
        TimeSource::Intervals(taken) => format!("{}, added up", column(taken)),
        TimeSource::Rate(rate) => format!("{} samples a second", plain(*rate, 6, "")),
        _ => "as the file says".to_owned(),
    }
}

fn signal_source(report: &ReadReport) -> String {
    let kind = match report.kind {
        SignalKind::Displacement => "displacement or angle",
        SignalKind::Velocity => "velocity",
        SignalKind::Acceleration => "acceleration",
        SignalKind::Envelope => "amplitude",
        SignalKind::LockIn => "X of a lock-in",
        _ => "signal",
    };
    format!("{}; taken as {kind}", column(&report.signal))
}

/// What there is to say about the clock, if anything.
fn clock(report: &ClockReport) -> Option<String> {
    let mut said = Vec::new();
    let mut count = |n: usize, what: &str| {
        if n > 0 {
            said.push(format!("{n} {what}"));
        }
    };
    count(report.nonfinite(), "rows without a number left out");
    count(report.corrupt_stamps, "rows with a corrupt stamp left out");
    count(report.reordered, "rows put in order");
    count(report.repeated_stamps, "repeated stamps");
    if report.resets > 0 {
        said.push(format!("{} resets: {} rows of other runs left out", report.resets, report.other_run_rows));
    }
    if let Some(quantum) = report.rebuilt_quantum_s {
        said.push(format!("uniform clock rebuilt from stamps rounded to {}", plain(quantum, 2, "s")));
    }
    if let Some(gap) = &report.longest_gap {
        said.push(format!(
            "{} gaps, the longest {} from {} on",
            report.gaps,
            plain(gap.length_s, 3, "s"),
            plain(gap.start_s, 4, "s")
        ));
    }
    if report.step_spread > 0.02 {
        said.push(format!("steps vary by {}", percent(report.step_spread)));
    }
    (!said.is_empty()).then(|| said.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_table_keep_three_digits() {
        assert_eq!(significant(0.031_234, 3), "0.0312");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(1e-9, 3), "1.00e-9");
        assert_eq!(significant(f64::NAN, 3), "?");
    }

    #[test]
    fn an_interval_is_shown_where_it_is_lopsided() {
        let mut q = Quantity::normal(1e-4, 1e-4, "rad");
        assert_eq!(interval(&q, &Rounded::new(q.value, q.std_error, &q.unit)), "");
        q.interval_95 = [0.0, 3.1e-4];
        assert_eq!(interval(&q, &Rounded::new(q.value, q.std_error, &q.unit)), "95 %: 0 to 310");
    }

    #[test]
    fn relative_uncertainties_are_left_out_where_they_say_nothing() {
        assert_eq!(relative(&Quantity::normal(2.0, 0.1, "")), "5 %");
        assert_eq!(relative(&Quantity::normal(0.0, 0.1, "")), "");
        assert_eq!(relative(&Quantity::normal(1.0, 1e-7, "")), "<0.001 %");
    }

    #[test]
    fn an_ordinary_clock_needs_no_words() {
        assert_eq!(clock(&ClockReport::default()), None);
    }
}

//! The answer to drive levels on one screen.

use super::account::column;
use super::resonance::{p_words, quantity_row};
use super::ringdown::label;
use super::table::{Align, columns};
use super::{ANSWER, WIDTH, labelled, wrap};
use crate::command::levels::AnalysedLevels;
use slipfit::format::{Rounded, plain};
use slipfit::levels::Answer;
use std::fmt::Write as _;
use std::path::Path;

/// The answer in a sentence.
pub(crate) fn levels_sentence(answer: &Answer) -> String {
    let Some(threshold) = answer.parameter("threshold") else {
        return "The levels give no threshold.".to_owned();
    };
    let shown = Rounded::new(threshold.value, threshold.std_error, &threshold.unit);
    if !answer.detected {
        let high = plain(threshold.interval_95[1], 2, &threshold.unit);
        return format!(
            "No threshold is seen ({}): sliding friction holds the mass below a drive of {high} at most.",
            p_words(answer.p_value)
        );
    }
    let friction = answer.parameter("friction_displacement").map_or_else(String::new, |q| {
        format!(", a friction displacement of {}", Rounded::new(q.value, q.std_error, &q.unit))
    });
    format!(
        "Sliding friction holds the mass up to a drive of {shown}{friction}; a line through zero is excluded, {}.",
        p_words(answer.p_value)
    )
}

/// The whole report, styled.
pub(crate) fn levels(analysed: &AnalysedLevels<'_>, written: &[&Path]) -> String {
    let (answer, reading) = (analysed.answer, analysed.reading);
    let mut text = String::new();
    for line in wrap(&levels_sentence(answer), WIDTH) {
        let _ = writeln!(text, "{ANSWER}{line}{ANSWER:#}");
    }
    text.push('\n');
    let rows: Vec<Vec<String>> = answer
        .parameters
        .iter()
        .filter(|p| p.quantity.value.is_finite())
        .map(|p| {
            let (words, symbol) = label(p.name);
            quantity_row(words, symbol, &p.quantity)
        })
        .collect();
    let left = Align::Left;
    let lines = columns(&rows, &[left, left, Align::Right, left, left, left]);
    lines.iter().for_each(|line| text += &format!("  {line}\n"));
    text.push('\n');
    let skipped = match reading.rows_skipped() {
        0 => String::new(),
        n => {
            let reasons: Vec<String> = reading.skipped.iter().map(|s| s.reason.clone()).collect();
            format!("; {n} skipped: {}", reasons.join(", "))
        }
    };
    text += &labelled("read", &format!("{}: {} rows{skipped}", reading.path, reading.rows_read));
    for (what, taken) in &reading.taken {
        let what = if *what == "amplitude" { "ampl" } else { what };
        text += &labelled(if what == "std_error" { "error" } else { what }, &column(taken));
    }
    for note in &reading.notes {
        text += &labelled("note", note);
    }
    let d = &answer.diagnostics;
    text += &labelled(
        "fit",
        &format!(
            "{} points, {} moving, {} stuck; residuals {}; a bend of the line: {}",
            d.points,
            d.moving,
            d.stuck,
            plain(d.residual_rms, 2, &answer.unit),
            p_words(d.bend_p_value)
        ),
    );
    if let Some(b) = &answer.breakaway {
        let drive = |v: f64| plain(v, 3, &answer.drive_unit);
        let stuck = b.stuck_below.map_or_else(String::new, |v| format!("stuck up to {}, ", drive(v)));
        let above = b.stuck_above_threshold.map_or_else(String::new, |v| {
            format!("; stuck at {}, above the threshold, while the levels rose", drive(v))
        });
        text += &labelled("moves", &format!("{stuck}moving from {} on{above}", drive(b.moving_from)));
    }
    if !written.is_empty() {
        let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
        text += &labelled("wrote", &names.join(", "));
    }
    text
}

//! The report of drive levels.

use super::content::{Document, Input, file_name, warnings};
use super::facts::Facts;
use super::method;
use super::parameter::ParameterRow;
use super::reading::column;
use crate::format::{p_value, plain};
use crate::{AnalysedLevels, Sentence, plot};
use slipfit::answer::hint::Spelling;

pub(super) fn document<'a>(analysed: &'a AnalysedLevels<'a>, spell: Spelling<'_>) -> Document<'a> {
    let (answer, reading) = (analysed.answer, &analysed.reading.report);
    Document {
        command: "levels",
        title: None,
        subject: file_name(&reading.path),
        sentence: answer.sentence(),
        parameters: ParameterRow::list(&answer.parameters, None),
        tables: Vec::new(),
        facts: facts(analysed, spell),
        warnings: warnings(&answer.warnings, spell),
        method: method::of_levels(answer),
        inputs: vec![Input { path: reading.path.clone(), sha256: reading.sha256.clone() }],
        pictures: Box::new(|| plot::levels_panels(analysed)),
    }
}

/// Where the answer comes from.
fn facts(analysed: &AnalysedLevels<'_>, spell: Spelling<'_>) -> Facts {
    let (answer, reading) = (analysed.answer, &analysed.reading.report);
    let mut facts = Facts::default();
    let skipped = match reading.rows_skipped() {
        0 => String::new(),
        n => {
            let reasons: Vec<String> = reading.skipped.iter().map(|s| s.reason.clone()).collect();
            format!("; {n} skipped: {}", reasons.join(", "))
        }
    };
    facts.add("read", format!("{}: {} rows{skipped}", reading.path, reading.rows_read));
    for (what, taken) in &reading.taken {
        facts.add(what, column(taken));
    }
    facts.notes(&reading.notes, spell);
    let d = &answer.diagnostics;
    let undecided = match d.undecided {
        0 => String::new(),
        n => format!(", {n} that may be either"),
    };
    facts.add(
        "fit",
        format!(
            "{} points, {} moving, {} stuck{undecided}; residuals {}; a bend of the line: {}",
            d.points,
            d.moving,
            d.stuck,
            plain(d.residual_rms, 2, &answer.unit),
            p_value(d.bend_p_value)
        ),
    );
    if let Some(b) = &answer.breakaway {
        let drive = |v: f64| plain(v, 3, &answer.drive_unit);
        let stuck = b.stuck_below.map_or_else(String::new, |v| format!("stuck up to {}, ", drive(v)));
        let above = b.stuck_above_threshold.map_or_else(String::new, |v| {
            let ratio = b.static_ratio_at_least.map_or_else(String::new, |r| {
                format!(": static friction is at least {r:.2} times the sliding one")
            });
            format!("; stuck at {}, above the threshold{ratio}", drive(v))
        });
        facts.add("moves", format!("{stuck}moving from {} on{above}", drive(b.moving_from)));
    }
    facts
}

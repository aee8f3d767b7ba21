//! The answer to drive levels on one screen.

use super::account::column;
use super::facts::Facts;
use super::parameters::{Told, laid_out};
use super::resonance::p_words;
use super::{ANSWER, WIDTH, labelled, wrap};
use crate::AnalysedLevels;
use crate::Sentence;
use crate::format::plain;
use slipfit::levels::Answer;
use std::fmt::Write as _;
use std::path::Path;

/// The whole report, styled.
pub fn levels(analysed: &AnalysedLevels<'_>, written: &[&Path]) -> String {
    let answer = analysed.answer;
    let mut text = String::new();
    for line in wrap(&answer.sentence(), WIDTH) {
        let _ = writeln!(text, "{ANSWER}{line}{ANSWER:#}");
    }
    text.push('\n');
    text += &laid_out(&told(answer));
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
    let finite = answer.parameters.iter().filter(|(_, q)| q.value.is_finite());
    finite.map(|(p, q)| Told::new(p, q)).collect()
}

/// Where the answer comes from.
pub(crate) fn account(analysed: &AnalysedLevels<'_>) -> Facts {
    let (answer, reading) = (analysed.answer, analysed.reading);
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
    facts.notes(&reading.notes);
    let d = &answer.diagnostics;
    facts.add(
        "fit",
        format!(
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
            let ratio = b.static_ratio_at_least.map_or_else(String::new, |r| {
                format!(": static friction is at least {r:.2} times the sliding one")
            });
            format!("; stuck at {}, above the threshold{ratio}", drive(v))
        });
        facts.add("moves", format!("{stuck}moving from {} on{above}", drive(b.moving_from)));
    }
    facts
}

//! Reports for a terminal of 80 columns, styled by ANSI escapes.

mod braille;
mod inspect;
mod parameters;
mod style;
mod table;

pub use inspect::{Inspected, inspect};
pub(crate) use style::{ANSWER, CHOSEN, DIM, HEADING, WIDTH};

use crate::document::{Document, DocumentWarning, Facts};
use crate::escape;
use crate::text::wrap;
use anstyle::Style;

/// The whole report. `written` names the files written in addition.
pub fn screen(document: &Document<'_>, written: &[String]) -> String {
    let mut text = String::new();
    if let Some(title) = &document.title {
        text += &format!("{HEADING}{}{HEADING:#}\n", escape::terminal(title));
    }
    for line in wrap(&escape::terminal(&document.sentence), WIDTH) {
        text += &format!("{ANSWER}{line}{ANSWER:#}\n");
    }
    text.push('\n');
    if !document.parameters.is_empty() {
        text += &parameters::laid_out(&document.parameters);
        text.push('\n');
    }
    for table in &document.tables {
        text += &table::styled(table);
        text.push('\n');
    }
    text += &labelled_facts(&document.facts);
    if !written.is_empty() {
        text += &labelled("wrote", &written.join(", "));
    }
    text
}

fn labelled_facts(facts: &Facts) -> String {
    facts.iter().map(|(label, text)| labelled(short(label), text)).collect()
}

/// Labels shortened to fit their column.
fn short(label: &str) -> &str {
    match label {
        "frequency" => "freq",
        "amplitude" => "ampl",
        "imaginary" => "imag",
        "std_error" => "error",
        "conductance" => "conduct",
        "susceptance" => "suscept",
        "resistance" => "resist",
        "reactance" => "react",
        "impedance" => "imped",
        "admittance" => "admit",
        "response" => "signal",
        other => other,
    }
}

/// `label   text`, wrapped with a hanging indent.
pub(crate) fn labelled(label: &str, text: &str) -> String {
    const INDENT: usize = 10;
    wrap(&escape::terminal(text), WIDTH - INDENT)
        .iter()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("  {HEADING}{label:<8}{HEADING:#}{line}\n"),
            _ => format!("{:INDENT$}{line}\n", ""),
        })
        .collect()
}

/// `label text`, wrapped with a hanging indent after the label; line breaks in `text`, such as those of a quoted
/// piece of a file, are kept.
pub fn hanging(label: &str, style: Style, text: &str) -> String {
    let text = &escape::terminal(text);
    let indent = label.chars().count() + 1;
    let lines: Vec<String> = match text.lines().count() {
        0 => vec![String::new()],
        1 if indent + text.chars().count() > WIDTH => wrap(text, WIDTH - indent),
        _ => text.lines().map(str::to_owned).collect(),
    };
    let word = label.trim_start();
    let margin = &label[..label.len() - word.len()];
    let first = format!("{margin}{style}{word}{style:#} {}\n", lines[0]);
    lines[1..].iter().fold(first, |text, line| text + &format!("{:indent$}{line}\n", ""))
}

/// A warning of an answer, followed by its code in brackets; `docs/warnings.md` explains the codes.
pub fn warning(warning: &DocumentWarning, style: Style) -> String {
    hanging("warning:", style, &format!("{} [{}]", warning.text, warning.code))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::by_hand;
    use anstream::adapter::strip_str;
    use slipfit::LossModel;
    use slipfit::ringdown::Answer;

    fn report(change: impl FnOnce(&mut Answer), written: &[String]) -> String {
        by_hand(change, |analysed| {
            strip_str(&screen(&Document::ringdown(analysed, &crate::example::spell), written)).to_string()
        })
    }

    #[test]
    fn a_term_the_model_lacks_shows_its_limit() {
        let text = report(|answer| answer.model = LossModel::VISCOUS, &[]);
        let line = text.lines().find(|l| l.starts_with("  friction displacement")).unwrap();
        for part in ["< 2.1", " mrad ", "95 %, not in model"] {
            assert!(line.contains(part), "{part} in {line}");
        }
    }

    #[test]
    fn a_fit_that_did_not_settle_is_marked() {
        let text = report(|answer| answer.comparison[2].converged = false, &[]);
        assert!(text.contains("viscous * "), "{text}");
        assert!(text.contains("* the fit did not converge"), "{text}");
    }

    /// All numbers are set by hand, so that only the layout is tested.
    #[test]
    fn a_report_reads_like_this() {
        insta::assert_snapshot!(report(|_| (), &["swing.svg".to_owned()]));
    }

    #[test]
    fn labels_fit_their_column_on_the_screen() {
        let mut facts = Facts::default();
        facts.add("conductance", "column 3");
        facts.add("", "and its unit");
        let text = strip_str(&labelled_facts(&facts)).to_string();
        assert_eq!(text, "  conduct column 3\n          and its unit\n");
    }

    #[test]
    fn a_message_hangs_behind_its_label() {
        let long = "one two three ".repeat(9);
        let text = anstream::adapter::strip_str(&hanging("  hint:", HEADING, &long)).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() == 2, "{text}");
        assert!(lines.iter().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert!(lines[0].starts_with("  hint: one two"), "{text}");
        assert!(lines[1].starts_with("        one"), "{text}");
        let quoted = hanging("error:", Style::new(), "line 3\n  | a = \n  |   ^");
        assert_eq!(quoted, "error: line 3\n         | a = \n         |   ^\n");
    }
}

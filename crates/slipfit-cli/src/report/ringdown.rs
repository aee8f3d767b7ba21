//! The answer to a ring-down on one screen.

use super::account::account;
use super::table::{Align, columns};
use super::{ANSWER, CHOSEN, DIM, HEADING, WIDTH, labelled, wrap};
use crate::command::ringdown::Analysed;
use slipfit::Quantity;
use slipfit::format::{Rounded, Scale, plain};
use slipfit::ringdown::{Answer, Candidate, Parameter};
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
        "natural_frequency_hz" => ("natural frequency", "f₀"),
        "drive_amplitude" => ("drive amplitude", "x₀"),
        "friction_ratio" => ("friction ratio", "β"),
        "slope" => ("slope", "R/x₀"),
        "threshold" => ("threshold of the drive", "x_T"),
        "decay_rate_per_s" => ("decay rate", "δ"),
        "decay_time_s" => ("decay time", "τ"),
        "friction_displacement" => ("friction displacement", "x_F"),
        "sliding_rate" => ("sliding rate", "a₀"),
        "drag_rate" => ("drag rate", "a₂"),
        "q_factor" => ("viscous quality factor", "Q"),
        "initial_amplitude" => ("initial amplitude", "A₀"),
        "viscous_coefficient" => ("viscous coefficient", "γ"),
        "coulomb_force" => ("sliding friction force", "F"),
        "static_force" => ("static friction force", "F_s"),
        other => return (other.replace('_', " "), ""),
    };
    (words.to_owned(), symbol)
}

fn parameters(answer: &Answer) -> String {
    let rows: Vec<Vec<String>> =
        answer.parameters.iter().filter(|p| is_told(answer, p)).map(|p| parameter_row(answer, p)).collect();
    let left = Align::Left;
    let align = [left, left, Align::Right, left, left, left];
    columns(&rows, &align).iter().map(|line| format!("  {line}\n")).collect()
}

/// Whether a parameter says something the others do not; JSON has them all.
fn is_told(answer: &Answer, parameter: &Parameter) -> bool {
    match parameter.name {
        "sliding_rate" => answer.parameter("friction_displacement").is_none(),
        "drag_rate" => answer.model.has_drag(),
        _ => parameter.quantity.value.is_finite(),
    }
}

fn parameter_row(answer: &Answer, parameter: &Parameter) -> Vec<String> {
    let (words, symbol) = label(parameter.name);
    let q = &parameter.quantity;
    if is_absent(answer, parameter.name) {
        return absent_row(words, symbol, q);
    }
    let shown = Rounded::new(q.value, q.std_error, &q.unit);
    vec![
        words,
        symbol.to_owned(),
        shown.value(),
        shown.uncertainty().map_or_else(String::new, |u| format!("± {u}")),
        shown.scale.unit.clone(),
        format!("{:>8}  {}", relative(q), interval(q, &shown)).trim_end().to_owned(),
    ]
}

/// Whether the model reported has no such term.
fn is_absent(answer: &Answer, name: &str) -> bool {
    match name {
        "friction_displacement" | "sliding_rate" | "coulomb_force" => !answer.model.has_sliding(),
        "decay_rate_per_s" | "viscous_coefficient" => !answer.model.has_viscous(),
        "drag_rate" => !answer.model.has_drag(),
        _ => false,
    }
}

/// A term the model does not have: how large it could be.
pub(super) fn absent_row(words: String, symbol: &str, q: &Quantity) -> Vec<String> {
    let high = q.interval_95[1];
    let (value, unit, note) = if high.is_finite() && high > 0.0 {
        let scale = Scale::for_size(high, &q.unit);
        (format!("< {}", significant(high * scale.factor, 2)), scale.unit, "95 %, not in model")
    } else {
        ("-".to_owned(), String::new(), "not in model")
    };
    vec![words, symbol.to_owned(), value, String::new(), unit, note.to_owned()]
}

pub(super) fn relative(q: &Quantity) -> String {
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
pub(super) fn interval(q: &Quantity, shown: &Rounded) -> String {
    let [low, high] = q.interval_95;
    let (below, above) = (q.value - low, high - q.value);
    let lopsided = below.max(above) > ASYMMETRY * below.min(above);
    if !lopsided || !(low.is_finite() || high.is_finite()) {
        return String::new();
    }
    format!("95 %: {} to {}", shown.also(low), shown.also(high))
}

fn models(answer: &Answer) -> String {
    let unit = &answer.signal_unit;
    let drag_unit = answer.parameter("drag_rate").map_or_else(|| format!("1/({unit} s)"), |q| q.unit.clone());
    let terms: [Term; 3] = [
        Term::new(answer, "decay_rate_per_s", "1/s", |c| c.model.has_viscous().then_some(c.decay_rate_per_s)),
        Term::new(answer, "friction_displacement", unit, |c| {
            c.model.has_sliding().then_some(c.friction_displacement)
        }),
        Term::new(answer, "drag_rate", &drag_unit, |c| c.model.has_drag().then_some(c.drag_rate)),
    ];
    let rms = Scale::for_size(answer.comparison.first().map_or(0.0, |c| c.rms), unit);
    let mut rows = vec![vec!["model".to_owned(), "ΔBIC".to_owned(), headed("rms", &rms)]];
    rows[0].extend(terms.iter().map(Term::heading));
    for c in &answer.comparison {
        let settled = if c.converged { "" } else { " *" };
        let mut row =
            vec![format!("{}{settled}", c.model), bic(c.delta_bic), significant(c.rms * rms.factor, 3)];
        row.extend(terms.iter().map(|t| t.cell(c)));
        rows.push(row);
    }
    let right = Align::Right;
    let lines = columns(&rows, &[Align::Left, right, right, right, right, right]);
    let styled = lines.iter().enumerate().map(|(i, line)| {
        let chosen = i.checked_sub(1).is_some_and(|i| answer.comparison[i].model == answer.model);
        match (i, chosen) {
            (0, _) => format!("  {HEADING}{line}{HEADING:#}\n"),
            (_, true) => format!("{CHOSEN}> {line}{CHOSEN:#}\n"),
            _ => format!("  {DIM}{line}{DIM:#}\n"),
        }
    });
    let mut text: String = styled.collect();
    if answer.comparison.iter().any(|c| !c.converged) {
        text += &format!("  {DIM}* the fit did not settle to its tolerance{DIM:#}\n");
    }
    text
}

pub(super) fn headed(name: &str, scale: &Scale) -> String {
    let unit = scale.unit.trim_start_matches('×');
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// One loss term across the models.
struct Term {
    name: &'static str,
    value: fn(&Candidate) -> Option<f64>,
    scale: Scale,
    /// Whether any model has it and the record can tell it.
    shown: bool,
}

impl Term {
    fn new(answer: &Answer, name: &'static str, unit: &str, value: fn(&Candidate) -> Option<f64>) -> Self {
        let largest = answer.comparison.iter().filter_map(value).fold(0.0, f64::max);
        let shown = largest > 0.0 && answer.parameter(name).is_some();
        Self { name, value, scale: Scale::for_size(largest, unit), shown }
    }

    fn heading(&self) -> String {
        if self.shown { headed(label(self.name).1, &self.scale) } else { String::new() }
    }

    fn cell(&self, candidate: &Candidate) -> String {
        match (self.value)(candidate) {
            _ if !self.shown => String::new(),
            None => "-".to_owned(),
            Some(_) if candidate.at_limit == Some(self.name) => "at 0".to_owned(),
            Some(value) => significant(value * self.scale.factor, 3),
        }
    }
}

pub(super) fn bic(delta: f64) -> String {
    if delta < 100.0 { format!("{delta:.1}") } else { format!("{delta:.0}") }
}

pub(super) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "?".to_owned() };
    }
    let decade = value.abs().log10().floor() as i64;
    if !(-5..7).contains(&decade) {
        return format!("{value:.*e}", digits - 1);
    }
    format!("{value:.*}", (digits as i64 - 1 - decade).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::ringdown::by_hand;
    use slipfit::ringdown::LossModel;

    #[test]
    fn a_term_the_model_lacks_shows_its_limit() {
        let change = |answer: &mut Answer| answer.model = LossModel::Viscous;
        let text = by_hand(change, |analysed| ringdown(analysed, &[]));
        let text = anstream::adapter::strip_str(&text).to_string();
        let line = text.lines().find(|l| l.starts_with("  friction displacement")).unwrap();
        assert!(
            line.contains("< 2.1") && line.contains(" mrad ") && line.ends_with("95 %, not in model"),
            "{line}"
        );
    }

    #[test]
    fn a_fit_that_did_not_settle_is_marked() {
        let change = |answer: &mut Answer| answer.comparison[2].converged = false;
        let text = by_hand(change, |analysed| ringdown(analysed, &[]));
        assert!(text.contains("viscous * ") && text.contains("* the fit did not settle"), "{text}");
    }

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

    /// Every number set by hand, so that only the layout is under test.
    #[test]
    fn a_report_reads_like_this() {
        let text = by_hand(|_| (), |analysed| ringdown(analysed, &[Path::new("swing.svg")]));
        insta::assert_snapshot!(anstream::adapter::strip_str(&text).to_string());
    }
}

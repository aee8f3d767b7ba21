//! The answer to a ring-down on one screen.

use super::account::account;
use super::parameters::{Told, laid_out, significant};
use super::table::{Align, columns, width};
use super::{ANSWER, CHOSEN, DIM, HEADING, WIDTH, labelled, wrap};
use crate::AnalysedRingdown;
use crate::Sentence;
use crate::format::Scale;
use slipfit::LossTerm;
use slipfit::answer::Candidate;
use slipfit::ringdown::Answer;
use slipfit::{Parameter, Quantity};
use std::fmt::Write as _;
use std::path::Path;

/// The whole report, styled.
pub fn ringdown(analysed: &AnalysedRingdown<'_>, written: &[&Path]) -> String {
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
    let parameters = answer.parameters.iter().filter(|(p, q)| is_told(answer, *p, q));
    let tell = |(p, q): (Parameter, &Quantity)| match is_absent(answer, p) {
        true => Told::absent(p, q),
        false => Told::new(p, q),
    };
    parameters.map(tell).collect()
}

/// Whether a parameter says something the others do not; JSON has them all.
fn is_told(answer: &Answer, parameter: Parameter, quantity: &Quantity) -> bool {
    match parameter {
        Parameter::SlidingRate => answer.parameter(Parameter::FRICTION_DISPLACEMENT).is_none(),
        Parameter::Loss(LossTerm::Viscous | LossTerm::Sliding) => quantity.value.is_finite(),
        Parameter::Loss(term) => answer.model.has(term),
        _ => quantity.value.is_finite(),
    }
}

/// Whether the model reported has no such term.
fn is_absent(answer: &Answer, parameter: Parameter) -> bool {
    match parameter {
        Parameter::Loss(term) => !answer.model.has(term),
        Parameter::SlidingRate | Parameter::CoulombForce => !answer.model.has_sliding(),
        Parameter::ViscousCoefficient => !answer.model.has(LossTerm::Viscous),
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
    let unit = &answer.signal_unit;
    let terms: Vec<Term> = LossTerm::ALL.iter().map(|term| Term::new(answer, *term)).collect();
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
    rows
}

/// Models on the screen, the one reported marked.
pub(super) fn model_table(rows: &[Vec<String>], chosen: impl Fn(usize) -> bool, settled: bool) -> String {
    let mut align = vec![Align::Right; rows[0].len()];
    align[0] = Align::Left;
    let (rows, heads) = short_heads(rows);
    let lines = columns(&rows, &align);
    let styled = lines.iter().enumerate().map(|(i, line)| match (i, i >= heads && chosen(i - heads)) {
        (i, _) if i < heads => format!("  {HEADING}{line}{HEADING:#}\n"),
        (_, true) => format!("{CHOSEN}> {line}{CHOSEN:#}\n"),
        _ => format!("  {DIM}{line}{DIM:#}\n"),
    });
    let mut text: String = styled.collect();
    if !settled {
        text += &format!("  {DIM}* {UNSETTLED}{DIM:#}\n");
    }
    text
}

/// Headings in two lines, the name above its unit, where one is too wide; and how many lines
/// they take.
fn short_heads(rows: &[Vec<String>]) -> (Vec<Vec<String>>, usize) {
    if width(rows) + 2 <= WIDTH {
        return (rows.to_vec(), 1);
    }
    let split =
        |cell: &String| cell.split_once(" [").map(|(name, unit)| [name.to_owned(), format!("[{unit}")]);
    let halves: Vec<[String; 2]> =
        rows[0].iter().map(|cell| split(cell).unwrap_or_else(|| [String::new(), cell.clone()])).collect();
    let line = |at: usize| halves.iter().map(|h| h[at].clone()).collect::<Vec<String>>();
    let heads = [line(0), line(1)];
    (heads.into_iter().chain(rows[1..].iter().cloned()).collect(), 2)
}

/// What an asterisk behind a model means.
pub(crate) const UNSETTLED: &str = "the fit did not settle to its tolerance";

pub(super) fn headed(name: &str, scale: &Scale) -> String {
    let unit = scale.unit.trim_start_matches('×');
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// One loss term across the models.
struct Term {
    term: LossTerm,
    scale: Scale,
    /// Whether any model has it and the record can tell it.
    shown: bool,
}

impl Term {
    fn new(answer: &Answer, term: LossTerm) -> Self {
        let parameter = Parameter::Loss(term);
        let with = answer.comparison.iter().filter(|c| c.model.has(term));
        let largest = with.map(|c| c.value(parameter)).fold(0.0, f64::max);
        let shown = largest > 0.0 && answer.parameter(parameter).is_some();
        Self { term, scale: Scale::for_size(largest, &parameter.unit(&answer.signal_unit)), shown }
    }

    fn heading(&self) -> String {
        if self.shown { headed(self.term.symbol(), &self.scale) } else { String::new() }
    }

    fn cell(&self, candidate: &Candidate) -> String {
        let parameter = Parameter::Loss(self.term);
        match candidate.model.has(self.term) {
            _ if !self.shown => String::new(),
            false => "-".to_owned(),
            true if candidate.at_limit == Some(parameter) => "at 0".to_owned(),
            true => significant(candidate.value(parameter) * self.scale.factor, 3),
        }
    }
}

pub(super) fn bic(delta: f64) -> String {
    if delta < 100.0 { format!("{delta:.1}") } else { format!("{delta:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::by_hand;
    use slipfit::LossModel;

    #[test]
    fn a_term_the_model_lacks_shows_its_limit() {
        let change = |answer: &mut Answer| answer.model = LossModel::VISCOUS;
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

    /// Every number set by hand, so that only the layout is under test.
    #[test]
    fn a_report_reads_like_this() {
        let text = by_hand(|_| (), |analysed| ringdown(analysed, &[Path::new("swing.svg")]));
        insta::assert_snapshot!(anstream::adapter::strip_str(&text).to_string());
    }
}

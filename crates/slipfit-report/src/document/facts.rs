//! Statements of a report other than the numbers, each with a label.

use slipfit::answer::hint::Spelling;
use slipfit::{LossModel, LossTerm};
use slipfit_io::Note;

/// Labelled sentences in reading order; an empty label continues the previous one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Facts(Vec<(&'static str, String)>);

impl Facts {
    pub(crate) fn add(&mut self, label: &'static str, text: impl Into<String>) {
        self.0.push((label, text.into()));
    }

    /// Losses that the confidence intervals account for, of a `record` or a curve.
    pub(crate) fn counted_losses(&mut self, losses: Option<LossModel>, record: &str) {
        if let Some(losses) = losses {
            let words: Vec<&str> = losses.terms().map(LossTerm::words).collect();
            let words = words.join(" and ");
            self.add("also", format!("the intervals include {words}, which the {record} does not exclude"));
        }
    }

    pub(crate) fn notes(&mut self, notes: &[Note], spell: Spelling<'_>) {
        notes.iter().for_each(|note| self.add("note", note.spelled(spell)));
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.0.iter().map(|(label, text)| (*label, text.as_str()))
    }
}

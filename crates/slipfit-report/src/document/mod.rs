//! Everything a report says, before it is laid out for a screen or a page.

mod content;
mod facts;
mod levels;
pub(crate) mod method;
mod models;
pub(crate) mod parameter;
pub(crate) mod reading;
pub(crate) mod resonance;
mod ringdown;
mod series;

pub(crate) use content::Table;
pub use content::{Document, DocumentWarning};
pub(crate) use facts::Facts;
pub(crate) use parameter::ParameterRow;

use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries};
use slipfit::answer::hint::Spelling;

impl<'a> Document<'a> {
    /// The report of a ring-down; `spell` writes the options named in hints.
    pub fn ringdown(analysed: &'a AnalysedRingdown<'a>, spell: Spelling<'_>) -> Self {
        ringdown::document(analysed, spell)
    }

    /// The report of a resonance curve.
    pub fn resonance(analysed: &'a AnalysedCurve<'a>, spell: Spelling<'_>) -> Self {
        resonance::document(analysed, spell)
    }

    /// The report of drive levels.
    pub fn levels(analysed: &'a AnalysedLevels<'a>, spell: Spelling<'_>) -> Self {
        levels::document(analysed, spell)
    }

    /// The report of a series.
    pub fn series(analysed: &'a AnalysedSeries<'a>, spell: Spelling<'_>) -> Self {
        series::document(analysed, spell)
    }

    /// What limits the answer.
    pub fn warnings(&self) -> &[DocumentWarning] {
        &self.warnings
    }
}

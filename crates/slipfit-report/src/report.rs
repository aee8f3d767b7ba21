//! The common interface from any analysis to all of its reports.

use crate::plot::{self, Picture};
use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, Document, csv, json};
use slipfit::answer::hint::Spelling;
use std::io::{self, Write};

/// An analysis that can be reported.
pub trait Report {
    /// Its text and tables, for a screen or a page; `spell` writes the options named in hints.
    fn document(&self, spell: Spelling<'_>) -> Document<'_>;

    /// Its figure.
    fn figure(&self) -> Picture;

    /// Writes the whole answer as JSON: docs/json.md.
    ///
    /// # Errors
    /// Those of `out`.
    fn write_json(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Writes the numbers behind the figure as CSV.
    ///
    /// # Errors
    /// Those of `out`.
    fn write_csv(&self, out: &mut dyn Write) -> io::Result<()>;
}

macro_rules! report {
    ($($analysed:ident $name:ident;)+) => {$(
        impl Report for $analysed<'_> {
            fn document(&self, spell: Spelling<'_>) -> Document<'_> {
                Document::$name(self, spell)
            }

            fn figure(&self) -> Picture {
                plot::$name(self)
            }

            fn write_json(&self, out: &mut dyn Write) -> io::Result<()> {
                json::$name(out, self)
            }

            fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
                csv::$name(out, self)
            }
        }
    )+};
}

report! {
    AnalysedRingdown ringdown;
    AnalysedCurve resonance;
    AnalysedLevels levels;
    AnalysedSeries series;
}

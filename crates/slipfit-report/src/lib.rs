//! Reports of slipfit's answers: a terminal screen, JSON, CSV, figures (SVG, PNG), HTML, Markdown and LaTeX.
//!
//! A [`Report`] is an answer together with what was read ([`AnalysedRingdown`], [`AnalysedCurve`],
//! [`AnalysedLevels`], [`AnalysedSeries`]). Its text is a [`Document`], which [`terminal`] and [`page`] lay out;
//! functions return text or bytes, or write to a stream of the caller. Nothing here opens a file, prints, or
//! reads the environment or the clock, so that a command, a notebook and a web page show the same report.
//!
//! | module | makes |
//! |---|---|
//! | [`terminal`] | the report on a screen of 80 columns, styled by ANSI escapes |
//! | [`page`] | a report to hand in as HTML, Markdown or LaTeX |
//! | [`plot`] | figures as SVG or PNG (feature `png`) |
//! | [`json`] | the whole answer, as described in docs/json.md |
//! | [`csv`] | the numbers behind the figures |
//! | [`row`] | one line of a table of many files |
//! | [`mod@format`], [`Sentence`] | numbers with uncertainty and unit; the answer in a sentence |
//! | [`escape`] | text of others made inert, for each format |
//!
//! ```
//! use slipfit_report::{AnalysedRingdown, Report, terminal};
//! # let mut text = String::from("time (s),angle (rad)\n");
//! # for i in 0..600 {
//! #     let t = 0.05 * f64::from(i);
//! #     text += &format!("{t},{}\n", 0.3 * (-0.05 * t).exp() * (6.3 * t).cos());
//! # }
//! let reading = slipfit_io::read_from(text.as_bytes(), "swing.csv", &Default::default())?;
//! let options = slipfit::ringdown::Options::default();
//! let answer = slipfit::ringdown::analyse(&reading.record, &options)?;
//! let analysed = AnalysedRingdown {
//!     file: "swing.csv".as_ref(),
//!     reading: &reading,
//!     options: &options,
//!     answer: &answer,
//! };
//! assert!(terminal::screen(&analysed.document(&|option, _| option.to_owned()), &[]).contains("decay rate"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod csv;
mod document;
pub mod escape;
pub mod format;
mod input;
pub mod json;
pub mod page;
pub mod plot;
mod report;
pub mod row;
mod sentence;
pub mod terminal;
mod text;
mod warning;

#[cfg(test)]
mod example;

pub use document::{Document, DocumentWarning};
pub use input::{
    AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, Provenance, SeriesHeading, SeriesInput,
};
pub use report::Report;
pub use sentence::Sentence;
pub use warning::warning_text;

//! Reports of slipfit's answers: a terminal screen, JSON, CSV, figures (SVG, PNG), HTML, Markdown
//! and LaTeX.
//!
//! Every function takes an answer together with what was read ([`AnalysedRingdown`],
//! [`AnalysedCurve`], [`AnalysedLevels`], [`AnalysedSeries`]) and returns text or bytes, or writes
//! into a stream of the caller. Nothing here opens a file, prints, or reads the environment or the
//! clock, so that a command, a notebook and a web page show the same report.
//!
//! | module | makes |
//! |---|---|
//! | [`terminal`] | the report on a screen of 80 columns, styled by ANSI escapes |
//! | [`json`] | the whole answer, as described in docs/json.md |
//! | [`csv`] | the numbers behind the figures |
//! | [`plot`] | figures as SVG or PNG (feature `png`) |
//! | [`page`] | a report to hand in as HTML, Markdown or LaTeX |
//! | [`row`] | one line of a table of many files |
//!
//! ```
//! use slipfit_report::{AnalysedRingdown, terminal};
//! # let mut text = String::from("time (s),angle (rad)\n");
//! # for i in 0..600 {
//! #     let t = 0.05 * f64::from(i);
//! #     text += &format!("{t},{}\n", 0.3 * (-0.05 * t).exp() * (6.3 * t).cos());
//! # }
//! let reading = slipfit_io::read_text(text.as_bytes(), "swing.csv", &Default::default())?;
//! let options = slipfit::ringdown::Options::default();
//! let answer = slipfit::ringdown::analyse(&reading.record, &options)?;
//! let analysed = AnalysedRingdown {
//!     file: "swing.csv".as_ref(),
//!     reading: &reading,
//!     options: &options,
//!     answer: &answer,
//! };
//! assert!(terminal::ringdown(&analysed, &[]).contains("decay rate"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod csv;
pub mod format;
mod input;
pub mod json;
pub mod page;
pub mod plot;
pub mod row;
mod sentence;
pub mod terminal;
mod warning;

#[cfg(test)]
mod example;

pub use input::{
    AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, Provenance, SeriesHeading, SeriesInput,
};
pub use sentence::Sentence;
pub use warning::warning_text;

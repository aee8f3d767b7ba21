//! slipfit in a browser: the bytes of a file and what the person chose go in, the answer comes out
//! with everything a page shows of it.
//!
//! This crate converts and computes nothing: reading is `slipfit-io`'s, the answer the core's, words,
//! figures and files are those of `slipfit-report`. Everything crosses to JavaScript as JSON text.
//!
//! | function | gives |
//! |---|---|
//! | [`preview`] | the tables of a file, and which analysis it is for |
//! | [`analyse`] | the answer: JSON, document, warnings, figure, report, CSV, command, Python call |
//! | [`simulate::decay`], [`simulate::resonance`] | the exact motion beside the paper's approximations |
//!
//! ```
//! use slipfit_wasm::{File, Options, analyse};
//! let mut text = String::from("time (s),angle (rad)\n");
//! for i in 0..600 {
//!     let t = 0.05 * f64::from(i);
//!     text += &format!("{t},{}\n", 0.3 * (-0.05 * t).exp() * (6.3 * t).cos());
//! }
//! let file = File { name: "swing.csv", bytes: text.as_bytes() };
//! let answered = analyse(&file, None, &Options::parse("{}").unwrap()).unwrap();
//! assert!(answered.json.starts_with("{\n  \"schema\": \"slipfit/ringdown-1\""));
//! assert_eq!(answered.command, "slipfit ringdown swing.csv");
//! ```

mod analyse;
mod options;
mod preview;
mod refusal;
pub mod simulate;
mod spelling;
mod trace;
mod words;

#[cfg(target_arch = "wasm32")]
mod bindings;

pub use analyse::{Answered, RaisedWarning, analyse};
pub use options::{Analysis, Options};
pub use preview::{Preview, PreviewColumn, PreviewTable, preview};
pub use refusal::{Advice, Refusal};
pub use trace::Trace;

/// A file as a browser hands it over.
#[derive(Debug, Clone, Copy)]
pub struct File<'a> {
    /// Its name, for display.
    pub name: &'a str,
    /// What it holds.
    pub bytes: &'a [u8],
}

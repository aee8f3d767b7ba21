//! slipfit in a browser: the input is the bytes of a file and the options of the user, the output is the answer
//! with everything a page shows of it.
//!
//! This crate only converts: `slipfit-io` reads, the core computes the answer, and `slipfit-report` makes texts,
//! figures and files. All data are passed to JavaScript as JSON text, samples as numbers.
//!
//! | function | gives |
//! |---|---|
//! | [`Session::preview`] | the tables of a file, and which analysis it is for |
//! | [`Session::analyse`] | the answer: JSON, document with the panels, warnings, command, Python call |
//! | [`Session::trace`] | the record and its fit, to be drawn |
//! | [`Session::output`] | figure, report or CSV, made on request |
//! | [`simulate::decay`], [`simulate::resonance`] | the exact motion and the paper's approximations |

mod analysed;
mod options;
mod preview;
mod refusal;
mod session;
pub mod simulate;
mod spelling;
mod trace;
mod words;

#[cfg(target_arch = "wasm32")]
mod bindings;

pub use options::{Analysis, Options};
pub use preview::{Preview, PreviewColumn, PreviewTable};
pub use refusal::{Advice, Refusal};
pub use session::{Answered, Output, RaisedWarning, Session};
pub use trace::Trace;

/// A file from a browser: its name, for display, and its content.
#[derive(Debug, Clone, Copy)]
struct File<'a> {
    name: &'a str,
    bytes: &'a [u8],
}

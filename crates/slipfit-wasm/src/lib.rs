//! slipfit in a browser: the bytes of a file and what the person chose go in, the answer comes out
//! with everything a page shows of it.
//!
//! This crate converts and computes nothing: reading is `slipfit-io`'s, the answer the core's, words,
//! figures and files are those of `slipfit-report`. Everything crosses to JavaScript as JSON text, samples
//! as numbers.
//!
//! | function | gives |
//! |---|---|
//! | [`Session::preview`] | the tables of a file, and which analysis it is for |
//! | [`Session::analyse`] | the answer: JSON, document with the panels, warnings, command, Python call |
//! | [`Session::trace`] | the record and its fit, to be drawn |
//! | [`Session::output`] | figure, report or CSV, made where they are asked for |
//! | [`simulate::decay`], [`simulate::resonance`] | the exact motion beside the paper's approximations |

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

/// A file as a browser hands it over: its name, for display, and what it holds.
#[derive(Debug, Clone, Copy)]
struct File<'a> {
    name: &'a str,
    bytes: &'a [u8],
}

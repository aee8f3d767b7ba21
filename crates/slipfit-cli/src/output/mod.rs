//! Destinations of output: the screen, and files that are replaced as a whole or not at all.

mod origin;
mod place;
mod plan;
mod sink;
mod store;

pub(crate) use origin::foreign;
pub(crate) use plan::{Folder, Outputs, Target};
pub(crate) use sink::Sink;
pub(crate) use store::Store;

use crate::failure::Failure;
use anstream::{AutoStream, ColorChoice};
use std::io::{self, Write};

/// Writes styled text to standard output.
pub(crate) fn print(text: &str, color: ColorChoice) -> Result<(), Failure> {
    let mut out = AutoStream::new(io::stdout().lock(), color);
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|e| Failure::writing("standard output", &e))
}

/// Writes styled text to standard error; a failure there cannot be reported to anybody.
pub(crate) fn print_error(text: &str, color: ColorChoice) {
    let mut out = AutoStream::new(io::stderr().lock(), color);
    let _ = out.write_all(text.as_bytes());
}

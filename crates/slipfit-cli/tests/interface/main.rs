//! The command as users see it: arguments, files, streams, documents, exit codes.
//!
//! All tests are one program, because each separate one would take as long to link as to run.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod batch;
mod command;
mod curves;
mod documentation;
mod examples;
mod files;
mod hostile_documents;
mod inputs;
mod inspect;
mod interrupts;
mod json;
mod maps;
mod paper;
mod progress;
mod reports;
mod shell;
mod simulate;

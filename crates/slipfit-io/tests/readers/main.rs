//! Tests of the readers: layouts, formats, tables, sweeps, and files that change while they are read.
//!
//! A single test program: separate ones would take as long to link as to run.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod changing;
mod clocks;
mod formats;
mod headers;
mod json;
mod laboratory_curves;
mod laboratory_records;
mod random;
mod sheets;
mod stacked;
mod sweeps;
mod texts;
mod writers;

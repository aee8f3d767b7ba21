//! Validation of slipfit, run as `cargo xtask statistics` and `cargo xtask bench`.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a command prints its results and its progress"
)]

mod bench;
mod places;
mod statistics;

use std::process::ExitCode;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let subject = arguments.next().unwrap_or_default();
    let rest: Vec<String> = arguments.collect();
    let outcome = match subject.as_str() {
        "bench" => bench::run(&rest),
        "statistics" => statistics::run(&rest),
        _ => Err("statistics or bench is expected; see cargo xtask help".into()),
    };
    outcome.unwrap_or_else(|failure| {
        eprintln!("error: {failure}");
        ExitCode::from(2)
    })
}

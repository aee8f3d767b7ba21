//! `cargo xtask fuzz`: files of every format, changed at random, for as long as wanted.

use crate::Failure;
use std::process::{Command, ExitCode};

/// Runs the fuzz targets; `--minutes N`, `--seed N`.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let value = |flag: &str, default: &str| {
        let at = arguments.iter().position(|a| a == flag);
        at.and_then(|i| arguments.get(i + 1)).map_or_else(|| default.to_owned(), Clone::clone)
    };
    let minutes: f64 = value("--minutes", "10").parse()?;
    let seed: u64 = value("--seed", "1").parse()?;
    let status = Command::new("cargo")
        .args(["test", "-p", "slipfit-io", "--test", "fuzz", "--", "--ignored", "--nocapture"])
        .env("SLIPFIT_FUZZ_MINUTES", minutes.to_string())
        .env("SLIPFIT_FUZZ_SEED", seed.to_string())
        .status()?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

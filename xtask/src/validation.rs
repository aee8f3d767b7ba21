//! Builds and runs the statistics and the benchmark in release mode.

use std::process::ExitCode;

use crate::Failure;
use crate::places::{cargo, slipfit};
use crate::python;

/// Runs a subcommand of `slipfit-validation`, passing the arguments on.
pub(crate) fn chore(subject: &str, arguments: &[String]) -> Result<ExitCode, Failure> {
    let mut program = cargo();
    program.args(["run", "--quiet", "--release", "--package", "slipfit-validation", "--", subject]);
    if subject == "bench" {
        // The slipfit command is itself one of the contestants.
        slipfit()?;
        program.arg("--python").arg(python::interpreter()?);
    }
    let status = program.args(arguments).status()?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

//! Statistics and benchmark, built and run as users run the rest.

use std::process::ExitCode;

use crate::Failure;
use crate::places::{cargo, slipfit};
use crate::python;

/// Runs a subject of `slipfit-validation` with the arguments as they are.
pub(crate) fn chore(subject: &str, arguments: &[String]) -> Result<ExitCode, Failure> {
    let mut program = cargo();
    program.args(["run", "--quiet", "--release", "--package", "slipfit-validation", "--", subject]);
    if subject == "bench" {
        // The command itself is a contestant.
        slipfit()?;
        program.arg("--python").arg(python::interpreter()?);
    }
    let status = program.args(arguments).status()?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

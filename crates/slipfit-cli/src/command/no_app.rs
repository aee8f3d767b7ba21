//! `slipfit app` in a program that was built without it.

use crate::args::AppArgs;
use crate::failure::{BUILD_PAGE, Failure, WITHOUT_PAGE};
use anstream::ColorChoice;
use std::process::ExitCode;

pub(crate) fn run(_: &AppArgs, _: ColorChoice) -> Result<ExitCode, Failure> {
    Err(Failure::new(WITHOUT_PAGE).hint(BUILD_PAGE))
}

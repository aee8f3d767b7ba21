//! `slipfit app` of a program that was built without it.

use crate::args::AppArgs;
use crate::failure::Failure;
use anstream::ColorChoice;
use std::process::ExitCode;

pub(crate) fn run(args: &AppArgs, _: ColorChoice) -> Result<ExitCode, Failure> {
    let named = args.files.first().map(|file| format!("{}: ", file.display())).unwrap_or_default();
    Err(Failure::new(format!("{named}this slipfit was built without the page of the browser")).hint(
        "`cargo xtask web` builds the page into target/site; SLIPFIT_SITE names that folder where slipfit is built \
         with --features app",
    ))
}

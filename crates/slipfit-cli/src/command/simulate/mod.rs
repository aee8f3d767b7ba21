//! `slipfit simulate`: records made by the exact motion.

mod decay;
mod drive;
mod driven;
mod oscillator;
mod parquet;
mod sampling;
mod scan;
mod sheet;
mod turning;
mod write;

use crate::args::{SimulateArgs, SimulateCommand};
use crate::failure::Failure;
use anstream::ColorChoice;
use std::process::ExitCode;
use write::Destinations;

pub(crate) use decay::lock_in;
pub(crate) use sampling::Noise;

pub(crate) fn run(args: &SimulateArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    match &args.command {
        SimulateCommand::Decay(args) => {
            decay::run(args, &Destinations::of_samples(&args.out, &args.sampling, None)?)?;
        }
        SimulateCommand::Driven(args) => {
            let input = args.drive.drive_file.as_deref();
            let to = Destinations::of_samples(&args.out, &args.sampling, input)?;
            driven::run(args, &to, color)?;
        }
        SimulateCommand::Sweep(args) => scan::sweep(args, &Destinations::new(&args.out, None)?)?,
        SimulateCommand::Levels(args) => scan::levels(args, &Destinations::new(&args.out, None)?)?,
    }
    Ok(ExitCode::SUCCESS)
}

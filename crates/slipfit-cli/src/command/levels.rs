//! `slipfit levels`: amplitude at resonance against the drive level.

use super::show::{Destinations, show};
use crate::args::LevelFitArgs;
use crate::failure::Failure;
use anstream::ColorChoice;
use slipfit::answer::hint::Analysis;
use slipfit::levels::{Options, analyse};
use slipfit_io::{LevelReading, ReadOptions, read_levels};
use slipfit_report::AnalysedLevels;
use std::path::Path;
use std::process::ExitCode;

pub(crate) fn run(args: &LevelFitArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let to = Destinations::new(&args.out, [args.file.as_path()])?;
    let (reading, options) = prepare(&args.file, &args.reading.options(), args.options())?;
    args.calibration.check(reading.levels.unit())?;
    let answer = analyse(&reading.levels, &options)
        .map_err(|e| Failure::analysing(Analysis::Levels, Path::new(&reading.report.path), &e))?;
    let analysed = AnalysedLevels { reading: &reading, options: &options, answer: &answer };
    show(&args.out, &to, &analysed, args.calibration.unit_note(reading.levels.unit()), color)
}

/// Reads the input of an analysis.
pub(crate) fn prepare(
    file: &Path,
    reading: &ReadOptions,
    mut options: Options,
) -> Result<(LevelReading, Options), Failure> {
    let reading = read_levels(file, reading)?;
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    Ok((reading, options))
}

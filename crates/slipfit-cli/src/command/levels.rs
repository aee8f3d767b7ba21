//! `slipfit levels`: amplitude at resonance over the level of the drive.

use super::ringdown::check_calibration;
use super::show::{Destinations, Faces, show};
use crate::args::LevelFitArgs;
use crate::failure::{Failure, spelled, warned};
use crate::version::provenance;
use anstream::ColorChoice;
use slipfit::levels::{Options, analyse};
use slipfit_io::{LevelReading, read_levels};
use slipfit_report::{AnalysedLevels, csv, json, page, plot, terminal};
use std::process::ExitCode;

pub(crate) fn run(args: &LevelFitArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let to = Destinations::new(&args.out, [args.file.as_path()])?;
    let (reading, options) = prepare(args)?;
    let answer = analyse(&reading.levels, &options).map_err(|e| Failure::analysing_levels(&args.file, &e))?;
    let analysed = AnalysedLevels { reading: &reading, options: &options, answer: &answer, spell: spelled };
    let provenance = provenance();
    let picture = to.picture(|| plot::levels(&analysed))?;
    let faces = Faces {
        picture,
        csv: &|out| csv::levels(out, &analysed),
        json: &|out| json::levels(out, &analysed),
        html: &|| page::html(&page::levels(&analysed, &provenance)),
        markdown: &|| page::markdown(&page::levels(&analysed, &provenance)),
        latex: &|| page::latex(&page::levels(&analysed, &provenance)),
        report: &|written| terminal::levels(&analysed, written),
        warnings: answer.warnings.iter().map(warned).collect(),
    };
    show(&args.out, &to, &faces, color)
}

/// Reads what an analysis needs.
pub(crate) fn prepare(args: &LevelFitArgs) -> Result<(LevelReading, Options), Failure> {
    let reading = read_levels(&args.file, &args.read_options())?;
    check_calibration(args.calibration.flag(), reading.levels.unit())?;
    let mut options = args.options();
    // Simulated levels name the frequency they stand at.
    let named = reading.report.named_values.iter().find(|(name, _)| name == "drive_frequency_hz");
    if options.frequency_hz.is_none() {
        options.frequency_hz =
            named.and_then(|(_, value)| value.parse().ok()).filter(|f: &f64| f.is_finite() && *f > 0.0);
    }
    Ok((reading, options))
}

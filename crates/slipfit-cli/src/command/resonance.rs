//! `slipfit resonance`: from a curve, or raw driven records, to its answer.

use super::ringdown::check_calibration;
use super::show::{Destinations, Faces, show};
use crate::args::ResonanceArgs;
use crate::batch;
use crate::failure::{Failure, spelled, warned};
use crate::version::provenance;
use anstream::ColorChoice;
use slipfit::resonance::{Options, analyse};
use slipfit_io::{SweepReading, read_sweep};
use slipfit_report::{AnalysedCurve, csv, json, page, plot, terminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub(crate) fn run(args: &ResonanceArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if args.table.table.is_some() {
        return many(args, color);
    }
    let to = Destinations::new(&args.out, args.inputs())?;
    let (reading, reference, options) = prepare(args)?;
    let file = Path::new(&reading.report.path);
    let answer = analyse(&reading.curve, &options).map_err(|e| Failure::analysing_curve(file, &e))?;
    let analysed = AnalysedCurve {
        reading: &reading,
        reference: reference.as_ref(),
        options: &options,
        answer: &answer,
        spell: spelled,
    };
    let provenance = provenance();
    let picture = to.picture(|| plot::resonance(&analysed))?;
    let faces = Faces {
        picture,
        csv: &|out| csv::resonance(out, &analysed),
        json: &|out| json::resonance(out, &analysed),
        html: &|| page::html(&page::resonance(&analysed, &provenance)),
        markdown: &|| page::markdown(&page::resonance(&analysed, &provenance)),
        latex: &|| page::latex(&page::resonance(&analysed, &provenance)),
        report: &|written| terminal::resonance(&analysed, written),
        warnings: answer.warnings.iter().map(warned).collect(),
    };
    show(&args.out, &to, &faces, color)
}

/// A table of curves, one a file.
fn many(args: &ResonanceArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    // Read once: it is the same for all of them.
    let reference = read_reference(args)?;
    let fingerprint = reference.as_ref().map(|r| r.report.sha256.as_str()).unwrap_or_default();
    let one = |file: &Path| {
        let (reading, options) = prepare_curve(args, &[file.to_owned()], reference.as_ref())?;
        let answer = analyse(&reading.curve, &options).map_err(|e| Failure::analysing_curve(file, &e))?;
        Ok(batch::resonance::row(file, &reading, &answer))
    };
    let task = batch::Task {
        command: "resonance",
        files: &args.files,
        reference: args.reference.as_deref(),
        table: &args.table,
        out: &args.out,
        columns: batch::resonance::COLUMNS,
        options: format!("{:?} {:?} {fingerprint}", args.curve.options(), args.options()),
        one: &one,
    };
    batch::run(&task, color)
}

/// Reads what an analysis needs.
pub(crate) fn prepare(
    args: &ResonanceArgs,
) -> Result<(SweepReading, Option<SweepReading>, Options), Failure> {
    let reference = read_reference(args)?;
    let (reading, options) = prepare_curve(args, &args.files, reference.as_ref())?;
    Ok((reading, reference, options))
}

fn read_reference(args: &ResonanceArgs) -> Result<Option<SweepReading>, Failure> {
    let read = |file| read_sweep(std::slice::from_ref(file), &args.curve.options());
    Ok(args.reference.as_ref().map(read).transpose()?)
}

fn prepare_curve(
    args: &ResonanceArgs,
    files: &[PathBuf],
    reference: Option<&SweepReading>,
) -> Result<(SweepReading, Options), Failure> {
    let reading = read_sweep(files, &args.curve.options())?;
    check_calibration(args.calibration.flag(), reading.curve.unit())?;
    let mut options = args.options();
    if let Some(reference) = reference {
        let (unit, other) = (reading.curve.unit(), reference.curve.unit());
        if unit != other {
            return Err(Failure::new(format!(
                "--reference {}: its amplitudes are in `{other}`, those of {} in `{unit}`",
                reference.report.path, reading.report.path
            ))
            .hint("--unit says what both are in"));
        }
        options.reference = Some(reference.curve.clone());
    }
    Ok((reading, options))
}

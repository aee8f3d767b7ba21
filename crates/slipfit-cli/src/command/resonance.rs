//! `slipfit resonance`: from a curve, or raw driven records, to the answer.

use super::show::{Destinations, show};
use crate::args::ResonanceArgs;
use crate::batch;
use crate::failure::{Failure, note_line};
use crate::output;
use crate::progress;
use anstream::ColorChoice;
use slipfit::answer::hint::Analysis;
use slipfit::resonance::{Options, analyse};
use slipfit_io::{ReadOptions, SweepReading, read_sweep};
use slipfit_report::AnalysedCurve;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub(crate) fn run(args: &ResonanceArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if let Some(note) = args.analysis.old_spelling().filter(|_| !args.out.quiet) {
        output::print_error(&note_line(&note), color);
    }
    if args.table.table.is_some() {
        return many(args, color);
    }
    let to = Destinations::new(&args.out, args.inputs())?;
    let curve = args.curve.options();
    let (reference, reading, options, answer) = progress::with_spinner("analysing", args.out.quiet, || {
        let [own, of_reference] = reading_options(&curve, &args.files, args.reference.as_deref());
        let reference = read_reference(args.reference.as_deref(), &of_reference)?;
        let given = (args.options(), args.analysis.drive_unit());
        let (reading, options) = prepare(&args.files, &own, given, reference.as_ref())?;
        args.calibration.check(reading.curve.unit())?;
        let file = Path::new(&reading.report.path);
        let answer = analyse(&reading.curve, &options)
            .map_err(|e| Failure::analysing(Analysis::Resonance, file, &e))?;
        Ok::<_, Failure>((reference, reading, options, answer))
    })?;
    let analysed = AnalysedCurve {
        reading: &reading,
        reference: reference.as_ref(),
        options: &options,
        answer: &answer,
    };
    show(&args.out, &to, &analysed, args.calibration.unit_note(reading.curve.unit()), color)
}

/// A table of curves, one per file.
fn many(args: &ResonanceArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let (curve, options, drive_unit) = (args.curve.options(), args.options(), args.analysis.drive_unit());
    // Read once, because it is the same for all files.
    let [_, of_reference] = reading_options(&curve, &args.files[..1], args.reference.as_deref());
    let reference = read_reference(args.reference.as_deref(), &of_reference)?;
    let fingerprint = reference.as_ref().map(|r| r.report.sha256.as_str()).unwrap_or_default();
    let one = |file: &Path| {
        let given = (options.clone(), drive_unit.clone());
        let files = [file.to_owned()];
        let [own, _] = reading_options(&curve, &files, args.reference.as_deref());
        let (reading, options) = prepare(&files, &own, given, reference.as_ref())?;
        args.calibration.check(reading.curve.unit())?;
        let answer = analyse(&reading.curve, &options)
            .map_err(|e| Failure::analysing(Analysis::Resonance, file, &e))?;
        Ok(batch::resonance::row(file, &reading, &answer))
    };
    let task = batch::Task {
        command: "resonance",
        typed: &args.files,
        files: &args.files,
        reference: args.reference.as_deref(),
        table: &args.table,
        out: &args.out,
        columns: batch::resonance::COLUMNS,
        options: format!("{curve:?} {options:?} {drive_unit:?} {fingerprint}"),
        one: &one,
    };
    batch::run(&task, color)
}

/// The options for the input of an analysis and for its friction-free curve.
pub(crate) fn reading_options(
    options: &ReadOptions,
    files: &[PathBuf],
    reference: Option<&Path>,
) -> [ReadOptions; 2] {
    match reference {
        Some(file) => [options.beside(files, &[file]), options.beside(&[file], files)],
        None => [options.clone(), options.clone()],
    }
}

/// Reads the friction-free curve, if there is one.
pub(crate) fn read_reference(
    file: Option<&Path>,
    options: &ReadOptions,
) -> Result<Option<SweepReading>, Failure> {
    let read = |file: &Path| read_sweep(&[file.to_owned()], options);
    Ok(file.map(read).transpose()?)
}

/// Reads the input of an analysis. The drive amplitude in the options, given in its own unit, is converted to the
/// unit of the response.
pub(crate) fn prepare(
    files: &[PathBuf],
    reading: &ReadOptions,
    (mut options, drive_unit): (Options, Option<String>),
    reference: Option<&SweepReading>,
) -> Result<(SweepReading, Options), Failure> {
    let reading = read_sweep(files, reading)?;
    if let (Some(drive), Some(from)) = (&mut options.drive_amplitude, drive_unit) {
        let to = reading.curve.unit();
        let factor = slipfit_io::unit_factor(&from, to).ok_or_else(|| {
            let of = if to.is_empty() { "in no known unit".to_owned() } else { format!("in `{to}`") };
            Failure::new(format!(
                "--drive-amplitude is in `{from}`, the response of {} {of}: they cannot be compared",
                reading.report.path
            ))
            .hint("--unit gives the unit of the response; a drive amplitude without a unit has that unit")
        })?;
        (drive.value, drive.std_error) = (drive.value * factor, drive.std_error * factor);
    }
    if let Some(reference) = reference {
        let (unit, other) = (reading.curve.unit(), reference.curve.unit());
        if unit != other {
            return Err(Failure::new(format!(
                "--reference {}: its amplitudes are in `{other}`, those of {} in `{unit}`",
                reference.report.path, reading.report.path
            ))
            .hint("give the unit of both curves with --unit"));
        }
        options.reference = Some(reference.curve.clone());
    }
    Ok((reading, options))
}

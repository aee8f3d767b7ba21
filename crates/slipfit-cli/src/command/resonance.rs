//! `slipfit resonance`: from a curve, or raw driven records, to its answer.

use super::ringdown::check_calibration;
use crate::args::{AnswerArgs, ResonanceArgs};
use crate::failure::{Failure, warning_line};
use crate::{csv, json, output, plot, report};
use anstream::ColorChoice;
use slipfit::resonance::{Answer, Options, analyse};
use slipfit_io::{SweepReading, read_sweep};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit status of a doubtful answer under `--strict`.
const DOUBTFUL: u8 = 1;

/// A curve, what was asked of it, and what it answered.
pub(crate) struct AnalysedCurve<'a> {
    pub(crate) reading: &'a SweepReading,
    pub(crate) reference: Option<&'a SweepReading>,
    pub(crate) options: &'a Options,
    pub(crate) answer: &'a Answer,
}

pub(crate) fn run(args: &ResonanceArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let plot_format = args.out.plot.as_deref().map(plot::Format::of).transpose()?;
    let (reading, reference, options) = prepare(args)?;
    let file = Path::new(&reading.report.path);
    let answer = analyse(&reading.curve, &options).map_err(|e| Failure::analysing_curve(file, &e))?;
    let analysed = AnalysedCurve {
        reading: &reading,
        reference: reference.as_ref(),
        options: &options,
        answer: &answer,
    };
    let picture = plot_format.map(|format| plot::resonance(&analysed, format)).transpose()?;
    let faces = Faces {
        picture,
        csv: &|out| csv::resonance(out, &analysed),
        json: &|out| json::resonance(out, &analysed),
        report: &|written| report::resonance(&analysed, written),
        warnings: answer.warnings.iter().map(|w| warning_line(&w.to_string())).collect(),
    };
    show(&args.out, &faces, color)
}

/// Reads what an analysis needs.
pub(crate) fn prepare(
    args: &ResonanceArgs,
) -> Result<(SweepReading, Option<SweepReading>, Options), Failure> {
    let read = args.curve.options();
    let reading = read_sweep(&args.files, &read)?;
    check_calibration(args.calibration.flag(), reading.curve.unit())?;
    let reference =
        args.reference.as_ref().map(|file| read_sweep(std::slice::from_ref(file), &read)).transpose()?;
    let mut options = args.options();
    if let Some(reference) = &reference {
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
    Ok((reading, reference, options))
}

/// The ways out of an analysis.
pub(crate) struct Faces<'a> {
    pub(crate) picture: Option<Vec<u8>>,
    pub(crate) csv: &'a dyn Fn(&mut dyn Write) -> io::Result<()>,
    pub(crate) json: &'a dyn Fn(&mut dyn Write) -> io::Result<()>,
    pub(crate) report: &'a dyn Fn(&[&Path]) -> String,
    pub(crate) warnings: Vec<String>,
}

/// Writes the files asked for, then the report, then the doubts.
pub(crate) fn show(out: &AnswerArgs, faces: &Faces<'_>, color: ColorChoice) -> Result<ExitCode, Failure> {
    let mut written: Vec<&Path> = Vec::new();
    if let (Some(path), Some(picture)) = (&out.plot, &faces.picture) {
        output::to_path(path, |o| o.write_all(picture))?;
        written.push(path);
    }
    let on_stdout = |path: &Option<PathBuf>| path.as_deref().is_some_and(output::is_stdout);
    if let Some(path) = &out.csv {
        output::to_path(path, faces.csv)?;
        written.push(path);
    }
    let json_on_stdout = on_stdout(&out.json);
    if let Some(path) = out.json.as_deref().filter(|_| !json_on_stdout) {
        output::to_path(path, faces.json)?;
        written.push(path);
    }
    if !out.quiet {
        // On a terminal both streams meet: the doubts come after the answer.
        if !json_on_stdout && !on_stdout(&out.csv) {
            output::print(&(faces.report)(&written), color)?;
        }
        output::print_error(&faces.warnings.concat(), color);
    }
    if let Some(path) = out.json.as_deref().filter(|_| json_on_stdout) {
        output::to_path(path, faces.json)?;
    }
    let doubtful = out.strict && !faces.warnings.is_empty();
    Ok(if doubtful { ExitCode::from(DOUBTFUL) } else { ExitCode::SUCCESS })
}

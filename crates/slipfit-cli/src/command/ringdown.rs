//! `slipfit ringdown`: from a file to its answer.

use crate::args::RingdownArgs;
use crate::failure::{Failure, warning_line};
use crate::{csv, json, output, plot, report};
use anstream::ColorChoice;
use slipfit::SignalKind;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit_io::Reading;
use std::path::Path;
use std::process::ExitCode;

/// Exit status of a doubtful answer under `--strict`.
const DOUBTFUL: u8 = 1;

/// A file, what was asked of it, and what it answered.
pub(crate) struct Analysed<'a> {
    pub(crate) file: &'a Path,
    pub(crate) reading: &'a Reading,
    pub(crate) options: &'a Options,
    pub(crate) answer: &'a Answer,
}

pub(crate) fn run(args: &RingdownArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let plot_format = args.plot.as_deref().map(plot::Format::of).transpose()?;
    let reading = slipfit_io::read(&args.file, &args.read_options())?;
    check_calibration(args, reading.record.unit())?;
    let mut options = args.options();
    if options.frequency_hz.is_none() {
        options.frequency_hz = named_frequency_hz(&reading);
    }
    let answer = analyse(&reading.record, &options).map_err(|e| Failure::analysing(&args.file, &e))?;
    let analysed = Analysed { file: &args.file, reading: &reading, options: &options, answer: &answer };

    let mut written: Vec<&Path> = Vec::new();
    if let (Some(path), Some(format)) = (&args.plot, plot_format) {
        let picture = plot::ringdown(&analysed, format)?;
        output::to_path(path, |out| out.write_all(&picture))?;
        written.push(path);
    }
    if let Some(path) = &args.csv {
        output::to_path(path, |out| csv::ringdown(out, &analysed))?;
        written.push(path);
    }
    let json_on_stdout = args.json.as_deref().is_some_and(output::is_stdout);
    if let Some(path) = args.json.as_deref().filter(|_| !json_on_stdout) {
        output::to_path(path, |out| json::ringdown(out, &analysed))?;
        written.push(path);
    }
    if !args.quiet {
        // On a terminal both streams meet: the doubts come after the answer.
        let warnings: String = answer.warnings.iter().map(|w| warning_line(&w.to_string())).collect();
        if !json_on_stdout && !args.csv.as_deref().is_some_and(output::is_stdout) {
            output::print(&report::ringdown(&analysed, &written), color)?;
        }
        output::print_error(&warnings, color);
    }
    if let Some(path) = args.json.as_deref().filter(|_| json_on_stdout) {
        output::to_path(path, |out| json::ringdown(out, &analysed))?;
    }
    let doubtful = args.strict && !answer.warnings.is_empty();
    Ok(if doubtful { ExitCode::from(DOUBTFUL) } else { ExitCode::SUCCESS })
}

/// The frequency of the oscillation, where amplitudes alone were recorded and
/// the lines above the table name it `frequency_hz`.
pub(crate) fn named_frequency_hz(reading: &Reading) -> Option<f64> {
    if !matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return None;
    }
    let named = reading.report.named_values.iter().find(|(name, _)| name == "frequency_hz")?;
    named.1.parse().ok().filter(|f: &f64| f.is_finite() && *f > 0.0)
}

/// A stiffness in N/m says nothing about an angle, nor a torsion stiffness about a length.
fn check_calibration(args: &RingdownArgs, unit: &str) -> Result<(), Failure> {
    let angle = matches!(unit, "rad" | "mrad" | "deg" | "°" | "rev");
    let length = matches!(unit, "m" | "cm" | "mm" | "µm" | "um" | "nm" | "pm");
    match args.calibration_flag() {
        Some((flag, false)) if angle => {
            Err(Failure::new(format!("{flag} is for a displacement; the signal is in {unit}"))
                .hint("--torsion-stiffness or --inertia calibrates an angle, --unit changes the unit read"))
        }
        Some((flag, true)) if length => {
            Err(Failure::new(format!("{flag} is for an angle; the signal is in {unit}"))
                .hint("--stiffness or --mass calibrates a displacement, --unit changes the unit read"))
        }
        _ => Ok(()),
    }
}

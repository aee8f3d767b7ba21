//! `slipfit ringdown`: from a file to its answer.

use super::show::{Destinations, Faces, show};
use crate::args::RingdownArgs;
use crate::batch;
use crate::failure::{Failure, spelled, warned};
use crate::version::provenance;
use anstream::ColorChoice;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipfit::Parameter;
use slipfit::SignalKind;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit_io::{Format, Reading};
use slipfit_report::format::plain;
use slipfit_report::{AnalysedRingdown, csv, json, page, plot, terminal};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// A file this large, in bytes, is read with a bar; it takes about a tenth of a second.
const LARGE: u64 = 32 << 20;

pub(crate) fn run(args: &RingdownArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if args.table.table.is_some() || args.files.len() > 1 {
        let task = batch::Task {
            command: "ringdown",
            files: &args.files,
            reference: None,
            table: &args.table,
            out: &args.out,
            columns: batch::ringdown::COLUMNS,
            options: format!("{:?} {:?}", args.reading.options(), args.options()),
            one: &|file| Ok(batch::ringdown::row(file, &analyse_file(file, args)?)),
        };
        return batch::run(&task, color);
    }
    let to = Destinations::new(&args.out, args.inputs())?;
    let file = &args.files[0];
    let Done { reading, options, answer } = watched(file, args)?;
    let analysed =
        AnalysedRingdown { file, reading: &reading, options: &options, answer: &answer, spell: spelled };

    let provenance = provenance();
    let picture = to.picture(|| plot::ringdown(&analysed))?;
    let faces = Faces {
        picture,
        csv: &|out| csv::ringdown(out, &analysed),
        json: &|out| json::ringdown(out, &analysed),
        html: &|| page::html(&page::ringdown(&analysed, &provenance)),
        markdown: &|| page::markdown(&page::ringdown(&analysed, &provenance)),
        latex: &|| page::latex(&page::ringdown(&analysed, &provenance)),
        report: &|written| terminal::ringdown(&analysed, written),
        warnings: answer.warnings.iter().map(warned).collect(),
    };
    show(&args.out, &to, &faces, color)
}

/// A file read and analysed.
pub(crate) struct Done {
    pub(crate) reading: Reading,
    pub(crate) options: Options,
    pub(crate) answer: Answer,
}

/// Reads and analyses one file, with a bar where that takes a while.
fn watched(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    let bytes = std::fs::metadata(file).map_or(0, |m| m.len());
    if args.out.quiet || bytes < LARGE {
        return analyse_file(file, args);
    }
    let bar = ProgressBar::with_draw_target(Some(bytes), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}, {eta} left") {
        bar.set_style(style);
    }
    let spin = |message| {
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(message);
        bar.enable_steady_tick(Duration::from_millis(120));
    };
    let read = slipfit_io::read_watched(file, &args.reading.options(), &mut |n| {
        bar.set_position(n);
        // Formats other than text are decoded once all of their bytes have passed.
        if n >= bytes {
            spin("decoding");
        }
    });
    let done = read.map_err(Failure::from).and_then(|reading| {
        spin("analysing");
        analyse_reading(file, reading, args)
    });
    bar.finish_and_clear();
    done
}

/// Reads and analyses one file.
pub(crate) fn analyse_file(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    analyse_reading(file, slipfit_io::read(file, &args.reading.options())?, args)
}

fn analyse_reading(file: &Path, reading: Reading, args: &RingdownArgs) -> Result<Done, Failure> {
    check_calibration(args.calibration_flag(), reading.record.unit())?;
    let mut options = args.options();
    if options.frequency_hz.is_none() {
        options.frequency_hz = reading.named_frequency_hz();
    }
    heeded(&reading, args)?;
    let answer = analyse(&reading.record, &options).map_err(|e| Failure::analysing(file, &e))?;
    reached(&options, &answer)?;
    Ok(Done { reading, options, answer })
}

/// A flag that would change nothing is a mistake.
fn heeded(reading: &Reading, args: &RingdownArgs) -> Result<(), Failure> {
    let amplitudes = matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    if let Some(f) = args.options().frequency_hz.filter(|_| !amplitudes) {
        return Err(Failure::new(format!(
            "--frequency-hz {f}: only for a record of amplitudes; this one oscillates and has its own frequency"
        ))
        .hint("--band says where to look for it"));
    }
    if let Some(sheet) = args.reading.sheet.as_ref().filter(|_| reading.report.format == Format::Text) {
        return Err(Failure::new(format!("--sheet {sheet}: a text has no sheets"))
            .hint("--part chooses one of several tables side by side, --run one of several runs"));
    }
    Ok(())
}

/// A least amplitude that no amplitude reaches leaves nothing to fit.
fn reached(options: &Options, answer: &Answer) -> Result<(), Failure> {
    let (Some(least), Some(first)) = (options.min_amplitude, answer.parameter(Parameter::InitialAmplitude))
    else {
        return Ok(());
    };
    if first.value.is_nan() || first.value > least {
        return Ok(());
    }
    let (unit, first) = (&answer.signal_unit, plain(first.value, 3, &answer.signal_unit));
    Err(Failure::new(format!("--min-amplitude {least} {unit}: the decay begins at {first} already")))
}

/// A stiffness in N/m says nothing about an angle, nor a torsion stiffness about a length.
pub(crate) fn check_calibration(given: Option<(&'static str, bool)>, unit: &str) -> Result<(), Failure> {
    let angle = matches!(unit, "rad" | "mrad" | "deg" | "°" | "rev");
    let length = matches!(unit, "m" | "cm" | "mm" | "µm" | "um" | "nm" | "pm");
    match given {
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

//! `slipfit ringdown`: from a file to the answer.

use super::show::{Destinations, show};
use crate::args::RingdownArgs;
use crate::batch;
use crate::failure::Failure;
use crate::progress;
use anstream::ColorChoice;
use slipfit::answer::hint::Analysis;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit_io::Reading;
use slipfit_report::AnalysedRingdown;
use std::path::Path;
use std::process::ExitCode;

/// File size, in bytes, from which reading shows a progress bar; reading it takes about a tenth of a second.
const LARGE: u64 = 32 << 20;

pub(crate) fn run(args: &RingdownArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    args.check_glob()?;
    let files = args.inputs();
    if args.table.table.is_some() || files.len() > 1 || files != args.files {
        let task = batch::Task {
            command: "ringdown",
            typed: &args.files,
            files: &files,
            reference: None,
            table: &args.table,
            out: &args.out,
            columns: batch::ringdown::COLUMNS,
            options: format!("{:?} {:?}", args.reading.options(), args.options()),
            one: &|file| {
                let done = analyse_file(file, args)?;
                Ok(batch::ringdown::row(file, &done.reading, &done.answer))
            },
        };
        return batch::run(&task, color);
    }
    let file = &args.files[0];
    let to = Destinations::new(&args.out, [file.as_path()])?;
    let Done { reading, options, answer } = analyse_with_progress(file, args)?;
    // The report contains the name used for standard input.
    let file = Path::new(&reading.report.path);
    let analysed = AnalysedRingdown { file, reading: &reading, options: &options, answer: &answer };
    let notes = [args.calibration.unit_note(reading.record.unit()), band_note(&reading, args)];
    let notes: Vec<String> = notes.into_iter().flatten().collect();
    let note = (!notes.is_empty()).then(|| notes.join("; "));
    show(&args.out, &to, &analysed, note, color)
}

/// A file after reading and analysis.
struct Done {
    reading: Reading,
    options: Options,
    answer: Answer,
}

/// Reads and analyses one file, with a progress bar if that takes a while.
fn analyse_with_progress(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    let bytes = std::fs::metadata(file).map_or(0, |m| m.len());
    if args.out.quiet || bytes < LARGE {
        return progress::with_spinner("analysing", args.out.quiet, || analyse_file(file, args));
    }
    let bar = progress::bar(bytes, "{bytes} of {total_bytes}", false);
    let read = slipfit_io::read_watched(file, &args.reading.options(), &mut |n| {
        bar.set_position(n);
        // Formats other than text are decoded after all of their bytes have been read.
        if n >= bytes {
            progress::spin(&bar, "decoding");
        }
    });
    let done = read.map_err(Failure::from).and_then(|reading| {
        progress::spin(&bar, "analysing");
        analyse_reading(reading, args)
    });
    bar.finish_and_clear();
    done
}

/// Reads and analyses one file.
fn analyse_file(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    if file.is_dir()
        && let Ok(held) = slipfit_io::files_in(file)
    {
        let (name, held) = (file.display(), held.len());
        return Err(match &args.glob {
            Some(pattern) => Failure::new(format!("{name}: --glob {pattern}: matches none of {held} files")),
            None => Failure::new(format!("{name}: the folder contains no files")),
        });
    }
    analyse_reading(slipfit_io::read(file, &args.reading.options())?, args)
}

fn analyse_reading(reading: Reading, args: &RingdownArgs) -> Result<Done, Failure> {
    args.calibration.check(reading.record.unit())?;
    let mut options = args.options();
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    check_flags(&reading, args)?;
    let file = Path::new(&reading.report.path);
    let failed = |e: slipfit::Error| Failure::analysing(Analysis::Ringdown, file, &e);
    let answer = analyse(&reading.record, &options).map_err(failed)?;
    options.check_reached(&answer).map_err(failed)?;
    Ok(Done { reading, options, answer })
}

/// A flag that would have no effect is an error.
fn check_flags(reading: &Reading, args: &RingdownArgs) -> Result<(), Failure> {
    if args.options().frequency_hz.is_some() && reading.record.kind().oscillates() {
        return Err(Failure::new(
            "--frequency-hz is only for records of amplitudes; the frequency of this one is fitted",
        )
        .hint("--band limits the frequencies"));
    }
    Ok(())
}

/// A note for the case that a band is given for amplitudes, which do not oscillate.
fn band_note(reading: &Reading, args: &RingdownArgs) -> Option<String> {
    let [low, high] = args.options().band_hz.filter(|_| !reading.record.kind().oscillates())?;
    Some(format!("--band {low} {high} has no effect on a record of amplitudes, which does not oscillate"))
}

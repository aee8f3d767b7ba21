//! Many files at once: one row a file, written as it is done.

mod journal;
mod row;
mod table;

use crate::args::RingdownArgs;
use crate::command::ringdown::{Done, analyse_file};
use crate::failure::Failure;
use crate::output;
use anstream::ColorChoice;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use journal::Journal;
use rayon::prelude::*;
use row::Row;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use table::Form;

/// Exit status of doubtful answers under `--strict`, and of nothing but failures.
const DOUBTFUL: u8 = 1;
const FAILED: u8 = 2;

/// Analyses every file; none of them stops the others.
pub(crate) fn run(args: &RingdownArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    for (flag, given) in [
        ("--json", args.out.json.is_some()),
        ("--plot", args.out.plot.is_some()),
        ("--csv", args.out.csv.is_some()),
    ] {
        if given {
            return Err(Failure::new(format!("{flag} is for one file, not for a table of several"))
                .hint("a table ending in .json holds every row in machine-readable form"));
        }
    }
    let form = args.table.table.as_deref().map(Form::of).transpose()?;
    let (journal, mut done) = match &args.table.table {
        Some(path) => {
            let (journal, rows) = Journal::open(path, &signature(), args.table.resume)?;
            (Some(Mutex::new(journal)), rows)
        }
        None => (None, Vec::new()),
    };
    let known: HashMap<String, ()> = done.iter().map(|r: &Row| (r.file.clone(), ())).collect();
    let waiting: Vec<&PathBuf> =
        args.files.iter().filter(|f| !known.contains_key(&f.display().to_string())).collect();
    let bar = progress(args.files.len() as u64, args.out.quiet);
    bar.inc((args.files.len() - waiting.len()) as u64);
    let fresh = waiting
        .par_iter()
        .map(|file| {
            let row = one(file, args);
            if let (Some(journal), Some(path), Some(form)) = (&journal, &args.table.table, form) {
                journal.lock().unwrap_or_else(std::sync::PoisonError::into_inner).add(&row, path, form)?;
            }
            bar.inc(1);
            Ok(row)
        })
        .collect::<Result<Vec<Row>, Failure>>()?;
    bar.finish_and_clear();
    done.extend(fresh);
    // Rows were written as they came; the table keeps the order of the files.
    let mut by_file: HashMap<String, Row> = done.into_iter().map(|r| (r.file.clone(), r)).collect();
    let rows: Vec<Row> = args.files.iter().filter_map(|f| by_file.remove(&f.display().to_string())).collect();
    match (&args.table.table, form, journal) {
        (Some(path), Some(form), Some(journal)) => {
            let journal = journal.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
            journal.finish(path, &form.render(&rows)?)?;
        }
        _ => output::print(&table::markdown(&rows), color)?,
    }
    let count = |status: &str| rows.iter().filter(|r| r.status == status).count();
    let (warned, failed) = (count("warned"), count("failed"));
    if !args.out.quiet {
        let place = args.table.table.as_deref().map(|p| format!("; {}", p.display())).unwrap_or_default();
        output::print_error(
            &format!(
                "{} files: {} without doubt, {warned} with warnings, {failed} failed{place}\n",
                rows.len(),
                count("done")
            ),
            color,
        );
    }
    Ok(match (failed == rows.len(), args.out.strict && warned + failed > 0) {
        (true, _) => ExitCode::from(FAILED),
        (_, true) => ExitCode::from(DOUBTFUL),
        _ => ExitCode::SUCCESS,
    })
}

/// The row of one file, whatever becomes of it.
fn one(file: &Path, args: &RingdownArgs) -> Row {
    match catch_unwind(AssertUnwindSafe(|| analyse_file(file, args))) {
        Ok(Ok(Done { reading, answer, .. })) => Row::answered(file, &reading, &answer),
        Ok(Err(failure)) => Row::failed(file, &failure.message()),
        Err(_) => Row::failed(file, "an error within slipfit: please report this file"),
    }
}

/// The command line without the files and what does not change a row: a table
/// is gone on with by the same options only.
fn signature() -> String {
    let mut words = Vec::new();
    let mut skip = false;
    for word in std::env::args().skip(2) {
        let known = ["--table", "--color"].contains(&word.as_str());
        if !(skip || known || ["--resume", "--quiet", "-q", "--strict"].contains(&word.as_str()))
            && (word.starts_with("--") || words.last().is_some_and(|w: &String| w.starts_with("--")))
        {
            words.push(word.clone());
        }
        skip = known;
    }
    format!("slipfit {} ringdown {}", env!("CARGO_PKG_VERSION"), words.join(" ")).trim_end().to_owned()
}

/// A bar on standard error, on a terminal only.
fn progress(length: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} files, {eta} left") {
        bar.set_style(style);
    }
    bar
}

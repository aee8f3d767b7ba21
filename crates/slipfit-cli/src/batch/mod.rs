//! Many files at once: one row per file, written as soon as it is done.

mod columns;
mod journal;
mod parquet;
pub(crate) mod resonance;
pub(crate) mod ringdown;
mod table;

use crate::args::{AnswerArgs, TableArgs};
use crate::command::show::{drawn, plot_target};
use crate::failure::{FAILED, Failure, WARNED};
use crate::interrupt::{self, INTERRUPTED};
use crate::output::{self, Outputs};
use crate::progress;
use crate::version;
use anstream::ColorChoice;
use journal::Journal;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use slipfit_report::plot;
use slipfit_report::row::{Column, Row, Status};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use table::{Form, Table};

/// What is done with each file.
pub(crate) struct Task<'a> {
    /// The command, such as `ringdown`.
    pub(crate) command: &'static str,
    /// The files and folders as typed.
    pub(crate) typed: &'a [PathBuf],
    pub(crate) files: &'a [PathBuf],
    /// A reference that is read in addition.
    pub(crate) reference: Option<&'a Path>,
    pub(crate) table: &'a TableArgs,
    pub(crate) out: &'a AnswerArgs,
    pub(crate) columns: &'static [Column],
    /// Everything that changes a row, as text: a table is continued only with the same options.
    pub(crate) options: String,
    pub(crate) one: &'a (dyn Fn(&Path) -> Result<Row, Failure> + Sync),
}

/// Analyses every file; a failure of one does not stop the others.
pub(crate) fn run(task: &Task<'_>, color: ColorChoice) -> Result<ExitCode, Failure> {
    if let Some((flag, _)) = task.out.files().next() {
        return Err(Failure::new(format!("{flag} is for one file, not for a table of several"))
            .hint("a table ending in .json or .parquet holds every row in machine-readable form"));
    }
    let inputs = task.files.iter().map(PathBuf::as_path).chain(task.reference);
    let mut outputs = Outputs::new(task.out.replace.force, inputs)?;
    let plot = plot_target(task.out, &mut outputs)?;
    let (journal, known) = match &task.table.table {
        Some(path) => {
            let table =
                Table { form: Form::of(path)?, columns: task.columns, to: outputs.add("--table", path)? };
            let (journal, rows) = Journal::open(table, &mut outputs, &signature(task), task.table.resume)?;
            (Some(Mutex::new(journal)), rows)
        }
        None => (None, Vec::new()),
    };
    interrupt::enable_graceful_stop()?;
    let known: HashMap<String, Row> = known.into_iter().map(|r| (r.file.clone(), r)).collect();
    let bar = progress::bar(task.files.len() as u64, "{pos}/{len} files", task.out.quiet);
    let rows = task
        .files
        .par_iter()
        .map(|file| {
            if let Some(row) = known.get(&file.display().to_string()) {
                bar.inc(1);
                return Ok(Some(row.clone()));
            }
            if interrupt::stop_requested() {
                return Ok(None);
            }
            let row = one(task, file);
            if let Some(journal) = &journal {
                journal.lock().unwrap_or_else(PoisonError::into_inner).add(&row)?;
            }
            bar.inc(1);
            Ok(Some(row))
        })
        .collect::<Result<Vec<Option<Row>>, Failure>>()?;
    interrupt::begin_completion();
    bar.finish_and_clear();
    let interrupted = rows.iter().any(Option::is_none);
    // Rows were written as they were completed; the table has the order of the files.
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    match journal {
        Some(journal) => {
            let journal = journal.into_inner().unwrap_or_else(PoisonError::into_inner);
            journal.finish(&rows, interrupted)?;
        }
        None => output::print(&table::markdown(&rows), color)?,
    }
    if let Some((target, format)) = &plot {
        let picture = drawn(&plot::files(&rows), *format)?;
        target.write(|out| out.write_all(&picture))?;
    }
    if !task.out.quiet {
        output::print_error(&summary(task, &rows, interrupted), color);
    }
    let count = |status| rows.iter().filter(|r| r.status == status).count();
    let (warned, failed) = (count(Status::Warned), count(Status::Failed));
    Ok(match (failed == rows.len(), task.out.strict && warned + failed > 0) {
        _ if interrupted => ExitCode::from(INTERRUPTED),
        (true, _) => ExitCode::from(FAILED),
        (_, true) => ExitCode::from(WARNED),
        _ => ExitCode::SUCCESS,
    })
}

/// The last line on the screen.
fn summary(task: &Task<'_>, rows: &[Row], interrupted: bool) -> String {
    let count = |status| rows.iter().filter(|r| r.status == status).count();
    let of = if interrupted { format!(" of {}", task.files.len()) } else { String::new() };
    let place = task.table.table.as_deref().map(|p| format!("; {}", p.display())).unwrap_or_default();
    let mut text = format!(
        "{}{of} {}: {} without warnings, {} with warnings, {} failed{place}\n",
        rows.len(),
        if task.files.len() == 1 { "file" } else { "files" },
        count(Status::Done),
        count(Status::Warned),
        count(Status::Failed)
    );
    if interrupted && task.table.table.is_some() {
        text.push_str("interrupted; the same command with --resume continues it\n");
    }
    text
}

/// The row of one file, even if its analysis fails.
fn one(task: &Task<'_>, file: &Path) -> Row {
    match catch_unwind(AssertUnwindSafe(|| (task.one)(file))) {
        Ok(Ok(row)) => row,
        Ok(Err(failure)) => Row::failed(file, &failure.message(), task.columns),
        Err(_) => Row::failed(file, "an error within slipfit: please report this file", task.columns),
    }
}

/// The command line without the files and without what does not change a row, and a fingerprint of everything
/// that does.
fn signature(task: &Task<'_>) -> String {
    let mut words = Vec::new();
    let typed: HashSet<Cow<'_, str>> = task.typed.iter().map(|file| file.to_string_lossy()).collect();
    let mut arguments = version::arguments();
    let mut named = false;
    while let Some(word) = arguments.next() {
        let name = word.split('=').next().unwrap_or_default();
        if ["--table", "--color", "--plot"].contains(&name) {
            if name == word {
                arguments.next();
            }
        } else if !named && word == task.command {
            named = true;
        } else if !["--resume", "--quiet", "-q", "--strict", "--force"].contains(&name)
            && !typed.contains(word.as_str())
        {
            words.push(word);
        }
    }
    let digest = Sha256::digest(task.options.as_bytes());
    let fingerprint: String = digest[..8].iter().map(|byte| format!("{byte:02x}")).collect();
    let words = words.join(" ").replace(['\n', '\r'], " ");
    format!("slipfit {} {} {words} #{fingerprint}", crate::version::long(), task.command).replace("  ", " ")
}

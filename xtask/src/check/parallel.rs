//! Steps that compile the release profile, run in parallel with those that compile the development profile.
//!
//! cargo allows only one command at a time in the build folder of a profile, and the core is compiled on one
//! processor: running the steps one after the other would leave a second processor idle for a third of the time. The
//! parallel steps run in a separate process, so that their output stays together.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode};
use std::time::Duration;

use super::outcome::{Outcome, Row};
use crate::Failure;
use crate::places::target;

/// Flag that names the file to which the rows are written.
pub(super) const FLAG: &str = "--parallel";

/// The process that runs these steps.
pub(super) struct ParallelSteps {
    process: Child,
    /// Output of the process and its commands.
    log: PathBuf,
    rows: PathBuf,
}

impl ParallelSteps {
    pub(super) fn start() -> Result<ParallelSteps, Failure> {
        let folder = target()?.join("check");
        std::fs::create_dir_all(&folder)?;
        let [log, rows] = ["parallel.log", "parallel.rows"].map(|name| folder.join(name));
        let _ = std::fs::remove_file(&rows);
        let out = File::create(&log)?;
        let mut again = Command::new(std::env::current_exe()?);
        again.args(["check", FLAG]).arg(&rows).stdout(out.try_clone()?).stderr(out);
        eprintln!("steps that compile for users run in parallel with the others: {}", log.display());
        Ok(ParallelSteps { process: again.spawn()?, log, rows })
    }

    /// Waits for the process to end and prints its output.
    pub(super) fn finish(mut self) -> Result<Vec<Row>, Failure> {
        let status = self.process.wait()?;
        std::io::copy(&mut File::open(&self.log)?, &mut std::io::stderr())?;
        let text = std::fs::read_to_string(&self.rows)
            .map_err(|_| format!("the parallel steps ended early: {status}"))?;
        text.lines().map(|line| read(line).ok_or_else(|| format!("`{line}` is no row").into())).collect()
    }
}

impl Drop for ParallelSteps {
    /// Stops the process if a failure ends the check early; no effect after it has ended.
    fn drop(&mut self) {
        let _ = self.process.kill();
    }
}

/// The parallel process: runs the steps and writes their rows.
pub(super) fn run(rows: impl Iterator<Item = Row>, path: &str) -> Result<ExitCode, Failure> {
    let rows: Vec<String> = rows.map(|row| written(&row)).collect();
    std::fs::write(Path::new(path), rows.concat())?;
    Ok(ExitCode::SUCCESS)
}

fn written(row: &Row) -> String {
    let (word, note) = match &row.result {
        Ok(Outcome::Passed(note)) => ("passed", note.clone()),
        Ok(Outcome::Skipped(reason)) => ("skipped", reason.clone()),
        Err(failure) => ("failed", failure.to_string()),
    };
    let note = note.replace(['\n', '\t'], " ");
    format!("{}\t{}\t{word}\t{note}\n", row.name, row.time.as_secs_f64())
}

fn read(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.split('\t').collect();
    let &[name, time_s, word, note] = cells.as_slice() else { return None };
    let result = match word {
        "passed" => Ok(Outcome::Passed(note.to_owned())),
        "skipped" => Ok(Outcome::Skipped(note.to_owned())),
        "failed" => Err(note.into()),
        _ => return None,
    };
    let time = Duration::try_from_secs_f64(time_s.parse().ok()?).ok()?;
    Some(Row { name: name.to_owned(), result, time })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_were_written() {
        let results: [Result<Outcome, Failure>; 3] = [
            Ok(Outcome::passed()),
            Ok(Outcome::Skipped("no network".into())),
            Err("exit status: 1\nand\tmore".into()),
        ];
        let notes = ["", "no network", "exit status: 1 and more"];
        for (result, note) in results.into_iter().zip(notes) {
            let row = Row { name: "a step".to_owned(), result, time: Duration::from_millis(2_600) };
            let text = written(&row);
            let again = read(text.strip_suffix('\n').unwrap()).unwrap();
            assert_eq!((again.name.as_str(), again.time), ("a step", row.time));
            let (passed, said) = match &again.result {
                Ok(Outcome::Passed(note)) => (Some(true), note.clone()),
                Ok(Outcome::Skipped(reason)) => (Some(false), reason.clone()),
                Err(failure) => (None, failure.to_string()),
            };
            let before = match &row.result {
                Ok(Outcome::Passed(_)) => Some(true),
                Ok(Outcome::Skipped(_)) => Some(false),
                Err(_) => None,
            };
            assert_eq!(passed, before, "{text}");
            assert_eq!(said, note);
        }
        assert!(read("a step\t2.6\tpassed").is_none());
        assert!(read("a step\tsoon\tpassed\t").is_none());
    }
}

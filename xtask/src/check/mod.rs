//! All checks that must pass before a change is accepted.

mod outcome;
mod parallel;
mod steps;

use std::process::ExitCode;
use std::time::Instant;

use crate::Failure;
use outcome::{Outcome, Profile, Row, Step};
use parallel::ParallelSteps;

/// Runs every step, or those whose names contain a text, regardless of earlier failures, and prints a table.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let begun = Instant::now();
    let rows: Vec<Row> = match arguments {
        [] => {
            let release_steps = ParallelSteps::start()?;
            let mut rows: Vec<Row> = of(Profile::Dev).map(take).collect();
            rows.extend(release_steps.finish()?);
            rows
        }
        [flag, text] if flag == "--only" => {
            steps::ALL.iter().filter(|step| step.name.contains(text.as_str())).map(take).collect()
        }
        [flag, path] if flag == parallel::FLAG => return parallel::run(of(Profile::Release).map(take), path),
        _ => return Err("check takes nothing, or --only TEXT".into()),
    };
    if rows.is_empty() {
        return Err("no step has such a name".into());
    }
    println!("\n{}", table(&rows));
    let failed = rows.iter().filter(|row| row.result.is_err()).count();
    let total_s = begun.elapsed().as_secs_f64();
    if failed == 0 {
        println!("check passed in {total_s:.0} s");
        Ok(ExitCode::SUCCESS)
    } else {
        println!("check FAILED: {failed} of {} steps, {total_s:.0} s", rows.len());
        Ok(ExitCode::FAILURE)
    }
}

fn of(profile: Profile) -> impl Iterator<Item = &'static Step> {
    steps::ALL.iter().filter(move |step| step.profile == profile)
}

fn take(step: &Step) -> Row {
    eprintln!("\n== {} ==", step.name);
    let begun = Instant::now();
    let result = (step.action)();
    match &result {
        Ok(Outcome::Passed(_)) => {}
        Ok(Outcome::Skipped(reason)) => eprintln!("SKIPPED: {reason}"),
        Err(failure) => eprintln!("FAILED: {failure}"),
    }
    Row { name: step.name.to_owned(), result, time: begun.elapsed() }
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<30} {:<7} {:>6}  note\n", "step", "result", "time");
    for row in rows {
        let (word, note) = match &row.result {
            Ok(Outcome::Passed(note)) => ("ok", note.clone()),
            Ok(Outcome::Skipped(reason)) => ("SKIPPED", reason.clone()),
            Err(failure) => ("FAILED", failure.to_string()),
        };
        let line = format!("{:<30} {word:<7} {:>4.0} s  {note}", row.name, row.time.as_secs_f64());
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_table_tells_passed_skipped_and_failed_apart() {
        let row =
            |name: &str, result| Row { name: name.to_owned(), result, time: Duration::from_millis(2_600) };
        let text = table(&[
            row("one", Ok(Outcome::passed())),
            row("two", Ok(Outcome::Skipped("no network".into()))),
            row("three", Err("exit status: 1".into())),
        ]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "one                            ok         3 s");
        assert_eq!(lines[2], "two                            SKIPPED    3 s  no network");
        assert_eq!(lines[3], "three                          FAILED     3 s  exit status: 1");
    }
}

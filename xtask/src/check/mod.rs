//! Everything that must hold before a change goes in.

mod outcome;
mod steps;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use crate::Failure;
use outcome::{Outcome, Step};

struct Row {
    name: &'static str,
    result: Result<Outcome, Failure>,
    time: Duration,
}

/// Runs every step, or those whose names hold a text, whatever became of the earlier ones, and prints a
/// table.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let rows: Vec<Row> = match arguments {
        [] => steps::ALL.iter().map(take).collect(),
        [flag, text] if flag == "--only" => {
            steps::ALL.iter().filter(|(name, _)| name.contains(text.as_str())).map(take).collect()
        }
        _ => return Err("check takes nothing, or --only TEXT".into()),
    };
    if rows.is_empty() {
        return Err("no step has such a name".into());
    }
    println!("\n{}", table(&rows));
    let failed = rows.iter().filter(|row| row.result.is_err()).count();
    let total: Duration = rows.iter().map(|row| row.time).sum();
    let total_s = total.as_secs_f64();
    if failed == 0 {
        println!("check passed in {total_s:.0} s");
        Ok(ExitCode::SUCCESS)
    } else {
        println!("check FAILED: {failed} of {} steps, {total_s:.0} s", rows.len());
        Ok(ExitCode::FAILURE)
    }
}

fn take(&(name, action): &Step) -> Row {
    eprintln!("\n== {name} ==");
    let begun = Instant::now();
    let result = action();
    match &result {
        Ok(Outcome::Passed(_)) => {}
        Ok(Outcome::Skipped(reason)) => eprintln!("SKIPPED: {reason}"),
        Err(failure) => eprintln!("FAILED: {failure}"),
    }
    Row { name, result, time: begun.elapsed() }
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
    use super::*;

    #[test]
    fn the_table_tells_passed_skipped_and_failed_apart() {
        let row = |name, result| Row { name, result, time: Duration::from_millis(2_600) };
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

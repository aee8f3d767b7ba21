//! How a record was read.

use super::facts::Facts;
use crate::format::{instant, percent, plain};
use slipfit::answer::hint::Spelling;
use slipfit::{ClockReport, SignalKind};
use slipfit_io::{ColumnTaken, ReadReport, Reading, TimeSource};
use std::fmt::Write as _;

/// How a file that is not analysed would be read.
pub(crate) fn record(reading: &Reading, spell: Spelling<'_>) -> Facts {
    let (record, report) = (&reading.record, &reading.report);
    let mut facts = Facts::default();
    facts.add("read", rows_read(report, spell));
    columns_taken(&mut facts, report);
    let mut rate = format!(
        "{} over {}",
        plain(1.0 / record.clock_report().median_step_s, 5, "Hz"),
        plain(record.duration_s(), 4, "s")
    );
    if let Some(clock) = clock(record.clock_report()) {
        let _ = write!(rate, "; {clock}");
    }
    facts.add("clock", rate);
    facts.notes(&report.notes, spell);
    facts
}

/// `1 row`, `2 rows`.
pub(crate) fn counted(n: u64, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}

pub(super) fn columns_taken(facts: &mut Facts, report: &ReadReport) {
    facts.add("time", time_source(report.time.as_ref()));
    facts.add("signal", signal_source(report));
    if let Some(q) = report.column("quadrature") {
        facts.add("", column(q));
    }
}

pub(super) fn rows_read(report: &ReadReport, spell: Spelling<'_>) -> String {
    let mut text = counted(report.rows_read, "row");
    if !report.skipped.is_empty() {
        let reasons: Vec<String> = report.skipped.iter().map(ToString::to_string).collect();
        let _ = write!(text, "; skipped {}", reasons.join("; "));
    }
    let mut choice = Vec::new();
    if report.parts > 1 {
        choice.push(format!("table {} of {} ({})", report.part, report.parts, spell("part", None)));
    }
    if report.runs > 1 {
        choice.push(format!("run {} of {} ({})", report.run, report.runs, spell("run", None)));
    }
    if !choice.is_empty() {
        let _ = write!(text, "; {}", choice.join(", "));
    }
    text
}

pub(super) fn column(taken: &ColumnTaken) -> String {
    if taken.unit.is_empty() { taken.why.clone() } else { format!("{}; in {}", taken.why, taken.unit) }
}

fn time_source(source: Option<&TimeSource>) -> String {
    match source {
        Some(TimeSource::Column(taken)) => column(taken),
        Some(TimeSource::Intervals(taken)) => format!("{}, summed", column(taken)),
        Some(TimeSource::Rate(rate)) => format!("{} samples per second", plain(*rate, 6, "")),
        _ => "as the file says".to_owned(),
    }
}

fn signal_source(report: &ReadReport) -> String {
    let kind = match report.kind {
        SignalKind::Displacement => "displacement or angle",
        SignalKind::Velocity => "velocity",
        SignalKind::Acceleration => "acceleration",
        SignalKind::Envelope => "amplitude",
        SignalKind::LockIn => "X of a lock-in",
        _ => "signal",
    };
    let signal = report.column("signal").map(column).unwrap_or_default();
    format!("{signal}; taken as {kind}")
}

/// Remarks on the clock, if there are any.
pub(super) fn clock(report: &ClockReport) -> Option<String> {
    let mut said = Vec::new();
    let mut count = |n: usize, what: &str| {
        if n > 0 {
            said.push(format!("{n} {what}"));
        }
    };
    count(report.nonfinite(), "rows without a number left out");
    count(report.corrupt_stamps, "rows with a corrupt stamp left out");
    count(report.reordered, "rows sorted");
    count(report.repeated_stamps, "repeated stamps");
    if let Some(period_s) = report.wrap_period_s {
        let times = counted(report.wraps as u64, "time");
        said.push(format!("restarts every {} and was continued, {times}", plain(period_s, 10, "s")));
    }
    if report.resets > 0 {
        let resets = counted(report.resets as u64, "reset");
        said.push(format!("{resets}: {} rows of other runs left out", report.other_run_rows));
    }
    if let Some(quantum) = report.rebuilt_quantum_s {
        said.push(format!("uniform clock rebuilt from stamps rounded to {}", plain(quantum, 2, "s")));
    }
    if let Some(samples) = report.burst_samples {
        said.push(format!(
            "bursts of {samples} samples under one stamp each, spaced evenly between the stamps"
        ));
    }
    if let Some(gap) = &report.longest_gap {
        said.push(format!(
            "{} of {} at {}",
            if report.gaps == 1 { "1 gap".to_owned() } else { format!("{} gaps, the longest", report.gaps) },
            plain(gap.length_s, 3, "s"),
            instant(gap.start_s, 100.0 * gap.length_s)
        ));
    }
    if report.step_spread > 0.02 {
        said.push(format!("steps vary by {}", percent(report.step_spread)));
    }
    (!said.is_empty()).then(|| said.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_a_thing_is_singular() {
        assert_eq!([counted(1, "row"), counted(2, "row")], ["1 row", "2 rows"]);
    }

    #[test]
    fn an_ordinary_clock_needs_no_words() {
        assert_eq!(clock(&ClockReport::default()), None);
    }
}

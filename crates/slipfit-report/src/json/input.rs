//! What was read and how, for the JSON answer.

use super::object::object;
use crate::{AnalysedLevels, AnalysedRingdown};
use serde::{Serialize, Serializer};
use slipfit::resonance::RunDirection;
use slipfit::{Quantity, Record};
use slipfit_io::{ColumnInfo, ColumnTaken, DrivenRecord, Note, ReadReport, SweepReading, TimeSource};

object! {
    /// The record of a ring-down.
    pub(super) struct RecordInput<'a> of analysed: &AnalysedRingdown<'a> {
        /// The file as named by the caller.
        path: String = analysed.file.display().to_string(),
        #[serde(flatten)]
        rows: Rows<'a> = Rows::new(&analysed.reading.report),
        /// The table read, from 1.
        table: usize = analysed.reading.report.part,
        /// Number of tables side by side.
        tables: usize = analysed.reading.report.parts,
        /// The run read, from 1.
        run: usize = analysed.reading.report.run,
        /// Number of runs, in groups of columns or one after the other.
        runs: usize = analysed.reading.report.runs,
        /// Where the times come from.
        time: Time<'a> = Time::new(analysed.reading.report.time.as_ref()),
        /// The signal.
        signal: Option<Taken<'a>> = analysed.reading.report.column("signal").map(Taken::new),
        /// The Y output of a lock-in; null without one.
        quadrature: Option<Taken<'a>> = analysed.reading.report.column("quadrature").map(Taken::new),
        /// What the signal is.
        #[cfg_attr(test, schemars(extend("enum" = KINDS)))]
        kind: &'static str = analysed.reading.report.kind.name(),
        /// Unit of the signal; empty if unknown.
        unit: &'a str = analysed.reading.record.unit(),
        /// Number of samples of the record.
        samples: usize = analysed.reading.record.len(),
        /// First and last time of the record, s.
        time_range_s: [f64; 2] = time_range(&analysed.reading.record),
        /// First and last time used, s.
        time_range_used_s: [f64; 2] = [analysed.answer.segment.start_s, analysed.answer.segment.end_s],
        /// How the clock was cleaned.
        clock: Clock = Clock::new(&analysed.reading.record),
        /// Other remarks for the reader.
        notes: Vec<String> = notes(&analysed.reading.report.notes),
    }
}

object! {
    /// A resonance curve.
    pub(super) struct CurveInput<'a> of reading: &'a SweepReading {
        /// The file or folder as named by the caller.
        path: &'a str = &reading.report.path,
        #[serde(flatten)]
        rows: Rows<'a> = Rows::new(&reading.report),
        /// Sheet, variable or group; empty if there is only one.
        sheet: &'a str = &reading.report.sheet,
        /// The curve read, from 1.
        run: usize = reading.report.run,
        /// Number of curves in groups of columns.
        runs: usize = reading.report.runs,
        /// The columns read, keyed by their role.
        #[cfg_attr(test, schemars(with = "std::collections::BTreeMap<String, Taken<'_>>"))]
        taken: TakenByName<'a> = TakenByName(&reading.report.taken),
        /// What the response is.
        #[cfg_attr(test, schemars(extend("enum" = KINDS)))]
        kind: &'static str = reading.report.kind.name(),
        /// Unit of the amplitudes.
        unit: &'a str = reading.curve.unit(),
        /// Number of points of the curve.
        points: usize = reading.curve.len(),
        /// Whether it has phases.
        has_phase: bool = reading.curve.is_complex(),
        /// Lowest and highest frequency, Hz.
        frequency_range_hz: [f64; 2] = ends(reading.curve.frequency_hz()),
        /// Runs of the sweep up and down.
        sweeps: Vec<Sweep> = reading.curve.runs().iter().map(Sweep::new).collect(),
        /// Driven records demodulated to points; empty for a curve.
        records: Vec<Demodulated<'a>> = reading.report.records.iter().map(Demodulated::new).collect(),
        /// Files of a folder that were not driven records.
        files_left_out: usize = reading.report.files_left_out,
        /// Other remarks for the reader.
        notes: Vec<String> = notes(&reading.report.notes),
    }
}

object! {
    /// A part of a curve measured in one direction.
    struct Sweep of run: &slipfit::resonance::Run {
        /// Index of its first point.
        first: usize = run.first,
        /// Number of its points.
        points: usize = run.points,
        /// Direction in which the frequency moved.
        direction: RunDirection = run.direction,
    }
}

object! {
    /// A driven record that became a point of a curve.
    struct Demodulated<'a> of run: &'a DrivenRecord {
        /// The file.
        path: &'a str = &run.path,
        /// SHA-256 of its bytes.
        sha256: &'a str = &run.sha256,
        /// Number of its samples.
        samples: usize = run.samples,
        /// Frequency of the drive.
        frequency_hz: &'a Quantity = &run.steady.frequency_hz,
        /// Amplitude of the fundamental.
        amplitude: &'a Quantity = &run.steady.amplitude,
        /// Its phase relative to the drive; null without a recorded drive.
        phase_rad: Option<&'a Quantity> = run.steady.phase_rad.as_ref(),
        /// Amplitude of the drive; null if it was not recorded.
        drive_amplitude: Option<&'a Quantity> = run.steady.drive_amplitude.as_ref(),
        /// Root-mean-square wander of the frequency.
        frequency_wander_hz: f64 = run.steady.frequency_wander_hz,
        /// Length of the transient left out.
        transient_s: f64 = run.steady.transient_s,
        /// Beginning and end of the part used.
        time_range_used_s: [f64; 2] = [run.steady.start_s, run.steady.end_s],
        /// Number of cycles in it.
        cycles: f64 = run.steady.cycles,
        /// Whether amplitude and phase had settled.
        settled: bool = run.steady.settled,
        /// Root mean square of the residuals after fundamental, harmonics, offset and drift.
        residual_rms: f64 = run.steady.residual_rms,
    }
}

object! {
    /// Drive levels.
    pub(super) struct LevelsInput<'a> of analysed: &AnalysedLevels<'a> {
        /// The file as named by the caller.
        path: &'a str = &analysed.reading.report.path,
        #[serde(flatten)]
        rows: Rows<'a> = Rows::new(&analysed.reading.report),
        /// The columns read, keyed by their role.
        #[cfg_attr(test, schemars(with = "std::collections::BTreeMap<String, Taken<'_>>"))]
        taken: TakenByName<'a> = TakenByName(&analysed.reading.report.taken),
        /// Unit of the amplitudes.
        unit: &'a str = &analysed.answer.unit,
        /// Unit of the drive levels.
        drive_unit: &'a str = &analysed.answer.drive_unit,
        /// Other remarks for the reader.
        notes: Vec<String> = notes(&analysed.reading.report.notes),
    }
}

fn time_range(record: &Record) -> [f64; 2] {
    [record.time_s(0), record.time_s(record.len() - 1)]
}

/// The lowest and the highest.
fn ends(values: &[f64]) -> [f64; 2] {
    let all = || values.iter().copied();
    [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
}

/// Remarks, with options under their own names.
fn notes(notes: &[Note]) -> Vec<String> {
    notes.iter().map(ToString::to_string).collect()
}

object! {
    /// The bytes of a file, its rows and columns.
    struct Rows<'a> of report: &'a ReadReport {
        /// SHA-256 of its bytes.
        #[cfg_attr(test, schemars(extend("pattern" = "^[0-9a-f]{64}$")))]
        sha256: &'a str = &report.sha256,
        /// Number of bytes.
        bytes: u64 = report.bytes,
        /// Rows read as samples, points, levels or records.
        rows_read: u64 = report.rows_read,
        /// Rows that gave none of these.
        rows_skipped: u64 = report.rows_skipped(),
        /// The skipped rows, by reason.
        skipped: Vec<Skipped<'a>> = report.skipped.iter().map(Skipped::new).collect(),
        /// All columns of the table.
        columns: Vec<Column<'a>> = report.columns.iter().map(Column::new).collect(),
    }
}

object! {
    /// Rows skipped for one reason.
    struct Skipped<'a> of skipped: &'a slipfit_io::Skipped {
        /// The reason.
        reason: &'a str = &skipped.reason,
        /// Number of rows.
        rows: u64 = skipped.rows,
        /// Line of the file where it first happened, from 1.
        first_row: u64 = skipped.first_row,
    }
}

object! {
    /// A column of the file.
    struct Column<'a> of column: &'a ColumnInfo {
        /// Its number, from 1.
        number: usize = column.number,
        /// Its header; empty without one.
        header: &'a str = &column.header,
        /// The unit in its header; empty without one.
        unit: &'a str = &column.unit,
    }
}

object! {
    /// A column that was read.
    struct Taken<'a> of taken: &'a ColumnTaken {
        /// Its number, from 1.
        number: usize = taken.column.number,
        /// Its header.
        header: &'a str = &taken.column.header,
        /// Unit assumed for its numbers; empty if unknown.
        unit: &'a str = &taken.unit,
        /// Why this column was chosen.
        why: &'a str = &taken.why,
    }
}

/// Columns that were read, keyed by their role.
struct TakenByName<'a>(&'a [(&'static str, ColumnTaken)]);

impl Serialize for TakenByName<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(what, taken)| (what, Taken::new(taken))))
    }
}

/// Where the times come from.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Time<'a> {
    /// `column`, `intervals` (times since the previous sample) or `rate`.
    #[cfg_attr(test, schemars(extend("enum" = ["column", "intervals", "rate", "other"])))]
    source: &'static str,
    /// The column; null for a rate.
    column: Option<Taken<'a>>,
    /// Samples per second; null for a column.
    rate_hz: Option<f64>,
}

impl<'a> Time<'a> {
    fn new(source: Option<&'a TimeSource>) -> Self {
        let (source, column, rate_hz) = match source {
            Some(TimeSource::Column(c)) => ("column", Some(Taken::new(c)), None),
            Some(TimeSource::Intervals(c)) => ("intervals", Some(Taken::new(c)), None),
            Some(TimeSource::Rate(rate)) => ("rate", None, Some(*rate)),
            _ => ("other", None, None),
        };
        Self { source, column, rate_hz }
    }
}

object! {
    /// How a clock was cleaned.
    struct Clock of record: &Record {
        /// Whether the samples are evenly spaced.
        uniform: bool = record.clock().is_uniform(),
        /// Median time between samples.
        median_step_s: f64 = record.clock_report().median_step_s,
        /// Spread of the steps relative to their median.
        step_spread: f64 = record.clock_report().step_spread,
        /// Rows left out because a number is missing.
        nonfinite_rows: usize = record.clock_report().nonfinite(),
        /// Number of time stamps that occur more than once.
        repeated_stamps: usize = record.clock_report().repeated_stamps,
        /// Number of rows sorted into order.
        reordered_rows: usize = record.clock_report().reordered,
        /// Rows left out because of a corrupt time stamp.
        corrupt_stamps: usize = record.clock_report().corrupt_stamps,
        /// Number of times that a counter restarted at zero while the motion went on, and was unwrapped.
        wraps: usize = record.clock_report().wraps,
        /// Period of that counter; null if it did not wrap.
        wrap_period_s: Option<f64> = record.clock_report().wrap_period_s,
        /// Number of times that the clock started anew.
        resets: usize = record.clock_report().resets,
        /// Rows of other runs that were left out.
        other_run_rows: usize = record.clock_report().other_run_rows,
        /// Number of gaps.
        gaps: usize = record.clock_report().gaps,
        /// The longest gap; null if there is none.
        longest_gap_s: Option<f64> = record.clock_report().longest_gap.map(|g| g.length_s),
        /// Rounding of the time stamps from which a uniform clock was rebuilt; null if none was rebuilt.
        rebuilt_quantum_s: Option<f64> = record.clock_report().rebuilt_quantum_s,
        /// Half width of the range of rates compatible with the stamps of a rebuilt clock, relative to the rate;
        /// 0 if no clock was rebuilt.
        rebuilt_rate_error: f64 = record.clock_report().rebuilt_rate_error,
        /// Usual number of samples that share one time stamp and were spread evenly between the stamps; null if
        /// each sample has its own.
        burst_samples: Option<usize> = record.clock_report().burst_samples,
    }
}

#[cfg(test)]
const KINDS: [&str; 6] = ["displacement", "velocity", "acceleration", "envelope", "lock-in", "other"];

//! What was read and how, for the JSON answer.

use crate::{AnalysedLevels, AnalysedRingdown};
use serde::{Serialize, Serializer};
use slipfit::resonance::RunDirection;
use slipfit::{ClockReport, Quantity, SignalKind};
use slipfit_io::{ColumnInfo, ColumnTaken, DrivenRecord, Note, ReadReport, SweepReading, TimeSource};

/// The record of a ring-down.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RecordInput<'a> {
    /// The file as named by the caller.
    path: String,
    /// SHA-256 of its bytes.
    #[cfg_attr(test, schemars(extend("pattern" = "^[0-9a-f]{64}$")))]
    sha256: &'a str,
    /// Its length.
    bytes: u64,
    /// Rows read as samples.
    rows_read: u64,
    /// Rows that gave no sample.
    rows_skipped: u64,
    /// The skipped rows, by reason.
    skipped: Vec<Skipped<'a>>,
    /// All columns of the table.
    columns: Vec<Column<'a>>,
    /// The table read, from 1.
    table: usize,
    /// Tables side by side.
    tables: usize,
    /// The run read, from 1.
    run: usize,
    /// Runs in groups of columns.
    runs: usize,
    /// Where the times come from.
    time: Time<'a>,
    /// The signal.
    signal: Option<Taken<'a>>,
    /// The Y output of a lock-in; null without.
    quadrature: Option<Taken<'a>>,
    /// What the signal is.
    #[cfg_attr(test, schemars(extend("enum" = ["displacement", "velocity", "acceleration", "envelope", "lock-in", "other"])))]
    kind: &'static str,
    /// Unit of the signal; empty if unknown.
    unit: &'a str,
    /// Samples of the record.
    samples: usize,
    /// First and last instant of the record, s.
    time_range_s: [f64; 2],
    /// First and last instant used, s.
    time_range_used_s: [f64; 2],
    /// How the clock was cleaned.
    clock: Clock,
    /// Whatever else a reader should know.
    notes: Vec<String>,
}

impl<'a> RecordInput<'a> {
    pub(super) fn new(analysed: &AnalysedRingdown<'a>) -> Self {
        let report: &ReadReport = &analysed.reading.report;
        let record = &analysed.reading.record;
        Self {
            path: analysed.file.display().to_string(),
            sha256: &report.sha256,
            bytes: report.bytes,
            rows_read: report.rows_read,
            rows_skipped: report.rows_skipped(),
            skipped: Skipped::list(&report.skipped),
            columns: Column::list(&report.columns),
            table: report.part,
            tables: report.parts,
            run: report.run,
            runs: report.runs,
            time: Time::new(report.time.as_ref()),
            signal: report.column("signal").map(Taken::new),
            quadrature: report.column("quadrature").map(Taken::new),
            kind: kind(report.kind),
            unit: record.unit(),
            samples: record.len(),
            time_range_s: [record.time_s(0), record.time_s(record.len() - 1)],
            time_range_used_s: [analysed.answer.segment.start_s, analysed.answer.segment.end_s],
            clock: Clock::new(record.clock_report(), record.clock().is_uniform()),
            notes: notes(&report.notes),
        }
    }
}

/// A resonance curve.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct CurveInput<'a> {
    /// The file or folder as named by the caller.
    path: &'a str,
    /// SHA-256 of its bytes.
    sha256: &'a str,
    /// Its length.
    bytes: u64,
    /// Sheet, variable or group; empty where there is one only.
    sheet: &'a str,
    /// Rows or records read.
    rows_read: u64,
    /// Rows that gave no point.
    rows_skipped: u64,
    /// The skipped rows, by reason.
    skipped: Vec<Skipped<'a>>,
    /// All columns of the table.
    columns: Vec<Column<'a>>,
    /// The curve read, from 1.
    run: usize,
    /// Curves in groups of columns.
    runs: usize,
    /// The columns read, by what they are.
    #[cfg_attr(test, schemars(with = "std::collections::BTreeMap<String, Taken<'_>>"))]
    taken: TakenByName<'a>,
    /// What the response is.
    #[cfg_attr(test, schemars(extend("enum" = ["displacement", "velocity", "acceleration", "envelope", "lock-in", "other"])))]
    kind: &'static str,
    /// Unit of the amplitudes.
    unit: &'a str,
    /// Points of the curve.
    points: usize,
    /// Whether it has phases.
    has_phase: bool,
    /// Lowest and highest frequency, Hz.
    frequency_range_hz: [f64; 2],
    /// Runs of the sweep up and down.
    sweeps: Vec<Sweep>,
    /// Driven records demodulated to points; empty for a curve.
    records: Vec<Demodulated<'a>>,
    /// Files of a folder that were no driven record.
    files_left_out: usize,
    /// Whatever else a reader should know.
    notes: Vec<String>,
}

impl<'a> CurveInput<'a> {
    pub(super) fn new(reading: &'a SweepReading) -> Self {
        let (report, curve) = (&reading.report, &reading.curve);
        let hz = || curve.frequency_hz().iter().copied();
        let sweep =
            |r: &slipfit::resonance::Run| Sweep { first: r.first, points: r.points, direction: r.direction };
        Self {
            path: &report.path,
            sha256: &report.sha256,
            bytes: report.bytes,
            sheet: &report.sheet,
            rows_read: report.rows_read,
            rows_skipped: report.rows_skipped(),
            skipped: Skipped::list(&report.skipped),
            columns: Column::list(&report.columns),
            run: report.run,
            runs: report.runs,
            taken: TakenByName(&report.taken),
            kind: kind(report.kind),
            unit: curve.unit(),
            points: curve.len(),
            has_phase: curve.is_complex(),
            frequency_range_hz: [hz().fold(f64::INFINITY, f64::min), hz().fold(f64::NEG_INFINITY, f64::max)],
            sweeps: curve.runs().iter().map(sweep).collect(),
            records: report.records.iter().map(Demodulated::new).collect(),
            files_left_out: report.files_left_out,
            notes: notes(&report.notes),
        }
    }
}

/// A part of a curve measured one way.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Sweep {
    /// Index of its first point.
    first: usize,
    /// Its points.
    points: usize,
    /// Which way the frequency went.
    direction: RunDirection,
}

/// A driven record that became a point of a curve.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Demodulated<'a> {
    /// The file.
    path: &'a str,
    /// SHA-256 of its bytes.
    sha256: &'a str,
    /// Its samples.
    samples: usize,
    /// Frequency of the drive.
    frequency_hz: &'a Quantity,
    /// Amplitude of the fundamental.
    amplitude: &'a Quantity,
    /// Its phase against the drive; null without a recorded drive.
    phase_rad: Option<&'a Quantity>,
    /// Amplitude of the drive; null where it was not recorded.
    drive_amplitude: Option<&'a Quantity>,
    /// How far the frequency wandered, root mean square.
    frequency_wander_hz: f64,
    /// Length of the transient left out.
    transient_s: f64,
    /// Beginning and end of the part used.
    time_range_used_s: [f64; 2],
    /// Cycles in it.
    cycles: f64,
    /// Whether amplitude and phase had settled.
    settled: bool,
    /// What fundamental, harmonics, offset and drift leave.
    residual_rms: f64,
}

impl<'a> Demodulated<'a> {
    fn new(run: &'a DrivenRecord) -> Self {
        let s = &run.steady;
        Self {
            path: &run.path,
            sha256: &run.sha256,
            samples: run.samples,
            frequency_hz: &s.frequency_hz,
            amplitude: &s.amplitude,
            phase_rad: s.phase_rad.as_ref(),
            drive_amplitude: s.drive_amplitude.as_ref(),
            frequency_wander_hz: s.frequency_wander_hz,
            transient_s: s.transient_s,
            time_range_used_s: [s.start_s, s.end_s],
            cycles: s.cycles,
            settled: s.settled,
            residual_rms: s.residual_rms,
        }
    }
}

/// Drive levels.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct LevelsInput<'a> {
    /// The file as named by the caller.
    path: &'a str,
    /// SHA-256 of its bytes.
    sha256: &'a str,
    /// Its length.
    bytes: u64,
    /// Rows read.
    rows_read: u64,
    /// Rows without a level or an amplitude.
    rows_skipped: u64,
    /// The skipped rows, by reason.
    skipped: Vec<Skipped<'a>>,
    /// All columns of the table.
    columns: Vec<Column<'a>>,
    /// The columns read, by what they are.
    #[cfg_attr(test, schemars(with = "std::collections::BTreeMap<String, Taken<'_>>"))]
    taken: TakenByName<'a>,
    /// Unit of the amplitudes.
    unit: &'a str,
    /// Unit of the drive levels.
    drive_unit: &'a str,
    /// Whatever else a reader should know.
    notes: Vec<String>,
}

impl<'a> LevelsInput<'a> {
    pub(super) fn new(analysed: &AnalysedLevels<'a>) -> Self {
        let report = &analysed.reading.report;
        Self {
            path: &report.path,
            sha256: &report.sha256,
            bytes: report.bytes,
            rows_read: report.rows_read,
            rows_skipped: report.rows_skipped(),
            skipped: Skipped::list(&report.skipped),
            columns: Column::list(&report.columns),
            taken: TakenByName(&report.taken),
            unit: &analysed.answer.unit,
            drive_unit: &analysed.answer.drive_unit,
            notes: notes(&report.notes),
        }
    }
}

/// Remarks, with options by their names.
fn notes(notes: &[Note]) -> Vec<String> {
    notes.iter().map(ToString::to_string).collect()
}

/// Rows skipped for one reason.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Skipped<'a> {
    /// The reason.
    reason: &'a str,
    /// How many rows.
    rows: u64,
    /// Line of the file where it first happened, from 1.
    first_row: u64,
}

impl<'a> Skipped<'a> {
    fn list(skipped: &'a [slipfit_io::Skipped]) -> Vec<Self> {
        let one =
            |s: &'a slipfit_io::Skipped| Self { reason: &s.reason, rows: s.rows, first_row: s.first_row };
        skipped.iter().map(one).collect()
    }
}

/// A column of the file.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Column<'a> {
    /// From 1.
    number: usize,
    /// Its header; empty without one.
    header: &'a str,
    /// The unit in its header; empty without one.
    unit: &'a str,
}

impl<'a> Column<'a> {
    fn list(columns: &'a [ColumnInfo]) -> Vec<Self> {
        columns.iter().map(|c| Self { number: c.number, header: &c.header, unit: &c.unit }).collect()
    }
}

/// A column that was read.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Taken<'a> {
    /// From 1.
    number: usize,
    /// Its header.
    header: &'a str,
    /// Unit its numbers were taken to have; empty if unknown.
    unit: &'a str,
    /// Why this column.
    why: &'a str,
}

impl<'a> Taken<'a> {
    fn new(taken: &'a ColumnTaken) -> Self {
        Self { number: taken.column.number, header: &taken.column.header, unit: &taken.unit, why: &taken.why }
    }
}

/// Columns that were read, by what they are.
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
    /// `column`, `intervals` (times since the sample before) or `rate`.
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

/// How a clock was cleaned.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Clock {
    /// Whether the samples are evenly spaced.
    uniform: bool,
    /// Usual time between samples.
    median_step_s: f64,
    /// Spread of the steps relative to it.
    step_spread: f64,
    /// Rows left out because a number is missing.
    nonfinite_rows: usize,
    /// Stamps that occur more than once.
    repeated_stamps: usize,
    /// Rows put in order.
    reordered_rows: usize,
    /// Rows left out because of a corrupt stamp.
    corrupt_stamps: usize,
    /// Times at which the clock began anew.
    resets: usize,
    /// Rows of other runs left out.
    other_run_rows: usize,
    /// Gaps.
    gaps: usize,
    /// The longest one; null without.
    longest_gap_s: Option<f64>,
    /// Rounding of the stamps from which a uniform clock was rebuilt; null where it was not.
    rebuilt_quantum_s: Option<f64>,
}

impl Clock {
    fn new(report: &ClockReport, uniform: bool) -> Self {
        Self {
            uniform,
            median_step_s: report.median_step_s,
            step_spread: report.step_spread,
            nonfinite_rows: report.nonfinite(),
            repeated_stamps: report.repeated_stamps,
            reordered_rows: report.reordered,
            corrupt_stamps: report.corrupt_stamps,
            resets: report.resets,
            other_run_rows: report.other_run_rows,
            gaps: report.gaps,
            longest_gap_s: report.longest_gap.map(|g| g.length_s),
            rebuilt_quantum_s: report.rebuilt_quantum_s,
        }
    }
}

fn kind(kind: SignalKind) -> &'static str {
    match kind {
        SignalKind::Displacement => "displacement",
        SignalKind::Velocity => "velocity",
        SignalKind::Acceleration => "acceleration",
        SignalKind::Envelope => "envelope",
        SignalKind::LockIn => "lock-in",
        _ => "other",
    }
}

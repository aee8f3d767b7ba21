//! Driven records, one file per frequency, demodulated to a curve.

use std::path::{Path, PathBuf};

use sha2::Digest as _;
use slipfit::{
    SignalKind,
    motion::steady::Phasor,
    resonance::Curve,
    signal::demodulate::{self, SteadyMotion},
};

use super::{open::Origin, record};
use crate::{
    columns::{head::Head, role::Role},
    error::{OptionProblem, ReadError, ReadProblem},
    hashing::hexadecimal,
    options::ReadOptions,
    report::{ColumnTaken, DrivenRecord, Note, ReadReport, Reading, SweepReading, TimeSource},
};

/// Files of a folder in the order of their names, without hidden ones.
pub(crate) fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut list = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let hidden = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
        if path.is_file() && !hidden {
            list.push(path);
        }
    }
    list.sort();
    Ok(list)
}

/// Reads and demodulates the records of `files`; `name` identifies them all.
pub(super) fn read(files: &[PathBuf], name: &str, options: &ReadOptions) -> Result<SweepReading, ReadError> {
    options.check_for_driven_records().map_err(|problem| ReadError::new(name, problem))?;
    let (mut records, mut refused): (Vec<DrivenRecord>, Vec<String>) = (Vec::new(), Vec::new());
    let mut first: Option<One> = None;
    let mut others: Vec<Note> = Vec::new();
    for path in files {
        match one(path, options) {
            Ok(mut one) => {
                records.push(one.record.clone());
                match &first {
                    None => first = Some(one),
                    Some(held) if held.report.taken != one.report.taken || held.unit != one.unit => {
                        let why: Vec<String> =
                            one.report.taken.drain(..).map(|(_, taken)| taken.why).collect();
                        let why = why.join("; ");
                        let path = one.record.path;
                        others.push(
                            format!("{path}: other columns were taken than in the first file: {why}").into(),
                        );
                    }
                    Some(_) => {}
                }
            }
            Err(error) => refused.push(error.to_string()),
        }
    }
    let Some(One { unit, mut report, .. }) = first else {
        let first = refused.into_iter().next().unwrap_or_default();
        return Err(ReadError::new(name, ReadProblem::NoDrivenRecords { files: files.len(), first }));
    };
    report.notes = refused.iter().map(|r| format!("left out: {r}").into()).collect();
    report.notes.append(&mut others);
    report.notes.extend(unsteady(&records));
    let phased = records.iter().all(|r| r.steady.phase_rad.is_some());
    if !phased {
        let text = "not every record has a drive that oscillates: only amplitudes were used";
        report.notes.push(Note::new(text).hint("drive", "names its column"));
    }
    let curve = curve(&records, phased, &unit).map_err(|e| ReadError::new(name, ReadProblem::Data(e)))?;
    name.clone_into(&mut report.path);
    report.sha256 = combined(&records);
    report.rows_read = records.len() as u64;
    (report.files_left_out, report.records) = (refused.len(), records);
    Ok(SweepReading { curve, report })
}

/// A file that was read: its motion, the unit of its response, and its report in the form for a curve.
struct One {
    record: DrivenRecord,
    unit: String,
    report: ReadReport,
}

fn one(path: &Path, options: &ReadOptions) -> Result<One, ReadError> {
    let read = |options: &ReadOptions| {
        let (origin, name) = Origin::file(path)?;
        record::read(origin, &name, options, None)
    };
    let plain = ReadOptions { signal: options.amplitude.clone(), kind: None, ..options.clone() };
    let alone = read(&plain)?;
    let refuse = |problem| ReadError::new(&alone.report.path, problem);
    let head = Head::of(alone.report.columns.iter().map(|c| &c.header));
    let response = alone.report.column("signal").cloned();
    let Some(response) = response else { return Err(refuse(ReadProblem::Empty)) };
    let drive = drive(&alone, &head, &response, options).map_err(refuse)?;
    let reading = match &drive {
        Some((index, _)) => read(&ReadOptions {
            signal: Some(response.column.number.to_string()),
            quadrature: Some((index + 1).to_string()),
            kind: Some(SignalKind::LockIn),
            unit: None,
            ..plain
        })?,
        None => alone.clone(),
    };
    let record = &reading.record;
    let steady = steady(record).map_err(|e| refuse(ReadProblem::Data(e)))?;
    let drive = drive.map(|(index, why)| {
        let column = head.info(index);
        let why = format!("{}: {why}", head.label(index));
        ("drive", ColumnTaken { why, unit: column.unit.clone(), column })
    });
    let taken = [Some(("response", response)), drive].into_iter().flatten().collect();
    let samples = record.len();
    let report = ReadReport {
        taken,
        kind: SignalKind::Displacement,
        columns: head.infos(),
        rows_read: 0,
        skipped: Vec::new(),
        time: None,
        parts: 1,
        part: 1,
        runs: 1,
        run: 1,
        notes: Vec::new(),
        ..alone.report
    };
    let ReadReport { path, sha256, .. } = reading.report;
    let unit = alone.record.unit().to_owned();
    Ok(One { record: DrivenRecord { path, sha256, samples, steady }, unit, report })
}

fn steady(record: &slipfit::Record) -> Result<SteadyMotion, slipfit::Error> {
    let time_s = record.times_s(0..record.len());
    let options = demodulate::Options::default();
    demodulate::demodulate(&time_s, record.signal(), record.quadrature(), &options)
}

/// The drive column, and the reason for choosing it.
fn drive(
    reading: &Reading,
    head: &Head,
    response: &ColumnTaken,
    options: &ReadOptions,
) -> Result<Option<(usize, &'static str)>, ReadProblem> {
    let all = head.all();
    if let Some(wanted) = &options.drive {
        let index = head.find("drive", wanted, &all)?;
        if index + 1 == response.column.number {
            let problem = OptionProblem::SameColumn { column: head.label(index), other: "response" };
            return Err(ReadProblem::Option { option: "drive", value: wanted.clone(), problem });
        }
        return Ok(Some((index, "asked for")));
    }
    let time = match &reading.report.time {
        Some(TimeSource::Column(t) | TimeSource::Intervals(t)) => t.column.number,
        _ => 0,
    };
    let response = response.column.number;
    let others: Vec<usize> = all.into_iter().filter(|i| i + 1 != time && i + 1 != response).collect();
    let role = |i: usize| Role::in_curve(&head.names[i]);
    if let Some(index) = others.iter().copied().find(|&i| role(i) == Role::Drive) {
        return Ok(Some((index, "named like a drive")));
    }
    // A voltage next to an angle or a position is the signal of the exciter.
    let rank = |i: usize| match Role::in_record(&head.names[i]) {
        Role::Signal { rank, .. } => Some(rank),
        _ => None,
    };
    let electrical = |i: &usize| rank(*i) == Some(70) && rank(response - 1).is_some_and(|r| r > 70);
    if let Some(index) = others.iter().copied().find(electrical) {
        return Ok(Some((index, "a measured signal next to the response")));
    }
    let unnamed = head.names.iter().all(|n| n.header.is_empty());
    match others[..] {
        [only] if unnamed || role(only) == Role::Unknown => Ok(Some((only, "the only column left"))),
        _ => Ok(None),
    }
}

fn curve(records: &[DrivenRecord], phased: bool, unit: &str) -> Result<Curve, slipfit::Error> {
    let frequency_hz = records.iter().map(|r| r.steady.frequency_hz.value).collect();
    let amplitude = |r: &DrivenRecord| r.steady.amplitude.value;
    let builder = if phased {
        let phase = |r: &DrivenRecord| r.steady.phase_rad.as_ref().map_or(0.0, |q| q.value);
        Curve::complex(
            frequency_hz,
            records.iter().map(|r| Phasor::from_polar(amplitude(r), phase(r))).collect(),
        )
    } else {
        Curve::builder(frequency_hz, records.iter().map(amplitude).collect())
    };
    let mut builder = builder.unit(unit);
    let drives: Option<Vec<f64>> =
        records.iter().map(|r| r.steady.drive_amplitude.as_ref().map(|d| d.value)).collect();
    if let Some(drives) = drives.filter(|d| d.iter().all(|v| *v > 0.0)) {
        builder = builder.drive(drives);
    }
    let errors: Vec<f64> = records.iter().map(|r| r.steady.amplitude.std_error).collect();
    if errors.iter().all(|e| *e > 0.0) {
        builder = builder.std_error(errors);
    }
    builder.build()
}

/// Notes on the records for the user of the curve.
fn unsteady(records: &[DrivenRecord]) -> Vec<Note> {
    let mut notes = Vec::new();
    let left: Vec<&DrivenRecord> = records.iter().filter(|r| r.steady.transient_s > 0.0).collect();
    if !left.is_empty() {
        let longest = left.iter().map(|r| r.steady.transient_s).fold(0.0, f64::max);
        notes.push(
            format!(
                "{} of {} records begin with a transient, up to {longest:.3} s long: it was left out",
                left.len(),
                records.len()
            )
            .into(),
        );
    }
    let restless: Vec<&str> = records.iter().filter(|r| !r.steady.settled).map(|r| r.path.as_str()).collect();
    if !restless.is_empty() {
        notes.push(format!("the motion had not settled at the end of {}", restless.join(", ")).into());
    }
    notes
}

/// One fingerprint for all files: the hash of their concatenated fingerprints.
fn combined(records: &[DrivenRecord]) -> String {
    let mut hash = sha2::Sha256::new();
    records.iter().for_each(|r| hash.update(r.sha256.as_bytes()));
    hexadecimal(&hash.finalize())
}

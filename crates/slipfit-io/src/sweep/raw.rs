//! Driven records, one file for each frequency, to a curve.

use std::path::{Path, PathBuf};

use slipfit::{
    SignalKind,
    motion::steady::Phasor,
    resonance::Curve,
    signal::demodulate::{self, SteadyMotion},
};

use super::{
    SweepOptions, SweepProblem, SweepReading, SweepReport,
    role::{self, Role},
};
use crate::{
    ReadError, ReadOptions, ReadProblem, Reading,
    columns::{self, asked, info_of, label, names::Name},
    report::{ColumnInfo, ColumnTaken},
};

/// A file of driven motion and what came of it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// The file.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Samples read.
    pub samples: usize,
    /// The steady motion.
    pub steady: SteadyMotion,
}

/// Files of a folder, in the order of their names read as numbers.
pub(super) fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
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

/// Reads and demodulates the records of `files`; `name` stands for them all.
pub(super) fn read(files: &[PathBuf], name: &str, options: &SweepOptions) -> Result<SweepReading, ReadError> {
    let (mut runs, mut refused): (Vec<Run>, Vec<String>) = (Vec::new(), Vec::new());
    let mut first: Option<First> = None;
    let mut notes: Vec<String> = Vec::new();
    let mut unit = String::new();
    let mut phased = true;
    for path in files {
        match one(path, options) {
            Ok((run, columns)) => {
                phased &= run.steady.phase_rad.is_some();
                match &first {
                    None => {
                        unit.clone_from(&columns.unit);
                        first = Some(columns);
                    }
                    Some(held) if held.taken != columns.taken || held.unit != columns.unit => {
                        notes.push(format!(
                            "{}: other columns were taken than in the first file: {}",
                            run.path,
                            columns.taken.iter().map(|(_, t)| t.why.as_str()).collect::<Vec<_>>().join("; ")
                        ))
                    }
                    Some(_) => {}
                }
                runs.push(run);
            }
            Err(error) => refused.push(error.to_string()),
        }
    }
    let Some(first) = first else {
        let problem = SweepProblem::NoRuns {
            files: files.len(),
            first: refused.into_iter().next().unwrap_or_default(),
        };
        return Err(ReadError::new(name, ReadProblem::Sweep(problem)));
    };
    notes.splice(0..0, refused.iter().map(|r| format!("left out: {r}")));
    notes.extend(told(&runs));
    if !phased {
        notes.push(
            "not every record has a drive that oscillates: amplitudes only, --drive names its column"
                .to_owned(),
        );
    }
    let curve = curve(&runs, phased, &unit)
        .map_err(|e| ReadError::new(name, ReadProblem::Sweep(SweepProblem::Curve(e))))?;
    let rows_read = runs.len() as u64;
    Ok(SweepReading {
        curve,
        report: SweepReport {
            path: name.to_owned(),
            sha256: combined(&runs),
            bytes: first.bytes,
            rows_read,
            taken: first.taken,
            columns: first.columns,
            kind: SignalKind::Displacement,
            files_left_out: refused.len(),
            runs,
            notes,
            ..first.report
        },
    })
}

/// What the first file decides for the report.
struct First {
    taken: Vec<(&'static str, ColumnTaken)>,
    columns: Vec<ColumnInfo>,
    unit: String,
    bytes: u64,
    report: SweepReport,
}

fn one(path: &Path, options: &SweepOptions) -> Result<(Run, First), ReadError> {
    let plain = ReadOptions {
        time: options.time.clone(),
        signal: options.amplitude.clone(),
        time_unit: options.time_unit.clone(),
        signal_unit: options.unit.clone(),
        rate_hz: options.rate_hz,
        sheet: options.sheet.clone(),
        run: options.run,
        ..ReadOptions::default()
    };
    let alone = crate::read(path, &plain)?;
    let refuse = |problem| ReadError::new(&alone.report.path, problem);
    let names: Vec<Name> = alone.report.columns.iter().map(|c| Name::parse(&c.header)).collect();
    let response = alone.report.signal.column.number;
    let drive = drive(&alone, &names, options).map_err(refuse)?;
    let reading = match &drive {
        Some((number, _)) => {
            let both = ReadOptions {
                signal: Some(response.to_string()),
                quadrature: Some(number.to_string()),
                kind: Some(SignalKind::LockIn),
                signal_unit: None,
                ..plain
            };
            crate::read(path, &both)?
        }
        None => alone.clone(),
    };
    let record = &reading.record;
    let time_s = record.times_s(0..record.len());
    let steady = demodulate::demodulate(
        &time_s,
        record.signal(),
        record.quadrature(),
        &demodulate::Options::default(),
    )
    .map_err(|e| refuse(ReadProblem::Sweep(SweepProblem::Curve(e))))?;
    let mut taken = vec![("response", alone.report.signal.clone())];
    if let Some((number, why)) = drive {
        let column = info_of(&names, number - 1);
        let unit = column.unit.clone();
        taken.push(("drive", ColumnTaken { why: format!("{}: {why}", label(&column)), unit, column }));
    }
    let run = Run {
        path: reading.report.path.clone(),
        sha256: reading.report.sha256.clone(),
        samples: record.len(),
        steady,
    };
    let unit = alone.record.unit().to_owned();
    let bytes = alone.report.bytes;
    let columns = alone.report.columns.clone();
    Ok((run, First { taken, columns, unit, bytes, report: SweepReport::of_record(alone.report) }))
}

/// The column of the drive, from 1, and why.
fn drive(
    reading: &Reading,
    names: &[Name],
    options: &SweepOptions,
) -> Result<Option<(usize, &'static str)>, ReadProblem> {
    let all: Vec<usize> = (0..names.len()).collect();
    if let Some(wanted) = &options.drive {
        return Ok(Some((asked::find(names, "--drive", wanted, &all)? + 1, "asked for")));
    }
    let time = match &reading.report.time {
        crate::TimeSource::Column(t) | crate::TimeSource::Intervals(t) => t.column.number,
        crate::TimeSource::Rate(_) => 0,
    };
    let response = reading.report.signal.column.number;
    let others: Vec<usize> = all.into_iter().filter(|i| i + 1 != time && i + 1 != response).collect();
    if let Some(index) = others.iter().find(|&&i| role::role(&names[i]) == Role::Drive) {
        return Ok(Some((index + 1, "named like a drive")));
    }
    // A voltage beside an angle or a position is what the exciter reports.
    let rank = |i: usize| match names[i].role() {
        columns::names::Role::Signal { rank, .. } => Some(rank),
        _ => None,
    };
    let electrical = |i: &&usize| rank(**i) == Some(70) && rank(response - 1).is_some_and(|r| r > 70);
    if let Some(index) = others.iter().find(electrical) {
        return Ok(Some((index + 1, "a measured signal beside the response")));
    }
    let unnamed = names.iter().all(|n| n.header.is_empty());
    match others[..] {
        [only] if unnamed || role::role(&names[only]) == Role::Unknown => {
            Ok(Some((only + 1, "the only column left")))
        }
        _ => Ok(None),
    }
}

fn curve(runs: &[Run], phased: bool, unit: &str) -> Result<Curve, slipfit::Error> {
    let frequency_hz = runs.iter().map(|r| r.steady.frequency_hz.value).collect();
    let amplitude = |r: &Run| r.steady.amplitude.value;
    let builder = if phased {
        let phase = |r: &Run| r.steady.phase_rad.as_ref().map_or(0.0, |q| q.value);
        Curve::complex(
            frequency_hz,
            runs.iter().map(|r| Phasor::from_polar(amplitude(r), phase(r))).collect(),
        )
    } else {
        Curve::builder(frequency_hz, runs.iter().map(amplitude).collect())
    };
    let mut builder = builder.unit(unit);
    let drives: Option<Vec<f64>> =
        runs.iter().map(|r| r.steady.drive_amplitude.as_ref().map(|d| d.value)).collect();
    if let Some(drives) = drives.filter(|d| d.iter().all(|v| *v > 0.0)) {
        builder = builder.drive(drives);
    }
    let errors: Vec<f64> = runs.iter().map(|r| r.steady.amplitude.std_error).collect();
    if errors.iter().all(|e| *e > 0.0) {
        builder = builder.std_error(errors);
    }
    builder.build()
}

/// What a reader of the curve should know of the records.
fn told(runs: &[Run]) -> Vec<String> {
    let mut notes = Vec::new();
    let left: Vec<&Run> = runs.iter().filter(|r| r.steady.transient_s > 0.0).collect();
    if !left.is_empty() {
        let longest = left.iter().map(|r| r.steady.transient_s).fold(0.0, f64::max);
        notes.push(format!(
            "{} of {} records begin with a transient, up to {longest:.3} s long: it was left out",
            left.len(),
            runs.len()
        ));
    }
    let restless: Vec<&str> = runs.iter().filter(|r| !r.steady.settled).map(|r| r.path.as_str()).collect();
    if !restless.is_empty() {
        notes.push(format!("the motion had not settled at the end of {}", restless.join(", ")));
    }
    notes
}

/// One fingerprint for all files, of theirs in a row.
fn combined(runs: &[Run]) -> String {
    use sha2::Digest;
    let mut hash = sha2::Sha256::new();
    runs.iter().for_each(|r| hash.update(r.sha256.as_bytes()));
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

//! Amplitudes at resonance over the level of the drive.

use std::path::Path;

use slipfit::levels::Levels;

use super::{
    SweepProblem,
    role::{self, Role},
};
use crate::{
    Format, ReadError, ReadProblem, Table,
    columns::{asked, info_of, label, names::Name, units},
    report::{ColumnInfo, ColumnTaken, Skipped},
};

/// Choices that override what the file itself suggests.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelOptions {
    /// Column of the drive levels.
    pub drive: Option<String>,
    /// Column of the amplitudes.
    pub amplitude: Option<String>,
    /// Column of their standard errors.
    pub std_error: Option<String>,
    /// Unit of the amplitudes. `dB` and `dBm` are made linear.
    pub unit: Option<String>,
    /// Unit of the drive levels.
    pub drive_unit: Option<String>,
    /// Which of several sheets, variables, groups or data sets.
    pub sheet: Option<String>,
}

/// Drive levels and the account of how they were read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LevelReading {
    /// The points, in the order of measurement.
    pub levels: Levels,
    /// The file, as named by the caller.
    pub path: String,
    /// Its format.
    pub format: Format,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Its length in bytes.
    pub bytes: u64,
    /// Rows with a drive level and an amplitude.
    pub rows_read: u64,
    /// Rows without, by reason.
    pub skipped: Vec<Skipped>,
    /// The columns read, with what they are.
    pub taken: Vec<(&'static str, ColumnTaken)>,
    /// All columns of the table, taken or not.
    pub columns: Vec<ColumnInfo>,
    /// Values named beside the table, as written.
    pub named_values: Vec<(String, String)>,
    /// Whatever else a reader of the result should know, one sentence each.
    pub notes: Vec<String>,
}

impl LevelReading {
    /// Rows that gave no point.
    #[must_use]
    pub fn rows_skipped(&self) -> u64 {
        self.skipped.iter().map(|s| s.rows).sum()
    }
}

/// Reads drive levels and the amplitudes they gave.
///
/// A table with a column of frequencies besides holds a curve for each level;
/// of each the largest amplitude is taken.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
pub fn read_levels(path: impl AsRef<Path>, options: &LevelOptions) -> Result<LevelReading, ReadError> {
    let tables = crate::read_tables(path, usize::MAX)?;
    let refuse = |problem| ReadError::new(&tables.path, problem);
    let names: Vec<String> = tables.tables.iter().map(|t| t.name.clone()).collect();
    let index = match &options.sheet {
        Some(wanted) => crate::samples::find(wanted, &names).map_err(refuse)?,
        None => (0..tables.tables.len()).find(|&i| read(&tables.tables[i], options).is_ok()).unwrap_or(0),
    };
    let mut reading = read(&tables.tables[index], options).map_err(refuse)?;
    if tables.tables.len() > 1 && options.sheet.is_none() {
        reading.notes.push(format!("the table `{}` was read; --sheet reads another", names[index]));
    }
    Ok(LevelReading {
        path: tables.path,
        format: tables.format,
        sha256: tables.sha256,
        bytes: tables.bytes,
        ..reading
    })
}

fn read(table: &Table, options: &LevelOptions) -> Result<LevelReading, ReadProblem> {
    let names: Vec<Name> = table.columns.iter().map(|c| Name::parse(&c.header)).collect();
    let all: Vec<usize> = (0..names.len()).collect();
    let label_of = |i: usize| label(&info_of(&names, i));
    let filled = |i: usize| table.columns[i].values.iter().any(|v| v.is_finite());
    let of = |wanted: &[Role], without: &[usize]| {
        all.iter()
            .copied()
            .find(|&i| wanted.contains(&role::role(&names[i])) && filled(i) && !without.contains(&i))
    };
    let asked = |flag, wanted: &Option<String>| {
        wanted.as_ref().map(|w| asked::find(&names, flag, w, &all)).transpose()
    };
    let mut notes = table.notes.clone();
    let list = || asked::list(&names, &all);
    let (drive, why_drive) = match asked("--drive", &options.drive)? {
        Some(index) => (index, "asked for"),
        None => match of(&[Role::Drive], &[]) {
            Some(index) => (index, "named like a drive"),
            None => {
                let free = |i: &usize| {
                    filled(*i)
                        && !matches!(role::role(&names[*i]), Role::Frequency | Role::Phase | Role::Never)
                };
                let first = all.iter().copied().find(free);
                (first.ok_or_else(|| missing(list()))?, "the first column")
            }
        },
    };
    let (amplitude, why_amplitude) = match asked("--amplitude", &options.amplitude)? {
        Some(index) => (index, "asked for"),
        None => match of(&[Role::Amplitude], &[drive]) {
            Some(index) => (index, "named like an amplitude"),
            None => {
                let index = of(&[Role::Unknown], &[drive]).ok_or_else(|| missing(list()))?;
                (index, "the next column")
            }
        },
    };
    let std_error = match asked("--std-error", &options.std_error)? {
        Some(index) => Some((index, "asked for")),
        None => of(&[Role::StdError], &[drive, amplitude])
            .filter(|&i| i > amplitude && table.columns[i].values.iter().all(|v| !(*v <= 0.0)))
            .map(|i| (i, "named like a standard error")),
    };
    let frequency = of(&[Role::Frequency], &[drive, amplitude]);
    let mut unit = options.unit.clone().unwrap_or_else(|| names[amplitude].unit.clone()).trim().to_owned();
    let level = match units::measures(&unit) {
        Some(units::Measures::Level(linear)) => {
            notes.push(format!("{}: levels in {unit} were made linear, 10^(x/20)", label_of(amplitude)));
            linear.clone_into(&mut unit);
            true
        }
        _ => false,
    };
    let mut drive_unit =
        options.drive_unit.clone().unwrap_or_else(|| names[drive].unit.clone()).trim().to_owned();
    let drive_level = match units::measures(&drive_unit) {
        Some(units::Measures::Level(linear)) => {
            notes.push(format!("{}: levels in {drive_unit} were made linear, 10^(x/20)", label_of(drive)));
            linear.clone_into(&mut drive_unit);
            true
        }
        _ => false,
    };
    let needed: Vec<usize> =
        [Some(drive), Some(amplitude), std_error.map(|s| s.0)].into_iter().flatten().collect();
    let linear = |v: f64, level: bool| if level { 10f64.powf(v / 20.0) } else { v };
    let mut skipped = table.skipped.clone();
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut missing_in: Vec<(u64, u64)> = vec![(0, 0); needed.len()];
    for row in 0..table.rows() {
        if let Some(at) = needed.iter().position(|&c| !table.columns[c].values[row].is_finite()) {
            missing_in[at].0 += 1;
            if missing_in[at].0 == 1 {
                missing_in[at].1 = row as u64 + 1;
            }
            continue;
        }
        let value = |c: usize| table.columns[c].values[row];
        let amplitude = linear(value(amplitude), level);
        if amplitude < 0.0 {
            return Err(ReadProblem::Sweep(SweepProblem::NegativeAmplitude {
                row: row as u64 + 1,
                column: label_of(needed[1]),
                value: amplitude,
            }));
        }
        let error = std_error.map_or(f64::NAN, |(c, _)| value(c));
        points.push([linear(value(drive), drive_level), amplitude, error]);
    }
    for (&column, (rows, first_row)) in needed.iter().zip(missing_in).filter(|(_, (rows, _))| *rows > 0) {
        skipped.push(Skipped { reason: format!("no value in column {}", column + 1), rows, first_row });
    }
    let rows_read = points.len() as u64;
    if let Some(frequency) = frequency.filter(|_| repeats(&points)) {
        let before = points.len();
        points = peaks(&points);
        notes.push(format!(
            "{} holds frequencies: of the {before} rows the largest amplitude at each of {} drive levels was taken",
            label_of(frequency),
            points.len()
        ));
    }
    let column = |at: usize| points.iter().map(|p| p[at]).collect::<Vec<f64>>();
    let mut builder = Levels::builder(column(0), column(1)).unit(unit.clone()).drive_unit(drive_unit.clone());
    if std_error.is_some() {
        builder = builder.std_error(column(2));
    }
    let levels = builder.build().map_err(|e| ReadProblem::Sweep(SweepProblem::Curve(e)))?;
    let took = |index: usize, unit: &str, why: &str| ColumnTaken {
        column: info_of(&names, index),
        unit: unit.to_owned(),
        why: format!("{}: {why}", label_of(index)),
    };
    let mut taken = vec![
        ("drive", took(drive, &drive_unit, why_drive)),
        ("amplitude", took(amplitude, &unit, why_amplitude)),
    ];
    taken.extend(std_error.map(|(i, why)| ("std_error", took(i, &unit, why))));
    let unread: Vec<usize> =
        all.iter().copied().filter(|i| !needed.contains(i) && Some(*i) != frequency && filled(*i)).collect();
    if !unread.is_empty() {
        notes.push(format!("not used: {}", asked::list(&names, &unread)));
    }
    Ok(LevelReading {
        levels,
        path: String::new(),
        format: Format::Text,
        sha256: String::new(),
        bytes: 0,
        rows_read,
        skipped,
        taken,
        columns: all.iter().map(|&i| info_of(&names, i)).collect(),
        named_values: table.named_values.clone(),
        notes,
    })
}

fn missing(columns: String) -> ReadProblem {
    ReadProblem::Sweep(SweepProblem::NoResponse { columns })
}

/// Whether most drive levels stand in several rows.
fn repeats(points: &[[f64; 3]]) -> bool {
    let mut levels: Vec<f64> = points.iter().map(|p| p[0]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    levels.len() > 1 && points.len() >= 3 * levels.len()
}

/// The largest amplitude of each drive level, in the order in which the levels come.
fn peaks(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut list: Vec<[f64; 3]> = Vec::new();
    for point in points {
        match list.iter_mut().find(|held| held[0] == point[0]) {
            Some(held) if held[1] < point[1] => *held = *point,
            Some(_) => {}
            None => list.push(*point),
        }
    }
    list
}

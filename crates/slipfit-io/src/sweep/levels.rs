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
    /// The frequency of the drive [Hz], where the lines above the table name it `drive_frequency_hz`,
    /// as simulated levels do.
    #[must_use]
    pub fn named_frequency_hz(&self) -> Option<f64> {
        crate::report::named_number(&self.named_values, "drive_frequency_hz")
    }
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
    let all = &tables.tables;
    let reading = match &options.sheet {
        Some(wanted) => {
            let index = crate::samples::find(wanted, &names).map_err(refuse)?;
            read(&all[index], &[], options).map_err(refuse)?
        }
        None => match curves(all) {
            Some((joint, starts)) => {
                let mut reading = read(&joint, &starts, options).map_err(refuse)?;
                reading
                    .notes
                    .push(format!("of {} tables a level each was read; --sheet reads one", starts.len()));
                reading
            }
            None => {
                let index = (0..all.len()).find(|&i| read(&all[i], &[], options).is_ok()).unwrap_or(0);
                let mut reading = read(&all[index], &[], options).map_err(refuse)?;
                if all.len() > 1 {
                    reading
                        .notes
                        .push(format!("the table `{}` was read; --sheet reads another", names[index]));
                }
                reading
            }
        },
    };
    Ok(LevelReading {
        path: tables.path,
        format: tables.format,
        sha256: tables.sha256,
        bytes: tables.bytes,
        ..reading
    })
}

/// Tables of the same columns, each a curve over frequency, one below the other; and the
/// first row of each. `None` where there are not several.
fn curves(tables: &[Table]) -> Option<(Table, Vec<usize>)> {
    let has = |t: &Table, wanted: Role| {
        t.columns.iter().any(|c| {
            role::role(&Name::parse(&c.header)) == wanted && c.values.windows(2).any(|w| w[0] != w[1])
        })
    };
    let is_curve = |t: &&Table| [Role::Frequency, Role::Drive, Role::Amplitude].iter().all(|r| has(t, *r));
    let first = tables.iter().find(is_curve)?;
    let headers = |t: &Table| t.columns.iter().map(|c| c.header.clone()).collect::<Vec<_>>();
    let mut joint = Table { name: String::new(), ..first.clone() };
    joint.columns.iter_mut().for_each(|c| c.values.clear());
    let mut starts = Vec::new();
    for table in tables.iter().filter(is_curve).filter(|t| headers(t) == headers(first)) {
        starts.push(joint.rows());
        for (held, new) in joint.columns.iter_mut().zip(&table.columns) {
            held.values.extend_from_slice(&new.values);
        }
    }
    (starts.len() > 1).then_some((joint, starts))
}

/// The points of a table, or of several that begin in the rows `starts`.
fn read(table: &Table, starts: &[usize], options: &LevelOptions) -> Result<LevelReading, ReadProblem> {
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
                if let Some(time) = of(&[Role::Time], &[]) {
                    return Err(not_levels(format!(
                        "{} holds times: this is a record of the motion, not amplitudes over levels of the drive",
                        label_of(time)
                    )));
                }
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
    let mut rows: Vec<usize> = Vec::new();
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
            return Err(not_levels(format!(
                "{}: amplitude {amplitude} in row {} is below zero",
                label_of(needed[1]),
                row + 1
            )));
        }
        let error = std_error.map_or(f64::NAN, |(c, _)| value(c));
        points.push([linear(value(drive), drive_level), amplitude, error]);
        rows.push(row);
    }
    for (&column, (rows, first_row)) in needed.iter().zip(missing_in).filter(|(_, (rows, _))| *rows > 0) {
        skipped.push(Skipped { reason: format!("no value in column {}", column + 1), rows, first_row });
    }
    let rows_read = points.len() as u64;
    if let Some(frequency) = frequency {
        let hz: Vec<f64> = rows.iter().map(|&row| table.columns[frequency].values[row]).collect();
        let curve_of = |i: usize| starts.iter().filter(|&&start| start <= rows[i]).count();
        let groups = groups(&points, &hz, starts.len() > 1, curve_of);
        let before = points.len();
        if let Some(groups) = groups {
            points = peaks(&points, &groups);
            if points.len() < FEWEST {
                return Err(not_levels(format!(
                    "{} varies and the drive does not: this is a resonance curve, not amplitudes at {FEWEST} levels \
                     of the drive or more",
                    label_of(frequency)
                )));
            }
            notes.push(format!(
                "{} holds frequencies: of the {before} rows the largest amplitude at each of {} drive levels was taken",
                label_of(frequency),
                points.len()
            ));
        }
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
    not_levels(format!("no column could be the amplitude among {columns}"))
}

fn not_levels(reason: String) -> ReadProblem {
    ReadProblem::Sweep(SweepProblem::NotLevels { reason })
}

/// Levels that make a line and a threshold.
const FEWEST: usize = 3;
/// Rows of a curve, on average.
const OF_A_CURVE: usize = 3;
/// A measured level strays by less than this from row to row, levels differ by more.
const JITTER: f64 = 0.05;

/// Which curve over frequency each point belongs to; `None` where every row is a level of its own.
fn groups(
    points: &[[f64; 3]],
    hz: &[f64],
    tables: bool,
    table_of: impl Fn(usize) -> usize,
) -> Option<Vec<usize>> {
    if tables {
        return Some((0..points.len()).map(table_of).collect());
    }
    let count = |groups: &[usize]| groups.iter().max().map_or(0, |m| m + 1);
    let levels = clusters(points);
    let tight = (0..count(&levels)).all(|group| {
        let drive = || points.iter().zip(&levels).filter(|(_, g)| **g == group).map(|(p, _)| p[0]);
        drive().fold(0.0, f64::max) <= (1.0 + 2.0 * JITTER) * drive().fold(f64::INFINITY, f64::min)
    });
    if count(&levels) >= FEWEST && tight {
        return (points.len() >= OF_A_CURVE * count(&levels)).then_some(levels);
    }
    // A drive that goes one way is set from row to row; one that strays is swept along.
    let steps = |values: &[f64]| {
        let rising = values.windows(2).filter(|w| w[1] > w[0]).count();
        let falling = values.windows(2).filter(|w| w[1] < w[0]).count();
        (rising, falling)
    };
    let drive: Vec<f64> = points.iter().map(|p| p[0]).collect();
    let set = matches!(steps(&drive), (rising, falling) if rising + 1 == points.len() || falling + 1 == points.len());
    let (rising, falling) = steps(hz);
    let swept = rising + falling >= OF_A_CURVE;
    (swept && !set).then(|| vec![0; points.len()])
}

/// Points of one level of the drive, by number.
fn clusters(points: &[[f64; 3]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    let mut groups = vec![0; points.len()];
    let mut group = 0;
    for pair in order.windows(2) {
        let [low, high] = [points[pair[0]][0], points[pair[1]][0]];
        group += usize::from(high - low > JITTER * high.abs());
        groups[pair[1]] = group;
    }
    groups
}

/// Of each curve the point of the largest amplitude for its drive, in the order in which the curves come.
fn peaks(points: &[[f64; 3]], groups: &[usize]) -> Vec<[f64; 3]> {
    let mut list: Vec<(usize, [f64; 3])> = Vec::new();
    let higher = |a: &[f64; 3], b: &[f64; 3]| a[1] * b[0] > b[1] * a[0];
    for (point, group) in points.iter().zip(groups) {
        match list.iter_mut().find(|(held, _)| held == group) {
            Some((_, held)) if higher(point, held) => *held = *point,
            Some(_) => {}
            None => list.push((*group, *point)),
        }
    }
    list.into_iter().map(|(_, point)| point).collect()
}

//! Amplitudes at resonance over the level of the drive.

use slipfit::levels::{Levels, peak_height};

use super::{
    open::{Origin, gathered, opened},
    pick,
};
use crate::{
    columns::{Chooser, ChosenColumn, head::Head, quadrature::Pair, role::Role, rows, scale::Scale, units},
    error::{Needed, OptionProblem, ReadError, ReadProblem},
    options::ReadOptions,
    report::{LevelReading, Note, ReadReport},
    tables::table::{LoadedTable, TableSource},
};

/// Reads drive levels and the resulting amplitudes.
pub(crate) fn read(origin: Origin<'_>, name: &str, options: &ReadOptions) -> Result<LevelReading, ReadError> {
    let from_source = |source: &mut dyn TableSource| {
        let tables = gathered(source, usize::MAX)?;
        from_tables(&tables, options)
    };
    let (mut reading, fingerprint) =
        opened(origin, options.format, None, from_source).map_err(|problem| ReadError::new(name, problem))?;
    fingerprint.write(&mut reading.report, name);
    Ok(reading)
}

fn from_tables(tables: &[LoadedTable], options: &ReadOptions) -> Result<LevelReading, ReadProblem> {
    let names: Vec<&str> = tables.iter().map(|t| t.head.name.as_str()).collect();
    if let Some(wanted) = &options.sheet {
        let is_text = tables.iter().any(|table| table.dialect.is_some());
        return from_table(&tables[pick::find(wanted, &names, is_text)?], &[], options);
    }
    let (mut reading, note) = match curves(tables) {
        Some((joint, starts)) => {
            let note = Note::new(format!("one level was read from each of {} tables", starts.len()));
            (from_table(&joint, &starts, options)?, note.hint("sheet", "reads one"))
        }
        None => {
            let read = |index: usize| from_table(&tables[index], &[], options);
            let found = (0..tables.len()).find_map(|index| Some((index, read(index).ok()?)));
            let (index, reading) = match found {
                Some(found) => found,
                None => (0, read(0)?),
            };
            let note = Note::new(format!("the table `{}` was read", names[index]));
            (reading, note.hint("sheet", "reads another"))
        }
    };
    if tables.len() > 1 {
        reading.report.notes.push(note);
    }
    Ok(reading)
}

/// Joins tables with the same columns, each a curve over frequency, and gives the first row of each. `None` if there
/// are not several.
fn curves(tables: &[LoadedTable]) -> Option<(LoadedTable, Vec<usize>)> {
    let has = |t: &LoadedTable, wanted: Role| {
        let varies = |c: &[f64]| c.windows(2).any(|w| w[0] != w[1]);
        let columns = t.head.names.iter().zip(&t.columns);
        columns.into_iter().any(|(name, values)| Role::in_curve(name) == wanted && varies(values))
    };
    let is_curve =
        |t: &&LoadedTable| [Role::Frequency, Role::Drive, Role::Amplitude].iter().all(|r| has(t, *r));
    let first = tables.iter().find(is_curve)?;
    let headers = |t: &LoadedTable| t.head.names.iter().map(|n| n.header.clone()).collect::<Vec<_>>();
    let mut joint = first.clone();
    joint.head.name.clear();
    joint.columns.iter_mut().for_each(Vec::clear);
    let mut starts = Vec::new();
    for table in tables.iter().filter(is_curve).filter(|t| headers(t) == headers(first)) {
        starts.push(joint.rows());
        for (held, new) in joint.columns.iter_mut().zip(&table.columns) {
            held.extend_from_slice(new);
        }
    }
    (starts.len() > 1).then_some((joint, starts))
}

/// Columns to be read from a table.
struct Choice {
    drive: ChosenColumn,
    /// The amplitudes, or the real part of the response.
    amplitude: ChosenColumn,
    /// The imaginary part of the response; the amplitude is then the modulus of both parts.
    imaginary: Option<ChosenColumn>,
    std_error: Option<ChosenColumn>,
    frequency: Option<usize>,
    /// Whether drive and amplitude are in decibels and have to be made linear.
    levels: [bool; 2],
    /// Whether the name of a column identifies it as the drive.
    named: bool,
}

impl Choice {
    /// The columns read, with their roles.
    fn columns(&self) -> Vec<(&'static str, &ChosenColumn)> {
        let std_error = self.std_error.as_ref().map(|p| ("std_error", p));
        let imaginary = self.imaginary.as_ref().map(|p| ("imaginary", p));
        let amplitude = if imaginary.is_some() { "real" } else { "amplitude" };
        [Some(("drive", &self.drive)), Some((amplitude, &self.amplitude)), imaginary, std_error]
            .into_iter()
            .flatten()
            .collect()
    }
}

impl Chooser<'_> {
    fn levels(&mut self) -> Result<Choice, ReadProblem> {
        let options = self.options;
        let missing = |head: &Head| ReadProblem::NoColumn {
            needed: Needed::LevelAmplitude,
            columns: head.list(&head.all()),
        };
        let of = |chooser: &Self, wanted: Role, without: &[usize]| {
            let fits = |i: &usize| chooser.roles[*i] == wanted && !without.contains(i) && chooser.filled(*i);
            (0..chooser.roles.len()).find(fits)
        };
        let asks_for_parts = options.real.is_some() || options.imaginary.is_some();
        if let (true, Some(value)) = (asks_for_parts, &options.amplitude) {
            let problem = OptionProblem::Excludes("real and imaginary");
            return Err(ReadProblem::Option { option: "amplitude", value: value.clone(), problem });
        }
        self.check_distinct(&[
            ("drive", &options.drive),
            ("amplitude", &options.amplitude),
            ("real", &options.real),
            ("imaginary", &options.imaginary),
            ("std_error", &options.std_error),
        ])?;
        let parts = self.parts()?;
        let beside: Vec<usize> = parts.iter().flatten().map(|(index, _)| *index).collect();
        let amplitude = self.asked("amplitude", &options.amplitude)?;
        let (drive, why_drive) = if let Some(index) = self.asked("drive", &options.drive)? {
            (index, "asked for")
        } else if let Some(index) = of(self, Role::Drive, &beside) {
            (index, "named like a drive")
        } else if let Some(time) = of(self, Role::Time, &[]) {
            let instead_of = "amplitudes over levels of the drive";
            return Err(ReadProblem::TimeRecord { column: self.label(time), instead_of });
        } else {
            let other = |i: usize| {
                let used = beside.contains(&i) || amplitude == Some(i);
                used || matches!(self.roles[i], Role::Frequency | Role::Phase | Role::Never)
            };
            let first = (0..self.roles.len()).find(|&i| self.filled(i) && !other(i));
            (first.ok_or_else(|| missing(self.head))?, "the first column")
        };
        if let (true, Some(value)) = (amplitude == Some(drive), &options.amplitude) {
            let problem = OptionProblem::SameColumn { column: self.label(drive), other: "drive" };
            return Err(ReadProblem::Option { option: "amplitude", value: value.clone(), problem });
        }
        let without: Vec<usize> = beside.iter().copied().chain([drive]).collect();
        let modulus = of(self, Role::Amplitude, &without);
        let parts = parts.filter(|_| !beside.contains(&drive));
        let ((amplitude, why_amplitude), imaginary) = if let Some(index) = amplitude {
            ((index, "asked for"), None)
        } else if let Some([real, imaginary]) = parts.filter(|_| asks_for_parts || modulus.is_none()) {
            (real, Some(imaginary))
        } else if let Some(index) = modulus.or_else(|| of(self, Role::Amplitude, &[drive])) {
            ((index, "named like an amplitude"), None)
        } else {
            let next = of(self, Role::Unknown, &[drive]);
            ((next.ok_or_else(|| missing(self.head))?, "the next column"), None)
        };
        let std_error = match self.asked("std_error", &options.std_error)? {
            Some(index) => Some((index, "asked for")),
            None => of(self, Role::StdError, &[drive, amplitude])
                .filter(|&i| i > amplitude && self.values[i].iter().all(|v| !(*v <= 0.0)))
                .map(|i| (i, "named like a standard error")),
        };
        let frequency = of(self, Role::Frequency, &[drive, amplitude]);
        let (amplitude, linear_amplitude) = self.in_unit(amplitude, why_amplitude, options.unit.as_ref());
        let imaginary = imaginary.map(|(index, why)| self.choose_column(index, why));
        let (drive, linear_drive) = self.in_unit(drive, why_drive, options.drive_unit.as_ref());
        let std_error = std_error.map(|(index, why)| self.choose_column(index, why));
        let levels = [linear_drive, linear_amplitude];
        let named = self.roles[drive.index] == Role::Drive;
        Ok(Choice { drive, amplitude, imaginary, std_error, frequency, levels, named })
    }

    /// Real and imaginary part of the response, requested or named so, with reasons.
    fn parts(&self) -> Result<Option<[(usize, &'static str); 2]>, ReadProblem> {
        let options = self.options;
        let drive = self.asked("drive", &options.drive)?;
        let without: Vec<usize> = drive.into_iter().collect();
        let named = [Role::Real, Role::Imaginary].map(|role| self.of_role(role, &without));
        let pair = match named {
            [Some(real), Some(imaginary)] => Some([real, imaginary]),
            _ => self.quadrature_pair(&without).map(|pair| [pair.real, pair.imaginary]),
        };
        let asked = [self.asked("real", &options.real)?, self.asked("imaginary", &options.imaginary)?];
        let other = |given: usize, part: usize| {
            let in_pair = pair.and_then(|pair| pair.contains(&given).then(|| pair[part]));
            in_pair.filter(|found| *found != given).or(named[part])
        };
        let half = |given: usize, missing: &'static str| ReadProblem::HalfComplex {
            given: self.label(given),
            missing,
            columns: self.list(),
        };
        Ok(match asked {
            [Some(real), Some(imaginary)] => Some([(real, "asked for"), (imaginary, "asked for")]),
            [Some(real), None] => {
                let found = other(real, 1).ok_or_else(|| half(real, "imaginary"))?;
                Some([(real, "asked for"), (found, Pair::WHY)])
            }
            [None, Some(imaginary)] => {
                let found = other(imaginary, 0).ok_or_else(|| half(imaginary, "real"))?;
                Some([(found, Pair::WHY), (imaginary, "asked for")])
            }
            [None, None] => pair.map(|pair| pair.map(|index| (index, Pair::WHY))),
        })
    }

    /// A column in its own unit or the given one, and whether it holds decibels.
    fn in_unit(&mut self, index: usize, why: &str, given: Option<&String>) -> (ChosenColumn, bool) {
        let mut chosen = self.choose_column(index, why);
        let written = given.unwrap_or(&chosen.unit).trim().to_owned();
        let linear = units::linear_unit(&written);
        if linear.is_some() {
            let text = format!(
                "{}: levels in {written} were converted to linear values, 10^(x/20)",
                self.label(index)
            );
            self.notes.push(text.into());
        }
        chosen.unit = linear.map_or(written, str::to_owned);
        (chosen, linear.is_some())
    }
}

/// The points of a table, or of several tables that begin in the rows `starts`.
fn from_table(
    table: &LoadedTable,
    starts: &[usize],
    options: &ReadOptions,
) -> Result<LevelReading, ReadProblem> {
    let LoadedTable { head, columns, .. } = table;
    let mut chooser = Chooser::of_curve(head, columns, options);
    let choice = chooser.levels()?;
    let mut taken: Vec<usize> = choice.columns().into_iter().map(|(_, chosen)| chosen.index).collect();
    let mut skipped = table.skipped.clone();
    let rows = rows::complete(columns, &taken, 1, &mut skipped);
    if let Some(imaginary) = &choice.imaginary {
        let (x, y) = (chooser.label(choice.amplitude.index), chooser.label(imaginary.index));
        let text = format!("{x} and {y}: the amplitude was taken as their modulus");
        chooser.notes.push(Note::new(text).hint("amplitude", "names a column that stands alone"));
    }
    let linear = |v: f64, level: bool| if level { units::from_decibels(v) } else { v };
    let mut points: Vec<[f64; 3]> = Vec::with_capacity(rows.len());
    for &row in &rows {
        let written = columns[choice.amplitude.index][row];
        let amplitude = match &choice.imaginary {
            Some(imaginary) => written.hypot(columns[imaginary.index][row]),
            None => linear(written, choice.levels[1]),
        };
        if amplitude < 0.0 {
            return Err(ReadProblem::Negative {
                what: "amplitude",
                row: row as u64 + 1,
                column: head.label(choice.amplitude.index),
                value: amplitude,
                unit: String::new(),
            });
        }
        let error = choice.std_error.as_ref().map_or(f64::NAN, |p| {
            let scale = if choice.levels[1] { Scale::Decibel } else { Scale::Linear };
            scale.error(columns[p.index][row], &p.unit, amplitude, &choice.amplitude.unit)
        });
        points.push([linear(columns[choice.drive.index][row], choice.levels[0]), amplitude, error]);
    }
    if let Some(frequency) = choice.frequency {
        let hz: Vec<f64> = rows.iter().map(|&row| columns[frequency][row]).collect();
        let curve_of = |i: usize| starts.iter().filter(|&&start| start <= rows[i]).count();
        if let Some(groups) = groups(&points, &hz, starts.len() > 1, curve_of) {
            let fitted;
            (points, fitted) = peaks(&points, &hz, &groups);
            let column = head.label(frequency);
            if points.len() < FEWEST {
                return Err(ReadProblem::OneLevel { column, needed: FEWEST });
            }
            let (rows, levels) = (rows.len(), points.len());
            let of = format!("{column} holds frequencies: from the {rows} rows the");
            chooser.notes.push(Note::new(match levels - fitted {
                0 => format!("{of} height of the resonance fitted at each of {levels} drive levels was taken"),
                coarse if fitted == 0 => format!(
                    "{of} largest amplitude at each of {coarse} drive levels was taken, which may lie below the peak: no \
                     resonance could be fitted there; sweep more finely"
                ),
                coarse => format!(
                    "{of} height of the resonance fitted at each of {fitted} drive levels was taken, and at {coarse} the largest \
                     amplitude, which may lie below the peak"
                ),
            }));
        }
    }
    let column = |at: usize| points.iter().map(|p| p[at]).collect::<Vec<f64>>();
    let builder = Levels::builder(column(0), column(1));
    let builder = builder.unit(choice.amplitude.unit.clone()).drive_unit(choice.drive.unit.clone());
    let builder = if choice.std_error.is_some() { builder.std_error(column(2)) } else { builder };
    let levels = builder.build().map_err(ReadProblem::Data)?;
    taken.extend(choice.frequency);
    chooser.note_unread(&taken);
    let report = ReadReport {
        rows_read: rows.len() as u64,
        skipped,
        taken: choice.columns().into_iter().map(|(what, chosen)| (what, chosen.taken(head))).collect(),
        named: choice.named,
        notes: chooser.notes,
        dialect: table.dialect.clone(),
        ..head.report()
    };
    Ok(LevelReading { levels, report })
}

/// Minimum number of levels for fitting a line and a threshold.
const FEWEST: usize = 3;
/// Minimum number of rows per curve, on average.
const FEWEST_PER_CURVE: usize = 3;
/// A measured level varies by less than this from row to row; distinct levels differ by more.
const JITTER: f64 = 0.05;

/// Index of the curve over frequency of each point; `None` if every row is a separate level.
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
        return (points.len() >= FEWEST_PER_CURVE * count(&levels)).then_some(levels);
    }
    // A drive that changes in one direction is set row by row; one that fluctuates is measured along a sweep.
    let steps = |values: &[f64]| {
        let rising = values.windows(2).filter(|w| w[1] > w[0]).count();
        let falling = values.windows(2).filter(|w| w[1] < w[0]).count();
        (rising, falling)
    };
    let drive: Vec<f64> = points.iter().map(|p| p[0]).collect();
    let set = matches!(steps(&drive), (rising, falling) if rising + 1 == points.len() || falling + 1 == points.len());
    let (rising, falling) = steps(hz);
    let swept = rising + falling >= FEWEST_PER_CURVE;
    (swept && !set).then(|| vec![0; points.len()])
}

/// Index of the drive level of each point.
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

/// Drive level and peak height of each curve, in the order of the curves, and the number of fitted heights. The level
/// is that of the point with the largest amplitude relative to its drive; this amplitude is the height if no fit is
/// possible.
fn peaks(points: &[[f64; 3]], hz: &[f64], groups: &[usize]) -> (Vec<[f64; 3]>, usize) {
    let mut curves: Vec<(usize, Vec<usize>)> = Vec::new();
    for (i, group) in groups.iter().enumerate() {
        match curves.iter_mut().find(|(held, _)| held == group) {
            Some((_, curve)) => curve.push(i),
            None => curves.push((*group, vec![i])),
        }
    }
    let higher = |a: &[f64; 3], b: &[f64; 3]| a[1] * b[0] > b[1] * a[0];
    let mut fitted = 0;
    let peak = |(_, curve): (usize, Vec<usize>)| {
        let most = |held: [f64; 3], &i: &usize| if higher(&points[i], &held) { points[i] } else { held };
        let mut held = curve.iter().skip(1).fold(points[curve[0]], most);
        let frequencies: Vec<f64> = curve.iter().map(|&i| hz[i]).collect();
        // Scaled to one drive, from which the points may deviate.
        let at_one = |&i: &usize| {
            if points[i][0] > 0.0 { points[i][1] * held[0] / points[i][0] } else { points[i][1] }
        };
        let amplitudes: Vec<f64> = curve.iter().map(at_one).collect();
        if let Some(height) = peak_height(&frequencies, &amplitudes) {
            (held[1], fitted) = (height, fitted + 1);
        }
        held
    };
    let list = curves.into_iter().map(peak).collect();
    (list, fitted)
}

//! Resonance curves of any dialect, and driven records demodulated to one.

mod build;
mod choice;
mod choose;
mod frequency;
mod levels;
mod options;
mod problem;
mod raw;
mod response;
mod role;

use std::{io::Read, path::PathBuf};

use slipfit::{SignalKind, resonance::Curve};

use self::choice::{Centre, Choice, Frequency, Response};
use self::choose::Chooser;
use crate::{
    Format, ReadError, ReadProblem, ReadReport, Table, Tables,
    report::{ColumnInfo, ColumnTaken, Dialect, Skipped},
};

pub use levels::{LevelOptions, LevelReading, read_levels};
pub use options::SweepOptions;
pub use problem::SweepProblem;
pub use raw::Run;

/// A curve and the account of how it was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SweepReading {
    /// The points, in the order of measurement.
    pub curve: Curve,
    /// The account.
    pub report: SweepReport,
}

/// How a resonance curve was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SweepReport {
    /// The file or the folder, as named by the caller.
    pub path: String,
    /// Its format; of raw records that of the first.
    pub format: Format,
    /// SHA-256 of its bytes, in hexadecimal; of several files that of theirs in a row.
    pub sha256: String,
    /// Its length in bytes; of several files that of the first.
    pub bytes: u64,
    /// The sheet, variable or group read; empty where the file has one table only.
    pub sheet: String,
    /// Points read; the curve may hold fewer.
    pub rows_read: u64,
    /// Rows that gave no point, by reason.
    pub skipped: Vec<Skipped>,
    /// How the text is written; `None` of other formats.
    pub dialect: Option<Dialect>,
    /// The columns read, with what they are: `frequency`, `amplitude`, `phase`, …
    pub taken: Vec<(&'static str, ColumnTaken)>,
    /// What the response was taken to be, before it was made a displacement.
    pub kind: SignalKind,
    /// Whether the name of a column says that this is a curve, not its numbers alone.
    pub named: bool,
    /// All columns of the table, taken or not.
    pub columns: Vec<ColumnInfo>,
    /// Curves in groups of columns.
    pub column_runs: usize,
    /// The one read, from 1.
    pub column_run: usize,
    /// Values named beside the table, as written.
    pub named_values: Vec<(String, String)>,
    /// The records the points come from; empty where the file held the curve itself.
    pub runs: Vec<Run>,
    /// Files that could not be read as driven records; `notes` says why.
    pub files_left_out: usize,
    /// Whatever else a reader of the result should know, one sentence each.
    pub notes: Vec<String>,
}

impl SweepReport {
    /// Rows of the table that gave no point.
    #[must_use]
    pub fn rows_skipped(&self) -> u64 {
        self.skipped.iter().map(|s| s.rows).sum()
    }

    /// The column read as this.
    #[must_use]
    pub fn column(&self, what: &str) -> Option<&ColumnTaken> {
        self.taken.iter().find(|(name, _)| *name == what).map(|(_, taken)| taken)
    }

    fn of_record(report: ReadReport) -> Self {
        Self {
            path: report.path,
            format: report.format,
            sha256: report.sha256,
            bytes: report.bytes,
            sheet: report.sheet,
            rows_read: 0,
            skipped: Vec::new(),
            dialect: report.dialect,
            taken: Vec::new(),
            kind: report.kind,
            named: false,
            columns: report.columns,
            column_runs: 1,
            column_run: 1,
            named_values: report.named_values,
            runs: Vec::new(),
            files_left_out: 0,
            notes: Vec::new(),
        }
    }
}

/// Reads a resonance curve: from one file that holds it, or from several files
/// or a folder of driven records, one for each frequency.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
pub fn read_sweep(paths: &[PathBuf], options: &SweepOptions) -> Result<SweepReading, ReadError> {
    match paths {
        [one] if one.is_dir() => {
            let name = one.display().to_string();
            let files = raw::files(one).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))?;
            if files.is_empty() {
                return Err(ReadError::new(&name, ReadProblem::Sweep(SweepProblem::NoFiles)));
            }
            raw::read(&files, &name, options)
        }
        [one] => from_tables(crate::read_tables(one, usize::MAX)?, options),
        [] => Err(ReadError::new("no file", ReadProblem::Empty)),
        several => {
            let name = format!("{} and {} more", several[0].display(), several.len() - 1);
            raw::read(several, &name, options)
        }
    }
}

/// Reads a resonance curve from a stream; `name` stands for it in the report
/// and in errors.
///
/// # Errors
/// As [`read_sweep`].
///
/// ```
/// use slipfit_io::{SweepOptions, read_sweep_from};
/// let file = "f (kHz);R (dBm);phi (deg)\n32,5;-40;-10\n32,75;-20;-90\n33;-40;-170\n";
/// let reading = read_sweep_from(file.as_bytes(), "fork.csv", &SweepOptions::default())?;
/// assert_eq!(reading.curve.frequency_hz(), [32500.0, 32750.0, 33000.0]);
/// assert!((reading.curve.response().amplitude(1) - 0.1).abs() < 1e-12);
/// assert_eq!(reading.curve.unit(), "√mW");
/// # Ok::<(), slipfit_io::ReadError>(())
/// ```
pub fn read_sweep_from(
    reader: impl Read,
    name: &str,
    options: &SweepOptions,
) -> Result<SweepReading, ReadError> {
    from_tables(crate::read_tables_from(reader, name, usize::MAX)?, options)
}

/// Reads the curve of one of the tables: the one asked for, or the first that holds one.
fn from_tables(tables: Tables, options: &SweepOptions) -> Result<SweepReading, ReadError> {
    let Tables { path, format, sha256, bytes, dialect, tables } = tables;
    let refuse = |problem| ReadError::new(&path, problem);
    let names: Vec<String> = tables.iter().map(|t| t.name.clone()).collect();
    let picked: Vec<usize> = match &options.sheet {
        Some(wanted) => vec![crate::samples::find(wanted, &names).map_err(refuse)?],
        None => (0..tables.len()).collect(),
    };
    let mut problem = ReadProblem::Empty;
    let mut found = None;
    for &index in picked.iter().rev() {
        match from_table(&tables[index], dialect.as_ref(), options) {
            Ok(read) => found = Some((index, read)),
            Err(e) => problem = e,
        }
    }
    let Some((index, mut reading)) = found else { return Err(refuse(problem)) };
    if tables.len() > 1 && options.sheet.is_none() {
        reading.report.notes.push(format!(
            "of {} tables `{}` was read, the first that holds a curve; --sheet reads another",
            tables.len(),
            names[index]
        ));
    }
    reading.report.sheet.clone_from(&names[index]);
    let report = SweepReport { path, format, sha256, bytes, dialect, ..reading.report };
    Ok(SweepReading { report, ..reading })
}

fn from_table(
    table: &Table,
    dialect: Option<&Dialect>,
    options: &SweepOptions,
) -> Result<SweepReading, ReadProblem> {
    let chooser = Chooser::new(table, options);
    let columns = chooser.columns();
    let choice = chooser.run()?;
    // Rows are lines of the file only where none of them was left out.
    let first_row = dialect.filter(|_| table.skipped.is_empty()).map_or(1, |d| d.first_data_row);
    let built = build::build(table, &columns, &choice, first_row)?;
    let mut notes = choice.notes.clone();
    notes.extend(built.notes);
    Ok(SweepReading {
        curve: built.curve,
        report: SweepReport {
            path: String::new(),
            format: Format::Text,
            sha256: String::new(),
            bytes: 0,
            sheet: String::new(),
            rows_read: built.rows_read,
            skipped: built.skipped,
            dialect: None,
            taken: taken(&choice, &columns),
            kind: choice.kind,
            named: choice.named,
            columns,
            column_runs: choice.runs,
            column_run: choice.run,
            named_values: table.named_values.clone(),
            runs: Vec::new(),
            files_left_out: 0,
            notes,
        },
    })
}

fn taken(choice: &Choice, columns: &[ColumnInfo]) -> Vec<(&'static str, ColumnTaken)> {
    let mut list = match &choice.frequency {
        Frequency::Plain(p, _) => vec![("frequency", p)],
        Frequency::Period(p, _) => vec![("period", p)],
        Frequency::Shift(p, _, Centre::Hz(_)) => vec![("shift", p)],
        Frequency::Shift(p, _, Centre::Column(c, _)) => vec![("shift", p), ("centre", c)],
    };
    match &choice.response {
        Response::Amplitude { amplitude, phase, .. } => {
            list.push(("amplitude", amplitude));
            list.extend(phase.as_ref().map(|(p, _)| ("phase", p)));
        }
        Response::Complex(re, im) => list.extend([("real", re), ("imaginary", im)]),
        Response::Admittance(g, b) => {
            list.push(("conductance", g));
            list.extend(b.as_ref().map(|b| ("susceptance", b)));
        }
        Response::Impedance(r, x) => {
            list.push(("resistance", r));
            list.extend(x.as_ref().map(|x| ("reactance", x)));
        }
    }
    list.extend(choice.drive.as_ref().map(|d| ("drive", d)));
    list.extend(choice.std_error.as_ref().map(|e| ("std_error", e)));
    list.into_iter().map(|(what, picked)| (what, picked.taken(columns))).collect()
}

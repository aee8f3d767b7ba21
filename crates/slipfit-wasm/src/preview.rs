//! Preview of a file: its tables and the analysis it is for.

use crate::refusal::Refusal;
use crate::{Analysis, File, Options};
use serde::Serialize;
use slipfit::{LossModel, LossTerm};
use slipfit_io::{ReadOptions, Table};

/// Rows of each table that are read.
const PREVIEW_ROWS: usize = 20_000;

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Preview {
    /// What kind of file it is.
    pub format: String,
    /// Its tables.
    pub tables: Vec<PreviewTable>,
    /// What it is for, unless the person chose.
    pub analysis: Analysis,
    /// Loss models that can be asked for by name in a free decay: those compared by default, and viscous damping
    /// beside each further law.
    pub models: Vec<String>,
}

/// A table of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreviewTable {
    /// Sheet, variable or group; empty where there is one only.
    pub name: String,
    /// Rows read for it.
    pub rows: usize,
    /// Its columns.
    pub columns: Vec<PreviewColumn>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreviewColumn {
    /// From 1.
    pub number: usize,
    /// Its header; empty without one.
    pub header: String,
}

/// Looks at a file without an analysis.
///
/// # Errors
/// [`Refusal`] where it holds no table, or is of a format that cannot be read here.
///
/// ```
/// use slipfit_wasm::{Analysis, File, Options, preview};
/// let bytes = b"f (Hz),R (V)\n99,0.1\n100,0.7\n101,0.2\n";
/// let seen = preview(&File { name: "sweep.csv", bytes }, &Options::default()).unwrap();
/// assert_eq!((seen.analysis, seen.tables[0].columns.len()), (Analysis::Resonance, 2));
/// ```
pub fn preview(file: &File<'_>, options: &Options) -> Result<Preview, Refusal> {
    // A column, a unit or a rate is of one analysis; what a file is does not turn on it.
    let chosen = options.read_options(Analysis::Levels)?;
    let reading = ReadOptions { format: chosen.format, sheet: chosen.sheet, ..ReadOptions::default() };
    let seen = slipfit_io::glance_from(file.bytes, file.name, PREVIEW_ROWS, &reading, Some(&reading))?;
    let tables = &seen.tables.tables;
    let is_sweep = seen.curve.is_some() || seen.record.is_err() && tables.iter().any(Table::is_sweep);
    let analysis = match options.analysis {
        Some(analysis) => analysis,
        None if is_sweep => Analysis::Resonance,
        None if seen.record.is_err() && names_levels(file, &reading) => Analysis::Levels,
        None => Analysis::Ringdown,
    };
    let table = |table: &Table| PreviewTable {
        name: table.name.clone(),
        rows: table.rows(),
        columns: (1..)
            .zip(&table.columns)
            .map(|(number, c)| PreviewColumn { number, header: c.header.clone() })
            .collect(),
    };
    Ok(Preview {
        format: seen.tables.format.name().to_owned(),
        tables: tables.iter().map(table).collect(),
        analysis,
        models: models(),
    })
}

fn models() -> Vec<String> {
    let mut models: Vec<LossModel> = LossModel::compared(None).collect();
    let beside_viscous =
        LossTerm::ALL.iter().filter_map(|term| LossModel::from_terms(&[LossTerm::Viscous, *term]));
    for model in beside_viscous {
        if !models.contains(&model) {
            models.push(model);
        }
    }
    models.iter().map(ToString::to_string).collect()
}

/// Whether the file says itself that it holds amplitudes over levels of a drive.
fn names_levels(file: &File<'_>, reading: &ReadOptions) -> bool {
    slipfit_io::read_levels_from(file.bytes, file.name, reading).is_ok_and(|levels| levels.report.named)
}

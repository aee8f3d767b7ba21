//! Preview of a file: its tables and the analysis it is for.

use crate::refusal::Refusal;
use crate::{Analysis, File, Options};
use serde::Serialize;
use slipfit::{LossModel, LossTerm};
use slipfit_io::{Column, ReadOptions, Reading, Table};

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

/// A preview with what it was read by.
#[derive(Debug)]
pub(crate) struct Seen {
    pub(crate) read_by: ReadOptions,
    /// Its analysis is that of the file.
    found: Preview,
}

impl Seen {
    /// How a file is looked at: a column, a unit or a rate is of one analysis; what a file is does not turn on it.
    pub(crate) fn read_by(options: &Options) -> Result<ReadOptions, Refusal> {
        let chosen = options.read_options(Analysis::Levels)?;
        Ok(ReadOptions { format: chosen.format, sheet: chosen.sheet, ..ReadOptions::default() })
    }

    /// Looks at a file; gives the record besides, where all of it has been read.
    pub(crate) fn new(file: &File<'_>, read_by: ReadOptions) -> Result<(Self, Option<Reading>), Refusal> {
        let seen = slipfit_io::glance_from(file.bytes, file.name, PREVIEW_ROWS, &read_by, Some(&read_by))?;
        let tables = &seen.tables.tables;
        let is_sweep = seen.curve.is_some() || seen.record.is_err() && tables.iter().any(Table::is_sweep);
        let analysis = if is_sweep {
            Analysis::Resonance
        } else if seen.record.is_err() && names_levels(file, &read_by) {
            Analysis::Levels
        } else {
            Analysis::Ringdown
        };
        let found = Preview {
            format: seen.tables.format.name().to_owned(),
            tables: tables.iter().map(PreviewTable::from).collect(),
            analysis,
            models: models(),
        };
        let record = seen.record.ok().filter(|_| !seen.in_part);
        Ok((Self { read_by, found }, record))
    }

    /// What the file holds; `analysis` where the person chose.
    pub(crate) fn preview(&self, analysis: Option<Analysis>) -> Preview {
        Preview { analysis: analysis.unwrap_or(self.found.analysis), ..self.found.clone() }
    }
}

impl From<&Table> for PreviewTable {
    fn from(table: &Table) -> Self {
        let column = |(number, c): (usize, &Column)| PreviewColumn { number, header: c.header.clone() };
        Self {
            name: table.name.clone(),
            rows: table.rows(),
            columns: (1..).zip(&table.columns).map(column).collect(),
        }
    }
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

//! Preview of a file: its tables and the analysis it is for.

use crate::refusal::Refusal;
use crate::{Analysis, File, Options};
use serde::Serialize;
use slipfit::{LossModel, LossTerm};
use slipfit_io::{Column, ReadOptions, Reading, Table};

/// Number of rows of each table that are read.
const PREVIEW_ROWS: usize = 20_000;

/// Contents of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Preview {
    /// What kind of file it is.
    pub format: String,
    /// Its tables.
    pub tables: Vec<PreviewTable>,
    /// The analysis the file is suited for, unless the user chose one.
    pub analysis: Analysis,
    /// Loss models that can be requested by name for a free decay: those compared by default, and viscous damping
    /// with each further law.
    pub models: Vec<String>,
}

/// A table of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreviewTable {
    /// Sheet, variable or group; empty if there is only one.
    pub name: String,
    /// Number of rows read for it.
    pub rows: usize,
    /// Its columns.
    pub columns: Vec<PreviewColumn>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreviewColumn {
    /// Its number, from 1.
    pub number: usize,
    /// Its header; empty without one.
    pub header: String,
}

/// A preview with the options it was read with.
#[derive(Debug)]
pub(crate) struct CachedPreview {
    pub(crate) read_by: ReadOptions,
    /// Its analysis is the one suggested by the file.
    found: Preview,
}

impl CachedPreview {
    /// The options for looking at a file. A column, a unit or a rate belongs to one analysis and does not decide
    /// what the file is.
    pub(crate) fn read_by(options: &Options) -> Result<ReadOptions, Refusal> {
        let chosen = options.read_options(Analysis::Levels)?;
        Ok(ReadOptions { format: chosen.format, sheet: chosen.sheet, ..ReadOptions::default() })
    }

    /// Looks at a file; also returns the record if all of it has been read.
    pub(crate) fn new(file: &File<'_>, read_by: ReadOptions) -> Result<(Self, Option<Reading>), Refusal> {
        let glance = slipfit_io::glance_from(file.bytes, file.name, PREVIEW_ROWS, &read_by, Some(&read_by))?;
        let tables = &glance.tables.tables;
        let is_sweep = glance.curve.is_some() || glance.record.is_err() && tables.iter().any(Table::is_sweep);
        let analysis = if is_sweep {
            Analysis::Resonance
        } else if glance.record.is_err() && names_levels(file, &read_by) {
            Analysis::Levels
        } else {
            Analysis::Ringdown
        };
        let found = Preview {
            format: glance.tables.format.name().to_owned(),
            tables: tables.iter().map(PreviewTable::from).collect(),
            analysis,
            models: models(),
        };
        let record = glance.record.ok().filter(|_| !glance.in_part);
        Ok((Self { read_by, found }, record))
    }

    /// Contents of the file, with `analysis` if the user chose one.
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

/// Whether the file itself states that it holds amplitudes against drive levels.
fn names_levels(file: &File<'_>, reading: &ReadOptions) -> bool {
    slipfit_io::read_levels_from(file.bytes, file.name, reading).is_ok_and(|levels| levels.report.named)
}

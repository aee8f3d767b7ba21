//! A resonance curve from a table, or from a folder of driven records.

use std::path::PathBuf;

use super::{
    driven,
    open::{Origin, gathered, opened},
    pick,
};
use crate::{
    columns::{curve, points},
    error::{ReadError, ReadProblem},
    options::ReadOptions,
    report::{Note, ReadReport, SweepReading},
    tables::table::{LoadedTable, TableSource},
};

/// Reads a curve from one file that contains it, or from several files or a folder of driven records.
pub(crate) fn read_paths(paths: &[PathBuf], options: &ReadOptions) -> Result<SweepReading, ReadError> {
    match paths {
        [one] if one.is_dir() => {
            let name = one.display().to_string();
            let files = driven::files(one).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))?;
            if files.is_empty() {
                return Err(ReadError::new(&name, ReadProblem::NoFiles));
            }
            driven::read(&files, &name, options)
        }
        [one] => {
            let (origin, name) = Origin::file(one)?;
            read(origin, &name, options)
        }
        [] => Err(ReadError::new("no file", ReadProblem::Empty)),
        several => {
            let name = format!("{} and {} more", several[0].display(), several.len() - 1);
            driven::read(several, &name, options)
        }
    }
}

/// Reads the curve of the requested table, or of the first one that contains a curve.
pub(crate) fn read(origin: Origin<'_>, name: &str, options: &ReadOptions) -> Result<SweepReading, ReadError> {
    let from_source = |source: &mut dyn TableSource| {
        options.check_for_curve()?;
        let tables = gathered(source, usize::MAX)?;
        from_tables(&tables, options)
    };
    let (mut reading, fingerprint) =
        opened(origin, options.format, None, from_source).map_err(|problem| ReadError::new(name, problem))?;
    fingerprint.write(&mut reading.report, name);
    Ok(reading)
}

/// The curve of the requested table, or of the first one that contains a curve.
pub(super) fn from_tables(
    tables: &[LoadedTable],
    options: &ReadOptions,
) -> Result<SweepReading, ReadProblem> {
    let names: Vec<&str> = tables.iter().map(|t| t.head.name.as_str()).collect();
    let candidates: Vec<usize> = match &options.sheet {
        Some(wanted) => {
            let is_text = tables.iter().any(|table| table.dialect.is_some());
            vec![pick::find(wanted, &names, is_text)?]
        }
        None => (0..tables.len()).collect(),
    };
    let mut problem = None;
    for index in candidates {
        match from_table(&tables[index], options) {
            Ok(mut reading) => {
                if tables.len() > 1 && options.sheet.is_none() {
                    let (count, name) = (tables.len(), names[index]);
                    let text = format!("of {count} tables, `{name}` was read, the first that holds a curve");
                    let others = format!("reads another: {}", pick::others(&names, index));
                    reading.report.notes.push(Note::new(text).hint("sheet", others));
                }
                return Ok(reading);
            }
            Err(e) => problem = problem.or(Some(e)),
        }
    }
    Err(problem.unwrap_or(ReadProblem::Empty))
}

fn from_table(table: &LoadedTable, options: &ReadOptions) -> Result<SweepReading, ReadProblem> {
    let LoadedTable { head, columns, skipped, dialect, .. } = table;
    let first_row = dialect.as_ref().map(|d| d.first_data_row);
    let choice = curve::choose(head, columns, options)?;
    // Rows are lines of the file only if none was left out.
    let first_row = first_row.filter(|_| skipped.is_empty()).unwrap_or(1);
    let built = points::build(head, columns, &choice, first_row, skipped.clone())?;
    let mut notes = choice.notes.clone();
    notes.extend(built.notes);
    let report = ReadReport {
        dialect: dialect.clone(),
        rows_read: built.rows_read,
        skipped: built.skipped,
        taken: choice.columns().into_iter().map(|(what, chosen)| (what, chosen.taken(head))).collect(),
        kind: choice.kind,
        named: choice.named,
        runs: choice.runs,
        run: choice.run,
        notes,
        ..head.report()
    };
    Ok(SweepReading { curve: built.curve, report })
}

//! Sheets of a workbook, written out as text so that the text reader finds headers, units, tables side by side and runs
//! in them as in any other table.

use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(crate) use super::cell::Cell;
use super::{
    cell::Place,
    side_cells,
    table::{LoadedTable, LoadedTables},
    text,
};
use crate::{
    columns::{named, stated},
    error::ReadProblem,
    report::Decimal,
};

/// The cells of one sheet by row and column.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) name: String,
    /// Whether cells were left unread because enough had been read.
    pub(crate) cut: bool,
    cells: BTreeMap<Place, Cell>,
}

impl Sheet {
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    pub(crate) fn set(&mut self, row: u32, column: u32, cell: Cell) {
        self.cells.insert((row, column), cell);
    }

    /// The tables in it from top to bottom, or the reason why there is none; cells beside them become named values.
    fn tables(&self) -> Result<Vec<LoadedTable>, String> {
        let side_cells = side_cells::find(&self.cells);
        let text = self.text(&side_cells)?;
        let mut tables = text::load_tables(text.as_bytes()).map_err(|problem| match problem {
            ReadProblem::Empty => "it is empty".to_owned(),
            other => other.to_string(),
        })?;
        let (lines, note) = side_cells::lines(&self.cells, &side_cells);
        let stated_rate_hz = stated::rate_hz(lines.iter().map(String::as_str), &['\t'], Decimal::Point);
        let named_values = named::values(lines.into_iter());
        for table in &mut tables {
            table.head.stated_rate_hz = table.head.stated_rate_hz.or(stated_rate_hz);
            table.head.named_values.extend_from_slice(&named_values);
            table.head.notes.extend(note.clone().map(Into::into));
            (table.cut, table.dialect) = (self.cut, None);
        }
        Ok(tables)
    }

    /// One line per row with tabs between the cells, excluding `side_cells`, or the reason why this is not possible.
    fn text(&self, side_cells: &[Place]) -> Result<String, String> {
        let within = || self.cells.iter().filter(|(place, _)| side_cells.binary_search(place).is_err());
        // A single remote cell would give a line of tabs only; the number of tabs is limited by that of cells.
        let mut wide: BTreeMap<u32, u32> = BTreeMap::new();
        for (&(row, column), _) in within() {
            wide.entry(row).and_modify(|w| *w = column.max(*w)).or_insert(column);
        }
        let tabs: u64 = wide.values().map(|w| u64::from(*w)).sum();
        let rows = wide.keys().next_back().map_or(0, |r| u64::from(*r));
        let cells = (self.cells.len() - side_cells.len()) as u64;
        if tabs + rows > 64 * cells + (1 << 16) {
            return Err(format!("its {cells} cells are scattered over {rows} rows"));
        }
        let mut text = String::with_capacity(self.cells.len() * 8);
        let (mut at_row, mut at_column) = (0, 0);
        for (&(row, column), cell) in within() {
            while at_row < row {
                text.push('\n');
                (at_row, at_column) = (at_row + 1, 0);
            }
            while at_column < column {
                text.push('\t');
                at_column += 1;
            }
            match cell {
                Cell::Number(value) => {
                    // Writing to a String cannot fail. The shortest form reads back exactly.
                    let _ = write!(text, "{value:?}");
                }
                Cell::Text(words) => {
                    text.extend(words.chars().map(|c| if c.is_control() { ' ' } else { c }));
                }
            }
        }
        text.push('\n');
        Ok(text)
    }
}

/// The tables of all sheets that contain one, and the reasons why the others do not.
pub(crate) fn tables(sheets: &[Sheet]) -> Result<LoadedTables, String> {
    let mut tables = LoadedTables::default();
    let mut problems = Vec::new();
    for sheet in sheets {
        match sheet.tables() {
            Ok(loaded) => tables.absorb(loaded, &sheet.name),
            Err(problem) => problems.push(format!("sheet `{}`: {problem}", sheet.name)),
        }
    }
    if tables.is_empty() {
        return Err(if problems.is_empty() { "it has no sheet".to_owned() } else { problems.join("; ") });
    }
    tables.note_all(&problems);
    Ok(tables)
}

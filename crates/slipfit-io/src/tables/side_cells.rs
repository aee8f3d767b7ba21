//! Cells beside the table of a sheet, such as a mean or the length of a pendulum, which are not part of its rows.

use std::collections::BTreeMap;

use super::cell::{Cell, Place};

/// Number of rows after the first row of a table, most of which must also hold a number.
const LOOK_AHEAD: u32 = 5;
/// Number of cells in a column that is too short for a record or a curve.
const FEW_CELLS: usize = 8;
/// Maximum number of cells in a column beside a much longer table.
const MOST_SIDE_CELLS: usize = 64;
/// Number of lines shown in a note.
const SHOWN: usize = 4;

/// The cells beside the table, in order: those of columns that hold few cells and end in the first half of the table.
pub(super) fn find(cells: &BTreeMap<Place, Cell>) -> Vec<Place> {
    let Some(first_row) = first_row(cells) else { return Vec::new() };
    // For each column, the number of cells below the header and the last row with a cell.
    let mut columns: BTreeMap<u32, (usize, u32)> = BTreeMap::new();
    for &(row, column) in cells.range((first_row, 0)..).map(|(place, _)| place) {
        let (count, last) = columns.entry(column).or_default();
        (*count, *last) = (*count + 1, row);
    }
    let (most, last_row) =
        columns.values().fold((0, first_row), |(most, end), (n, last)| (most.max(*n), end.max(*last)));
    let is_side_column = |column: u32| {
        columns.get(&column).is_none_or(|&(count, last)| {
            let few = count < FEW_CELLS && 2 * count < most || count < MOST_SIDE_CELLS && 8 * count < most;
            few && 2 * (last - first_row) < last_row - first_row
        })
    };
    let table: Vec<u32> = columns.keys().copied().filter(|&column| !is_side_column(column)).collect();
    let Some(&left) = table.first() else { return Vec::new() };
    let header = (0..first_row).rev().take(2).take_while(|row| is_header(cells, *row, &table)).last();
    // Without a header, settings in front of the samples may be rows themselves.
    let is_excluded = |column: u32| is_side_column(column) && (column > left || header.is_some());
    let below = cells.range((header.unwrap_or(first_row), 0)..);
    below.map(|(place, _)| *place).filter(|(_, column)| is_excluded(*column)).collect()
}

/// The first row of the column with the most numbers.
fn first_row(cells: &BTreeMap<Place, Cell>) -> Option<u32> {
    let is_number = |cell: &Cell| matches!(cell, Cell::Number(_));
    let mut numbers: BTreeMap<u32, usize> = BTreeMap::new();
    for ((_, column), _) in cells.iter().filter(|(_, cell)| is_number(cell)) {
        *numbers.entry(*column).or_default() += 1;
    }
    let (&column, _) = numbers.iter().rev().max_by_key(|(_, count)| **count)?;
    let holds = |row: u32| cells.get(&(row, column)).is_some_and(is_number);
    let begins =
        |row: &u32| (1..=LOOK_AHEAD).filter(|offset| holds(row + offset)).count() + 1 >= LOOK_AHEAD as usize;
    let rows =
        cells.iter().filter(|((_, at), cell)| *at == column && is_number(cell)).map(|((row, _), _)| *row);
    rows.into_iter().find(begins)
}

/// Whether a row names most columns of a table. A single column may have a statement such as `Sample rate`, `100`, `Hz`
/// above it.
fn is_header(cells: &BTreeMap<Place, Cell>, row: u32, table: &[u32]) -> bool {
    let is_text = |column: u32| matches!(cells.get(&(row, column)), Some(Cell::Text(_)));
    let named = table.iter().filter(|column| is_text(**column)).count();
    let states_a_number = || {
        let cells_of_row = (table[0]..).map_while(|column| cells.get(&(row, column)));
        cells_of_row.into_iter().any(|cell| matches!(cell, Cell::Number(_)))
    };
    2 * named > table.len() && (table.len() > 1 || !states_a_number())
}

/// The cells as lines of text, and a note on them.
pub(super) fn lines(cells: &BTreeMap<Place, Cell>, side_cells: &[Place]) -> (Vec<String>, Option<String>) {
    let rows = side_cells.chunk_by(|a, b| a.0 == b.0);
    let lines: Vec<String> = rows
        .map(|row| {
            let words = row.iter().filter_map(|place| cells.get(place)).map(|cell| match cell {
                Cell::Number(value) => value.to_string(),
                Cell::Text(words) => words.clone(),
            });
            words.collect::<Vec<_>>().join("\t")
        })
        .collect();
    let (Some(first), Some(last)) = (side_cells.first(), side_cells.last()) else { return (lines, None) };
    let places = if side_cells.len() == 1 {
        format!("cell {}", name(*first))
    } else {
        format!("{} cells, {} to {},", side_cells.len(), name(*first), name(*last))
    };
    let shown: Vec<String> =
        lines.iter().take(SHOWN).map(|line| format!("`{}`", line.replace('\t', " "))).collect();
    let more = if lines.len() > SHOWN { ", …" } else { "" };
    let note = format!("left out {places} next to the table: {}{more}", shown.join(", "));
    (lines, Some(note))
}

/// A cell reference as used in spreadsheets.
fn name((row, column): Place) -> String {
    let (mut letters, mut left) = (Vec::new(), column + 1);
    while left > 0 {
        left -= 1;
        letters.push(char::from(b'A' + (left % 26) as u8));
        left /= 26;
    }
    format!("{}{}", letters.iter().rev().collect::<String>(), u64::from(row) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header, sixty rows of two columns, and cells beside them.
    fn sheet(side_cells: &[(Place, Cell)]) -> BTreeMap<Place, Cell> {
        let rows = (1..61).flat_map(|row| [0, 1].map(|column| ((row, column), Cell::Number(f64::from(row)))));
        let names = ["t (s)", "x (mm)"].map(|name| Cell::Text(name.to_owned()));
        let header = (0..).zip(names).map(|(column, name)| ((0, column), name));
        rows.chain(header).chain(side_cells.iter().cloned()).collect()
    }

    fn word(place: Place) -> (Place, Cell) {
        (place, Cell::Text("Mean".to_owned()))
    }

    #[test]
    fn cells_beside_the_first_rows_are_told_from_columns() {
        let number = |place| (place, Cell::Number(0.5));
        for side_cells in [
            vec![word((1, 3)), number((1, 4))],
            // In the row of the header, and next to it without a gap.
            vec![word((0, 2)), number((1, 2))],
            vec![word((9, 7)), number((10, 7))],
        ] {
            let places: Vec<Place> = side_cells.iter().map(|(place, _)| *place).collect();
            assert_eq!(find(&sheet(&side_cells)), places);
        }
        let sparse: Vec<_> = (0..61).step_by(12).map(|row| number((row, 2))).collect();
        let shorter: Vec<_> = (1..21).map(|row| number((row, 4))).collect();
        for part in [Vec::new(), sparse, shorter] {
            assert_eq!(find(&sheet(&part)), []);
        }
    }

    #[test]
    fn cells_are_named_as_spreadsheets_name_them() {
        assert_eq!([(0, 0), (11, 27), (1_048_575, 16_383)].map(name), ["A1", "AB12", "XFD1048576"]);
    }
}

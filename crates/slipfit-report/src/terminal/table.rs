//! Tables on the screen.

use super::{CHOSEN, DIM, HEADING, WIDTH};
use crate::document::Table;
use crate::escape;

/// Alignment of a cell in its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Align {
    Left,
    Right,
}

fn widths(rows: &[Vec<String>], columns: usize) -> Vec<usize> {
    (0..columns)
        .map(|c| rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0))
        .collect()
}

/// Width of rows laid out two blanks apart.
pub(crate) fn width(rows: &[Vec<String>]) -> usize {
    let widths = widths(rows, rows.iter().map(Vec::len).max().unwrap_or(0));
    let filled = widths.iter().filter(|w| **w > 0).count();
    widths.iter().sum::<usize>() + 2 * filled.saturating_sub(1)
}

/// Lays rows out in columns two blanks apart, or one blank if the screen is too narrow; columns that are empty in
/// every row are left out.
pub(crate) fn columns(rows: &[Vec<String>], align: &[Align]) -> Vec<String> {
    let inert = |cell: &String| escape::terminal(cell).replace('\n', " ");
    let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(inert).collect()).collect();
    let rows = &rows[..];
    let widths = widths(rows, align.len());
    // Two columns are used by the margin.
    let gap = if width(rows) + 2 <= WIDTH { "  " } else { " " };
    rows.iter()
        .map(|row| {
            let mut line = String::new();
            for ((cell, &width), align) in row.iter().zip(&widths).zip(align) {
                if width == 0 {
                    continue;
                }
                if !line.is_empty() {
                    line.push_str(gap);
                }
                // Widths in characters: every symbol used here takes one column.
                let blanks = " ".repeat(width - cell.chars().count());
                match align {
                    Align::Left => line.extend([cell.as_str(), &blanks]),
                    Align::Right => line.extend([blanks.as_str(), cell]),
                }
            }
            line.trim_end().to_owned()
        })
        .collect()
}

/// A table with coloured headings and the reported row marked.
pub(super) fn styled(table: &Table) -> String {
    let (heads, rows) = lines(table);
    let count = heads.len();
    let all: Vec<Vec<String>> = heads.into_iter().chain(rows).collect();
    let mut align = vec![Align::Right; all[0].len()];
    align[0] = Align::Left;
    let mut text = String::new();
    for (i, line) in columns(&all, &align).iter().enumerate() {
        text += &match (i.checked_sub(count), table.chosen) {
            (None, _) => format!("  {HEADING}{line}{HEADING:#}\n"),
            (_, None) => format!("  {line}\n"),
            (row, chosen) if row == chosen => format!("{CHOSEN}> {line}{CHOSEN:#}\n"),
            _ => format!("  {DIM}{line}{DIM:#}\n"),
        };
    }
    if !table.note.is_empty() {
        text += &format!("  {DIM}{}{DIM:#}\n", table.note);
    }
    text
}

/// Headings, in two lines if columns are grouped or the line is too wide, else in one; and the rows below them.
fn lines(table: &Table) -> (Vec<Vec<String>>, Vec<Vec<String>>) {
    let (own, rows) = table.split();
    let rows = rows.to_vec();
    if !table.groups.is_empty() {
        return (vec![table.group_of_each(), own.to_vec()], rows);
    }
    if width(&table.rows) + 2 <= WIDTH {
        return (vec![own.to_vec()], rows);
    }
    // The name goes above its unit.
    let split =
        |cell: &String| cell.split_once(" [").map(|(name, unit)| [name.to_owned(), format!("[{unit}")]);
    let halves: Vec<[String; 2]> =
        own.iter().map(|cell| split(cell).unwrap_or_else(|| [String::new(), cell.clone()])).collect();
    let line = |at: usize| halves.iter().map(|h| h[at].clone()).collect::<Vec<String>>();
    (vec![line(0), line(1)], rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_line_up_and_empty_columns_vanish() {
        let rows = [vec!["f", "", "1.5"], vec!["x_F", "", "10.25"]]
            .map(|r| r.into_iter().map(str::to_owned).collect());
        assert_eq!(columns(&rows, &[Align::Left, Align::Left, Align::Right]), ["f      1.5", "x_F  10.25"]);
    }
}

//! Columns that line up.

/// Which side of its column a cell keeps to.
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

/// Lays rows out in columns two blanks apart, or one where the screen demands
/// it; columns empty in every row vanish.
pub(crate) fn columns(rows: &[Vec<String>], align: &[Align]) -> Vec<String> {
    let widths = widths(rows, align.len());
    // Two of the columns are the margin.
    let gap = if width(rows) + 2 <= super::WIDTH { "  " } else { " " };
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

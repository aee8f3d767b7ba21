//! How a file separates cells and writes fractions.

use memchr::memchr;

use super::number::{self, Cell};
use crate::report::{Decimal, Delimiter};

/// Characters that begin a remark.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    matches!(line.first(), Some(b'#' | b'%')) || line.starts_with(b"//")
}

/// The single byte between two cells, where there is one.
pub(super) fn separator(delimiter: Delimiter) -> Option<u8> {
    match delimiter {
        Delimiter::Comma => Some(b','),
        Delimiter::Semicolon => Some(b';'),
        Delimiter::Tab => Some(b'\t'),
        Delimiter::Bar => Some(b'|'),
        Delimiter::Blanks | Delimiter::None => None,
    }
}

/// The cells of a line, quotes heeded and kept.
pub(super) fn cells(line: &[u8], delimiter: Delimiter) -> Vec<&[u8]> {
    match separator(delimiter) {
        Some(separator) => separated(line, separator),
        None if delimiter == Delimiter::None => vec![line],
        None => line.split(u8::is_ascii_whitespace).filter(|c| !c.is_empty()).collect(),
    }
}

fn separated(line: &[u8], separator: u8) -> Vec<&[u8]> {
    if memchr(b'"', line).is_none() {
        return line.split(|b| *b == separator).collect();
    }
    let (mut cells, mut start, mut quoted) = (Vec::new(), 0, false);
    for (i, &byte) in line.iter().enumerate() {
        if byte == b'"' {
            // A quote opens a cell only at its beginning; inches stand inside.
            quoted =
                if quoted { false } else { line[start..i].trim_ascii().is_empty() || ends_quote(line, i) };
        } else if byte == separator && !quoted {
            cells.push(&line[start..i]);
            start = i + 1;
        }
    }
    cells.push(&line[start..]);
    cells
}

/// Whether the quote at `i` is the second of a doubled one.
fn ends_quote(line: &[u8], i: usize) -> bool {
    i > 0 && line[i - 1] == b'"'
}

/// What kind of row a line is in a dialect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowKind {
    Blank,
    Comment,
    /// So many cells, every one a number or missing, and a number among them.
    Numbers(usize),
    /// Anything else.
    Text(usize),
}

/// The kind of a line; `words` tells whether a row of numbers may hold other cells too.
pub(super) fn row_kind(line: &[u8], delimiter: Delimiter, decimal: Decimal, words: bool) -> RowKind {
    if line.trim_ascii().is_empty() {
        return RowKind::Blank;
    }
    if is_comment(line) {
        return RowKind::Comment;
    }
    let cells = cells(line, delimiter);
    let mut numbers = 0;
    for cell in &cells {
        match number::cell(cell, decimal) {
            Cell::Number(_) => numbers += 1,
            Cell::Text if !words => return RowKind::Text(cells.len()),
            Cell::Missing | Cell::Text => {}
        }
    }
    if numbers > 0 { RowKind::Numbers(cells.len()) } else { RowKind::Text(cells.len()) }
}

/// Delimiter, decimal mark and the most common number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) delimiter: Delimiter,
    pub(super) decimal: Decimal,
    pub(super) width: usize,
    /// Whether the rows hold words beside their numbers.
    pub(super) words: bool,
}

/// Lines looked at closely.
const FIRST: usize = 150;

/// In order of preference where several fit equally well.
const CANDIDATES: &[(Delimiter, Decimal)] = &[
    (Delimiter::Tab, Decimal::Point),
    (Delimiter::Semicolon, Decimal::Point),
    (Delimiter::Tab, Decimal::Comma),
    (Delimiter::Semicolon, Decimal::Comma),
    (Delimiter::Bar, Decimal::Point),
    (Delimiter::Bar, Decimal::Comma),
    (Delimiter::Comma, Decimal::Point),
    (Delimiter::Blanks, Decimal::Point),
    (Delimiter::Blanks, Decimal::Comma),
    // Every number in quotes.
    (Delimiter::Comma, Decimal::Comma),
];

/// The dialect in which most lines are rows of numbers.
pub(super) fn detect(lines: &[&[u8]]) -> Option<Shape> {
    // The first lines, where preambles are, and a sample of the others.
    let (first, others) = lines.split_at(lines.len().min(FIRST));
    let stride = others.len().div_ceil(FIRST).max(1);
    let lines: Vec<&[u8]> = first.iter().chain(others.iter().step_by(stride)).copied().collect();
    detect_rows(&lines, false).or_else(|| {
        // Rows with words in them are a table only where nearly all lines are such rows.
        let shape = detect_rows(&lines, true)?;
        let row = RowKind::Numbers(shape.width);
        let rows = lines.iter().filter(|l| row_kind(l, shape.delimiter, shape.decimal, true) == row).count();
        (shape.width > 1 && rows >= 8 && rows * 5 >= lines.len() * 4).then_some(shape)
    })
}

fn detect_rows(lines: &[&[u8]], words: bool) -> Option<Shape> {
    let mut best: Option<(usize, Shape)> = None;
    let occurs = |byte: u8| lines.iter().any(|line| memchr(byte, line).is_some());
    let mut undivided: Vec<Decimal> = Vec::new();
    for &(delimiter, decimal) in CANDIDATES {
        // Without a separator in them lines are one cell each, whichever it is.
        if separator(delimiter).is_some_and(|byte| !occurs(byte)) {
            if undivided.contains(&decimal) {
                continue;
            }
            undivided.push(decimal);
        }
        let widths: Vec<usize> = lines
            .iter()
            .filter_map(|line| match row_kind(line, delimiter, decimal, words) {
                RowKind::Numbers(width) => Some(width),
                _ => None,
            })
            .collect();
        let Some(width) = mode(&widths) else { continue };
        let shape = Shape { delimiter, decimal, width, words };
        let rows = widths.len();
        // One cell a row is what any wrong delimiter gives.
        let better = best.is_none_or(|(most, held)| {
            let clearly = rows * 50 > most * 51;
            let as_good = rows * 51 >= most * 50;
            clearly || (as_good && held.width == 1 && width > 1)
        });
        if better {
            best = Some((rows, shape));
        }
    }
    let (_, mut shape) = best?;
    if shape.delimiter == Delimiter::Comma && is_decimal_comma(lines) {
        shape = Shape { delimiter: Delimiter::None, decimal: Decimal::Comma, width: 1, words };
    }
    if shape.width == 1 {
        shape.delimiter = Delimiter::None;
    }
    Some(shape)
}

/// Whether commas that could separate pairs of integers are decimal marks of
/// single numbers: `38,0169` is.
fn is_decimal_comma(lines: &[&[u8]]) -> bool {
    let (mut pairs, mut lengths, mut header) = (0_usize, Vec::new(), None);
    for line in lines {
        match row_kind(line, Delimiter::Comma, Decimal::Point, false) {
            RowKind::Numbers(1) => {}
            RowKind::Numbers(2) => {
                let cells = separated(line, b',');
                let (left, right) = (number::trim(cells[0]), number::trim(cells[1]));
                if !is_integer(left) || right.is_empty() || !right.iter().all(u8::is_ascii_digit) {
                    return false;
                }
                if left == b"-0" || (right.len() > 1 && right[0] == b'0') {
                    return true;
                }
                pairs += 1;
                lengths.push(right.len());
            }
            RowKind::Numbers(_) => return false,
            RowKind::Text(width) if pairs == 0 => header = Some(width),
            _ => {}
        }
    }
    match header {
        Some(1) => pairs > 0,
        Some(_) => false,
        None => pairs > 0 && lengths[0] > 1 && lengths.iter().all(|l| *l == lengths[0]),
    }
}

fn is_integer(cell: &[u8]) -> bool {
    let digits = cell.strip_prefix(b"-").or_else(|| cell.strip_prefix(b"+")).unwrap_or(cell);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

/// The most common value; of equals the greater.
fn mode(values: &[usize]) -> Option<usize> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    sorted.chunk_by(|a, b| a == b).max_by_key(|same| (same.len(), same[0])).map(|same| same[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(text: &str) -> (Delimiter, Decimal, usize) {
        let lines: Vec<&[u8]> = text.lines().map(str::as_bytes).collect();
        let shape = detect(&lines).unwrap();
        (shape.delimiter, shape.decimal, shape.width)
    }

    #[test]
    fn dialects_are_told_apart() {
        assert_eq!(shape("0.1,2\n0.2,3\n"), (Delimiter::Comma, Decimal::Point, 2));
        assert_eq!(shape("0.1, 2\n0.2, 3\n"), (Delimiter::Comma, Decimal::Point, 2));
        assert_eq!(shape("0,1;2\n0,2;3,5\n"), (Delimiter::Semicolon, Decimal::Comma, 2));
        assert_eq!(shape("1;2\n2;3\n"), (Delimiter::Semicolon, Decimal::Point, 2));
        assert_eq!(shape("0,1\t2\n0,2\t3\n"), (Delimiter::Tab, Decimal::Comma, 2));
        assert_eq!(shape("0.1\t\t2\n0.2\t\t3\n"), (Delimiter::Tab, Decimal::Point, 3));
        assert_eq!(shape(" 0.1   2\n 10.2  3\n"), (Delimiter::Blanks, Decimal::Point, 2));
        assert_eq!(shape("0,1 2,5\n0,2 3,5\n"), (Delimiter::Blanks, Decimal::Comma, 2));
        assert_eq!(shape("\"0,1\",\"2,5\"\n"), (Delimiter::Comma, Decimal::Comma, 2));
        assert_eq!(shape("0.1|2\n0.2|3\n"), (Delimiter::Bar, Decimal::Point, 2));
    }

    #[test]
    fn a_lone_column_with_decimal_commas_is_not_two_columns() {
        assert_eq!(shape("x (mm)\n38,0169\n40,4689\n"), (Delimiter::None, Decimal::Comma, 1));
        assert_eq!(shape("38,0169\n40,4689\n-0,5\n"), (Delimiter::None, Decimal::Comma, 1));
        assert_eq!(shape("38,16\n40,89\n12,25\n"), (Delimiter::None, Decimal::Comma, 1));
        assert_eq!(shape("t,n\n38,16\n40,89\n"), (Delimiter::Comma, Decimal::Point, 2));
        assert_eq!(shape("0,5\n1,12\n2,7\n"), (Delimiter::Comma, Decimal::Point, 2));
        assert_eq!(shape("5\n1\n2\n"), (Delimiter::None, Decimal::Point, 1));
    }

    #[test]
    fn a_separator_inside_quotes_separates_nothing() {
        let line = br#""a, b",2,"c ""d"", e""#;
        assert_eq!(cells(line, Delimiter::Comma).len(), 3);
        assert_eq!(cells(br#"12" disc,3"#, Delimiter::Comma).len(), 2);
    }
}

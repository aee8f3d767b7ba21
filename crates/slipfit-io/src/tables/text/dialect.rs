//! Separators of cells and decimal marks of a file.

use memchr::memchr;

use super::number::{self, Cell};
use crate::report::{Decimal, Delimiter};

/// Whether a line is a remark.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    matches!(line.first(), Some(b'#' | b'%')) || line.starts_with(b"//")
}

/// The single byte between two cells, if there is one.
pub(super) fn separator(delimiter: Delimiter) -> Option<u8> {
    match delimiter {
        Delimiter::Comma => Some(b','),
        Delimiter::Semicolon => Some(b';'),
        Delimiter::Tab => Some(b'\t'),
        Delimiter::Bar => Some(b'|'),
        Delimiter::Blanks | Delimiter::None => None,
    }
}

/// The cells of a line; quotes are respected and kept.
pub(super) fn cells(line: &[u8], delimiter: Delimiter) -> Vec<&[u8]> {
    let mut cells = Vec::new();
    for_each_cell(line, delimiter, |cell| cells.push(cell));
    cells
}

/// Passes on each cell of a line; quotes are respected and kept.
fn for_each_cell<'a>(line: &'a [u8], delimiter: Delimiter, mut take: impl FnMut(&'a [u8])) {
    let Some(separator) = separator(delimiter) else {
        if delimiter == Delimiter::None {
            return take(line);
        }
        return line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty()).for_each(take);
    };
    if memchr(b'"', line).is_none() {
        return line.split(|byte| *byte == separator).for_each(take);
    }
    let (mut start, mut quoted) = (0, false);
    for (i, &byte) in line.iter().enumerate() {
        if byte == b'"' {
            // A quote opens a cell only at its beginning; inside a cell it means inches.
            quoted =
                if quoted { false } else { line[start..i].trim_ascii().is_empty() || ends_quote(line, i) };
        } else if byte == separator && !quoted {
            take(&line[start..i]);
            start = i + 1;
        }
    }
    take(&line[start..]);
}

/// Whether the quote at `i` is the second of two adjacent quotes.
fn ends_quote(line: &[u8], i: usize) -> bool {
    i > 0 && line[i - 1] == b'"'
}

/// Kind of a line in a dialect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowKind {
    Blank,
    Comment,
    /// Number of cells, all of which are numbers or missing, with at least one number.
    Numbers(usize),
    /// Anything else.
    Text(usize),
}

/// The kind of a line; with `words`, a row of numbers may also contain other cells.
pub(super) fn row_kind(line: &[u8], delimiter: Delimiter, decimal: Decimal, words: bool) -> RowKind {
    if line.trim_ascii().is_empty() {
        return RowKind::Blank;
    }
    if is_comment(line) {
        return RowKind::Comment;
    }
    let (mut width, mut numbers, mut text) = (0, 0, false);
    for_each_cell(line, delimiter, |cell| {
        width += 1;
        // A single word in a row of numbers is decisive.
        if text {
            return;
        }
        match number::cell(cell, decimal) {
            Cell::Number(_) => numbers += 1,
            Cell::Text => text = !words,
            Cell::Missing => {}
        }
    });
    if numbers > 0 && !text { RowKind::Numbers(width) } else { RowKind::Text(width) }
}

/// Delimiter, decimal mark and the most common number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) delimiter: Delimiter,
    pub(super) decimal: Decimal,
    pub(super) width: usize,
    /// Whether the rows contain words in addition to their numbers.
    pub(super) words: bool,
}

/// Number of lines examined closely.
const FIRST: usize = 150;

/// In order of preference if several fit equally well.
pub(super) const CANDIDATES: &[(Delimiter, Decimal)] = &[
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
    // The first lines, which contain preambles, and a sample of the others.
    let (first, others) = lines.split_at(lines.len().min(FIRST));
    let stride = others.len().div_ceil(FIRST).max(1);
    let lines: Vec<&[u8]> = first.iter().chain(others.iter().step_by(stride)).copied().collect();
    detect_rows(&lines, false).or_else(|| {
        // Rows containing words are a table only if nearly all lines are such rows.
        let shape = detect_rows(&lines, true)?;
        let row = RowKind::Numbers(shape.width);
        let rows = lines.iter().filter(|l| row_kind(l, shape.delimiter, shape.decimal, true) == row).count();
        (shape.width > 1 && rows >= 8 && rows * 5 >= lines.len() * 4).then_some(shape)
    })
}

/// Whether most of the lines in the middle are rows of numbers only.
pub(super) fn is_clear(lines: &[&[u8]], shape: Shape) -> bool {
    const LINES_EXAMINED: usize = 24;
    let from = lines.len() / 2;
    let kind = |line: &&&[u8]| row_kind(line, shape.delimiter, shape.decimal, false);
    let kinds: Vec<RowKind> = lines[from..].iter().take(LINES_EXAMINED).map(|line| kind(&line)).collect();
    let rows = kinds.iter().filter(|kind| matches!(kind, RowKind::Numbers(_))).count();
    !shape.words && rows * 2 >= kinds.len()
}

fn detect_rows(lines: &[&[u8]], words: bool) -> Option<Shape> {
    let mut whole = vec![[None; 2]; lines.len()];
    let mut shape_with = |&(delimiter, decimal): &(Delimiter, Decimal)| {
        let widths = rows_of_numbers(lines, &mut whole, delimiter, decimal, words);
        mode(&widths).map(|width| (widths.len(), Shape { delimiter, decimal, width, words }))
    };
    // Earlier candidates divide no line and give one cell per row; later ones cannot give clearly more rows.
    let first = CANDIDATES.iter().find(|(delimiter, _)| lines.iter().any(|line| divides(line, *delimiter)));
    let nearly_all = |found: &(usize, Shape)| found.1.width > 1 && found.0 * 51 >= lines.len() * 50;
    let (_, mut shape) = match first.and_then(&mut shape_with).filter(nearly_all) {
        Some(found) => found,
        None => CANDIDATES.iter().filter_map(shape_with).reduce(better)?,
    };
    if shape.delimiter == Delimiter::Comma && is_decimal_comma(lines) {
        shape = Shape { delimiter: Delimiter::None, decimal: Decimal::Comma, width: 1, words };
    }
    if shape.width == 1 {
        shape.delimiter = Delimiter::None;
    }
    Some(shape)
}

/// The one with clearly more rows; if they are similar, the first with more than one cell per row: any wrong delimiter
/// gives one cell per row.
fn better(held: (usize, Shape), other: (usize, Shape)) -> (usize, Shape) {
    let ((most, held_shape), (rows, shape)) = (held, other);
    let clearly = rows * 50 > most * 51;
    let as_good = rows * 51 >= most * 50;
    if clearly || (as_good && held_shape.width == 1 && shape.width > 1) { other } else { held }
}

/// The number of cells of each row of numbers. A line that is not divided has the same kind for every delimiter:
/// `whole` stores this kind, for decimal points and for decimal commas.
fn rows_of_numbers(
    lines: &[&[u8]],
    whole: &mut [[Option<RowKind>; 2]],
    delimiter: Delimiter,
    decimal: Decimal,
    words: bool,
) -> Vec<usize> {
    let kind = |(line, whole): (&&[u8], &mut [Option<RowKind>; 2])| {
        let kind = || row_kind(line, delimiter, decimal, words);
        let kind = if divides(line, delimiter) {
            kind()
        } else {
            *whole[usize::from(decimal == Decimal::Comma)].get_or_insert_with(kind)
        };
        if let RowKind::Numbers(width) = kind { Some(width) } else { None }
    };
    lines.iter().zip(whole).filter_map(kind).collect()
}

/// Whether a line has more than one cell.
fn divides(line: &[u8], delimiter: Delimiter) -> bool {
    match separator(delimiter) {
        Some(separator) => memchr(separator, line).is_some(),
        None => line.trim_ascii().iter().any(u8::is_ascii_whitespace),
    }
}

/// Whether commas that could separate pairs of integers are decimal marks of single numbers, as in `38,0169`.
fn is_decimal_comma(lines: &[&[u8]]) -> bool {
    let (mut pairs, mut lengths, mut header) = (Vec::new(), Vec::new(), None);
    for line in lines {
        match row_kind(line, Delimiter::Comma, Decimal::Point, false) {
            RowKind::Numbers(1) => {}
            RowKind::Numbers(2) => {
                let cells = cells(line, Delimiter::Comma);
                let (left, right) = (number::trim(cells[0]), number::trim(cells[1]));
                if !is_integer(left) || right.is_empty() || !right.iter().all(u8::is_ascii_digit) {
                    return false;
                }
                if left == b"-0" || (right.len() > 1 && right[0] == b'0') {
                    return true;
                }
                pairs.push([left, right]);
                lengths.push(right.len());
            }
            RowKind::Numbers(_) => return false,
            RowKind::Text(width) if pairs.is_empty() => header = Some(width),
            _ => {}
        }
    }
    match header {
        Some(1) => !pairs.is_empty(),
        Some(_) => false,
        None => {
            let alike =
                lengths.first().is_some_and(|&first| first > 1 && lengths.iter().all(|l| *l == first));
            alike && !are_clock_and_readings(&pairs)
        }
    }
}

/// Whether pairs of integers are clock times and readings, as `1234,885` from a microcontroller: in many rows the first
/// number increases in each. Numbers with as many decimals would increase evenly, to the last digit.
fn are_clock_and_readings(pairs: &[[&[u8]; 2]]) -> bool {
    const ROWS: usize = 8;
    /// Maximum variation of the steps between rounded numbers of an even clock, in units of the last digit.
    const EVEN: i128 = 4;
    let number = |cell: &[u8]| std::str::from_utf8(cell).ok()?.parse::<i64>().ok().map(i128::from);
    let rows: Option<Vec<[i128; 2]>> =
        pairs.iter().map(|[left, right]| Some([number(left)?, number(right)?])).collect();
    let Some(rows) = rows.filter(|rows| rows.len() >= ROWS) else { return false };
    // Lines far into the file are a stride apart.
    let near = &rows[..rows.len().min(FIRST / 2)];
    let digits = pairs[0][1].len().min(18) as u32;
    let joined = |[left, right]: &[i128; 2]| left * 10_i128.pow(digits) + right;
    let steps: Vec<i128> = near.windows(2).map(|w| joined(&w[1]) - joined(&w[0])).collect();
    let (least, most) = steps.iter().fold((i128::MAX, i128::MIN), |(l, m), s| (l.min(*s), m.max(*s)));
    rows.windows(2).all(|w| w[1][0] > w[0][0]) && most - least > EVEN
}

fn is_integer(cell: &[u8]) -> bool {
    let digits = cell.strip_prefix(b"-").or_else(|| cell.strip_prefix(b"+")).unwrap_or(cell);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

/// The most common value; the greater of equally common ones.
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
        let rows = |row: &dyn Fn(i64) -> String| (0..20).map(|i| row(i) + "\n").collect::<String>();
        let two = (Delimiter::Comma, Decimal::Point, 2);
        let one = (Delimiter::None, Decimal::Comma, 1);
        assert_eq!(shape(&rows(&|i| format!("{},{}", 1234 + 20 * i, 500 + 300 * (i % 3 - 1)))), two);
        assert_eq!(shape(&rows(&|i| format!("{},{}", 40 * i / 100, 10 + (40 * i) % 90))), one, "it repeats");
        assert_eq!(
            shape(&rows(&|i| format!("{},{:02}", 253 * i / 100, (253 * i) % 100))),
            one,
            "an even clock"
        );
        assert_eq!(shape(&rows(&|i| format!("{},{}", 30 + i % 4, 20 + 7 * i % 60))), one, "it swings");
    }

    #[test]
    fn a_separator_inside_quotes_separates_nothing() {
        let line = br#""a, b",2,"c ""d"", e""#;
        assert_eq!(cells(line, Delimiter::Comma).len(), 3);
        assert_eq!(cells(br#"12" disc,3"#, Delimiter::Comma).len(), 2);
    }
}

//! Lines that are rewritten before they are read as a table: annotated numbers, stamps of a serial monitor, names
//! before values, settings beside rows, and numbers that occupy two cells each.

use super::{
    annotated::Annotations,
    dialect::{self, Shape},
    labelled::Labels,
    layout::{Layout, text},
    number,
    settings::Settings,
    stamp,
};
use crate::{
    columns::name::Name,
    error::ReadProblem,
    report::{Decimal, Delimiter, Note},
};

/// Number of lines examined.
const FIRST: usize = 150;
/// Minimum number of rows that show how lines are written.
const FEWEST: usize = 3;
/// Mark between the stamp of a serial monitor and the text received.
const ARROW: &[u8] = b" -> ";

/// How lines are rewritten.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rewrite {
    Annotated(Annotations),
    /// The stamp is moved behind the cells, separated by this byte.
    Stamped(u8),
    /// Names precede the values.
    Labelled(Labels),
    /// Settings are beside the first rows.
    Settings(Settings),
    /// Each row is enclosed in brackets.
    Bracketed,
    /// Number of numbers per row, each of which occupies two cells.
    Halved(usize),
}

impl Rewrite {
    /// Rewriting of lines that are not a clear table.
    pub(super) fn find(lines: &[&[u8]]) -> Option<Self> {
        let first = &lines[..lines.len().min(FIRST)];
        stamped(lines)
            .map(Self::Stamped)
            .or_else(|| Annotations::find(lines).map(Self::Annotated))
            .or_else(|| are_bracketed(first).then_some(Self::Bracketed))
            .or_else(|| Labels::find(first, FEWEST).map(Self::Labelled))
    }

    /// Rewriting of lines of a clear table: numbers with decimal commas in cells that are separated by commas, or
    /// settings beside the first rows.
    ///
    /// # Errors
    /// [`ReadProblem::DecimalCommas`] if rows differ in length, so that separators and decimal commas cannot be
    /// distinguished.
    pub(super) fn of_table(lines: &[&[u8]], layout: &Layout) -> Result<Option<Self>, ReadProblem> {
        let halved = halves(lines, layout)?.map(Self::Halved);
        Ok(halved.or_else(|| Settings::find(lines, layout).map(Self::Settings)))
    }

    /// The first lines, rewritten.
    pub(super) fn head(&self, lines: &[&[u8]]) -> Vec<Vec<u8>> {
        match self {
            Self::Annotated(annotations) => annotations.head(lines),
            _ => lines.iter().map(|line| self.rows(line, b'\n')).collect(),
        }
    }

    /// Whole lines below the header, rewritten.
    pub(super) fn rows(&self, bytes: &[u8], newline: u8) -> Vec<u8> {
        let line: &dyn Fn(&[u8], &mut Vec<u8>) = match self {
            Self::Annotated(annotations) => return annotations.rows(bytes, newline),
            Self::Stamped(separator) => &|line, out| with_stamp_last(line, *separator, out),
            Self::Labelled(labels) => &|line, out| labels.line(line, out),
            Self::Settings(settings) => &|line, out| settings.line(line, out),
            Self::Bracketed => &|line, out| out.extend_from_slice(within_brackets(line).unwrap_or(line)),
            Self::Halved(numbers) => &|line, out| joined(line, *numbers, out),
        };
        let mut out = Vec::with_capacity(bytes.len());
        for whole in bytes.split_inclusive(|b| *b == newline) {
            let end = whole.len() - usize::from(whole.last() == Some(&newline));
            line(&whole[..end], &mut out);
            out.extend_from_slice(&whole[end..]);
        }
        out
    }

    /// Names of the columns if no line states them.
    pub(super) fn names(&self) -> Vec<Name> {
        match self {
            Self::Annotated(annotations) => annotations.names(),
            Self::Labelled(labels) => labels.names(),
            Self::Settings(settings) => settings.names(),
            Self::Stamped(_) | Self::Bracketed | Self::Halved(_) => Vec::new(),
        }
    }

    /// Values named in the parts that are removed.
    pub(super) fn named_values(&self) -> &[(String, String)] {
        match self {
            Self::Settings(settings) => settings.values(),
            _ => &[],
        }
    }

    /// Note on the rewriting.
    pub(super) fn note(&self) -> Note {
        match self {
            Self::Annotated(annotations) => annotations.note(),
            Self::Stamped(_) => {
                Note::new("the stamps of a serial monitor in front of `->` were read as the last column")
            }
            Self::Labelled(labels) => labels.note(),
            Self::Bracketed => Note::new("the brackets around each row were left out"),
            Self::Settings(settings) => settings.note(),
            Self::Halved(numbers) => Note::new(format!(
                "commas are both cell separators and decimal marks: the {} cells of each row were read as \
                 {numbers} numbers",
                2 * numbers
            )),
        }
    }
}

/// The cells of a line enclosed in brackets, `[0.0, 1.0]` or `(0.0, 1.0),`.
fn within_brackets(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii();
    let line = line.strip_suffix(b",").unwrap_or(line).trim_ascii_end();
    match line {
        [b'[', cells @ .., b']'] | [b'(', cells @ .., b')'] => Some(cells),
        _ => None,
    }
}

/// Whether most lines are rows of numbers enclosed in brackets.
fn are_bracketed(lines: &[&[u8]]) -> bool {
    let numbers = |cells: &[u8]| {
        let cells = dialect::cells(cells, Delimiter::Comma);
        cells.len() > 1
            && cells.iter().all(|cell| number::number(number::trim(cell), Decimal::Point).is_some())
    };
    let filled = lines.iter().filter(|line| !line.trim_ascii().is_empty()).count();
    let rows = lines.iter().filter(|line| within_brackets(line).is_some_and(numbers)).count();
    rows >= FEWEST && 2 * rows > filled
}

/// The stamp and the text received in a line such as `12:34:56.789 -> 512`.
fn split_stamp(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let at = line.windows(ARROW.len()).position(|bytes| bytes == ARROW)?;
    let (before, behind) = (line[..at].trim_ascii(), &line[at + ARROW.len()..]);
    stamp::read(&text(before)).map(|_| (before, behind.trim_ascii()))
}

/// The byte between the cells, if most lines begin with a stamp.
fn stamped(lines: &[&[u8]]) -> Option<u8> {
    let first = &lines[..lines.len().min(FIRST)];
    let filled = first.iter().filter(|line| !line.trim_ascii().is_empty()).count();
    let received: Vec<&[u8]> = first.iter().filter_map(|line| split_stamp(line)).map(|(_, r)| r).collect();
    if received.len() < FEWEST || received.len() * 2 <= filled {
        return None;
    }
    let most = |byte: u8| received.iter().filter(|line| line.contains(&byte)).count() * 2 > received.len();
    Some([b'\t', b';', b',', b' '].into_iter().find(|byte| most(*byte)).unwrap_or(b'\t'))
}

fn with_stamp_last(line: &[u8], separator: u8, out: &mut Vec<u8>) {
    let Some((stamp, received)) = split_stamp(line) else { return out.extend_from_slice(line) };
    out.extend_from_slice(received);
    if received.is_empty() {
        return;
    }
    out.push(separator);
    let is_header = received.first().is_some_and(u8::is_ascii_alphabetic);
    out.extend_from_slice(if is_header { b"received" } else { stamp });
}

/// Whether a cell may be half of a number: digits, with an optional sign before the comma.
fn is_half(cell: &[u8], in_front: bool) -> bool {
    let cell = number::trim(cell);
    let digits =
        if in_front { cell.strip_prefix(b"-").or(cell.strip_prefix(b"+")).unwrap_or(cell) } else { cell };
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

/// Number of numbers per row, if each occupies two cells.
fn halves(lines: &[&[u8]], layout: &Layout) -> Result<Option<usize>, ReadProblem> {
    let Shape { delimiter, decimal, width, words } = layout.shape;
    if delimiter != Delimiter::Comma || decimal != Decimal::Point || words || layout.quoted || width < 3 {
        return Ok(None);
    }
    let cells = |line: &[u8]| -> Vec<Vec<u8>> {
        dialect::cells(line, Delimiter::Comma).iter().map(|c| number::trim(c).to_vec()).collect()
    };
    let first = lines.get(layout.first_line).copied().unwrap_or_default();
    if !dialect::cells(first, Delimiter::Comma).iter().all(|cell| is_half(cell, true)) {
        return Ok(None);
    }
    // Rows with fewer cells may precede the first row of the most common length.
    let is_row = |line: &&&[u8]| cells(line).iter().all(|cell| is_half(cell, true));
    let first_line = layout.first_line - lines[..layout.first_line].iter().rev().take_while(is_row).count();
    let rows: Vec<Vec<Vec<u8>>> = lines[first_line..]
        .iter()
        .filter(|line| !line.trim_ascii().is_empty() && !dialect::is_comment(line))
        .map(|line| cells(line))
        .collect();
    if rows.len() < FEWEST || !rows.iter().flatten().all(|cell| is_half(cell, true)) {
        return Ok(None);
    }
    // No number begins this way, but a fraction does.
    let is_fraction = |cell: &[u8]| cell.len() > 1 && cell[0] == b'0';
    let fractions = rows.iter().flatten().any(|cell| is_fraction(cell) || cell == b"-0");
    let header = (0..first_line).rev().find(|&i| !lines[i].trim_ascii().is_empty());
    let names = header.map(|i| cells(lines[i])).filter(|cells| {
        let numeric = |cell: &Vec<u8>| number::number(cell, Decimal::Point).is_some();
        !cells.iter().any(numeric)
    });
    let named = names.map(|cells| cells.iter().rposition(|c| !c.is_empty()).map_or(0, |last| last + 1));
    let even = rows.iter().all(|row| row.len() == width) && width % 2 == 0;
    let halved = || {
        rows.iter().all(|row| row.chunks(2).all(|pair| pair.len() == 2 && is_half(&pair[1], false)))
            && rows.iter().flat_map(|row| row.chunks(2)).all(|pair| !is_fraction(&pair[0]))
    };
    let as_many =
        |digits: usize| (0..width / 2).any(|k| rows.iter().all(|row| row[2 * k + 1].len() == digits));
    let alike = |least: usize| (least..=9).any(as_many);
    match named {
        Some(named) if even && named * 2 == width && halved() && (fractions || alike(2)) => {
            Ok(Some(width / 2))
        }
        None if even && width > 2 && halved() && fractions => Ok(Some(width / 2)),
        Some(named)
            if named > 1
                && fractions
                && rows.iter().all(|row| (named..=2 * named).contains(&row.len()))
                && rows.iter().any(|row| row.len() > named) =>
        {
            let line = text(lines[first_line].trim_ascii()).into_owned();
            Err(ReadProblem::DecimalCommas { row: first_line as u64 + 1, line, columns: named })
        }
        _ => Ok(None),
    }
}

/// A row of halves as numbers with decimal points; any other row as one cell of text.
fn joined(line: &[u8], numbers: usize, out: &mut Vec<u8>) {
    if line.trim_ascii().is_empty() || dialect::is_comment(line) {
        return out.extend_from_slice(line);
    }
    let cells = dialect::cells(line.trim_ascii_end(), Delimiter::Comma);
    let halves = cells.iter().enumerate().all(|(i, cell)| is_half(cell, i % 2 == 0));
    if !halves || cells.len() != 2 * numbers {
        // A header remains unchanged.
        if cells.iter().any(|cell| is_half(cell, true)) {
            out.push(b'"');
            out.extend(line.iter().filter(|byte| **byte != b'"'));
            return out.push(b'"');
        }
        return out.extend_from_slice(line);
    }
    for (i, cell) in cells.iter().enumerate() {
        if i > 0 {
            out.push(if i % 2 == 0 { b',' } else { b'.' });
        }
        out.extend_from_slice(number::trim(cell));
    }
}

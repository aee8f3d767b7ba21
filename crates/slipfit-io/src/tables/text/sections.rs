//! Several tables below each other in one text, each with its own header: `BEGIN CH1_DATA … END`, or another header at
//! the end of the rows of a table.

use std::ops::Range;

use super::{
    dialect::{self, RowKind, Shape},
    layout::{self, Layout, text},
    number::{self, Cell},
};
use crate::{
    columns::{name::Name, role::Role},
    report::Delimiter,
};

/// Minimum number of rows of numbers below the header of a table.
const FEWEST: usize = 3;
/// Number of lines examined below a header.
const LINES_EXAMINED: usize = 12;
/// Maximum number of lines without numbers; if there are more, they are cells of rows and not headers.
const MOST: usize = 1 << 12;
/// Maximum number of characters of a title.
const TITLE: usize = 60;

/// One of several tables in a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    /// The title above its header, or its number.
    pub(super) name: String,
    /// Number of lines above it in the text.
    pub(super) lines_before: usize,
    /// Its position in the text.
    pub(super) bytes: Range<usize>,
}

/// A header and its title.
struct Heading {
    /// Indices of its first line and of the line of the header.
    lines: [usize; 2],
    names: Vec<Name>,
    title: Option<String>,
}

/// The tables of a whole text, the first of which is described by `layout`; empty if there is only one.
pub(super) fn find(window: &[u8], newline: u8, layout: &Layout) -> Vec<Section> {
    let shape = layout.shape;
    let starts = candidates(window, newline);
    if shape.words || starts.is_empty() || starts.len() > MOST || !any_below(&starts, layout.first_line) {
        return Vec::new();
    }
    let lines: Vec<&[u8]> = window.split(|byte| *byte == newline).collect();
    let mut headings: Vec<Heading> = Vec::new();
    let mut at = 0;
    while at < starts.len() {
        let gap = gap(&lines, &starts[at..], shape);
        at += starts[at..].iter().take_while(|line| **line < gap.end).count().max(1);
        let Some(heading) = heading(&lines, gap, shape) else { continue };
        match headings.last() {
            Some(before) if !differ(before, &heading) => {}
            None if layout.first_line < heading.lines[0] => {
                headings.push(Heading { lines: [0, 0], names: Vec::new(), title: None });
                headings.push(heading);
            }
            _ => headings.push(heading),
        }
    }
    if headings.len() < 2 {
        return Vec::new();
    }
    headings[0].lines[0] = 0;
    let mut ends: Vec<usize> = headings[1..].iter().map(|heading| heading.lines[0]).collect();
    ends.push(lines.len());
    let mut byte = 0;
    let mut sections: Vec<Section> = Vec::new();
    for (number, (heading, end)) in (1..).zip(headings.into_iter().zip(ends)) {
        let from = heading.lines[0];
        let length = lines[from..end].iter().map(|line| line.len() + 1).sum::<usize>();
        let bytes = byte..(byte + length).min(window.len());
        let title = heading.title.filter(|title| sections.iter().all(|known| known.name != *title));
        let name = title.unwrap_or_else(|| format!("table {number}"));
        byte = bytes.end;
        sections.push(Section { name, lines_before: from, bytes });
    }
    sections
}

/// Whether a line names columns other than these, and so begins another table in a text that is read only once.
pub(super) fn is_other_header(line: &[u8], shape: Shape, names: &[Name]) -> bool {
    let cells = dialect::cells(line.trim_ascii_end(), shape.delimiter);
    let words = |cell: &[u8]| number::cell(cell, shape.decimal) == Cell::Text;
    if cells.len() < 2 || !cells.iter().all(|cell| words(cell)) {
        return false;
    }
    let found: Vec<Name> = cells.iter().map(|cell| Name::parse(&text(number::trim(cell)))).collect();
    is_known(&found) && !are_alike(&found, names)
}

/// Lines that are not blank and do not begin like rows of numbers.
fn candidates(window: &[u8], newline: u8) -> Vec<usize> {
    let mut found = Vec::new();
    let (mut start, mut number) = (0, 0);
    let last = (!window.is_empty()).then_some(window.len());
    for end in memchr::memchr_iter(newline, window).chain(last) {
        let first = window[start..end].iter().find(|byte| !b" \t\r\"',;|".contains(byte));
        if first.is_some_and(|byte| !byte.is_ascii_digit() && !b"+-.".contains(byte)) {
            found.push(number);
            if found.len() > MOST {
                break;
            }
        }
        (start, number) = (end + 1, number + 1);
    }
    found
}

fn any_below(candidates: &[usize], line: usize) -> bool {
    candidates.last().is_some_and(|last| *last > line)
}

/// The contiguous lines around the first candidate that are not rows of numbers.
fn gap(lines: &[&[u8]], candidates: &[usize], shape: Shape) -> Range<usize> {
    let is_row = |line: usize| {
        let kind = dialect::row_kind(lines[line], shape.delimiter, shape.decimal, false);
        matches!(kind, RowKind::Numbers(_))
    };
    let first = candidates[0];
    let start = (0..first).rev().take_while(|&line| !is_row(line)).last().unwrap_or(first);
    let end = (first..lines.len()).find(|&line| is_row(line)).unwrap_or(lines.len());
    start..end
}

/// The header at the end of lines that are not rows, if rows follow and its words are names of columns.
fn heading(lines: &[&[u8]], gap: Range<usize>, shape: Shape) -> Option<Heading> {
    let kind = |line: &&[u8]| dialect::row_kind(line, shape.delimiter, shape.decimal, false);
    let below = &lines[gap.end..lines.len().min(gap.end + LINES_EXAMINED)];
    let rows: Vec<RowKind> = below.iter().map(kind).filter(|kind| *kind != RowKind::Blank).collect();
    let first = *rows.first().filter(|kind| matches!(kind, RowKind::Numbers(_)))?;
    if rows.iter().filter(|kind| **kind == first).count() < FEWEST {
        return None;
    }
    let part = &lines[gap.start..gap.end + below.len()];
    let found = layout::find(part)?;
    let header = gap.start + found.header_line.filter(|line| gap.start + line < gap.end)?;
    if !is_known(&found.head.names) {
        return None;
    }
    let is_blank = |line: usize| lines[line].trim_ascii().is_empty();
    let from = (gap.start..header).find(|&line| is_blank(line) || lines[line].trim_ascii() == b"END");
    let from = from.map_or(gap.start, |line| line + 1);
    let lone = |line: usize| dialect::cells(lines[line].trim_ascii_end(), shape.delimiter).len() == 1;
    let above = (from..header).rev().filter(|&line| !is_blank(line));
    let title = above.into_iter().find(|&line| lone(line) || shape.delimiter == Delimiter::Blanks);
    let title = title.and_then(|line| title_of(lines[line]));
    Some(Heading { lines: [from, header], names: found.head.names, title })
}

/// A title without enclosing marks: `CH1_DATA` of `BEGIN CH1_DATA`.
fn title_of(line: &[u8]) -> Option<String> {
    let line = text(line);
    let marks = |c: char| c.is_whitespace() || "#%!*=-:;,\"[]".contains(c);
    let title = line.trim_matches(marks);
    let title = title.strip_prefix("BEGIN ").unwrap_or(title).trim();
    let fits = !title.is_empty() && title.chars().count() <= TITLE && !title.contains(char::is_control);
    fits.then(|| title.to_owned())
}

/// Whether at least half of the names, and at least one, are known.
fn is_known(names: &[Name]) -> bool {
    let says = |role| !matches!(role, Role::Unknown);
    let known = |name: &&Name| {
        !name.header.is_empty()
            && (says(Role::in_record(name)) || says(Role::in_curve(name)) || name.measures().is_some())
    };
    let count = names.iter().filter(known).count();
    count > 0 && 2 * count >= names.len()
}

/// Whether another table begins: different columns or units, or another block of a network analyser.
fn differ(before: &Heading, next: &Heading) -> bool {
    before.title != next.title && next.title.as_ref().is_some_and(|title| title.ends_with("_DATA"))
        || !are_alike(&before.names, &next.names)
}

/// Whether the columns are the same, apart from the run that they name.
fn are_alike(names: &[Name], others: &[Name]) -> bool {
    let same = |(one, other): (&Name, &Name)| {
        one.unit == other.unit && one.bare.trim().eq_ignore_ascii_case(other.bare.trim())
    };
    names.len() == others.len() && names.iter().zip(others).all(same)
}

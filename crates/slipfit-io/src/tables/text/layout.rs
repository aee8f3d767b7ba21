//! Beginning of the table, names of its columns, and their grouping.

use std::borrow::Cow;

use super::{
    dialect::{self, RowKind, Shape},
    number, stamp,
};
use crate::{
    columns::{
        head::Head,
        name::Name,
        named,
        role::Role,
        stated,
        units::{self, Measures},
    },
    report::{Decimal, Delimiter, Note},
};

/// Number of lines, from the first row on, most of which must be rows.
const LOOK_AHEAD: usize = 5;

/// A table found in the first lines of a file.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) shape: Shape,
    /// Index of the header line.
    pub(super) header_line: Option<usize>,
    /// Index of the first line of numbers.
    pub(super) first_line: usize,
    /// Whether the rows quote cells.
    pub(super) quoted: bool,
    /// The day of the first date, counted from 1970; 0 if there is none.
    pub(super) day: i64,
    /// The program or instrument that wrote it, if it is known.
    pub(super) convention: Option<&'static str>,
    /// Its columns, and the information above it.
    pub(super) head: Head,
}

/// Bytes as text: UTF-8, else Windows-1252, which covers every byte.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

/// Finds the table in the first lines of a file.
pub(super) fn find(lines: &[&[u8]]) -> Option<Layout> {
    let shape = dialect::detect(lines)?;
    let mut kinds = Vec::new();
    let first_line = first_row(lines, shape, &mut kinds)?;
    let mut notes = Vec::new();
    let header = header(lines, &kinds, first_line, shape, &mut notes);
    let (header_line, names) = match header {
        Some((line, names)) => (Some(line), names),
        None => (None, vec![Name::default(); shape.width]),
    };
    let names = shift_past_row_names(names, header_line, lines, first_line, shape);
    let (names, day) = stamped(names, lines[first_line], shape, &mut notes);
    let quoted = lines[first_line..].iter().any(|l| memchr::memchr(b'"', l).is_some());
    let named_values =
        named::values(lines[..first_line].iter().map(|line| text(uncommented(line)).into_owned()));
    let stated_rate_hz = stated_rate_hz(&lines[..first_line], shape);
    let head = Head { names, named_values, stated_rate_hz, notes, ..Head::default() };
    Some(Layout { shape, header_line, first_line, quoted, day, convention: None, head })
}

/// The sampling rate stated in the lines above a table.
fn stated_rate_hz(lines: &[&[u8]], shape: Shape) -> Option<f64> {
    let lines: Vec<Cow<'_, str>> = lines.iter().map(|line| text(line)).collect();
    let own = dialect::separator(shape.delimiter).map(char::from);
    let any: &[char] = if shape.decimal == Decimal::Comma { &[';', '\t'] } else { &[',', ';', '\t'] };
    let of =
        |separators: &[char]| stated::rate_hz(lines.iter().map(|line| &**line), separators, shape.decimal);
    own.and_then(|own| of(&[own])).or_else(|| of(any))
}

/// Shifts names that are one column too far to the left, as written by R above rows that begin with a row number.
fn shift_past_row_names(
    mut names: Vec<Name>,
    header_line: Option<usize>,
    lines: &[&[u8]],
    first_line: usize,
    shape: Shape,
) -> Vec<Name> {
    const ROWS: usize = 20;
    let Some(header) = header_line.filter(|_| shape.width > 2) else { return names };
    let rows: Vec<Vec<&[u8]>> = lines[first_line..]
        .iter()
        .map(|line| dialect::cells(line, shape.delimiter))
        .filter(|cells| cells.len() == shape.width)
        .take(ROWS)
        .collect();
    let number = |cell: &&[u8]| number::number(number::trim(cell), shape.decimal);
    let labels: Vec<f64> = rows.iter().filter_map(|row| number(row.first()?)).collect();
    let counts = labels.len() > 2
        && labels.len() == rows.len()
        && labels.windows(2).all(|w| w[1] - w[0] == 1.0)
        && matches!(labels.first(), Some(0.0 | 1.0));
    let filled = rows.iter().all(|row| row.last().and_then(number).is_some());
    let short = dialect::cells(lines[header].trim_ascii_end(), shape.delimiter).len() + 1 == shape.width;
    if counts && filled && short && names.last().is_some_and(|name| name.header.is_empty()) {
        names.rotate_right(1);
    }
    names
}

/// Columns of dates and times of day become times in seconds, whatever their headers; also returns the first day.
fn stamped(mut names: Vec<Name>, row: &[u8], shape: Shape, notes: &mut Vec<Note>) -> (Vec<Name>, i64) {
    let mut day = None;
    for (column, (name, cell)) in names.iter_mut().zip(dialect::cells(row, shape.delimiter)).enumerate() {
        let cell = text(number::trim(cell));
        // A number with a decimal comma or point is not a stamp; `1.5` is read as a number first.
        let plain = number::number(cell.as_bytes(), shape.decimal).is_some();
        let Some(stamp) = stamp::read(&cell).filter(|_| !plain) else { continue };
        day = day.or(stamp.day);
        if !stamp.timed {
            continue;
        }
        let what = if stamp.day.is_some() { "date and time" } else { "the time of day" };
        let since = if stamp.day.is_some() { "the midnight before" } else { "midnight" };
        let number = column + 1;
        let text = format!("column {number} holds {what}, such as `{cell}`: read as seconds since {since}");
        notes.push(text.into());
        "s".clone_into(&mut name.unit);
    }
    (names, day.unwrap_or(0))
}

/// The first row of numbers with the most common width that is followed by others; `kinds` receives the kinds of the
/// lines examined for this.
fn first_row(lines: &[&[u8]], shape: Shape, kinds: &mut Vec<RowKind>) -> Option<usize> {
    let mut kind = |i: usize| {
        let seen = kinds.len();
        let more = lines.get(seen..=i).unwrap_or_default();
        kinds.extend(more.iter().map(|l| dialect::row_kind(l, shape.delimiter, shape.decimal, shape.words)));
        kinds[i]
    };
    let usual = RowKind::Numbers(shape.width);
    let mut any = None;
    for i in 0..lines.len() {
        if kind(i) != usual {
            continue;
        }
        any = any.or(Some(i));
        let next: Vec<RowKind> =
            (i..lines.len()).map(&mut kind).filter(|k| *k != RowKind::Blank).take(LOOK_AHEAD).collect();
        let rows = next.iter().filter(|k| matches!(k, RowKind::Numbers(_))).count();
        // A date above the header is not a row: the header lies between it and the numbers.
        let header_below = matches!(next.get(1), Some(RowKind::Text(_))) && !is_below_names(lines, i, shape);
        if !header_below && rows * 5 >= next.len() * 4 {
            return Some(i);
        }
    }
    any
}

/// Whether the line above a line names its columns.
fn is_below_names(lines: &[&[u8]], line: usize, shape: Shape) -> bool {
    let above = lines[..line].iter().rev().find(|line| !line.trim_ascii().is_empty());
    let cells = above.map(|line| texts(&dialect::cells(line, shape.delimiter))).unwrap_or_default();
    let known = |cell: &&String| Role::in_record(&Name::parse(cell)) != Role::Unknown;
    let words = cells.iter().all(|cell| number::cell(cell.as_bytes(), shape.decimal) == number::Cell::Text);
    cells.len() == shape.width && words && 2 * cells.iter().filter(known).count() >= cells.len()
}

fn header(
    lines: &[&[u8]],
    kinds: &[RowKind],
    first_line: usize,
    shape: Shape,
    notes: &mut Vec<Note>,
) -> Option<(usize, Vec<Name>)> {
    let above = || (0..first_line).rev().filter(|&i| kinds[i] != RowKind::Blank);
    let nearest = above().next()?;
    let states_rate =
        |line: &[u8]| shape.delimiter != Delimiter::Comma && stated_rate_hz(&[line], shape).is_some();
    if let Some((line, names)) = above_comments(lines, kinds, nearest, shape) {
        let comments = plain_header_cells(lines[nearest]);
        let said: Vec<&str> = comments.iter().map(String::as_str).filter(|c| !c.is_empty()).collect();
        notes.push(format!("line {} below the units was not read: {}", nearest + 1, said.join(", ")).into());
        return Some((line, names));
    } else if states_rate(lines[nearest]) {
        // A sentence about the samples, not their names.
    } else if holds_numbers(lines[nearest], shape) {
        notes.push(
            format!(
                "line {} holds numbers among its words: it was taken for preamble and not read",
                nearest + 1
            )
            .into(),
        );
    } else if matches!(kinds[nearest], RowKind::Text(_)) {
        if let Some(cells) = header_cells(lines[nearest], shape) {
            let joined = join_unit_row(cells.clone(), nearest, lines, kinds, shape);
            if joined == cells
                && let Some(names) = names_of_units(&cells)
            {
                return Some((nearest, names));
            }
            let cells = join_name_rows(joined, nearest, lines, kinds, shape);
            return Some((nearest, cells.iter().map(|c| Name::parse(c)).collect()));
        }
        let cells = plain_header_cells(lines[nearest]);
        let numeric =
            |c: &String| matches!(number::cell(c.as_bytes(), shape.decimal), number::Cell::Number(_));
        if cells.len() != shape.width && !cells.iter().any(numeric) {
            notes.push(
                format!(
                    "line {} names {} columns (`{}`) but the rows hold {}: its names were not used",
                    nearest + 1,
                    cells.len(),
                    text(lines[nearest]).trim(),
                    shape.width
                )
                .into(),
            );
        }
    }
    // A remark is a header if its words are names of columns.
    above().filter(|&i| kinds[i] == RowKind::Comment).find_map(|i| {
        let cells = header_cells(names_of(uncommented(lines[i]), shape)?, shape)?;
        let cells = join_unit_row(cells, i, lines, kinds, shape);
        let names: Vec<Name> = cells.iter().map(|c| Name::parse(c)).collect();
        let known = names.iter().filter(|n| Role::in_record(n) != Role::Unknown).count();
        (known * 2 >= names.len() && known > 0).then_some((i, names))
    })
}

/// Whether at least half the cells of a line are numbers, which is too many for a header.
fn holds_numbers(line: &[u8], shape: Shape) -> bool {
    let cells = dialect::cells(line, shape.delimiter);
    let filled = cells.iter().filter(|c| !number::trim(c).is_empty()).count();
    let numeric = |c: &&&[u8]| matches!(number::cell(c, shape.decimal), number::Cell::Number(_));
    cells.len() == shape.width && shape.width > 1 && cells.iter().filter(numeric).count() * 2 >= filled
}

/// The line without its remark mark.
fn uncommented(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii();
    let marks = line.iter().take_while(|b| matches!(b, b'#' | b'%' | b'/')).count();
    line[marks..].trim_ascii()
}

/// The part of a remark that may name columns: the text after `columns:`, nothing of `units: V`.
fn names_of(line: &[u8], shape: Shape) -> Option<&[u8]> {
    if dialect::separator(shape.delimiter).is_some() {
        return Some(line);
    }
    let words =
        line.iter().position(|byte| *byte == b':').map(|at| (&line[..at], line[at + 1..].trim_ascii()));
    match words {
        Some((key, names)) if !key.contains(&b'(') && !key.iter().any(u8::is_ascii_whitespace) => {
            let key = key.to_ascii_lowercase();
            let of_columns = [b"columns".as_slice(), b"column", b"fields", b"names", b"header", b"spalten"];
            of_columns.contains(&key.as_slice()).then_some(names)
        }
        _ => Some(line),
    }
}

/// The cells of a header, if it can be split into as many cells as the rows have.
fn header_cells(line: &[u8], shape: Shape) -> Option<Vec<String>> {
    let line = line.trim_ascii_end();
    if shape.delimiter == Delimiter::None {
        // A line with a number among its words is the value of another quantity.
        let numeric = |c: &[u8]| matches!(number::cell(c, shape.decimal), number::Cell::Number(_));
        let several = line.windows(3).any(|bytes| matches!(bytes, b"\",\"" | b"\";\""));
        if several || line.split(|b| b",;\t=: ".contains(b)).any(numeric) && !line.starts_with(b"\"") {
            return None;
        }
        return Some(vec![text(number::trim(line)).into_owned()]);
    }
    let own = || texts(&dialect::cells(line, shape.delimiter));
    let ways: [&dyn Fn() -> Vec<String>; 4] = [
        &own,
        &|| joined_units(&text(line)),
        &|| text(line).split("  ").map(|c| c.trim().to_owned()).filter(|c| !c.is_empty()).collect(),
        &|| {
            [Delimiter::Tab, Delimiter::Semicolon, Delimiter::Comma]
                .into_iter()
                .map(|d| texts(&dialect::cells(line, d)))
                .find(|cells| cells.len() == shape.width)
                .unwrap_or_default()
        },
    ];
    ways.iter().find_map(|way| fitted(way(), shape.width))
}

/// Removes surplus empty cells at the end, or adds a missing one.
fn fitted(mut cells: Vec<String>, width: usize) -> Option<Vec<String>> {
    // LabVIEW names a column of comments but writes none.
    // Rigol writes start and step after the names.
    let spare = |cell: &String| {
        cell.is_empty() || cell == "Comment" || cell.starts_with("t0 =") || cell.starts_with("tInc =")
    };
    while cells.len() > width && cells.last().is_some_and(spare) {
        cells.pop();
    }
    if cells.len() + 1 == width && width > 2 {
        cells.push(String::new());
    }
    (cells.len() == width && cells.iter().any(|c| !c.is_empty())).then_some(cells)
}

fn texts(cells: &[&[u8]]) -> Vec<String> {
    cells.iter().map(|c| text(number::trim(c)).into_owned()).collect()
}

/// Words separated by blanks, with units in brackets joined to the preceding word.
fn joined_units(line: &str) -> Vec<String> {
    let mut cells: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match cells.last_mut() {
            Some(last) if word.starts_with(['(', '[']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => cells.push(word.to_owned()),
        }
    }
    cells
}

/// The names of a line as a human reader would count them.
fn plain_header_cells(line: &[u8]) -> Vec<String> {
    let by = |d| texts(&dialect::cells(line, d));
    [by(Delimiter::Tab), by(Delimiter::Semicolon), by(Delimiter::Comma)]
        .into_iter()
        .find(|cells| cells.len() > 1)
        .unwrap_or_else(|| joined_units(&text(line)))
}

/// Joins names that span two lines, if the lower line contains nothing known and the line directly above it, with as
/// many cells, does.
fn join_name_rows(
    cells: Vec<String>,
    line: usize,
    lines: &[&[u8]],
    kinds: &[RowKind],
    shape: Shape,
) -> Vec<String> {
    let known = |cells: &[String]| {
        let said = |c: &&String| {
            let name = Name::parse(c);
            let says_nothing = |role| matches!(role, Role::Unknown | Role::Never);
            !says_nothing(Role::in_record(&name)) || !says_nothing(Role::in_curve(&name))
        };
        cells.iter().filter(said).count()
    };
    let Some(above) = line.checked_sub(1).filter(|&i| matches!(kinds[i], RowKind::Text(_))) else {
        return cells;
    };
    let upper = texts(&dialect::cells(lines[above], shape.delimiter));
    let whole = upper.len() == cells.len() && cells.len() > 1 && upper.iter().all(|c| !c.is_empty());
    if !whole || known(&cells) > 0 || known(&upper) * 2 < upper.len() {
        return cells;
    }
    upper.iter().zip(&cells).map(|(upper, lower)| format!("{upper} {lower}").trim().to_owned()).collect()
}

/// A cell without enclosing brackets: the last one of `m/(s^2)` is kept.
fn unbracketed(cell: &str) -> &str {
    let cell = cell.trim();
    match cell.as_bytes() {
        [b'(', .., b')'] | [b'[', .., b']'] => unbracketed(&cell[1..cell.len() - 1]),
        _ => cell,
    }
}

/// Whether a cell of a row of units is a unit or empty: Campbell loggers write `TS` and `RN` for stamps and numbers.
fn is_unit(cell: &str) -> bool {
    cell.is_empty()
        || matches!(cell, "TS" | "RN")
        || units::measures(unbracketed(cell)).is_some()
        || (cell.starts_with(['(', '[']) && cell.ends_with([')', ']']))
}

/// A name with the unit given below it.
fn with_unit(name: &str, unit: &str) -> String {
    let unit = if matches!(unit, "TS" | "RN") { "" } else { unbracketed(unit) };
    format!("{name} ({unit})").trim_end_matches("()").trim().to_owned()
}

/// Names and units above a line with further information on the columns: comments of Origin, `Smp` and `Avg` of
/// Campbell loggers, types, dashes; returned with the index of the line of units.
fn above_comments(
    lines: &[&[u8]],
    kinds: &[RowKind],
    comments: usize,
    shape: Shape,
) -> Option<(usize, Vec<Name>)> {
    let [names, units] = [comments.checked_sub(2)?, comments.checked_sub(1)?];
    if shape.width < 2 || [names, units, comments].iter().any(|&i| !matches!(kinds[i], RowKind::Text(_))) {
        return None;
    }
    let [names, cells] = [header_cells(lines[names], shape)?, header_cells(lines[units], shape)?];
    let says = |cell: &String| units::measures(unbracketed(cell)).is_some();
    let own = header_cells(lines[comments], shape).unwrap_or_default();
    // Two lines of units, or a line of names below them, have another meaning.
    let of_units = |cells: &[String]| cells.iter().all(|cell| is_unit(cell)) && cells.iter().any(says);
    if !of_units(&cells) || of_units(&own) || of_units(&names) {
        return None;
    }
    let joined = names.iter().zip(&cells).map(|(name, unit)| Name::parse(&with_unit(name, unit)));
    Some((units, joined.collect()))
}

/// The columns of a header that consists of units only, `s,V` or `Hz,mV`: a time or a frequency and the quantities over
/// it.
fn names_of_units(cells: &[String]) -> Option<Vec<Name>> {
    let is_clock = |unit: &str| {
        let plain = !["h", "d", "m"].contains(&unit);
        plain && (matches!(units::measures(unit), Some(Measures::Time(_))) || units::hertz(unit).is_some())
    };
    let over = is_clock(cells.first()?);
    if !over || cells.len() < 2 || !cells.iter().all(|cell| units::is_known(cell)) {
        return None;
    }
    let name = |cell: &String| {
        // `V` is not a velocity and `g` not an axis of an acceleration; `deg` may be a phase.
        let measured =
            matches!(units::measures(cell), Some(Measures::Signal(_))) && units::radians(cell).is_none();
        let bare = if measured { String::new() } else { cell.clone() };
        Name { header: cell.clone(), bare, unit: cell.clone(), run: None }
    };
    Some(cells.iter().map(name).collect())
}

/// If the line above the numbers contains only units, joins them with the names above it.
fn join_unit_row(
    cells: Vec<String>,
    line: usize,
    lines: &[&[u8]],
    kinds: &[RowKind],
    shape: Shape,
) -> Vec<String> {
    if !cells.iter().all(|cell| is_unit(cell)) || cells.iter().all(String::is_empty) {
        return cells;
    }
    let above = (0..line).rev().find(|&i| kinds[i] != RowKind::Blank);
    let names = above.and_then(|i| header_cells(uncommented(lines[i]), shape));
    match names {
        // `x` and `s` are both units and names: two such rows are needed.
        Some(names) => names.iter().zip(&cells).map(|(name, unit)| with_unit(name, unit)).collect(),
        None => cells,
    }
}

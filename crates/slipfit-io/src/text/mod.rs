//! Delimited text of any dialect.

mod conventions;
mod dialect;
mod layout;
mod number;
mod scan;
mod source;

use std::io::Read;

use self::{
    layout::Layout,
    number::Cell,
    scan::{Plan, Scan, TimePlan},
    source::Source,
};
use crate::{
    Format, ReadOptions, ReadProblem,
    columns::{self, Choice, Time},
    report::{Dialect, Reading, Skipped},
    samples,
    table::HeldTables,
};

/// Bytes from which the dialect is told.
const HEAD: usize = 256 << 10;
/// Bytes from which columns are told apart where their names do not do it.
const PREVIEW: usize = 8 << 20;
/// Longest line of a table.
const LONGEST_LINE: usize = 4 << 20;
/// Bytes read while those before are turned into numbers.
const BLOCK: usize = 2 << 20;
/// Lines from which the dialect is told.
const HEAD_LINES: usize = 2000;

/// Reads the text that `reader` gives, of a size if it is known.
pub(crate) fn read(
    reader: impl Read,
    size: Option<u64>,
    options: &ReadOptions,
) -> Result<Reading, ReadProblem> {
    let (mut source, encoding, newline, layout) = open(reader)?;
    let mut columns = preview(source.window(), newline, source.ended(), &layout);
    let mut choice = columns::choose(&layout.head, &columns, options);
    if !source.ended() && choice.as_ref().map_or(true, |c| c.by_content) {
        source.fill(PREVIEW).map_err(ReadProblem::Io)?;
        columns = preview(source.window(), newline, source.ended(), &layout);
        choice = columns::choose(&layout.head, &columns, options);
    }
    drop(columns);
    let mut choice = choice?;
    if choice.by_content && !source.ended() {
        choice.notes.push(format!("the columns were chosen from the first {} MB", PREVIEW >> 20));
    }
    let mut scan = start(&mut source, size, newline, &layout, &choice, options);
    let mut spare = Vec::new();
    loop {
        let (window, ended) = (source.window(), source.ended());
        let whole =
            if ended { window.len() } else { memchr::memrchr(newline, window).map_or(0, |at| at + 1) };
        if whole == 0 && window.len() > LONGEST_LINE {
            scan.join();
            return Err(ReadProblem::LineTooLong { row: scan.row + 1, limit: LONGEST_LINE });
        }
        let taken = source.take(whole, spare);
        // More than the rest of a long line.
        let wanted = source.window().len() + BLOCK;
        scan.block(taken.bytes(), || source.fill(wanted)).map_err(ReadProblem::Io)?;
        if ended {
            break;
        }
        spare = taken.memory();
    }
    drop(source);
    let (samples, averaging) = scan.samples();
    let dialect = Some(written(encoding, &layout));
    samples::finish(Format::Text, dialect, &layout.head, choice, samples, averaging)
}

/// A text with its encoding, its line end and the table found in it.
fn open<R: Read>(reader: R) -> Result<(Source<R>, &'static str, u8, Layout), ReadProblem> {
    let mut source = Source::new(reader);
    source.fill(HEAD).map_err(ReadProblem::Io)?;
    let encoding = source.detect_encoding().name();
    check_text(source.window())?;
    let newline = newline(source.window());
    let head_lines = lines(source.window(), newline, source.ended());
    if head_lines.is_empty() && !source.ended() {
        return Err(ReadProblem::LineTooLong { row: 1, limit: HEAD });
    }
    let mut layout = layout::find(&head_lines).ok_or_else(|| no_table(&head_lines))?;
    layout.convention = conventions::apply(&head_lines, &mut layout);
    Ok((source, encoding, newline, layout))
}

/// Bytes as text: UTF-8, else Windows-1252, which has every byte.
pub(crate) fn decoded(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    layout::text(bytes)
}

/// Refuses bytes that no text has.
fn check_text(window: &[u8]) -> Result<(), ReadProblem> {
    if window.trim_ascii().is_empty() {
        return Err(ReadProblem::Empty);
    }
    let strange = |b: &u8| matches!(b, 0 | 1..=8 | 14..=25 | 27..=31);
    // A stray control character is a logger's hiccup, many are no text.
    let count = window.iter().filter(|b| strange(b)).count();
    if let Some(position) = window.iter().position(strange)
        && (window.contains(&0) || count * 100 > window.len())
    {
        return Err(ReadProblem::Binary { byte: window[position], position });
    }
    Ok(())
}

/// Lines end with LF, CRLF or, on very old systems, CR.
fn newline(window: &[u8]) -> u8 {
    if memchr::memchr(b'\n', window).is_none() && memchr::memchr(b'\r', window).is_some() {
        b'\r'
    } else {
        b'\n'
    }
}

/// The first whole lines; the last is whole also where the text ends.
fn lines(window: &[u8], newline: u8, ended: bool) -> Vec<&[u8]> {
    let mut lines: Vec<&[u8]> = window.split(|b| *b == newline).take(HEAD_LINES + 1).collect();
    let cut = lines.len() > HEAD_LINES || !ended || lines.last().is_some_and(|l| l.is_empty());
    if cut {
        lines.pop();
    }
    lines
}

fn no_table(lines: &[&[u8]]) -> ReadProblem {
    let first = lines.iter().find(|l| !l.trim_ascii().is_empty()).copied().unwrap_or_default();
    let first: String = layout::text(first).trim().chars().filter(|c| !c.is_control()).take(40).collect();
    ReadProblem::NoTable { lines: lines.len(), first }
}

/// The numbers of all columns in the window; NaN where there is none.
fn preview(window: &[u8], newline: u8, ended: bool, layout: &Layout) -> Vec<Vec<f64>> {
    let shape = layout.shape;
    let mut columns = vec![Vec::new(); layout.head.names.len()];
    let mut rows = window.split(|b| *b == newline).skip(layout.first_line).peekable();
    while let Some(line) = rows.next() {
        let cut = rows.peek().is_none() && !ended;
        if cut || line.trim_ascii().is_empty() || dialect::is_comment(line) {
            continue;
        }
        let cells = dialect::cells(line, shape.delimiter);
        for (index, column) in columns.iter_mut().enumerate() {
            let value = match cells.get(index).map(|c| number::cell(c, shape.decimal)) {
                Some(Cell::Number(value)) => value,
                _ => f64::NAN,
            };
            column.push(value);
        }
    }
    columns
}

/// A scan that has room for the whole file; the source stands at its first row.
fn start<R: Read>(
    source: &mut Source<R>,
    size: Option<u64>,
    newline: u8,
    layout: &Layout,
    choice: &Choice,
    options: &ReadOptions,
) -> Scan {
    let time = match &choice.time {
        Time::Column(taken) => TimePlan::Stamps { index: taken.index, seconds: taken.seconds },
        Time::Intervals(taken) => TimePlan::Intervals { index: taken.index, seconds: taken.seconds },
        Time::Rate(_) => TimePlan::Rate,
    };
    let plan = Plan {
        delimiter: layout.shape.delimiter,
        decimal: layout.shape.decimal,
        quoted: layout.quoted,
        newline,
        time,
        signal: choice.signal.index,
        quadrature: choice.quadrature.as_ref().map(|q| q.index),
    };
    let window = source.window();
    let rows = memchr::memchr_iter(newline, window).count();
    let room = match size {
        Some(size) if !window.is_empty() && !source.ended() => {
            // A hundredth more than rows like the first would need.
            (rows as f64 * size as f64 / window.len() as f64 * 1.01) as usize
        }
        _ => rows + 1,
    };
    let preamble: usize =
        window.split_inclusive(|b| *b == newline).take(layout.first_line).map(<[u8]>::len).sum();
    source.consume(preamble);
    // More than are held come within a block.
    let most = options.most_samples.unwrap_or(ReadOptions::MOST_SAMPLES).saturating_add(BLOCK / 2);
    Scan::new(plan, layout.first_line as u64 + 1, room.min(most), options.averaging(choice))
}

/// Reads all columns of the table, of its first `most_rows` rows.
pub(crate) fn hold(reader: impl Read, most_rows: usize) -> Result<HeldTables, ReadProblem> {
    let (mut source, encoding, newline, layout) = open(reader)?;
    let (shape, mut rows) = (layout.shape, Held::new(layout.head.names.len()));
    let preamble: usize =
        source.window().split_inclusive(|b| *b == newline).take(layout.first_line).map(<[u8]>::len).sum();
    source.consume(preamble);
    rows.row = layout.first_line as u64;
    let mut cut = false;
    while !cut {
        let window = source.window();
        let whole = if source.ended() {
            window.len()
        } else {
            memchr::memrchr(newline, window).map_or(0, |at| at + 1)
        };
        let (lines, used) = (&window[..whole], whole);
        for line in lines.strip_suffix(&[newline]).unwrap_or(lines).split(|b| *b == newline) {
            if rows.count >= most_rows {
                cut = true;
                break;
            }
            if !lines.is_empty() {
                rows.push(line, shape);
            }
        }
        if source.ended() {
            break;
        }
        source.consume(used);
        if source.window().len() > LONGEST_LINE {
            return Err(ReadProblem::LineTooLong { row: rows.row + 1, limit: LONGEST_LINE });
        }
        source.advance().map_err(ReadProblem::Io)?;
    }
    let mut tables = HeldTables::default();
    tables.dialect = Some(written(encoding, &layout));
    tables.cut = cut;
    tables.push(layout.head, rows.columns, rows.skipped);
    Ok(tables)
}

/// All columns of a text.
struct Held {
    columns: Vec<Vec<f64>>,
    skipped: Vec<Skipped>,
    /// Line number of the last line seen.
    row: u64,
    /// Rows kept.
    count: usize,
}

impl Held {
    fn new(columns: usize) -> Self {
        Self { columns: vec![Vec::new(); columns], skipped: Vec::new(), row: 0, count: 0 }
    }

    fn push(&mut self, line: &[u8], shape: dialect::Shape) {
        self.row += 1;
        if line.trim_ascii().is_empty() {
            return self.skip("blank line");
        }
        if dialect::is_comment(line) {
            return self.skip("remark");
        }
        let cells = dialect::cells(line, shape.delimiter);
        let value = |index: usize| match cells.get(index).map(|c| number::cell(c, shape.decimal)) {
            Some(Cell::Number(value)) => value,
            _ => f64::NAN,
        };
        let values: Vec<f64> = (0..self.columns.len()).map(value).collect();
        if values.iter().all(|v| v.is_nan()) {
            return self.skip("no number in any column");
        }
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        self.count += 1;
    }

    fn skip(&mut self, reason: &str) {
        match self.skipped.iter_mut().find(|s| s.reason == reason) {
            Some(skipped) => skipped.rows += 1,
            None => self.skipped.push(Skipped { reason: reason.to_owned(), rows: 1, first_row: self.row }),
        }
    }
}

/// How the text is written.
fn written(encoding: &'static str, layout: &Layout) -> Dialect {
    Dialect {
        delimiter: layout.shape.delimiter,
        decimal: layout.shape.decimal,
        encoding,
        convention: layout.convention,
        header_row: layout.header_line.map(|line| line as u64 + 1),
        first_data_row: layout.first_line as u64 + 1,
    }
}

#[cfg(test)]
mod tests;

//! Delimited text of any dialect.

mod choose;
mod content;
mod dialect;
mod layout;
mod names;
mod number;
mod scan;
mod source;
mod units;

use std::io::Read;

use slipfit::Record;

use self::{
    choose::{Choice, Taken, Time},
    layout::Layout,
    number::Cell,
    scan::{Plan, Scan, TimePlan},
    source::Source,
};
use crate::{
    Format, ReadOptions, ReadProblem,
    report::{ColumnTaken, Dialect, ReadReport, Reading, TimeSource},
};

/// Bytes from which the dialect is told.
const HEAD: usize = 256 << 10;
/// Bytes from which columns are told apart where their names do not do it.
const PREVIEW: usize = 8 << 20;
/// Longest line of a table.
const LONGEST_LINE: usize = 4 << 20;
/// Lines from which the dialect is told.
const HEAD_LINES: usize = 2000;

/// Reads the text that `reader` gives, of a size if it is known.
pub(crate) fn read(
    reader: impl Read,
    size: Option<u64>,
    options: &ReadOptions,
) -> Result<Reading, ReadProblem> {
    let mut source = Source::new(reader);
    source.fill(HEAD).map_err(ReadProblem::Io)?;
    let encoding = source.detect_encoding().name();
    check_text(source.window())?;
    let newline = newline(source.window());
    let head_lines = lines(source.window(), newline, source.ended());
    if head_lines.is_empty() && !source.ended() {
        return Err(ReadProblem::LineTooLong { row: 1, limit: HEAD });
    }
    let layout = layout::find(&head_lines).ok_or_else(|| no_table(&head_lines))?;
    let mut columns = preview(source.window(), newline, source.ended(), &layout);
    let mut choice = choose::choose(&layout, &columns, options);
    if !source.ended() && choice.as_ref().map_or(true, |c| c.by_content) {
        source.fill(PREVIEW).map_err(ReadProblem::Io)?;
        columns = preview(source.window(), newline, source.ended(), &layout);
        choice = choose::choose(&layout, &columns, options);
    }
    drop(columns);
    let mut choice = choice?;
    if choice.by_content && !source.ended() {
        choice.notes.push(format!("the columns were chosen from the first {} MB", PREVIEW >> 20));
    }
    let mut scan = start(&mut source, size, newline, &layout, &choice);
    loop {
        let used = scan.lines(source.window(), source.ended());
        if source.ended() {
            break;
        }
        source.consume(used);
        if source.window().len() > LONGEST_LINE {
            return Err(ReadProblem::LineTooLong { row: scan.row + 1, limit: LONGEST_LINE });
        }
        source.advance().map_err(ReadProblem::Io)?;
    }
    drop(source);
    finish(encoding, &layout, choice, scan)
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
    let mut columns = vec![Vec::new(); layout.names.len()];
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
) -> Scan {
    /// Room made beforehand at most: half a gigabyte a column.
    const MOST_ROWS: usize = 1 << 26;
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
    Scan::new(plan, layout.first_line as u64 + 1, room.min(MOST_ROWS))
}

fn finish(
    encoding: &'static str,
    layout: &Layout,
    choice: Choice,
    mut scan: Scan,
) -> Result<Reading, ReadProblem> {
    let skipped = scan.skipped();
    let column = choose::label(&choose::info(layout, choice.signal.index));
    linearise(&mut scan, &choice);
    let (rows_read, backwards) = (scan.read, scan.backwards);
    let record = match (&choice.time, choice.quadrature.is_some()) {
        (Time::Rate(rate), false) => Record::uniform(*rate, scan.signal),
        (Time::Rate(rate), true) => Record::lock_in_uniform(*rate, scan.signal, scan.quadrature),
        (_, false) => Record::new(scan.time_s, scan.signal),
        (_, true) => Record::lock_in(scan.time_s, scan.signal, scan.quadrature),
    };
    let record = record.map_err(|error| match (error, backwards) {
        (slipfit::Error::ConstantSignal { value }, _) => ReadProblem::ConstantSignal { column, value },
        (slipfit::Error::TooFewSamples { found, needed }, _) => {
            let reasons: Vec<String> = skipped
                .iter()
                .map(|s| {
                    format!(
                        "{} (row {}{})",
                        s.reason,
                        s.first_row,
                        if s.rows > 1 { " and others" } else { "" }
                    )
                })
                .collect();
            let skipped = if reasons.is_empty() {
                String::new()
            } else {
                format!("; left out: {}", reasons.join(", "))
            };
            ReadProblem::TooFewRows { read: found, needed, column, skipped }
        }
        (slipfit::Error::TimeBackwards { .. }, Some(back)) => ReadProblem::TimeBackwards {
            row: back.row,
            column: match &choice.time {
                Time::Column(t) | Time::Intervals(t) => choose::label(&choose::info(layout, t.index)),
                Time::Rate(_) => String::new(),
            },
            previous: back.previous,
            next: back.next,
        },
        (other, _) => ReadProblem::Record(other),
    })?;
    let record = record.with_kind(choice.kind).with_unit(choice.signal.unit.clone());
    let taken = |t: Taken| ColumnTaken { column: choose::info(layout, t.index), unit: t.unit, why: t.why };
    let report = ReadReport {
        path: String::new(),
        format: Format::Text,
        sha256: String::new(),
        bytes: 0,
        rows_read,
        skipped,
        dialect: Some(Dialect {
            delimiter: layout.shape.delimiter,
            decimal: layout.shape.decimal,
            encoding,
            header_row: layout.header_line.map(|line| line as u64 + 1),
            first_data_row: layout.first_line as u64 + 1,
        }),
        columns: (0..layout.names.len()).map(|i| choose::info(layout, i)).collect(),
        kind: choice.kind,
        tables: choice.tables,
        table: choice.group.table,
        runs: choice.runs,
        run: choice.group.run,
        time: match choice.time {
            Time::Column(t) => TimeSource::Column(taken(t)),
            Time::Intervals(t) => TimeSource::Intervals(taken(t)),
            Time::Rate(rate) => TimeSource::Rate(rate),
        },
        signal: taken(choice.signal),
        quadrature: choice.quadrature.map(taken),
        named_values: layout.named_values.clone(),
        notes: choice.notes,
    };
    Ok(Reading { record, report })
}

/// Makes levels in dB linear amplitudes, `10^(x/20)`.
fn linearise(scan: &mut Scan, choice: &Choice) {
    let linear = |values: &mut [f64]| values.iter_mut().for_each(|v| *v = 10f64.powf(*v / 20.0));
    if choice.signal.level {
        linear(&mut scan.signal);
    }
    if choice.quadrature.as_ref().is_some_and(|q| q.level) {
        linear(&mut scan.quadrature);
    }
}

#[cfg(test)]
mod tests;

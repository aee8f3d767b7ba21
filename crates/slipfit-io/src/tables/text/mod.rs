//! Delimited text of any dialect.

mod annotated;
mod beside;
mod dialect;
mod igor;
mod labelled;
mod layout;
mod number;
mod rewrite;
mod scan;
mod source;
mod stamp;
mod vendors;

use std::{io::Read, sync::Arc};

pub(crate) use self::layout::text as decoded;
#[cfg(feature = "excel")]
pub(crate) use self::stamp::written as stamp;
use self::{
    layout::Layout,
    rewrite::Rewrite,
    scan::{Part, Plan},
    source::Source,
};
use super::table::{Batch, Held, Sink, TableSource, gather};
use crate::{
    columns::head::Head,
    error::ReadProblem,
    report::{Dialect, Skipped},
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

/// A text that is read once, from front to back; its table is found in its first lines.
pub(crate) struct Text<R> {
    source: Source<R>,
    /// Its size in bytes, if it is known.
    size: Option<u64>,
    encoding: &'static str,
    newline: u8,
    layout: Layout,
    /// How its lines are written anew, where they are no rows of numbers alone.
    rewrite: Option<Arc<Rewrite>>,
    /// Every column, where the window that was looked at holds the whole text and each line of it is a row.
    previewed: Option<Vec<Vec<f64>>>,
}

/// The table of a text that is held as a whole.
pub(crate) fn hold(bytes: &[u8]) -> Result<(Held, Option<Dialect>), ReadProblem> {
    let mut text = Text::open(bytes, None)?;
    let held = gather(&mut text, 0, usize::MAX)?;
    Ok((held, text.dialect()))
}

impl<R: Read> Text<R> {
    pub(crate) fn open(reader: R, size: Option<u64>) -> Result<Self, ReadProblem> {
        let mut source = Source::new(reader);
        source.fill(HEAD).map_err(ReadProblem::Io)?;
        let encoding = source.detect_encoding().name();
        check_text(source.window())?;
        let newline = newline(source.window());
        let head_lines = lines(source.window(), newline, source.ended());
        if head_lines.is_empty() && !source.ended() {
            return Err(ReadProblem::LineTooLong { row: 1, limit: HEAD });
        }
        let plain = layout::find(&head_lines);
        let clear = plain.as_ref().is_some_and(|layout| dialect::is_clear(&head_lines, layout.shape));
        let rewrite = match plain.as_ref().filter(|_| clear) {
            Some(layout) => Rewrite::of_table(&head_lines, layout)?,
            None => Rewrite::find(&head_lines),
        };
        let rewritten = rewrite.and_then(|rewrite| Some((rewritten(&head_lines, &rewrite)?, rewrite)));
        let (mut layout, rewrite) = match rewritten {
            Some((layout, rewrite)) => (layout, Some(Arc::new(rewrite))),
            None => (plain.ok_or_else(|| no_table(&head_lines))?, None),
        };
        layout.convention = vendors::apply(&head_lines, &mut layout);
        if layout.convention == Some(igor::WRITER) {
            source.fill(PREVIEW).map_err(ReadProblem::Io)?;
            igor::add_scale(source.window(), &mut layout);
        }
        Ok(Self { source, size, encoding, newline, layout, rewrite, previewed: None })
    }

    fn plan(&self, wanted: &[usize]) -> Plan {
        let mut plan = Plan::new(self.layout.shape, self.layout.quoted, self.newline, wanted);
        plan.day = self.layout.day;
        plan.rewrite.clone_from(&self.rewrite);
        plan
    }

    /// The whole lines of the window, without its first so many.
    fn rows(&self, without: usize) -> &[u8] {
        let window = self.source.window();
        let from = window.split_inclusive(|b| *b == self.newline).take(without).map(<[u8]>::len).sum();
        &window[from..self.whole().max(from)]
    }

    /// Bytes of the whole lines in the window.
    fn whole(&self) -> usize {
        let window = self.source.window();
        if self.source.ended() {
            window.len()
        } else {
            memchr::memrchr(self.newline, window).map_or(0, |at| at + 1)
        }
    }
}

impl<R: Read> TableSource for Text<R> {
    fn heads(&self) -> Vec<&Head> {
        vec![&self.layout.head]
    }

    fn scan(&mut self, _: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        if let Some(columns) = self.previewed.take()
            && let Some(columns) = wanted.iter().map(|i| columns.get(*i).map(Vec::as_slice)).collect()
        {
            let (columns, line): (Vec<&[f64]>, _) = (columns, self.layout.first_line as u64 + 1);
            sink(Batch { columns: &columns, line: Some(line), odd: &[], more: false });
            return Ok(Vec::new());
        }
        let plan = self.plan(wanted);
        let preamble = self.whole() - self.rows(self.layout.first_line).len();
        self.source.consume(preamble);
        let mut line = self.layout.first_line as u64 + 1;
        let mut hand_on = |parts: Vec<Part>| {
            let count = parts.len();
            parts.into_iter().enumerate().all(|(i, part)| {
                let columns: Vec<&[f64]> = part.columns.iter().map(Vec::as_slice).collect();
                let more = i + 1 < count;
                let batch = Batch { columns: &columns, line: Some(line), odd: &part.odd, more };
                line += part.lines;
                sink(batch)
            })
        };
        let mut read = Vec::new();
        let mut spare = Vec::new();
        loop {
            let (whole, ended) = (self.whole(), self.source.ended());
            if whole == 0 && self.source.window().len() > LONGEST_LINE {
                hand_on(read);
                return Err(ReadProblem::LineTooLong { row: line, limit: LONGEST_LINE });
            }
            let taken = self.source.take(whole, spare);
            // More than the rest of a long line.
            let wanted = self.source.window().len() + BLOCK;
            let source = &mut self.source;
            let (parts, done) = plan.read(taken.bytes(), || {
                let more = hand_on(std::mem::take(&mut read));
                source.fill(wanted).map(|()| more)
            });
            read = parts;
            if !done.map_err(ReadProblem::Io)? {
                return Ok(Vec::new());
            }
            if ended {
                break;
            }
            spare = taken.memory();
        }
        hand_on(read);
        Ok(Vec::new())
    }

    fn window(&mut self, attempt: usize) -> Result<Option<Held>, ReadProblem> {
        if attempt > 0 {
            if attempt > 1 || self.source.ended() {
                return Ok(None);
            }
            self.source.fill(PREVIEW).map_err(ReadProblem::Io)?;
        }
        let head = self.layout.head.clone();
        let part = self.plan(&head.all()).part(self.rows(self.layout.first_line));
        let clean = self.source.ended() && part.odd.is_empty();
        self.previewed = clean.then(|| part.columns.clone());
        Ok(Some(Held { head, columns: part.columns, skipped: Vec::new(), cut: !self.source.ended() }))
    }

    fn previewed(&self) -> String {
        format!("{} MB", PREVIEW >> 20)
    }

    fn rows_expected(&self) -> usize {
        let window = self.source.window();
        let rows = memchr::memchr_iter(self.newline, window).count();
        match self.size {
            // A hundredth more than rows like the first would need.
            Some(size) if !window.is_empty() && !self.source.ended() => {
                (rows as f64 * size as f64 / window.len() as f64 * 1.01) as usize
            }
            _ => rows + 1,
        }
    }

    fn dialect(&self) -> Option<Dialect> {
        Some(Dialect {
            delimiter: self.layout.shape.delimiter,
            decimal: self.layout.shape.decimal,
            encoding: self.encoding,
            convention: self.layout.convention,
            header_row: self.layout.header_line.map(|line| line as u64 + 1),
            first_data_row: self.layout.first_line as u64 + 1,
        })
    }
}

/// The table of a text whose lines are written anew.
fn rewritten(lines: &[&[u8]], rewrite: &Rewrite) -> Option<Layout> {
    let plain = rewrite.head(lines);
    let plain: Vec<&[u8]> = plain.iter().map(Vec::as_slice).collect();
    let mut layout = layout::find(&plain)?;
    let names = rewrite.names();
    if layout.header_line.is_none() && names.len() == layout.head.names.len() {
        layout.head.names = names;
    }
    layout.head.named_values.extend_from_slice(rewrite.named_values());
    layout.head.notes.push(rewrite.note());
    Some(layout)
}

/// Refuses bytes that no text has.
fn check_text(window: &[u8]) -> Result<(), ReadProblem> {
    if window.trim_ascii().is_empty() {
        return Err(ReadProblem::Empty);
    }
    // Without branches, so that it runs in vector instructions.
    let strange = |b: u8| (b < 9) | ((14..32).contains(&b) & (b != 26));
    let count_of = |bytes: &[u8]| usize::from(bytes.iter().map(|b| u8::from(strange(*b))).sum::<u8>());
    // A stray control character is a logger's hiccup, many are no text.
    let count: usize = window.chunks(128).map(count_of).sum();
    if count > 0
        && let Some(position) = window.iter().position(|b| strange(*b))
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
    let first: String = decoded(first).trim().chars().filter(|c| !c.is_control()).take(40).collect();
    ReadProblem::NoTable { lines: lines.len(), first }
}

#[cfg(test)]
mod tests;

//! Delimited text of any dialect.

mod annotated;
mod dialect;
mod igor;
mod labelled;
mod layout;
mod number;
mod part;
mod rewrite;
mod scan;
mod sections;
mod settings;
mod source;
mod stamp;
mod vendors;
mod wrapped;

use std::{io::Read, ops::Range, sync::Arc};

pub(crate) use self::layout::text as decoded;
#[cfg(feature = "excel")]
pub(crate) use self::stamp::written as stamp;
use self::{
    layout::Layout, part::Part, rewrite::Rewrite, scan::Plan, sections::Section, source::Source,
    wrapped::Wrapped,
};
use super::table::{self, Batch, LoadedTable, Reason, Sink, TableSource, gather};
use crate::{
    columns::head::Head,
    error::ReadProblem,
    report::{Dialect, Skipped},
};

/// Number of bytes from which the dialect is detected.
const HEAD: usize = 256 << 10;
/// Number of bytes from which the roles of columns are determined if their names do not suffice.
const PREVIEW: usize = 8 << 20;
/// Maximum size in bytes of a text that may have several tables below each other.
const LARGEST_WITH_SEVERAL_TABLES: usize = LONGEST_LINE;
/// Maximum length of a line of a table.
const LONGEST_LINE: usize = 4 << 20;
/// Number of bytes read while the preceding ones are converted to numbers.
const BLOCK: usize = 2 << 20;
/// Number of lines from which the dialect is detected.
const HEAD_LINES: usize = 2000;

/// A text that is read once, from start to end; its table is found in its first lines. Several tables below each other
/// are found only in a text that fits into the window.
pub(crate) struct Text<R> {
    source: Source<R>,
    /// Its size in bytes, if it is known.
    size: Option<u64>,
    encoding: &'static str,
    newline: u8,
    /// Number of bytes of the window from which the dialect was detected.
    looked_at: usize,
    /// At least one; if there are several, only the first may lack its place in the window.
    tables: Vec<TextTable>,
    /// Every column, if the examined window contains the whole text and each of its lines is a row.
    previewed: Option<Vec<Vec<f64>>>,
}

/// A table of a text.
struct TextTable {
    layout: Layout,
    /// How its lines are rewritten, if they are not rows of plain numbers.
    rewrite: Option<Arc<Rewrite>>,
    /// Number of lines above it in the text.
    lines_before: usize,
    /// Its position in the window, if there are several tables.
    place: Option<Range<usize>>,
    /// How the values of one signal are distributed over several columns.
    wrapped: Option<Wrapped>,
}

impl TextTable {
    /// The table of a text with these first lines.
    fn find(lines: &[&[u8]]) -> Result<Self, ReadProblem> {
        let plain = layout::find(lines);
        let clear = plain.as_ref().is_some_and(|layout| dialect::is_clear(lines, layout.shape));
        let rewrite = match plain.as_ref().filter(|_| clear) {
            Some(layout) => Rewrite::of_table(lines, layout)?,
            None => Rewrite::find(lines),
        };
        let rewritten = rewrite.and_then(|rewrite| Some((rewritten(lines, &rewrite)?, rewrite)));
        let (mut layout, rewrite) = match rewritten {
            Some((layout, rewrite)) => (layout, Some(Arc::new(rewrite))),
            None => (plain.ok_or_else(|| no_table(lines))?, None),
        };
        layout.convention = vendors::apply(lines, &mut layout);
        Ok(Self { layout, rewrite, lines_before: 0, place: None, wrapped: None })
    }

    /// The line number of its first row in the text, from 1.
    fn first_row(&self) -> u64 {
        (self.lines_before + self.layout.first_line) as u64 + 1
    }
}

/// The tables of a text in memory.
pub(crate) fn load_tables(bytes: &[u8]) -> Result<Vec<LoadedTable>, ReadProblem> {
    let mut text = Text::open(bytes, None)?;
    (0..text.tables.len()).map(|table| gather(&mut text, table, usize::MAX)).collect()
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
        let mut table = TextTable::find(&head_lines)?;
        let wrapped = Wrapped::find(&head_lines, &table.layout).filter(|_| table.rewrite.is_none());
        let mut described = table.layout.clone();
        if let Some(wrapped) = wrapped {
            wrapped.describe(&head_lines, &mut described);
        }
        let looked_at = source.window().len();
        let is_igor = table.layout.convention == Some(igor::WRITER);
        source.fill(if is_igor { PREVIEW } else { LARGEST_WITH_SEVERAL_TABLES }).map_err(ReadProblem::Io)?;
        if is_igor {
            igor::add_scale(source.window(), &mut table.layout);
        }
        let mut text =
            Self { source, size, encoding, newline, looked_at, tables: vec![table], previewed: None };
        if wrapped.is_some_and(|wrapped| text.is_wrapped(wrapped)) {
            (text.tables[0].wrapped, text.tables[0].layout) = (wrapped, described);
        } else if let Some(tables) = text.several() {
            text.tables = tables;
        }
        Ok(text)
    }

    /// Whether the text contains as many values as its header states; estimated from its size if it is longer than the
    /// window.
    fn is_wrapped(&self, wrapped: Wrapped) -> bool {
        if !self.source.ended() {
            return self.size.is_some() && wrapped.fits_about(self.rows_expected());
        }
        let (window, first_line) = (self.source.window().len(), self.tables[0].layout.first_line);
        wrapped.fits(self.plan(0, &wrapped.all()).part(self.rows(window, first_line)))
    }

    /// The tables below each other, if a text in memory has several.
    fn several(&self) -> Option<Vec<TextTable>> {
        let first = self.tables.first()?;
        let is_one = first.rewrite.is_some() || first.layout.convention == Some(igor::WRITER);
        if is_one || !self.source.ended() {
            return None;
        }
        let window = self.source.window();
        let sections = sections::find(window, self.newline, &first.layout);
        let table = |section: Section| {
            let Section { name, lines_before, bytes } = section;
            let mut table = TextTable::find(&lines(&window[bytes.clone()], self.newline, true)).ok()?;
            table.layout.head.name = name;
            Some(TextTable { lines_before, place: Some(bytes), ..table })
        };
        let tables: Option<Vec<TextTable>> = sections.into_iter().map(table).collect();
        tables.filter(|tables| tables.len() > 1)
    }

    fn plan(&self, table: usize, wanted: &[usize]) -> Plan {
        let TextTable { layout, rewrite, wrapped, .. } = &self.tables[table];
        let all = wrapped.map(Wrapped::all);
        let wanted = all.as_deref().unwrap_or(wanted);
        let mut plan = Plan::new(layout.shape, layout.quoted, self.newline, wanted);
        plan.wrapped = *wrapped;
        plan.block_headers = layout.convention == Some(vendors::LABVIEW);
        plan.day = layout.day;
        plan.rewrite.clone_from(rewrite);
        // Only one table is read from a text that is longer than the window.
        let is_table = wrapped.is_none() && !self.source.ended();
        plan.names = is_table.then(|| layout.head.names.clone().into());
        plan
    }

    /// The rows of one of several tables in the window.
    fn scan_in_window(&self, table: usize, wanted: &[usize], sink: Sink<'_>) {
        let TextTable { layout, place, .. } = &self.tables[table];
        let bytes = &self.source.window()[place.clone().unwrap_or_default()];
        let above =
            bytes.split_inclusive(|b| *b == self.newline).take(layout.first_line).map(<[u8]>::len).sum();
        let mut line = self.tables[table].first_row();
        let (parts, ()) = self.plan(table, wanted).read(&bytes[above..], || ());
        let count = parts.len();
        for (i, part) in parts.into_iter().enumerate() {
            let columns: Vec<&[f64]> = part.columns.iter().map(Vec::as_slice).collect();
            if !sink(Batch {
                columns: &columns,
                line: Some(line),
                irregularities: &part.irregularities,
                more: i + 1 < count,
            }) {
                return;
            }
            line += part.lines;
        }
    }

    /// The whole lines in the first `within` bytes of the window, without the first `without` lines.
    fn rows(&self, within: usize, without: usize) -> &[u8] {
        let window = self.source.window();
        let from = window.split_inclusive(|b| *b == self.newline).take(without).map(<[u8]>::len).sum();
        &window[from..self.whole(within).max(from)]
    }

    /// Length of the whole lines in the first `within` bytes of the window.
    fn whole(&self, within: usize) -> usize {
        let window = self.source.window();
        match window.get(..within) {
            Some(first) if self.is_cut(within) => memchr::memrchr(self.newline, first).map_or(0, |at| at + 1),
            _ => window.len(),
        }
    }

    /// Whether the text continues after the first `within` bytes of the window.
    fn is_cut(&self, within: usize) -> bool {
        !self.source.ended() || within < self.source.window().len()
    }
}

impl<R: Read> TableSource for Text<R> {
    fn heads(&self) -> Vec<&Head> {
        self.tables.iter().map(|table| &table.layout.head).collect()
    }

    fn scan(&mut self, table: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        if self.tables[table].place.is_some() {
            self.scan_in_window(table, wanted, sink);
            return Ok(Vec::new());
        }
        if let Some(columns) = self.previewed.take()
            && let Some(columns) = wanted.iter().map(|i| columns.get(*i).map(Vec::as_slice)).collect()
        {
            let table = &self.tables[table];
            let (columns, line): (Vec<&[f64]>, _) =
                (columns, table.wrapped.is_none().then(|| table.first_row()));
            sink(Batch { columns: &columns, line, irregularities: &[], more: false });
            return Ok(Vec::new());
        }
        let plan = self.plan(table, wanted);
        let (window, first_line) = (self.source.window().len(), self.tables[table].layout.first_line);
        let preamble = self.whole(window) - self.rows(window, first_line).len();
        self.source.consume(preamble);
        let mut line = self.tables[table].first_row();
        let mut other = OtherTable::default();
        let is_wrapped = self.tables[table].wrapped.is_some();
        let mut hand_on = |parts: Vec<Part>| {
            let count = parts.len();
            parts.into_iter().enumerate().all(|(i, mut part)| {
                let lines = part.lines;
                other.take_from(&mut part, line);
                let columns: Vec<&[f64]> = part.columns.iter().map(Vec::as_slice).collect();
                let more = i + 1 < count;
                // If several values share a line, rows are values.
                let of_line = (!is_wrapped).then_some(line);
                let batch =
                    Batch { columns: &columns, line: of_line, irregularities: &part.irregularities, more };
                line += lines;
                sink(batch)
            })
        };
        let mut read = Vec::new();
        let mut spare = Vec::new();
        loop {
            let (whole, ended) = (self.whole(self.source.window().len()), self.source.ended());
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
        Ok(other.skipped())
    }

    fn window(&mut self, attempt: usize) -> Result<Option<LoadedTable>, ReadProblem> {
        let seen = attempt > 1 || attempt > 0 && !self.is_cut(self.looked_at);
        let [TextTable { layout, place: None, .. }] = &self.tables[..] else { return Ok(None) };
        if seen {
            return Ok(None);
        }
        let (head, first_line) = (layout.head.clone(), layout.first_line);
        if attempt > 0 {
            self.source.fill(PREVIEW).map_err(ReadProblem::Io)?;
        }
        let within = if attempt == 0 { self.looked_at } else { self.source.window().len() };
        let part = self.plan(0, &head.all()).part(self.rows(within, first_line));
        let cut = self.is_cut(within);
        let clean = !cut && part.irregularities.is_empty();
        self.previewed = clean.then(|| part.columns.clone());
        Ok(Some(LoadedTable { head, columns: part.columns, skipped: Vec::new(), cut, dialect: None }))
    }

    fn previewed(&self) -> String {
        if self.tables.len() > 1 { table::previewed() } else { format!("{} MB", PREVIEW >> 20) }
    }

    fn rows_expected(&self) -> usize {
        let window = self.source.window();
        let rows = memchr::memchr_iter(self.newline, window).count();
        match self.size {
            // One per cent more than needed for rows like the first ones.
            Some(size) if !window.is_empty() && !self.source.ended() => {
                (rows as f64 * size as f64 / window.len() as f64 * 1.01) as usize
            }
            _ => rows + 1,
        }
    }

    fn dialect(&self, table: usize) -> Option<Dialect> {
        let table = &self.tables[table];
        let layout = &table.layout;
        Some(Dialect {
            delimiter: layout.shape.delimiter,
            decimal: layout.shape.decimal,
            encoding: self.encoding,
            convention: layout.convention,
            header_row: layout.header_line.map(|line| (table.lines_before + line) as u64 + 1),
            first_data_row: table.first_row(),
        })
    }
}

/// The rows below another header, which belong to another table; they are counted.
#[derive(Default)]
struct OtherTable {
    first_row: Option<u64>,
    rows: u64,
}

impl OtherTable {
    /// Removes them from the rows that begin at a line.
    fn take_from(&mut self, part: &mut Part, line: u64) {
        let keep = match self.first_row {
            Some(_) => {
                part.irregularities.clear();
                0
            }
            None => {
                let Some(at) = part
                    .irregularities
                    .iter()
                    .position(|irregularity| irregularity.reason == Reason::OtherHeader)
                else {
                    return;
                };
                let row = part.irregularities[at].row;
                let no_rows = part.irregularities[..at]
                    .iter()
                    .filter(|irregularity| irregularity.reason.is_no_row())
                    .count();
                self.first_row = Some(line + (row + no_rows) as u64);
                part.irregularities.truncate(at);
                row
            }
        };
        let rows = part.columns.first().map_or(0, Vec::len);
        self.rows += (rows - keep) as u64;
        part.columns.iter_mut().for_each(|column| column.truncate(keep));
    }

    fn skipped(self) -> Vec<Skipped> {
        let of = |first_row| Skipped { reason: Reason::OtherHeader.text(), rows: self.rows, first_row };
        self.first_row.map(of).into_iter().collect()
    }
}

/// The layout of a text whose lines are rewritten.
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

/// Rejects bytes that do not occur in text.
fn check_text(window: &[u8]) -> Result<(), ReadProblem> {
    if window.trim_ascii().is_empty() {
        return Err(ReadProblem::Empty);
    }
    // Without branches, so that it compiles to vector instructions.
    let strange = |b: u8| (b < 9) | ((14..32).contains(&b) & (b != 26));
    let count_of = |bytes: &[u8]| usize::from(bytes.iter().map(|b| u8::from(strange(*b))).sum::<u8>());
    // A single control character is a glitch of a logger; many of them mean that this is not text.
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

/// The first whole lines; at the end of the text the last line is whole as well.
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

//! Rows to samples, as fast as the file can be had.

use std::collections::HashMap;

use memchr::{memchr, memchr_iter, memrchr};

use super::{
    dialect::{self, separator},
    number::{self, Cell},
};
use crate::columns::units::Seconds;
use crate::report::{Decimal, Delimiter, Skipped};
use crate::samples::{Backwards, Samples};

/// Columns read at once: time, signal, quadrature.
const SLOTS: usize = 3;

/// What to read from each row.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) delimiter: Delimiter,
    pub(super) decimal: Decimal,
    /// Whether cells are quoted, so that separators may stand inside.
    pub(super) quoted: bool,
    /// Byte between two lines.
    pub(super) newline: u8,
    pub(super) time: TimePlan,
    /// Indices of signal and quadrature.
    pub(super) signal: usize,
    pub(super) quadrature: Option<usize>,
}

/// How a row gets its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TimePlan {
    /// The stamp.
    Stamps { index: usize, seconds: Seconds },
    /// The sum of the steps so far.
    Intervals { index: usize, seconds: Seconds },
    /// From a rate: rows without a signal keep their place.
    Rate,
}

/// Why a row gave no sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Reason {
    BlankLine,
    Comment,
    TooFew { column: usize },
    Missing { column: usize },
    Text { column: usize },
}

/// How often a row was left out for a reason.
#[derive(Debug, Clone)]
struct Count {
    rows: u64,
    first_row: u64,
    order: usize,
    example: String,
}

/// Samples as they come.
#[derive(Debug)]
pub(super) struct Scan {
    plan: Plan,
    /// Columns wanted in order, with their slots.
    wanted: Vec<(usize, usize)>,
    pub(super) time_s: Vec<f64>,
    pub(super) signal: Vec<f64>,
    pub(super) quadrature: Vec<f64>,
    /// Line number of the last line seen.
    pub(super) row: u64,
    /// Rows that gave a sample.
    pub(super) read: u64,
    elapsed: f64,
    started: bool,
    pub(super) backwards: Option<Backwards>,
    reasons: HashMap<Reason, Count>,
}

impl Scan {
    /// A scan whose first line is number `first_row`, making room for `rows`.
    pub(super) fn new(plan: Plan, first_row: u64, rows: usize) -> Self {
        let mut wanted = vec![(plan.signal, 1)];
        wanted.extend(plan.quadrature.map(|q| (q, 2)));
        match plan.time {
            TimePlan::Stamps { index, .. } | TimePlan::Intervals { index, .. } => wanted.push((index, 0)),
            TimePlan::Rate => {}
        }
        wanted.sort_unstable();
        let timed = plan.time != TimePlan::Rate;
        let room = |used: bool| Vec::with_capacity(if used { rows } else { 0 });
        Self {
            wanted,
            time_s: room(timed),
            signal: room(true),
            quadrature: room(plan.quadrature.is_some()),
            row: first_row - 1,
            read: 0,
            elapsed: 0.0,
            started: false,
            backwards: None,
            reasons: HashMap::new(),
            plan,
        }
    }

    /// Reads the whole lines in `bytes`, of the last one also an unfinished
    /// part if `last`. Returns the bytes used.
    pub(super) fn lines(&mut self, bytes: &[u8], last: bool) -> usize {
        let newline = self.plan.newline;
        let whole = memrchr(newline, bytes).map_or(0, |at| at + 1);
        let mut start = 0;
        for end in memchr_iter(newline, &bytes[..whole]) {
            self.line(&bytes[start..end]);
            start = end + 1;
        }
        if last && whole < bytes.len() {
            self.line(&bytes[whole..]);
            return bytes.len();
        }
        whole
    }

    /// What was read.
    pub(super) fn samples(self) -> Samples {
        let skipped = self.skipped();
        Samples {
            time_s: self.time_s,
            signal: self.signal,
            quadrature: self.quadrature,
            read: self.read,
            backwards: self.backwards,
            skipped,
        }
    }

    /// Rows left out, by reason.
    fn skipped(&self) -> Vec<Skipped> {
        let mut counted: Vec<(&Reason, &Count)> = self.reasons.iter().collect();
        counted.sort_by_key(|(_, count)| count.order);
        counted
            .into_iter()
            .map(|(reason, count)| Skipped {
                reason: match reason {
                    Reason::BlankLine => "blank line".to_owned(),
                    Reason::Comment => "remark".to_owned(),
                    Reason::TooFew { column } => format!("row ends before column {column}"),
                    Reason::Missing { column } => format!("no value in column {column}"),
                    Reason::Text { column } => {
                        format!("`{}` in column {column} is not a number", count.example)
                    }
                },
                rows: count.rows,
                first_row: count.first_row,
            })
            .collect()
    }

    fn line(&mut self, line: &[u8]) {
        self.row += 1;
        let mut values = [0.0; SLOTS];
        if self.quick(line, &mut values) {
            self.push(values);
        } else {
            self.careful(line);
        }
    }

    fn push(&mut self, values: [f64; SLOTS]) {
        let time_s = match self.plan.time {
            TimePlan::Stamps { seconds, .. } => seconds.of(values[0]),
            TimePlan::Intervals { seconds, .. } => {
                // The first sample has nothing before it.
                if self.started {
                    self.elapsed += values[0];
                }
                seconds.of(self.elapsed)
            }
            TimePlan::Rate => f64::NAN,
        };
        self.started = true;
        if self.plan.time != TimePlan::Rate {
            if let Some(&previous) = self.time_s.last()
                && time_s < previous
                && self.backwards.is_none()
            {
                self.backwards = Some(Backwards { row: self.row, previous, next: time_s });
            }
            self.time_s.push(time_s);
        }
        self.signal.push(values[1]);
        if self.plan.quadrature.is_some() {
            self.quadrature.push(values[2]);
        }
        self.read += 1;
    }

    /// Reads a row of plain numbers; `false` if anything is unusual.
    #[inline]
    fn quick(&self, line: &[u8], values: &mut [f64; SLOTS]) -> bool {
        if self.plan.quoted {
            return false;
        }
        match (separator(self.plan.delimiter), self.plan.decimal) {
            (Some(separator), Decimal::Point) => self.quick_separated(line, separator, values),
            (Some(separator), Decimal::Comma) => self.quick_comma(line, separator, values),
            (None, Decimal::Point) => self.quick_blanks(line, values),
            (None, Decimal::Comma) => false,
        }
    }

    fn quick_separated(&self, line: &[u8], separator: u8, values: &mut [f64; SLOTS]) -> bool {
        let (mut rest, mut column) = (line, 0);
        for &(index, slot) in &self.wanted {
            while column < index {
                if rest.first() == Some(&b'"') {
                    return false;
                }
                let Some(at) = memchr(separator, rest) else { return false };
                rest = &rest[at + 1..];
                column += 1;
            }
            // A remark that reads as a number would begin with its mark.
            let cell = skip_blanks(rest);
            let Ok((value, used)) = fast_float2::parse_partial::<f64, _>(cell) else { return false };
            let after = skip_blanks(&cell[used..]);
            let closed = after.first().is_none_or(|b| *b == separator || *b == b'\r');
            if !closed || !value.is_finite() {
                return false;
            }
            values[slot] = value;
            rest = after;
        }
        // A remark in an unread first cell.
        self.wanted[0].0 == 0 || !dialect::is_comment(line)
    }

    fn quick_comma(&self, line: &[u8], separator: u8, values: &mut [f64; SLOTS]) -> bool {
        let (mut rest, mut column) = (line, 0);
        for &(index, slot) in &self.wanted {
            while column < index {
                let Some(at) = memchr(separator, rest) else { return false };
                rest = &rest[at + 1..];
                column += 1;
            }
            let end = memchr(separator, rest).unwrap_or(rest.len());
            match number::number(rest[..end].trim_ascii(), Decimal::Comma) {
                Some(value) if value.is_finite() => values[slot] = value,
                _ => return false,
            }
        }
        self.wanted[0].0 == 0 || !dialect::is_comment(line)
    }

    fn quick_blanks(&self, line: &[u8], values: &mut [f64; SLOTS]) -> bool {
        let blank = |b: &u8| b.is_ascii_whitespace();
        let (mut rest, mut column) = (line.trim_ascii_start(), 0);
        for &(index, slot) in &self.wanted {
            while column < index {
                let Some(at) = rest.iter().position(blank) else { return false };
                rest = rest[at..].trim_ascii_start();
                column += 1;
            }
            let Ok((value, used)) = fast_float2::parse_partial::<f64, _>(rest) else { return false };
            let after = &rest[used..];
            if !after.first().is_none_or(blank) || !value.is_finite() {
                return false;
            }
            values[slot] = value;
            rest = after;
        }
        let whole = self.plan.delimiter != Delimiter::None || rest.trim_ascii().is_empty();
        whole && (self.wanted[0].0 == 0 || !dialect::is_comment(line))
    }

    /// Reads any row, or says why not.
    #[cold]
    fn careful(&mut self, line: &[u8]) {
        if line.trim_ascii().is_empty() {
            return self.skip(Reason::BlankLine, b"");
        }
        if dialect::is_comment(line) {
            return self.skip(Reason::Comment, b"");
        }
        let cells = dialect::cells(line, self.plan.delimiter);
        let mut values = [f64::NAN; SLOTS];
        let mut missing = None;
        for &(index, slot) in &self.wanted {
            let column = index + 1;
            let Some(&cell) = cells.get(index) else {
                missing = missing.or(Some((Reason::TooFew { column }, &b""[..])));
                continue;
            };
            match number::cell(cell, self.plan.decimal) {
                Cell::Number(value) => values[slot] = value,
                Cell::Missing => missing = missing.or(Some((Reason::Missing { column }, b""))),
                Cell::Text => missing = missing.or(Some((Reason::Text { column }, cell))),
            }
        }
        let Some((reason, cell)) = missing else { return self.push(values) };
        self.skip(reason, cell);
        match self.plan.time {
            // The row was sampled: it keeps its time.
            TimePlan::Rate => {
                self.signal.push(f64::NAN);
                if self.plan.quadrature.is_some() {
                    self.quadrature.push(f64::NAN);
                }
            }
            TimePlan::Intervals { .. } if values[0].is_finite() => {
                if self.started {
                    self.elapsed += values[0];
                }
                self.started = true;
            }
            _ => {}
        }
    }

    fn skip(&mut self, reason: Reason, cell: &[u8]) {
        const LONGEST: usize = 24;
        let (row, order) = (self.row, self.reasons.len());
        let count = self.reasons.entry(reason).or_insert_with(|| {
            let text = super::layout::text(number::trim(cell));
            let mut example: String = text.chars().take(LONGEST).filter(|c| !c.is_control()).collect();
            if text.chars().count() > LONGEST {
                example.push('…');
            }
            Count { rows: 0, first_row: row, order, example }
        });
        count.rows += 1;
    }
}

#[inline]
fn skip_blanks(mut bytes: &[u8]) -> &[u8] {
    while let [b' ', rest @ ..] = bytes {
        bytes = rest;
    }
    bytes
}

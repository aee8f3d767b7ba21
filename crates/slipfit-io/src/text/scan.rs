//! Rows to samples, as fast as the file can be had.

use std::collections::HashMap;

use memchr::{memchr, memchr_iter, memchr2};
use slipfit::record::Averaging;

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
    /// Rows that gave a sample, and the line number of the first.
    pub(super) read: u64,
    first: u64,
    elapsed: f64,
    started: bool,
    pub(super) backwards: Option<Backwards>,
    reasons: HashMap<Reason, Count>,
    averaging: Averaging,
    /// What other cores have read behind this.
    parts: Vec<Scan>,
}

/// Whole lines in parts of about that many bytes.
#[cfg(feature = "threads")]
fn parts(mut bytes: &[u8], newline: u8, most: usize) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let end = bytes
            .get(most..)
            .map_or(bytes.len(), |rest| memchr(newline, rest).map_or(bytes.len(), |at| most + at + 1));
        let (part, rest) = bytes.split_at(end);
        bytes = rest;
        (!part.is_empty()).then_some(part)
    })
}

impl Scan {
    /// A scan whose first line is number `first_row`, making room for `rows`.
    pub(super) fn new(plan: Plan, first_row: u64, rows: usize, averaging: Averaging) -> Self {
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
            first: 0,
            elapsed: 0.0,
            started: false,
            backwards: None,
            reasons: HashMap::new(),
            averaging,
            parts: Vec::new(),
            plan,
        }
    }

    /// Reads whole lines, of which the last may lack its end.
    pub(super) fn lines(&mut self, bytes: &[u8]) {
        if let (Some(separator), Decimal::Point, false) =
            (separator(self.plan.delimiter), self.plan.decimal, self.plan.quoted)
        {
            return self.separated_lines(bytes, separator);
        }
        let mut start = 0;
        for end in memchr_iter(self.plan.newline, bytes) {
            self.line(&bytes[start..end]);
            start = end + 1;
        }
        if start < bytes.len() {
            self.line(&bytes[start..]);
        }
    }

    /// The same where a row of plain numbers ends where its last number does: no line is looked
    /// through twice.
    fn separated_lines(&mut self, mut bytes: &[u8], separator: u8) {
        let newline = self.plan.newline;
        while !bytes.is_empty() {
            self.row += 1;
            let mut values = [0.0; SLOTS];
            let used = match self.quick_separated(bytes, separator, &mut values) {
                Some(used) => {
                    self.push(values);
                    used
                }
                None => {
                    let end = memchr(newline, bytes).unwrap_or(bytes.len());
                    self.careful(&bytes[..end]);
                    end
                }
            };
            bytes = bytes.get(used + 1..).unwrap_or_default();
        }
    }

    /// Reads whole lines on all cores and does something else meanwhile.
    #[cfg(feature = "threads")]
    pub(super) fn block<T>(&mut self, bytes: &[u8], meanwhile: impl FnOnce() -> T) -> T {
        /// Less is read before another core has begun.
        const PART: usize = 128 << 10;
        // Times that are sums depend on every row before.
        if bytes.len() < 2 * PART || matches!(self.plan.time, TimePlan::Intervals { .. }) {
            self.join();
            self.lines(bytes);
            self.settle();
            return meanwhile();
        }
        let mut parts: Vec<(Self, &[u8])> =
            parts(bytes, self.plan.newline, PART).map(|part| (self.empty(part), part)).collect();
        let done = rayon::in_place_scope(|scope| {
            for (scan, part) in &mut parts {
                scope.spawn(|_| scan.lines(part));
            }
            let done = meanwhile();
            self.join();
            done
        });
        self.parts = parts.into_iter().map(|(scan, _)| scan).collect();
        done
    }

    /// Reads whole lines, then does something else.
    #[cfg(not(feature = "threads"))]
    pub(super) fn block<T>(&mut self, bytes: &[u8], meanwhile: impl FnOnce() -> T) -> T {
        self.lines(bytes);
        self.settle();
        meanwhile()
    }

    /// A scan of the same columns with nothing in it yet, and room for what such a part holds.
    #[cfg(feature = "threads")]
    fn empty(&self, part: &[u8]) -> Self {
        let line = memchr(self.plan.newline, part).map_or(part.len(), |at| at + 1).max(2);
        Self::new(self.plan.clone(), 1, part.len() / line, Averaging::new(usize::MAX, None))
    }

    /// Puts the parts read last behind the rest.
    pub(super) fn join(&mut self) {
        for part in std::mem::take(&mut self.parts) {
            self.absorb(part);
        }
        self.settle();
    }

    /// Averages what has come, where there is more than wanted.
    fn settle(&mut self) {
        self.averaging.settle(&mut self.time_s, &mut self.signal, &mut self.quadrature);
    }

    fn absorb(&mut self, part: Self) {
        if self.backwards.is_none() {
            if let (Some(&previous), Some(&next)) = (self.time_s.last(), part.time_s.first())
                && next < previous
            {
                self.backwards = Some(Backwards { row: self.row + part.first, previous, next });
            } else {
                self.backwards = part.backwards.map(|b| Backwards { row: self.row + b.row, ..b });
            }
        }
        if self.read == 0 {
            self.first = self.row + part.first;
        }
        let mut reasons: Vec<(Reason, Count)> = part.reasons.into_iter().collect();
        reasons.sort_by_key(|(_, count)| count.order);
        for (reason, count) in reasons {
            let (first_row, order) = (self.row + count.first_row, self.reasons.len());
            self.reasons.entry(reason).and_modify(|mine| mine.rows += count.rows).or_insert(Count {
                first_row,
                order,
                ..count
            });
        }
        self.time_s.extend_from_slice(&part.time_s);
        self.signal.extend_from_slice(&part.signal);
        self.quadrature.extend_from_slice(&part.quadrature);
        self.row += part.row;
        self.read += part.read;
        self.started |= part.started;
    }

    /// What was read.
    pub(super) fn samples(mut self) -> (Samples, Averaging) {
        self.join();
        let skipped = self.skipped();
        let samples = Samples {
            time_s: self.time_s,
            signal: self.signal,
            quadrature: self.quadrature,
            read: self.read,
            backwards: self.backwards,
            skipped,
        };
        (samples, self.averaging)
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

    #[inline(always)]
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
        if self.read == 0 {
            self.first = self.row;
        }
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
    fn quick(&self, line: &[u8], values: &mut [f64; SLOTS]) -> bool {
        if self.plan.quoted {
            return false;
        }
        match (separator(self.plan.delimiter), self.plan.decimal) {
            (Some(separator), Decimal::Comma) => self.quick_comma(line, separator, values),
            (None, Decimal::Point) => self.quick_blanks(line, values),
            _ => false,
        }
    }

    /// Reads the first row of plain numbers and gives its length without its newline; `None` if
    /// anything is unusual.
    #[inline]
    fn quick_separated(&self, bytes: &[u8], separator: u8, values: &mut [f64; SLOTS]) -> Option<usize> {
        let newline = self.plan.newline;
        // A remark in an unread first cell; one that reads as a number would begin with its mark.
        if self.wanted[0].0 > 0 && dialect::is_comment(bytes) {
            return None;
        }
        let (mut rest, mut column) = (bytes, 0);
        for &(index, slot) in &self.wanted {
            while column < index {
                if rest.first() == Some(&b'"') {
                    return None;
                }
                let at = memchr2(separator, newline, rest)?;
                if rest[at] == newline {
                    return None;
                }
                rest = &rest[at + 1..];
                column += 1;
            }
            let cell = skip_blanks(rest);
            let (value, used) = fast_float2::parse_partial::<f64, _>(cell).ok()?;
            rest = skip_blanks(&cell[used..]);
            let closed = rest.first().is_none_or(|b| *b == separator || *b == newline || *b == b'\r');
            if !closed || !value.is_finite() {
                return None;
            }
            values[slot] = value;
        }
        let behind =
            if rest.first() == Some(&newline) { 0 } else { memchr(newline, rest).unwrap_or(rest.len()) };
        Some(bytes.len() - rest.len() + behind)
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

#[cfg(all(test, feature = "threads"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plan(time: TimePlan, quadrature: Option<usize>) -> Plan {
        let (delimiter, decimal) = (Delimiter::Semicolon, Decimal::Point);
        Plan { delimiter, decimal, quoted: false, newline: b'\n', time, signal: 1, quadrature }
    }

    fn line() -> impl Strategy<Value = String> {
        prop_oneof![
            8 => (0..1000_u32, -9.0..9.0_f64, -9.0..9.0_f64).prop_map(|(t, x, y)| format!("{t};{x:.4};{y:.3}")),
            1 => prop_oneof![
                Just(""), Just("# 3;4;5"), Just("3"), Just("4;;1"), Just("5;word;1"), Just("nan;1;2"),
                Just(" 6 ; 1.5 ;2\r"), Just("7;1.5"), Just("8;\"2\";3"), Just("1e3;1e999;1"), Just("\r")
            ].prop_map(str::to_owned),
        ]
    }

    proptest! {
        #[test]
        fn parts_read_apart_and_joined_are_the_whole(
            lines in prop::collection::vec(line(), 0..200),
            end in any::<bool>(),
            most in 1..600_usize,
            rate in any::<bool>(),
            quadrature in prop::option::of(Just(2_usize)),
        ) {
            let text = lines.join("\n") + if end { "\n" } else { "" };
            let stamps = TimePlan::Stamps { index: 0, seconds: Seconds::Same };
            let plan = plan(if rate { TimePlan::Rate } else { stamps }, quadrature);
            let mut whole = Scan::new(plan.clone(), 7, 0, Averaging::new(usize::MAX, None));
            whole.lines(text.as_bytes());
            let mut joined = Scan::new(plan, 7, 0, Averaging::new(usize::MAX, None));
            let pieces = parts(text.as_bytes(), b'\n', most).map(|part| {
                let mut scan = joined.empty(part);
                scan.lines(part);
                scan
            });
            joined.parts = pieces.collect();
            joined.join();
            prop_assert_eq!(joined.row, whole.row);
            // Missing values of a rate's rows are no numbers and equal to nothing.
            prop_assert_eq!(format!("{:?}", joined.samples().0), format!("{:?}", whole.samples().0));
        }
    }
}

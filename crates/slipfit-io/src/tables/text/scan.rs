//! Fast conversion of rows of text to columns of numbers.

use std::sync::Arc;

use memchr::{memchr, memchr_iter, memchr2};

use super::{
    dialect::{self, Shape, separator},
    layout::text,
    number::{self, Cell},
    part::Part,
    rewrite::Rewrite,
    sections,
    wrapped::Wrapped,
};
use crate::{
    columns::name::Name,
    report::{Decimal, Delimiter},
    tables::table::Reason,
};

/// Parts of each row to be read.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    delimiter: Delimiter,
    decimal: Decimal,
    /// Whether cells are quoted and may therefore contain separators.
    quoted: bool,
    /// Byte between two lines.
    newline: u8,
    /// The day from whose midnight dates are counted, itself counted from 1970.
    pub(super) day: i64,
    /// How lines are rewritten if they are not rows of plain numbers.
    pub(super) rewrite: Option<Arc<Rewrite>>,
    /// The columns, if another header among the rows begins another table.
    pub(super) names: Option<Arc<[Name]>>,
    /// Whether lines that begin with a word are headers of blocks among the rows.
    pub(super) block_headers: bool,
    /// How the values of one signal are distributed over several columns.
    pub(super) wrapped: Option<Wrapped>,
    /// The requested columns in ascending order, with their positions in the result.
    wanted: Vec<(usize, usize)>,
}

/// Splits whole lines into parts of about `most` bytes.
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

impl Plan {
    pub(super) fn new(shape: Shape, quoted: bool, newline: u8, wanted: &[usize]) -> Self {
        let mut wanted: Vec<(usize, usize)> = wanted.iter().copied().zip(0..).collect();
        wanted.sort_unstable();
        Self {
            delimiter: shape.delimiter,
            decimal: shape.decimal,
            quoted,
            newline,
            day: 0,
            rewrite: None,
            names: None,
            block_headers: false,
            wrapped: None,
            wanted,
        }
    }

    /// Reads whole lines, of which the last may lack its end, on all cores, and runs `meanwhile` at the same time.
    #[cfg(feature = "threads")]
    pub(super) fn read<T>(&self, bytes: &[u8], meanwhile: impl FnOnce() -> T) -> (Vec<Part>, T) {
        /// Smaller parts are read before another core has started.
        const PART: usize = 128 << 10;
        if bytes.len() < 2 * PART {
            return (vec![self.part(bytes)], meanwhile());
        }
        let mut list: Vec<(Part, &[u8])> =
            parts(bytes, self.newline, PART).map(|bytes| (Part::default(), bytes)).collect();
        let done = rayon::in_place_scope(|scope| {
            for (part, bytes) in &mut list {
                scope.spawn(|_| *part = self.part(bytes));
            }
            meanwhile()
        });
        (list.into_iter().map(|(part, _)| part).collect(), done)
    }

    /// Reads whole lines, of which the last may lack its end, then runs `meanwhile`.
    #[cfg(not(feature = "threads"))]
    pub(super) fn read<T>(&self, bytes: &[u8], meanwhile: impl FnOnce() -> T) -> (Vec<Part>, T) {
        (vec![self.part(bytes)], meanwhile())
    }

    /// Reads whole lines, of which the last may lack its end.
    pub(super) fn part(&self, bytes: &[u8]) -> Part {
        let part = match &self.rewrite {
            Some(rewrite) => self.plain_part(&rewrite.rows(bytes, self.newline)),
            None => self.plain_part(bytes),
        };
        match self.wrapped {
            Some(wrapped) => wrapped.joined(part),
            None => part,
        }
    }

    /// The same for cells that contain only numbers.
    fn plain_part(&self, bytes: &[u8]) -> Part {
        // A cell takes at least two bytes.
        let line = memchr(self.newline, bytes).map_or(bytes.len(), |at| at + 1).max(2 * self.wanted.len());
        let columns = vec![Vec::with_capacity(bytes.len() / line); self.wanted.len()];
        let mut part = Part { columns, ..Part::default() };
        let mut values = vec![f64::NAN; self.wanted.len()];
        if let (Some(separator), Decimal::Point, false) =
            (separator(self.delimiter), self.decimal, self.quoted)
        {
            self.separated_lines(bytes, separator, &mut values, &mut part);
            return part;
        }
        let mut start = 0;
        let last = bytes.last().is_some_and(|b| *b != self.newline).then_some(bytes.len());
        for end in memchr_iter(self.newline, bytes).chain(last) {
            let line = &bytes[start..end];
            if self.quick(line, &mut values) {
                part.push(&values);
            } else {
                self.careful(line, &mut values, &mut part);
            }
            start = end + 1;
        }
        part
    }

    /// The same if a row of plain numbers ends directly after its last number: no line is scanned twice.
    fn separated_lines(&self, mut bytes: &[u8], separator: u8, values: &mut [f64], part: &mut Part) {
        while !bytes.is_empty() {
            let used = match self.quick_separated(bytes, separator, values) {
                Some(used) => {
                    part.push(values);
                    used
                }
                None => {
                    let end = memchr(self.newline, bytes).unwrap_or(bytes.len());
                    self.careful(&bytes[..end], values, part);
                    end
                }
            };
            bytes = bytes.get(used + 1..).unwrap_or_default();
        }
    }

    /// Reads a row of plain numbers; `false` if anything is unusual.
    fn quick(&self, line: &[u8], values: &mut [f64]) -> bool {
        if self.quoted {
            return false;
        }
        match (separator(self.delimiter), self.decimal) {
            (Some(separator), Decimal::Comma) => self.quick_comma(line, separator, values),
            (None, Decimal::Point) => self.quick_blanks(line, values),
            _ => false,
        }
    }

    /// Reads the first row of plain numbers and returns its length without the newline; `None` if anything is unusual.
    #[inline]
    fn quick_separated(&self, bytes: &[u8], separator: u8, values: &mut [f64]) -> Option<usize> {
        let newline = self.newline;
        // A remark in a first cell that is not read; in a cell that is read, its mark would not be a number.
        if self.wanted[0].0 > 0 && self.is_not_a_row(bytes) {
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

    /// Whether a line whose first cell is not read is not a row: a remark, or a line of a block header.
    fn is_not_a_row(&self, line: &[u8]) -> bool {
        let word = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'*';
        dialect::is_comment(line) || self.block_headers && line.trim_ascii_start().first().is_some_and(word)
    }

    fn quick_comma(&self, line: &[u8], separator: u8, values: &mut [f64]) -> bool {
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
        self.wanted[0].0 == 0 || !self.is_not_a_row(line)
    }

    fn quick_blanks(&self, line: &[u8], values: &mut [f64]) -> bool {
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
        let whole = self.delimiter != Delimiter::None || rest.trim_ascii().is_empty();
        whole && (self.wanted[0].0 == 0 || !self.is_not_a_row(line))
    }

    /// Reads any row, or notes why it could not be read.
    #[cold]
    fn careful(&self, line: &[u8], values: &mut [f64], part: &mut Part) {
        if line.trim_ascii().is_empty() {
            part.lines += 1;
            return part.note(Reason::BlankLine);
        }
        if dialect::is_comment(line) {
            part.lines += 1;
            return part.note(Reason::Remark);
        }
        let cells = dialect::cells(line, self.delimiter);
        if self.block_headers && number::cell(cells[0], self.decimal) == Cell::Text {
            part.lines += 1;
            return part.note(Reason::BlockHeader);
        }
        let mut missing = None;
        for &(index, place) in &self.wanted {
            let column = index + 1;
            values[place] = f64::NAN;
            let reason =
                match cells.get(index).map(|cell| (cell, number::cell_since(cell, self.decimal, self.day))) {
                    Some((_, Cell::Number(value))) => {
                        values[place] = value;
                        continue;
                    }
                    Some((_, Cell::Missing)) => Reason::NoValue(column),
                    Some((cell, Cell::Text)) if missing.is_none() => Reason::Text(column, example(cell)),
                    Some((_, Cell::Text)) => continue,
                    None => Reason::TooFewCells(column),
                };
            missing = missing.or(Some(reason));
        }
        if matches!(missing, Some(Reason::Text(..))) && self.is_other_header(line) {
            missing = Some(Reason::OtherHeader);
        }
        if let Some(reason) = missing {
            part.note(reason);
        }
        part.push(values);
    }

    /// Whether a line among the rows begins another table.
    fn is_other_header(&self, line: &[u8]) -> bool {
        self.names.as_ref().is_some_and(|names| {
            let shape =
                Shape { delimiter: self.delimiter, decimal: self.decimal, width: names.len(), words: false };
            sections::is_other_header(line, shape, names)
        })
    }
}

/// The beginning of a cell that is not a number.
fn example(cell: &[u8]) -> String {
    const LONGEST: usize = 24;
    let text = text(number::trim(cell));
    let mut example: String = text.chars().take(LONGEST).filter(|c| !c.is_control()).collect();
    if text.chars().count() > LONGEST {
        example.push('…');
    }
    example
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
    use crate::tables::table::Irregularity;
    use proptest::prelude::*;

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
            quadrature in prop::option::of(Just(2_usize)),
        ) {
            let text = lines.join("\n") + if end { "\n" } else { "" };
            let (delimiter, decimal) = (Delimiter::Semicolon, Decimal::Point);
            let shape = Shape { delimiter, decimal, width: 3, words: false };
            let wanted: Vec<usize> = [1, 0].into_iter().chain(quadrature).collect();
            let plan = Plan::new(shape, false, b'\n', &wanted);
            let whole = plan.part(text.as_bytes());
            let mut joined = Part { columns: vec![Vec::new(); wanted.len()], ..Part::default() };
            for part in parts(text.as_bytes(), b'\n', most).map(|bytes| plan.part(bytes)) {
                let before = joined.columns[0].len();
                let moved = |it: Irregularity| Irregularity { row: it.row + before, ..it };
                joined.irregularities.extend(part.irregularities.into_iter().map(moved));
                joined.columns.iter_mut().zip(part.columns).for_each(|(all, new)| all.extend(new));
                joined.lines += part.lines;
            }
            // Missing values are NaN, which is not equal to itself.
            prop_assert_eq!(format!("{joined:?}"), format!("{whole:?}"));
        }
    }
}

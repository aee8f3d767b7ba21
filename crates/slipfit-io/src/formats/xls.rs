//! Old Excel workbooks (.xls): the records of a BIFF8 stream in an OLE file.

use std::io::{Cursor, Read as _};

use crate::{
    error::ReadProblem,
    format::Format,
    tables::sheet::{self, Cell, Sheet},
    tables::table::LoadedTables,
};

// Record numbers of [MS-XLS] 2.3.
const FORMULA: u16 = 0x0006;
const EOF: u16 = 0x000a;
const CONTINUE: u16 = 0x003c;
const BOUND_SHEET: u16 = 0x0085;
const MUL_RK: u16 = 0x00bd;
const RK: u16 = 0x027e;
const SST: u16 = 0x00fc;
const LABEL_SST: u16 = 0x00fd;
const NUMBER: u16 = 0x0203;
const LABEL: u16 = 0x0204;
const BOF: u16 = 0x0809;

/// Reads every sheet.
pub(crate) fn tables(bytes: Vec<u8>) -> Result<LoadedTables, ReadProblem> {
    let size = bytes.len() as u64;
    let mut file = cfb::CompoundFile::open(Cursor::new(bytes)).map_err(|e| Format::Xls.broken(e))?;
    let name = ["/Workbook", "/Book"].into_iter().find(|n| file.is_stream(n));
    let name = name.ok_or_else(|| {
        Format::Xls.broken("no workbook is in it; other OLE files (.doc, .opj) are no tables")
    })?;
    let stream = file.open_stream(name).map_err(|e| Format::Xls.broken(e))?;
    let mut book = Vec::new();
    // The length stated by the stream is not trusted: it cannot exceed that of the file.
    stream.take(size).read_to_end(&mut book).map_err(|e| Format::Xls.broken(e))?;
    let records = Records { rest: &book };
    let mut bounds: Vec<(usize, String)> = Vec::new();
    let mut strings = Vec::new();
    let mut globals = records.peekable();
    while let Some((kind, data)) = globals.next() {
        match kind {
            BOUND_SHEET => bounds.extend(bound(data)),
            SST => {
                let mut parts = vec![data];
                while let Some((_, more)) = globals.next_if(|(kind, _)| *kind == CONTINUE) {
                    parts.push(more);
                }
                strings = Strings { parts, part: 0, at: 0 }.all();
            }
            EOF => break,
            _ => {}
        }
    }
    let sheets: Vec<Sheet> =
        bounds.iter().filter_map(|(at, name)| Some(sheet(book.get(*at..)?, name, &strings))).collect();
    sheet::tables(&sheets).map_err(|e| Format::Xls.broken(e))
}

/// The successive records of a stream.
struct Records<'a> {
    rest: &'a [u8],
}

impl<'a> Iterator for Records<'a> {
    type Item = (u16, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let kind = u16_at(self.rest, 0)?;
        let length = usize::from(u16_at(self.rest, 2)?);
        let data = self.rest.get(4..4 + length)?;
        self.rest = &self.rest[4 + length..];
        Some((kind, data))
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn f64_at(bytes: &[u8], at: usize) -> Option<f64> {
    Some(f64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}

/// Offset and name of a sheet; `None` for charts and macros.
fn bound(data: &[u8]) -> Option<(usize, String)> {
    let at = u32_at(data, 0)? as usize;
    let (kind, length) = (*data.get(5)?, usize::from(*data.get(6)?));
    let wide = data.get(7)? & 1 == 1;
    let name = characters(data.get(8..)?, length, wide);
    (kind == 0).then_some((at, name))
}

/// Text of `count` characters, of one byte (Latin-1) or two.
fn characters(bytes: &[u8], count: usize, wide: bool) -> String {
    if wide {
        let words = bytes.chunks_exact(2).take(count).map(|c| u16::from_le_bytes([c[0], c[1]]));
        char::decode_utf16(words).map(|c| c.unwrap_or('\u{fffd}')).collect()
    } else {
        bytes.iter().take(count).map(|b| char::from(*b)).collect()
    }
}

/// The cells from a sheet's first record to its last.
fn sheet(bytes: &[u8], name: &str, strings: &[String]) -> Sheet {
    let mut sheet = Sheet::new(name);
    let mut depth = 0;
    for (kind, data) in (Records { rest: bytes }) {
        match kind {
            // A chart in a sheet has its own records.
            BOF => depth += 1,
            EOF if depth <= 1 => break,
            EOF => depth -= 1,
            _ if depth == 1 => {
                let _ = cells(&mut sheet, kind, data, strings);
            }
            _ => {}
        }
    }
    sheet
}

/// The cells of one record. `None` if it ends too early.
fn cells(sheet: &mut Sheet, kind: u16, data: &[u8], strings: &[String]) -> Option<()> {
    let (row, column) = (u32::from(u16_at(data, 0)?), u32::from(u16_at(data, 2)?));
    let mut number = |column, value: f64| {
        if value.is_finite() {
            sheet.set(row, column, Cell::Number(value));
        }
    };
    match kind {
        NUMBER => number(column, f64_at(data, 6)?),
        RK => number(column, rk(u32_at(data, 6)?)),
        MUL_RK => {
            for (i, pair) in data.get(4..data.len().checked_sub(2)?)?.chunks_exact(6).enumerate() {
                number(column + i as u32, rk(u32_at(pair, 2)?));
            }
        }
        // The last result; text and errors have ones in the last two bytes.
        FORMULA if u16_at(data, 12)? != 0xffff => number(column, f64_at(data, 6)?),
        LABEL_SST => {
            let text = strings.get(u32_at(data, 6)? as usize)?;
            sheet.set(row, column, Cell::Text(text.clone()));
        }
        LABEL => {
            let (length, wide) = (usize::from(u16_at(data, 6)?), data.get(8)? & 1 == 1);
            sheet.set(row, column, Cell::Text(characters(data.get(9..)?, length, wide)));
        }
        _ => {}
    }
    Some(())
}

/// A number in four bytes: the upper part of a float or an integer, possibly in hundredths.
fn rk(word: u32) -> f64 {
    let value =
        if word & 2 == 0 { f64::from_bits(u64::from(word & !3) << 32) } else { f64::from(word as i32 >> 2) };
    if word & 1 == 0 { value } else { value / 100.0 }
}

/// The table of strings: records that continue each other, even within a string.
struct Strings<'a> {
    parts: Vec<&'a [u8]>,
    part: usize,
    at: usize,
}

impl Strings<'_> {
    fn all(mut self) -> Vec<String> {
        let count = u32_at(self.parts[0], 4).unwrap_or(0) as usize;
        self.at = 8;
        // Each string takes at least three bytes: the count alone is not trusted.
        let bytes: usize = self.parts.iter().map(|p| p.len()).sum();
        (0..count.min(bytes / 3)).map_while(|_| self.string()).collect()
    }

    fn byte(&mut self) -> Option<u8> {
        while self.at >= self.parts.get(self.part)?.len() {
            (self.part, self.at) = (self.part + 1, 0);
        }
        self.at += 1;
        self.parts[self.part].get(self.at - 1).copied()
    }

    fn word(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes([self.byte()?, self.byte()?]))
    }

    fn string(&mut self) -> Option<String> {
        let count = usize::from(self.word()?);
        let flags = self.byte()?;
        let runs = if flags & 8 != 0 { usize::from(self.word()?) } else { 0 };
        let phonetic =
            if flags & 4 != 0 { usize::from(self.word()?) | usize::from(self.word()?) << 16 } else { 0 };
        let mut wide = flags & 1 == 1;
        let mut words = Vec::new();
        for _ in 0..count {
            if self.at >= self.parts.get(self.part)?.len() {
                // The continuation of a string states the width of its characters again.
                (self.part, self.at) = (self.part + 1, 0);
                wide = self.byte()? & 1 == 1;
            }
            words.push(if wide { self.word()? } else { u16::from(self.byte()?) });
        }
        for _ in 0..(4 * runs).saturating_add(phonetic) {
            self.byte()?;
        }
        Some(String::from_utf16_lossy(&words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_are_floats_or_integers_or_hundredths() {
        // Examples of [MS-XLS] 2.5.217.
        for (word, value) in
            [(0x3ff0_0000, 1.0), (0x3ff0_0001, 0.01), (0x0000_0fa6, 1001.0), (0x0000_00f7, 0.61)]
        {
            assert_eq!(rk(word), value, "{word:#x}");
        }
        assert_eq!(rk((-5_i32 << 2) as u32 | 2), -5.0);
    }
}

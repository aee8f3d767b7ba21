//! MATLAB level 5 files: arrays, structs and cells, packed or not.

use std::io::Read as _;

use crate::{
    error::ReadProblem,
    format::Format,
    tables::arrays::{self, Array, NamedValues},
    tables::binary::{Kind, Stored},
    tables::table::HeldTables,
};

/// Structs in structs in cells, at most.
const DEEPEST: usize = 16;
/// Arrays kept at most: a struct array of thousands of elements is no record.
const MOST_ARRAYS: usize = 4096;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Bytes of a file in its byte order, read from the front.
#[derive(Clone, Copy)]
struct Bytes<'a> {
    rest: &'a [u8],
    big: bool,
}

/// A piece of data and what it is.
struct Element<'a> {
    kind: u32,
    data: Bytes<'a>,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(n)?;
        self.rest = rest;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        let bytes: [u8; 4] = self.take(4)?.try_into().ok()?;
        Some(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The next element; what is cut off at the end is given as far as it goes.
    fn element(&mut self) -> Option<Element<'a>> {
        let big = self.big;
        let word = self.u32()?;
        if word >> 16 != 0 {
            // Up to four bytes stand in the tag itself.
            let data = self.take(4)?;
            let length = (word >> 16) as usize;
            return Some(Element { kind: word & 0xffff, data: Bytes { rest: data.get(..length)?, big } });
        }
        let length = self.u32()? as usize;
        let data = self.take(length.min(self.rest.len()))?;
        if word != COMPRESSED {
            let padding = (8 - length % 8) % 8;
            self.take(padding.min(self.rest.len()));
        }
        Some(Element { kind: word, data: Bytes { rest: data, big } })
    }
}

impl Element<'_> {
    /// Numbers of any storage type; those cut off are missing at the end.
    fn numbers(&self) -> Option<Vec<f64>> {
        let (kind, bytes) = match self.kind {
            1 => (Kind::Signed, 1),
            2 => (Kind::Unsigned, 1),
            3 => (Kind::Signed, 2),
            4 => (Kind::Unsigned, 2),
            5 => (Kind::Signed, 4),
            6 => (Kind::Unsigned, 4),
            7 => (Kind::Float, 4),
            9 => (Kind::Float, 8),
            12 => (Kind::Signed, 8),
            13 => (Kind::Unsigned, 8),
            _ => return None,
        };
        Some(Stored { kind, bytes, big_endian: self.data.big }.all(self.data.rest))
    }

    /// Text of any storage type.
    fn text(&self) -> Option<String> {
        let bytes = self.data.rest;
        match self.kind {
            1 | 2 | 16 => Some(String::from_utf8_lossy(bytes).into_owned()),
            4 | 17 => {
                let word = |c: &[u8]| {
                    if self.data.big {
                        u16::from_be_bytes([c[0], c[1]])
                    } else {
                        u16::from_le_bytes([c[0], c[1]])
                    }
                };
                Some(
                    char::decode_utf16(bytes.chunks_exact(2).map(word))
                        .map(|c| c.unwrap_or('\u{fffd}'))
                        .collect(),
                )
            }
            _ => None,
        }
    }
}

/// What has been found so far.
#[derive(Default)]
struct Found {
    arrays: Vec<Array>,
    named: NamedValues,
    notes: Vec<String>,
    /// Arrays left aside because there are too many.
    left: usize,
}

/// Reads all variables.
pub(crate) fn tables(bytes: &[u8]) -> Result<HeldTables, ReadProblem> {
    let big = match bytes.get(126..128) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(Format::Mat5.broken("its header does not end with the byte order")),
    };
    let mut rest = Bytes { rest: &bytes[128..], big };
    let mut found = Found::default();
    while !rest.rest.is_empty() {
        let whole = rest.rest.len();
        let Some(element) = rest.element() else {
            found.notes.push(format!("the file ends within a variable: {whole} bytes were not read"));
            break;
        };
        match element.kind {
            COMPRESSED => {
                let mut plain = Vec::new();
                let unpacked = flate2::read::ZlibDecoder::new(element.data.rest).read_to_end(&mut plain);
                if let Err(error) = unpacked {
                    found.notes.push(format!("a packed variable ends early: {error}"));
                }
                let mut inner = Bytes { rest: &plain, big };
                if let Some(inner) = inner.element().filter(|e| e.kind == MATRIX) {
                    found.matrix(inner.data, "", None, 0);
                }
            }
            MATRIX => {
                found.matrix(element.data, "", None, 0);
            }
            _ => {}
        }
    }
    let mut tables = arrays::tables(found.arrays, &found.named);
    if tables.is_empty() {
        let cut = found.notes.first().map(|n| format!("; {n}")).unwrap_or_default();
        return Err(Format::Mat5.broken(format!("it holds no array of numbers with more than one row{cut}")));
    }
    if found.left > 0 {
        found.notes.push(format!("{} further arrays were left aside", found.left));
    }
    tables.note_all(&found.notes);
    Ok(tables)
}

impl Found {
    /// Reads a matrix; `given` names it where its place does.
    fn matrix(
        &mut self,
        mut bytes: Bytes<'_>,
        parent: &str,
        given: Option<&str>,
        depth: usize,
    ) -> Option<()> {
        if bytes.rest.is_empty() || depth > DEEPEST {
            return None;
        }
        let mut flags = bytes.element()?.data;
        let flags = flags.u32()?;
        let dims: Vec<usize> = bytes.element()?.numbers()?.into_iter().map(|d| d.max(0.0) as usize).collect();
        let own = bytes.element()?.text()?;
        let name = given.unwrap_or(&own);
        let path = if parent.is_empty() { name.to_owned() } else { format!("{parent}.{name}") };
        let count = dims.iter().try_fold(1_usize, |n, d| n.checked_mul(*d))?;
        match flags & 0xff {
            1 => {
                for i in 1..=count {
                    let element = bytes.element().filter(|e| e.kind == MATRIX)?;
                    self.matrix(element.data, parent, Some(&format!("{name}{{{i}}}")), depth + 1);
                }
            }
            class @ (2 | 3) => {
                if class == 3 {
                    bytes.element()?;
                }
                let width = bytes.element()?.numbers()?.first().copied()? as usize;
                let names = bytes.element()?.text()?;
                let names: Vec<&str> = match names.is_ascii() && width > 0 {
                    true => {
                        names.as_bytes().chunks(width).filter_map(|c| std::str::from_utf8(c).ok()).collect()
                    }
                    false => return None,
                };
                for i in 1..=count {
                    let place = if count == 1 { path.clone() } else { format!("{path}({i})") };
                    for field in &names {
                        let element = bytes.element().filter(|e| e.kind == MATRIX)?;
                        let field = field.trim_end_matches('\0');
                        self.matrix(element.data, &place, Some(field), depth + 1);
                    }
                }
            }
            4 => {
                let text = bytes.element()?.text()?;
                if dims.first() == Some(&1) {
                    self.named.push((parent.to_owned(), name.to_owned(), text.trim().to_owned()));
                }
            }
            6..=15 => {
                let mut values = bytes.element()?.numbers()?;
                if let ([value], 1) = (&values[..], count) {
                    self.named.push((parent.to_owned(), name.to_owned(), value.to_string()));
                    return Some(());
                }
                if values.len() < count && !values.is_empty() {
                    // Cut off: as far as a column goes, where it is one.
                    if dims.iter().filter(|d| **d != 1).count() != 1 {
                        return None;
                    }
                    self.notes.push(format!("`{path}` ends after {} of {count} values", values.len()));
                    let length = values.len();
                    self.keep(Array::new(parent, name, &[length], values, true));
                    return Some(());
                }
                values.truncate(count);
                self.keep(Array::new(parent, name, &dims, values, true));
                if flags & 0x800 != 0 {
                    let mut imaginary = bytes.element()?.numbers()?;
                    imaginary.truncate(count);
                    self.keep(Array::new(parent, &format!("{name} imaginary"), &dims, imaginary, true));
                }
            }
            _ => {}
        }
        Some(())
    }

    fn keep(&mut self, array: Option<Array>) {
        let Some(array) = array else { return };
        if self.arrays.len() < MOST_ARRAYS {
            self.arrays.push(array);
        } else {
            self.left += 1;
        }
    }
}

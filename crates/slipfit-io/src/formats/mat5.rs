//! MATLAB level 5 files: arrays, structs and cells, compressed or not.

use std::io::Read as _;

use crate::tables::unpack::BUDGET;

use crate::{
    error::ReadProblem,
    format::Format,
    tables::arrays::{self, Array, NamedValues},
    tables::binary::{Kind, Stored},
    tables::table::LoadedTables,
};

/// Maximum depth of nested structs and cells.
const DEEPEST: usize = 16;
/// Maximum number of arrays kept: a struct array of thousands of elements is not a record.
const MOST_ARRAYS: usize = 4096;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Bytes of a file in its byte order, read from the front.
#[derive(Clone, Copy)]
struct Bytes<'a> {
    rest: &'a [u8],
    big: bool,
}

/// An element of data and its type.
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

    /// The next element; an element truncated at the end is returned as far as it goes.
    fn element(&mut self) -> Option<Element<'a>> {
        let big = self.big;
        let word = self.u32()?;
        if word >> 16 != 0 {
            // Up to four bytes are stored in the tag itself.
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
    /// Numbers of any storage type; truncated ones are missing at the end.
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

/// Results so far.
#[derive(Default)]
struct Found {
    arrays: Vec<Array>,
    named: NamedValues,
    notes: Vec<String>,
    /// Number of arrays omitted because there are too many.
    left: usize,
}

/// Reads all variables.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
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
                let unpacked = flate2::read::ZlibDecoder::new(element.data.rest);
                if let Err(error) = unpacked.take(BUDGET as u64).read_to_end(&mut plain) {
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
    found.join_signals();
    let mut tables = arrays::tables(found.arrays, &found.named);
    if tables.is_empty() {
        let cut = found.notes.first().map(|n| format!("; {n}")).unwrap_or_default();
        return Err(Format::Mat5.broken(format!("it holds no array of numbers with more than one row{cut}")));
    }
    if found.left > 0 {
        found.notes.push(format!("{} further arrays were not read", found.left));
    }
    tables.note_all(&found.notes);
    Ok(tables)
}

impl Found {
    /// Reads a matrix; `given` is its name if its place determines it.
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
                // Without fields, any number of structures takes no bytes.
                let count = if names.is_empty() { 0 } else { count };
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
                    // Truncated: the values present are kept if the array is a single column.
                    if dims.iter().filter(|d| **d != 1).count() != 1 {
                        return None;
                    }
                    self.notes.push(format!("`{path}` ends after {} of {count} values", values.len()));
                    let length = values.len();
                    self.keep(Array::new(parent, name, &[length], values, true));
                    return Some(());
                }
                values.truncate(count);
                if flags & 0x800 == 0 {
                    self.keep(Array::new(parent, name, &dims, values, true));
                    return Some(());
                }
                let [real, imaginary] = arrays::parts(name);
                self.keep(Array::new(parent, &real, &dims, values, true));
                let mut values = bytes.element()?.numbers()?;
                values.truncate(count);
                self.keep(Array::new(parent, &imaginary, &dims, values, true));
            }
            _ => {}
        }
        Some(())
    }

    /// Simulink's structures with time store each signal in a separate structure: `time`, `signals(k).values` and its
    /// `label`. They are joined with their times.
    fn join_signals(&mut self) {
        let is_time = |a: &&Array| a.name == "time" && a.columns.len() == 1;
        let timed: Vec<(String, usize)> =
            self.arrays.iter().filter(is_time).map(|a| (a.parent.clone(), a.rows())).collect();
        for array in self.arrays.iter_mut().filter(|a| a.name == "values") {
            let Some((parent, signal)) = array.parent.rsplit_once('.') else { continue };
            if !signal.starts_with("signals") || !timed.contains(&(parent.to_owned(), array.rows())) {
                continue;
            }
            let label = self.named.iter().find(|(place, name, _)| *place == array.parent && name == "label");
            let label = label.map(|(.., text)| text.trim_matches(['<', '>', ' '])).filter(|l| !l.is_empty());
            let unnamed = || signal.replacen("signals", "values", 1);
            let (name, parent) = (label.map_or_else(unnamed, str::to_owned), parent.to_owned());
            (array.name, array.parent) = (name, parent);
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, read_from, report::TimeSource};

    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend_from_slice(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn matrix(class: u8, dims: [i32; 2], name: &str, rest: &[Vec<u8>]) -> Vec<u8> {
        let dims = [dims[0].to_le_bytes(), dims[1].to_le_bytes()].concat();
        let parts =
            [element(6, &[class, 0, 0, 0, 0, 0, 0, 0]), element(5, &dims), element(1, name.as_bytes())];
        element(MATRIX, &[parts.concat(), rest.concat()].concat())
    }

    fn numbers(name: &str, values: &[f64]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        matrix(6, [values.len() as i32, 1], name, &[element(9, &bytes)])
    }

    fn text(name: &str, text: &str) -> Vec<u8> {
        matrix(4, [1, text.len() as i32], name, &[element(16, text.as_bytes())])
    }

    /// A structure array with its fields, element by element.
    fn structs(name: &str, count: i32, fields: &[&str], values: &[Vec<u8>]) -> Vec<u8> {
        let mut names = Vec::new();
        for field in fields {
            names.extend_from_slice(field.as_bytes());
            names.resize(names.len().next_multiple_of(32), 0);
        }
        let head = [element(5, &32_i32.to_le_bytes()), element(1, &names)];
        matrix(2, [1, count], name, &[head.concat(), values.concat()])
    }

    fn file(variables: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
        bytes.resize(124, b' ');
        bytes.extend_from_slice(b"\0\x01IM");
        bytes.extend(variables.concat());
        bytes
    }

    fn ring(n: usize, interval_s: f64) -> Vec<f64> {
        let at = |i: usize| interval_s * i as f64;
        (0..n).map(|i| (-0.2 * at(i)).exp() * (6.0 * at(i)).cos()).collect()
    }

    #[test]
    fn a_rate_named_in_the_file_stands_for_missing_times() {
        for (name, value) in
            [("ActualRate", 50.0), ("fs", 50.0), ("fs_Hz", 50.0), ("dt", 0.02), ("SampleRate", 50.0)]
        {
            let bytes = file(&[numbers(name, &[value]), numbers("data", &ring(500, 0.02))]);
            let reading = read_from(&bytes[..], "gyro.mat", &ReadOptions::default()).unwrap();
            let Some(TimeSource::Rate(rate)) = reading.report.time else {
                panic!("{:?}", reading.report.time)
            };
            assert!((rate - 50.0).abs() < 1e-9, "{name}: {rate}");
            assert!(reading.report.notes.iter().any(|n| n.text.contains("rate that the file names")));
        }
        let bytes = file(&[numbers("gain", &[50.0]), numbers("data", &ring(500, 0.02))]);
        assert!(read_from(&bytes[..], "gyro.mat", &ReadOptions::default()).is_err());
    }

    #[test]
    fn signals_of_a_structure_with_time_stand_beside_their_times() {
        let times: Vec<f64> = (0..500).map(|i| 0.02 * f64::from(i)).collect();
        let fields = ["values", "label"];
        let driven: Vec<f64> = times.iter().map(|t| if *t < 5.0 { 1.0 } else { 0.0 }).collect();
        let signals =
            [numbers("", &driven), text("", "motor"), numbers("", &ring(500, 0.02)), text("", "<pendulum>")];
        let run = structs(
            "run",
            1,
            &["time", "signals"],
            &[numbers("", &times), structs("", 2, &fields, &signals)],
        );
        let bytes = file(&[run]);
        let reading = read_from(&bytes[..], "simulink.mat", &ReadOptions::default()).unwrap();
        assert_eq!(
            reading.report.columns.iter().map(|c| &c.header[..]).collect::<Vec<_>>(),
            ["time", "motor", "pendulum"]
        );
        assert_eq!(reading.report.column("signal").unwrap().column.number, 3);
        assert!((reading.record.duration_s() - 9.98).abs() < 1e-9);
    }
}

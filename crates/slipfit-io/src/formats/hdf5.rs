//! HDF5 files, including MATLAB 7.3.

use std::ops::Range;
use std::path::Path;

use hdf5_reader::{
    ByteOrder, Dataset, Datatype, FilterRegistry, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem,
    error::Error, group::Group,
};

use crate::{
    error::ReadProblem,
    format::Format,
    tables::arrays::{self, Array, NamedValues},
    tables::binary::{Kind, Stored},
    tables::guard,
    tables::known::{Known, not_found},
    tables::table::LoadedTables,
};

/// Maximum depth of nested groups; links can form cycles.
const DEEPEST: usize = 12;
/// Maximum number of values in one field of one row.
const MOST_MEMBERS: u64 = 256;
/// Maximum number of data sets read.
const MOST_SETS: usize = 2048;
/// Maximum expansion factor: deflate encodes 258 repeated bytes by two bits.
const MOST_EXPANSION: usize = 1032;
/// The identifier under which h5py registered its filter LZF.
const LZF: u16 = 32000;

/// Reading limits for a file of this size, and the maximum number of bytes they allow.
fn limits(bytes: usize) -> (OpenOptions, usize) {
    let most = guard::budget(bytes, MOST_EXPANSION);
    let mut filters = FilterRegistry::new();
    let broken = || Error::InvalidData("an LZF chunk points outside of itself".into());
    filters.register(LZF, Box::new(move |_, packed, _| unpacked_lzf(packed).ok_or_else(broken)));
    let options = OpenOptions { filter_registry: Some(filters), ..OpenOptions::default() }
        .with_max_read_bytes(most)
        .with_max_chunk_bytes(most)
        .with_max_object_header_bytes(bytes);
    (options, most)
}

/// Reads all data sets of one or two dimensions.
pub(crate) fn tables(bytes: Vec<u8>) -> Result<LoadedTables, ReadProblem> {
    let (options, most) = limits(bytes.len());
    let mut found = Found { left: most, ..Found::default() };
    let decode = || {
        let file = Hdf5File::from_vec_with_options(bytes, options)?;
        found.group(&file.root_group()?, "", 0);
        Ok(())
    };
    guard::guarded(Format::Hdf5, decode, |e: Error| Format::Hdf5.broken(e))?;
    if found.arrays.is_empty() {
        return Err(Format::Hdf5
            .broken(format!("no data set in it holds rows of numbers; {}", found.notes.join("; "))));
    }
    let mut tables = arrays::tables(found.arrays, &found.named);
    tables.note_all(&found.notes);
    Ok(tables)
}

/// A data set of three dimensions in an open file.
pub(crate) struct Cube {
    set: Dataset,
    kind: Stored,
}

/// Shape, unit and numbers of the three-dimensional data set called `name`, or of the only one.
pub(crate) fn cube(path: &Path, name: Option<&str>) -> Result<([usize; 3], String, Cube), ReadProblem> {
    let open = || {
        let bytes = std::fs::metadata(path).map_or(0, |m| usize::try_from(m.len()).unwrap_or(usize::MAX));
        let file = Hdf5File::open_with_options(path, limits(bytes).0)?;
        let mut sets = Vec::new();
        let named = name.map(|name| (name, file.dataset(name)));
        if let Some((name, Ok(set))) = named {
            return Ok((vec![(name.to_owned(), set)], Vec::new()));
        }
        all_sets(&file.root_group()?, "", &mut Vec::new(), &mut sets);
        let known = sets.iter().map(|(path, set)| Known { path: path.clone(), shape: set.shape().to_vec() });
        let known: Vec<Known> = known.collect();
        // A leading slash may be omitted.
        let is_there =
            |name: &str| known.iter().any(|one| one.path.trim_matches('/') == name.trim_matches('/'));
        match named {
            Some((name, Err(broken))) if is_there(name) => Err(broken),
            Some(_) => Ok((Vec::new(), known)),
            None => Ok((sets.into_iter().filter(|(_, set)| set.shape().len() == 3).collect(), known)),
        }
    };
    let (mut sets, known) = guard::guarded(Format::Hdf5, open, |e: Error| Format::Hdf5.broken(e))?;
    let refused = |reason: String| ReadProblem::NoStack { reason };
    let Some((name, set)) = sets.pop() else {
        return Err(refused(not_found("data set", name, &known)));
    };
    if !sets.is_empty() {
        let names: Vec<String> = sets.iter().map(|(name, _)| name.clone()).chain([name]).collect();
        return Err(refused(format!("{} have three axes each, name one of them", names.join(", "))));
    }
    let kind = stored(set.dtype()).ok_or_else(|| refused(format!("{name} holds no real numbers")))?;
    let mut shape = [0; 3];
    if set.shape().len() != 3 {
        return Err(refused(format!("{name} has the shape {:?}, three axes are needed", set.shape())));
    }
    for (length, found) in shape.iter_mut().zip(set.shape()) {
        *length = usize::try_from(*found).unwrap_or(usize::MAX);
    }
    let attributes = set.attributes();
    let unit = attributes.iter().find(|a| matches!(a.name.to_lowercase().as_str(), "units" | "unit"));
    let unit = unit.and_then(|a| a.read_string().ok()).map(|t| t.trim().to_owned()).unwrap_or_default();
    Ok((shape, unit, Cube { set, kind }))
}

/// All data sets with their paths.
fn all_sets(group: &Group, path: &str, seen: &mut Vec<u64>, found: &mut Vec<(String, Dataset)>) {
    if seen.len() > MOST_SETS || seen.contains(&group.address()) {
        return;
    }
    seen.push(group.address());
    let Ok((groups, sets)) = group.members() else { return };
    for set in sets {
        found.push((format!("{path}/{}", set.name()), set));
    }
    for inner in groups {
        all_sets(&inner, &format!("{path}/{}", inner.name()), seen, found);
    }
}

impl Cube {
    /// The numbers within a range along an axis.
    pub(crate) fn part(&self, axis: usize, range: Range<usize>) -> Result<Vec<f64>, ReadProblem> {
        let whole = |length: &u64| SliceInfoElem::Slice { start: 0, end: *length, step: 1 };
        let mut selections: Vec<SliceInfoElem> = self.set.shape().iter().map(whole).collect();
        selections[axis] = SliceInfoElem::Slice { start: range.start as u64, end: range.end as u64, step: 1 };
        let part = SliceInfo { selections };
        let read = || match (self.kind.kind, self.kind.bytes) {
            (Kind::Float, 4) => self.numbers(&part, |v: f32| f64::from(v)),
            (Kind::Float, 8) => self.numbers(&part, |v: f64| v),
            (Kind::Signed, 1) => self.numbers(&part, |v: i8| f64::from(v)),
            (Kind::Signed, 2) => self.numbers(&part, |v: i16| f64::from(v)),
            (Kind::Signed, 4) => self.numbers(&part, |v: i32| f64::from(v)),
            (Kind::Signed, 8) => self.numbers(&part, |v: i64| v as f64),
            (Kind::Unsigned, 1) => self.numbers(&part, |v: u8| f64::from(v)),
            (Kind::Unsigned, 2) => self.numbers(&part, |v: u16| f64::from(v)),
            (Kind::Unsigned, 4) => self.numbers(&part, |v: u32| f64::from(v)),
            (Kind::Unsigned, 8) => self.numbers(&part, |v: u64| v as f64),
            (_, bytes) => {
                let bits = 8 * bytes;
                Err(Error::InvalidData(format!("numbers of {bits} bits in three dimensions are not read")))
            }
        };
        guard::guarded(Format::Hdf5, read, |e: Error| Format::Hdf5.broken(e))
    }

    fn numbers<T: H5Type + Copy>(&self, part: &SliceInfo, double: fn(T) -> f64) -> Result<Vec<f64>, Error> {
        Ok(self.set.read_slice::<T>(part)?.iter().map(|v| double(*v)).collect())
    }
}

#[derive(Default)]
struct Found {
    arrays: Vec<Array>,
    named: NamedValues,
    notes: Vec<String>,
    seen: Vec<u64>,
    /// Bytes that may still be requested.
    left: usize,
}

impl Found {
    fn group(&mut self, group: &Group, path: &str, depth: usize) {
        if depth > DEEPEST || self.seen.contains(&group.address()) {
            return;
        }
        self.seen.push(group.address());
        for attribute in group.attributes().unwrap_or_default() {
            let named = value(&attribute).map(|(name, value)| (path.to_owned(), name, value));
            self.named.extend(named);
        }
        let (groups, sets) = match group.members() {
            Ok(members) => members,
            Err(error) => {
                self.notes.push(format!("group `{path}/` was not read: {error}"));
                return;
            }
        };
        for set in sets {
            if self.seen.len() + self.arrays.len() > MOST_SETS {
                self.notes.push(format!("more than {MOST_SETS} data sets: the rest was not read"));
                return;
            }
            if let Err(error) = self.set(&set, path) {
                self.notes.push(format!("`{path}/{}` was not read: {error}", set.name()));
            }
        }
        for inner in groups {
            // MATLAB stores the targets of cell references in separate groups, PyTables its indices.
            if !inner.name().starts_with('#') && !inner.name().starts_with("_i_") {
                self.group(&inner, &format!("{path}/{}", inner.name()), depth + 1);
            }
        }
    }

    /// Converts counts of a converter to readings if the group states the scale, as Keysight oscilloscopes do.
    fn scale(&mut self, path: &str, set: &str, counts: &mut [f64]) {
        let of = |wanted: &str| {
            let found = self.named.iter().find(|(place, name, _)| place == path && name == wanted);
            found.and_then(|(.., value)| value.parse::<f64>().ok()).filter(|value| value.is_finite())
        };
        let (Some(step), Some(origin)) = (of("YInc").filter(|step| *step != 0.0), of("YOrg")) else { return };
        counts.iter_mut().for_each(|count| *count = *count * step + origin);
        let done = format!(
            "`{path}/{set}` holds counts: they were multiplied by YInc, {step}, and YOrg, {origin}, was added"
        );
        self.notes.push(done);
    }

    fn set(&mut self, set: &Dataset, path: &str) -> Result<(), Error> {
        let dims: Vec<usize> =
            set.shape().iter().map(|d| usize::try_from(*d).unwrap_or(usize::MAX)).collect();
        let attributes = set.attributes();
        let text = |name: &str| {
            let found = attributes.iter().find(|a| a.name.eq_ignore_ascii_case(name))?;
            found.read_string().ok().map(|t| t.trim().to_owned())
        };
        let unit = text("units").or_else(|| text("unit")).unwrap_or_default();
        let single = dims.iter().all(|d| *d <= 1);
        let complex = complex_parts(set.dtype(), set.name());
        let fields: Vec<(String, usize, Stored)> = match set.dtype() {
            _ if !complex.is_empty() => complex.clone(),
            Datatype::Compound { fields, .. } => {
                fields.iter().flat_map(|f| members(&f.name, f.byte_offset as usize, &f.datatype)).collect()
            }
            other => members("", 0, other),
        };
        if fields.is_empty() {
            return Ok(());
        }
        let (step, length) = (set.raw_element_size()?, set.raw_byte_len()?);
        let Some(left) = self.left.checked_sub(length) else {
            return Err(Error::ResourceLimit(format!(
                "its {length} bytes are more than a file of this size may hold in all"
            )));
        };
        self.left = left;
        let raw = set.read_raw_bytes()?;
        for (field, offset, stored) in fields {
            let mut values: Vec<f64> = raw
                .chunks_exact(step.max(1))
                .map(|e| e.get(offset..).map_or(f64::NAN, |bytes| stored.read(bytes)))
                .collect();
            if stored.kind != Kind::Float && !single {
                self.scale(path, set.name(), &mut values);
            }
            let own = match (field.is_empty(), path.is_empty() && single) {
                (true, _) => set.name().to_owned(),
                (false, _) => field.clone(),
            };
            if let ([value], true) = (&values[..], single) {
                self.named.push((path.to_owned(), own, value.to_string()));
                continue;
            }
            // The fields of a compound form a separate table.
            let parent = if field.is_empty() || !complex.is_empty() {
                path.to_owned()
            } else {
                format!("{path}/{}", set.name())
            };
            if let Some(mut array) = Array::new(&parent, &own, &dims, values, false) {
                array.unit.clone_from(&unit);
                let is_unit = |name: &str| matches!(name.to_lowercase().as_str(), "unit" | "units");
                array.named =
                    attributes.iter().filter_map(value).filter(|(name, _)| !is_unit(name)).collect();
                self.arrays.push(array);
            }
        }
        Ok(())
    }
}

/// Name and value of an attribute that is a single word or number.
fn value(attribute: &hdf5_reader::Attribute) -> Option<(String, String)> {
    let value = attribute.read_string().ok().or_else(|| attribute.read_as_f64().ok().map(|v| v.to_string()));
    Some((attribute.name.clone(), value.filter(|v| v.len() < 200)?))
}

/// LZF: literal runs of at most 32 bytes, and copies of at most 264 bytes from the preceding 8 kB; `None` if the data
/// are corrupt.
fn unpacked_lzf(packed: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut rest = packed.iter();
    while let Some(&control) = rest.next() {
        let control = usize::from(control);
        if control < 32 {
            let run = rest.as_slice().get(..=control)?;
            bytes.extend_from_slice(run);
            rest = rest.as_slice()[run.len()..].iter();
            continue;
        }
        let mut length = control >> 5;
        if length == 7 {
            length += usize::from(*rest.next()?);
        }
        let back = ((control & 0x1f) << 8) + usize::from(*rest.next()?) + 1;
        let from = bytes.len().checked_sub(back)?;
        // A copy may overlap the bytes that it writes.
        for at in from..from + length + 2 {
            bytes.push(bytes[at]);
        }
    }
    Some(bytes)
}

/// The two parts of a complex number, which h5py and PyTables write as a compound of `r` and `i`; empty for other
/// types.
fn complex_parts(kind: &Datatype, name: &str) -> Vec<(String, usize, Stored)> {
    let Datatype::Compound { fields, .. } = kind else { return Vec::new() };
    let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).collect();
    if !matches!(names[..], ["r", "i"] | ["real", "imag"]) {
        return Vec::new();
    }
    let part = |(name, f): (String, &hdf5_reader::CompoundField)| {
        Some((name, f.byte_offset as usize, stored(&f.datatype)?))
    };
    let parts: Vec<_> = arrays::parts(name).into_iter().zip(fields).filter_map(part).collect();
    if parts.len() == 2 { parts } else { Vec::new() }
}

/// The numbers of a field, with name, offset and storage: one, or those of a short array; empty for text.
fn members(name: &str, offset: usize, kind: &Datatype) -> Vec<(String, usize, Stored)> {
    let (base, count) = match kind {
        Datatype::Array { base, dims } => (&**base, dims.iter().fold(1, |n: u64, d| n.saturating_mul(*d))),
        other => (other, 1),
    };
    let Some(stored) = stored(base).filter(|_| count <= MOST_MEMBERS) else { return Vec::new() };
    let own =
        |i: u64| if count == 1 { name.to_owned() } else { format!("{name} {}", i + 1).trim().to_owned() };
    (0..count).map(|i| (own(i), offset + i as usize * stored.bytes, stored)).collect()
}

/// How a number is stored; `None` if the type is not a number.
fn stored(kind: &Datatype) -> Option<Stored> {
    let (kind, size, order) = match kind {
        Datatype::FloatingPoint { size: size @ (2 | 4 | 8), byte_order } => (Kind::Float, size, byte_order),
        Datatype::FixedPoint { size: size @ (1 | 2 | 4 | 8), signed, byte_order, .. } => {
            (if *signed { Kind::Signed } else { Kind::Unsigned }, size, byte_order)
        }
        _ => return None,
    };
    Stored::new(kind, usize::from(*size), matches!(order, ByteOrder::BigEndian))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lzf_repeats_what_it_has_written_and_refuses_what_it_has_not() {
        // `ab`, then six bytes from two back; then one literal.
        assert_eq!(unpacked_lzf(b"\x01ab\x80\x01\x00c").as_deref(), Some(&b"ababababc"[..]));
        for broken in [&b"\x05ab"[..], b"\x20\x00", b"\xe0", b"\x00a\x20\x01"] {
            assert_eq!(unpacked_lzf(broken), None, "{broken:?}");
        }
    }
}

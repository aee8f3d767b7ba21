//! HDF5 files, MATLAB 7.3 among them.

use hdf5_reader::{ByteOrder, Dataset, Datatype, Hdf5File, OpenOptions, group::Group};

use crate::{
    error::ReadProblem,
    format::Format,
    tables::arrays::{self, Array, NamedValues},
    tables::binary::{Kind, Stored},
    tables::guard,
    tables::table::HeldTables,
};

/// Groups in groups, at most; links can make circles.
const DEEPEST: usize = 12;
/// Data sets read, at most.
const MOST_SETS: usize = 2048;
/// Numbers that unpack to so many times the file are no measurement.
const MOST_EXPANSION: usize = 64;

/// Reads all data sets of one or two dimensions.
pub(crate) fn tables(bytes: Vec<u8>) -> Result<HeldTables, ReadProblem> {
    let most = bytes.len().saturating_mul(MOST_EXPANSION).max(1 << 24);
    let options = OpenOptions::default()
        .with_max_read_bytes(most)
        .with_max_chunk_bytes(most)
        .with_max_object_header_bytes(bytes.len());
    let mut found = Found::default();
    let decode = || {
        let file = Hdf5File::from_vec_with_options(bytes, options)?;
        found.group(&file.root_group()?, "", 0);
        Ok(())
    };
    guard::guarded(Format::Hdf5, decode, |e: hdf5_reader::error::Error| Format::Hdf5.broken(e))?;
    if found.arrays.is_empty() {
        return Err(Format::Hdf5
            .broken(format!("no data set in it holds rows of numbers; {}", found.notes.join("; "))));
    }
    let mut tables = arrays::tables(found.arrays, &found.named);
    tables.note_all(&found.notes);
    Ok(tables)
}

#[derive(Default)]
struct Found {
    arrays: Vec<Array>,
    named: NamedValues,
    notes: Vec<String>,
    seen: Vec<u64>,
}

impl Found {
    fn group(&mut self, group: &Group, path: &str, depth: usize) {
        if depth > DEEPEST || self.seen.contains(&group.address()) {
            return;
        }
        self.seen.push(group.address());
        for attribute in group.attributes().unwrap_or_default() {
            self.name(path, &attribute);
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
                self.notes.push(format!("more than {MOST_SETS} data sets: the rest was left aside"));
                return;
            }
            if let Err(error) = self.set(&set, path) {
                self.notes.push(format!("`{path}/{}` was not read: {error}", set.name()));
            }
        }
        for inner in groups {
            // MATLAB keeps what cells refer to in groups of its own.
            if !inner.name().starts_with('#') {
                self.group(&inner, &format!("{path}/{}", inner.name()), depth + 1);
            }
        }
    }

    fn name(&mut self, path: &str, attribute: &hdf5_reader::Attribute) {
        let value =
            attribute.read_string().ok().or_else(|| attribute.read_as_f64().ok().map(|v| v.to_string()));
        if let Some(value) = value.filter(|v| v.len() < 200) {
            self.named.push((path.to_owned(), attribute.name.clone(), value));
        }
    }

    fn set(&mut self, set: &Dataset, path: &str) -> Result<(), hdf5_reader::error::Error> {
        let dims: Vec<usize> =
            set.shape().iter().map(|d| usize::try_from(*d).unwrap_or(usize::MAX)).collect();
        let attributes = set.attributes();
        let text = |name: &str| {
            let found = attributes.iter().find(|a| a.name.eq_ignore_ascii_case(name))?;
            found.read_string().ok().map(|t| t.trim().to_owned())
        };
        let unit = text("units").or_else(|| text("unit")).unwrap_or_default();
        let single = dims.iter().all(|d| *d <= 1);
        let fields: Vec<(String, usize, Datatype)> = match set.dtype() {
            Datatype::Compound { fields, .. } => {
                fields.iter().map(|f| (f.name.clone(), f.byte_offset as usize, f.datatype.clone())).collect()
            }
            other => vec![(String::new(), 0, other.clone())],
        };
        if !fields.iter().any(|(.., kind)| stored(kind).is_some()) {
            return Ok(());
        }
        let step = set.raw_element_size()?;
        let raw = set.read_raw_bytes()?;
        for (field, offset, kind) in fields {
            let Some(stored) = stored(&kind) else { continue };
            let values: Vec<f64> = raw
                .chunks_exact(step.max(1))
                .map(|e| e.get(offset..).map_or(f64::NAN, |bytes| stored.read(bytes)))
                .collect();
            let own = match (field.is_empty(), path.is_empty() && single) {
                (true, _) => set.name().to_owned(),
                (false, _) => field.clone(),
            };
            if let ([value], true) = (&values[..], single) {
                self.named.push((path.to_owned(), own, value.to_string()));
                continue;
            }
            // The fields of a compound are a table of their own.
            let parent = if field.is_empty() { path.to_owned() } else { format!("{path}/{}", set.name()) };
            if let Some(mut array) = Array::new(&parent, &own, &dims, values, false) {
                array.unit.clone_from(&unit);
                self.arrays.push(array);
            }
        }
        Ok(())
    }
}

/// How a number is stored, `None` of what is none.
fn stored(kind: &Datatype) -> Option<Stored> {
    let (kind, size, order) = match kind {
        Datatype::FloatingPoint { size: size @ (4 | 8), byte_order } => (Kind::Float, size, byte_order),
        Datatype::FixedPoint { size: size @ (1 | 2 | 4 | 8), signed, byte_order, .. } => {
            (if *signed { Kind::Signed } else { Kind::Unsigned }, size, byte_order)
        }
        _ => return None,
    };
    Stored::new(kind, usize::from(*size), matches!(order, ByteOrder::BigEndian))
}

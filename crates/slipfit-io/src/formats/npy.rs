//! NumPy arrays: plain, with several columns, or with named fields.

use crate::{
    error::ReadProblem,
    format::Format,
    tables::arrays::{self, Array, NamedValues},
    tables::binary::{Kind, Stored},
    tables::table::LoadedTables,
};

/// Maximum depth of nested brackets in a header.
const DEEPEST: usize = 8;

/// The tables of one `.npy` file.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
    let Contents { arrays, note, .. } = contents(bytes, "", "x")?;
    if arrays.is_empty() {
        return Err(Format::Npy.broken("it holds no rows of numbers"));
    }
    let mut tables = arrays::tables(arrays, &Vec::new());
    tables.note_all(&Vec::from_iter(note));
    Ok(tables)
}

/// Content of an array.
#[derive(Default)]
pub(crate) struct Contents {
    /// Its columns.
    pub(crate) arrays: Vec<Array>,
    /// Its number if it is a scalar, such as a rate.
    pub(crate) named: NamedValues,
    /// Note on an irregularity.
    pub(crate) note: Option<String>,
}

/// The columns of an array, or its number.
pub(crate) fn contents(bytes: &[u8], parent: &str, name: &str) -> Result<Contents, ReadProblem> {
    let header = Header::read(bytes)?;
    let size = header.fields.iter().try_fold(0_usize, |sum, f| sum.checked_add(f.bytes));
    let size = size.filter(|s| *s > 0).ok_or_else(|| Format::Npy.broken("its elements have no size"))?;
    let count = header.shape.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    let count = count.ok_or_else(|| Format::Npy.broken("its shape is larger than any memory"))?;
    let there = header.data.len() / size;
    let (count, mut dims, mut found) = (count.min(there), header.shape.clone(), Contents::default());
    if header.shape.iter().product::<usize>() > there {
        found.note = Some(format!("the array ends early: {there} of the elements its header names"));
        // Only the slowest index can be incomplete.
        let slowest = if header.first_fastest { dims.last_mut() } else { dims.first_mut() };
        if let Some(slowest) = slowest {
            let others = (header.shape.iter().product::<usize>() / (*slowest).max(1)).max(1);
            *slowest = count / others;
        }
    }
    let count = dims.iter().product::<usize>();
    let mut at = 0;
    for field in &header.fields {
        for (name, offset, stored) in field.numbers(name) {
            let from = at + offset;
            let elements = header.data.chunks_exact(size).take(count);
            let values: Vec<f64> = elements.map(|e| stored.read(&e[from..at + field.bytes])).collect();
            match values[..] {
                [value] => found.named.push((parent.to_owned(), name, value.to_string())),
                _ => found.arrays.extend(Array::new(parent, &name, &dims, values, header.first_fastest)),
            }
        }
        at += field.bytes;
    }
    Ok(found)
}

/// Shape, storage of the numbers and their offset, for a three-dimensional array, from the first bytes of its file.
pub(crate) fn cube(head: &[u8]) -> Result<([usize; 3], Stored, u64), ReadProblem> {
    let header = Header::read(head)?;
    let refused = |reason: String| ReadProblem::NoStack { reason };
    let shape = <[usize; 3]>::try_from(header.shape.as_slice())
        .map_err(|_| refused(format!("the array has the shape {:?}, three axes are needed", header.shape)))?;
    if header.first_fastest {
        return Err(refused("the array is in Fortran order; numpy.ascontiguousarray converts it".to_owned()));
    }
    match header.fields.as_slice() {
        [field] => match field.stored() {
            Some(stored) => Ok((shape, stored, (head.len() - header.data.len()) as u64)),
            None => Err(refused(format!("its elements are {}, not real numbers", field.code))),
        },
        _ => Err(refused("its elements have named fields".to_owned())),
    }
}

/// How a number with this type code, such as `<f4`, is stored.
#[cfg(feature = "zarr")]
pub(crate) fn stored(code: &str) -> Option<Stored> {
    Field::new("", code)?.stored()
}

/// Header and data of an array.
struct Header<'a> {
    fields: Vec<Field>,
    shape: Vec<usize>,
    first_fastest: bool,
    data: &'a [u8],
}

/// A number in each element of an array.
struct Field {
    name: String,
    /// `<f8` and the like; empty if the field is itself an array.
    code: String,
    bytes: usize,
}

impl Field {
    fn new(name: &str, code: &str) -> Option<Self> {
        let digits = code.trim_start_matches(|c: char| !c.is_ascii_digit());
        let digits = digits.split('[').next().unwrap_or_default();
        // Text counts characters of four bytes.
        let wide = if code.contains('U') { 4 } else { 1 };
        let bytes = digits.parse::<usize>().ok()?.checked_mul(wide)?;
        Some(Self { name: name.to_owned(), code: code.to_owned(), bytes })
    }

    /// How its number is stored.
    fn stored(&self) -> Option<Stored> {
        let code = self.code.split('[').next()?;
        let order = code.chars().next()?;
        let kind = match code.get(1..2)? {
            "f" => Kind::Float,
            // Times are counts of their unit.
            "i" | "m" | "M" => Kind::Signed,
            "u" => Kind::Unsigned,
            "b" if code == "|b1" => Kind::Unsigned,
            _ => return None,
        };
        let bytes = code.get(2..)?.parse().ok().filter(|bytes| matches!(bytes, 1 | 2 | 4 | 8))?;
        matches!(order, '<' | '>' | '=' | '|').then(|| Stored::new(kind, bytes, order == '>'))?
    }

    /// Its numbers with name, offset and storage: one, two for a complex number, none for text. If unnamed, it has the
    /// array's name.
    fn numbers(&self, array: &str) -> Vec<(String, usize, Stored)> {
        let name = if self.name.is_empty() { array } else { &self.name };
        if let Some(stored) = self.stored() {
            return vec![(name.to_owned(), 0, stored)];
        }
        if self.code.get(1..2) != Some("c") || !matches!(self.bytes, 8 | 16) {
            return Vec::new();
        }
        let half = self.bytes / 2;
        let part = |(name, offset)| {
            Some((name, offset, Stored::new(Kind::Float, half, self.code.starts_with('>'))?))
        };
        arrays::parts(name).into_iter().zip([0, half]).filter_map(part).collect()
    }

    /// The unit in the type code of a time, such as `<m8[ns]`.
    fn time_unit(&self) -> Option<&str> {
        let (kind, rest) = self.code.split_once('[')?;
        kind.ends_with(['m', 'M', '8']).then(|| rest.trim_end_matches(']'))
    }
}

/// A Python literal of the kinds used in headers.
#[derive(Debug, PartialEq)]
enum Literal {
    Text(String),
    Number(usize),
    Word(String),
    List(Vec<Literal>),
    Dict(Vec<(Literal, Literal)>),
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, ReadProblem> {
        let length = |n: usize| -> Option<usize> {
            let bytes = bytes.get(8..8 + n)?;
            Some(bytes.iter().rev().fold(0, |sum, b| sum << 8 | usize::from(*b)))
        };
        let (start, length) = match bytes.get(6) {
            Some(1) => (10, length(2)),
            Some(2 | 3) => (12, length(4)),
            _ => return Err(Format::Npy.broken("its version is unknown")),
        };
        let end = length.and_then(|l| l.checked_add(start)).filter(|end| *end <= bytes.len());
        let end = end.ok_or_else(|| Format::Npy.broken("it ends in its header"))?;
        let text = std::str::from_utf8(&bytes[start..end])
            .map_err(|_| Format::Npy.broken("its header is not text"))?;
        let mut parser = Parser { rest: text };
        let Some(Literal::Dict(entries)) = parser.literal(0) else {
            return Err(Format::Npy.broken("its header is not a dictionary"));
        };
        let entry = |name: &str| {
            entries.iter().find(|(key, _)| *key == Literal::Text(name.to_owned())).map(|(_, value)| value)
        };
        let shape = match entry("shape") {
            Some(Literal::List(dims)) => dims
                .iter()
                .map(|d| if let Literal::Number(n) = d { Some(*n) } else { None })
                .collect::<Option<Vec<usize>>>(),
            _ => None,
        };
        let shape = shape.ok_or_else(|| Format::Npy.broken("its header has no shape"))?;
        let fields = match entry("descr") {
            Some(Literal::Text(code)) => Field::new("", code).map(|f| vec![f]),
            Some(Literal::List(fields)) => fields.iter().map(Self::field).collect(),
            _ => None,
        };
        let mut fields =
            fields.ok_or_else(|| Format::Npy.broken("its header has no type this program knows"))?;
        for field in &mut fields {
            if let Some(unit) = field.time_unit() {
                field.name = format!("{} ({unit})", field.name);
            }
            field.code.truncate(field.code.find('[').unwrap_or(field.code.len()));
        }
        if fields.iter().all(|f| f.numbers("").is_empty()) {
            let codes: Vec<&str> = fields.iter().map(|f| f.code.as_str()).collect();
            return Err(Format::Npy.broken(format!("its elements are not numbers: {}", codes.join(", "))));
        }
        let first_fastest = entry("fortran_order") == Some(&Literal::Word("True".to_owned()));
        Ok(Self { fields, shape, first_fastest, data: &bytes[end..] })
    }

    /// `('name', '<f8')`, or `('name', '<f8', (3,))`, of which only the size is kept and not the numbers.
    fn field(literal: &Literal) -> Option<Field> {
        let Literal::List(parts) = literal else { return None };
        match &parts[..] {
            [Literal::Text(name), Literal::Text(code)] => Field::new(name, code),
            [Literal::Text(name), Literal::Text(code), Literal::List(dims)] => {
                let mut field = Field::new(name, code)?;
                for dim in dims {
                    let Literal::Number(n) = dim else { return None };
                    field.bytes = field.bytes.checked_mul(*n)?;
                }
                field.code = String::new();
                Some(field)
            }
            _ => None,
        }
    }
}

struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    fn next_is(&mut self, mark: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(mark) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn literal(&mut self, depth: usize) -> Option<Literal> {
        if depth > DEEPEST {
            return None;
        }
        if self.next_is('{') {
            let mut entries = Vec::new();
            while !self.next_is('}') {
                let key = self.literal(depth + 1)?;
                if !self.next_is(':') {
                    return None;
                }
                entries.push((key, self.literal(depth + 1)?));
                self.next_is(',');
            }
            return Some(Literal::Dict(entries));
        }
        for (open, close) in [('(', ')'), ('[', ']')] {
            if self.next_is(open) {
                let mut items = Vec::new();
                while !self.next_is(close) {
                    items.push(self.literal(depth + 1)?);
                    self.next_is(',');
                }
                return Some(Literal::List(items));
            }
        }
        for quote in ['\'', '"'] {
            if self.next_is(quote) {
                let (text, rest) = self.rest.split_once(quote)?;
                self.rest = rest;
                return Some(Literal::Text(text.to_owned()));
            }
        }
        let end = self.rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        match word.trim_end_matches('L').parse() {
            Ok(number) => Some(Literal::Number(number)),
            Err(_) if word.is_empty() => None,
            Err(_) => Some(Literal::Word(word.to_owned())),
        }
    }
}

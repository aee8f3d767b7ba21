//! Description of an array in `.zarray` and `zarr.json`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::codec::Codec;
use super::cube::{Cube, refused};
use crate::error::ReadProblem;
use crate::formats::npy;
use crate::tables::binary::Stored;

/// Maximum number of bytes of a chunk: the largest size that its compression can state.
const LARGEST_CHUNK: usize = i32::MAX as usize;
/// Maximum number of bytes of a description.
const LONGEST: u64 = 1 << 24;

/// A folder of a store.
pub(super) enum Node {
    Group,
    Array(Array),
}

/// Description of an array.
pub(super) struct Array {
    version: Version,
    text: Value,
    attributes: Value,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Three,
}

/// Kind of a folder; `None` if it is not part of a store.
pub(super) fn node(folder: &Path) -> Result<Option<Node>, ReadProblem> {
    if let Some(text) = json(&folder.join("zarr.json"))? {
        let attributes = text["attributes"].clone();
        let is_array = text["node_type"] == "array";
        return Ok(Some(if is_array {
            Node::Array(Array { version: Version::Three, text, attributes })
        } else {
            Node::Group
        }));
    }
    if let Some(text) = json(&folder.join(".zarray"))? {
        let attributes = json(&folder.join(".zattrs"))?.unwrap_or_default();
        return Ok(Some(Node::Array(Array { version: Version::Two, text, attributes })));
    }
    Ok(folder.join(".zgroup").is_file().then_some(Node::Group))
}

fn json(path: &Path) -> Result<Option<Value>, ReadProblem> {
    let named = || path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match fs::metadata(path) {
        Ok(m) if m.len() > LONGEST => return Err(refused(format!("{} has {} bytes", named(), m.len()))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        _ => {}
    }
    let bytes = fs::read(path).map_err(ReadProblem::Io)?;
    serde_json::from_slice(&bytes)
        .map(Some)
        .map_err(|error| refused(format!("{} is broken: {error}", named())))
}

/// Three whole numbers.
fn lengths(value: &Value) -> Option<[usize; 3]> {
    let list: Option<Vec<usize>> =
        value.as_array()?.iter().map(|v| usize::try_from(v.as_u64()?).ok()).collect();
    list?.try_into().ok()
}

impl Array {
    pub(super) fn shape(&self) -> Vec<u64> {
        let lengths = self.text["shape"].as_array();
        lengths.into_iter().flatten().map(|length| length.as_u64().unwrap_or_default()).collect()
    }

    /// Its unit, and access to its numbers.
    pub(super) fn cube(self, folder: PathBuf) -> Result<(String, Cube), ReadProblem> {
        let Self { version, text, attributes } = self;
        let unit = ["units", "unit"].iter().find_map(|name| attributes[name].as_str());
        let unit = unit.unwrap_or_default().trim().to_owned();
        let shape = lengths(&text["shape"]).ok_or_else(|| {
            refused(format!("the array has the shape {}, three axes are needed", text["shape"]))
        })?;
        let form = match version {
            Version::Two => Form::second(&text),
            Version::Three => Form::third(&text),
        }?;
        let Form { chunk, stored, separator, prefix, codecs, first_fastest } = form;
        let size = chunk.iter().try_fold(stored.bytes, |n, length| n.checked_mul(*length));
        if !size.is_some_and(|size| (1..=LARGEST_CHUNK).contains(&size)) {
            return Err(refused(format!("its chunks are {chunk:?} numbers")));
        }
        let strides = if first_fastest {
            [1, chunk[0], chunk[0] * chunk[1]]
        } else {
            [chunk[1] * chunk[2], chunk[2], 1]
        };
        let fill = match &text["fill_value"] {
            Value::Null => 0.0,
            Value::Bool(fill) => f64::from(u8::from(*fill)),
            Value::Number(fill) => fill.as_f64().unwrap_or(f64::NAN),
            Value::String(word) if word == "Infinity" => f64::INFINITY,
            Value::String(word) if word == "-Infinity" => f64::NEG_INFINITY,
            _ => f64::NAN,
        };
        Ok((unit, Cube { folder, shape, chunk, strides, stored, fill, separator, prefix, codecs }))
    }
}

/// How the numbers of an array are stored.
struct Form {
    chunk: [usize; 3],
    stored: Stored,
    separator: char,
    prefix: &'static str,
    codecs: Vec<Codec>,
    first_fastest: bool,
}

fn separator(value: &Value, otherwise: char) -> char {
    value.as_str().and_then(|text| text.chars().next()).unwrap_or(otherwise)
}

fn chunk(value: &Value) -> Result<[usize; 3], ReadProblem> {
    lengths(value).ok_or_else(|| refused(format!("its chunks are {value}")))
}

fn numbers(stored: Option<Stored>, named: &Value) -> Result<Stored, ReadProblem> {
    stored.ok_or_else(|| refused(format!("its elements are {named}, not real numbers")))
}

fn codec(named: &Value, id: &str) -> Result<Codec, ReadProblem> {
    Codec::named(named[id].as_str().unwrap_or_default()).ok_or_else(|| {
        refused(format!("its chunks are packed as {named}; gzip, zlib, zstd and blosc are read"))
    })
}

impl Form {
    fn second(text: &Value) -> Result<Self, ReadProblem> {
        let kind = &text["dtype"];
        let stored = numbers(kind.as_str().and_then(npy::stored), kind)?;
        if text["filters"].as_array().is_some_and(|filters| !filters.is_empty()) {
            return Err(refused(format!("its numbers are filtered: {}", text["filters"])));
        }
        let packing = &text["compressor"];
        let codecs = if packing.is_null() { Vec::new() } else { vec![codec(packing, "id")?] };
        Ok(Self {
            chunk: chunk(&text["chunks"])?,
            stored,
            separator: separator(&text["dimension_separator"], '.'),
            prefix: "",
            codecs,
            first_fastest: text["order"] == "F",
        })
    }

    fn third(text: &Value) -> Result<Self, ReadProblem> {
        let kind = &text["data_type"];
        let list = text["codecs"].as_array().map(Vec::as_slice).unwrap_or_default();
        let [bytes, packing @ ..] = list else { return Err(refused("it names no codecs".to_owned())) };
        if bytes["name"] != "bytes" {
            return Err(refused(format!("its numbers are stored as {bytes}")));
        }
        let order = if bytes["configuration"]["endian"] == "big" { '>' } else { '<' };
        let code = kind.as_str().and_then(|kind| {
            let digits = kind.trim_start_matches(|c: char| !c.is_ascii_digit());
            let letter = match kind.strip_suffix(digits)? {
                "float" => 'f',
                "int" => 'i',
                "uint" => 'u',
                _ => return None,
            };
            Some(format!("{order}{letter}{}", digits.parse::<usize>().ok()? / 8))
        });
        let stored = numbers(code.and_then(|code| npy::stored(&code)), kind)?;
        let keys = &text["chunk_key_encoding"];
        let (prefix, otherwise) = if keys["name"] == "v2" { ("", '.') } else { ("c", '/') };
        let separator = separator(&keys["configuration"]["separator"], otherwise);
        Ok(Self {
            chunk: chunk(&text["chunk_grid"]["configuration"]["chunk_shape"])?,
            stored,
            separator,
            prefix: match (prefix, separator) {
                ("", _) => "",
                (_, '.') => "c.",
                _ => "c/",
            },
            codecs: packing.iter().map(|packing| codec(packing, "name")).collect::<Result<_, _>>()?,
            first_fastest: false,
        })
    }
}

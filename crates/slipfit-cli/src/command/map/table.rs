//! A map as a table or as images in a file.

use super::answers::Map;
use crate::failure::Failure;
use crate::output::Target;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef};
use arrow_ipc::writer::FileWriter;
use arrow_schema::DataType;
use slipfit_report::escape;
use std::io::{self, Write};
use std::path::Path;

/// How a map is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Csv,
    Npy,
    Arrow,
}

impl Form {
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|e| e.to_str()) {
            _ if path.as_os_str() == "-" => Ok(Self::Csv),
            Some("csv") => Ok(Self::Csv),
            Some("npy") => Ok(Self::Npy),
            Some("arrow" | "feather") => Ok(Self::Arrow),
            _ => {
                let shown = path.display();
                Err(Failure::new(format!("--table {shown}: the name must end in .csv, .npy or .arrow")))
            }
        }
    }
}

pub(super) fn write(target: &Target, form: Form, map: &Map<'_>) -> Result<(), Failure> {
    target.write(|out| match form {
        Form::Csv => as_csv(out, map),
        Form::Npy => as_npy(out, map),
        Form::Arrow => as_arrow(out, map),
    })
}

/// Rows from top to bottom, in each of them pixels from left to right.
fn pixels<'a>(map: &'a Map<'_>) -> impl Iterator<Item = (usize, usize, &'a arrow_array::RecordBatch, usize)> {
    let columns = map.pixels[1];
    let rows = map.parts.iter().flat_map(|part| (0..part.num_rows()).map(move |row| (part, row)));
    rows.enumerate().map(move |(i, (part, row))| (i / columns, i % columns, part, row))
}

fn as_csv(out: &mut dyn Write, map: &Map<'_>) -> io::Result<()> {
    let Some(first) = map.parts.first() else { return Ok(()) };
    writeln!(out, "# slipfit {} map", env!("CARGO_PKG_VERSION"))?;
    let schema = first.schema();
    let names: Vec<&str> = schema.fields().iter().map(|field| field.name().as_str()).collect();
    writeln!(out, "y,x,{}", names.join(","))?;
    for (y, x, part, row) in pixels(map) {
        write!(out, "{y},{x}")?;
        for column in part.columns() {
            write!(out, ",{}", cell(column, row))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A value as CSV has it; empty where there is none.
fn cell(column: &ArrayRef, row: usize) -> String {
    if column.is_null(row) {
        return String::new();
    }
    match column.data_type() {
        DataType::Float64 => column.as_primitive::<Float64Type>().value(row).to_string(),
        DataType::Int64 => column.as_primitive::<Int64Type>().value(row).to_string(),
        DataType::Boolean => column.as_boolean().value(row).to_string(),
        _ => escape::csv(column.as_string::<i32>().value(row)),
    }
}

/// An array of shape (y, x) with a named field for each column: `np.load(file)["decay_rate_per_s"]` is an
/// image. Words are as long as the longest of them.
fn as_npy(out: &mut dyn Write, map: &Map<'_>) -> io::Result<()> {
    let Some(first) = map.parts.first() else { return Ok(()) };
    let schema = first.schema();
    let mut widths = Vec::new();
    for (at, field) in schema.fields().iter().enumerate() {
        let longest = || {
            let of = |part: &arrow_array::RecordBatch| {
                let column = part.column(at).as_string::<i32>();
                (0..column.len()).map(|row| column.value(row).len()).max().unwrap_or(0)
            };
            map.parts.iter().map(of).max().unwrap_or(0).max(1)
        };
        let (kind, width) = match field.data_type() {
            DataType::Float64 => ("<f8".to_owned(), 8),
            DataType::Int64 => ("<i8".to_owned(), 8),
            DataType::Boolean => ("|b1".to_owned(), 1),
            _ => {
                let width = longest();
                (format!("|S{width}"), width)
            }
        };
        widths.push((field.name().clone(), kind, width));
    }
    let fields: Vec<String> = widths.iter().map(|(name, kind, _)| format!("('{name}', '{kind}')")).collect();
    let [rows, columns] = map.pixels;
    let mut header = format!(
        "{{'descr': [{}], 'fortran_order': False, 'shape': ({rows}, {columns}), }}",
        fields.join(", ")
    );
    // Magic, version and length are twelve bytes; numbers begin at a multiple of 64.
    let all = (12 + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', all - 12 - header.len() - 1));
    header.push('\n');
    out.write_all(b"\x93NUMPY\x02\x00")?;
    out.write_all(&(header.len() as u32).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    for (_, _, part, row) in pixels(map) {
        for (column, (_, _, width)) in part.columns().iter().zip(&widths) {
            match column.data_type() {
                DataType::Float64 => {
                    let held = column.as_primitive::<Float64Type>();
                    let value = if held.is_null(row) { f64::NAN } else { held.value(row) };
                    out.write_all(&value.to_le_bytes())?;
                }
                DataType::Int64 => {
                    out.write_all(&column.as_primitive::<Int64Type>().value(row).to_le_bytes())?;
                }
                DataType::Boolean => {
                    let held = column.as_boolean();
                    out.write_all(&[u8::from(held.is_valid(row) && held.value(row))])?;
                }
                _ => {
                    let mut bytes = column.as_string::<i32>().value(row).as_bytes().to_vec();
                    bytes.resize(*width, 0);
                    out.write_all(&bytes)?;
                }
            }
        }
    }
    Ok(())
}

fn as_arrow(out: &mut dyn Write, map: &Map<'_>) -> io::Result<()> {
    let Some(first) = map.parts.first() else { return Ok(()) };
    let failed = |e| io::Error::other(format!("Arrow: {e}"));
    let [rows, columns] = map.pixels;
    let mut metadata = first.schema().metadata().clone();
    metadata.insert("slipfit_map".to_owned(), format!("{rows} {columns}"));
    let schema = first.schema().as_ref().clone().with_metadata(metadata);
    let mut writer = FileWriter::try_new(out, &schema).map_err(failed)?;
    for part in &map.parts {
        writer.write(part).map_err(failed)?;
    }
    writer.finish().map_err(failed)
}

//! A map as a table or as images in a file.

use super::answers::Map;
use super::layout::{Field, fields, put};
use super::zarr;
use crate::failure::Failure;
use crate::output::{Outputs, Store, Target};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef};
use arrow_ipc::writer::FileWriter;
use arrow_schema::DataType;
use slipfit_report::escape;
use std::io::{self, Write};
use std::path::Path;

/// Where a map is written, and how.
pub(super) enum Table {
    File(Target, fn(&mut dyn Write, &Map) -> io::Result<()>),
    Store(Store),
}

impl Table {
    pub(super) fn planned(outputs: &mut Outputs, path: &Path) -> Result<Self, Failure> {
        let flag = "--table";
        let write = match path.extension().and_then(|e| e.to_str()) {
            _ if path.as_os_str() == "-" => as_csv,
            Some("csv") => as_csv,
            Some("npy") => as_npy,
            Some("arrow" | "feather") => as_arrow,
            Some("zarr") => return Ok(Self::Store(outputs.add_store(flag, path)?)),
            _ => {
                let shown = path.display();
                let problem = format!("{flag} {shown}: the name must end in .zarr, .csv, .npy or .arrow");
                return Err(Failure::new(problem));
            }
        };
        Ok(Self::File(outputs.add(flag, path)?, write))
    }

    pub(super) fn write(&self, map: &Map) -> Result<(), Failure> {
        match self {
            Self::File(target, write) => target.write(|out| write(out, map)),
            Self::Store(store) => store.write(zarr::files(map)),
        }
    }
}

/// Rows from top to bottom, and in each row the pixels from left to right.
fn pixels(map: &Map) -> impl Iterator<Item = (usize, usize, &arrow_array::RecordBatch, usize)> {
    let columns = map.pixels[1];
    let rows = map.parts.iter().flat_map(|part| (0..part.num_rows()).map(move |row| (part, row)));
    rows.enumerate().map(move |(i, (part, row))| (i / columns, i % columns, part, row))
}

fn as_csv(out: &mut dyn Write, map: &Map) -> io::Result<()> {
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

/// A value as written in CSV; empty if there is none.
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
/// image.
fn as_npy(out: &mut dyn Write, map: &Map) -> io::Result<()> {
    let layout = fields(map);
    let described: Vec<String> =
        layout.iter().map(|Field { name, code, .. }| format!("('{name}', '{code}')")).collect();
    let [rows, columns] = map.pixels;
    let mut header = format!(
        "{{'descr': [{}], 'fortran_order': False, 'shape': ({rows}, {columns}), }}",
        described.join(", ")
    );
    // Magic, version and length take twelve bytes; the numbers begin at a multiple of 64.
    let all = (12 + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', all - 12 - header.len() - 1));
    header.push('\n');
    out.write_all(b"\x93NUMPY\x02\x00")?;
    out.write_all(&(header.len() as u32).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    let mut pixel = Vec::new();
    for (_, _, part, row) in pixels(map) {
        pixel.clear();
        for (column, field) in part.columns().iter().zip(&layout) {
            put(&mut pixel, column, row, field.width);
        }
        out.write_all(&pixel)?;
    }
    Ok(())
}

fn as_arrow(out: &mut dyn Write, map: &Map) -> io::Result<()> {
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

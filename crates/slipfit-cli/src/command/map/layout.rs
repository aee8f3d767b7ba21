//! The columns of a map in NumPy's number types, for `.npy` and zarr.

use super::answers::Map;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef};
use arrow_schema::DataType;

/// A column; texts are as long as the longest of them.
pub(super) struct Field {
    pub(super) name: String,
    /// Its type in NumPy's notation, such as `<f8`.
    pub(super) code: String,
    /// Bytes of a value.
    pub(super) width: usize,
}

pub(super) fn fields(map: &Map) -> Vec<Field> {
    let Some(first) = map.parts.first() else { return Vec::new() };
    let schema = first.schema();
    let field = |(at, field): (usize, &std::sync::Arc<arrow_schema::Field>)| {
        let (code, width) = match field.data_type() {
            DataType::Float64 => ("<f8".to_owned(), 8),
            DataType::Int64 => ("<i8".to_owned(), 8),
            DataType::Boolean => ("|b1".to_owned(), 1),
            _ => {
                let width = longest(map, at);
                (format!("|S{width}"), width)
            }
        };
        Field { name: field.name().clone(), code, width }
    };
    schema.fields().iter().enumerate().map(field).collect()
}

fn longest(map: &Map, at: usize) -> usize {
    let of = |part: &arrow_array::RecordBatch| {
        let column = part.column(at).as_string::<i32>();
        (0..column.len()).map(|row| column.value(row).len()).max().unwrap_or(0)
    };
    map.parts.iter().map(of).max().unwrap_or(0).max(1)
}

/// Appends a value; NaN if there is no number.
pub(super) fn put(out: &mut Vec<u8>, column: &ArrayRef, row: usize, width: usize) {
    match column.data_type() {
        DataType::Float64 => {
            let held = column.as_primitive::<Float64Type>();
            let value = if held.is_null(row) { f64::NAN } else { held.value(row) };
            out.extend(value.to_le_bytes());
        }
        DataType::Int64 => out.extend(column.as_primitive::<Int64Type>().value(row).to_le_bytes()),
        DataType::Boolean => {
            let held = column.as_boolean();
            out.push(u8::from(held.is_valid(row) && held.value(row)));
        }
        _ => {
            let end = out.len() + width;
            out.extend(column.as_string::<i32>().value(row).as_bytes());
            out.resize(end, 0);
        }
    }
}

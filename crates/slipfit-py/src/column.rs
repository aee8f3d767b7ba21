//! Columns of tables as arrays, and comparison of tables.

use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::DataType;
use numpy::{Element, PyArray1};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

/// A column whose batches are `parts`: numbers and flags as an array, texts as a list; `None` for other types.
///
/// A null number becomes NaN, which converts integers to doubles; a null flag becomes False.
pub(crate) fn values<'py>(
    py: Python<'py>,
    kind: &DataType,
    parts: &[&ArrayRef],
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let found = match kind {
        DataType::Float64 => numbers::<Float64Type>(py, parts, |v| v),
        DataType::Float32 => {
            let values = parts.iter().flat_map(|part| part.as_primitive::<Float32Type>().iter());
            PyArray1::from_vec(py, values.map(|v| v.unwrap_or(f32::NAN)).collect()).into_any()
        }
        DataType::Float16 => doubles::<Float16Type>(py, parts, f64::from),
        DataType::Int8 => numbers::<Int8Type>(py, parts, f64::from),
        DataType::Int16 => numbers::<Int16Type>(py, parts, f64::from),
        DataType::Int32 => numbers::<Int32Type>(py, parts, f64::from),
        DataType::Int64 => numbers::<Int64Type>(py, parts, |v| v as f64),
        DataType::UInt8 => numbers::<UInt8Type>(py, parts, f64::from),
        DataType::UInt16 => numbers::<UInt16Type>(py, parts, f64::from),
        DataType::UInt32 => numbers::<UInt32Type>(py, parts, f64::from),
        DataType::UInt64 => numbers::<UInt64Type>(py, parts, |v| v as f64),
        DataType::Boolean => {
            let flags = parts.iter().flat_map(|part| part.as_boolean().iter());
            PyArray1::from_iter(py, flags.map(Option::unwrap_or_default)).into_any()
        }
        _ => {
            let Some(texts) = parts.iter().map(|part| texts(part)).collect::<Option<Vec<_>>>() else {
                return Ok(None);
            };
            if parts.is_empty() && !is_text(kind) {
                return Ok(None);
            }
            texts.concat().into_bound_py_any(py)?
        }
    };
    Ok(Some(found))
}

/// Numbers in their own type, or as doubles if one is missing.
fn numbers<'py, T: ArrowPrimitiveType<Native: Element>>(
    py: Python<'py>,
    parts: &[&ArrayRef],
    double: fn(T::Native) -> f64,
) -> Bound<'py, PyAny> {
    if parts.iter().any(|part| part.null_count() > 0) {
        return doubles::<T>(py, parts, double);
    }
    let values = parts.iter().flat_map(|part| part.as_primitive::<T>().values().iter().copied());
    PyArray1::from_vec(py, values.collect()).into_any()
}

fn doubles<'py, T: ArrowPrimitiveType>(
    py: Python<'py>,
    parts: &[&ArrayRef],
    double: fn(T::Native) -> f64,
) -> Bound<'py, PyAny> {
    let values = parts.iter().flat_map(|part| part.as_primitive::<T>().iter());
    PyArray1::from_vec(py, values.map(|v| v.map_or(f64::NAN, double)).collect()).into_any()
}

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// The texts of an array, plain or dictionary-encoded; `None` if it holds none.
fn texts(array: &ArrayRef) -> Option<Vec<Option<&str>>> {
    Some(match array.data_type() {
        DataType::Utf8 => array.as_string::<i32>().iter().collect(),
        DataType::LargeUtf8 => array.as_string::<i64>().iter().collect(),
        DataType::Utf8View => array.as_string_view().iter().collect(),
        DataType::Dictionary(_, values) if is_text(values) => {
            let held = array.as_any_dictionary();
            let words = texts(held.values())?;
            let keys = held.normalized_keys();
            keys.iter()
                .enumerate()
                .map(|(row, key)| words.get(*key).filter(|_| held.is_valid(row)).copied()?)
                .collect()
        }
        _ => return None,
    })
}

/// Whether batches of one schema hold the same rows, however they are divided.
pub(crate) fn same_rows(one: &[RecordBatch], other: &[RecordBatch]) -> bool {
    let rows = |batches: &[RecordBatch]| batches.iter().map(RecordBatch::num_rows).sum::<usize>();
    if rows(one) != rows(other) {
        return false;
    }
    let mut others = other.iter().filter(|batch| batch.num_rows() > 0).cloned();
    let mut left: Option<RecordBatch> = None;
    for batch in one {
        let mut first = 0;
        while first < batch.num_rows() {
            let Some(other_batch) = left.take().or_else(|| others.next()) else { return false };
            let length = other_batch.num_rows().min(batch.num_rows() - first);
            if batch.slice(first, length).columns() != other_batch.slice(0, length).columns() {
                return false;
            }
            let rest = other_batch.num_rows() - length;
            left = (rest > 0).then(|| other_batch.slice(length, rest));
            first += length;
        }
    }
    true
}

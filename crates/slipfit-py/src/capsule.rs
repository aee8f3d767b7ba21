//! Arrow's C interface in Python capsules: the only place with raw pointers.
//!
//! <https://arrow.apache.org/docs/format/CDataInterface/PyCapsuleInterface.html>
#![allow(unsafe_code, reason = "a capsule is a pointer; what it points to is Arrow's C interface")]

use crate::failure::{Failure, option_error};
use arrow_array::ffi::{FFI_ArrowArray, FFI_ArrowSchema, from_ffi};
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::{RecordBatch, RecordBatchIterator, RecordBatchReader, StructArray};
use arrow_schema::{ArrowError, DataType, Schema};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

/// The batches of anything that exports a stream or an array.
pub(crate) fn import(table: &Bound<'_, PyAny>) -> PyResult<Box<dyn RecordBatchReader + Send>> {
    let py = table.py();
    let arrow = |error: ArrowError| {
        let message = format!("the table cannot be taken: {error}");
        Failure::new(py, "OptionError", "arrow", message).with("option", "table").into_error()
    };
    if table.hasattr("__arrow_c_stream__")? {
        let exported = table.call_method0("__arrow_c_stream__").map_err(|error| not_exported(py, error))?;
        let capsule = exported.cast_into::<PyCapsule>()?;
        let pointer = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
        // SAFETY: by the interface, a capsule of this name holds such a stream. It is moved out; an empty one is
        // left for the capsule to release.
        let reader = unsafe { RecordBatchStreamReader::from_raw(pointer.cast().as_ptr()) };
        return Ok(Box::new(reader.map_err(|error| match error {
            // The schema of a single column, such as a Series, has no fields; a stream that has been read has no
            // schema at all.
            ArrowError::CDataInterface(_) => option_error(py, "table", not_a_table(table)),
            other => arrow(other),
        })?));
    }
    if table.hasattr("__arrow_c_array__")? {
        let (schema, array): (Bound<'_, PyCapsule>, Bound<'_, PyCapsule>) =
            table.call_method0("__arrow_c_array__").map_err(|error| not_exported(py, error))?.extract()?;
        let schema = schema.pointer_checked(Some(c"arrow_schema"))?;
        let array = array.pointer_checked(Some(c"arrow_array"))?;
        // SAFETY: by the interface, capsules of these names hold an array and its schema. The array is moved out
        // and an empty one left; the schema is only read, while its capsule lives.
        let data = unsafe {
            let array = FFI_ArrowArray::from_raw(array.cast().as_ptr());
            from_ffi(array, schema.cast::<FFI_ArrowSchema>().as_ref())
        }
        .map_err(arrow)?;
        if !matches!(data.data_type(), DataType::Struct(_)) {
            return Err(option_error(py, "table", not_a_table(table)));
        }
        let batch = RecordBatch::from(StructArray::from(data));
        let schema = batch.schema();
        return Ok(Box::new(RecordBatchIterator::new([Ok(batch)], schema)));
    }
    let kind = table.get_type().qualname()?;
    let message = format!(
        "table is of the type {kind}, which does not export Arrow's C interface (__arrow_c_stream__); pyarrow.table, \
         polars.DataFrame and others do"
    );
    Err(Failure::new(py, "OptionTypeError", "type", message).with("option", "table").into_error())
}

/// The error of a table of another package that cannot be exported as Arrow; errors of slipfit and interruptions
/// are passed on.
fn not_exported(py: Python<'_>, error: PyErr) -> PyErr {
    let own = py.import("slipfit._errors").and_then(|errors| errors.getattr("SlipfitError"));
    if !error.is_instance_of::<PyException>(py) || own.is_ok_and(|own| error.is_instance(py, &own)) {
        return error;
    }
    let message = format!("the table cannot be taken: {error}");
    let told = Failure::new(py, "OptionError", "arrow", message).with("option", "table").into_error();
    told.set_cause(py, Some(error));
    told
}

fn not_a_table(table: &Bound<'_, PyAny>) -> String {
    let kind = table.get_type().qualname().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    format!(
        "table is of the type {kind} and has no columns with names: it is a single column, or has been read"
    )
}

/// A stream for other readers.
pub(crate) fn export_stream<'py>(
    py: Python<'py>,
    reader: Box<dyn RecordBatchReader + Send>,
) -> PyResult<Bound<'py, PyCapsule>> {
    // Released when it is dropped, unless its reader has taken it.
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(reader), c"arrow_array_stream")
}

/// A schema for other readers.
pub(crate) fn export_schema<'py>(py: Python<'py>, schema: &Schema) -> PyResult<Bound<'py, PyCapsule>> {
    let schema = FFI_ArrowSchema::try_from(schema)
        .map_err(|error| Failure::new(py, "SlipfitError", "arrow", error.to_string()).into_error())?;
    PyCapsule::new_with_value(py, schema, c"arrow_schema")
}

//! Arrays as the reader sees them: the bytes of an NPY file with one named field each.
//!
//! The analysis of arrays is that of the file that `numpy.save` would write of them. Cleaning, fingerprint,
//! report and JSON are therefore those of the reader, and the command gives the same answer.

use crate::failure::{Failure, option_error};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

/// A column of numbers.
pub(crate) type Vector<'py> = PyReadonlyArray1<'py, f64>;

/// Name under which reports show arrays.
pub(crate) const NAME: &str = "arrays";

/// The file of these columns, all of equal length.
pub(crate) fn npy(py: Python<'_>, columns: &[(&str, &Vector<'_>)]) -> PyResult<Vec<u8>> {
    let rows = columns.first().map_or(0, |(_, values)| values.as_array().len());
    for (name, values) in columns {
        let found = values.as_array().len();
        if found != rows {
            let first = columns[0].0;
            return Err(option_error(
                py,
                name,
                format!("{name} has {found} values where {first} has {rows}: both need one for each sample"),
            ));
        }
    }
    if rows < 2 {
        let name = columns.last().map_or("signal", |(name, _)| name);
        let found = if rows == 0 { "no rows" } else { "one row" };
        let message = format!("{NAME}: {name} has {found} where several are needed");
        let failure = Failure::new(py, "ReadError", "too_few_rows", message);
        return Err(failure.with("file", NAME).with("row", None::<usize>).with("found", rows).into_error());
    }
    let views: Vec<_> = columns.iter().map(|(_, values)| values.as_array()).collect();
    let mut bytes = header(columns.iter().map(|(name, _)| *name), rows);
    bytes.reserve_exact(8 * rows * views.len());
    if let [Some(only)] = views.iter().map(|v| v.as_slice()).collect::<Vec<_>>()[..] {
        bytes.extend(only.iter().flat_map(|v| v.to_le_bytes()));
        return Ok(bytes);
    }
    for row in 0..rows {
        for view in &views {
            bytes.extend_from_slice(&view[row].to_le_bytes());
        }
    }
    Ok(bytes)
}

/// The first bytes of the file, a multiple of 64.
fn header<'a>(names: impl Iterator<Item = &'a str>, rows: usize) -> Vec<u8> {
    let fields: Vec<String> = names.map(|name| format!("('{name}', '<f8')")).collect();
    let text = format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}", fields.join(", "));
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // A few names: far below 65536.
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes
}

//! Stacks of traces in files.

use crate::failure::read_error;
use crate::interrupt::interruptible;
use numpy::IntoPyArray as _;
use numpy::{PyArray3, PyArrayMethods as _};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// An array of three axes in a file, of which parts are read.
#[pyclass(frozen, module = "slipfit._core")]
pub(crate) struct Stack {
    stack: Arc<Mutex<slipfit_io::Stack>>,
    #[pyo3(get)]
    shape: (usize, usize, usize),
    #[pyo3(get)]
    unit: String,
}

#[pymethods]
impl Stack {
    /// Opens the file; `data` names one of several arrays in it.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, data: Option<&str>) -> PyResult<Self> {
        let stack = slipfit_io::Stack::open(path, data).map_err(|error| read_error(py, error))?;
        let (shape, unit) = (stack.shape().into(), stack.unit().to_owned());
        Ok(Self { stack: Arc::new(Mutex::new(stack)), shape, unit })
    }

    /// The numbers from one index to another along an axis, complete along the others.
    fn part<'py>(
        &self,
        py: Python<'py>,
        axis: usize,
        first: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let stack = Arc::clone(&self.stack);
        let read = move || stack.lock().unwrap_or_else(PoisonError::into_inner).part(axis, first..end);
        let values = interruptible(py, read)?.map_err(|error| read_error(py, error))?;
        let mut shape = <[usize; 3]>::from(self.shape);
        shape[axis] = end - first;
        values.into_pyarray(py).reshape(shape)
    }
}

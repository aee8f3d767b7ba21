//! Where a reading comes from, and how to read it again.

use super::choices::Choices;
use crate::failure::option_error;
use pyo3::IntoPyObjectExt as _;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Clone)]
pub(super) enum Source {
    Paths(Vec<PathBuf>),
    Bytes(Arc<Vec<u8>>, String),
}

/// Everything needed to read the same again.
pub(super) struct Origin {
    pub(super) source: Source,
    pub(super) choices: Choices,
}

/// A function and its arguments, as stored in a pickle.
pub(super) type Call<'py> = (Bound<'py, PyAny>, (Bound<'py, PyAny>, Option<String>, Choices));

impl Origin {
    /// The call that reads it again: a single file is included as its bytes, several files by their names.
    ///
    /// # Errors
    /// The file no longer exists, or its bytes differ from those that were read.
    pub(super) fn call<'py>(&self, py: Python<'py>, function: &str, sha256: &str) -> PyResult<Call<'py>> {
        let function = py.import("slipfit._core")?.getattr(function)?;
        let (source, name) = match &self.source {
            Source::Bytes(bytes, name) => (PyBytes::new(py, bytes).into_any(), Some(name.clone())),
            Source::Paths(paths) => match paths.as_slice() {
                [path] if !path.is_dir() => {
                    let bytes = PyBytes::new(py, &std::fs::read(path)?);
                    let digest = py.import("hashlib")?.call_method1("sha256", (&bytes,))?;
                    let shown = path.display().to_string();
                    if digest.call_method0("hexdigest")?.extract::<String>()? != sha256 {
                        return Err(PyRuntimeError::new_err(format!(
                            "{shown} has changed since it was read"
                        )));
                    }
                    (bytes.into_any(), Some(shown))
                }
                several => (several.into_bound_py_any(py)?, None),
            },
        };
        Ok((function, (source, name, self.choices.clone())))
    }
}

/// Paths, or bytes with a name.
#[derive(FromPyObject)]
pub(crate) enum Given<'py> {
    #[pyo3(transparent)]
    Bytes(Bound<'py, PyBytes>),
    #[pyo3(transparent)]
    Paths(Vec<PathBuf>),
}

impl Given<'_> {
    pub(super) fn source(self, py: Python<'_>, name: Option<String>, most: usize) -> PyResult<Source> {
        match self {
            Self::Bytes(bytes) => {
                let held = Arc::new(bytes.as_bytes().to_vec());
                Ok(Source::Bytes(held, name.unwrap_or_else(|| "bytes".to_owned())))
            }
            Self::Paths(list) if list.is_empty() || list.len() > most => {
                Err(option_error(py, "source", format!("{} files where one is read", list.len())))
            }
            Self::Paths(list) => Ok(Source::Paths(list)),
        }
    }
}

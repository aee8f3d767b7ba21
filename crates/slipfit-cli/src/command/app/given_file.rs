//! The files named on the command line, the only ones that the page may request.

use crate::failure::Failure;
use serde_json::{Value, json};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A file that the page opens at start.
#[derive(Debug)]
pub(super) struct GivenFile {
    path: PathBuf,
}

impl GivenFile {
    /// A file that exists and can be read.
    pub(super) fn new(path: &Path) -> Result<Self, Failure> {
        let file = Self { path: path.to_owned() };
        match file.open() {
            Ok(_) => Ok(file),
            Err(e) => Err(Failure::new(format!("{}: cannot be read: {e}", path.display()))),
        }
    }

    /// The open file and its length.
    pub(super) fn open(&self) -> io::Result<(File, u64)> {
        // Opened first, so that the length is that of the file that is read.
        let file = File::open(&self.path)?;
        let what = file.metadata()?;
        if !what.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
        }
        Ok((file, what.len()))
    }
}

/// The names of the files in the order of their numbers, as on the command line.
pub(super) fn list(files: &[GivenFile]) -> Value {
    files.iter().map(|file| json!({ "name": file.path.to_string_lossy() })).collect()
}

//! A folder that forms one output and is put in place as a whole, as files are.

use super::Outputs;
use super::origin::foreign;
use crate::failure::Failure;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A checked folder of files.
pub(crate) struct Store {
    named: PathBuf,
    /// With links resolved.
    folder: PathBuf,
    force: bool,
}

/// Identifies a store written by slipfit.
const MARK: &str = ".zattrs";

impl Outputs {
    /// Adds the store that `flag` requests.
    ///
    /// # Errors
    /// It is an input, contains one or lies in one, cannot be written, or is something that slipfit did not
    /// write.
    pub(crate) fn add_store(&self, flag: &str, path: &Path) -> Result<Store, Failure> {
        let shown = format!("{flag} {}", path.display());
        let failed = |e: io::Error| Failure::new(format!("{shown}: cannot be written: {e}"));
        let parent = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = path.file_name().ok_or_else(|| failed(io::ErrorKind::InvalidFilename.into()))?;
        let folder = match fs::canonicalize(path) {
            Ok(folder) => folder,
            Err(_) => fs::canonicalize(parent).map_err(failed)?.join(name),
        };
        let inputs = self.inputs().filter_map(|input| fs::canonicalize(input).ok());
        for input in inputs {
            if input.starts_with(&folder) || folder.starts_with(&input) {
                return Err(Failure::new(format!("{shown}: this is the input, which is never overwritten"))
                    .hint("name another folder"));
            }
        }
        let store = Store { named: path.to_owned(), folder, force: self.is_forced() };
        if !store.may_be_replaced() {
            return Err(foreign(&shown));
        }
        Ok(store)
    }
}

impl Store {
    /// Whether it contains no foreign data; with force any zarr store may be replaced, but no other folder.
    fn may_be_replaced(&self) -> bool {
        let is_ours = || {
            let mark = fs::read_to_string(self.folder.join(MARK)).unwrap_or_default();
            serde_json::from_str::<serde_json::Value>(&mark).is_ok_and(|said| said["slipfit"].is_string())
        };
        let is_store =
            || [".zgroup", ".zarray", "zarr.json"].iter().any(|name| self.folder.join(name).is_file());
        !self.folder.exists() || is_ours() || self.force && is_store()
    }

    /// Writes all of its files, given by their paths in it.
    pub(crate) fn write(&self, files: Vec<(String, Vec<u8>)>) -> Result<(), Failure> {
        let name = self.named.display().to_string();
        self.put(files).map_err(|e| Failure::writing(&name, &e))?.then_some(()).ok_or_else(|| foreign(&name))
    }

    /// Whether it could be put in place: another program may have created one in the meantime.
    fn put(&self, files: Vec<(String, Vec<u8>)>) -> io::Result<bool> {
        let temp_folder = tempfile::Builder::new()
            .prefix(".slipfit-")
            .tempdir_in(self.folder.parent().unwrap_or(Path::new(".")))?;
        let [new, old] = ["new", "old"].map(|name| temp_folder.path().join(name));
        fs::create_dir(&new)?;
        for (path, bytes) in files {
            let path = new.join(path);
            fs::create_dir_all(path.parent().unwrap_or(&new))?;
            fs::write(path, bytes)?;
        }
        if !self.may_be_replaced() {
            return Ok(false);
        }
        if self.folder.exists() {
            fs::rename(&self.folder, &old)?;
        }
        fs::rename(&new, &self.folder).inspect_err(|_| {
            let _ = fs::rename(&old, &self.folder);
        })?;
        Ok(true)
    }
}

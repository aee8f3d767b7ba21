//! Folders of the project.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Failure;

/// The workspace folder.
pub(crate) fn root() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// Path of a peer's script, or of the list of the peers' packages.
pub(crate) fn peer(file: &str) -> PathBuf {
    root().join("validation").join("peers").join(file)
}

/// The folder of release builds, which contains this program.
pub(crate) fn programs() -> Result<PathBuf, Failure> {
    let program = std::env::current_exe()?;
    Ok(program.parent().ok_or("this program does not lie in a build folder")?.to_path_buf())
}

/// A command started in the workspace folder.
pub(crate) fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// Writes a page of `docs/`.
pub(crate) fn write_page(name: &str, text: &str) -> Result<(), Failure> {
    let page = root().join("docs").join(name);
    std::fs::write(&page, text).map_err(|error| format!("{}: {error}", page.display()).into())
}

//! A Python of the project's own, with the peers in it.

use std::path::PathBuf;

use crate::Failure;
use crate::places::{command, root, run, target};

/// Folder of the peers' scripts.
pub(crate) fn peers() -> PathBuf {
    root().join("xtask").join("peers")
}

/// The interpreter in `target/venv`, made and filled with the packages of
/// `xtask/peers/requirements.txt` where they are missing.
pub(crate) fn interpreter() -> Result<PathBuf, Failure> {
    let folder = target()?.join("venv");
    let python = if cfg!(windows) { folder.join("Scripts/python.exe") } else { folder.join("bin/python") };
    if !python.is_file() {
        let system = if cfg!(windows) { "python" } else { "python3" };
        run(command(system).args(["-m", "venv"]).arg(&folder))?;
    }
    let mut pip = command(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
    run(pip.arg(peers().join("requirements.txt")))?;
    Ok(python)
}

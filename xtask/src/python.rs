//! The project's own Python environment with the peers' packages.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::Failure;
use crate::places::{command, root, run, target};

/// Folder of the peers' scripts.
pub(crate) fn peers() -> PathBuf {
    root().join("validation").join("peers")
}

/// The interpreter in `target/venv`; the environment is created and the packages of
/// `validation/peers/requirements.txt` are installed if they are missing.
pub(crate) fn interpreter() -> Result<PathBuf, Failure> {
    let programs = environment(&target()?.join("venv"))?;
    install(&programs, [OsStr::new("--requirement"), peers().join("requirements.txt").as_os_str()])?;
    Ok(python_in(&programs))
}

/// Creates a virtual environment in a folder if it is missing; returns the folder of its programs.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf, Failure> {
    let programs = folder.join(if cfg!(windows) { "Scripts" } else { "bin" });
    if !python_in(&programs).is_file() {
        let system = if cfg!(windows) { "python" } else { "python3" };
        run(command(system).args(["-m", "venv"]).arg(folder))?;
    }
    Ok(programs)
}

/// Installs what these arguments name with an environment's `pip`.
pub(crate) fn install<S: AsRef<OsStr>>(
    programs: &Path,
    arguments: impl IntoIterator<Item = S>,
) -> Result<(), Failure> {
    let mut pip = command(python_in(programs));
    // Python compiles modules when they are imported, which is a small part of what is installed.
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"]);
    run(pip.args(arguments))
}

/// Path of the interpreter among an environment's programs.
pub(crate) fn python_in(programs: &Path) -> PathBuf {
    programs.join("python").with_extension(std::env::consts::EXE_EXTENSION)
}

//! A Python of the project's own, with the peers in it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::Failure;
use crate::places::{command, root, run, target};

/// Folder of the peers' scripts.
pub(crate) fn peers() -> PathBuf {
    root().join("validation").join("peers")
}

/// The interpreter in `target/venv`, made and filled with the packages of
/// `validation/peers/requirements.txt` where they are missing.
pub(crate) fn interpreter() -> Result<PathBuf, Failure> {
    let programs = environment(&target()?.join("venv"))?;
    install(&programs, [OsStr::new("--requirement"), peers().join("requirements.txt").as_os_str()])?;
    Ok(python_in(&programs))
}

/// A virtual environment in a folder, made if it is missing: the folder of its programs.
pub(crate) fn environment(folder: &Path) -> Result<PathBuf, Failure> {
    let programs = folder.join(if cfg!(windows) { "Scripts" } else { "bin" });
    if !python_in(&programs).is_file() {
        let system = if cfg!(windows) { "python" } else { "python3" };
        run(command(system).args(["-m", "venv"]).arg(folder))?;
    }
    Ok(programs)
}

/// Lets an environment's `pip` install what these arguments name.
pub(crate) fn install<S: AsRef<OsStr>>(
    programs: &Path,
    arguments: impl IntoIterator<Item = S>,
) -> Result<(), Failure> {
    let mut pip = command(python_in(programs));
    // Python compiles what is imported: a small part of what is installed.
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"]);
    run(pip.args(arguments))
}

/// The interpreter among an environment's programs.
pub(crate) fn python_in(programs: &Path) -> PathBuf {
    programs.join("python").with_extension(std::env::consts::EXE_EXTENSION)
}

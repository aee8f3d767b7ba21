//! Locations of folders, and starting programs there.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Failure;

/// The workspace folder.
pub(crate) fn root() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// The build folder that contains this program, wherever the configuration put it.
pub(crate) fn target() -> Result<PathBuf, Failure> {
    let program = std::env::current_exe()?;
    let folder = program.parent().and_then(Path::parent);
    Ok(folder.ok_or("this program does not lie in a build folder")?.to_path_buf())
}

/// A command started in the workspace folder.
pub(crate) fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// The cargo that started this program.
pub(crate) fn cargo() -> Command {
    command(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// The release build of `slipfit`, built if it is missing. It always includes `slipfit app` and the features of
/// dependencies that the Python package requests: otherwise the readers and the core would be compiled again.
pub(crate) fn slipfit() -> Result<PathBuf, Failure> {
    run(&mut slipfit_build())?;
    Ok(target()?.join("release/slipfit").with_extension(std::env::consts::EXE_EXTENSION))
}

/// The command that builds it.
pub(crate) fn slipfit_build() -> Command {
    let mut build = cargo();
    build.args(["build", "--quiet", "--release", "--bin", "slipfit"]);
    build.args(["--package", "slipfit-cli", "--features", "app", "--package", "slipfit-py"]);
    build
}

/// Whether a command can be started and succeeds; its output is not shown.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

/// The command as it would be typed.
pub(crate) fn spelled(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_stem().unwrap_or(command.get_program());
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

/// Runs a command to its end, passing its output through.
///
/// # Errors
/// If it cannot be started or does not succeed.
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    let spelled = spelled(command);
    eprintln!("$ {spelled}");
    let status = command.status().map_err(|error| format!("`{spelled}` could not be started: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{spelled}`: {status}").into()) }
}

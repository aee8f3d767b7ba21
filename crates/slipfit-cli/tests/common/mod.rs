//! Shared by the tests of the command.
#![allow(dead_code, reason = "each test binary uses some of it")]

use assert_cmd::Command;
use std::path::PathBuf;

/// The command, away from any terminal and any preference of the person testing.
pub(crate) fn slipfit() -> Command {
    let mut command = Command::cargo_bin("slipfit").unwrap();
    command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env_remove("COLUMNS");
    command
}

/// Root of the workspace.
pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// An example shipped with the project.
pub(crate) fn example(name: &str) -> PathBuf {
    root().join("examples").join(name)
}

/// Standard output of a run that must succeed.
pub(crate) fn stdout(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

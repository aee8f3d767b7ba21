//! Release builds of the later steps, compiled at low priority beside the earlier ones.

use std::process::{Command, Stdio};

use crate::Failure;
use crate::places::{cargo, command, slipfit_build};
use crate::web::{MODULES, Toolchain};

/// Starts them. The core is compiled on one processor, and the steps leave one free now and then. What these builds have
/// not ended the steps end, and what fails here fails there, with its message.
pub(super) fn start() {
    std::thread::spawn(|| {
        let mut python = cargo();
        python.args(["build", "--release", "--package", "slipfit-py"]);
        for build in [python, slipfit_build()].into_iter().chain(page().unwrap_or_default()) {
            // Where there is no `nice` nothing is built ahead.
            let _ = at_low_priority(&build).stdout(Stdio::null()).stderr(Stdio::null()).status();
        }
    });
}

fn page() -> Result<Vec<Command>, Failure> {
    let toolchain = Toolchain::find()?;
    MODULES.iter().map(|(_, features)| toolchain.module(*features)).collect()
}

fn at_low_priority(build: &Command) -> Command {
    let mut niced = command("nice");
    niced.args(["-n", "19"]).arg(build.get_program()).args(build.get_args());
    niced.envs(build.get_envs().filter_map(|(name, value)| Some((name, value?))));
    niced
}

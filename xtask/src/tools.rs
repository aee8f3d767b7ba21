//! Tools that do not come with Rust, at the versions used for checking this project.

use std::path::{Path, PathBuf};

use crate::Failure;
use crate::places::{cargo, command, run, target};
use crate::python;

/// A program at a fixed version: precompiled if its authors publish a wheel, otherwise built from source.
pub(crate) struct Tool {
    package: &'static str,
    /// Name of the authors' wheel, which `pip` installs in about a second.
    wheel: Option<&'static str>,
    program: &'static str,
    version: &'static str,
}

/// Checks licences, banned crates, sources and known vulnerabilities.
pub(crate) const CARGO_DENY: Tool =
    Tool { package: "cargo-deny", wheel: None, program: "cargo-deny", version: "0.20.2" };
/// Checks spelling.
pub(crate) const TYPOS: Tool =
    Tool { package: "typos-cli", wheel: Some("typos"), program: "typos", version: "1.52.0" };

impl Tool {
    /// The program: from the search path if the version fits, otherwise from `target/tools`, where it is built first
    /// if missing.
    pub(crate) fn program(&self) -> Result<PathBuf, Failure> {
        let folder = target()?.join("tools");
        let own = folder.join("bin").join(self.program).with_extension(std::env::consts::EXE_EXTENSION);
        for program in [PathBuf::from(self.program), own.clone()] {
            if self.fits(&program) {
                return Ok(program);
            }
        }
        if let Some(program) = self.wheel.and_then(|wheel| self.by_wheel(wheel, &folder)) {
            return Ok(program);
        }
        // Unoptimised: each runs for a second and would take minutes to optimise. A registry that is behind may lack
        // the locked dependency versions; the version of the program itself stays the same.
        let built = self.install(&folder, &["--locked"]).or_else(|_| self.install(&folder, &[]));
        built?;
        if self.fits(&own) { Ok(own) } else { Err(format!("{} does not run", own.display()).into()) }
    }

    fn install(&self, folder: &Path, flags: &[&str]) -> Result<(), Failure> {
        run(cargo()
            .arg("install")
            .args(flags)
            .args(["--force", "--root"])
            .arg(folder)
            .arg(format!("{}@{}", self.package, self.version))
            .env("CARGO_TARGET_DIR", folder.join("build"))
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0")
            .env("CARGO_PROFILE_RELEASE_LTO", "off")
            .env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16")
            .env("CARGO_PROFILE_RELEASE_DEBUG", "0"))
    }

    /// `None` if there is no Python, no network, or no wheel for this machine.
    fn by_wheel(&self, wheel: &str, folder: &Path) -> Option<PathBuf> {
        let programs = python::environment(&folder.join("venv")).ok()?;
        let program = programs.join(self.program).with_extension(std::env::consts::EXE_EXTENSION);
        if !self.fits(&program) {
            let package = format!("{wheel}=={}", self.version);
            python::install(&programs, ["--only-binary", ":all:", &package]).ok()?;
        }
        self.fits(&program).then_some(program)
    }

    fn fits(&self, program: &PathBuf) -> bool {
        command(program).arg("--version").output().is_ok_and(|output| {
            let said = String::from_utf8_lossy(&output.stdout);
            output.status.success() && said.split_whitespace().last() == Some(self.version)
        })
    }
}

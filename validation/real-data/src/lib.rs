//! Measured files that are no part of the repository, and tests that need them.
//!
//! The folder is the one named by `SLIPFIT_REAL_DATA`, by default `../shared/data` beside the
//! workspace. Where it is missing, tests listed in [`tests!`] are reported as ignored: by
//! `cargo test`, by nextest as skipped, and with their number by `cargo xtask check`.
//!
//! A file of such tests has `harness = false` in the manifest and plain functions:
//!
//! ```no_run
//! # use slipfit_real_data as slipfit_real_data;
//! slipfit_real_data::tests! { the_bell_is_read }
//!
//! fn the_bell_is_read() {
//!     let bell = slipfit_real_data::path("ringdown/bell_440hz.wav");
//!     assert!(bell.is_file());
//! }
//! ```

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

/// Where the measured files are, whether they exist or not.
pub fn folder() -> PathBuf {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A relative path counts from the workspace.
    let named = std::env::var_os("SLIPFIT_REAL_DATA");
    workspace.join(named.unwrap_or_else(|| "../shared/data".into()))
}

/// A file or folder of the measured data.
///
/// # Panics
/// When it does not exist: the data are there, so the test must run.
pub fn path(name: &str) -> PathBuf {
    let path = folder().join(name);
    assert!(path.exists(), "the measured data lack {}", path.display());
    path
}

/// Runs tests by name as `cargo test` and nextest expect; ignores them where there are no data.
pub fn run(tests: &[(&str, fn())]) -> ExitCode {
    let missing = !folder().is_dir();
    let trial = |&(name, test): &(&str, fn())| {
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(missing)
    };
    libtest_mimic::run(&Arguments::from_args(), tests.iter().map(trial).collect()).exit_code()
}

/// The `main` of a file of tests that need measured files. A function left out is reported by the
/// compiler as never used.
#[macro_export]
macro_rules! tests {
    ($($name:ident),+ $(,)?) => {
        fn main() -> ::std::process::ExitCode {
            $crate::run(&[$((stringify!($name), $name as fn())),+])
        }
    };
}

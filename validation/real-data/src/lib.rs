//! Measured files that are not part of the repository, and tests that need them.
//!
//! The folder is the one named by `SLIPFIT_REAL_DATA`, by default `../shared/data` next to the workspace. If it is
//! missing, the tests listed in [`tests!`] are reported as ignored by `cargo test` and as skipped by nextest;
//! `cargo xtask check` reports their number.
//!
//! A file of such tests has `harness = false` in the manifest and contains plain functions:
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

/// Folder of the measured files, whether it exists or not.
pub fn folder() -> PathBuf {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A relative path is taken relative to the workspace.
    let named = std::env::var_os("SLIPFIT_REAL_DATA");
    workspace.join(named.unwrap_or_else(|| "../shared/data".into()))
}

/// A file or folder of the measured data.
///
/// # Panics
/// If the file or folder does not exist: the data folder is present, so the test must run.
pub fn path(name: &str) -> PathBuf {
    let path = folder().join(name);
    assert!(path.exists(), "the measured data lack {}", path.display());
    path
}

/// Runs tests by name as `cargo test` and nextest expect; ignores them if there are no data.
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

/// The `main` of a file of tests that need measured files. A function missing from the list is reported by the
/// compiler as never used.
#[macro_export]
macro_rules! tests {
    ($($name:ident),+ $(,)?) => {
        fn main() -> ::std::process::ExitCode {
            $crate::run(&[$((stringify!($name), $name as fn())),+])
        }
    };
}

//! The commit this was built from, where that can be known without asking a network.

use std::path::Path;
use std::process::Command;

/// Where this crate lies in its own repository. A copy inside another one, vendored
/// perhaps, must not take that one's commit for its own.
const PLACE: &str = "crates/slipfit-cli/";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if let Some(commit) = packaged().or_else(checked_out) {
        println!("cargo:rustc-env=SLIPFIT_COMMIT={commit}");
    }
}

/// From the note that `cargo package` leaves beside the manifest.
fn packaged() -> Option<String> {
    let note = Path::new(&std::env::var_os("CARGO_MANIFEST_DIR")?).join(".cargo_vcs_info.json");
    // Named only where it exists: a missing file would make every build run this again.
    let text = std::fs::read_to_string(&note).ok()?;
    println!("cargo:rerun-if-changed={}", note.display());
    let after = text.split_once("\"sha1\"")?.1;
    short(after.split('"').nth(1)?)
}

/// From the repository around this crate.
fn checked_out() -> Option<String> {
    if git(&["rev-parse", "--show-prefix"])? != PLACE {
        return None;
    }
    // The log of HEAD grows with every commit, checkout and reset. Where it is switched off,
    // HEAD and the branches move instead.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]);
    let watched: &[&str] = match log.filter(|log| Path::new(log).is_file()) {
        Some(_) => &["HEAD", "logs/HEAD"],
        None => &["HEAD", "refs/heads", "packed-refs"],
    };
    for name in watched {
        if let Some(path) = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists()) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    short(&git(&["rev-parse", "HEAD"])?)
}

fn short(commit: &str) -> Option<String> {
    (commit.len() >= 12 && commit.bytes().all(|b| b.is_ascii_hexdigit())).then(|| commit[..12].to_owned())
}

/// A word from git, started in this crate's folder; none where it, or a repository, is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}

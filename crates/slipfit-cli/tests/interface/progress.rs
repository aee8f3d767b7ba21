//! A progress bar while a large file is read: shown on a terminal only.

use crate::common::slipfit;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A record of some 34 MB.
fn large() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("t (s),x (rad)\n");
    for i in 0..1_900_000 {
        let t = 1e-4 * f64::from(i);
        // The cosine repeats, so that writing the file does not take longer than reading it.
        let phase = f64::from(i % 7850) * std::f64::consts::TAU / 7850.0;
        writeln!(text, "{t:.4},{:.6}", 0.3 * (-0.02 * t).exp() * phase.cos()).unwrap();
    }
    assert!(text.len() > 32 << 20);
    std::fs::write(folder.path().join("large.csv"), text).unwrap();
    folder
}

/// The output on a terminal; `None` if there is none.
fn on_a_terminal(folder: &Path, line: &str) -> Option<String> {
    let command = format!("{} {line}", assert_cmd::cargo::cargo_bin!("slipfit").display());
    let mut script = Command::new("script");
    script.current_dir(folder).args(["-qec", &command, "/dev/null"]);
    // Other systems have another `script` command, or none.
    let output = script.output().ok().filter(|_| cfg!(target_os = "linux"))?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Noise in many sweeps, in which the search for a resonance continues to its limit.
#[test]
fn a_long_series_and_a_map_show_that_they_are_at_work() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 1u64;
    let mut manifest = String::new();
    for n in 0..96 {
        let mut text = String::from("frequency (Hz),amplitude (V)\n");
        for i in 0..400 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let noise = (state >> 11) as f64 / (1u64 << 53) as f64;
            writeln!(text, "{},{}", 10.0 + 0.05 * f64::from(i), noise + 1e-3).unwrap();
        }
        std::fs::write(folder.path().join(format!("{n}.csv")), text).unwrap();
        writeln!(manifest, "[[measurement]]\nsweep = \"{n}.csv\"\ncondition = \"{n}\"").unwrap();
    }
    std::fs::write(folder.path().join("all.toml"), manifest).unwrap();
    if let Some(seen) = on_a_terminal(folder.path(), "series all.toml") {
        assert!(seen.contains("analysing, "), "{seen:.400}");
    }
    if let Some(seen) = on_a_terminal(folder.path(), "series all.toml --quiet") {
        assert!(!seen.contains("analysing"), "{seen:.400}");
    }
    let stack = crate::common::root().join("validation/reference/maps/stack.npy");
    if let Some(seen) = on_a_terminal(folder.path(), &format!("map {} --dt 0.02", stack.display())) {
        assert!(seen.contains("/6 pixels, "), "{seen:.400}");
    }
    let output = slipfit().current_dir(folder.path()).args(["series", "all.toml"]).output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("analysing"));
}

#[test]
fn a_large_file_has_a_bar_on_a_terminal_and_nowhere_else() {
    let folder = large();
    let output = slipfit().current_dir(folder.path()).args(["ringdown", "large.csv"]).output().unwrap();
    assert!(output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.lines().all(|line| line.starts_with("warning:") || line.starts_with("         ")), "{said}");
    let on_a_terminal = |flags: &str| on_a_terminal(folder.path(), &format!("ringdown large.csv {flags}"));
    if let Some(seen) = on_a_terminal("") {
        assert!(seen.contains(" MiB, "), "{seen:.400}");
        assert!(seen.contains(" left"), "{seen:.400}");
        assert!(seen.contains("decay rate"), "the report follows: {seen:.400}");
    }
    if let Some(seen) = on_a_terminal("--quiet") {
        assert_eq!(seen, "");
    }
}

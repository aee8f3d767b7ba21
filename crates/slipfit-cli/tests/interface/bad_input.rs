//! Input that is not a table: distinguished by kind, status 2, no panic.

use crate::common::slipfit;
use std::fs;

/// The message for a file that the command must refuse.
fn refusal(name: &str, prepare: impl Fn(&std::path::Path)) -> String {
    let folder = tempfile::tempdir().unwrap();
    prepare(&folder.path().join(name));
    let output =
        slipfit().current_dir(folder.path()).args(["ringdown", name, "--json", "-"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.starts_with("error: "), "{said}");
    assert!(said.contains(name), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn a_folder_is_no_file() {
    refusal("folder.csv", |path| fs::create_dir(path).unwrap());
}

#[test]
fn a_known_format_is_named_whatever_the_ending() {
    let said = refusal("packed.csv", |path| fs::write(path, b"\x1f\x8b\x08\0 packed").unwrap());
    assert!(said.contains("gzip"), "{said}");
}

#[test]
fn a_sound_cut_off_in_its_header_is_refused() {
    refusal("cut.wav", |path| fs::write(path, b"RIFF\x24\0\0\0WAVEfmt \x10\0").unwrap());
}

#[test]
fn numbers_beyond_reach_are_refused_with_the_value() {
    let rows: String = (0..100).map(|i| format!("{i},{:e}\n", 1e250 * f64::from(i).cos())).collect();
    let said = refusal("huge.csv", |path| fs::write(path, format!("t (s),x (m)\n{rows}")).unwrap());
    let words: Vec<&str> = said.split_whitespace().collect();
    assert!(words.join(" ").contains("choose another unit"), "{said}");
}

#[test]
fn amplitudes_that_nobody_called_so_name_the_flag() {
    let rows: String =
        (0..400).map(|i| format!("{},{:.6}\n", 0.05 * f64::from(i), (-0.01 * f64::from(i)).exp())).collect();
    let text = format!("t (s),x (m)\n{rows}");
    let said = refusal("swing.csv", |path| fs::write(path, &text).unwrap());
    let words: Vec<&str> = said.split_whitespace().collect();
    assert!(words.join(" ").contains("hint: --kind envelope takes them as amplitudes"), "{said}");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("swing.csv"), &text).unwrap();
    let mut command = slipfit();
    command.current_dir(folder.path()).args(["ringdown", "swing.csv", "--kind", "envelope"]);
    assert_eq!(command.output().unwrap().status.code(), Some(0));
}

//! `slipfit inspect`: what files of several formats hold.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod common;

use common::{root, slipfit, stdout};

/// What the command says of a fixture, from within its folder.
fn inspected(arguments: &[&str]) -> String {
    let folder = root().join("validation/reference/formats");
    stdout(slipfit().current_dir(folder).arg("inspect").args(arguments))
}

#[test]
fn a_file_is_shown_with_its_tables_clock_plot_and_command() {
    insta::assert_snapshot!("inspect_text", inspected(&["capstone.csv", "--run", "2"]));
    insta::assert_snapshot!("inspect_sheets", inspected(&["sheets.xlsx"]));
    insta::assert_snapshot!("inspect_ticks", inspected(&["labone.csv"]));
    insta::assert_snapshot!("inspect_variables", inspected(&["groups.h5"]));
    insta::assert_snapshot!("inspect_sweep", inspected(&["sweep.s1p"]));
    insta::assert_snapshot!("inspect_sound_free_rate", inspected(&["integers.mat"]));
}

#[test]
fn every_line_fits_the_screen_and_the_command_given_works() {
    let folder = root().join("validation/reference/formats");
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.ends_with(".py") || name.ends_with(".md") {
            continue;
        }
        let text = inspected(&[&name]);
        let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
        assert!(wide.is_empty(), "{name}: {wide:#?}");
        let command = text.lines().last().unwrap().strip_prefix("> slipfit ").unwrap();
        // Of these the command asks for what is missing; sweeps have a command of their own.
        let missing =
            ["labone.csv", "groups.h5", "cells.mat", "integers.mat", "half.npy", "stamps_gaps.parquet"];
        if command.starts_with("ringdown") && !missing.contains(&name.as_str()) {
            stdout(slipfit().current_dir(&folder).args(command.split(' ')));
        }
    }
}

#[test]
fn a_file_that_is_no_table_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.txt"), "no numbers here\n").unwrap();
    let output = slipfit().current_dir(folder.path()).args(["inspect", "notes.txt"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().starts_with("error: notes.txt: no table"));
}

#[test]
fn the_command_given_is_one_a_shell_takes() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String =
        (0..300).map(|i| 0.1 * f64::from(i)).map(|t| format!("{t:.1},{}\n", (3.0 * t).cos())).collect();
    for (name, typed) in [("--odd.csv", "./--odd.csv"), ("a$b.csv", "'a$b.csv'"), ("a b.csv", "\"a b.csv\"")]
    {
        std::fs::write(folder.path().join(name), format!("t (s),x (mm)\n{rows}")).unwrap();
        let text = stdout(slipfit().current_dir(folder.path()).args(["inspect", "--", name]));
        assert!(text.ends_with(&format!("\n> slipfit ringdown {typed}\n")), "{text}");
    }
    let output = slipfit().current_dir(folder.path()).args(["inspect", "."]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("hint: slipfit resonance . reads"), "{said}");
}

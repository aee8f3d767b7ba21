//! `slipfit inspect`: what files of several formats hold.

use crate::common::{root, slipfit, stdout};

/// The output of the command for a fixture, run in its folder.
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
        // For these the command asks for what is missing; sweeps have their own command.
        let missing = ["labone.csv", "groups.h5", "cells.mat", "half.npy", "stamps_gaps.parquet"];
        if command.starts_with("ringdown") && !missing.contains(&name.as_str()) {
            stdout(slipfit().current_dir(&folder).args(command.split(' ')));
        }
    }
}

#[test]
fn a_file_that_is_no_table_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let output = slipfit().arg("inspect").arg(folder.path()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("slipfit ringdown ") && said.contains("resonance "), "{said}");
    std::fs::write(folder.path().join("notes.txt"), "no numbers here\n").unwrap();
    let output = slipfit().current_dir(folder.path()).args(["inspect", "notes.txt"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().starts_with("error: notes.txt: no table"));
}

#[test]
fn a_manifest_is_no_table_and_the_hint_names_the_command_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = "title = \"Swings\"\n\n[[measurement]]\nringdown = \"swing.csv\"\n";
    for (name, is_manifest) in [("series.toml", true), ("series.txt", false)] {
        std::fs::write(folder.path().join(name), manifest).unwrap();
        let output = slipfit().current_dir(folder.path()).args(["inspect", name]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("no table of numbers"), "{said}");
        assert_eq!(said.contains("hint: slipfit series series.toml reads"), is_manifest, "{said}");
    }
}

/// These columns have no names: their values decide what they are, without a fit.
#[test]
fn numbers_without_names_are_told_apart_by_what_they_do() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |x: &dyn Fn(f64) -> f64, from: f64| -> String {
        (0..400).map(|i| from + 0.01 * f64::from(i)).map(|t| format!("{t:.2} {:.6}\n", x(t))).collect()
    };
    let swing = |t: f64| (-0.3 * t).exp() * (12.0 * t).cos();
    let peak = |f: f64| 1.0 / ((f - 9.0).powi(2) + 0.01).sqrt();
    let drift = |t: f64| 20.0 + 0.1 * t - 0.02 * t * t;
    for (name, text, verb, said) in [
        ("swing.txt", rows(&swing, 0.0), "ringdown", "15 crossings of the middle, period about 0.53 s"),
        ("peak.txt", rows(&peak, 7.0), "resonance", "400 points between 7 Hz and 10.99 Hz"),
        ("drift.txt", rows(&drift, 0.0), "ringdown", "hardly an oscillation"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
        let text = stdout(slipfit().current_dir(folder.path()).args(["inspect", name]));
        assert!(text.ends_with(&format!("\n> slipfit {verb} {name}\n")), "{text}");
        assert!(text.contains(said), "{text}");
    }
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
    assert!(
        said.contains("slipfit ringdown . makes") && said.contains("slipfit resonance . reads"),
        "{said}"
    );
}

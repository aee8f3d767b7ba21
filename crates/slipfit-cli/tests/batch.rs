//! Many files at once: every file its row, none lost when the run is cut off.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod common;

use common::{slipfit, stdout};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A folder of swings, each with a damping of its own.
fn folder(files: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for n in 0..files {
        let mut text = String::from("Time (s),Angle (rad)\n");
        let rate = 0.02 + 0.001 * f64::from(n);
        for i in 0..1500 {
            let t = 0.02 * f64::from(i);
            let noise = 1e-3 * (7.7 * f64::from(i * i + n)).sin();
            text += &format!("{t:.2},{:.5}\n", 0.3 * (-rate * t).exp() * (8.0 * t).cos() + noise);
        }
        fs::write(folder.path().join(format!("run{n:02}.csv")), text).unwrap();
    }
    folder
}

fn names(files: u32) -> Vec<String> {
    (0..files).map(|n| format!("run{n:02}.csv")).collect()
}

fn rows(path: &Path) -> Vec<serde_json::Value> {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_bad_file_keeps_its_row_and_stops_nobody() {
    let folder = folder(3);
    fs::write(folder.path().join("bad.csv"), "no numbers\n").unwrap();
    let output = slipfit()
        .current_dir(folder.path())
        .args([
            "ringdown",
            "run00.csv",
            "bad.csv",
            "run01.csv",
            "missing.csv",
            "run02.csv",
            "--table",
            "out.json",
        ])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("5 files") && said.contains("2 failed; out.json"), "{said}");
    let rows = rows(&folder.path().join("out.json"));
    let of = |key: &str| rows.iter().map(|r| r[key].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(of("file"), ["run00.csv", "bad.csv", "run01.csv", "missing.csv", "run02.csv"]);
    assert_eq!((of("status")[1].as_str(), of("status")[3].as_str()), ("failed", "failed"));
    assert!(of("reason")[1].contains("no table of numbers"), "{:?}", of("reason"));
    let rate = rows[2]["decay_rate_per_s"].as_f64().unwrap();
    assert!((rate / 0.021 - 1.0).abs() < 0.1, "{rate}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "only the table is left behind");
}

#[test]
fn a_table_comes_in_every_form() {
    let folder = folder(2);
    for ending in ["csv", "md", "tex", "json"] {
        let table = format!("out.{ending}");
        stdout(slipfit().current_dir(folder.path()).args([
            "ringdown",
            "run00.csv",
            "run01.csv",
            "--table",
            &table,
        ]));
        let text = fs::read_to_string(folder.path().join(&table)).unwrap();
        assert!(text.contains("run00.csv") && text.contains("run01.csv"), "{ending}: {text}");
    }
    let shown = stdout(slipfit().current_dir(folder.path()).args(["ringdown", "run00.csv", "run01.csv"]));
    assert!(shown.starts_with("| file | status |") && shown.lines().count() == 4, "{shown}");
    let mut refused = slipfit();
    let output =
        refused.current_dir(folder.path()).args(["ringdown", "run00.csv", "--table", "out.doc"]).output();
    assert_eq!(output.unwrap().status.code(), Some(2));
}

#[test]
fn nothing_but_failures_is_a_failure_and_doubts_count_under_strict() {
    let folder = folder(1);
    fs::write(folder.path().join("bad.csv"), "no numbers\n").unwrap();
    let status = |arguments: &[&str]| {
        slipfit().current_dir(folder.path()).arg("ringdown").args(arguments).output().unwrap().status.code()
    };
    assert_eq!(status(&["bad.csv", "bad.csv"]), Some(2));
    assert_eq!(status(&["bad.csv", "run00.csv", "--strict"]), Some(1));
    assert_eq!(status(&["bad.csv", "run00.csv"]), Some(0));
}

/// Kills a run at so many moments, goes on after each, and compares the end
/// with a run that nothing disturbed.
fn kill_and_resume(files: u32, moments: u64) {
    let folder = folder(files);
    let names = names(files);
    let whole = |table: &str| {
        stdout(slipfit().current_dir(folder.path()).arg("ringdown").args(&names).args(["--table", table]));
        fs::read(folder.path().join(table)).unwrap()
    };
    let undisturbed = whole("whole.csv");
    let journal = folder.path().join("cut.csv.rows");
    let finished = || {
        let text = fs::read_to_string(&journal).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    let mut before: Vec<String> = Vec::new();
    for moment in 0..moments {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"))
            .current_dir(folder.path())
            .arg("ringdown")
            .args(&names)
            .args(["--table", "cut.csv", "--resume"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(3 + moment * 37 % 90));
        let _ = child.kill();
        child.wait().unwrap();
        if !journal.exists() {
            // It was done before it could be killed: begin again.
            before.clear();
            continue;
        }
        let after = finished();
        assert!(before.iter().all(|row| after.contains(row)), "a finished row was lost at moment {moment}");
        before = after;
    }
    stdout(
        slipfit()
            .current_dir(folder.path())
            .arg("ringdown")
            .args(&names)
            .args(["--table", "cut.csv", "--resume"]),
    );
    assert_eq!(fs::read(folder.path().join("cut.csv")).unwrap(), undisturbed);
    assert!(!journal.exists());
}

#[test]
fn a_killed_run_loses_no_row_and_goes_on_to_the_same_table() {
    kill_and_resume(24, 5);
}

#[test]
#[ignore = "a measurement: 500 files, 50 kills"]
fn fifty_kills_lose_no_row() {
    kill_and_resume(500, 50);
}

#[test]
fn a_table_is_not_gone_on_with_by_other_options() {
    let folder = folder(2);
    fs::write(folder.path().join("out.csv.rows"), "slipfit 0.0.1 ringdown --model viscous\n").unwrap();
    let output = slipfit()
        .current_dir(folder.path())
        .args(["ringdown", "run00.csv", "run01.csv", "--table", "out.csv", "--resume"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("was begun by"));
}

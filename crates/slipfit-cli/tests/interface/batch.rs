//! Many files at once: each file gets its row, and none is lost when the run is killed.

use crate::common::{slipfit, stdout};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A folder of swings, each with its own damping.
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
        fs::write(folder.path().join(format!("run{n:03}.csv")), text).unwrap();
    }
    folder
}

fn names(files: u32) -> Vec<String> {
    (0..files).map(|n| format!("run{n:03}.csv")).collect()
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
            "run000.csv",
            "bad.csv",
            "run001.csv",
            "missing.csv",
            "run002.csv",
            "--table",
            "out.json",
        ])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("5 files"), "{said}");
    assert!(said.contains("2 failed; out.json"), "{said}");
    let rows = rows(&folder.path().join("out.json"));
    let of = |key: &str| rows.iter().map(|r| r[key].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(of("file"), ["run000.csv", "bad.csv", "run001.csv", "missing.csv", "run002.csv"]);
    assert_eq!((of("status")[1].as_str(), of("status")[3].as_str()), ("failed", "failed"));
    assert!(of("reason")[1].contains("no table of numbers"), "{:?}", of("reason"));
    let rate = rows[2]["decay_rate_per_s"].as_f64().unwrap();
    assert!((rate / 0.021 - 1.0).abs() < 0.1, "{rate}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "only the table is left behind");
}

#[test]
fn a_table_comes_in_every_form() {
    let folder = folder(2);
    for ending in ["csv", "md", "tex", "json", "parquet"] {
        let table = format!("out.{ending}");
        stdout(slipfit().current_dir(folder.path()).args([
            "ringdown",
            "run000.csv",
            "run001.csv",
            "--table",
            &table,
        ]));
        let bytes = fs::read(folder.path().join(&table)).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("run000.csv"), "{ending}: {text}");
        assert!(text.contains("run001.csv"), "{ending}: {text}");
    }
    let shown = stdout(slipfit().current_dir(folder.path()).args(["ringdown", "run000.csv", "run001.csv"]));
    assert!(shown.starts_with("| file | status |"), "{shown}");
    assert!(shown.lines().count() == 4, "{shown}");
    let mut refused = slipfit();
    let output =
        refused.current_dir(folder.path()).args(["ringdown", "run000.csv", "--table", "out.doc"]).output();
    assert_eq!(output.unwrap().status.code(), Some(2));
}

#[test]
fn friction_of_an_accelerometer_is_a_displacement() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("Time (s),Acceleration (m/s^2)\n");
    for i in 0..1500 {
        let t = 0.02 * f64::from(i);
        text += &format!(
            "{t:.2},{:.5}\n",
            20.0 * (-0.05 * t).exp() * (8.0 * t).cos() + 0.1 * (7.7 * f64::from(i * i)).sin()
        );
    }
    fs::write(folder.path().join("a.csv"), &text).unwrap();
    fs::write(folder.path().join("b.csv"), &text).unwrap();
    for table in ["out.json", "out.md"] {
        let arguments = ["ringdown", "a.csv", "b.csv", "--table", table];
        let output = slipfit().current_dir(folder.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    let rows = rows(&folder.path().join("out.json"));
    assert_eq!(rows[0]["unit"], "m/s^2");
    assert_eq!(rows[0]["friction_unit"], "m");
    let page = fs::read_to_string(folder.path().join("out.md")).unwrap();
    assert!(!page.contains("/s^2"), "{page}");
}

#[test]
fn nothing_but_failures_is_a_failure_and_doubts_count_under_strict() {
    let folder = folder(1);
    fs::write(folder.path().join("bad.csv"), "no numbers\n").unwrap();
    let status = |arguments: &[&str]| {
        slipfit().current_dir(folder.path()).arg("ringdown").args(arguments).output().unwrap().status.code()
    };
    assert_eq!(status(&["bad.csv", "bad.csv"]), Some(2));
    assert_eq!(status(&["bad.csv", "run000.csv", "--strict"]), Some(1));
    assert_eq!(status(&["bad.csv", "run000.csv"]), Some(0));
}

/// Kills a run at `moments` random times, resumes after each, and compares the result with an undisturbed run.
/// Returns the rows kept after each kill that hit a run.
fn kill_and_resume(files: u32, moments: u32) -> Vec<usize> {
    let folder = folder(files);
    let names = names(files);
    let begun = Instant::now();
    stdout(slipfit().current_dir(folder.path()).arg("ringdown").args(&names).args(["--table", "whole.csv"]));
    // On average the kills are spaced such that the last one comes near the end.
    let apart_s = begun.elapsed().as_secs_f64() / f64::from(moments);
    let undisturbed = fs::read(folder.path().join("whole.csv")).unwrap();
    let journal = folder.path().join("cut.csv.rows");
    let finished = || {
        let text = fs::read_to_string(&journal).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    let mut before: Vec<String> = Vec::new();
    let mut kept = Vec::new();
    let mut state = 12_345_u64;
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
        // Knuth's generator, for the same times in every run.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (state >> 11) as f64 / (1_u64 << 53) as f64;
        std::thread::sleep(Duration::from_secs_f64(0.004 + 2.0 * share * apart_s));
        let _ = child.kill();
        child.wait().unwrap();
        if !journal.exists() {
            // It finished before it could be killed: begin again.
            before.clear();
            continue;
        }
        let after = finished();
        assert!(before.iter().all(|row| after.contains(row)), "a finished row was lost at moment {moment}");
        kept.push(after.len());
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
    kept
}

#[test]
fn a_killed_run_loses_no_row_and_goes_on_to_the_same_table() {
    kill_and_resume(24, 5);
}

#[test]
#[ignore = "a measurement: 500 files, 75 kills"]
#[allow(clippy::print_stdout, reason = "the figures are what it is for")]
fn seventy_five_kills_lose_no_row() {
    let kept = kill_and_resume(500, 75);
    println!("{} of 75 kills hit a run; rows kept after each: {kept:?}", kept.len());
    assert!(kept.len() >= 60, "too few kills hit: {kept:?}");
}

#[test]
fn a_table_is_not_gone_on_with_by_other_options() {
    let folder = folder(2);
    fs::write(folder.path().join("out.csv.rows"), "slipfit 0.0.1 ringdown --model viscous\n").unwrap();
    let output = slipfit()
        .current_dir(folder.path())
        .args(["ringdown", "run000.csv", "run001.csv", "--table", "out.csv", "--resume"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("was begun by"));
}

#[test]
fn a_parquet_table_holds_what_json_does() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let folder = folder(3);
    fs::write(folder.path().join("bad.csv"), "no numbers\n").unwrap();
    let table = |name: &str| {
        let files = ["run000.csv", "bad.csv", "run001.csv", "run002.csv"];
        stdout(slipfit().current_dir(folder.path()).arg("ringdown").args(files).args(["--table", name]));
        folder.path().join(name)
    };
    let json = rows(&table("out.json"));
    let reader = SerializedFileReader::new(fs::File::open(table("out.parquet")).unwrap()).unwrap();
    let mut seen = 0;
    for (row, json) in reader.get_row_iter(None).unwrap().zip(&json) {
        let row = row.unwrap();
        let mut keys: Vec<&String> = row.get_column_iter().map(|(name, _)| name).collect();
        keys.sort();
        assert_eq!(keys, json.as_object().unwrap().keys().collect::<Vec<_>>());
        for (name, field) in row.get_column_iter() {
            let held = match field {
                Field::Null => serde_json::Value::Null,
                Field::Str(text) => text.as_str().into(),
                Field::Double(v) => (*v).into(),
                Field::Long(v) => (*v).into(),
                Field::Bool(v) => (*v).into(),
                other => panic!("{name}: {other}"),
            };
            assert_eq!(held, json[name], "{name}");
            seen += 1;
        }
    }
    assert_eq!(seen, 4 * 25);
}

/// Curves of one resonator at three frictions, with the reference they share.
fn curves() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, x_f) in [("free", "0"), ("a", "0.02"), ("b", "0.05"), ("c", "0.08")] {
        let base = ["simulate", "sweep", "--frequency-hz", "100", "--q", "60", "--drive-amplitude", "0.3"];
        let rest =
            ["--start-hz", "97", "--stop-hz", "103", "--points", "61", "--noise-rms", "0.01", "--seed", "3"];
        let file = format!("{name}.csv");
        stdout(slipfit().current_dir(folder.path()).args(base).args(rest).args([
            "--friction-displacement",
            x_f,
            "--out",
            &file,
        ]));
    }
    folder
}

#[test]
fn curves_make_a_table_as_ring_downs_do() {
    let folder = curves();
    fs::write(folder.path().join("bad.csv"), "no numbers\n").unwrap();
    let files = ["a.csv", "bad.csv", "b.csv", "c.csv"];
    let mut command = slipfit();
    command.current_dir(folder.path()).arg("resonance").args(files);
    stdout(command.args(["--reference", "free.csv", "--table", "out.json", "--plot", "out.svg"]));
    let rows = rows(&folder.path().join("out.json"));
    assert_eq!(rows.len(), 4);
    assert_eq!(rows[1]["status"], "failed");
    for (row, x_f) in [(&rows[0], 0.02), (&rows[2], 0.05), (&rows[3], 0.08)] {
        let [low, high] = ["friction_displacement_low", "friction_displacement_high"]
            .map(|name| row[name].as_f64().unwrap());
        // Two interval widths: three of three within the 95 % interval would fail once in seven.
        let slack = 0.5 * (high - low);
        assert!((low - slack..high + slack).contains(&x_f), "{x_f}: {low} to {high}");
        assert_eq!(row["drive_source"], "reference");
    }
    let alone: serde_json::Value =
        serde_json::from_str(&stdout(slipfit().current_dir(folder.path()).args([
            "resonance",
            "b.csv",
            "--reference",
            "free.csv",
            "--json",
            "-",
        ])))
        .unwrap();
    let share = alone["sliding"]["share_at_peak"].as_f64();
    assert_eq!(rows[2]["sliding_share_at_peak"].as_f64(), share, "the same as the file alone");
    let picture = fs::read_to_string(folder.path().join("out.svg")).unwrap();
    for word in ["friction displacement", "decay rate", "sliding share", "file c.csv", "1 failed"] {
        assert!(picture.contains(word), "{word}");
    }
}

#[test]
fn a_picture_across_ring_downs_names_every_file() {
    let folder = folder(4);
    let mut command = slipfit();
    command.current_dir(folder.path()).arg("ringdown").args(names(4));
    stdout(command.args(["--table", "out.csv", "--plot", "out.svg"]));
    let picture = fs::read_to_string(folder.path().join("out.svg")).unwrap();
    for name in names(4) {
        assert!(picture.contains(&format!("<title>file {name}\n")), "{name}");
    }
}

/// An interrupt between two files of a long run leaves a valid table of what is done.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_valid_table_to_go_on_with() {
    const FILES: u32 = 300;
    let folder = folder(FILES);
    let start = || {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"));
        command.current_dir(folder.path()).arg("ringdown").args(names(FILES));
        command.args(["--table", "cut.csv", "--resume"]).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    let mut child = start();
    let journal = folder.path().join("cut.csv.rows");
    // After some rows are done, the handler is in place and most rows are still to come.
    while fs::read_to_string(&journal).unwrap_or_default().lines().count() < 10 {
        assert!(child.try_wait().unwrap().is_none(), "too quick to be interrupted");
        std::thread::sleep(Duration::from_millis(1));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut reader = csv::Reader::from_path(folder.path().join("cut.csv")).unwrap();
    let held: Vec<String> = reader.records().map(|r| r.unwrap()[0].to_owned()).collect();
    assert!((9..FILES as usize).contains(&held.len()), "{} rows", held.len());
    assert!(held.is_sorted(), "in the order of the files: {held:?}");
    let kept = fs::read_to_string(&journal).unwrap().lines().count() - 1;
    assert_eq!(kept, held.len(), "the journal has the same rows");
    assert!(start().wait().unwrap().success());
    assert_eq!(csv::Reader::from_path(folder.path().join("cut.csv")).unwrap().records().count(), 300);
    assert!(!journal.exists());
}

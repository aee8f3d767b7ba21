//! Sources of records: standard input, pipes, folders, and names that are hard to type.

use crate::common::{root, slipfit, stdout};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A swing at 1.25 Hz that loses 4 % per second.
fn swing() -> String {
    let row = |i: u32| {
        let t = 0.02 * f64::from(i);
        let noise = 1e-4 * (7.7 * f64::from(i * i)).sin();
        format!("{t:.2},{:.5}\n", 0.3 * (-0.04 * t).exp() * (2.5 * std::f64::consts::PI * t).cos() + noise)
    };
    String::from("Time (s),Angle (rad)\n") + &(0..1500).map(row).collect::<String>()
}

fn folder(names: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    names.iter().for_each(|name| fs::write(folder.path().join(name), swing()).unwrap());
    folder
}

/// The rows of a table written as JSON.
fn rows(path: &Path) -> Vec<serde_json::Value> {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn of(rows: &[serde_json::Value], key: &str) -> Vec<String> {
    rows.iter().map(|row| row[key].as_str().unwrap().to_owned()).collect()
}

/// The answer to the swing, with the hash of its bytes.
fn answer(json: &str) -> (f64, String) {
    let answer: serde_json::Value = serde_json::from_str(json).unwrap();
    let hash = answer["input"]["sha256"].as_str().unwrap().to_owned();
    (answer["parameters"]["frequency_hz"]["value"].as_f64().unwrap(), hash)
}

#[test]
fn standard_input_is_read_as_a_file_is() {
    let folder = folder(&["a.csv"]);
    let of_file = stdout(slipfit().current_dir(folder.path()).args(["ringdown", "a.csv", "--json", "-"]));
    let (frequency, hash) = answer(&of_file);
    assert!((frequency - 1.25).abs() < 1e-3, "{frequency}");
    for name in ["-", "/dev/stdin"] {
        if cfg!(windows) && name != "-" {
            continue;
        }
        let piped = stdout(slipfit().args(["ringdown", name, "--json", "-"]).write_stdin(swing()));
        assert_eq!(answer(&piped), (frequency, hash.clone()), "{name}");
        let shown = stdout(slipfit().args(["inspect", name]).write_stdin(swing()));
        assert!(shown.contains("1500 rows"), "{shown}");
        assert!(shown.contains("Time (s),Angle (rad)"), "{shown}");
        assert!(shown.contains(&format!("> slipfit ringdown {name}")), "{shown}");
    }
    // The same name is used wherever the file is mentioned.
    let noise: String = (0..400).map(|i| format!("{},{}\n", 0.01 * f64::from(i), (i * 7919) % 101)).collect();
    let refused =
        slipfit().args(["ringdown", "-"]).write_stdin(format!("t (s),x (m)\n{noise}")).output().unwrap();
    let said = [
        stdout(slipfit().args(["ringdown", "-"]).write_stdin(swing())),
        stdout(slipfit().args(["ringdown", "-", "--json", "-"]).write_stdin(swing())),
        stdout(slipfit().args(["ringdown", "-", "--csv", "-", "-q"]).write_stdin(swing())),
        stdout(slipfit().args(["inspect", "-"]).write_stdin(swing())),
        String::from_utf8(refused.stderr).unwrap(),
    ];
    for (i, text) in said.iter().enumerate() {
        assert!(text.contains("standard input"), "{i}: {text:.600}");
    }
    // A format that is read from several positions is held in memory.
    let workbook = fs::read(root().join("validation/reference/formats/snappy.parquet")).unwrap();
    let shown = stdout(slipfit().args(["inspect", "-"]).write_stdin(workbook));
    assert!(shown.contains("Parquet file"), "{shown}");
    assert!(shown.contains("400 rows"), "{shown}");
    let output = slipfit().args(["ringdown", "-"]).write_stdin("").output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("standard input: the file is empty"), "{said}");
}

#[test]
fn curves_and_levels_come_from_standard_input_too() {
    let sweep = "simulate sweep --frequency-hz 10 --q 50 --drive-amplitude 1 --start-hz 9 --stop-hz 11";
    let curve = stdout(slipfit().args(sweep.split(' ')));
    let shown = stdout(slipfit().args(["resonance", "-", "--drive-amplitude", "1"]).write_stdin(curve));
    assert!(shown.contains("quality factor"), "{shown}");
    let levels = "drive,amplitude\n1,0.8\n2,1.8\n3,2.8\n4,3.8\n5,4.8\n6,5.8\n";
    let output = slipfit().args(["levels", "-"]).write_stdin(levels).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(unix)]
#[test]
fn a_pipe_with_a_name_is_read_once() {
    for command in ["ringdown", "inspect"] {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("logger");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let written = pipe.clone();
        let writer = std::thread::spawn(move || fs::write(written, swing()).unwrap());
        let shown = stdout(slipfit().arg(command).arg(&pipe).timeout(std::time::Duration::from_secs(60)));
        writer.join().unwrap();
        let wanted = if command == "ringdown" { "1.250" } else { "period about 0.8 s" };
        assert!(shown.contains(wanted), "{shown}");
    }
}

#[test]
fn a_format_is_named_where_the_content_cannot_tell_it() {
    let folder = tempfile::tempdir().unwrap();
    // The first letters are those with which a sound file begins.
    fs::write(folder.path().join("a.txt"), format!("ID3 of the sensor\n{}", swing())).unwrap();
    let run = |arguments: &[&str]| slipfit().current_dir(folder.path()).args(arguments).output().unwrap();
    let refused = run(&["ringdown", "a.txt"]);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("MP3"), "{refused:?}");
    for name in ["text", "csv", ".TXT"] {
        let taken = run(&["ringdown", "a.txt", "--format", name]);
        assert!(taken.status.success(), "{taken:?}");
    }
    let broken = run(&["ringdown", "a.txt", "--format", "parquet"]);
    assert!(String::from_utf8_lossy(&broken.stderr).contains("cannot be read as"), "{broken:?}");
    let unknown = run(&["ringdown", "a.txt", "--format", "docx"]);
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("there are text, wav, mat"), "{unknown:?}");
}

#[test]
fn a_folder_gives_a_row_for_each_of_its_files() {
    let folder = folder(&["b.csv", "a.csv", "notes.md", ".hidden.csv"]);
    fs::create_dir(folder.path().join("inner")).unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    let out = tempfile::tempdir().unwrap();
    let table = out.path().join("out.json");
    let path = folder.path().to_str().unwrap();
    let names = |arguments: &[&str]| {
        let output = slipfit().arg("ringdown").args(arguments).arg("--table").arg(&table).output().unwrap();
        let rows = rows(&table);
        let last = |name: String| name.rsplit(['/', '\\']).next().unwrap().to_owned();
        let files: Vec<String> = of(&rows, "file").into_iter().map(last).collect();
        (files, of(&rows, "reason"), output.status.code())
    };
    assert_eq!(names(&[path]).0, ["a.csv", "b.csv", "notes.md"]);
    assert_eq!(names(&[path, "--glob", "*.csv"]).0, ["a.csv", "b.csv"]);
    assert_eq!(names(&[path, "--glob", "b*"]).0, ["b.csv"]);
    let (files, reasons, code) = names(&[path, "--glob", "*.txt"]);
    assert_eq!((files.len(), code), (1, Some(2)));
    assert!(reasons[0].contains("--glob *.txt: matches none of 3 files"), "{reasons:?}");
    let empty = folder.path().join("empty");
    let (files, reasons, code) = names(&[path, empty.to_str().unwrap(), "--glob", "*.csv"]);
    assert_eq!((files.len(), code), (3, Some(0)));
    assert!(reasons[2].contains("matches none of 0 files"), "{reasons:?}");
    let shown = stdout(slipfit().arg("ringdown").arg(path).args(["--glob", "a*"]));
    assert!(shown.starts_with("| file | status |"), "a folder gives a table, {shown}");
}

/// Without quotes the shell replaces the pattern by the first file, which is then left out of the table.
#[test]
fn a_pattern_without_a_folder_is_refused() {
    let folder = folder(&["a.csv", "b.csv"]);
    for files in [&["a.csv", "b.csv"][..], &["b.csv"]] {
        let output =
            slipfit().current_dir(folder.path()).args(["ringdown", "--glob", "a.csv"]).args(files).output();
        let output = output.unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{output:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        let start = "error: --glob a.csv: selects files in folders, and no folder is given\n  hint: ";
        assert!(said.starts_with(start), "{said}");
    }
    let output = slipfit().current_dir(folder.path()).args(["ringdown", "--glob", "*", "no.csv"]).output();
    let said = String::from_utf8(output.unwrap().stderr).unwrap();
    assert!(said.starts_with("error: no.csv: ") && !said.contains("--glob"), "{said}");
    // Together with a folder it applies to the files in it.
    let shown = stdout(slipfit().current_dir(folder.path()).args(["ringdown", ".", "b.csv", "--glob", "a*"]));
    assert_eq!(shown.matches(".csv |").count(), 2, "{shown}");
}

#[test]
fn a_band_of_amplitudes_has_a_note() {
    let folder = folder(&[]);
    let rows = (0..400).map(|i| 0.1 * f64::from(i)).map(|t| format!("{t:.1},{}\n", 3.0 * (-0.1 * t).exp()));
    fs::write(folder.path().join("a.csv"), format!("t (s),R (mV)\n{}", rows.collect::<String>())).unwrap();
    let arguments = ["ringdown", "a.csv", "--kind", "envelope", "--band", "1", "2"];
    let output = slipfit().current_dir(folder.path()).args(arguments).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("note: --band 1 2 has no effect on a record of amplitudes"), "{said}");
}

/// `--sheet` was refused for every text, although it chooses one of the tables below each other.
#[test]
fn a_table_of_a_text_is_chosen_by_its_number() {
    let folder = folder(&["a.csv"]);
    let path = folder.path().join("two.csv");
    fs::write(&path, swing() + "\n" + &swing().replace("Angle (rad)", "Position (mm)")).unwrap();
    let unit = |arguments: &[&str]| {
        let text = stdout(slipfit().arg("ringdown").arg(&path).args(arguments).args(["--json", "-"]));
        let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
        answer["parameters"]["friction_displacement"]["unit"].as_str().unwrap().to_owned()
    };
    assert_eq!([unit(&[]), unit(&["--sheet", "2"])], ["rad", "mm"]);
}

/// A lock-in of two equal outputs has a phase of 45 degrees, whatever the motion.
#[test]
fn options_without_effect_and_two_options_with_one_column_are_refused() {
    let folder = folder(&["a.csv"]);
    let levels = "drive (nm),amplitude (nm)\n1,1\n2,2\n3,3\n4,4\n5,5\n";
    fs::write(folder.path().join("levels.csv"), levels).unwrap();
    fs::write(folder.path().join("curve.csv"), "f (Hz),R (V),D (V)\n1,1,1\n2,3,1\n3,1,1\n").unwrap();
    for (arguments, expected) in [
        (
            "ringdown a.csv --signal 2 --quadrature angle",
            "a.csv: --quadrature angle: column 2 `Angle (rad)` is also the signal\n  hint: --quadrature names the Y",
        ),
        (
            "ringdown a.csv --rate-hz 50 --time-unit ms",
            "--time-unit ms: cannot be combined with a sampling rate\n",
        ),
        (
            "resonance curve.csv --kind envelope",
            "--kind envelope: the response of a curve is a displacement, a",
        ),
        ("resonance curve.csv --sheet x", "--sheet x: a text file has no sheets hint: --part"),
        (
            "ringdown a.csv --signal 2 --time 2",
            "a.csv: --time 2: column 2 `Angle (rad)` is also the signal\n",
        ),
        (
            "levels levels.csv --drive 2 --amplitude 2",
            "--amplitude 2: column 2 `amplitude (nm)` is also the drive\n",
        ),
        ("resonance curve.csv --real 2 --imaginary 2", "--imaginary 2: column 2 `R (V)` is also the real\n"),
        (
            "resonance curve.csv --amplitude 2 --drive R",
            "--drive R: column 2 `R (V)` is also the amplitude\n",
        ),
    ] {
        let output = slipfit().current_dir(folder.path()).args(arguments.split(' ')).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{arguments}: {said}");
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words(&said).contains(&words(expected)), "{arguments}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_a_row() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder(&["a.csv"]);
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).unwrap();
    // The superuser can read everything: then the folder is empty, which also gives a row.
    let superuser = fs::read_dir(&locked).is_ok();
    let table = folder.path().join("out.json");
    let output = slipfit()
        .current_dir(folder.path())
        .args(["ringdown", "locked", "a.csv", "--table"])
        .arg(&table)
        .output()
        .unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o700)).unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let rows = rows(&table);
    assert_eq!(of(&rows, "file"), ["locked", "a.csv"]);
    let wanted = if superuser { "contains no files" } else { "Permission denied" };
    assert!(of(&rows, "reason")[0].contains(wanted), "{:?}", of(&rows, "reason"));
    assert_ne!(of(&rows, "status")[1], "failed");
}

#[test]
fn the_same_file_twice_is_two_rows_also_when_resumed() {
    let folder = folder(&["a.csv", "b.csv"]);
    let run = |more: &[&str]| {
        let files = ["ringdown", "a.csv", "b.csv", "./a.csv", "a.csv", "--table", "out.json"];
        let output = slipfit().current_dir(folder.path()).args(files).args(more).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        of(&rows(&folder.path().join("out.json")), "file")
    };
    let twice = ["a.csv", "b.csv", "./a.csv", "a.csv"];
    assert_eq!(run(&[]), twice);
    assert_eq!(run(&["--resume"]), twice);
}

#[cfg(unix)]
#[test]
fn names_that_are_hard_to_type_are_rows_like_others() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};
    let folder = tempfile::tempdir().unwrap();
    let hostile: [&[u8]; 4] = [b"-start.csv", b"two\nlines.csv", b"latin\xe9.csv", b"a b'c\"d.csv"];
    for name in hostile {
        fs::write(folder.path().join(OsStr::from_bytes(name)), swing()).unwrap();
    }
    let table = folder.path().join("out.json");
    let run = |command: &mut assert_cmd::Command| {
        let output = command.current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        output
    };
    // After `--`, each name may be typed as it is.
    let typed = hostile.map(OsStr::from_bytes);
    run(slipfit().args(["ringdown", "--table"]).arg(&table).arg("--").args(typed));
    let listed = rows(&table);
    assert_eq!(of(&listed, "file"), ["-start.csv", "two\nlines.csv", "latin\u{fffd}.csv", "a b'c\"d.csv"]);
    assert!(of(&listed, "status").iter().all(|status| status != "failed"), "{listed:?}");
    // The same files by their folder, and in a format whose rows are lines.
    let csv = folder.path().join("out.csv");
    run(slipfit().args(["ringdown", ".", "--glob", "*s*.csv", "--table"]).arg(&csv));
    let text = fs::read_to_string(&csv).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(reader.records().map(Result::unwrap).count(), 2, "{text}");
    for name in typed {
        let shown = run(slipfit().args(["inspect", "--"]).arg(name)).stdout;
        assert!(String::from_utf8_lossy(&shown).contains("1500 rows"));
        run(slipfit().args(["ringdown", "--"]).arg(name));
    }
    let shown = String::from_utf8(run(slipfit().args(["inspect", "--", "-start.csv"])).stdout).unwrap();
    assert!(shown.contains("> slipfit ringdown ./-start.csv"), "{shown}");
}

/// Files of one swing under names that are hard to type, one missing and one without permission, by name, twice,
/// and by their folder: one row each, in the order given.
#[cfg(unix)]
fn many_rows(count: usize) -> (std::time::Duration, f64) {
    use std::{ffi::OsString, os::unix::ffi::OsStringExt as _, os::unix::fs::PermissionsExt as _};
    let folder = tempfile::tempdir().unwrap();
    let held = folder.path().join("held");
    fs::create_dir(&held).unwrap();
    let swing = swing();
    let name = |i: usize| {
        let mut name: Vec<u8> = [&b"-"[..], b"two\nlines", b"latin\xe9", b"=1+1;", b"run"][i % 5].to_vec();
        name.extend(format!("{i:05}.csv").bytes());
        OsString::from_vec(name)
    };
    // All except one are links to one swing, so that the run is measured, not the disk.
    fs::write(held.join(name(0)), &swing).unwrap();
    (1..count).for_each(|i| fs::hard_link(held.join(name(0)), held.join(name(i))).unwrap());
    fs::write(held.join("locked.csv"), &swing).unwrap();
    fs::set_permissions(held.join("locked.csv"), fs::Permissions::from_mode(0o000)).unwrap();
    // The superuser can read everything.
    let locked = fs::read(held.join("locked.csv")).is_err();
    let table = folder.path().join("out.json");
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin!("slipfit"));
    command
        .current_dir(&held)
        .args(["ringdown", "--quiet", "--table"])
        .arg(&table)
        .args(["--", "missing.csv"]);
    command.arg(name(1)).arg(name(1)).arg(".");
    let begun = std::time::Instant::now();
    let mut child = command.spawn().unwrap();
    // The system reports the peak memory while the program runs.
    let status = format!("/proc/{}/status", child.id());
    let mut most_mb = 0.0;
    let code = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|l| l.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        most_mb = peak.and_then(|kb| kb.parse::<f64>().ok()).map_or(most_mb, |kb| kb / 1000.0);
        match child.try_wait().unwrap() {
            Some(status) => break status.code(),
            None => std::thread::sleep(std::time::Duration::from_millis(5)),
        }
    };
    assert_eq!(code, Some(0));
    let rows = rows(&table);
    assert_eq!(rows.len(), 3 + count + 1);
    let (files, statuses) = (of(&rows, "file"), of(&rows, "status"));
    assert_eq!(files[..3], ["missing.csv", "two\nlines00001.csv", "two\nlines00001.csv"]);
    let failed: Vec<&String> =
        files.iter().zip(&statuses).filter(|(_, s)| *s == "failed").map(|(f, _)| f).collect();
    let wanted: &[&str] = if locked { &["missing.csv", "./locked.csv"] } else { &["missing.csv"] };
    assert_eq!(failed, wanted);
    assert!(files[3..].is_sorted(), "a folder by the names of its files");
    (begun.elapsed(), most_mb)
}

#[cfg(unix)]
#[test]
fn hundreds_of_files_are_a_row_each_and_take_no_memory_each() {
    let (_, few) = many_rows(50);
    let (_, many) = many_rows(500);
    // A row takes some hundred bytes; a record of 1500 samples in memory would take 24 kB, 11 MB in all.
    assert!(many < few + 6.0, "{few} MB for 50 files, {many} MB for 500");
}

#[cfg(unix)]
#[test]
#[ignore = "a measurement: 20 000 files"]
#[allow(clippy::print_stdout, reason = "the figures are what it is for")]
fn twenty_thousand_files_are_a_row_each() {
    let (time, memory) = many_rows(20_000);
    println!("20 000 files: {:.1} s, {memory:.0} MB at most", time.as_secs_f64());
    assert!(memory < 200.0, "{memory} MB");
}

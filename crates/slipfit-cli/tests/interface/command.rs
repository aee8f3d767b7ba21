//! The command as users see it: help, report, exit status, bad input.

use crate::common::{example, slipfit, stdout};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn folder_with(name: &str, content: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), content).unwrap();
    folder
}

fn table(header: &str, row: impl Fn(u32) -> String) -> Vec<u8> {
    let rows: Vec<String> = (0..200).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n")).into_bytes()
}

#[test]
fn help_reads_well() {
    insta::assert_snapshot!("help", stdout(slipfit().arg("--help")));
    insta::assert_snapshot!("help_ringdown", stdout(slipfit().args(["help", "ringdown"])));
    insta::assert_snapshot!("help_inspect", stdout(slipfit().args(["help", "inspect"])));
    insta::assert_snapshot!("help_simulate_decay", stdout(slipfit().args(["help", "simulate", "decay"])));
}

#[test]
fn no_help_line_is_wider_than_the_screen() {
    for command in [vec!["--help"], vec!["help", "ringdown"], vec!["help", "simulate", "decay"]] {
        let text = stdout(slipfit().args(&command));
        let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 100).collect();
        assert!(wide.is_empty(), "{wide:#?}");
    }
}

#[test]
fn the_report_fits_on_one_screen() {
    for file in ["classroom_pendulum.csv", "tuning_fork_9nN.csv", "tuning_fork_9nN_waveform.csv"] {
        let text = stdout(slipfit().current_dir(example("")).args(["ringdown", file]));
        assert!(text.lines().count() <= 36, "{text}");
        let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
        assert!(wide.is_empty(), "{wide:#?}");
        assert!(!text.contains('\u{1b}'), "colour in a pipe");
    }
}

#[test]
fn the_report_begins_with_the_answer_and_accounts_for_the_file() {
    let text = stdout(slipfit().current_dir(example("")).args(["ringdown", "classroom_pendulum.csv"]));
    assert!(text.starts_with("Sliding friction carries "), "{text}");
    let place = |needle: &str| text.find(needle).unwrap_or_else(|| panic!("no `{needle}` in\n{text}"));
    let order = [
        "\n  frequency ",
        " x_F ",
        "\n  model ",
        "\n> ",
        "\n  read ",
        "\n  time ",
        "\n  signal ",
        "\n  used ",
        "\n  fit ",
    ];
    let places: Vec<usize> = order.iter().map(|o| place(o)).collect();
    assert!(places.is_sorted(), "{places:?}\n{text}");
}

#[test]
fn colour_comes_when_asked_for() {
    let file = example("classroom_pendulum.csv");
    let plain = stdout(slipfit().arg("ringdown").arg(&file));
    let coloured = stdout(slipfit().args(["--color", "always", "ringdown"]).arg(&file));
    assert!(coloured.contains("\u{1b}["));
    assert!(!plain.contains("\u{1b}["));
    let stripped = anstream::adapter::strip_str(&coloured).to_string();
    assert_eq!(stripped, plain);
}

#[test]
fn quiet_prints_nothing_and_still_writes() {
    let folder = tempfile::tempdir().unwrap();
    let assert = slipfit()
        .current_dir(folder.path())
        .args(["ringdown", "--quiet", "--json", "a.json", "--csv", "a.csv", "--plot", "a.svg"])
        .arg(fs::canonicalize(example("classroom_pendulum.csv")).unwrap())
        .assert();
    assert.success().stdout("").stderr("");
    for name in ["a.json", "a.csv", "a.svg"] {
        assert!(folder.path().join(name).metadata().unwrap().len() > 1000, "{name}");
    }
}

#[test]
fn the_envelope_csv_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("envelope.csv");
    let csv_file = path.to_str().unwrap();
    stdout(slipfit().arg("ringdown").arg(example("classroom_pendulum.csv")).args(["--csv", csv_file]));
    let text = fs::read_to_string(&path).unwrap();
    let mut rows = text.lines().filter(|l| !l.starts_with('#'));
    assert_eq!(rows.next(), Some("time_s,amplitude,std_error,fitted,residual,frequency_hz,used"));
    let mut used = 0;
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        assert_eq!(cells.len(), 7, "{row}");
        if cells[6] == "true" {
            let number = |i: usize| cells[i].parse::<f64>().unwrap();
            assert!((number(1) - number(3) - number(4)).abs() < 1e-12, "{row}");
            used += 1;
        }
    }
    assert!(used > 20, "{used} amplitudes");
    assert!(text.contains("\n# friction_displacement = "));
}

#[test]
fn pictures_are_whole_in_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    for (file, name) in [("classroom_pendulum.csv", "a.png"), ("tuning_fork_9nN.csv", "b.svg")] {
        let path = folder.path().join(name);
        stdout(slipfit().arg("ringdown").arg(example(file)).arg("--plot").arg(&path));
    }
    let png = fs::read(folder.path().join("a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    assert!(png.ends_with(b"IEND\xaeB`\x82"));
    let svg = fs::read_to_string(folder.path().join("b.svg")).unwrap();
    assert!(svg.starts_with("<svg "));
    assert!(svg.ends_with("</svg>\n"));
    for said in ["Sliding friction", "purely viscous", "time [ms]", "amplitude [nm]", "loss per cycle [pm]"] {
        assert!(svg.contains(said), "{said}");
    }
    assert!(!svg.contains("NaN"));
    assert!(!svg.contains("inf"));
}

#[test]
fn a_picture_needs_a_known_ending() {
    let folder = tempfile::tempdir().unwrap();
    let output = slipfit()
        .current_dir(folder.path())
        .arg("ringdown")
        .arg(fs::canonicalize(example("classroom_pendulum.csv")).unwrap())
        .args(["--plot", "a.pdf"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    insta::assert_snapshot!(String::from_utf8(output.stderr).unwrap(), @r"
    error: --plot a.pdf: no picture format with this extension is known
      hint: name the file .svg or .png
    ");
}

/// Three cycles: an answer, with a warning.
fn doubtful() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    slipfit()
        .current_dir(folder.path())
        .args(["simulate", "decay", "--frequency-hz", "1", "--q", "20", "--friction-displacement", "0.01"])
        .args([
            "--amplitude",
            "1",
            "--duration",
            "3",
            "--rate-hz",
            "100",
            "--noise-rms",
            "3e-2",
            "--unit",
            "rad",
        ])
        .args(["--out", "short.csv"])
        .assert()
        .success();
    folder
}

#[test]
fn strict_turns_a_warning_into_status_one() {
    let folder = doubtful();
    let run = |strict: bool| {
        let mut command = slipfit();
        command.current_dir(folder.path()).args(["ringdown", "short.csv"]);
        if strict {
            command.arg("--strict");
        }
        command.output().unwrap()
    };
    let (lax, strict) = (run(false), run(true));
    assert_eq!((lax.status.code(), strict.status.code()), (Some(0), Some(1)));
    assert!(String::from_utf8_lossy(&strict.stderr).contains("warning: only"), "{strict:?}");
    assert!(String::from_utf8_lossy(&strict.stdout).starts_with("Only 3.0 cycles, too few"), "{strict:?}");
    // Without a warning, `--strict` changes nothing.
    slipfit().arg("ringdown").arg(example("classroom_pendulum.csv")).arg("--strict").assert().code(0);
}

#[test]
fn json_on_standard_output_stands_alone() {
    let folder = doubtful();
    let output =
        slipfit().current_dir(folder.path()).args(["ringdown", "short.csv", "--json", "-"]).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["warnings"][0]["code"], "too_few_cycles");
    assert!(String::from_utf8_lossy(&output.stderr).contains("warning: only"));
}

#[test]
fn a_closed_pipe_is_silent() {
    let file = example("tuning_fork_9nN.csv");
    let file = file.to_str().unwrap();
    let runs: [&[&str]; 3] = [
        &["ringdown", file, "--json", "-"],
        &["ringdown", file],
        &[
            "simulate",
            "decay",
            "--frequency-hz",
            "1",
            "--amplitude",
            "1",
            "--duration",
            "1e4",
            "--rate-hz",
            "100",
        ],
    ];
    for args in runs {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin("slipfit"))
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{args:?}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{args:?}");
    }
}

/// Status 2, nothing on standard output, and the message.
fn complaint(folder: &Path, args: &[&str]) -> String {
    let output = slipfit().current_dir(folder).arg("ringdown").args(args).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.starts_with("error: "), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn bad_input_is_told_apart() {
    let swing = |i: u32| format!("{},{:.4}", f64::from(i) * 0.05, (f64::from(i) * 0.3).cos());
    let garbage: Vec<u8> = (0..4000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    // File, content, further arguments, expected message.
    let cases: [(&str, Vec<u8>, &[&str], &str); 9] = [
        ("empty.csv", Vec::new(), &[], "empty"),
        ("one_row.csv", b"t (s),x (m)\n0,1\n".to_vec(), &[], "usable row"),
        ("all_nan.csv", table("t (s),x (m)", |i| format!("{},nan", f64::from(i) * 0.1)), &[], "signal"),
        ("constant.csv", table("t (s),x (m)", |i| format!("{},2.5", f64::from(i) * 0.1)), &[], "constant"),
        ("garbage.csv", garbage, &[], "not text"),
        ("wrong_column.csv", table("t (s),x (m)", swing), &["--signal", "angle"], "--signal angle"),
        (
            "backwards.csv",
            table("t (s),x (m)", |i| format!("{},{}", 300 - i, f64::from(i).sin())),
            &[],
            "backwards",
        ),
        ("no_time.csv", table("x (m)", |i| format!("{:.4}", (f64::from(i) * 0.3).cos())), &[], "--rate-hz"),
        ("prose.txt", b"It was a dark and stormy night.\nNothing swung.\n".to_vec(), &[], "no table"),
    ];
    for (name, content, more, expected) in cases {
        let folder = folder_with(name, &content);
        let args: Vec<&str> = std::iter::once(name).chain(more.iter().copied()).collect();
        let said = complaint(folder.path(), &args);
        assert!(said.contains(name), "{said}");
        assert!(said.contains(expected), "{said}");
    }
    assert!(complaint(Path::new("."), &["no_such_file.csv"]).contains("no_such_file.csv"));
}

#[test]
fn bad_arguments_are_status_two() {
    let file = example("classroom_pendulum.csv");
    let file = file.to_str().unwrap();
    let wrong: [&[&str]; 8] = [
        &["--start", "nan"],
        &["--rate-hz", "0"],
        &["--model", "elastic"],
        &["--lockin-order", "4"],
        &["--stiffness", "12±"],
        &["--mass", "1", "--stiffness", "1"],
        &["--band", "5"],
        &["--kind", "smell"],
    ];
    for args in wrong {
        slipfit().args(["ringdown", file]).args(args).assert().code(2).stdout("");
    }
    let said = complaint(Path::new("."), &[file, "--stiffness", "12000"]);
    assert!(said.contains("--torsion-stiffness"), "{said}");
    let said = complaint(Path::new("."), &[file, "--start", "20", "--end", "10"]);
    assert_eq!(said, "error: --end 10: must be a time after --start\n");
}

#[test]
fn a_file_in_the_place_of_a_command_says_what_to_type() {
    let folder = folder_with("my swing.csv", b"0,1\n");
    let said = |word: &str| {
        let output = slipfit().current_dir(folder.path()).arg(word).output().unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    for (word, typed) in [("my swing.csv", "\"my swing.csv\""), ("missing.wav", "missing.wav")] {
        let said = said(word);
        assert!(said.contains(&format!("tip: slipfit ringdown {typed} analyses")), "{said}");
        assert!(said.contains(&format!("tip: slipfit inspect {typed} shows")), "{said}");
    }
    assert!(!said("swing").contains("ringdown swing"));
    assert!(said("rigndown").contains("'ringdown'"));
}

#[test]
fn a_number_with_a_sign_is_refused_for_its_value() {
    let file = example("classroom_pendulum.csv");
    let file = file.to_str().unwrap();
    let positive = "must be above zero";
    for (command, arguments, expected) in [
        ("ringdown", "--min-amplitude -1", positive),
        ("ringdown", "--rate-hz -1e-3", positive),
        ("ringdown", "--band -5 1", positive),
        ("ringdown", "--band 1 -.5", positive),
        ("ringdown", "--stiffness -5±1", positive),
        ("ringdown", "--run -1", "must be a whole number from 1 on"),
        ("ringdown", "--signal -1", "no such column"),
        ("ringdown", "--lockin-order -1", "-1 is not in 1..=8"),
        ("ringdown", "--start --end", "not a number"),
        ("resonance", "--drive-amplitude -2", positive),
        ("levels", "--q -2", positive),
        ("map", "--dt -1", positive),
    ] {
        let output = slipfit().args([command, file]).args(arguments.split(' ')).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected) && !said.contains("tip:"), "{arguments}: {said}");
    }
    for (command, file) in
        [("ringdown", "classroom_pendulum.csv"), ("resonance", "tuning_fork_12nN_sweep.csv")]
    {
        let output = slipfit().arg(command).arg(example(file)).args(["--band", "5", "1"]).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said, "error: --band 5 1: the lower frequency must come first\n");
    }
}

#[test]
fn a_force_of_a_signal_without_a_unit_says_so() {
    let swing = |i: u32| {
        let t = 0.1 * f64::from(i);
        format!("{t},{}", 20.0 * (-0.03 * t).exp() * (3.0 * t).cos())
    };
    let folder = folder_with("swing.csv", &table("t (s),x", swing));
    let run = |more: &[&str]| {
        let mut command = slipfit();
        command.current_dir(folder.path()).args([
            "ringdown",
            "swing.csv",
            "--stiffness",
            "40",
            "--json",
            "-",
        ]);
        let output = command.args(more).output().unwrap();
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let unit = answer["parameters"]["coulomb_force"]["unit"].as_str().unwrap().to_owned();
        (unit, String::from_utf8(output.stderr).unwrap())
    };
    let (unit, said) = run(&[]);
    assert_eq!(unit, "N/m × signal unit");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("note: --stiffness: the unit of the signal is unknown"), "{said}");
    assert!(said.contains("--unit gives it"), "{said}");
    let (unit, said) = run(&["--unit", "mm"]);
    assert_eq!(unit, "N");
    assert!(!said.contains("note:"), "{said}");
}

#[test]
fn runs_one_after_the_other_are_chosen_by_number() {
    let run = |from: f64| {
        (0..300)
            .map(move |i| 0.05 * f64::from(i))
            .map(move |t| format!("{t:.2},{:.5}", from * (3.0 * t).cos() * (-0.1 * t).exp()))
    };
    let rows: Vec<String> = [1.0, 2.0, 3.0].into_iter().flat_map(run).collect();
    let folder = folder_with("runs.csv", format!("t (s),x (mm)\n{}\n", rows.join("\n")).as_bytes());
    let amplitude = |arguments: &str| {
        let told = stdout(slipfit().current_dir(folder.path()).args(arguments.split(' ')));
        let answer: serde_json::Value = serde_json::from_str(&told).unwrap();
        answer["parameters"]["initial_amplitude"]["value"].as_f64().unwrap()
    };
    for (number, expected) in [(1, 1.0), (2, 2.0), (3, 3.0)] {
        let found = amplitude(&format!("ringdown runs.csv --run {number} --json -"));
        assert!((found / expected - 1.0).abs() < 1e-3, "{number}: {found}");
    }
    assert_eq!(
        complaint(folder.path(), &["runs.csv", "--run", "4"]),
        "error: runs.csv: --run 4: the file has only 3\n"
    );
    let told = stdout(slipfit().current_dir(folder.path()).args(["inspect", "runs.csv"]));
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    let note = "3 runs follow one another; number 1, the longest, was read; --run reads another";
    assert!(told.contains(note), "{told}");
}

#[test]
fn a_constant_of_angles_needs_an_angle() {
    let decay = |header: &str| {
        let swing = |i: u32| {
            let t = 0.1 * f64::from(i);
            format!("{t},{}", 20.0 * (-0.03 * t).exp() * (3.0 * t).cos())
        };
        folder_with("swing.csv", &table(&format!("t (s),{header}"), swing))
    };
    let viscous_unit = |header: &str| {
        let folder = decay(header);
        let arguments = "ringdown swing.csv --inertia 0.12 --json -";
        let told = stdout(slipfit().current_dir(folder.path()).args(arguments.split(' ')));
        let answer: serde_json::Value = serde_json::from_str(&told).unwrap();
        answer["parameters"]["viscous_coefficient"]["unit"].as_str().unwrap().to_owned()
    };
    for header in ["Winkel (Grad)", "Angle (Deg)", "Angle (DEG)", "Angle (Rad)"] {
        assert_eq!(viscous_unit(header), "N m s", "{header}");
    }
    for (header, found) in [("theta", "the signal has no unit"), ("theta (V)", "the signal is in V")] {
        for flag in ["--inertia", "--torsion-stiffness"] {
            let said = complaint(decay(header).path(), &["swing.csv", flag, "0.12"]);
            let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
            for part in [flag, found, "--unit deg or --unit rad"] {
                assert!(said.contains(part), "{header} {flag}: {said}");
            }
        }
    }
}

#[test]
fn simulate_names_what_is_missing() {
    let output = slipfit()
        .args(["simulate", "decay", "--amplitude", "1", "--duration", "1", "--rate-hz", "10"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--frequency-hz"), "{output:?}");
    slipfit()
        .args(["simulate", "decay", "--frequency-hz", "1", "--amplitude", "1", "--duration", "1e9"])
        .args(["--rate-hz", "1e9"])
        .assert()
        .code(2)
        .stdout("");
}

#[test]
fn messages_fit_the_screen_and_hang_behind_their_label() {
    let name =
        format!("{}.csv", "a_recording_with_a_name_as_long_as_folders_of_a_laboratory_make_them".repeat(2));
    let folder = folder_with(&name, &table("x (rad)", |i| f64::from(i).cos().to_string()));
    let output = slipfit().current_dir(folder.path()).args(["ringdown", &name]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let words: Vec<&str> = said.split_whitespace().collect();
    assert!(
        words.join(" ").contains("no column of times; the file has column 1 `x (rad)` hint: --rate-hz"),
        "{said}"
    );
    // A name is never broken, but the text after it is.
    assert!(said.lines().all(|l| l.chars().count() <= 80 || l.contains(&name)), "{said}");
    assert!(said.lines().nth(1).unwrap().starts_with("       no column of times"), "{said}");
}

#[test]
fn a_flag_that_would_change_nothing_is_refused() {
    let rows = |i: u32| {
        let t = 0.05 * f64::from(i);
        format!("{t:.2},{}", 0.3 * (-0.1 * t).exp() * (6.0 * t).cos())
    };
    let folder = folder_with("swing.csv", &table("t (s),angle (rad)", rows));
    for (flags, word) in [
        (["--min-amplitude", "5"], "the decay already begins at"),
        (["--frequency-hz", "7"], "only for records of amplitudes"),
        (["--sheet", "foo"], "a text file has no sheets"),
        (["--torsion-stiffness", "-3"], "must be above zero"),
        (["--table", "nowhere/table.csv"], "there is no folder nowhere"),
    ] {
        let output = slipfit()
            .current_dir(folder.path())
            .args(["ringdown", "swing.csv"])
            .args(flags)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{flags:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        let words: Vec<&str> = said.split_whitespace().collect();
        assert!(words.join(" ").contains(word), "{said}");
    }
}

#[test]
fn an_empty_folder_is_called_so() {
    let folder = tempfile::tempdir().unwrap();
    let output = slipfit().arg("resonance").arg(folder.path()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.split_whitespace().collect::<Vec<_>>().join(" ").contains("the folder contains no files"),
        "{said}"
    );
}

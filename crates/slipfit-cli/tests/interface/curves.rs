//! Resonance curves, drive levels and series from the command line.

use crate::common::{example, keeps_to_schema, root, slipfit, stdout};
use serde_json::Value;
use std::path::Path;

fn json(args: &[&str], file: &Path) -> Value {
    let text = stdout(slipfit().args(&args[..1]).arg(file).args(&args[1..]).args(["--json", "-"]));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{args:?}: {e}\n{text}"))
}

/// A file in a folder.
fn write(folder: &tempfile::TempDir, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn refused(args: &[&str], file: &Path) -> String {
    let output = slipfit().args(&args[..1]).arg(file).args(&args[1..]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

const SWEEP: &str = "tuning_fork_9nN_sweep.csv";
const FREE: &str = "tuning_fork_free_sweep.csv";

#[test]
fn answers_keep_to_their_schemas() {
    let free = example(FREE);
    let free = free.to_str().unwrap();
    keeps_to_schema(
        &json(&["resonance", "--reference", free, "--stiffness", "10000"], &example(SWEEP)),
        "resonance",
    );
    keeps_to_schema(
        &json(&["resonance", "--drive-amplitude", "10e-12", "--response", "paper"], &example(SWEEP)),
        "resonance",
    );
    keeps_to_schema(
        &json(&["levels", "--stiffness", "1e4±100"], &example("tuning_fork_9nN_levels.csv")),
        "levels",
    );
    keeps_to_schema(&json(&["series"], &example("tuning_fork.toml")), "series");
}

/// The paper's inversion needs the drive amplitude, which a reference also gives.
#[test]
fn what_gives_the_drive_amplitude_is_named_where_it_is_missing() {
    let said = refused(&["resonance", "--response", "paper"], &example(SWEEP));
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("--drive-amplitude is missing"), "{said}");
    assert!(said.contains("--drive-amplitude or --reference gives it"), "{said}");
}

/// A sweep that is too fast: the line of the fit said 6.2 times, the warning 9.9 times.
#[test]
fn residuals_are_told_by_one_number() {
    let sweep = "simulate sweep --frequency-hz 1 --q 50 --beta 0.8 --drive-amplitude 1 --start-hz 1.06 --stop-hz 0.94 \
                 --sweep-time 600";
    let curve = stdout(slipfit().args(sweep.split_whitespace()));
    let output =
        slipfit().args(["resonance", "-", "--drive-amplitude", "1"]).write_stdin(curve).output().unwrap();
    let [shown, warned] = [output.stdout, output.stderr]
        .map(|text| String::from_utf8(text).unwrap().split_whitespace().collect::<Vec<_>>().join(" "));
    let number = |text: &str, from: &str, to: &str| -> f64 {
        let after = text.split_once(from).unwrap_or_else(|| panic!("{from}: {text}")).1;
        after.split_once(to).unwrap().0.parse().unwrap()
    };
    let fit = number(&shown, "residuals ", " times the noise");
    let warning = number(&warned, "residuals are ", " times the noise");
    assert!(warning > 5.0 && (fit - warning).abs() < 0.05 * warning, "{fit} {warning}");
    // No percentage is a negative zero.
    assert!(!shown.contains("-0 %") && !shown.contains("+0 %"), "{shown}");
}

/// `--model paper` was the former spelling.
#[test]
fn the_response_may_be_spelled_as_it_was() {
    let run = |flags: &[&str]| {
        let output = slipfit()
            .args(["resonance", "--drive-amplitude", "10e-12", "--json", "-"])
            .args(flags)
            .arg(example(SWEEP))
            .output()
            .unwrap();
        assert!(output.status.success(), "{flags:?}");
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let note =
            String::from_utf8(output.stderr).unwrap().contains("--model paper is --response paper now");
        (answer, note)
    };
    let (new, note) = run(&["--response", "paper", "--model", "viscous+sliding"]);
    assert!(!note);
    assert_eq!((&new["method"], &new["options"]["model"]), (&"paper".into(), &"viscous+sliding".into()));
    assert_eq!(run(&["--model", "paper", "--model", "viscous+sliding"]), (new, true));
}

#[test]
fn the_reference_gives_the_friction_of_the_example() {
    let free = example(FREE);
    let answer =
        json(&["resonance", "--reference", free.to_str().unwrap(), "--stiffness", "10000"], &example(SWEEP));
    // Simulated with F = 15 nN, gamma = 20 µN s/m.
    let force = &answer["parameters"]["coulomb_force"];
    let (value, error) = (force["value"].as_f64().unwrap(), force["std_error"].as_f64().unwrap());
    assert!((value - 15e-9).abs() < 4.0 * error, "{force}");
    assert!(error < 1.5e-9, "{force}");
    assert_eq!(answer["drive_source"], "reference");
    assert_eq!(answer["sliding"]["detected"], true);
}

/// The amplitude is the modulus of the columns that the flags name; every flag in a hint exists.
#[test]
fn levels_take_two_parts_and_hints_name_what_they_take() {
    let folder = tempfile::tempdir().unwrap();
    let text = "Drive (V),A,B\n1,-3,4\n2,6,-8\n3,-9.1,12\n4,12,-16\n5,15,20\n6,-18,-24\n";
    let file = write(&folder, "levels.csv", text);
    let answer = json(&["levels", "--real", "2", "--imaginary", "B"], &file);
    keeps_to_schema(&answer, "levels");
    assert_eq!(answer["input"]["taken"]["imaginary"]["number"], 3);
    let slope = answer["parameters"]["slope"]["value"].as_f64().unwrap();
    assert!((slope - 5.0).abs() < 0.1, "{slope}");
    let help = stdout(slipfit().args(["levels", "--help"]));
    let half = refused(&["levels", "--imaginary", "3"], &file);
    for message in [refused(&["levels"], &file), half] {
        assert!(message.contains("--real"), "{message}");
        for flag in message.split_whitespace().filter(|word| word.starts_with("--")) {
            assert!(help.contains(flag.trim_end_matches([':', ',', ';'])), "{flag}: {message}");
        }
    }
}

/// Levels in volts of a drive and volts of a sensor give no Q.
#[test]
fn levels_of_volts_over_volts_have_no_q() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (1..12).map(|i| format!("{i},{}\n", 0.02 * f64::from(i) - 0.01)).collect();
    let file = write(&folder, "levels.csv", &format!("Drive (V),Amplitude (V)\n{rows}"));
    let answer = json(&["levels"], &file);
    assert!(answer["parameters"]["q_factor"].is_null(), "{}", answer["parameters"]);
    let warnings = answer["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|w| w["code"] == "drive_uncalibrated"), "{warnings:?}");
    let file = write(&folder, "lengths.csv", &format!("x0 (mm),A (m)\n{rows}"));
    let q = json(&["levels"], &file)["parameters"]["q_factor"]["value"].as_f64().unwrap();
    assert!((q - 20.0).abs() < 0.1, "{q}");
}

#[test]
fn levels_of_the_example_show_their_threshold() {
    let answer = json(&["levels", "--stiffness", "10000"], &example("tuning_fork_9nN_levels.csv"));
    let threshold = &answer["parameters"]["threshold"];
    let (value, error) = (threshold["value"].as_f64().unwrap(), threshold["std_error"].as_f64().unwrap());
    let truth = 4.0 * 15e-9 / (std::f64::consts::PI * 1e4);
    assert!((value - truth).abs() < 4.0 * error.max(1e-3 * truth), "{threshold} for {truth}");
}

#[test]
fn the_series_of_the_example_agrees() {
    let answer = json(&["series"], &example("tuning_fork.toml"));
    assert!(answer["agreement_p_value"].as_f64().unwrap() > 1e-3, "{}", answer["table"]);
    for row in answer["table"].as_array().unwrap() {
        if !row["ringdown"].is_null() {
            let force = row["ringdown"]["friction"]["value"].as_f64().unwrap();
            assert!((14e-9..18e-9).contains(&force), "{row}");
        }
    }
}

/// With ring-downs only, the answer is friction and its dependence on load, without what was not measured.
#[test]
fn a_series_of_one_way_says_what_it_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let told = |friction: [&str; 2]| {
        let mut manifest = "condition = 'load'\ncondition_unit = 'N'\n".to_owned();
        for (x_f, load) in friction.into_iter().zip([1, 2]) {
            let made = slipfit()
                .args([
                    "simulate",
                    "decay",
                    "--frequency-hz",
                    "10",
                    "--q",
                    "100",
                    "--unit",
                    "mm",
                    "--amplitude",
                    "1",
                ])
                .args([
                    "--duration",
                    "8",
                    "--rate-hz",
                    "100",
                    "--noise-rms",
                    "0.01",
                    "--friction-displacement",
                    x_f,
                ])
                .arg("--out")
                .arg(at(&format!("{load}.csv")))
                .arg("--force")
                .output()
                .unwrap();
            assert!(made.status.success(), "{made:?}");
            manifest.push_str(&format!("[[measurement]]\nringdown = '{load}.csv'\ncondition = {load}\n"));
        }
        let manifest = write(&folder, "s.toml", &manifest);
        let said =
            stdout(slipfit().arg("series").arg(manifest).arg("--force").arg("--plot").arg(at("s.svg")));
        (said, std::fs::read_to_string(at("s.svg")).unwrap())
    };
    let (said, svg) = told(["0.001", "0.002"]);
    assert!(said.starts_with("Friction at 2 loads is described best by F = "), "{said}");
    assert!(!said.contains("resonance"), "{said}");
    assert!(svg.contains("ring-down") && !svg.contains("both together") && !svg.contains("resonance"));
    let (said, svg) = told(["0", "0"]);
    assert!(said.starts_with("No sliding friction is found at 2 conditions: it is below "), "{said}");
    assert!(!said.contains("BIC") && !svg.contains("F = "), "{said}");
}

#[test]
fn every_output_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let free = example(FREE);
    let report = stdout(
        slipfit()
            .arg("resonance")
            .arg(example(SWEEP))
            .args(["--reference", free.to_str().unwrap(), "--plot", &at("a.svg"), "--csv", &at("a.csv")])
            .args(["--json", &at("a.json")]),
    );
    assert!(report.contains("natural frequency"), "{report}");
    assert!(report.contains("wrote"), "{report}");
    let svg = std::fs::read_to_string(at("a.svg")).unwrap();
    assert!(svg.contains("without friction"));
    assert!(!svg.contains("NaN"));
    let csv = std::fs::read_to_string(at("a.csv")).unwrap();
    assert!(csv.contains("curve,frequency_hz,amplitude"));
    assert!(csv.contains("\nreference,"));
    let manifest = example("tuning_fork.toml");
    let table = stdout(slipfit().arg("series").arg(&manifest).args([
        "--plot",
        &at("s.png"),
        "--csv",
        &at("s.csv"),
        "--markdown",
        &at("s.md"),
        "--latex",
        &at("s.tex"),
    ]));
    assert!(table.contains("ring-down"), "{table}");
    assert!(table.contains("resonance"), "{table}");
    assert!(std::fs::read(at("s.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(std::fs::read_to_string(at("s.md")).unwrap().contains("|---|"));
    let latex = std::fs::read_to_string(at("s.tex")).unwrap();
    assert!(latex.contains("\\begin{tabular}"), "{latex}");
    assert!(latex.contains("\\pm"), "{latex}");
    let csv = std::fs::read_to_string(at("s.csv")).unwrap();
    assert!(csv.contains("condition,value,value_std_error,friction_ringdown"), "{csv}");
}

#[test]
fn bad_curves_are_refused_or_flagged() {
    let folder = tempfile::tempdir().unwrap();
    let few = write(&folder, "few.csv", "f (Hz),A (mm)\n9,1\n10,5\n11,1\n");
    let said = refused(&["resonance"], &few);
    assert!(said.contains("points"), "{said}");
    assert!(said.contains("hint"), "{said}");
    let negative = write(&folder, "negative.csv", "f (Hz),A (mm)\n9,1\n-10,5\n11,1\n");
    assert!(refused(&["resonance", "--frequency", "1"], &negative).contains("row 3"));
    let columns = write(&folder, "columns.csv", "f (Hz),phase (deg)\n9,1\n10,5\n11,1\n");
    assert!(refused(&["resonance"], &columns).contains("--amplitude"));
    let record = write(&folder, "record.csv", "t (s),x (mm)\n0,1\n0.1,-1\n0.2,0.5\n0.3,-0.2\n");
    assert!(refused(&["resonance"], &record).contains("not a resonance curve"));
    let missing = folder.path().join("missing.csv");
    assert!(refused(&["resonance"], &missing).contains("missing.csv"));
    let other_unit = write(&folder, "free.csv", "f (Hz),A (V)\n9,1\n10,5\n11,1\n");
    let rows = (0..41).map(|i| format!("{},{},1\n", 9.0 + 0.05 * f64::from(i), 1 + i % 3));
    let text = format!("f (MHz),G (mS),B (mS)\n{}", rows.collect::<String>());
    let quartz = write(&folder, "quartz.csv", &text);
    let said = refused(&["resonance", "--stiffness", "12000"], &quartz);
    assert!(said.contains("--stiffness is for a displacement; the signal is in F"), "{said}");
    assert!(said.contains("a capacitance has no force"), "{said}");
    let said = refused(&["resonance", "--reference", other_unit.to_str().unwrap()], &few);
    assert!(said.contains("--reference"), "{said}");
    assert!(said.contains("`V`"), "{said}");
}

/// Amplitudes of a damped oscillator, as text.
fn lorentzian(peaks: &[(f64, f64)], points: u32, phase: Option<f64>) -> String {
    let mut text =
        String::from(if phase.is_some() { "f (Hz),A (mm),phase (deg)\n" } else { "f (Hz),A (mm)\n" });
    for i in 0..points {
        let f = 9.0 + 2.0 * f64::from(i) / f64::from(points - 1);
        let (mut re, mut im) = (0.0, 0.0);
        for (f0, height) in peaks {
            let (a, b) = (1.0 - (f / f0) * (f / f0), 0.01 * f / f0);
            re += height * 0.01 * a / (a * a + b * b);
            im -= height * 0.01 * b / (a * a + b * b);
        }
        let ripple = 1.0 + 2e-4 * (13.7 * f64::from(i * i)).sin();
        text += &format!("{f},{}", re.hypot(im) * ripple);
        if let Some(sign) = phase {
            text += &format!(",{}", sign * im.atan2(re).to_degrees());
        }
        text.push('\n');
    }
    text
}

fn codes(answer: &Value) -> Vec<String> {
    answer["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn options_of_the_other_kind_of_input_are_refused() {
    let sweep = example(SWEEP);
    for (option, value) in [("--rate-hz", "10"), ("--time", "t"), ("--time-unit", "ms")] {
        let said = refused(&["resonance", option, value], &sweep);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        let expected = format!("{SWEEP}: {option} {value}: has no effect on a curve over frequency");
        assert!(said.contains(&expected) && said.contains("hint: leave it out"), "{said}");
    }
    let folder = tempfile::tempdir().unwrap();
    for hz in (0..21).map(|i| 9.5 + 0.05 * f64::from(i)) {
        let omega = std::f64::consts::TAU * hz;
        let height = 1.0 / ((hz - 10.0) / 0.1).hypot(1.0);
        let row = |i: u32| {
            let t = 0.01 * f64::from(i);
            format!("{},{}\n", height * (omega * t).cos(), (omega * t).cos())
        };
        let text: String = (0..1000).map(row).collect();
        write(&folder, &format!("{hz}.csv"), &format!("position (mm),drive\n{text}"));
    }
    let records = folder.path();
    for (option, value) in [("--phase", "3"), ("--frequency-unit", "kHz"), ("--kind", "velocity")] {
        let said = refused(&["resonance", "--rate-hz", "100", option, value], records);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(&format!("{option} {value}: has no effect on driven records")), "{said}");
    }
    // A reference of the other kind is read with the options that concern it.
    let other = tempfile::tempdir().unwrap();
    let free = write(&other, "free.csv", &lorentzian(&[(10.0, 1.0)], 101, Some(1.0)));
    let options = ["--rate-hz", "100", "--frequency-unit", "Hz", "--unit", "mm", "--reference"];
    let mut arguments = vec!["resonance"];
    arguments.extend(options);
    arguments.push(free.to_str().unwrap());
    json(&arguments, records);
}

/// The force of a curve in volts was in N/m times V without a word.
#[test]
fn a_force_of_a_signal_that_is_no_length_has_a_note() {
    let said = |command: &str, file: &str, unit: &str| {
        let constant = ["--unit", unit, "--stiffness", "3"];
        let output = slipfit().arg(command).arg(example(file)).args(constant).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (command, file) in
        [("resonance", SWEEP), ("levels", "tuning_fork_9nN_levels.csv"), ("ringdown", "tuning_fork_9nN.csv")]
    {
        let note =
            "note: --stiffness: the signal is in V, which is not a length, so the force is in N/m times V;";
        assert!(said(command, file, "V").contains(note), "{command}: {}", said(command, file, "V"));
        assert!(!said(command, file, "nm").contains("--stiffness"));
    }
}

#[test]
fn odd_curves_give_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let two = write(&folder, "two.csv", &lorentzian(&[(9.6, 1.0), (10.4, 0.8)], 201, None));
    assert!(codes(&json(&["resonance"], &two)).contains(&"second_peak".to_owned()));
    let flank = write(&folder, "flank.csv", &lorentzian(&[(8.9, 1.0)], 101, Some(1.0)));
    assert!(codes(&json(&["resonance"], &flank)).contains(&"one_flank".to_owned()));
    let turned = write(&folder, "turned.csv", &lorentzian(&[(10.0, 1.0)], 101, Some(-1.0)));
    assert!(codes(&json(&["resonance"], &turned)).contains(&"phase_sign".to_owned()));
    let zero = lorentzian(&[(10.0, 1.0)], 101, Some(1.0)) + "0,0.01,0\n";
    let zero = json(&["resonance"], &write(&folder, "zero.csv", &zero));
    assert!(codes(&zero).contains(&"dropped".to_owned()));
    assert!((zero["parameters"]["natural_frequency_hz"]["value"].as_f64().unwrap() - 10.0).abs() < 1e-3);
    let free = write(&folder, "free.csv", &lorentzian(&[(9.4, 1.0)], 101, Some(1.0)));
    let answer = json(
        &["resonance", "--reference", free.to_str().unwrap()],
        &write(&folder, "curve.csv", &lorentzian(&[(10.0, 1.0)], 101, Some(1.0))),
    );
    assert!(codes(&answer).contains(&"reference_differs".to_owned()), "{:?}", codes(&answer));
}

#[test]
fn manifests_that_cannot_be_meant_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let typo = write(&folder, "typo.toml", "stifness = 3\n");
    let said = refused(&["series"], &typo);
    assert!(said.contains("stifness"), "{said}");
    assert!(said.contains("docs/series.md"), "{said}");
    let absent = write(&folder, "absent.toml", "[[measurement]]\nringdown = 'nothing.csv'\ncondition = 1\n");
    assert!(refused(&["series"], &absent).contains("nothing.csv"));
}

#[test]
fn help_of_the_new_commands() {
    for command in ["resonance", "levels", "series"] {
        let text = stdout(slipfit().args(["help", command]));
        insta::assert_snapshot!(format!("help_{command}"), text);
    }
}

/// One screen: every line fits, and the terms are those of the field.
#[test]
fn the_report_fits_the_screen() {
    let free = example(FREE);
    let report = stdout(slipfit().current_dir(root().join("examples")).arg("resonance").arg(SWEEP).args([
        "--reference",
        FREE,
        "--stiffness",
        "10000",
    ]));
    drop(free);
    assert!(report.lines().all(|l| l.chars().count() <= 80), "{report}");
    for word in ["sliding friction force", "drive amplitude", "viscous+sliding", "against", "fit"] {
        assert!(report.contains(word), "{word}: {report}");
    }
}

#[test]
fn a_drive_amplitude_comes_in_a_unit_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..60)
        .map(|i| {
            let f = 97.0 + 0.1 * f64::from(i);
            let z = 1.0 / (1.0 - (f / 100.0_f64).powi(2)).hypot(0.01);
            format!("{f},{z}\n")
        })
        .collect();
    let file = write(&folder, "sweep.csv", &format!("f (Hz),A (nm)\n{rows}"));
    let with = |drive: &str| json(&["resonance", "--drive-amplitude", drive], &file)["parameters"].clone();
    assert_eq!(with("1"), with("1 nm"));
    // A factor of 1000 is exact to rounding.
    let micrometres = with("0.001 \u{b5}m")["drive_amplitude"]["value"].as_f64().unwrap();
    assert!((micrometres - 1.0).abs() < 1e-12, "{micrometres}");
    let said = refused(&["resonance", "--drive-amplitude", "1 V"], &file);
    assert!(said.contains("`V`") && said.contains("`nm`") && said.contains("--unit"), "{said}");
}

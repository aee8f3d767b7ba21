//! `slipfit simulate`, as users see it.

use crate::common::{slipfit, stdout};
use std::fs;
use std::path::Path;

/// Rows of a table, after a check of its header.
fn rows(text: &str, header: &str) -> Vec<Vec<f64>> {
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    assert_eq!(lines.next(), Some(header));
    // An empty cell is NaN.
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
    lines.map(|l| l.split(',').map(number).collect()).collect()
}

fn simulate(args: &str) -> String {
    stdout(slipfit().arg("simulate").args(args.split_whitespace()))
}

/// Status 2, nothing on standard output, and the message.
fn refusal(args: &str) -> String {
    let output = slipfit().arg("simulate").args(args.split_whitespace()).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{args}: {:.300}", String::from_utf8_lossy(&output.stdout));
    assert!(output.stdout.is_empty(), "{args}");
    let said = String::from_utf8(output.stderr).unwrap();
    // Messages are wrapped for the screen.
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn what_simulate_writes_ringdown_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    for (name, more) in [("swing.csv", ""), ("fine.csv", "--quantize-bits 16")] {
        let path = folder.path().join(name);
        let args = "decay --frequency-hz 1.3 --q 70 --friction-displacement 0.004 --unit rad --amplitude 0.5 \
                    --duration 40 --rate-hz 60 --noise-rms 1e-3 --seed 4";
        let written = slipfit()
            .arg("simulate")
            .args(args.split_whitespace())
            .args(more.split_whitespace())
            .arg("--out")
            .arg(&path)
            .assert();
        written.success().stdout("");
        let answer = stdout(slipfit().arg("ringdown").arg(&path).args(["--json", "-"]));
        let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
        let text = answer.to_string();
        assert_eq!(answer["model"].as_str().unwrap_or(&text), "viscous+sliding", "{text}");
        let delta = std::f64::consts::PI * 1.3 / 70.0;
        for (name, truth) in
            [("frequency_hz", 1.3), ("decay_rate_per_s", delta), ("friction_displacement", 0.004)]
        {
            let p = &answer["parameters"][name];
            let (value, error) = (p["value"].as_f64().unwrap(), p["std_error"].as_f64().unwrap());
            assert!((value - truth).abs() < 4.0 * error + 1e-4 * truth, "{name}: {value} ± {error}, {truth}");
            assert!(error < 0.05 * truth, "{name}: {error}");
        }
    }
}

/// Seven digits would leave a rounding of 3e-8 of the amplitude, which a fit of samples without noise sees.
#[test]
fn samples_read_back_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    for (command, header) in [
        ("decay --frequency-hz 1.3 --q 70 --amplitude 2.5e-8 --duration 4 --rate-hz 60", "displacement"),
        (
            "decay --frequency-hz 1.3 --q 70 --amplitude 0.5 --duration 4 --rate-hz 60 --output envelope",
            "amplitude",
        ),
        ("driven --frequency-hz 1 --q 20 --drive-amplitude 1 --duration 4 --rate-hz 50", "displacement"),
    ] {
        simulate(&format!("{command} --out {}", file("a.csv")));
        simulate(&format!("{command} --force --out {}", file("a.npy")));
        let text = fs::read_to_string(file("a.csv")).unwrap();
        let read = rows(&text, &format!("time (s),{header} (m)")).concat();
        let bytes = fs::read(file("a.npy")).unwrap();
        let exact: Vec<f64> = bytes[bytes.len() - 8 * read.len()..]
            .chunks_exact(8)
            .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
            .collect();
        assert!(read == exact, "{command}");
    }
}

#[test]
fn a_release_on_the_other_side_is_the_mirror_image() {
    let base = "decay --frequency-hz 1 --q 50 --beta 0.3 --duration 4 --rate-hz 20 --amplitude";
    let rows = |amplitude: &str| rows(&simulate(&format!("{base} {amplitude}")), "time (s),displacement (m)");
    assert!(rows("1").iter().zip(rows("-1")).all(|(a, b)| a[1] == -b[1]));
    let driven = "driven --frequency-hz 1 --drive-amplitude 1 --duration 4 --rate-hz 20 --off-at 4";
    assert!(refusal(driven).contains("--off-at 4: the record ends before it, at 4 s"));
    let said = refusal(&format!("{base} 0"));
    assert!(said.contains("--beta is a ratio to --amplitude, which is zero hint: --friction-dis"), "{said}");
}

#[test]
fn digits_are_limited_on_request_and_in_text_only() {
    let base = "decay --frequency-hz 1.3 --q 70 --amplitude 0.5 --duration 0.1 --rate-hz 60";
    let text = simulate(&format!("{base} --digits 3"));
    assert!(text.ends_with("0.1,3.43e-1\n"), "{text}");
    let said = refusal(&format!("{base} --digits 3 --out a.npy"));
    assert!(said.contains("--digits 3: only CSV has a number of digits"), "{said}");
    assert!(refusal(&format!("{base} --digits 3 --json -")).contains("--digits 3"));
    assert!(refusal(&format!("{base} --digits 3 --turning-points")).contains("--digits"));
    assert!(refusal(&format!("{base} --digits 18")).contains("18"));
}

#[test]
fn a_driven_record_is_the_exact_steady_motion() {
    let text = simulate(
        "driven --frequency-hz 0.15915494309189535 --q 50 --beta 0.9 --drive-amplitude 1 \
         --drive-frequency-hz 0.15438029479913848 --from steady --duration 200 --rate-hz 40",
    );
    let all = rows(&text, "time (s),displacement (m)");
    assert_eq!(all.len(), 8001);
    let largest = all.iter().map(|r| r[1].abs()).fold(0.0, f64::max);
    // Value of the closed form: X = 4.205794275 at 0.97 omega_0.
    assert!((4.2055..=4.205_795).contains(&largest), "{largest}");
    assert!(text.contains("# friction_ratio = 0.9\n"), "{text:.900}");
    assert!(text.contains("# q_factor = 50\n"), "{text:.900}");
}

#[test]
fn from_rest_the_motion_grows_into_the_steady_one_and_may_be_switched_off() {
    let base = "driven --frequency-hz 1 --q 20 --friction-displacement 0.2 --drive-amplitude 1 \
                --duration 120 --rate-hz 50";
    let all = rows(&simulate(base), "time (s),displacement (m)");
    assert_eq!(all[0], [0.0, 0.0]);
    let largest = |part: &[Vec<f64>]| part.iter().map(|r| r[1].abs()).fold(0.0, f64::max);
    let steady = largest(&all[5000..]);
    assert!((steady / (20.0 * (1.0 - 0.8 / std::f64::consts::PI)) - 1.0).abs() < 0.01, "{steady}");
    let off = rows(&simulate(&format!("{base} --off-at 60")), "time (s),displacement (m)");
    assert!(largest(&off[5500..]) <= 0.2, "at rest within the stick zone");
}

#[test]
fn turning_points_are_those_of_the_closed_form_at_17_digits() {
    let text = simulate(
        "decay --frequency-hz 1 --q 1e9 --friction-displacement 0.03 --amplitude 1 --duration 60 --rate-hz 5 \
         --turning-points",
    );
    let all = rows(&text, "time (s),turning point (m)");
    // 1, -0.94, 0.88 … to the first one within the stick zone.
    assert_eq!(all.len(), 18);
    for (n, row) in all.iter().enumerate() {
        let expected = (1.0 - 0.06 * n as f64) * if n % 2 == 0 { 1.0 } else { -1.0 };
        assert!((row[0] - 0.5 * n as f64).abs() < 1e-12, "{row:?}");
        assert!((row[1] - expected).abs() < 1e-7, "{row:?}");
    }
    assert!(text.lines().last().unwrap().split(',').all(|c| c.split('e').next().unwrap().len() >= 18));

    let slow = simulate(
        "driven --frequency-hz 1 --q 10 --friction-displacement 0.5 --static-displacement 0.6 \
         --drive-amplitude 1 --drive-frequency-hz 0.05 --duration 100 --rate-hz 0.01 --turning-points",
    );
    let points = rows(&slow, "time (s),turning point (m)");
    assert!(points.len() > 8);
    assert!(points.windows(2).all(|w| w[0][0] < w[1][0]));
}

#[test]
fn sweeps_and_levels_show_what_the_equations_say() {
    let fork = "--frequency-hz 32700 --stiffness 1e4 --viscous 20e-6";
    let text =
        simulate(&format!("sweep {fork} --drive-force 1e-7 --start-hz 32680 --stop-hz 32720 --points 41"));
    let all = rows(&text, "frequency (Hz),amplitude (m),phase (deg)");
    assert_eq!((all.len(), all[0][0], all[40][0]), (41, 32680.0, 32720.0));
    // Without friction: Q P/k at resonance, a quarter cycle behind.
    let q = 1e4 / (20e-6 * std::f64::consts::TAU * 32700.0);
    assert!((all[20][1] / (q * 1e-11) - 1.0).abs() < 1e-6, "{:?}", all[20]);
    assert!((all[20][2] + 90.0).abs() < 1e-3, "{:?}", all[20]);
    assert!(all[0][2] > -45.0);
    assert!(all[40][2] < -135.0);

    let up = simulate(
        "sweep --frequency-hz 1 --q 50 --beta 0.5 --drive-amplitude 1 --start-hz 0.94 --stop-hz 1.06 \
         --sweep-time 300 --points 61",
    );
    let down = simulate(
        "sweep --frequency-hz 1 --q 50 --beta 0.5 --drive-amplitude 1 --start-hz 1.06 --stop-hz 0.94 \
         --sweep-time 300 --points 61",
    );
    let top = |text: &str| {
        let all = rows(text, "frequency (Hz),amplitude (m),phase (deg)");
        all.into_iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap()[0]
    };
    assert!(top(&up) > top(&down), "a sweep lags behind");

    let text = simulate(
        "levels --frequency-hz 1 --q 50 --friction-displacement 0.01 --start-amplitude 0.002 \
         --stop-amplitude 0.2 --points 100",
    );
    for row in rows(&text, "drive amplitude (m),amplitude (m),phase (deg)") {
        // Eq. (9), above the threshold; the exact value is slightly higher near it.
        let expected = 50.0 * (row[0] - 0.04 / std::f64::consts::PI);
        match row[0] {
            x if x < 0.01 => assert!(row[1] < 1e-12, "{row:?}"),
            x if x > 0.016 => assert!((row[1] / expected - 1.0).abs() < 0.02, "{row:?} {expected}"),
            _ => {}
        }
        // A mass at rest has no phase.
        let finite: Vec<bool> = row.iter().map(|v| v.is_finite()).collect();
        assert_eq!(finite, [true, true, row[1] > 1e-12], "{row:?}");
    }
}

#[test]
fn levels_at_rest_have_no_phase_and_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let args = "levels --frequency-hz 1 --q 50 --friction-displacement 0.01 --start-amplitude 0.002 \
                --stop-amplitude 0.2 --points 100";
    let text = simulate(args);
    assert!(text.contains("\n0.002,0,\n"), "{text:.900}");
    for name in ["levels.csv", "levels.parquet", "levels.npy"] {
        let path = folder.path().join(name);
        slipfit().arg("simulate").args(args.split_whitespace()).arg("--out").arg(&path).assert().success();
        let mut command = slipfit();
        command.arg("levels").arg(&path);
        if name.ends_with("npy") {
            command.args(["--drive", "1", "--amplitude", "2"]);
        }
        let said = stdout(&mut command);
        assert!(said.contains("100 points, 9"), "{said}");
    }
    let json: serde_json::Value = serde_json::from_str(&simulate(&format!("{args} --json -"))).unwrap();
    assert!(json["columns"][2]["values"][0].is_null());
    assert!(json["columns"][2]["values"][99].is_f64());
}

/// Lines of the header of a record, by name.
fn header<'a>(text: &'a str, name: &str) -> &'a str {
    let found = text.lines().find_map(|line| line.strip_prefix(&format!("# {name} = ")));
    found.unwrap_or_else(|| panic!("{name}: {text:.900}"))
}

/// 15 nN over 10 kN/m is 1.5 pm, whatever the unit of the displacement.
#[test]
fn forces_are_turned_into_the_unit_of_the_displacement() {
    let fork = "--frequency-hz 32700 --stiffness 1e4 --viscous 20e-6 --coulomb-force 15e-9 --static-force 20e-9 \
                --coulomb-force-minus 10e-9";
    let release = "--duration 0.001 --rate-hz 200e3";
    for (unit, m) in [("m", 1.0), ("nm", 1e-9), ("µm", 1e-6)] {
        let amplitude = 25e-9 / m;
        let of_length = |text: &str, name: &str| {
            let (number, of) = header(text, name).split_once(' ').unwrap();
            assert_eq!(of, unit);
            number.parse::<f64>().unwrap() * m
        };
        let is = |found: f64, wanted: f64| {
            assert!((found / wanted - 1.0).abs() < 1e-9, "{unit}: {found} {wanted}")
        };
        let text = simulate(&format!("decay {fork} --unit {unit} --amplitude {amplitude:e} {release}"));
        for (name, wanted) in [
            ("friction_displacement", 1.5e-12),
            ("static_displacement", 2e-12),
            ("friction_displacement_minus", 1e-12),
        ] {
            is(of_length(&text, name), wanted);
        }
        // The header contains the forces that were given.
        assert_eq!(header(&text, "coulomb_force"), "1.5e-8 N");
        assert_eq!(header(&text, "coulomb_force_minus"), "1e-8 N");
        let wave = rows(&text, &format!("time (s),displacement ({unit})"));
        let in_m = rows(
            &simulate(&format!("decay {fork} --amplitude 25e-9 {release}")),
            "time (s),displacement (m)",
        );
        for (a, b) in wave.iter().zip(&in_m) {
            assert!((a[1] * m - b[1]).abs() < 1e-5 * 25e-9, "{unit}: {a:?} {b:?}");
        }
        // A drive by a force, with the resulting --beta.
        let driven = format!("driven {fork} --unit {unit} --drive-force 1.2e-7 {release}");
        let swept = format!(
            "sweep {fork} --unit {unit} --drive-force 1.2e-7 --start-hz 32690 --stop-hz 32710 --points 3"
        );
        for text in [simulate(&driven), simulate(&swept)] {
            is(of_length(&text, "drive_amplitude"), 1.2e-11);
            assert_eq!(header(&text, "drive_force"), "1.2e-7 N");
            is(
                header(&text, "friction_ratio").parse().unwrap(),
                4.0 * 1.5e-12 / (std::f64::consts::PI * 1.2e-11),
            );
        }
        let levels = format!(
            "levels {fork} --unit {unit} --start-amplitude {:e} --stop-amplitude {:e} --points 3",
            1e-12 / m,
            12e-12 / m
        );
        is(of_length(&simulate(&levels), "friction_displacement"), 1.5e-12);
    }
}

/// A force given to the simulation is recovered by the analysis in that unit.
#[test]
fn the_force_that_simulate_was_given_ringdown_finds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fork.csv");
    let args = "decay --frequency-hz 32700 --stiffness 1e4 --viscous 20e-6 --coulomb-force 15e-9 --unit nm \
                --amplitude 25 --duration 0.05 --rate-hz 200e3 --noise-rms 0.3";
    slipfit().arg("simulate").args(args.split_whitespace()).arg("--out").arg(&path).assert().success();
    let answer =
        stdout(slipfit().arg("ringdown").arg(&path).args(["--stiffness", "1e4", "--json", "-", "-q"]));
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    let force = &answer["parameters"]["coulomb_force"];
    let (value, error) = (force["value"].as_f64().unwrap(), force["std_error"].as_f64().unwrap());
    assert!((value - 15e-9).abs() < 4.0 * error && error < 1e-9, "{force}");
}

#[test]
fn of_a_rotation_forces_are_torques() {
    let swing = "decay --frequency-hz 1 --stiffness 0.02 --viscous 1e-5 --coulomb-force 1e-4";
    let text = simulate(&format!("{swing} --unit deg --amplitude 20 --duration 2 --rate-hz 20"));
    let x_f: f64 = header(&text, "friction_displacement").trim_end_matches(" deg").parse().unwrap();
    assert!((x_f / (1e-4f64 / 0.02).to_degrees() - 1.0).abs() < 1e-9, "{x_f}");
    for (name, unit) in [
        ("mass", "kg m²"),
        ("stiffness", "N m/rad"),
        ("viscous_coefficient", "N m s/rad"),
        ("coulomb_force", "N m"),
        ("static_force", "N m"),
    ] {
        assert_eq!(header(&text, name).split_once(' ').unwrap().1, unit, "{name}");
    }
    let text = simulate(
        "sweep --frequency-hz 1 --stiffness 0.02 --q 30 --coulomb-force-minus 2e-5 --unit rad --drive-force 1e-4 \
         --start-hz 0.9 --stop-hz 1.1 --points 3",
    );
    assert_eq!(header(&text, "drive_force"), "0.0001 N m");
    assert_eq!(header(&text, "coulomb_force_minus"), "2e-5 N m");
    assert_eq!(header(&text, "drive_amplitude"), "0.005 rad");
}

#[test]
fn a_unit_that_no_force_over_a_stiffness_has_is_for_displacements_alone() {
    let base = "--frequency-hz 1 --stiffness 100 --q 50";
    let record = "--amplitude 1 --duration 2 --rate-hz 20";
    let drive = "--duration 2 --rate-hz 20";
    let span = "--start-hz 0.9 --stop-hz 1.1 --points 3";
    let levels = "--start-amplitude 1 --stop-amplitude 2 --points 3";
    for unit in ["dB", "furlong", "V"] {
        for args in [
            format!("decay {base} --coulomb-force 1 {record}"),
            format!("decay {base} --static-force 1 {record}"),
            format!("decay {base} --coulomb-force-minus 1 {record}"),
            format!("driven {base} --drive-force 1 {drive}"),
            format!("sweep {base} --drive-force 1 {span}"),
            format!("levels {base} --coulomb-force 1 {levels}"),
        ] {
            let said = refusal(&format!("{args} --unit {unit}"));
            assert!(
                said.contains(&format!("`{unit}`, is neither")) && said.contains("--unit"),
                "{args}: {said}"
            );
        }
        for args in [
            format!("decay {base} --friction-displacement 0.01 {record}"),
            format!("sweep {base} --drive-amplitude 1 {span}"),
        ] {
            let text = simulate(&format!("{args} --unit {unit}"));
            assert!(text.contains(&format!("({unit})")), "{text:.900}");
            assert!(!text.contains("_force = "), "{text:.900}");
        }
    }
}

#[test]
fn what_is_missing_or_too_much_is_named_by_its_flags() {
    let rest = "--amplitude 1 --duration 1 --rate-hz 100";
    for (args, said) in [
        (
            "--frequency-hz 1 --mass 1 --stiffness 4",
            "--mass and --stiffness determine --frequency-hz, and all three are given: leave one of them out",
        ),
        (
            "--frequency-hz 1 --viscous 1",
            "--stiffness is missing: --viscous needs --mass or --stiffness; --q needs neither",
        ),
        (
            "--frequency-hz 1 --coulomb-force 1",
            "a friction force needs --mass or --stiffness; --friction-displacement needs neither",
        ),
        ("--mass 1", "the oscillator is not determined: give --frequency-hz"),
    ] {
        let text = refusal(&format!("decay {args} {rest}"));
        assert!(text.contains(said), "{args}: {text}");
    }
}

#[test]
fn every_format_holds_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let args = "decay --frequency-hz 5 --q 40 --friction-displacement 0.002 --amplitude 1 --duration 2 \
                --rate-hz 100 --noise-rms 0.01 --seed 3";
    let base = || {
        let mut command = slipfit();
        command.arg("simulate").args(args.split_whitespace());
        command
    };
    let csv = rows(&stdout(&mut base()), "time (s),displacement (m)");
    base().arg("--out").arg(at("a.npy")).arg("--json").arg(at("a.json")).assert().success().stdout("");
    base().arg("--out").arg(at("a.wav")).assert().success().stdout("");
    let alone: serde_json::Value = serde_json::from_str(&stdout(base().args(["--json", "-"]))).unwrap();
    let beside: serde_json::Value = serde_json::from_slice(&fs::read(at("a.json")).unwrap()).unwrap();
    assert_eq!(alone, beside);
    assert_eq!(alone["parameters"]["q_factor"]["value"], 40.0);
    assert_eq!(alone["rows"], 201);

    let bytes = fs::read(at("a.npy")).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(npy.shape(), [201, 2]);
    let npy: Vec<f64> = npy.into_vec().unwrap();
    let wav = hound::WavReader::open(at("a.wav")).unwrap();
    assert_eq!(wav.spec().sample_rate, 100);
    let wav: Vec<f32> = wav.into_samples().map(Result::unwrap).collect();
    for (i, row) in csv.iter().enumerate() {
        let json = alone["columns"][1]["values"][i].as_f64().unwrap();
        assert_eq!((npy[2 * i], npy[2 * i + 1]), (row[0], json));
        assert!((json - row[1]).abs() < 1e-6 * json.abs());
        assert!((f64::from(wav[i]) - json).abs() < 1e-6);
    }
    assert!(refusal(&format!("{args} --output envelope --out {}", at("b.wav").display())).contains("sound"));
}

#[test]
fn what_cannot_be_is_named_with_value_and_range() {
    let rest = "--amplitude 1 --duration 1 --rate-hz 100";
    for (args, said) in [
        ("--mass -1 --stiffness 1", &["'-1'", "--mass", "above zero"][..]),
        ("--mass 1 --stiffness 0", &["'0'", "--stiffness", "above zero"]),
        ("--mass nan --stiffness 1", &["'nan'", "--mass", "finite"]),
        ("--mass inf --stiffness 1", &["'inf'", "--mass", "finite"]),
        ("--frequency-hz 1 --q 0.4", &["--q = 0.4", "> 0.5"]),
        ("--frequency-hz 1 --friction-displacement -2", &["'-2'", "--friction-displacement", "negative"]),
        (
            "--mass 1 --stiffness 4 --coulomb-force 2 --static-force 1",
            &["--static-force = 1 ", "--coulomb-force <= --static-force"],
        ),
        (
            "--frequency-hz 1 --friction-displacement 2 --static-displacement 1",
            &["--static-displacement = 1 ", "--friction-displacement <= "],
        ),
        ("--frequency-hz 1 --coulomb-force 1", &["--mass or --stiffness"]),
    ] {
        let text = refusal(&format!("decay {args} {rest}"));
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.iter().all(|s| words.contains(s)), "{args}: {text}");
    }
    let text = refusal(
        "driven --frequency-hz 1 --drive-amplitude 1 --drive-frequency-hz 60 --duration 1 --rate-hz 100",
    );
    assert!(text.contains("--drive-frequency-hz = 60 "), "{text}");
    assert!(text.contains("half the sampling rate"), "{text}");
    let text = refusal("driven --frequency-hz 1 --drive-force 1 --duration 1 --rate-hz 100");
    assert!(text.contains("--drive-force"), "{text}");
    assert!(text.contains("--stiffness"), "{text}");
    let text = refusal(
        "sweep --frequency-hz 1 --q 9 --drive-amplitude 1 --start-hz 0.9 --stop-hz 1.1 --sweep-time 5 --points 50",
    );
    assert!(text.contains("--points = 50 "), "{text}");
    assert!(text.contains("--sweep-time"), "{text}");
}

#[test]
fn help_of_every_command_fits_the_screen_and_reads_well() {
    for command in
        [&["simulate", "driven"][..], &["simulate", "sweep"], &["simulate", "levels"], &["paper"], &["atlas"]]
    {
        let text = stdout(slipfit().arg("help").args(command));
        let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 100).collect();
        assert!(wide.is_empty(), "{wide:#?}");
        insta::assert_snapshot!(format!("help_{}", command.join("_")), text);
    }
    insta::assert_snapshot!("help_simulate", stdout(slipfit().args(["help", "simulate"])));
}

/// The numbers of a Parquet file, row by row, and its metadata.
fn parquet(path: &Path) -> (Vec<String>, Vec<Vec<f64>>, std::collections::HashMap<String, String>) {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let about = reader.metadata().file_metadata();
    let names = about.schema_descr().columns().iter().map(|c| c.name().to_owned()).collect();
    let metadata = about
        .key_value_metadata()
        .unwrap()
        .iter()
        .map(|kv| (kv.key.clone(), kv.value.clone().unwrap()))
        .collect();
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let number = |(_, field): (&String, &parquet::record::Field)| match field {
            parquet::record::Field::Double(v) => *v,
            other => panic!("{other:?}"),
        };
        row.unwrap().get_column_iter().map(number).collect()
    });
    (names, rows.collect(), metadata)
}

#[test]
fn parquet_holds_every_digit_and_every_parameter() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Longer than one row group.
    let args = "driven --mass 0.1 --stiffness 40 --viscous 0.02 --coulomb-force 0.05 --static-force 0.08 \
                --coulomb-force-minus 0.03 --drive-force 0.1 --duration 70 --rate-hz 1000 --noise-rms 1e-4 --seed 5";
    let base = || {
        let mut command = slipfit();
        command.arg("simulate").args(args.split_whitespace());
        command
    };
    base().arg("--out").arg(at("a.parquet")).assert().success().stdout("");
    base().arg("--out").arg(at("b.parquet")).arg("--json").arg(at("b.json")).assert().success().stdout("");
    base().arg("--out").arg(at("a.csv")).assert().success().stdout("");
    let csv_text = fs::read_to_string(at("a.csv")).unwrap();
    let csv = rows(&csv_text, "time (s),displacement (m)");
    let (names, table, about) = parquet(&at("a.parquet"));
    assert_eq!(names, ["time (s)", "displacement (m)"]);
    assert_eq!((table.len(), csv.len()), (70_001, 70_001));
    for (p, c) in table.iter().zip(&csv) {
        assert!(p[0] == c[0], "{p:?} {c:?}");
        assert!((p[1] - c[1]).abs() <= 1e-6 * c[1].abs(), "{p:?} {c:?}");
    }
    assert_eq!(table, parquet(&at("b.parquet")).1);
    let json: serde_json::Value = serde_json::from_slice(&fs::read(at("b.json")).unwrap()).unwrap();
    assert_eq!(json["columns"][1]["values"][777], table[777][1]);
    // Every line of the CSV header is there, unrounded.
    for line in csv_text.lines().filter_map(|l| l.strip_prefix("# ")).skip(1) {
        let (name, value) = line.split_once(" = ").unwrap();
        let there = &about[name];
        let (a, b) = (value.split(' ').next().unwrap(), there.split(' ').next().unwrap());
        match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => assert!((a - b).abs() <= 1e-11 * b.abs(), "{name}: {value} {there}"),
            _ => assert_eq!(value, there, "{name}"),
        }
    }
    assert_eq!(about["command"], "simulate driven");
    assert_eq!(about["coulomb_force_minus"], "0.03 N");
    // The extension determines the format, and so does `--format`.
    let bytes = base().args(["--format", "parquet"]).output().unwrap().stdout;
    assert_eq!(bytes, fs::read(at("a.parquet")).unwrap());
}

#[test]
fn friction_that_differs_by_direction_shifts_the_rest_and_the_middle() {
    let args = "--frequency-hz 1 --q 1e6 --friction-displacement 0.05 --friction-displacement-minus 0.02 \
                --amplitude 1 --duration 30 --rate-hz 100";
    let text = simulate(&format!("decay {args} --turning-points"));
    let turns = rows(&text, "time (s),turning point (m)");
    assert!(text.contains("# friction_displacement_minus = 0.02 m\n"), "{text:.900}");
    // Down against 0.02, up against 0.05: 2 x_F less each time, around the shifted centre.
    for (i, w) in turns.windows(2).enumerate().take(10) {
        let middle = if i % 2 == 0 { 0.02 } else { -0.05 };
        assert!((w[1][1] + w[0][1] - 2.0 * middle).abs() < 1e-5, "{w:?}");
    }
    assert!(text.contains("# stop_time_s = "), "{text:.900}");
    let wave = rows(&simulate(&format!("decay {args}")), "time (s),displacement (m)");
    assert!((wave[50][1] - turns[1][1]).abs() < 1e-6);
    let envelope = rows(&simulate(&format!("decay {args} --output envelope")), "time (s),amplitude (m)");
    // The amplitude falls by 2 (F+ + F-)/2k each half cycle.
    let lost = envelope[0][1] - envelope[500][1];
    assert!((lost / (2.0 * 0.035 * 10.0) - 1.0).abs() < 0.01, "{lost}");
    for (more, said) in [
        ("--static-displacement-minus 0.01", "--static-displacement-minus = 0.01 "),
        ("--static-force-minus 1", "needs a stiffness"),
        ("--friction-displacement-minus -1", "negative"),
    ] {
        let args =
            "decay --frequency-hz 1 --friction-displacement 0.05 --amplitude 1 --duration 3 --rate-hz 10";
        let minus = if more.contains("static-d") { "--friction-displacement-minus 0.02" } else { "" };
        let said_there = refusal(&format!("{args} {minus} {more}"));
        assert!(said_there.contains(said), "{said_there}");
    }
    let settled = "sweep --frequency-hz 1 --q 30 --friction-displacement 0.3 --friction-displacement-minus 0.1 \
                   --drive-amplitude 1 --start-hz 0.9 --stop-hz 1.1 --points 11";
    let top = |text: &str| {
        let all = rows(text, "frequency (Hz),amplitude (m),phase (deg)");
        all.into_iter().map(|r| r[1]).fold(0.0, f64::max)
    };
    // At resonance the mean of the two matters.
    let mean = "sweep --frequency-hz 1 --q 30 --friction-displacement 0.2 --drive-amplitude 1 --start-hz 0.9 \
                --stop-hz 1.1 --points 11";
    assert!((top(&simulate(settled)) / top(&simulate(mean)) - 1.0).abs() < 2e-3);
}

#[test]
fn several_harmonics_and_a_wave_from_a_file_drive_as_they_should() {
    let common = "--frequency-hz 1 --q 20 --friction-displacement 0.3 --duration 40 --rate-hz 50";
    let header = "time (s),displacement (m)";
    // One tone is equivalent to the harmonic drive.
    let one = rows(&simulate(&format!("driven {common} --tone 0.7,1")), header);
    let same =
        rows(&simulate(&format!("driven {common} --drive-amplitude 1 --drive-frequency-hz 0.7")), header);
    assert_eq!(one, same);
    let text = simulate(&format!("driven {common} --tone 0.4,1 --tone 1.2,0.4,90"));
    assert!(
        text.contains("# drive = 1 cos(2 pi 0.4 t + 0 deg) + 0.4 cos(2 pi 1.2 t + 90 deg) m\n"),
        "{text:.900}"
    );
    let two = rows(&text, header);
    // The same waveform sampled finely, interpolated linearly.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("base.csv");
    let mut table = String::from("time (s),position (m)\n");
    for i in 0..=40_000 {
        let t = f64::from(i) * 1e-3;
        let w = std::f64::consts::TAU * t;
        table += &format!("{t:.3},{:.12}\n", (0.4 * w).cos() - 0.4 * (1.2 * w).sin());
    }
    fs::write(&path, table).unwrap();
    let text = simulate(&format!("driven {common} --drive-file {}", path.display()));
    assert!(text.contains("base.csv, 40001 samples, sha256 "), "{text:.900}");
    for (a, b) in two.iter().zip(&rows(&text, header)) {
        assert!((a[1] - b[1]).abs() < 2e-5, "{a:?} {b:?}");
    }
    for (args, said) in [
        ("--tone 0.4", "HZ,X"),
        ("--tone 0,1", "the frequency: must be above zero"),
        ("--tone 0.4,nan", "the amplitude: not a finite number"),
        ("--tone 30,1", "--drive-frequency-hz = 30 "),
        ("--tone 0.4,1,10 --from steady", "--from steady"),
        ("--tone 0.4,1 --drive-frequency-hz 1", "--drive-frequency-hz"),
        ("--drive-file no/such.csv", "no/such.csv"),
        ("--drive-amplitude 1 --drive-force 1", "cannot be used with"),
        ("", "--drive-amplitude"),
    ] {
        let text = refusal(&format!("driven {common} {args}"));
        assert!(text.contains(said), "{args}: {text}");
    }
    let text = refusal("driven --frequency-hz 1 --beta 0.5 --tone 1,1 --duration 1 --rate-hz 50");
    assert!(text.contains("--beta"), "{text}");
    assert!(text.contains("--drive-amplitude"), "{text}");
}

#[test]
fn a_sweep_stepped_too_fast_has_not_settled() {
    let args = "sweep --frequency-hz 1 --q 100 --friction-displacement 0.2 --drive-amplitude 1 --start-hz 0.97 \
                --stop-hz 1.03 --points 31";
    let column = |more: &str| -> Vec<f64> {
        let text = simulate(&format!("{args} {more}"));
        rows(&text, "frequency (Hz),amplitude (m),phase (deg)").iter().map(|r| r[1]).collect()
    };
    let (settled, long, short) = (column(""), column("--wait 400"), column("--wait 1"));
    let off = |a: &[f64]| a.iter().zip(&settled).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(off(&long) < 1e-3, "{} {}", off(&long), off(&short));
    assert!(off(&short) > 0.1, "{} {}", off(&long), off(&short));
    assert!(refusal(&format!("{args} --wait -1")).contains("--wait"));
    assert!(refusal(&format!("{args} --wait 1 --sweep-time 9")).contains("--sweep-time"));
    let text = simulate(
        "levels --frequency-hz 1 --q 50 --friction-displacement 0.01 --start-amplitude 0.02 --stop-amplitude 0.1 \
         --points 9 --wait 300",
    );
    assert!(text.contains("# wait_s = 300\n"), "{text:.600}");
}

#[test]
fn json_keeps_to_its_schema() {
    let validator = jsonschema::draft202012::new(&crate::common::schema("simulate")).unwrap();
    for args in [
        "decay --frequency-hz 5 --friction-displacement 0.002 --amplitude 1 --duration 1 --rate-hz 20",
        "decay --frequency-hz 5 --q 40 --amplitude 1 --duration 1 --rate-hz 20 --quantize-bits 8 --turning-points",
        "driven --mass 1 --stiffness 4 --coulomb-force 0.1 --coulomb-force-minus 0.2 --tone 0.2,1 --tone 0.6,1,9 \
         --duration 2 --rate-hz 10",
        "sweep --frequency-hz 1 --q 9 --drive-amplitude 1 --start-hz 0.9 --stop-hz 1.1 --points 5",
        "levels --frequency-hz 1 --q 9 --start-amplitude 0.1 --stop-amplitude 1 --points 3 --wait 2",
        // At rest, without a phase.
        "levels --frequency-hz 1 --friction-displacement 1 --start-amplitude 0.1 --stop-amplitude 0.2 --points 3",
    ] {
        let text = simulate(&format!("{args} --json -"));
        let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
        let errors: Vec<String> =
            validator.iter_errors(&answer).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(errors.is_empty(), "{args}: {errors:#?}");
        for column in answer["columns"].as_array().unwrap() {
            assert_eq!(column["values"].as_array().unwrap().len() as u64, answer["rows"].as_u64().unwrap());
        }
        // The validator is able to refuse.
        let mut broken = answer.clone();
        broken["rows"] = "many".into();
        assert!(!validator.is_valid(&broken));
        broken.as_object_mut().unwrap().remove("rows");
        assert!(!validator.is_valid(&broken));
    }
}

#[test]
fn json_reads_like_this() {
    let text = simulate(
        "driven --mass 1 --stiffness 4 --viscous 0.1 --coulomb-force 0.1 --static-force 0.15 --drive-force 1 \
         --drive-frequency-hz 0.2 --duration 1 --rate-hz 5 --json -",
    );
    let mut answer: serde_json::Value = serde_json::from_str(&text).unwrap();
    answer["version"] = "[version]".into();
    for value in answer["columns"][1]["values"].as_array_mut().unwrap() {
        // Sines differ in their last digit between systems.
        *value = format!("{:.9}", value.as_f64().unwrap()).parse::<f64>().unwrap().into();
    }
    insta::assert_snapshot!("json_simulate_driven", serde_json::to_string_pretty(&answer).unwrap());
}

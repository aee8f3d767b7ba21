//! The command on measured files: each resonance curve gives a result in its expected range or a warning.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod common;

use common::{slipfit, stdout};
use serde_json::Value;
use std::time::Duration;

slipfit_real_data::tests! {
    pohl_wheel_forced,
    pohl_wheel_raw_runs,
    torsion_pendulum_forced,
    torsion_pendulum_forced_frequency,
    wheel_with_a_jump_is_flagged,
    compound_pendulum_in_its_own_unit,
    quartz_in_decibels,
    akiyama_tuning_fork,
    sloshing_tank_is_near_linear,
    bolted_beam_loses_its_quality_with_the_force,
    the_real_table_1,
    the_real_table_1_from_raw_runs,
    every_command_given_for_a_real_file_runs,
}

fn answer(file: &str, more: &[&str]) -> Value {
    let file = slipfit_real_data::path("sweep").join(file);
    let text = stdout(slipfit().arg("resonance").arg(file).args(["--json", "-"]).args(more));
    serde_json::from_str(&text).unwrap()
}

fn value(answer: &Value, name: &str) -> f64 {
    answer["parameters"][name]["value"].as_f64().unwrap_or_else(|| panic!("{name}: {}", answer["parameters"]))
}

fn in_band(answer: &Value, name: &str, [low, high]: [f64; 2]) {
    let value = value(answer, name);
    assert!((low..=high).contains(&value), "{name} = {value} outside {low} to {high}");
}

fn codes(answer: &Value) -> Vec<&str> {
    answer["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

fn pohl_wheel_forced() {
    let a = answer("pohl_forced_400mA.csv", &[]);
    in_band(&a, "natural_frequency_hz", [0.518, 0.524]);
    in_band(&a, "decay_rate_per_s", [0.203, 0.213]);
    in_band(&a, "friction_displacement", [1.6e-3, 3.4e-3]);
    in_band(&a, "drive_amplitude", [0.061, 0.064]);
}

fn pohl_wheel_raw_runs() {
    let a = answer("pohl_forced_400mA_raw", &[]);
    assert_eq!(a["input"]["records"].as_array().unwrap().len(), 13);
    in_band(&a, "natural_frequency_hz", [0.518, 0.524]);
    in_band(&a, "decay_rate_per_s", [0.203, 0.213]);
    in_band(&a, "drive_amplitude", [0.061, 0.064]);
}

fn torsion_pendulum_forced() {
    let a = answer("torsion_forced.csv", &[]);
    in_band(&a, "q_factor", [57.0, 65.0]);
}

fn torsion_pendulum_forced_frequency() {
    let a = answer("torsion_forced.csv", &[]);
    in_band(&a, "natural_frequency_hz", [0.9560, 0.9570]);
}

fn wheel_with_a_jump_is_flagged() {
    let a = answer("wheel_period_amplitude_jump.csv", &[]);
    assert!(codes(&a).contains(&"jump"), "{:?}", codes(&a));
}

fn compound_pendulum_in_its_own_unit() {
    let a = answer("compound_pendulum_rad_per_s.csv", &["--frequency-unit", "rad/s"]);
    in_band(&a, "natural_frequency_hz", [0.690, 0.704]);
    // The total loss, to which bearings and air contribute.
    let whole = a["paper"]["effective_q_factor"].as_f64().unwrap();
    assert!((3.7..=4.5).contains(&whole), "{whole}");
    let viscous = ["--frequency-unit", "rad/s", "--model", "viscous"];
    let a = answer("compound_pendulum_rad_per_s.csv", &viscous);
    in_band(&a, "q_factor", [3.7, 4.5]);
    let untold = answer("compound_pendulum_rad_per_s.csv", &[]);
    let notes = untold["input"]["notes"].to_string();
    assert!(notes.contains("frequency_unit gives another"), "{notes}");
}

fn quartz_in_decibels() {
    let a = answer("quartz_10MHz_dB.txt", &["--band", "9.9975e6", "10.001e6"]);
    in_band(&a, "natural_frequency_hz", [9.99915e6, 9.99935e6]);
    in_band(&a, "q_factor", [8400.0, 10_200.0]);
}

fn akiyama_tuning_fork() {
    let a = answer("akiyama_tuning_fork_nanonis.dat", &[]);
    in_band(&a, "natural_frequency_hz", [30_280.0, 30_282.0]);
    in_band(&a, "q_factor", [1090.0, 1340.0]);
}

fn sloshing_tank_is_near_linear() {
    let a = answer("sloshing_near_linear.txt", &[]);
    assert!(!codes(&a).contains(&"jump"), "{:?}", codes(&a));
    in_band(&a, "natural_frequency_hz", [0.158, 0.160]);
    // Hz/%²: softening, 0.7 % of the frequency at the highest amplitude of 1.8 %.
    in_band(&a, "frequency_shift_by_amplitude", [-4.0e-4, -3.0e-4]);
}

/// Micro-slip in the joint: the loss increases with the drive.
fn bolted_beam_loses_its_quality_with_the_force() {
    let q = [1, 2, 3, 4].map(|level| {
        let table = format!("FRdata.ForceControl({level})");
        value(&answer("bolted_beam_force_levels.mat", &["--sheet", &table, "--model", "viscous"]), "q_factor")
    });
    assert!(q.windows(2).all(|w| w[1] < w[0]), "{q:?}");
    assert!((235.0..=310.0).contains(&q[0]), "{q:?}");
    assert!((70.0..=115.0).contains(&q[3]), "{q:?}");
}

/// Table 1 from real data: ring-down and resonance of one wheel at one brake current.
fn table_1(sweep: &str) -> Value {
    let data = slipfit_real_data::folder();
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("pohl.toml");
    let text = format!(
        "title = \"Pohl wheel\"\ncondition = \"brake current\"\ncondition_unit = \"mA\"\nshared = [\"natural_frequency\"]\n\
         [[measurement]]\nringdown = '{}'\ncondition = 400\n[[measurement]]\nsweep = '{}'\ncondition = 400\n",
        data.join("ringdown/pohl_brake_400mA.csv").display(),
        data.join("sweep").join(sweep).display()
    );
    std::fs::write(&manifest, text).unwrap();
    let text = stdout(slipfit().arg("series").arg(&manifest).args(["--json", "-"]));
    serde_json::from_str(&text).unwrap()
}

fn agrees(answer: &Value) {
    let row = &answer["table"][0];
    let of = |way: &str, what: &str, key: &str| row[way][what][key].as_f64().unwrap();
    let (ring, swept) = (of("ringdown", "damping", "value"), of("resonance", "damping", "value"));
    assert!((ring / swept - 1.0).abs() < 0.02, "delta {ring} and {swept}");
    let (ring, swept) = (of("ringdown", "friction", "value"), of("resonance", "friction", "value"));
    let joint = of("ringdown", "friction", "std_error").hypot(of("resonance", "friction", "std_error"));
    assert!((ring - swept).abs() < 2.0 * joint, "x_F {ring} and {swept}, ± {joint}");
    let sweep = &answer["measurements"][1]["parameters"]["drive_amplitude"]["value"].as_f64().unwrap();
    assert!((0.061..=0.064).contains(sweep), "x_0 {sweep}");
}

fn the_real_table_1() {
    agrees(&table_1("pohl_forced_400mA.csv"));
}

fn the_real_table_1_from_raw_runs() {
    agrees(&table_1("pohl_forced_400mA_raw"));
}

/// Files that the command refuses, immediately and with a reason.
const REFUSED: &[(&str, &str)] = &[
    ("spring_no_time_column.csv", "invalid value 'RATE'"),
    // Fewer than two cycles; no oscillation at all.
    ("seismometer_near_critical.txt", "not a ring-down"),
    // The log of a refrigerator.
    ("kinxy.lvm", "not a ring-down"),
    ("L_slow_drift_inspect_hangs.txt", "not a ring-down"),
    ("pisa_quadrifilar.txt", "no column could be the signal"),
    // Three swings of a hand-held telephone.
    ("lynch_acc.csv", "fewer than three amplitudes"),
];

/// Running time after which a command counts as hanging.
const HANGS: Duration = Duration::from_secs(20);

/// `inspect` ends on every file, even on one without an oscillation, and the command that it suggests answers or
/// refuses with a reason.
fn every_command_given_for_a_real_file_runs() {
    for folder in ["ringdown", "sweep", "simulated"] {
        let data = slipfit_real_data::path(folder);
        for entry in std::fs::read_dir(&data).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if path.is_dir() || name.ends_with(".md") {
                continue;
            }
            let inspect = &mut slipfit();
            let text = stdout(inspect.current_dir(&data).args(["inspect", &name]).timeout(HANGS));
            let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
            assert!(wide.is_empty(), "{name}: {wide:#?}");
            let command = text.lines().last().unwrap().strip_prefix("> slipfit ").unwrap();
            let swept = folder == "sweep" || folder == "simulated" && b"DGHI".contains(&name.as_bytes()[0]);
            let verb = if swept { "resonance" } else { "ringdown" };
            assert!(command.starts_with(verb), "{name}: {command}");
            let mut run = slipfit();
            run.current_dir(&data).args(command.split(' '));
            if let Some((_, reason)) = REFUSED.iter().find(|(refused, _)| *refused == name) {
                let output = run.timeout(HANGS).output().unwrap();
                let said = String::from_utf8(output.stderr).unwrap();
                assert_eq!(output.status.code(), Some(2), "{name}: {said}");
                assert!(said.split_whitespace().collect::<Vec<_>>().join(" ").contains(reason), "{said}");
                continue;
            }
            let report = stdout(&mut run);
            let wide: Vec<&str> = report.lines().filter(|l| l.chars().count() > 80).collect();
            assert!(wide.is_empty(), "{name}: {wide:#?}");
        }
    }
}

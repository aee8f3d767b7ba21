//! Resonance curves that somebody measured: each lands in its band, or is flagged.
//!
//! They are no part of the repository; `SLIPFIT_REAL_DATA` says where they are.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod common;

use common::{root, slipfit};
use serde_json::Value;
use std::path::PathBuf;

fn data() -> Option<PathBuf> {
    let folder =
        std::env::var_os("SLIPFIT_REAL_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    if folder.join("sweep").is_dir() {
        return Some(folder);
    }
    #[allow(clippy::print_stderr, reason = "a skipped test must show")]
    {
        eprintln!("SKIPPED: no real data at {}; set SLIPFIT_REAL_DATA", folder.display());
    }
    None
}

fn answer(file: &str, more: &[&str]) -> Option<Value> {
    let file = data()?.join("sweep").join(file);
    let output = slipfit().arg("resonance").arg(file).args(["--json", "-"]).args(more).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).unwrap())
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

#[test]
fn pohl_wheel_forced() {
    let Some(a) = answer("pohl_forced_400mA.csv", &[]) else { return };
    in_band(&a, "natural_frequency_hz", [0.518, 0.524]);
    in_band(&a, "decay_rate_per_s", [0.203, 0.213]);
    in_band(&a, "friction_displacement", [1.6e-3, 3.4e-3]);
    in_band(&a, "drive_amplitude", [0.061, 0.064]);
}

#[test]
fn pohl_wheel_raw_runs() {
    let Some(a) = answer("pohl_forced_400mA_raw", &[]) else { return };
    assert_eq!(a["input"]["records"].as_array().unwrap().len(), 13);
    in_band(&a, "natural_frequency_hz", [0.518, 0.524]);
    in_band(&a, "decay_rate_per_s", [0.203, 0.213]);
    in_band(&a, "drive_amplitude", [0.061, 0.064]);
}

#[test]
fn torsion_pendulum_forced() {
    let Some(a) = answer("torsion_forced.csv", &[]) else { return };
    in_band(&a, "q_factor", [57.0, 65.0]);
}

#[test]
fn torsion_pendulum_forced_frequency() {
    let Some(a) = answer("torsion_forced.csv", &[]) else { return };
    in_band(&a, "natural_frequency_hz", [0.9560, 0.9570]);
}

#[test]
fn wheel_with_a_jump_is_flagged() {
    let Some(a) = answer("wheel_period_amplitude_jump.csv", &[]) else { return };
    assert!(codes(&a).contains(&"jump"), "{:?}", codes(&a));
}

#[test]
fn compound_pendulum_in_its_own_unit() {
    let Some(a) = answer("compound_pendulum_rad_per_s.csv", &["--frequency-unit", "rad/s"]) else { return };
    in_band(&a, "natural_frequency_hz", [0.690, 0.704]);
    // The whole loss; bearings and air have their part in it.
    let whole = a["paper"]["effective_q_factor"].as_f64().unwrap();
    assert!((3.7..=4.5).contains(&whole), "{whole}");
    let viscous = ["--frequency-unit", "rad/s", "--model", "viscous"];
    let Some(a) = answer("compound_pendulum_rad_per_s.csv", &viscous) else { return };
    in_band(&a, "q_factor", [3.7, 4.5]);
    let Some(untold) = answer("compound_pendulum_rad_per_s.csv", &[]) else { return };
    let notes = untold["input"]["notes"].to_string();
    assert!(notes.contains("--frequency-unit"), "{notes}");
}

#[test]
fn quartz_in_decibels() {
    let Some(a) = answer("quartz_10MHz_dB.txt", &["--band", "9.9975e6", "10.001e6"]) else { return };
    in_band(&a, "natural_frequency_hz", [9.99915e6, 9.99935e6]);
    in_band(&a, "q_factor", [8400.0, 10_200.0]);
}

#[test]
fn akiyama_tuning_fork() {
    let Some(a) = answer("akiyama_tuning_fork_nanonis.dat", &[]) else { return };
    in_band(&a, "natural_frequency_hz", [30_280.0, 30_282.0]);
    in_band(&a, "q_factor", [1090.0, 1340.0]);
}

#[test]
fn sloshing_tank_is_near_linear() {
    let Some(a) = answer("sloshing_near_linear.txt", &[]) else { return };
    assert!(!codes(&a).contains(&"jump"), "{:?}", codes(&a));
    let shift = a["parameters"]["duffing"]["value"].as_f64().unwrap_or(0.0);
    assert!(shift.is_finite());
}

/// Micro-slip in its joint: the harder it is driven, the more of it is lost.
#[test]
fn bolted_beam_loses_its_quality_with_the_force() {
    let q: Vec<f64> = (1..=4)
        .map_while(|level| {
            let table = format!("FRdata.ForceControl({level})");
            let more = ["--sheet", &table, "--model", "viscous"];
            Some(value(&answer("bolted_beam_force_levels.mat", &more)?, "q_factor"))
        })
        .collect();
    if let [first, .., last] = q[..] {
        assert!(q.windows(2).all(|w| w[1] < w[0]), "{q:?}");
        assert!((235.0..=310.0).contains(&first) && (70.0..=115.0).contains(&last), "{q:?}");
    }
}

/// The real Table 1: ring-down and resonance of one wheel at one brake current.
fn table_1(sweep: &str) -> Option<Value> {
    let data = data()?;
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("pohl.toml");
    let text = format!(
        "title = \"Pohl wheel\"\ncondition = \"brake current\"\ncondition_unit = \"mA\"\nshared = [\"natural_frequency\"]\n\
         [[measurement]]\nringdown = '{}'\ncondition = 400\n[[measurement]]\nsweep = '{}'\ncondition = 400\n",
        data.join("ringdown/pohl_brake_400mA.csv").display(),
        data.join("sweep").join(sweep).display()
    );
    std::fs::write(&manifest, text).unwrap();
    let output = slipfit().arg("series").arg(&manifest).args(["--json", "-"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).unwrap())
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

#[test]
fn the_real_table_1() {
    if let Some(answer) = table_1("pohl_forced_400mA.csv") {
        agrees(&answer);
    }
}

#[test]
fn the_real_table_1_from_raw_runs() {
    if let Some(answer) = table_1("pohl_forced_400mA_raw") {
        agrees(&answer);
    }
}

//! Measured resonance curves are read with the expected columns, units and frequencies.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::path::PathBuf;

use slipfit_io::{ReadOptions, SweepReading, read_sweep};

slipfit_real_data::tests! {
    real_sweeps_are_read_right,
    real_raw_runs_become_the_curve_made_of_them_by_hand,
}

fn sweep(file: &str) -> PathBuf {
    slipfit_real_data::path("sweep").join(file)
}

fn columns(reading: &SweepReading) -> Vec<(&'static str, usize, &str)> {
    reading.report.taken.iter().map(|(w, t)| (*w, t.column.number, t.unit.as_str())).collect()
}

struct Expected {
    file: &'static str,
    columns: &'static [(&'static str, usize, &'static str)],
    points: usize,
    unit: &'static str,
    /// Frequency of the first and of the last row, Hz.
    first_hz: f64,
    last_hz: f64,
}

#[rustfmt::skip]
const EXPECTED: &[Expected] = &[
    Expected { file: "pohl_forced_400mA.csv", columns: &[("frequency", 1, "Hz"), ("amplitude", 2, "rad"), ("phase", 3, "deg"), ("drive", 4, "")], points: 13, unit: "rad", first_hz: 0.19195, last_hz: 0.99825 },
    Expected { file: "torsion_forced.csv", columns: &[("frequency", 1, "Hz"), ("amplitude", 2, "rev"), ("phase", 3, "deg"), ("drive", 4, "")], points: 25, unit: "rev", first_hz: 0.938417, last_hz: 0.974986 },
    Expected { file: "wheel_period_amplitude_jump.csv", columns: &[("period", 1, "s"), ("amplitude", 2, "")], points: 20, unit: "", first_hz: 0.8333, last_hz: 0.7722 },
    Expected { file: "compound_pendulum_rad_per_s.csv", columns: &[("frequency", 2, "Hz"), ("amplitude", 3, "")], points: 646, unit: "", first_hz: 7.713867, last_hz: 1.227734 },
    Expected { file: "quartz_10MHz_dB.txt", columns: &[("frequency", 1, "Hz"), ("amplitude", 2, ""), ("phase", 3, "deg")], points: 18001, unit: "", first_hz: 9_987_268.0, last_hz: 10_005_268.0 },
    Expected { file: "akiyama_tuning_fork_nanonis.dat", columns: &[("shift", 1, "Hz"), ("centre", 2, "Hz"), ("amplitude", 3, "m"), ("phase", 4, "deg")], points: 256, unit: "m", first_hz: 30_244.8, last_hz: 30_321.0 },
    Expected { file: "reed_four_columns", columns: &[("frequency", 1, "Hz"), ("amplitude", 4, ""), ("phase", 2, "rad")], points: 701, unit: "", first_hz: 130.0, last_hz: 158.0 },
    Expected { file: "sloshing_near_linear.txt", columns: &[("frequency", 1, "rad/s"), ("amplitude", 2, "%"), ("phase", 3, "deg")], points: 26, unit: "%", first_hz: 0.153_743, last_hz: 0.161_470 },
];

fn real_sweeps_are_read_right() {
    for want in EXPECTED {
        let reading =
            read_sweep(&[sweep(want.file)], &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let file = want.file;
        assert_eq!(columns(&reading), want.columns, "{file}: {:?}", reading.report.notes);
        assert_eq!((reading.curve.len(), reading.curve.unit()), (want.points, want.unit), "{file}");
        let f = reading.curve.frequency_hz();
        assert!((f[0] / want.first_hz - 1.0).abs() < 1e-4, "{file}: starts at {}", f[0]);
        assert!((f[f.len() - 1] / want.last_hz - 1.0).abs() < 1e-4, "{file}: ends at {}", f[f.len() - 1]);
    }
}

fn real_raw_runs_become_the_curve_made_of_them_by_hand() {
    let by_hand = read_sweep(&[sweep("pohl_forced_400mA.csv")], &ReadOptions::default()).unwrap().curve;
    let raw = read_sweep(&[sweep("pohl_forced_400mA_raw")], &ReadOptions::default()).unwrap();
    assert_eq!((raw.curve.len(), raw.curve.unit(), raw.report.files_left_out), (13, "rad", 0));
    let why = |what: &str| raw.report.column(what).unwrap().why.clone();
    assert_eq!(why("response"), "column 4 `Weg &b_A1 / rad`: named like a position");
    assert_eq!(why("drive"), "column 3 `Spannung U_B1 / V`: a measured signal next to the response");
    let slipfit::resonance::Response::Complex(hand) = by_hand.response() else { panic!() };
    let slipfit::resonance::Response::Complex(ours) = raw.curve.response() else { panic!() };
    for (i, run) in raw.report.records.iter().enumerate() {
        let f = run.steady.frequency_hz.value;
        let j = (0..13).min_by(|a, b| {
            (by_hand.frequency_hz()[*a] - f).abs().total_cmp(&(by_hand.frequency_hz()[*b] - f).abs())
        });
        let j = j.unwrap();
        // Another interval of the same run, without harmonics.
        assert!((by_hand.frequency_hz()[j] / f - 1.0).abs() < 2e-3, "{}: {f}", run.path);
        let relative = ours[i] / hand[j];
        assert!((relative.norm() - 1.0).abs() < 0.03, "{}: {relative}", run.path);
        assert!(relative.arg().abs() < 0.06, "{}: {relative}", run.path);
        assert!(run.steady.cycles >= 4.0, "{run:?}");
    }
}

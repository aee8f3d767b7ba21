//! The exact motion compared with forty-digit references (`reference/motion`).

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, EventKind, Harmonic, Motion};
use std::f64::consts::TAU;

const FREE: &str = include_str!("../reference/motion/free_decay.txt");
const DRIVES: &str = include_str!("../reference/motion/drives.txt");
const DRIVEN: &str = include_str!("../reference/motion/driven.txt");

/// The numbers of a line; the parser rounds the forty digits correctly to a double.
fn rows(text: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_whitespace().map(|w| w.parse().expect("a number")).collect())
}

fn oscillator(delta: f64, x_f: f64, x_s: f64) -> Oscillator {
    Oscillator::builder()
        .omega_0(1.0)
        .decay_rate_per_s(delta)
        .friction_displacement(x_f)
        .static_displacement(x_s)
        .build()
        .expect("a reference oscillator")
}

#[test]
fn free_decays_hold_to_1e_12_after_ten_thousand_half_cycles() {
    let mut count = 0;
    for row in rows(FREE) {
        let [delta, x_f, x_s, x_0, n, turn_time, turn, t, x, v] = row[..] else { panic!("{row:?}") };
        let o = oscillator(delta, x_f, x_s);
        let decay = FreeDecay::from_rest(&o, x_0).unwrap();
        let point = decay.turning_point(n as u64);
        let (xx, vv) = decay.state(t);
        assert!((point.position - turn).abs() < 2e-15, "{row:?} {point:?}");
        assert!((point.time_s / turn_time - 1.0).abs() < 2e-16 || n == 0.0);
        // The time of each row is exactly a double, so it adds no error.
        assert!((xx - x).abs() < 1e-14, "{row:?} {xx} {vv}");
        assert!((vv - v).abs() < 1e-14, "{row:?} {xx} {vv}");

        let mut motion = Motion::new(&o, Drive::none(), 0.0, x_0, 0.0).unwrap();
        let turns: Vec<_> = motion.events(turn_time * (1.0 + 1e-15)).collect();
        assert_eq!(turns.len(), n as usize, "{row:?}");
        if let Some(last) = turns.last() {
            assert!((last.position - turn).abs() < 1e-12, "{row:?} {last:?}");
            if turn.abs() <= x_s && x_s > 0.0 {
                assert_eq!(last.kind, EventKind::Rest);
            }
        }
        let s = motion.state_at(t).unwrap();
        assert!((s.position - x).abs() < 1e-12, "{row:?} {s:?}");
        assert!((s.velocity - v).abs() < 1e-12, "{row:?} {s:?}");
        count += 1;
    }
    assert_eq!(count, 47);
}

#[test]
fn driven_motions_hold_to_1e_12_after_a_thousand_cycles() {
    let mut worst: f64 = 0.0;
    let mut count = 0;
    for row in rows(DRIVEN) {
        let [delta, x_f, x_s, omega, x_0, v_0, _, t, x, v, stops] = row[..] else { panic!("{row:?}") };
        let o = oscillator(delta, x_f, x_s);
        let drive = Drive::harmonic(1.0, omega).unwrap();
        let mut motion = Motion::new(&o, drive, 0.0, x_0, v_0).unwrap();
        let mut counted = 0;
        let mut amplitude: f64 = 0.0;
        for e in motion.events(t) {
            counted += usize::from(e.kind == EventKind::Stop || e.kind == EventKind::Rest);
            if e.time_s > t - 2.0 * std::f64::consts::PI / omega {
                amplitude = amplitude.max(e.position.abs());
            }
        }
        let s = motion.state_at(t).unwrap();
        let error = (s.position - x).abs().max((s.velocity - v).abs() / omega.max(1.0));
        worst = worst.max(error / amplitude.max(1e-300));
        assert_eq!(counted as f64, stops, "{row:?}");
        count += 1;
    }
    assert_eq!(count, 54);
    assert!(worst < 1e-12, "{worst}");
}

fn tones(all: &[(f64, f64, f64)]) -> Drive {
    let all: Vec<Harmonic> =
        all.iter().map(|&(amplitude, omega, phase)| Harmonic { amplitude, omega, phase }).collect();
    Drive::harmonics(0.0, &all).unwrap()
}

/// The values of one cycle, repeated for the length of the reference.
fn samples(step: f64, cycle: &[f64]) -> Drive {
    let count = 1000 * cycle.len() + 2;
    let time_s = (0..count).map(|i| step * i as f64).collect();
    Drive::sampled(time_s, (0..count).map(|i| cycle[i % cycle.len()]).collect()).unwrap()
}

#[test]
fn sums_of_harmonics_drives_switched_off_and_samples_hold_to_1e_12() {
    // As in drives_reference.py: oscillator, drive, start, and the span of one cycle.
    let three = [(0.8, 1.0, 0.0), (0.4, 0.6180339887498949, 0.5), (0.3, 2.23606797749979, 1.5)];
    let trapeze = [0.0, 1.0, 1.0, 0.0, -1.0, -1.0];
    let off = |w, phase, at| tones(&[(1.0, w, phase)]).until(at).unwrap();
    type Case = ((f64, f64, f64), Drive, f64, f64, f64);
    let cases: [Case; 9] = [
        ((0.05, 0.2, 0.2), tones(&[(1.0, 0.9, 0.3), (0.5, 2.7, 1.0)]), 0.0, 0.0, TAU / 0.9),
        ((0.1, 0.5, 0.6), tones(&[(1.0, 0.4, 0.0), (0.4, 1.2, 2.0)]), 0.2, 0.0, TAU / 0.4),
        ((0.02, 0.3, 0.35), tones(&three), 0.0, 0.4, TAU),
        ((1.0 / 2e5, 0.3, 0.3), tones(&[(1.0, 1.0, 0.0), (0.2, 3.0, 0.7)]), 0.0, 0.0, TAU),
        ((1.0 / 2e3, 0.3, 0.3), off(1.0, 0.0, 6284.1), 0.0, 0.0, TAU),
        ((0.05, 0.5, 0.65), off(0.3, 0.0, 20947.3), 0.0, 0.0, TAU / 0.3),
        ((0.2, 0.1, 0.12), off(0.8, 0.4, 7855.7), 0.1, 0.0, TAU / 0.8),
        ((0.05, 0.2, 0.2), samples(1.75, &[0.0, 1.0, 0.0, -1.0]), 0.3, 0.0, 7.0),
        ((0.1, 0.4, 0.5), samples(3.0, &trapeze), 0.0, 0.0, 18.0),
    ];
    let (mut count, mut worst) = (0, 0.0f64);
    for row in rows(DRIVES) {
        let [case, _, t, x, v, stops] = row[..] else { panic!("{row:?}") };
        let ((delta, x_f, x_s), drive, x_0, v_0, cycle) = &cases[case as usize];
        let mut motion =
            Motion::new(&oscillator(*delta, *x_f, *x_s), drive.clone(), 0.0, *x_0, *v_0).unwrap();
        let (mut counted, mut amplitude) = (0, 0.0f64);
        for e in motion.events(t) {
            counted += usize::from(matches!(e.kind, EventKind::Stop | EventKind::Rest));
            // Relative to the amplitude of the recent motion; for a ring-down, to the motion before the drive was
            // switched off.
            if e.time_s > t.min(1000.0 * cycle) - 2.0 * cycle {
                amplitude = amplitude.max(e.position.abs());
            }
        }
        let s = motion.state_at(t).unwrap();
        let error = (s.position - x).abs().max((s.velocity - v).abs()) / amplitude;
        assert_eq!(counted as f64, stops, "{row:?}");
        assert!(error < 1e-12, "{row:?} {s:?} {error:e}");
        worst = worst.max(error);
        count += 1;
    }
    assert_eq!(count, 37);
    assert!(worst > 0.0);
}

//! The exact motion against forty-digit references (`reference/motion`).

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use slipfit::Oscillator;
use slipfit::decay::FreeDecay;
use slipfit::simulate::{Drive, EventKind, Motion};

const FREE: &str = include_str!("../../../reference/motion/free_decay.txt");
const DRIVEN: &str = include_str!("../../../reference/motion/driven.txt");

/// Numbers of a line; the forty digits beyond a double are rounded correctly by the parser.
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
        // The time of each row is a double: nothing is lost there.
        assert!((xx - x).abs() < 1e-14 && (vv - v).abs() < 1e-14, "{row:?} {xx} {vv}");

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
        assert!((s.position - x).abs() < 1e-12 && (s.velocity - v).abs() < 1e-12, "{row:?} {s:?}");
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

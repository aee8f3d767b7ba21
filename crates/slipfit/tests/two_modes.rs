//! Records of two modes: the friction of the stronger one is found, and none is claimed where there is none.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use slipfit::motion::decay::FreeDecay;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{Oscillator, Parameter, Record};
use std::f64::consts::{PI, TAU};

const FREQUENCY_HZ: f64 = 1.7;

/// Normal noise from sums of uniform ones.
fn noise(seed: &mut u64) -> f64 {
    let mut uniform = || {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

struct Truth {
    decay_rate: f64,
    friction_displacement: f64,
}

/// A decay of amplitude 1 with a sliding share of the loss, a second viscous mode, and noise.
fn record(q: f64, share: f64, [strength, ratio]: [f64; 2], noise_rms: f64, seed: u64) -> (Record, Truth) {
    let omega = TAU * FREQUENCY_HZ;
    let decay_rate = PI * FREQUENCY_HZ / q;
    let friction_displacement = share / (1.0 - share) * decay_rate * (PI / 2.0) / omega;
    let oscillator = Oscillator::kinematic(omega, decay_rate, friction_displacement).unwrap();
    let decay = FreeDecay::from_rest(&oscillator, 1.0).unwrap();
    let duration_s = 2.5 / decay_rate * (1.0 - share);
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ seed;
    let time: Vec<f64> =
        (0..(duration_s * 20.0 * FREQUENCY_HZ) as usize).map(|i| i as f64 / (20.0 * FREQUENCY_HZ)).collect();
    let signal = time
        .iter()
        .map(|&t| {
            let second = strength * (-decay_rate * t).exp() * (omega * ratio * t + 0.7).cos();
            decay.displacement(t) + second + noise_rms * noise(&mut state)
        })
        .collect();
    (Record::new(time, signal).unwrap(), Truth { decay_rate, friction_displacement })
}

/// In a default analysis each parameter lies within four standard errors, and the second mode is found at its
/// frequency.
fn second_is_found(q: f64, share: f64, second: [f64; 2], noise_rms: f64) {
    for seed in 0..3 {
        let (record, truth) = record(q, share, second, noise_rms, seed);
        let answer = analyse(&record, &Options::default()).unwrap();
        let case = format!("Q {q}, share {share}, second {second:?}, seed {seed}");
        let found = answer.second_mode.as_ref().unwrap_or_else(|| panic!("{case}: {:?}", answer.warnings));
        let ratio = found.frequency.value / FREQUENCY_HZ;
        assert!((ratio - second[1]).abs() < 0.05 * (second[1] - 1.0), "{case}: {ratio}");
        assert!((found.amplitude.value / second[0] - 1.0).abs() < 0.2, "{case}: {:?}", found.amplitude);
        let close = |parameter, truth: f64| {
            let q = answer.parameter(parameter).unwrap();
            assert!((q.value - truth).abs() < 4.0 * q.std_error, "{case}: {parameter} {q:?} for {truth}");
        };
        close(Parameter::DECAY_RATE, truth.decay_rate);
        close(Parameter::FRICTION_DISPLACEMENT, truth.friction_displacement);
        assert_eq!(answer.sliding.detected, share > 0.0, "{case}: p = {}", answer.sliding.p_value);
    }
}

#[test]
fn a_mode_a_fifth_as_strong_and_15_percent_off_is_subtracted() {
    second_is_found(100.0, 0.0, [0.2, 1.15], 0.01);
    second_is_found(100.0, 0.3, [0.2, 1.15], 0.01);
}

#[test]
fn a_mode_of_2_percent_3_percent_off_is_subtracted() {
    second_is_found(300.0, 0.0, [0.02, 1.03], 0.01);
    second_is_found(300.0, 0.3, [0.02, 1.03], 0.01);
}

#[test]
fn one_mode_with_friction_is_no_pair() {
    for share in [0.0, 0.2, 0.7] {
        let answer: Answer =
            analyse(&record(100.0, share, [0.0, 1.3], 0.003, 7).0, &Options::default()).unwrap();
        assert_eq!(answer.second_mode, None, "share {share}");
    }
}

//! Simulated ring-downs with known true values on which a default analysis easily goes wrong: each answer agrees with
//! the true values.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::f64::consts::{PI, TAU};

use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{LossTerm, Parameter, SignalKind};
use slipfit_io::{ReadOptions, read};

const FREQUENCY_HZ: f64 = 1.7;

/// Decay rate and friction displacement (mm) from Q and the sliding share of the loss at 1 mm.
fn truth(q: f64, share: f64) -> [f64; 2] {
    let delta = PI * FREQUENCY_HZ / q;
    [delta, share / (1.0 - share) * delta * (PI / 2.0) / (TAU * FREQUENCY_HZ)]
}

slipfit_real_data::tests! {
    a_rest_after_a_start_in_mid_swing,
    twenty_seconds_of_decay_in_449,
    a_side_minimum_with_many_samples,
    a_side_minimum_with_few_swings,
    a_friction_too_weak_to_be_seen_stays_in_the_errors,
    drag_alone_is_no_viscous_decay,
    the_noise_of_an_amplitude_is_no_friction,
    beats_of_two_viscous_modes_are_no_friction,
}

fn analysed(file: &str, kind: SignalKind) -> Answer {
    let path = slipfit_real_data::path("simulated").join(file);
    let record = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}")).record;
    let mut options = Options::default();
    options.frequency_hz = (kind == SignalKind::Envelope).then_some(FREQUENCY_HZ);
    analyse(&record.with_kind(kind), &options).unwrap_or_else(|e| panic!("{e}"))
}

/// The answer lies within four of its standard errors of the true values.
fn holds(file: &str, [delta, x_f]: [f64; 2]) -> Answer {
    let answer = analysed(file, SignalKind::Displacement);
    for (parameter, truth) in [(Parameter::DECAY_RATE, delta), (Parameter::FRICTION_DISPLACEMENT, x_f)] {
        let q = answer.parameter(parameter).unwrap();
        assert!((q.value - truth).abs() < 4.0 * q.std_error, "{parameter:?}: {q:?} for {truth}");
        let [low, high] = q.interval_95;
        assert!((low..=high).contains(&q.value), "{parameter:?}: {q:?}");
        let row = answer.comparison.iter().find(|c| c.model == answer.model).unwrap();
        let shown = row.value(parameter);
        assert!((shown - q.value).abs() < 1e-6 * q.std_error.max(shown), "{parameter:?}: {shown}, {q:?}");
    }
    answer
}

/// As [`holds`], and the standard errors are below half of the values.
fn determines(file: &str, truth: [f64; 2]) {
    let answer = holds(file, truth);
    for parameter in [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT] {
        let q = answer.parameter(parameter).unwrap();
        assert!(q.std_error < 0.5 * q.value, "{parameter:?}: {q:?}");
    }
}

fn a_rest_after_a_start_in_mid_swing() {
    determines("A_q5_rest_midphase.csv", truth(5.0, 0.2));
}

fn twenty_seconds_of_decay_in_449() {
    determines("B_longrest_q300_40dB_i0.csv", truth(300.0, 0.7));
}

fn a_side_minimum_with_many_samples() {
    determines("C_localmin_Q30_s0.2_60dB_L3_spc200_i5.csv", truth(30.0, 0.2));
}

fn a_side_minimum_with_few_swings() {
    determines("C_localmin_Q30_s0.7_40dB_L3_spc6_i1.csv", truth(30.0, 0.7));
    determines("C_localmin_Q30_s0.7_40dB_L8_spc6_i0.csv", truth(30.0, 0.7));
}

fn a_friction_too_weak_to_be_seen_stays_in_the_errors() {
    holds("E_postselection_Q30_share.2_20dB.npy", truth(30.0, 0.2));
}

fn drag_alone_is_no_viscous_decay() {
    let answer = analysed("J_pure_drag_pd0.csv", SignalKind::Displacement);
    assert!(answer.preferred_model.has(LossTerm::Drag), "{}", answer.preferred_model);
    let drag = answer.parameter(Parameter::DRAG_RATE).unwrap();
    assert!((drag.value - 0.03).abs() < 4.0 * drag.std_error, "{drag:?}");
}

fn the_noise_of_an_amplitude_is_no_friction() {
    let answer = analysed("F_envelope_false_friction.csv", SignalKind::Envelope);
    assert!(!answer.sliding.detected, "p = {}", answer.sliding.p_value);
}

fn beats_of_two_viscous_modes_are_no_friction() {
    let answer = analysed("K_beats_two_viscous_modes.csv", SignalKind::Displacement);
    assert!(!answer.sliding.detected, "p = {}", answer.sliding.p_value);
    let second = answer.second_mode.as_ref().unwrap();
    for (frequency, hz) in
        [(answer.parameter(Parameter::Frequency).unwrap(), 0.7076), (&second.frequency, 0.73)]
    {
        assert!((frequency.value - hz).abs() < 1e-4, "{frequency:?}");
    }
    for decay_rate in [answer.parameter(Parameter::DECAY_RATE).unwrap(), &second.decay_rate] {
        assert!((decay_rate.value - 0.012).abs() < 3e-4, "{decay_rate:?}");
    }
}

//! Friction that decreases with speed, and contacts that yield before they slide: simulated and recovered.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod laws;
mod noise;

use laws::{noisy, options, scatters_about};
use slipfit::motion::simulate::Drive;
use slipfit::motion::simulate::smooth::SmoothMotion;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{LossModel, LossTerm, Oscillator, Parameter};
use std::f64::consts::PI;

const OMEGA: f64 = 6.0;
const SEEDS: u64 = 4;

fn times() -> Vec<f64> {
    (0..6000).map(|i| 0.05 * f64::from(i)).collect()
}

/// Decay from 1 under viscous loss, sliding friction and the excess of friction at low speed, as displacements; the
/// excess decreases around the velocity `v_s`.
fn stribeck(delta: f64, x_f: f64, more: f64, v_s: f64) -> Vec<f64> {
    let o = Oscillator::kinematic(OMEGA, delta, x_f + more).unwrap();
    // The oscillator has the friction at rest; the law subtracts the decrease with speed.
    let law = move |v: f64| more / (1.0 + (v / v_s).powi(2)) - more;
    let mut motion = SmoothMotion::new(&o, law, Drive::none(), 0.0, 1.0, 0.0).unwrap();
    times().iter().map(|&t| motion.state_at(t).unwrap().position).collect()
}

/// Decay from 1 under viscous loss and Dahl's friction of contacts that break at `break_amplitude`.
fn dahl(delta: f64, x_f: f64, break_amplitude: f64) -> Vec<f64> {
    let slopes = |[x, v, f]: [f64; 3]| {
        // The force over the stiffness; its slope along the path is x_F/A_b.
        let force = v * x_f / break_amplitude * (1.0 - f / x_f * v.signum());
        [v, -OMEGA * OMEGA * (x + f) - 2.0 * delta * v, force]
    };
    let step = 0.05 / 200.0;
    let along = |y: [f64; 3], k: [f64; 3], h: f64| [y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]];
    let mut state = [1.0, 0.0, -x_f];
    times()
        .iter()
        .map(|_| {
            let here = state[0];
            for _ in 0..200 {
                let a = slopes(state);
                let b = slopes(along(state, a, 0.5 * step));
                let c = slopes(along(state, b, 0.5 * step));
                let d = slopes(along(state, c, step));
                let mean: Vec<f64> = (0..3).map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0).collect();
                state = along(state, [mean[0], mean[1], mean[2]], step);
            }
            here
        })
        .collect()
}

fn answers(motion: &[f64], noise: f64, options: &Options) -> Vec<Answer> {
    (1..=SEEDS).map(|seed| analyse(&noisy(&times(), motion, noise, seed), options).unwrap()).collect()
}

#[test]
fn friction_that_falls_with_speed_is_found_again() {
    let (x_f, more, v_s) = (0.0006, 0.0012, 1.0);
    let motion = stribeck(0.002, x_f, more, v_s);
    let found = answers(&motion, 0.003, &options("viscous+sliding+stribeck"));
    // The loss at the initial amplitude, from asinh(z)/(z sqrt(1 + z²)).
    let z = OMEGA / v_s;
    let rate = 2.0 * OMEGA * more / PI * z.asinh() / (z * (1.0 + z * z).sqrt());
    scatters_about("rate", rate, &found, Parameter::Loss(LossTerm::Stribeck));
    scatters_about("velocity", v_s / OMEGA, &found, Parameter::StribeckVelocityRatio);
    scatters_about("x_F", x_f, &found, Parameter::FRICTION_DISPLACEMENT);
    scatters_about("delta", 0.002, &found, Parameter::DECAY_RATE);
}

#[test]
fn contacts_that_yield_are_found_again() {
    let (x_f, break_amplitude) = (0.0012, 0.08);
    let motion = dahl(0.002, x_f, break_amplitude);
    let found = answers(&motion, 0.003, &options("viscous+presliding"));
    for answer in &found {
        // Both refer to the amplitude at which the free decay begins.
        let first = answer.parameter(Parameter::InitialAmplitude).unwrap().value;
        let held = |parameter, truth: f64| {
            let over = answer.parameter(parameter).unwrap().value * first / truth;
            assert!((over - 1.0).abs() < 0.02, "{parameter:?}: {over}");
        };
        let a = first / break_amplitude;
        held(Parameter::Loss(LossTerm::Presliding), 2.0 * OMEGA * x_f / PI * (1.0 - a.tanh() / a));
        held(Parameter::BreakAmplitudeRatio, break_amplitude);
        let delta = answer.parameter(Parameter::DECAY_RATE).unwrap();
        assert!((delta.value - 0.002).abs() < 4.0 * delta.std_error, "{delta:?}");
    }
}

/// Each law is named if it acts, and the compared laws leave a misfit.
#[test]
fn the_law_that_acts_is_named() {
    for (motion, noise, term) in [
        (stribeck(0.0005, 0.0002, 0.0015, 0.6), 1e-4, LossTerm::Stribeck),
        (dahl(0.002, 0.0015, 0.15), 3e-4, LossTerm::Presliding),
    ] {
        let answer = analyse(&noisy(&times(), &motion, noise, 1), &Options::default()).unwrap();
        let named = answer.warnings.iter().find(|w| w.code() == "further_law");
        let hint = &named.expect("a law is named").hints()[0];
        let Some(slipfit::answer::hint::HintValue::Text(model)) = &hint.value else { panic!("{hint:?}") };
        let model: LossModel = model.parse().unwrap();
        assert!(model.has(term), "{model}");
    }
}

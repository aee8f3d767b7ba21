//! A loss proportional to a power of the amplitude, simulated and recovered with its exponent.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod laws;
mod noise;

use laws::{noisy, options, scatters_about};
use slipfit::motion::simulate::Drive;
use slipfit::motion::simulate::smooth::SmoothMotion;
use slipfit::ringdown::{Answer, Criteria, Options, analyse, analyse_with};
use slipfit::{LossTerm, Oscillator, Parameter, resonance};
use std::f64::consts::PI;

const POWER: Parameter = Parameter::Loss(LossTerm::Power);
const OMEGA: f64 = 6.0;
const SEEDS: u64 = 8;

/// A record released from `start` under viscous loss and a force `c |v|^n` that reduces the initial amplitude by the
/// part `rate` per second.
fn record(delta: f64, rate: f64, n: f64, start: f64) -> (Vec<f64>, Vec<f64>) {
    // a_n = (2 c omega^(n-1)/pi) times the integral of sin^(n+1) over a quarter turn, c per mass.
    let steps = 20_000;
    let sine = |i: i32| (PI / 2.0 * (f64::from(i) + 0.5) / f64::from(steps)).sin();
    let integral: f64 = (0..steps).map(|i| sine(i).powf(n + 1.0)).sum::<f64>() * PI / 2.0 / f64::from(steps);
    let c = rate * start.powf(1.0 - n) * PI / (2.0 * OMEGA.powf(n - 1.0) * integral);
    let o = Oscillator::kinematic(OMEGA, delta, 0.0).unwrap();
    let law = move |_: f64, v: f64| c * v.abs().powf(n) * v.signum() / (OMEGA * OMEGA);
    let mut motion = SmoothMotion::with_position(&o, law, Drive::none(), 0.0, start, 0.0).unwrap();
    let time_s: Vec<f64> = (0..4000).map(|i| 0.05 * f64::from(i)).collect();
    let signal = time_s.iter().map(|&t| motion.state_at(t).unwrap().position).collect();
    (time_s, signal)
}

#[test]
fn rate_and_exponent_are_found_again() {
    for (n, rate, start) in [(0.5, 0.006, 0.4), (1.5, 0.01, 0.4), (2.5, 0.01, 400.0)] {
        let (time_s, motion) = record(0.0, rate, n, start);
        let answers = |options: &Options, criteria: &Criteria| -> Vec<Answer> {
            let noisy = |s| noisy(&time_s, &motion, 0.01 * start, s);
            (1..=SEEDS).map(|s| analyse_with(&noisy(s), options, criteria).unwrap()).collect()
        };
        for (band_hz, method) in [(None, "waveform"), (Some([0.5, 2.0]), "waveform"), (None, "envelope")] {
            let (mut options, mut criteria) = (options("power"), Criteria::default());
            options.band_hz = band_hz;
            if method == "envelope" {
                criteria.waveform.most_samples = 0;
            }
            let found = answers(&options, &criteria);
            assert!(
                found.iter().all(|a| a.diagnostics.method == method && a.model == options.model.unwrap())
            );
            scatters_about(&format!("{method}, n = {n}: n"), n, &found, Parameter::LossExponent);
            if band_hz.is_none() {
                scatters_about(&format!("{method}, n = {n}: rate"), rate, &found, POWER);
            }
            let off = |a: &Answer| (a.parameter(POWER).unwrap().value / rate - 1.0).abs();
            assert!(found.iter().all(|a| off(a) < 0.05), "{method}, n = {n}");
            let exponent = found[0].parameter(Parameter::LossExponent).unwrap();
            assert!(exponent.std_error < 0.1, "{exponent:?}");
            let [low, high] = exponent.interval_95;
            assert!(low < exponent.value);
            assert!(exponent.value < high);
            assert!((0.0..=4.0).contains(&low));
            assert!(high <= 4.0);
        }
    }
}

#[test]
fn beside_viscous_loss_as_well() {
    let (time_s, motion) = record(0.004, 0.02, 2.5, 1.0);
    let answers: Vec<Answer> = (1..=SEEDS)
        .map(|s| analyse(&noisy(&time_s, &motion, 0.003, s), &options("viscous+power")).unwrap())
        .collect();
    scatters_about("n", 2.5, &answers, Parameter::LossExponent);
    scatters_about("rate", 0.02, &answers, POWER);
    scatters_about("delta", 0.004, &answers, Parameter::DECAY_RATE);
}

/// The shape parameter counts: a model with the power law has two more parameters.
#[test]
fn the_exponent_counts_as_a_parameter() {
    let (time_s, motion) = record(0.01, 0.0, 1.5, 1.0);
    for seed in 1..=SEEDS {
        let answer = analyse(&noisy(&time_s, &motion, 0.01, seed), &options("viscous+power")).unwrap();
        let free = |name: &str| {
            let model = name.parse().unwrap();
            answer.comparison.iter().find(|c| c.model == model).map(|c| c.free_parameters)
        };
        let viscous = free("viscous").unwrap();
        if let Some(both) = free("viscous+power") {
            assert_eq!(both, viscous + 2);
        }
        // A viscous decay is still described as viscous.
        assert_eq!(answer.preferred_model, slipfit::LossModel::VISCOUS);
    }
}

#[test]
fn a_resonance_curve_has_no_such_law() {
    let frequency: Vec<f64> = (0..40).map(|i| 0.9 + 0.005 * f64::from(i)).collect();
    let amplitude = frequency.iter().map(|f| 1.0 / ((1.0 - f * f).powi(2) + 1e-3).sqrt()).collect();
    let curve = resonance::Curve::builder(frequency, amplitude).build().unwrap();
    let mut options = resonance::Options::default();
    options.model = Some("viscous+power".parse().unwrap());
    let refused = resonance::analyse(&curve, &options).unwrap_err().to_string();
    assert!(refused.contains("free decays"), "{refused}");
}

/// A loss that is not a polynomial of the amplitude leaves curved residuals: the power law is tried and named.
#[test]
fn a_bow_names_the_power_law() {
    let (time_s, motion) = record(0.0, 0.01, 3.5, 1.0);
    let record = noisy(&time_s, &motion, 1e-4, 1);
    let answer = analyse(&record, &Options::default()).unwrap();
    let found = answer.warnings.iter().find(|w| w.code() == "further_law").expect("named");
    let hint = &found.hints()[0];
    assert_eq!(hint.option, Some("model"));
    let Some(slipfit::answer::hint::HintValue::Text(model)) = &hint.value else { panic!("{hint:?}") };
    let reported = analyse(&record, &options(model)).unwrap();
    let n = reported.parameter(Parameter::LossExponent).unwrap();
    assert!((n.value - 3.5).abs() < 0.1, "{n:?}");
    assert!(reported.diagnostics.residual_excess < 0.5 * answer.diagnostics.residual_excess);
}

/// If the compared laws hold, no other law is tried.
#[test]
fn no_other_law_is_named_where_those_compared_hold() {
    let (time_s, motion) = record(0.01, 0.02, 2.0, 1.0);
    for seed in 1..=SEEDS {
        let answer = analyse(&noisy(&time_s, &motion, 0.003, seed), &Options::default()).unwrap();
        assert!(answer.warnings.iter().all(|w| w.code() != "further_law"), "{:?}", answer.warnings);
    }
}

//! Simulated resonance curves with known true values on which a default analysis easily goes wrong: each answer
//! agrees with the true values.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::f64::consts::{FRAC_PI_4, PI};

use slipfit::Parameter;
use slipfit::answer::Warning;
use slipfit::resonance::{Answer, DriveAmplitude, Options, analyse};
use slipfit_io::{ReadOptions, read_sweep};

slipfit_real_data::tests! {
    no_background_is_added_to_a_broad_line_without_one,
    a_weak_background_is_found_or_counted,
    a_delay_and_a_background_are_told_apart,
    a_background_under_amplitudes_is_no_friction,
}

fn simulated(file: &str, drive: Option<f64>) -> Answer {
    let mut options = Options::default();
    options.drive_amplitude = drive.map(|value| DriveAmplitude { value, std_error: 0.0 });
    let path = slipfit_real_data::path("simulated").join(file);
    let reading = read_sweep(&[path], &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    analyse(&reading.curve, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// Curves of 5 Hz driven with 1 mm: decay rate and friction displacement lie within four of their standard errors of
/// the true values, and the values lie in their intervals.
fn holds(answer: &Answer, q: f64, beta: f64) {
    let delta = PI * 5.0 / q;
    for (parameter, truth) in
        [(Parameter::DECAY_RATE, delta), (Parameter::FRICTION_DISPLACEMENT, FRAC_PI_4 * beta)]
    {
        let found = answer.parameter(parameter).unwrap();
        let [low, high] = found.interval_95;
        assert!((low..=high).contains(&found.value), "{parameter:?}: {found:?}");
        assert!((found.value - truth).abs() < 4.0 * found.std_error, "{parameter:?}: {found:?} for {truth}");
    }
}

fn no_background_is_added_to_a_broad_line_without_one() {
    for drive in [None, Some(1.0)] {
        let answer = simulated("D_false_background_Q10_b0.9.csv", drive);
        holds(&answer, 10.0, 0.9);
        assert!(answer.instrument.background.is_none(), "{:?}", answer.instrument);
    }
}

fn a_weak_background_is_found_or_counted() {
    for drive in [None, Some(1.0)] {
        let answer = simulated("G_background_1.5pct_Q100_beta0.5.csv", drive);
        holds(&answer, 100.0, 0.5);
        assert!(answer.sliding.detected, "{:?}", answer.sliding);
    }
}

fn a_delay_and_a_background_are_told_apart() {
    for drive in [None, Some(1.0)] {
        let answer = simulated("H_delay_and_background_Q100_beta0.5.csv", drive);
        holds(&answer, 100.0, 0.5);
        assert!(answer.instrument.background.is_some());
        assert!(answer.instrument.delay_s.is_some());
        assert!(answer.sliding.detected, "{:?}", answer.sliding);
    }
}

fn a_background_under_amplitudes_is_no_friction() {
    for drive in [None, Some(1.0)] {
        let answer = simulated("I_background_5pct_amplitude_beta0.csv", drive);
        holds(&answer, 100.0, 0.0);
        assert!(!answer.sliding.detected, "{:?}", answer.sliding);
        let says = |w: &Warning| {
            matches!(
                w,
                Warning::Background { .. } | Warning::RivalInstrument { .. } | Warning::ShapeAlone { .. }
            )
        };
        assert!(answer.warnings.iter().any(says), "{:?}", answer.warnings);
    }
}

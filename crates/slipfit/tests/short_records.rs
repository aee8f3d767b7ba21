//! Records too short to distinguish viscous from sliding loss must not give small errors for either.

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use slipfit::Parameter;
use slipfit::motion::simulate::{Drive, Motion};
use slipfit::{Oscillator, Record, ringdown};

#[test]
fn three_cycles_do_not_claim_a_friction_they_cannot_know() {
    let o =
        Oscillator::builder().frequency_hz(0.8).q_factor(90.0).friction_displacement(2e-3).build().unwrap();
    let time_s: Vec<f64> = (0..190).map(|i| 0.02 * f64::from(i)).collect();
    let mut state = 88_172_645_463_325_252_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut covered = 0;
    for _ in 0..20 {
        let mut signal = vec![0.0; time_s.len()];
        Motion::new(&o, Drive::none(), 0.0, 0.3, 0.0).unwrap().fill(&time_s, &mut signal).unwrap();
        signal.iter_mut().for_each(|v| *v += 1e-3 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0));
        let record = Record::new(time_s.clone(), signal).unwrap();
        let answer = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
        assert!(answer.warnings.iter().any(|w| w.code() == "too_few_cycles"), "{:?}", answer.warnings);
        let [low, high] = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().interval_95;
        covered += usize::from((low..=high).contains(&2e-3));
    }
    // Of twenty 95 % intervals, fewer than 16 cover the true value once in four hundred times.
    assert!(covered >= 16, "{covered} of 20");
}

/// Friction stops the motion after four and a half cycles with equally many samples each.
#[test]
fn a_motion_that_friction_stops_soon_has_cycles_enough() {
    let o =
        Oscillator::builder().frequency_hz(1.7).q_factor(20.0).friction_displacement(0.04).build().unwrap();
    let time_s: Vec<f64> = (0..119).map(|i| f64::from(i) / 7.65).collect();
    let mut signal = vec![0.0; time_s.len()];
    Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap().fill(&time_s, &mut signal).unwrap();
    for (i, x) in signal.iter_mut().enumerate() {
        *x += 0.01 * (7.0 * (i * i) as f64).sin();
    }
    let record = Record::new(time_s, signal).unwrap();
    let answer = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
    let codes: Vec<&str> = answer.warnings.iter().map(|w| w.code()).collect();
    assert!(!codes.contains(&"too_few_cycles") && !codes.contains(&"coarse_sampling"), "{codes:?}");
    let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
    assert!((x_f.interval_95[0]..=x_f.interval_95[1]).contains(&0.04), "{x_f:?}");
}

#[test]
fn a_part_outside_of_the_record_is_called_that() {
    let time_s: Vec<f64> = (0..100).map(f64::from).collect();
    let signal = time_s.iter().map(|t| (0.7 * t).cos()).collect();
    let record = Record::new(time_s, signal).unwrap();
    for (start_s, end_s) in [(Some(500.0), None), (None, Some(-5.0))] {
        let mut options = ringdown::Options::default();
        (options.start_s, options.end_s) = (start_s, end_s);
        let error = ringdown::analyse(&record, &options).unwrap_err().to_string();
        assert!(error.ends_with("the record extends from 0 s to 99 s"), "{error}");
    }
}

use super::*;
use crate::Oscillator;
use crate::motion::simulate::{Drive, Motion};
use crate::motion::steady::scan::reading;

/// A fixed pseudo-random sequence, uniform in -1 to 1.
fn noise(n: usize) -> Vec<f64> {
    let mut state = 88_172_645_463_325_252_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    (0..n).map(|_| next()).collect()
}

fn clock(samples: usize, rate_hz: f64) -> Vec<f64> {
    (0..samples).map(|i| i as f64 / rate_hz).collect()
}

#[test]
fn the_steady_motion_with_sliding_friction_is_the_exact_one() {
    let oscillator = Oscillator::kinematic(2.0, 0.05, 0.02).unwrap();
    let omega = 1.95;
    let drive = Drive::harmonic(0.1, omega).unwrap();
    let mut motion = Motion::new(&oscillator, drive, 0.0, 0.3, 0.0).unwrap();
    let time = clock(6000, 20.0);
    let mut response = vec![0.0; time.len()];
    motion.fill(&time, &mut response).unwrap();
    let drive: Vec<f64> = time.iter().map(|t| 0.5 * (omega * t).cos()).collect();
    let point = demodulate(&time, &response, Some(&drive), &Options::default()).unwrap();
    let exact = reading(&oscillator, 0.1, omega / std::f64::consts::TAU).unwrap();
    assert!((point.amplitude.value / exact.amplitude() - 1.0).abs() < 1e-4, "{point:?} {exact:?}");
    assert!((point.phase_rad.as_ref().unwrap().value - exact.phase_rad().unwrap()).abs() < 1e-4);
    assert!(point.settled, "{}", point.transient_s);
    assert!(point.transient_s > 50.0, "{}", point.transient_s);
    assert!(point.transient_s < 250.0, "{}", point.transient_s);
}

#[test]
fn noise_is_answered_with_honest_errors() {
    let time = clock(3000, 25.0);
    let drive: Vec<f64> = time.iter().map(|t| (4.0 * t + 0.3).sin()).collect();
    let (mut far, mut runs) = (0.0, 0.0);
    let all = noise(40 * 3000);
    for part in all.chunks_exact(3000) {
        let response: Vec<f64> =
            time.iter().zip(part).map(|(t, e)| 0.4 * (4.0 * t + 0.3 - 2.0).sin() + 0.05 * e).collect();
        let point = demodulate(&time, &response, Some(&drive), &Options::default()).unwrap();
        assert_eq!(point.transient_s, 0.0);
        far += ((point.amplitude.value - 0.4) / point.amplitude.std_error).powi(2);
        let phase = point.phase_rad.unwrap();
        far += ((phase.value + 2.0) / phase.std_error).powi(2);
        runs += 2.0;
    }
    // Mean square of 80 standard normals: 1 with a spread of 0.16.
    assert!((0.5..1.5).contains(&(far / runs)), "{}", far / runs);
}

#[test]
fn a_record_that_never_settles_says_so() {
    let time = clock(400, 10.0);
    let drive: Vec<f64> = time.iter().map(|t| (3.0 * t).cos()).collect();
    let response: Vec<f64> =
        time.iter().map(|t| 0.2 * (3.0 * t).cos() - 0.2 * (-0.01 * t).exp() * (2.9 * t).cos()).collect();
    assert!(!demodulate(&time, &response, Some(&drive), &Options::default()).unwrap().settled);
}

#[test]
fn without_a_drive_there_is_an_amplitude_and_no_phase() {
    let time = clock(2000, 20.0);
    let response: Vec<f64> = time.iter().map(|t| 0.2 * (3.0 * t).cos() + 1.0 + 0.01 * t).collect();
    let point = demodulate(&time, &response, None, &Options::default()).unwrap();
    assert!((point.amplitude.value - 0.2).abs() < 1e-9);
    assert!(point.phase_rad.is_none());
    assert!((point.frequency_hz.value * std::f64::consts::TAU - 3.0).abs() < 1e-9);
    let constant = vec![-0.5; 2000];
    assert!(demodulate(&time, &response, Some(&constant), &Options::default()).unwrap().phase_rad.is_none());
}

#[test]
fn a_start_given_is_taken_as_given() {
    let time = clock(2000, 20.0);
    let response: Vec<f64> = time.iter().map(|t| 0.2 * (3.0 * t).cos()).collect();
    let options = Options { start_s: Some(40.0), end_s: Some(80.0), ..Options::default() };
    let point = demodulate(&time, &response, Some(&response), &options).unwrap();
    assert_eq!((point.start_s, point.end_s, point.samples), (40.0, 80.0, 801));
}

#[test]
fn what_cannot_be_demodulated_is_refused() {
    let time = clock(100, 10.0);
    let slow: Vec<f64> = time.iter().map(|t| (0.3 * t).cos()).collect();
    let options = Options::default();
    assert!(matches!(demodulate(&time, &slow, Some(&slow), &options), Err(Error::NoSteadyMotion { .. })));
    assert!(matches!(
        demodulate(&time, &[0.0; 100], None, &options),
        Err(Error::NoSteadyMotion { cycles: 0.0, .. })
    ));
    assert!(matches!(demodulate(&time, &slow[1..], None, &options), Err(Error::Length { .. })));
    assert!(matches!(demodulate(&time[..9], &slow[..9], None, &options), Err(Error::TooFewSamples { .. })));
    let back: Vec<f64> = time.iter().rev().copied().collect();
    assert!(matches!(demodulate(&back, &slow, None, &options), Err(Error::TimeBackwards { .. })));
    let mut holed = slow.clone();
    holed[7] = f64::NAN;
    assert!(matches!(demodulate(&time, &holed, None, &options), Err(Error::Parameter { .. })));
}

#[test]
fn a_drive_that_changes_its_speed_is_followed() {
    let time = clock(3000, 20.0);
    let phase = |t: f64| 3.0 * t + 4e-5 * (t - 75.0).powi(2);
    let drive: Vec<f64> = time.iter().map(|&t| phase(t).cos()).collect();
    let response: Vec<f64> = time.iter().map(|&t| 0.2 * (phase(t) - 0.7).cos()).collect();
    let point = demodulate(&time, &response, Some(&drive), &Options::default()).unwrap();
    assert!((point.amplitude.value - 0.2).abs() < 1e-5, "{point:?}");
    assert!((point.phase_rad.as_ref().unwrap().value + 0.7).abs() < 1e-4);
    // Root mean square of a rate of 8e-5 rad/s² about its mean.
    let wander = 8e-5 * 0.5 * (point.end_s - point.start_s) / 3f64.sqrt() / std::f64::consts::TAU;
    assert!(
        (point.frequency_wander_hz / wander - 1.0).abs() < 0.02,
        "{} {wander}",
        point.frequency_wander_hz
    );
}

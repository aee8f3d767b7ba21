//! The answer for any curve is consistent in itself.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slipfit::motion::steady::Phasor;
use slipfit::motion::steady::fundamental::{Point, fundamental};
use slipfit::resonance::{Answer, Curve, DriveAmplitude, Options, analyse};
use slipfit::{LossTerm, Parameter};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Claims are supported: detected friction has a share of the loss, and values lie in their intervals.
fn is_consistent(answer: &Answer) -> Result<(), TestCaseError> {
    let sliding = &answer.sliding;
    if sliding.detected && answer.model.has(LossTerm::Sliding) {
        let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
        prop_assert!(sliding.share_at_highest > 0.0, "{sliding:?} {x_f:?}");
        prop_assert!(x_f.value > 0.0, "{sliding:?} {x_f:?}");
        prop_assert!(sliding.p_value < 0.01, "{sliding:?}");
    }
    for parameter in [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT, Parameter::NaturalFrequency] {
        let q = answer.parameter(parameter).unwrap();
        let [low, high] = q.interval_95;
        prop_assert!((low..=high).contains(&q.value), "{parameter:?}: {q:?}");
        prop_assert!(parameter == Parameter::NaturalFrequency || low >= 0.0, "{parameter:?}: {q:?}");
    }
    Ok(())
}

fn noise() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 61)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_resonance_with_any_instrument(
        beta in prop_oneof![Just(0.0), 0.0..0.97f64],
        q in 4.0..3000.0f64,
        level in prop_oneof![Just(0.0), 1e-6..0.1f64],
        background in (0.0..0.3f64, -3.0..3.0f64),
        turn in -3.0..3.0f64,
        proportional in any::<bool>(),
        (complex, known) in any::<(bool, bool)>(),
        points in 9usize..61,
        noise in noise(),
    ) {
        let delta = TAU / (2.0 * q);
        let at = |place: f64| {
            let omega = TAU + 6.0 * delta * place;
            let x_f = FRAC_PI_4 * beta;
            let point = Point { omega, omega_0: TAU, detuning: omega - TAU, delta, x_0: 1.0, x_f };
            Some((omega / TAU, fundamental(&point)?.value))
        };
        let places = (0..points).map(|i| 2.0 * i as f64 / (points - 1) as f64 - 1.0);
        let clean: Option<Vec<(f64, Phasor)>> = places.clone().map(at).collect();
        prop_assume!(clean.is_some());
        let clean = clean.unwrap();
        let highest = clean.iter().map(|c| c.1.norm()).fold(0.0, f64::max);
        let (hz, z): (Vec<f64>, Vec<Phasor>) = clean
            .iter()
            .zip(places)
            .zip(&noise)
            .map(|((&(hz, z), place), &(a, b))| {
                let seen = z * Phasor::from_polar(1.0, turn * place)
                    + Phasor::from_polar(background.0 * highest, background.1);
                let size = level * if proportional { seen.norm() } else { highest };
                (hz, seen + Phasor::new(a, b) * size)
            })
            .unzip();
        let curve = if complex {
            Curve::complex(hz, z).build()
        } else {
            Curve::builder(hz, z.iter().map(|z| z.norm()).collect()).build()
        };
        let mut options = Options::default();
        options.drive_amplitude = known.then_some(DriveAmplitude { value: 1.0, std_error: 0.0 });
        if let Ok(answer) = analyse(&curve.unwrap(), &options) {
            is_consistent(&answer)?;
        }
    }

    /// Lines that no oscillator has: the real part of one, a Gaussian, steps, plain noise.
    #[test]
    fn a_line_that_is_no_resonance(
        kind in 0..4,
        width in 0.02..0.6f64,
        level in prop_oneof![Just(0.0), 1e-5..0.1f64],
        known in any::<bool>(),
        noise in noise(),
    ) {
        let line = |x: f64| match kind {
            0 => width * width / (x * x + width * width),
            1 => (-x * x / (width * width)).exp(),
            2 => if x.abs() < width { 1.0 } else { 0.2 },
            _ => 0.5,
        };
        let n = noise.len();
        let x = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
        let hz = (0..n).map(|i| 1.0 + 0.05 * x(i)).collect();
        let amplitude = noise.iter().enumerate().map(|(i, (a, _))| (line(x(i)) + level * a).abs()).collect();
        let curve = Curve::builder(hz, amplitude).build().unwrap();
        let mut options = Options::default();
        options.drive_amplitude = known.then_some(DriveAmplitude { value: 0.05, std_error: 0.0 });
        if let Ok(answer) = analyse(&curve, &options) {
            is_consistent(&answer)?;
        }
    }
}

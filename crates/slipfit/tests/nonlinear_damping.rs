//! Nonlinear damping `m eta x² x'`, simulated and recovered if a model with it is requested.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod noise;

use noise::Noise;
use slipfit::motion::simulate::Drive;
use slipfit::motion::simulate::smooth::SmoothMotion;
use slipfit::motion::steady::Phasor;
use slipfit::resonance::{self, Curve};
use slipfit::{LossModel, LossTerm, Oscillator, Parameter, Quantity, Record, SignalKind, ringdown};
use std::f64::consts::{PI, TAU};

const CUBIC: Parameter = Parameter::Loss(LossTerm::Cubic);
const SEEDS: u64 = 8;

fn model(name: &str) -> LossModel {
    name.parse().unwrap()
}

/// Releases an oscillator from 0.5 with `a3 = eta/8`.
fn released(o: &Oscillator, a3: f64, time_s: &[f64]) -> Vec<f64> {
    let scale = 8.0 * a3 / (o.omega_0() * o.omega_0());
    let law = move |x: f64, v: f64| scale * x * x * v;
    let mut motion = SmoothMotion::with_position(o, law, Drive::none(), 0.0, 0.5, 0.0).unwrap();
    time_s.iter().map(|&t| motion.state_at(t).unwrap().position).collect()
}

/// Deviation from the true value in standard errors; over the seeds it scatters about zero by about one.
fn off(q: &Quantity, truth: f64) -> f64 {
    (q.unbounded_value - truth) / q.std_error
}

fn scatters_about_zero(what: &str, z: &[f64]) {
    let n = z.len() as f64;
    let mean = z.iter().sum::<f64>() / n;
    assert!(mean.abs() < 4.0 / n.sqrt(), "{what}: {z:.2?}");
    assert!(z.iter().all(|z| z.abs() < 4.0), "{what}: {z:.2?}");
}

/// Analyses records that differ only in their noise, and compares with the true values.
fn found_again(
    o: &Oscillator,
    a3: f64,
    name: &str,
    method: &str,
    record: impl Fn(&mut Noise) -> Record,
    mut options: ringdown::Options,
) {
    options.model = Some(model(name));
    let mut criteria = ringdown::Criteria::default();
    if method == "envelope" {
        criteria.waveform.most_samples = 0;
    }
    let mut z = [Vec::new(), Vec::new(), Vec::new()];
    for seed in 1..=SEEDS {
        let answer = ringdown::analyse_with(&record(&mut Noise::of(seed)), &options, &criteria).unwrap();
        assert_eq!((answer.model, answer.diagnostics.method), (model(name), method));
        let truths = [
            (CUBIC, a3),
            (Parameter::DECAY_RATE, o.decay_rate_per_s()),
            (Parameter::FRICTION_DISPLACEMENT, o.friction_displacement()),
        ];
        for (z, (parameter, truth)) in z.iter_mut().zip(truths) {
            z.push(off(answer.parameter(parameter).unwrap(), truth));
        }
        let cubic = answer.parameter(CUBIC).unwrap();
        assert!(cubic.std_error < 0.3 * a3, "{cubic:?}");
        assert_eq!(cubic.unit, "1/(rad² s)");
    }
    for (z, what) in z.iter().zip(["a3", "delta", "x_F"]) {
        scatters_about_zero(&format!("{name}, {method}, {what}"), z);
    }
}

fn times(n: u32, step: f64) -> Vec<f64> {
    (0..n).map(|i| step * f64::from(i)).collect()
}

#[test]
fn every_sample_of_a_ring_down_tells_it() {
    for (x_f, name) in [(0.0, "viscous+cubic"), (3e-4, "viscous+sliding+cubic")] {
        let o = Oscillator::kinematic(6.0, 0.01, x_f).unwrap();
        let time_s = times(4000, 0.05);
        let motion = released(&o, 0.12, &time_s);
        let record = |n: &mut Noise| {
            let signal = motion.iter().map(|x| x + 4e-3 * n.next()).collect();
            Record::new(time_s.clone(), signal).unwrap().with_unit("rad")
        };
        found_again(&o, 0.12, name, "waveform", record, ringdown::Options::default());
    }
}

#[test]
fn the_amplitudes_of_a_ring_down_tell_it() {
    let o = Oscillator::kinematic(6.0, 0.01, 3e-4).unwrap();
    let time_s = times(8000, 0.025);
    let motion = released(&o, 0.12, &time_s);
    let record = |n: &mut Noise| {
        let signal = motion.iter().map(|x| x + 4e-3 * n.next()).collect();
        Record::new(time_s.clone(), signal).unwrap().with_unit("rad")
    };
    found_again(&o, 0.12, "viscous+sliding+cubic", "envelope", record, ringdown::Options::default());
}

#[test]
fn a_bare_amplitude_tells_it() {
    let o = Oscillator::kinematic(60.0, 0.01, 3e-5).unwrap();
    let a3 = 0.12;
    let time_s = times(400, 0.5);
    // dA/dt = -(a0 + delta A + a3 A³), in steps in which the amplitude changes by a thousandth.
    let a0 = 2.0 * o.omega_d() * o.friction_displacement() / PI;
    let rate = |a: f64| a0 + 0.01 * a + a3 * a * a * a;
    let mut a = 0.5;
    let amplitude: Vec<f64> = time_s
        .iter()
        .map(|_| {
            let now = a;
            for _ in 0..50 {
                let middle = a - 0.005 * rate(a);
                a -= 0.01 * rate(middle);
            }
            now.max(0.0)
        })
        .collect();
    let mut options = ringdown::Options::default();
    options.frequency_hz = Some(o.omega_d() / TAU);
    let record = |n: &mut Noise| {
        let size = |a: &f64| (a + 2e-3 * n.next()).hypot(2e-3 * n.next());
        let signal = amplitude.iter().map(size).collect();
        Record::new(time_s.clone(), signal).unwrap().with_unit("rad").with_kind(SignalKind::Envelope)
    };
    found_again(&o, a3, "viscous+sliding+cubic", "envelope", record, options);
}

/// The law, averaged over a cycle, holds over a few cycles to the order of the loss per cycle: the neglected third
/// harmonic, at most 3e-3, lies below the noise of a sample.
#[test]
fn a_few_cycles_give_its_size() {
    let o = Oscillator::kinematic(6.0, 0.02, 0.0).unwrap();
    let time_s = times(260, 0.01);
    for a3 in [0.2, 0.6] {
        let motion = released(&o, a3, &time_s);
        let mut z = Vec::new();
        for seed in 1..=SEEDS {
            let mut n = Noise::of(seed);
            let signal = motion.iter().map(|x| x + 5e-3 * n.next()).collect();
            let record = Record::new(time_s.clone(), signal).unwrap().with_unit("rad");
            let mut options = ringdown::Options::default();
            options.model = Some(model("viscous+cubic"));
            let answer = ringdown::analyse(&record, &options).unwrap();
            assert_eq!((answer.model, answer.diagnostics.method), (model("viscous+cubic"), "waveform"));
            z.push(off(answer.parameter(CUBIC).unwrap(), a3));
        }
        scatters_about_zero("a3 of a few cycles", &z);
    }
}

#[test]
fn the_default_answer_knows_nothing_of_it() {
    let o = Oscillator::kinematic(6.0, 0.01, 3e-4).unwrap();
    let time_s = times(3000, 0.05);
    let signal = released(&o, 0.12, &time_s);
    let mut n = Noise::of(3);
    let signal = signal.iter().map(|x| x + 4e-3 * n.next()).collect();
    let record = Record::new(time_s, signal).unwrap().with_unit("rad");
    let answer = ringdown::analyse(&record, &ringdown::Options::default()).unwrap();
    assert!(answer.parameter(CUBIC).is_none());
    assert!(answer.comparison.iter().all(|c| !c.model.has(LossTerm::Cubic)));
    assert!(answer.comparison.iter().all(|c| c.values.iter().all(|(p, _)| p != CUBIC)));
}

/// The fundamental of a driven motion at one frequency in the steady state.
fn steady(o: &Oscillator, a3: f64, x_0: f64, omega: f64) -> Phasor {
    // Balance of the fundamental with delta + a3 R² for delta, by bisection.
    let d = |r: f64| {
        let delta = o.decay_rate_per_s() + a3 * r * r;
        let stiffness = o.omega_0().powi(2) - omega * omega;
        Phasor::new(stiffness, 2.0 * delta * omega)
    };
    let (mut low, mut high) = (0.0, x_0 * o.omega_0() / (2.0 * o.decay_rate_per_s()));
    let force = x_0 * o.omega_0().powi(2);
    for _ in 0..100 {
        let r = 0.5 * (low + high);
        if r * d(r).norm() < force { low = r } else { high = r }
    }
    Phasor::new(force, 0.0) / d(low)
}

#[test]
fn a_resonance_curve_tells_it() {
    let o = Oscillator::kinematic(TAU, 0.02, 0.0).unwrap();
    let (x_0, a3) = (0.003, 0.12);
    let hz: Vec<f64> = (0..161).map(|i| 0.96 + 5e-4 * f64::from(i)).collect();
    let clean: Vec<Phasor> = hz.iter().map(|f| steady(&o, a3, x_0, TAU * f)).collect();
    let highest = clean.iter().map(|z| z.norm()).fold(0.0, f64::max);
    assert!(a3 * highest * highest > 0.2 * o.decay_rate_per_s(), "{highest}");
    for complex in [true, false] {
        let mut z = [Vec::new(), Vec::new(), Vec::new()];
        for seed in 1..=SEEDS {
            let mut n = Noise::of(seed);
            let sigma = 0.002 * highest;
            let noisy: Vec<Phasor> =
                clean.iter().map(|z| z + Phasor::new(sigma * n.next(), sigma * n.next())).collect();
            let curve = if complex {
                Curve::complex(hz.clone(), noisy).build().unwrap()
            } else {
                Curve::builder(hz.clone(), noisy.iter().map(|z| z.norm()).collect()).build().unwrap()
            };
            let mut options = resonance::Options::default();
            options.model = Some(model("viscous+cubic"));
            options.drive_amplitude = Some(resonance::DriveAmplitude { value: x_0, std_error: 0.0 });
            let answer = resonance::analyse(&curve, &options).unwrap();
            assert_eq!(answer.model, model("viscous+cubic"));
            let truths = [(CUBIC, a3), (Parameter::DECAY_RATE, 0.02), (Parameter::NaturalFrequency, 1.0)];
            for (z, (parameter, truth)) in z.iter_mut().zip(truths) {
                z.push(off(answer.parameter(parameter).unwrap(), truth));
            }
            assert!(answer.parameter(CUBIC).unwrap().std_error < 0.2 * a3);
        }
        for (z, what) in z.iter().zip(["a3", "delta", "f_0"]) {
            scatters_about_zero(&format!("curve, phases {complex}, {what}"), z);
        }
    }
}

/// The balance from which the curves are computed agrees with the fundamental of the integrated motion.
#[test]
fn the_balance_is_that_of_the_driven_motion() {
    let o = Oscillator::kinematic(1.0, 0.02, 0.0).unwrap();
    let (x_0, a3) = (0.003, 4.0);
    for omega in [0.97, 1.0, 1.02] {
        let law = |x: f64, v: f64| 8.0 * a3 * x * x * v;
        let drive = Drive::harmonic(x_0, omega).unwrap();
        let mut motion = SmoothMotion::with_position(&o, law, drive, 0.0, 0.0, 0.0).unwrap();
        let (first, per_period) = (100.0 * TAU / omega, 64);
        let mut sum = Phasor::default();
        for i in 0..per_period {
            let t = first + TAU / omega * f64::from(i) / f64::from(per_period);
            sum += Phasor::from_polar(motion.state_at(t).unwrap().position, -omega * t);
        }
        let measured = sum * (2.0 / f64::from(per_period));
        let expected = steady(&o, a3, x_0, omega);
        assert!((measured - expected).norm() < 3e-3 * expected.norm(), "{omega}: {measured} {expected}");
    }
}

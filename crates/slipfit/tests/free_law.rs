//! The model-free law on simulated decays: its band covers the true loss, its limit the sliding part.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod noise;

use noise::Noise;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::Drive;
use slipfit::motion::simulate::smooth::SmoothMotion;
use slipfit::ringdown::{LawOption, LowPass, Options, analyse};
use slipfit::{Oscillator, Record, SignalKind};
use std::f64::consts::{PI, TAU};

const SEEDS: u64 = 40;
const OMEGA: f64 = 6.0;

fn times(n: u32, step: f64) -> Vec<f64> {
    (0..n).map(|i| step * f64::from(i)).collect()
}

/// A motion released from 1 under viscous loss and a force over the stiffness.
fn released(delta: f64, law: impl Fn(f64, f64) -> f64, time_s: &[f64]) -> Vec<f64> {
    let o = Oscillator::kinematic(OMEGA, delta, 0.0).unwrap();
    let mut motion = SmoothMotion::with_position(&o, law, Drive::none(), 0.0, 1.0, 0.0).unwrap();
    time_s.iter().map(|&t| motion.state_at(t).unwrap().position).collect()
}

/// How often, over the seeds, the band covers the loss and the interval of the limit covers the sliding rate.
struct Held {
    band: f64,
    limit: f64,
    slope: f64,
    /// Mean width of the band, and of the limit's interval, over the loss at the start.
    width: f64,
    limit_width: f64,
}

fn held(
    records: impl Fn(u64) -> Record,
    options: &Options,
    loss: impl Fn(f64) -> f64,
    slope: f64,
    period: f64,
) -> Held {
    held_over(SEEDS, records, options, loss, slope, period)
}

fn held_over(
    seeds: u64,
    records: impl Fn(u64) -> Record,
    options: &Options,
    loss: impl Fn(f64) -> f64,
    slope: f64,
    period: f64,
) -> Held {
    let mut h = Held { band: 0.0, limit: 0.0, slope: 0.0, width: 0.0, limit_width: 0.0 };
    for seed in 1..=seeds {
        let answer = analyse(&records(seed), options).unwrap();
        let law = answer.free_law.expect("amplitudes enough");
        let measured: Vec<_> = law.curve.iter().filter(|p| p.amplitude >= law.lowest_amplitude).collect();
        let inside = |a: f64| loss(a) * period;
        let n = measured.len() as f64;
        let holds = measured.iter().filter(|p| (p.low_95..=p.high_95).contains(&inside(p.amplitude)));
        h.band += holds.count() as f64 / n;
        h.width += measured.iter().map(|p| (p.high_95 - p.low_95) / inside(1.0)).sum::<f64>() / n;
        let [low, high] = law.limit.interval_95;
        h.limit += f64::from(u8::from(low <= loss(0.0) && loss(0.0) <= high));
        h.limit_width += (high - low) / loss(1.0);
        let [low, high] = law.slope.interval_95;
        h.slope += f64::from(u8::from(low <= slope && slope <= high));
    }
    let n = seeds as f64;
    Held {
        band: h.band / n,
        limit: h.limit / n,
        slope: h.slope / n,
        width: h.width / n,
        limit_width: h.limit_width / n,
    }
}

fn free() -> Options {
    let mut options = Options::default();
    options.law = Some(LawOption::Free);
    options
}

fn noisy<'a>(time_s: &'a [f64], motion: &'a [f64], noise: f64) -> impl Fn(u64) -> Record + 'a {
    move |seed| {
        let mut n = Noise::of(seed);
        let signal = motion.iter().map(|x| x + noise * n.next()).collect();
        Record::new(time_s.to_vec(), signal).unwrap().with_unit("rad")
    }
}

fn good(what: &str, h: &Held) {
    assert!(h.band >= 0.9, "{what}: the band holds {:.3} of the curve", h.band);
    assert!(h.limit >= 0.9, "{what}: the limit holds the sliding rate in {:.3}", h.limit);
    assert!(h.slope >= 0.9, "{what}: the slope holds the decay rate in {:.3}", h.slope);
}

const PERIOD: f64 = TAU / OMEGA;

/// A wide enough band covers everything: `most` bounds its mean width over the loss at the start.
fn says_something(what: &str, h: &Held, most: f64) {
    assert!(h.limit_width < 0.5, "{what}: the limit is {:.3} of that loss wide", h.limit_width);
    assert!(h.width < most, "{what}: the band is {:.3} of the loss at the start wide", h.width);
}

#[test]
fn the_band_holds_viscous_and_sliding_loss() {
    let time_s = times(4000, 0.05);
    for (delta, x_f, noise) in
        [(0.01, 0.001, 0.02), (0.0, 0.001, 0.02), (0.02, 0.0, 0.07), (0.002, 3e-4, 0.002)]
    {
        let o = Oscillator::kinematic(OMEGA, delta, x_f).unwrap();
        let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
        let motion: Vec<f64> = time_s.iter().map(|&t| decay.displacement(t)).collect();
        let a0 = 2.0 * OMEGA * x_f / PI;
        let h = held(noisy(&time_s, &motion, noise), &free(), |a| a0 + delta * a, delta, PERIOD);
        let what = format!("noise {noise}, delta {delta}, x_F {x_f}");
        good(&what, &h);
        says_something(&what, &h, 3.0 * noise);
    }
}

#[test]
fn the_band_holds_cubic_loss_and_drag() {
    let time_s = times(4000, 0.05);
    let (delta, a3, a2) = (0.01, 0.05, 0.05);
    // a2 = 4 c omega/(3 pi m), over the stiffness m omega².
    let c = a2 * 3.0 * PI / (4.0 * OMEGA) / (OMEGA * OMEGA);
    for noise in [0.002, 0.02, 0.07] {
        let motion = released(delta, |x, v| 8.0 * a3 * x * x * v / (OMEGA * OMEGA), &time_s);
        let h = held(noisy(&time_s, &motion, noise), &free(), |a| delta * a + a3 * a.powi(3), delta, PERIOD);
        good(&format!("noise {noise}, cubic"), &h);
        let motion = released(delta, |_, v: f64| c * v * v.abs(), &time_s);
        let h = held(noisy(&time_s, &motion, noise), &free(), |a| delta * a + a2 * a * a, delta, PERIOD);
        good(&format!("noise {noise}, drag"), &h);
        let motion = released(0.0, |_, v: f64| c * v * v.abs(), &time_s);
        let h = held(noisy(&time_s, &motion, noise), &free(), |a| a2 * a * a, 0.0, PERIOD);
        good(&format!("noise {noise}, drag alone"), &h);
    }
}

/// Friction that rises towards rest: `F_c + (F_s - F_c) exp(-|v|/v_s)`, averaged by quadrature.
#[test]
fn the_band_holds_friction_that_falls_with_speed() {
    let time_s = times(4000, 0.05);
    let (x_f, more, v_s) = (8e-4, 8e-4, 1.2);
    let force = move |v: f64| (x_f + more * (-v.abs() / v_s).exp()) * (v / 1e-3).tanh();
    let motion = released(0.003, |_, v| force(v), &time_s);
    let loss = |a: f64| {
        let n = 2000;
        let mean = (0..n).map(|i| {
            let sin = (PI / 2.0 * (f64::from(i) + 0.5) / f64::from(n)).sin();
            (x_f + more * (-a * OMEGA * sin / v_s).exp()) * sin
        });
        0.003 * a + OMEGA * mean.sum::<f64>() / f64::from(n)
    };
    for noise in [0.005, 0.01, 0.03] {
        let h = held(noisy(&time_s, &motion, noise), &free(), loss, f64::NAN, PERIOD);
        assert!(h.band >= 0.9, "noise {noise}: {:.3}, {:.3}", h.band, h.limit);
        assert!(h.limit >= 0.9, "noise {noise}: {:.3}, {:.3}", h.band, h.limit);
    }
}

/// Amplitudes recorded directly, including their noise.
#[test]
fn bare_envelopes_have_one_as_well() {
    let time_s = times(4000, 0.05);
    let (delta, a0) = (0.01, 0.004);
    let law = |t: f64| ((1.0 + a0 / delta) * (-delta * t).exp() - a0 / delta).max(0.0);
    let bare = |seed| {
        let mut n = Noise::of(seed);
        let signal = time_s.iter().map(|&t| (law(t) + 0.02 * n.next()).hypot(0.02 * n.next())).collect();
        Record::new(time_s.clone(), signal).unwrap().with_kind(SignalKind::Envelope)
    };
    let loss = |a: f64| a0 + delta * a;
    let mut options = free();
    good("envelope", &held(bare, &options, loss, delta, 1.0));
    options.frequency_hz = Some(1.0);
    good("envelope of 1 Hz", &held(bare, &options, loss, delta, 1.0));
}

/// Amplitudes after a filter of four stages of 2 s, a tenth of the decay time of the drag, are delayed.
#[test]
fn the_low_pass_of_a_lock_in_is_undone() {
    let time_s = times(3000, 0.05);
    let a2 = 0.05;
    let filter = LowPass { time_constant_s: 2.0, order: 4 };
    // Four stages of first order, driven by A = 1/(1 + a2 t), which began long before the record.
    let (begin, step) = (-18.0, 0.001);
    let mut stages = [1.0 / (1.0 + a2 * begin); 4];
    let mut filtered = Vec::with_capacity(time_s.len());
    let mut t: f64 = begin;
    for wanted in &time_s {
        while t < wanted - 0.5 * step {
            let mut input = 1.0 / (1.0 + a2 * (t + 0.5 * step));
            for stage in &mut stages {
                *stage += (1.0 - (-step / filter.time_constant_s).exp()) * (input - *stage);
                input = *stage;
            }
            t += step;
        }
        filtered.push(stages[3]);
    }
    let mut options = free();
    options.lockin = Some(filter);
    options.start_s = Some(20.0);
    let record = |seed| {
        let mut n = Noise::of(seed);
        let outputs = filtered.iter().map(|a| (a + 0.003 * n.next(), 0.003 * n.next()));
        let (p, q) = outputs.unzip();
        Record::lock_in(time_s.clone(), p, q).unwrap()
    };
    // Few seeds, because the fits of the laws take seconds behind a filter.
    good("lock-in", &held_over(6, record, &options, |a| a2 * a * a, 0.0, 1.0));
}

#[test]
fn a_law_that_rises_has_a_band_that_rises() {
    let time_s = times(4000, 0.05);
    let o = Oscillator::kinematic(OMEGA, 0.004, 0.001).unwrap();
    let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
    let motion: Vec<f64> = time_s.iter().map(|&t| decay.displacement(t)).collect();
    let mut options = Options::default();
    options.law = Some(LawOption::Rising);
    let record = noisy(&time_s, &motion, 0.05);
    for seed in 1..6 {
        let law = analyse(&record(seed), &options).unwrap().free_law.unwrap();
        assert!(law.rising);
        let rises = |of: fn(&slipfit::ringdown::FreeLossPoint) -> f64| {
            law.curve.windows(2).all(|w| of(&w[0]) <= of(&w[1]))
        };
        assert!(rises(|p| p.loss_per_cycle));
        assert!(rises(|p| p.low_95));
        assert!(rises(|p| p.high_95));
    }
}

#[test]
fn without_being_asked_for_there_is_none() {
    let time_s = times(400, 0.05);
    let o = Oscillator::kinematic(OMEGA, 0.1, 0.001).unwrap();
    let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
    let motion: Vec<f64> = time_s.iter().map(|&t| decay.displacement(t)).collect();
    let record = noisy(&time_s, &motion, 0.01)(1);
    let plain = analyse(&record, &Options::default()).unwrap();
    assert!(plain.free_law.is_none());
    let with = analyse(&record, &free()).unwrap();
    // The rest of the answer is the same.
    assert_eq!((with.parameters, with.comparison), (plain.parameters, plain.comparison));
}

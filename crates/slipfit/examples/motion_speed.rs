//! Times of the exact motion: turning points, dense traces, driven events.
//!
//! `cargo run --release -p slipfit --example motion_speed`

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that reports to a person")]

use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, Motion};
use slipfit::motion::steady::{HarmonicDrive, solve};
use std::hint::black_box;
use std::time::Instant;

/// Best of several runs, s.
fn best(mut f: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    let started = Instant::now();
    while started.elapsed().as_secs_f64() < 0.5 {
        let t = Instant::now();
        f();
        best = best.min(t.elapsed().as_secs_f64());
    }
    best
}

fn main() {
    let o = Oscillator::kinematic(1.0, 1e-5, 1e-4).unwrap();
    let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
    let t = best(|| {
        black_box(black_box(&decay).turning_points().take(2000).map(|p| p.position).sum::<f64>());
    });
    println!("free decay, 1000 cycles, iterator of turning points   {:9.2} us", t * 1e6);
    let t = best(|| {
        let mut m = Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        black_box(m.events(6283.0).map(|e| e.position).sum::<f64>());
    });
    println!("free decay, 1000 cycles, event machine                {:9.2} us", t * 1e6);
    for cycles in [1000.0, 100.0, 10.0] {
        let times: Vec<f64> = (0..100_000).map(|i| f64::from(i) * cycles * 6.283e-5).collect();
        let mut out = vec![0.0; times.len()];
        let t = best(|| decay.fill(black_box(&times), &mut out).unwrap());
        println!("free decay, 100 k samples of {cycles:5} cycles            {:9.2} us", t * 1e6);
    }
    let times: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 6.283e-2).collect();
    let mut out = vec![0.0; times.len()];
    let t = best(|| {
        let mut m = Motion::new(&o, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        m.fill(black_box(&times), &mut out).unwrap();
    });
    println!("free decay, 100 k samples, event machine              {:9.2} us", t * 1e6);
    for (name, delta, x_f, omega) in [
        ("resonant", 0.01, 0.3, 1.0),
        ("stick-slip, slow drive", 0.05, 0.4, 0.3),
        ("two stops a cycle", 0.1, 0.6, 0.6),
        ("fast drive", 0.01, 0.1, 3.0),
    ] {
        let o = Oscillator::kinematic(1.0, delta, x_f).unwrap();
        let drive = Drive::harmonic(1.0, omega).unwrap();
        let until = 1000.0 * 2.0 * std::f64::consts::PI / omega;
        let run = || Motion::new(&o, drive.clone(), 0.0, 0.0, 0.0).unwrap().events(until).count();
        let events = run();
        let t = best(|| {
            black_box(run());
        });
        println!("driven, 1000 cycles, {name:24} {events:6} events, {:7.0} ns each", t / events as f64 * 1e9);
        let found = HarmonicDrive::new(1.0, omega).unwrap();
        let t = best(|| {
            black_box(solve(&o, &found).unwrap().method);
        });
        println!("        steady state                                  {:9.2} us", t * 1e6);
    }
    let sampled: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 0.05).collect();
    let drive = Drive::sampled(sampled.clone(), sampled.iter().map(|t| t.cos()).collect()).unwrap();
    let o = Oscillator::kinematic(1.0, 0.01, 0.3).unwrap();
    let t = best(|| {
        black_box(Motion::new(&o, drive.clone(), 0.0, 0.0, 0.0).unwrap().events(4999.0).count());
    });
    println!("sampled drive, 100 k samples                          {:9.2} us", t * 1e6);
    let chirp = Drive::chirp(1.0, 0.9, 1.1, 0.0, 2e4).unwrap();
    let run = || Motion::new(&o, chirp.clone(), 0.0, 0.0, 0.0).unwrap().events(2e4).count();
    let events = run();
    let t = best(|| {
        black_box(run());
    });
    println!("sweep, {events} events, {:7.0} ns each", t / events as f64 * 1e9);
    let gentle = Oscillator::kinematic(1.0, 1e-12, 1e-12).unwrap();
    for count in [100, 10_000, 1_000_000, 10_000_000] {
        let t = Instant::now();
        let mut m = Motion::new(&gentle, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        black_box(m.events(1e9).take(count).map(|e| e.position).sum::<f64>());
        println!(
            "{count:9} events                                {:7.1} ns each",
            t.elapsed().as_secs_f64() / count as f64 * 1e9
        );
    }
}

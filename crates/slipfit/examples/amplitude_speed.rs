//! Time of one fit of 512 amplitudes, in cache.
//!
//! `cargo run --release -p slipfit --example amplitude_speed`

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that reports to a person")]

use slipfit::ringdown::{Sampling, fit_amplitudes};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let jitter = |i: usize| ((i * 7919) % 1009) as f64 / 1009.0 - 0.5;
    for (sliding, delta) in [(0.3, 0.0), (0.1, 1.0), (0.2, 3.0), (0.0, 4.0)] {
        let gone = |t: f64| if delta == 0.0 { t } else { -(-delta * t).exp_m1() / delta };
        let law = |t: f64| (-delta * t).exp() - sliding * gone(t);
        let trace: Vec<f64> = (0..512).map(|i| law(1e-3 * i as f64) + 0.03 * jitter(i)).collect();
        let mut best = f64::INFINITY;
        let mut steps = 0;
        for _ in 0..200 {
            let begun = Instant::now();
            for _ in 0..100 {
                steps = black_box(fit_amplitudes(Sampling::Every(1e-3), black_box(&trace)).unwrap()).steps;
            }
            best = best.min(begun.elapsed().as_secs_f64() / 100.0);
        }
        println!("a0 {sliding}, delta {delta}: {:.2} us, {steps} passes", 1e6 * best);
    }
}

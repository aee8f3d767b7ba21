//! Time of the whole analysis of a ring-down, for typical records.
//!
//! `cargo run --release -p slipfit --example ringdown_speed [NAME [REPEATS]]`

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that reports to a person")]

use slipfit::motion::decay::FreeDecay;
use slipfit::ringdown::{Options, analyse};
use slipfit::{Oscillator, Record};
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Instant;

/// A decay at 1 Hz: samples, samples a cycle, decay times by viscous loss, stop by friction over the
/// length of the record (infinite: none), signal to noise in dB.
struct Case {
    samples: usize,
    per_cycle: f64,
    decays: f64,
    stop: f64,
    decibel: f64,
}

impl Case {
    fn name(&self) -> String {
        format!("{}-{}-{}-{}-{}", self.samples, self.per_cycle, self.decays, self.stop, self.decibel)
    }

    fn record(&self) -> Record {
        let duration = self.samples as f64 / self.per_cycle;
        let delta = self.decays / duration;
        let stop = self.stop * duration;
        let x_f =
            if stop.is_finite() { delta / ((delta * stop).exp() - 1.0) * PI / (2.0 * TAU) } else { 0.0 };
        let decay = FreeDecay::from_rest(&Oscillator::kinematic(TAU, delta, x_f).unwrap(), 1.0).unwrap();
        let noise = 10f64.powf(-self.decibel / 20.0) / 2f64.sqrt();
        let mut state = 88_172_645_463_325_252u64;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos();
        let time: Vec<f64> = (0..self.samples).map(|i| i as f64 / self.per_cycle).collect();
        let signal = time.iter().map(|&t| 0.02 + decay.displacement(t) + noise * normal()).collect();
        Record::new(time, signal).unwrap().with_unit("mm")
    }
}

fn main() {
    let mut cases = Vec::new();
    for (samples, per_cycle) in [(512, 20.0), (2000, 20.0), (5000, 20.0), (5000, 50.0), (50_000, 50.0)] {
        for (decays, stop) in [(2.0, f64::INFINITY), (1.0, 2.0), (1.0, 0.8)] {
            for decibel in [20.0, 40.0, 60.0] {
                cases.push(Case { samples, per_cycle, decays, stop, decibel });
            }
        }
    }
    for samples in [512, 5000] {
        cases.push(Case { samples, per_cycle: 100.0, decays: 1.0, stop: 1.25, decibel: 40.0 });
    }
    cases.push(Case { samples: 1_000_000, per_cycle: 50.0, decays: 2.0, stop: 2.0, decibel: 40.0 });
    let asked = std::env::args().nth(1);
    let repeats: Option<usize> = std::env::args().nth(2).and_then(|n| n.parse().ok());
    for case in cases.iter().filter(|c| asked.as_ref().is_none_or(|a| c.name().contains(a))) {
        let record = case.record();
        let repeats = repeats.unwrap_or((2_000_000 / case.samples).clamp(3, 60));
        let mut best = f64::INFINITY;
        let mut said = String::new();
        for _ in 0..repeats {
            let begun = Instant::now();
            let answer = black_box(analyse(black_box(&record), &Options::default()));
            best = best.min(begun.elapsed().as_secs_f64());
            said = answer.map_or_else(
                |e| e.to_string(),
                |a| format!("{} {:?} warnings {}", a.diagnostics.method, a.preferred_model, a.warnings.len()),
            );
        }
        println!("{:24} {:10.1} us  {said}", case.name(), 1e6 * best);
    }
}

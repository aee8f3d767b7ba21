//! Ring-downs: exact decays with white noise and disturbances.

use std::f64::consts::{PI, SQRT_2, TAU};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Instant;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use slipfit::LossModel;
use slipfit::motion::decay::FreeDecay;
use slipfit::ringdown::{Options, analyse};
use slipfit::{Oscillator, Record};

use super::bounds::of_motion;
use super::choices::Choices;
use super::hardening::hardening;
use super::trials::{COLUMNS, Experiment, Requirements, Summary, Trial, Truth, coverage_error, seed, trials};
use crate::Failure;

const Q: [f64; 4] = [5.0, 50.0, 1_000.0, 20_000.0];
const SHARE: [f64; 4] = [0.0, 0.1, 0.5, 0.9];
const SNR_DB: [f64; 3] = [20.0, 40.0, 60.0];
const AMPLITUDE: f64 = 1.0;
const OMEGA_0: f64 = TAU;
/// The frequency is one cycle per second, so this is also the time in seconds.
const LEAD_IN_CYCLES: f64 = 20.0;

/// Disturbance of the record in addition to white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Nuisance {
    None,
    /// Spring `k (x + alpha x³)`, 2 % frequency change over the decay.
    Hardening,
    /// Offset drifting by 5 % of the first amplitude.
    OffsetDrift,
    /// Eight-bit converter with a range of 1.2 times the first amplitude.
    EightBit,
    /// A tenth of the samples missing.
    MissingSamples,
    /// The record begins with [`LEAD_IN_CYCLES`] cycles of driven motion of constant amplitude.
    DrivenLeadIn,
    /// The record is 1.4 times as long as the motion and ends at rest.
    Rest,
}

impl Nuisance {
    const ALL: [Self; 6] = [
        Self::Hardening,
        Self::OffsetDrift,
        Self::EightBit,
        Self::MissingSamples,
        Self::DrivenLeadIn,
        Self::Rest,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Hardening => "frequency changes by 2 %",
            Self::OffsetDrift => "offset drifts by 5 %",
            Self::EightBit => "8-bit converter",
            Self::MissingSamples => "10 % missing",
            Self::DrivenLeadIn => "driven lead-in",
            Self::Rest => "at rest at the end",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cell {
    q: f64,
    /// Sliding part of the loss at the start.
    share: f64,
    snr_db: f64,
    nuisance: Nuisance,
}

/// A cell with its record before noise is added.
struct Decay {
    cell: Cell,
    time: Vec<f64>,
    clean: Vec<f64>,
    sigma: f64,
    truth: Truth,
}

/// Runs the table.
pub(super) fn run(choices: Choices) -> Result<ExitCode, Failure> {
    let mut rows: Vec<(Cell, Option<(Decay, Summary)>)> = Vec::new();
    for cell in cells().into_iter().filter(|cell| cell.name().contains(&choices.only)) {
        let begun = Instant::now();
        let row = cell.decay().map(|decay| {
            let summary = Summary::of(&trials(&decay, 0..choices.seeds), &decay.truth);
            eprintln!("{:46} {}, {:.1?}", cell.name(), summary.line(), begun.elapsed());
            (decay, summary)
        });
        rows.push((cell, row));
    }
    choices.publish("statistics.md", &page(&rows, choices.seeds))?;
    Ok(ExitCode::SUCCESS)
}

fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for q in Q {
        for share in SHARE {
            cells.extend(SNR_DB.map(|snr_db| Cell { q, share, snr_db, nuisance: Nuisance::None }));
        }
    }
    for nuisance in Nuisance::ALL {
        let levels: &[f64] = if nuisance == Nuisance::Rest { &[20.0, 40.0] } else { &[40.0] };
        for (q, share) in [(50.0, 0.1), (50.0, 0.5), (1_000.0, 0.1), (1_000.0, 0.5)] {
            cells.extend(levels.iter().map(|&snr_db| Cell { q, share, snr_db, nuisance }));
        }
    }
    cells
}

impl Cell {
    fn name(&self) -> String {
        format!("Q={} share={} snr={} {}", self.q, self.share, self.snr_db, self.nuisance.name())
    }

    fn requirements(&self) -> Requirements {
        if self.nuisance == Nuisance::None {
            Requirements::of_white_noise(self.share > 0.0)
        } else {
            Requirements { bias_and_spread: false, coverage: 0.9..=1.0, no_sliding: false }
        }
    }

    /// The noise-free record; `None` if friction holds the mass at once.
    fn decay(self) -> Option<Decay> {
        let delta = OMEGA_0 / (2.0 * self.q);
        // share = a0/(a0 + delta A) with a0 = 2 omega x_F/pi
        let x_f = self.share / (1.0 - self.share) * delta * AMPLITUDE * PI / (2.0 * OMEGA_0);
        if x_f >= AMPLITUDE {
            return None;
        }
        let oscillator = Oscillator::kinematic(OMEGA_0, delta, x_f).ok()?;
        let decay = FreeDecay::from_rest(&oscillator, AMPLITUDE).ok()?;
        // Down to 3 % of the first amplitude, or to the stop.
        let offset = oscillator.decay_offset();
        let fall = ((AMPLITUDE + offset) / (0.03 * AMPLITUDE + offset)).ln() / delta;
        let stop = decay.stop().map_or(f64::INFINITY, |s| s.time_s);
        let end = if self.nuisance == Nuisance::Rest { 1.4 * stop } else { stop.min(fall) };
        if !end.is_finite() {
            return None;
        }
        let usual: f64 = match self.q {
            q if q < 10.0 => 60.3,
            q if q < 100.0 => 20.7,
            q if q < 5_000.0 => 8.3,
            _ => 5.3,
        };
        // A record of a cycle or two is sampled fast enough to contain 400 samples.
        let per_cycle = usual.max(400.3 / end);
        let count = (end * per_cycle) as usize;
        let mut time: Vec<f64> = (0..count).map(|i| i as f64 / per_cycle).collect();
        let mut clean = vec![0.0; count];
        if self.nuisance == Nuisance::Hardening {
            clean = hardening(OMEGA_0, delta, x_f, AMPLITUDE, &time);
        } else {
            decay.fill(&time, &mut clean).ok()?;
        }
        if self.nuisance == Nuisance::OffsetDrift {
            clean.iter_mut().zip(&time).for_each(|(x, t)| *x += 0.05 * AMPLITUDE * t / end);
        }
        let free: Vec<f64> = time.iter().copied().filter(|t| *t <= stop).collect();
        if self.nuisance == Nuisance::DrivenLeadIn {
            let before = (0..(LEAD_IN_CYCLES * per_cycle) as usize).map(|i| i as f64 / per_cycle);
            let driven = before.clone().map(|t| AMPLITUDE * (TAU * (t - LEAD_IN_CYCLES)).cos());
            clean = driven.chain(clean).collect();
            time = before.chain(time.iter().map(|t| t + LEAD_IN_CYCLES)).collect();
        }
        let sigma = AMPLITUDE / SQRT_2 * 10f64.powf(-self.snr_db / 20.0);
        let bound = of_motion([AMPLITUDE, delta, x_f, 0.0, OMEGA_0, 0.0], &free, sigma);
        Some(Decay { cell: self, time, clean, sigma, truth: Truth { value: [delta, x_f], bound } })
    }
}

impl Experiment for Decay {
    fn seed(&self) -> u64 {
        let Cell { q, share, snr_db, nuisance } = self.cell;
        seed(0x5117_F175, &[q, share, snr_db, f64::from(nuisance as u8)])
    }

    fn trial(&self, rng: &mut ChaCha8Rng) -> Trial {
        let mut time = Vec::with_capacity(self.time.len());
        let mut signal = Vec::with_capacity(self.time.len());
        let lsb = 2.4 * AMPLITUDE / 256.0;
        for (t, x) in self.time.iter().zip(&self.clean) {
            let noise: f64 = rng.sample(StandardNormal);
            let mut value = x + self.sigma * noise;
            if self.cell.nuisance == Nuisance::EightBit {
                value = (value / lsb).round() * lsb;
            }
            if self.cell.nuisance == Nuisance::MissingSamples && rng.random::<f64>() < 0.1 {
                continue;
            }
            time.push(*t);
            signal.push(value);
        }
        let mut options = Options::default();
        options.model = Some(LossModel::VISCOUS_SLIDING);
        let Ok(answer) = Record::new(time, signal).and_then(|record| analyse(&record, &options)) else {
            return Trial::default();
        };
        let estimates = self.truth.estimates(|parameter| answer.parameter(parameter));
        Trial { estimates, sliding_detected: answer.sliding.detected, paper: None }
    }
}

fn page(rows: &[(Cell, Option<(Decay, Summary)>)], seeds: u64) -> String {
    const REST: &str = "The bound is that of the samples up to the stop. The position of rest shows which swing was \
                        the last, so the spread can fall below it.\n\n";
    let head = format!(
        "| Q | share | dB | samples | cycles | {COLUMNS} | sliding claimed | misses |\n{}|\n",
        "|---".repeat(13)
    );
    let mut text = format!(
        "# Bias, spread and coverage\n\nMade by `cargo xtask statistics --write`, {seeds} seeds a cell. Exact decays \
         from release down to 3 % of the first amplitude or to the stop, white noise; *share* is the sliding part \
         of the loss at the start, *dB* the rms of the first cycles over that of the noise. The whole analysis runs \
         on each record with the model (viscous+sliding) as its only option.\n\n*Bias* is over the spread (wanted \
         below 0.15), *spread* over the Cramér-Rao bound of the waveform with amplitude, phase, frequency and offset \
         free (wanted at most 1.10), *covered* the share of 95 % intervals that hold the truth (wanted 93 to 97 %). \
         Bias and spread are those of the unbounded estimate (`unbounded_value`), coverage that of the reported \
         interval. *Misses* names what is not met; with {seeds} seeds the coverage of a cell is itself uncertain by \
         {:.1} %.\n\n## White noise\n\n{head}",
        100.0 * coverage_error(seeds as usize)
    );
    let mut nuisance = Nuisance::None;
    for (cell, row) in rows {
        if cell.nuisance != nuisance {
            if nuisance == Nuisance::None {
                text.push_str("\n## With nuisances\n\nIntervals are wanted to cover at least 90 %.\n");
            }
            nuisance = cell.nuisance;
            let note = if nuisance == Nuisance::Rest { REST } else { "" };
            let _ = write!(text, "\n### {}\n\n{note}{head}", nuisance.name());
        }
        let Cell { q, share, snr_db, .. } = cell;
        let rest = row.as_ref().map_or_else(
            || "| | | | | | | | | friction holds the mass at once: x_F exceeds the amplitude".to_owned(),
            |(decay, summary)| {
                format!(
                    "{} | {:.0} | {} | {:.1} % | {}",
                    decay.time.len(),
                    decay.time[decay.time.len() - 1],
                    summary.columns(),
                    100.0 * summary.detected,
                    summary.misses(&cell.requirements()).join(", ")
                )
            },
        );
        let _ = writeln!(text, "| {q} | {share} | {snr_db} | {rest} |");
    }
    text
}

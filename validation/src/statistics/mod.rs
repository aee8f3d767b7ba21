//! `cargo xtask statistics`: what the intervals are worth, on decays whose truth is known.
//!
//! Every cell simulates the exact decay many times with white noise, runs the
//! whole analysis on it (nothing is handed over: release, end and start values
//! are found as on a measured file), and compares bias, spread and coverage with
//! what the Cramér-Rao bound of the waveform allows.

mod cell;
mod resonance;
mod table;
mod table_one;

use crate::Failure;
use cell::{Cell, Nuisance, Outcome};
use rayon::prelude::*;
use std::process::ExitCode;
use std::time::Instant;

const Q: [f64; 4] = [5.0, 50.0, 1_000.0, 20_000.0];
const SHARE: [f64; 4] = [0.0, 0.1, 0.5, 0.9];
const SNR_DB: [f64; 3] = [20.0, 40.0, 60.0];
const NUISANCES: [Nuisance; 6] = [
    Nuisance::Hardening,
    Nuisance::OffsetDrift,
    Nuisance::EightBit,
    Nuisance::MissingSamples,
    Nuisance::DrivenLeadIn,
    Nuisance::Rest,
];

/// Runs the tables; `--seeds N`, `--only TEXT`, `--write`.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    if arguments.iter().any(|a| a == "--resonance") {
        return resonance::run(arguments);
    }
    if arguments.iter().any(|a| a == "--table-one") {
        return table_one::run(arguments);
    }
    let value = |flag: &str| arguments.iter().position(|a| a == flag).and_then(|i| arguments.get(i + 1));
    let seeds: u64 = value("--seeds").and_then(|s| s.parse().ok()).unwrap_or(1000);
    let only = value("--only").cloned().unwrap_or_default();
    let mut cells = Vec::new();
    for q in Q {
        for share in SHARE {
            for snr_db in SNR_DB {
                cells.push(Cell { q, share, snr_db, nuisance: Nuisance::None });
            }
        }
    }
    for nuisance in NUISANCES {
        for q in [50.0, 1_000.0] {
            for share in [0.1, 0.5] {
                if nuisance == Nuisance::Rest {
                    cells.push(Cell { q, share, snr_db: 20.0, nuisance });
                }
                cells.push(Cell { q, share, snr_db: 40.0, nuisance });
            }
        }
    }
    let mut rows: Vec<(Cell, Option<Outcome>)> = Vec::new();
    for cell in cells.into_iter().filter(|c| c.name().contains(&only)) {
        let begun = Instant::now();
        let outcome = cell.prepare().map(|prepared| {
            let runs: Vec<_> = (0..seeds).into_par_iter().map(|seed| prepared.run(seed)).collect();
            prepared.summarise(&runs)
        });
        table::progress(&cell, outcome.as_ref(), begun.elapsed());
        rows.push((cell, outcome));
    }
    let text = table::markdown(&rows, seeds);
    if arguments.iter().any(|a| a == "--write") {
        std::fs::write("docs/statistics.md", &text)?;
    } else {
        table::show(&text);
    }
    Ok(ExitCode::SUCCESS)
}

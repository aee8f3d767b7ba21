//! Bias, spread and coverage on simulated measurements whose truth is known.
//!
//! Every experiment is simulated exactly, many times with different noise, and analysed like a measured file:
//! release, end and start values are found, not given. The spread is compared with the Cramér-Rao bound, the smallest
//! that an unbiased estimator can have.

mod bounds;
mod choices;
mod default_cells;
mod default_curve;
mod default_decay;
mod default_levels;
mod disturbance;
mod hardening;
mod measured_cells;
mod nuisances;
mod resonance;
mod ring_down;
mod scores;
mod table_one;
mod trials;

use std::process::ExitCode;

use crate::Failure;
use choices::Choices;

/// Runs one of the tables: `[--default|--default-curves|--default-levels|--resonance|--table-one] [--seeds N] [--only TEXT] [--write]`.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let mut choices = Choices { seeds: 0, only: String::new(), write: false };
    let mut table: fn(Choices) -> Result<ExitCode, Failure> = ring_down::run;
    let mut usual = 1000;
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--default" => (table, usual) = (default_decay::run, 100),
            "--default-curves" => (table, usual) = (default_curve::run, 40),
            "--default-levels" => (table, usual) = (default_levels::run, 200),
            "--resonance" => (table, usual) = (resonance::run, 300),
            "--table-one" => (table, usual) = (table_one::run, 200),
            "--write" => choices.write = true,
            "--only" => choices.only = words.next().ok_or("--only needs a part of a name")?.clone(),
            "--seeds" => {
                let count = words.next().ok_or("--seeds needs a number")?;
                choices.seeds = count.parse().map_err(|error| format!("--seeds {count}: {error}"))?;
            }
            other => {
                return Err(format!("`{other}` is not an option of statistics; see cargo xtask help").into());
            }
        }
    }
    if choices.seeds == 0 {
        choices.seeds = usual;
    }
    table(choices)
}

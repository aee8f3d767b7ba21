//! Project chores, run as `cargo xtask <chore>`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command speaks on both streams")]

mod book;
mod check;
mod fuzz;
mod places;
mod python;
mod tools;
mod validation;
mod web;

use std::process::ExitCode;

/// Error of a chore: it is printed and ends the chore.
type Failure = Box<dyn std::error::Error>;

const HELP: &str = "\
Usage: cargo xtask <chore>

  check         formatting, lints, documentation, every test, licences, spelling
  bench         speed and memory next to SciPy, lmfit and heyoka (needs Python 3.11 or newer)
  statistics    bias, spread and coverage on decays whose truth is known
  fuzz          files of every format, changed where that reaches new code: no panic, no hang, no
                excess of memory (needs a C++ compiler)
  web           the browser page as static files, in target/site
  book          every command of the documentation, its output compared

cargo xtask check [--only TEXT]
  --only TEXT   only the steps whose names hold TEXT; `browser` builds and tests the page

cargo xtask bench [--write] [--only a,b, …] [--rounds N]
  --write       renew docs/benchmarks.md
  --only        measure these lines of the table only
  --rounds N    take the best of N interleaved rounds (default 7)

cargo xtask statistics [--write] [--only TEXT] [--seeds N]
  --write       renew docs/statistics.md
  --only TEXT   only the cells whose name holds TEXT, such as Q=50
  --seeds N     records a cell (default 1000)

cargo xtask statistics --default [--write] [--only TEXT] [--seeds N]
  the answer as every user gets it, no model named (docs/statistics_default.md; 100 seeds)
cargo xtask statistics --default-curves [--write] [--only TEXT] [--seeds N]
  the same of resonance curves (docs/statistics_default_curves.md; 40 seeds)
cargo xtask statistics --default-levels [--write] [--only TEXT] [--seeds N]
  the same of drive levels (docs/statistics_default_levels.md; 200 seeds)
cargo xtask statistics --resonance [--write] [--only TEXT] [--seeds N]
  bias, spread and coverage of resonance curves, beside the paper's Lorentzian (docs/statistics_resonance.md; 300 seeds)

cargo xtask statistics --table-one [--write] [--seeds N]
  the paper's Table 1 in closed loop: ring-down and resonance at three loads, do they agree
  (docs/table_one.md; 200 repeats)

cargo xtask book [--write]
  --write       put what the commands print into the pages

cargo xtask fuzz [--minutes N] [--runs N] [--jobs N] [--only wav,npy, …] [--seed N] [--keep]
  --minutes N   for so long in all (default 10)
  --runs N      each target ends after so many inputs, if that comes first
  --jobs N      so many targets at once (default: one a core)
  --only        these targets only (fuzz/targets)
  --seed N      other changes than by the default, 1
  --keep        renew fuzz/corpus, the small files that reach most of the readers
";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let chore = arguments.next().unwrap_or_default();
    let rest: Vec<String> = arguments.collect();
    let outcome = match chore.as_str() {
        "check" => check::run(&rest),
        "bench" | "statistics" => validation::chore(&chore, &rest),
        "fuzz" => fuzz::run(&rest),
        "book" => book::chore(&rest),
        "web" if rest.is_empty() => web::chore(),
        "help" | "--help" | "-h" => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprint!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(2)
        }
    }
}

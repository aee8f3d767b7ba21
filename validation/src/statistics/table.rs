//! The tables as text.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a chore speaks to its terminal")]

use super::cell::{Cell, Nuisance, Outcome};
use std::fmt::Write;
use std::time::Duration;

pub(crate) fn progress(cell: &Cell, outcome: Option<&Outcome>, took: Duration) {
    match outcome {
        Some(o) => eprintln!(
            "{:46} n={:6} delta {:+.2} {:.3} {:.3}  x_F {:+.2} {:.3} {:.3}  claimed {:.3} failed {} {took:.1?}",
            cell.name(),
            o.samples,
            o.figures[0][0],
            o.figures[0][1],
            o.figures[0][2],
            o.figures[1][0],
            o.figures[1][1],
            o.figures[1][2],
            o.claimed,
            o.failed
        ),
        None => eprintln!("{:46} held by friction at once", cell.name()),
    }
}

pub(crate) fn show(text: &str) {
    println!("{text}");
}

const HEAD: &str = "| Q | share | dB | samples | cycles | δ bias | δ spread | δ covered | x_F bias | x_F spread | \
                    x_F covered | sliding claimed | misses |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

const REST: &str = "The bound is that of the samples up to the stop; where the place of rest tells which swing was \
                    the last, the spread falls below it.\n\n";

pub(crate) fn markdown(rows: &[(Cell, Option<Outcome>)], seeds: u64) -> String {
    let mut text = format!(
        "# Bias, spread and coverage\n\nMade by `cargo xtask statistics --write`, {seeds} seeds a cell. Exact decays \
         from release down to 3 % of the first amplitude or to the stop, white noise; *share* is the sliding part \
         of the loss at the start, *dB* the rms of the first cycles over that of the noise. The whole analysis runs \
         on each record; nothing is handed over but the model (viscous+sliding).\n\n*Bias* is over the spread (wanted \
         below 0.15), *spread* over the Cramér-Rao bound of the waveform with amplitude, phase, frequency and offset \
         free (wanted at most 1.10), *covered* the share of 95 % intervals that hold the truth (wanted 93 to 97 %). \
         Bias and spread are those of the unbounded estimate (`unbounded_value`), coverage that of the reported \
         interval. *Misses* names what is not met; with {seeds} seeds the coverage of a cell is itself uncertain by \
         {:.1} %.\n\n## White noise\n\n{HEAD}",
        100.0 * (0.95f64 * 0.05 / seeds as f64).sqrt()
    );
    let line = |text: &mut String, cell: &Cell, outcome: &Option<Outcome>| {
        let Some(o) = outcome else {
            let _ = writeln!(
                text,
                "| {} | {} | {} | | | | | | | | | | friction holds the mass at once: x_F exceeds the amplitude |",
                cell.q, cell.share, cell.snr_db
            );
            return;
        };
        let mut misses = Vec::new();
        let clean = cell.nuisance == Nuisance::None;
        for (name, [bias, spread, covered]) in ["δ", "x_F"].into_iter().zip(o.figures) {
            if clean && bias.abs() > 0.15 {
                misses.push(format!("{name} bias"));
            }
            if clean && spread > 1.10 {
                misses.push(format!("{name} spread"));
            }
            if (clean && !(0.93..=0.97).contains(&covered)) || covered < 0.9 {
                misses.push(format!("{name} coverage"));
            }
        }
        if clean && cell.share == 0.0 && o.claimed > 0.05 {
            misses.push("sliding claimed".into());
        }
        if o.failed > 0 {
            misses.push(format!("{} refused", o.failed));
        }
        let [d, x] = o.figures;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.0} | {:+.2} | {:.2} | {:.1} % | {:+.2} | {:.2} | {:.1} % | {:.1} % | {} |",
            cell.q,
            cell.share,
            cell.snr_db,
            o.samples,
            o.cycles,
            d[0],
            d[1],
            100.0 * d[2],
            x[0],
            x[1],
            100.0 * x[2],
            100.0 * o.claimed,
            misses.join(", ")
        );
    };
    for (cell, outcome) in rows.iter().filter(|r| r.0.nuisance == Nuisance::None) {
        line(&mut text, cell, outcome);
    }
    text.push_str("\n## With nuisances\n\nHere intervals are wanted to cover at least 90 %.\n");
    let mut last = None;
    for (cell, outcome) in rows.iter().filter(|r| r.0.nuisance != Nuisance::None) {
        if last != Some(cell.nuisance) {
            let note = if cell.nuisance == Nuisance::Rest { REST } else { "" };
            let _ = write!(text, "\n### {}\n\n{note}{HEAD}", cell.nuisance.name());
            last = Some(cell.nuisance);
        }
        line(&mut text, cell, outcome);
    }
    text
}

//! `slipfit atlas`: errors of the approximations over Q and beta.

use crate::args::AtlasArgs;
use crate::command::show::drawn;
use crate::failure::{Failure, warning_line};
use crate::output::{self, Outputs};
use crate::progress;
use anstream::ColorChoice;
use slipfit::motion::steady::atlas::{Cell, FLANK_HALF_WIDTHS, cell};
use slipfit_report::plot::{self, HeatMap};
use std::io::{self, Write};
use std::process::ExitCode;

const Q_RANGE: [f64; 2] = [2.0, 1e5];
const BETA_RANGE: [f64; 2] = [0.0, 0.99];

type Pick = fn(&Cell) -> Option<f64>;
/// Heading of the map, column of the table, value.
const MAPS: [(&str, &str, Pick); 6] = [
    ("eq. (8) at resonance", "leading_error", |c| Some(c.leading_error)),
    ("eq. (8), worst on the flanks", "leading_flank_error", |c| Some(c.leading_flank_error)),
    ("eq. (14), a = 4/3, at resonance", "lorentzian_error", |c| Some(c.lorentzian_error)),
    ("eq. (14), a = 4/3, worst on the flanks", "lorentzian_flank_error", |c| Some(c.lorentzian_flank_error)),
    ("eq. (16), ring-down", "ring_down_error", |c| c.ring_down_error),
    ("φ₁ at resonance, taken as 0 [rad]", "phi_1_rad", |c| Some(c.fundamental_phase)),
];

pub(crate) fn run(args: &AtlasArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let files = ["atlas.csv", "atlas.svg", "atlas.png"];
    let to = Outputs::new(args.replace.force, [])?.folder(&args.out, files)?;
    let along = |i: u32, n: u32| f64::from(i) / f64::from(n - 1);
    let [q_low, q_high] = Q_RANGE;
    let q: Vec<f64> =
        (0..args.q_points).map(|i| q_low * (q_high / q_low).powf(along(i, args.q_points))).collect();
    let [b_low, b_high] = BETA_RANGE;
    let beta: Vec<f64> =
        (0..args.beta_points).map(|i| b_low + (b_high - b_low) * along(i, args.beta_points)).collect();
    let bar = progress::bar((q.len() * beta.len()) as u64, "{pos}/{len} cells", false);
    let each = |q: f64, b: f64| {
        bar.inc(1);
        cell(q, b).ok()
    };
    let cells: Vec<Option<Cell>> =
        beta.iter().flat_map(|b| q.iter().map(|q| each(*q, *b)).collect::<Vec<_>>()).collect();
    bar.finish_and_clear();

    to.write("atlas.csv", |out| table(out, &q, &beta, &cells))?;
    let maps: Vec<HeatMap> = MAPS
        .iter()
        .map(|(title, _, pick)| HeatMap {
            title: (*title).to_owned(),
            values: cells.iter().map(|c| c.as_ref().and_then(pick)).collect(),
        })
        .collect();
    let caption = format!(
        "Exact steady motion and exact ring-down, static friction equal to sliding friction. Amplitudes at the turning \
         points; flanks to {FLANK_HALF_WIDTHS} half widths of the line (ω₀/2Q_f) either side, frequencies below \
         ω₀/5 left out. Ring-down from the resonance amplitude: largest difference at the turning points over \
         the initial amplitude, the stop excepted (grey: there is no other). The scale ends at 10⁻⁵ and 1; what lies beyond has the colour of the end."
    );
    let labels = ["Q", "β = 4F/(πk x₀)", "relative error, or rad"];
    let picture = plot::heat_maps("Where each approximation may be used", &caption, labels, &q, &beta, &maps);
    for (name, format) in [("atlas.svg", plot::Format::Svg), ("atlas.png", plot::Format::Png)] {
        let bytes = drawn(&picture, format)?;
        to.write(name, |out| out.write_all(&bytes))?;
    }
    let missing = cells.iter().filter(|c| c.is_none()).count();
    if missing > 0 {
        let total = cells.len();
        output::print_error(
            &warning_line(&format!("{missing} of {total} cells have no steady motion: they are left empty")),
            color,
        );
    }
    output::print(&format!("{}: atlas.csv, atlas.svg, atlas.png\n", args.out.display()), color)?;
    Ok(ExitCode::SUCCESS)
}

fn table(out: &mut dyn Write, q: &[f64], beta: &[f64], cells: &[Option<Cell>]) -> io::Result<()> {
    writeln!(out, "# slipfit {} atlas: errors of the paper's approximations", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# relative to the exact motion; signed at resonance, largest magnitude elsewhere")?;
    writeln!(out, "# flanks: within {FLANK_HALF_WIDTHS} half line widths")?;
    let names: Vec<&str> = MAPS.iter().map(|m| m.1).collect();
    writeln!(out, "q_factor,beta,way,gain,{}", names.join(","))?;
    for (i, cell) in cells.iter().enumerate() {
        write!(out, "{},{}", q[i % q.len()], beta[i / q.len()])?;
        match cell {
            Some(c) => {
                write!(out, ",{},{:e}", c.method.name(), c.gain)?;
                for (_, _, pick) in MAPS {
                    match pick(c) {
                        Some(error) => write!(out, ",{error:e}")?,
                        None => write!(out, ",")?,
                    }
                }
            }
            None => write!(out, "{}", ",".repeat(2 + MAPS.len()))?,
        }
        writeln!(out)?;
    }
    Ok(())
}

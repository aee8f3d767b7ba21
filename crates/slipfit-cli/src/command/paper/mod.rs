//! `slipfit paper`: figures and statements of the paper, compared with the exact motion.

mod page;
mod response;
mod ringdowns;
mod waveforms;

use crate::args::PaperArgs;
use crate::command::show::drawn;
use crate::failure::Failure;
use crate::output::{self, Folder, Outputs};
use crate::progress;
use anstream::ColorChoice;
use slipfit_report::plot::{self, Chart};
use std::io::{self, Write};
use std::process::ExitCode;

/// All files that are written.
const FILES: [&str; 13] = [
    "paper.md",
    "fig1.svg",
    "fig1.png",
    "fig1_a.csv",
    "fig1_b.csv",
    "fig1_c.csv",
    "fig1_d.csv",
    "fig2.svg",
    "fig2.png",
    "fig2_a.csv",
    "fig2_b.csv",
    "fig2_c.csv",
    "fig2_d.csv",
];

pub(crate) fn run(args: &PaperArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let to = Outputs::new(args.replace.force, [])?.folder(&args.out, FILES)?;
    let computed = |e: slipfit::Error| Failure::new(format!("the paper's case could not be computed: {e}"));
    let (first, ringdowns, response, third) = progress::with_spinner("computing", false, || {
        let (first, ringdowns) = (waveforms::charts()?, ringdowns::measure(args.seed)?);
        Ok((first, ringdowns, response::curves()?, response::at_a_third()?))
    })
    .map_err(computed)?;
    let mut second = ringdowns::charts(&ringdowns);
    second.push(response.chart);
    second.push(third.chart);

    let heading = "Fig. 1: steady motion with sliding friction, Q = 10⁴, ω = ω₀";
    write_figure(&to, "fig1", heading, &first.caption, &first.charts)?;
    let heading = "Fig. 2: a tuning fork under load, f₀ = 32.7 kHz, k = 10⁴ N/m";
    let caption = format!("{} {}", ringdowns::CAPTION, response::caption(third.left_out));
    write_figure(&to, "fig2", heading, &caption, &second)?;
    let statements = slipfit::paper::statements().map_err(computed)?;
    let text = page::markdown(&statements, &first.notes, &ringdowns, &response.fits, args.seed);
    to.write("paper.md", |out| out.write_all(text.as_bytes()))?;
    let summary = format!(
        "{}: paper.md, fig1 and fig2 as .svg and .png, {} tables as .csv\n",
        args.out.display(),
        first.charts.len() + second.len()
    );
    output::print(&summary, color)?;
    Ok(ExitCode::SUCCESS)
}

fn write_figure(
    to: &Folder,
    name: &str,
    heading: &str,
    caption: &str,
    charts: &[Chart],
) -> Result<(), Failure> {
    let picture = plot::page(heading, caption, charts);
    for (ending, format) in [("svg", plot::Format::Svg), ("png", plot::Format::Png)] {
        let bytes = drawn(&picture, format)?;
        to.write(&format!("{name}.{ending}"), |out| out.write_all(&bytes))?;
    }
    for chart in charts {
        to.write(&format!("{}.csv", chart.file), |out| table(out, chart))?;
    }
    Ok(())
}

/// One row per point, with the name of the curve first.
fn table(out: &mut dyn Write, chart: &Chart) -> io::Result<()> {
    writeln!(out, "# slipfit {} paper: {}", env!("CARGO_PKG_VERSION"), chart.title)?;
    writeln!(out, "curve,{},{}", quoted(&chart.x.label), quoted(&chart.y.label))?;
    for series in &chart.series {
        for [x, y] in &series.points {
            if x.is_finite() && y.is_finite() {
                writeln!(out, "{},{x},{y}", quoted(&series.name))?;
            }
        }
    }
    Ok(())
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

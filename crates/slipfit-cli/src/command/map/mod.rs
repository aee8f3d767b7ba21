//! `slipfit map`: a trace in each pixel.

mod answers;
mod blocks;
mod layout;
mod table;
mod zarr;

use crate::args::{MapArgs, MapKind, MapMethod};
use crate::command::show::drawn;
use crate::failure::{Failure, spelled};
use crate::interrupt::{self, INTERRUPTED};
use crate::output::{self, Outputs};
use crate::progress;
use anstream::ColorChoice;
use answers::Map;
use blocks::Blocks;
use slipfit::SignalKind;
use slipfit_batch::{Clock, Error, Grid, Method, Number, Options, Signal, fit_pixels};
use slipfit_io::Stack;
use slipfit_report::plot::Format;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use table::Table;

pub(crate) fn run(args: &MapArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let mut outputs = Outputs::new(args.replace.force, [args.file.as_path()])?;
    let table = args.table.as_deref().map(|path| Table::planned(&mut outputs, path)).transpose()?;
    let plot = match args.plot.as_deref() {
        Some(path) => {
            let format = picture(path)?;
            Some((outputs.add("--plot", path)?, format))
        }
        None => None,
    };
    let mut stack = Stack::open(&args.file, args.data.as_deref())?;
    let grid = Grid::new(stack.shape(), usize::from(args.axis)).map_err(|e| refused(&args.file, &e))?;
    let options = options(args, stack.unit());
    let blocks = match &args.resume {
        Some(folder) => {
            Some(Blocks::in_folder(folder, grid.blocks(), &options, &mut outputs, args.replace.force)?)
        }
        None => None,
    };
    // An unfinished map is worth keeping only if blocks are kept.
    if blocks.is_some() {
        interrupt::enable_graceful_stop()?;
    }
    let [rows, columns] = grid.pixels();
    let bar = progress::bar((rows * columns) as u64, "{pos}/{len} pixels", args.quiet);
    let mut parts = Vec::new();
    for block in grid.blocks() {
        if interrupt::stop_requested() {
            bar.abandon();
            return Ok(ExitCode::from(INTERRUPTED));
        }
        let values = stack.part(grid.cut(), block.clone())?;
        let traces = grid.traces(block.len(), values).map_err(|e| refused(&args.file, &e))?;
        let fit = |traces| {
            fit_pixels(traces, grid.samples(), &options, &AtomicBool::new(false))
                .map_err(|e| refused(&args.file, &e))
        };
        parts.push(match &blocks {
            Some(blocks) => blocks.load_or_compute(&block, traces, fit)?,
            None => fit(traces)?,
        });
        bar.inc((block.len() * columns) as u64);
    }
    bar.finish_and_clear();
    interrupt::begin_completion();
    let map = Map { parts, pixels: [rows, columns] };
    if let Some(table) = table {
        table.write(&map)?;
    }
    if let Some((target, format)) = plot {
        let bytes = drawn(&map.picture(args), format)?;
        target.write(|out| out.write_all(&bytes))?;
    }
    if !args.quiet {
        output::print(&map.summary(args, grid.samples()), color)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn picture(path: &Path) -> Result<Format, Failure> {
    Format::of(path)
        .ok_or_else(|| Failure::new(format!("--plot {}: the name must end in .svg or .png", path.display())))
}

fn refused(file: &Path, error: &Error) -> Failure {
    match error {
        Error::Option { option: "stack", problem } => Failure::new(format!("{}: {problem}", file.display())),
        Error::Option { option, problem } => Failure::new(format!("{}: {problem}", spelled(option, None))),
        other => Failure::new(format!("{}: {other}", file.display())),
    }
}

fn options(args: &MapArgs, unit: &str) -> Options {
    let signal = match args.kind {
        MapKind::Amplitude => Signal::Amplitude("trace".into()),
        MapKind::Displacement => Signal::Oscillation("trace".into(), SignalKind::Displacement),
        MapKind::Velocity => Signal::Oscillation("trace".into(), SignalKind::Velocity),
        MapKind::Acceleration => Signal::Oscillation("trace".into(), SignalKind::Acceleration),
    };
    let method = match args.method {
        MapMethod::Fit => Method::Fit,
        MapMethod::Analyse => Method::Analyse,
    };
    let mut options = Options::new(signal, Clock::Interval(Number::Same(args.dt)), method);
    options.frequency_hz = args.frequency_hz.map(Number::Same);
    options.min_amplitude = args.min_amplitude.map(Number::Same);
    let unit = args.unit.as_deref().unwrap_or(unit);
    let of_levels = slipfit_io::unit_of_levels(unit);
    options.levels = of_levels.is_some();
    options.unit = of_levels.unwrap_or(unit).to_owned();
    options
}

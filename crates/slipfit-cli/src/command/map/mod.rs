//! `slipfit map`: a trace in each pixel.

mod blocks;
mod table;

use crate::args::{MapArgs, MapKind, MapMethod};
use crate::command::show::drawn;
use crate::failure::{Failure, spelled};
use crate::interrupt::{self, INTERRUPTED};
use crate::output::{self, Outputs, Target};
use anstream::ColorChoice;
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use blocks::Blocks;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipfit::SignalKind;
use slipfit_batch::{Clock, Error, Grid, Method, Number, Options, Signal, fit_pixels};
use slipfit_io::Stack;
use slipfit_report::format::{Scale, plain};
use slipfit_report::plot::{self, Format, Image};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use table::Form;

pub(crate) fn run(args: &MapArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let mut outputs = Outputs::new(args.replace.force, [args.file.as_path()])?;
    let table =
        args.table.as_deref().map(|path| planned(&mut outputs, "--table", path, Form::of)).transpose()?;
    let plot = args.plot.as_deref().map(|path| planned(&mut outputs, "--plot", path, picture)).transpose()?;
    let mut stack = Stack::open(&args.file, args.data.as_deref())?;
    let grid = Grid::new(stack.shape(), usize::from(args.axis)).map_err(|e| refused(&args.file, &e))?;
    let options = options(args, stack.unit());
    let blocks = args.resume.as_deref().map(|folder| Blocks::in_folder(folder, &options)).transpose()?;
    // A half-done map is worth keeping only where blocks are kept.
    if blocks.is_some() {
        interrupt::watch()?;
    }
    let [rows, columns] = grid.pixels();
    let bar = progress((rows * columns) as u64, args.quiet);
    let mut parts = Vec::new();
    for block in grid.blocks() {
        if interrupt::asked() {
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
            Some(blocks) => blocks.taken_or(&block, traces, fit)?,
            None => fit(traces)?,
        });
        bar.inc((block.len() * columns) as u64);
    }
    bar.finish_and_clear();
    interrupt::closing();
    let map = Map { parts, pixels: [rows, columns], unit: &options.unit };
    if let Some((target, form)) = table {
        table::write(&target, form, &map)?;
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

/// An output whose ending says its form.
fn planned<T>(
    outputs: &mut Outputs,
    flag: &str,
    path: &Path,
    form: impl Fn(&Path) -> Result<T, Failure>,
) -> Result<(Target, T), Failure> {
    let form = form(path)?;
    Ok((outputs.add(flag, path)?, form))
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
    options.unit = args.unit.clone().unwrap_or_else(|| unit.to_owned());
    options
}

fn progress(pixels: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(pixels), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} pixels, {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// The answers of all blocks.
struct Map<'a> {
    parts: Vec<RecordBatch>,
    pixels: [usize; 2],
    unit: &'a str,
}

impl Map<'_> {
    /// A column of numbers, `None` where a pixel has none.
    fn numbers(&self, name: &str) -> Vec<Option<f64>> {
        let columns = self.parts.iter().filter_map(|part| part.column_by_name(name));
        columns.flat_map(|column| column.as_primitive::<Float64Type>().iter()).collect()
    }

    fn texts<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        let columns = self.parts.iter().filter_map(move |part| part.column_by_name(name));
        columns.flat_map(|column| column.as_string::<i32>().iter().map(Option::unwrap_or_default))
    }

    /// What is drawn and summed up: name, words and unit.
    fn shown(&self) -> Vec<(&'static str, &'static str, String)> {
        let per_s = if self.unit.is_empty() { "1/s".to_owned() } else { format!("{}/s", self.unit) };
        let all = [
            ("friction_displacement", "friction displacement", self.unit.to_owned()),
            ("sliding_rate", "sliding rate", per_s),
            ("decay_rate_per_s", "decay rate", "1/s".to_owned()),
        ];
        let known = |name: &str| self.numbers(name).iter().any(Option::is_some);
        // The rate stands in where no frequency turns it into a displacement.
        let displacement = known("friction_displacement");
        let wanted = |name: &str| if name == "sliding_rate" { !displacement } else { known(name) };
        all.into_iter().filter(|(name, ..)| wanted(name)).collect()
    }

    fn picture(&self, args: &MapArgs) -> plot::Picture {
        let shown = self.shown();
        let image = |(name, words, unit): &(&str, &str, String)| {
            let mut values = self.numbers(name);
            let mut sizes: Vec<f64> = values.iter().flatten().map(|v| v.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            // That of the middle value: a stray pixel has no say.
            let scale = Scale::for_size(sizes.get(sizes.len() / 2).copied().unwrap_or(0.0), unit);
            values.iter_mut().flatten().for_each(|v| *v *= scale.factor);
            Image { title: scale.titled(words), values }
        };
        let images: Vec<Image> = shown.iter().map(image).collect();
        let file = args.file.display().to_string();
        let data = args.data.as_deref().map(|data| format!(":{data}")).unwrap_or_default();
        let axis = args.axis;
        let note = |y: usize, x: usize| {
            let index = match axis {
                0 => format!(":, {y}, {x}"),
                1 => format!("{y}, :, {x}"),
                _ => format!("{y}, {x}, :"),
            };
            format!("{file}{data}[{index}]")
        };
        let caption = "Viscous and sliding loss of each pixel. Colours leave one value in a hundred out at \
                       either end; grey: no answer.";
        plot::images(&file, caption, self.pixels, &images, &note)
    }

    fn summary(&self, args: &MapArgs, samples: usize) -> String {
        let [rows, columns] = self.pixels;
        let mut text = format!("{}: {rows} × {columns} pixels of {samples} samples\n", args.file.display());
        let mut status: BTreeMap<&str, usize> = BTreeMap::new();
        self.texts("status").for_each(|word| *status.entry(word).or_default() += 1);
        let counts: Vec<String> = status.iter().map(|(word, count)| format!("{count} {word}")).collect();
        text += &format!("  {}\n", counts.join(", "));
        let flags = self.parts.iter().filter_map(|part| part.column_by_name("sliding_detected"));
        let detected: usize = flags.map(|column| column.as_boolean().true_count()).sum();
        text += &format!("  sliding friction detected in {detected}\n");
        for (name, words, unit) in self.shown() {
            let mut values: Vec<f64> = self.numbers(name).into_iter().flatten().collect();
            values.sort_by(f64::total_cmp);
            let at = |part: f64| values[(part * (values.len() - 1) as f64).round() as usize];
            let [median, low, high] = [0.5, 0.25, 0.75].map(|part| plain(at(part), 4, &unit));
            text += &format!("  {words}: {median} in the middle, half of the pixels from {low} to {high}\n");
        }
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        self.texts("reason").filter(|r| !r.is_empty()).for_each(|r| *reasons.entry(r).or_default() += 1);
        let mut reasons: Vec<(&str, usize)> = reasons.into_iter().collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        for (reason, count) in reasons.iter().take(MOST_REASONS) {
            text += &format!("  {count}: {reason}\n");
        }
        if let Some(others) = reasons.len().checked_sub(MOST_REASONS).filter(|others| *others > 0) {
            text += &format!("  and {others} reasons more: --table has all of them\n");
        }
        text
    }
}

/// Reasons that are listed.
const MOST_REASONS: usize = 8;

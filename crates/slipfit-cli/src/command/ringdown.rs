//! `slipfit ringdown`: from a file to its answer.

use super::show::{Faces, show};
use crate::args::RingdownArgs;
use crate::failure::{Failure, warning_line};
use crate::{batch, csv, json, page, plot, report};
use anstream::ColorChoice;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipfit::SignalKind;
use slipfit::format::plain;
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit_io::{Format, Reading};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// A file this large, in bytes, is read with a bar; it takes about a tenth of a second.
const LARGE: u64 = 32 << 20;

/// A file, what was asked of it, and what it answered.
pub(crate) struct Analysed<'a> {
    pub(crate) file: &'a Path,
    pub(crate) reading: &'a Reading,
    pub(crate) options: &'a Options,
    pub(crate) answer: &'a Answer,
}

pub(crate) fn run(args: &RingdownArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if args.table.table.is_some() || args.files.len() > 1 {
        let task = batch::Task {
            command: "ringdown",
            files: &args.files,
            table: &args.table,
            out: &args.out,
            columns: batch::ringdown::COLUMNS,
            options: format!("{:?} {:?}", args.reading.options(), args.options()),
            one: &|file| Ok(batch::ringdown::row(file, &analyse_file(file, args)?)),
        };
        return batch::run(&task, color);
    }
    let plot_format = args.out.plot.as_deref().map(plot::Format::of).transpose()?;
    let file = &args.files[0];
    let Done { reading, options, answer } = watched(file, args)?;
    let analysed = Analysed { file, reading: &reading, options: &options, answer: &answer };

    let picture = plot_format.map(|format| plot::ringdown(&analysed, format)).transpose()?;
    let faces = Faces {
        picture,
        csv: &|out| csv::ringdown(out, &analysed),
        json: &|out| json::ringdown(out, &analysed),
        html: &|| page::html(&page::ringdown(&analysed)),
        markdown: &|| page::markdown(&page::ringdown(&analysed)),
        latex: &|| page::latex(&page::ringdown(&analysed)),
        report: &|written| report::ringdown(&analysed, written),
        warnings: answer.warnings.iter().map(|w| warning_line(&w.to_string())).collect(),
    };
    show(&args.out, &faces, color)
}

/// A file read and analysed.
pub(crate) struct Done {
    pub(crate) reading: Reading,
    pub(crate) options: Options,
    pub(crate) answer: Answer,
}

/// Reads and analyses one file, with a bar where that takes a while.
fn watched(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    let bytes = std::fs::metadata(file).map_or(0, |m| m.len());
    if args.out.quiet || bytes < LARGE {
        return analyse_file(file, args);
    }
    let bar = ProgressBar::with_draw_target(Some(bytes), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}, {eta} left") {
        bar.set_style(style);
    }
    let spin = |message| {
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(message);
        bar.enable_steady_tick(Duration::from_millis(120));
    };
    let read = slipfit_io::read_watched(file, &args.reading.options(), &mut |n| {
        bar.set_position(n);
        // Formats other than text are decoded once all of their bytes have passed.
        if n >= bytes {
            spin("decoding");
        }
    });
    let done = read.map_err(Failure::from).and_then(|reading| {
        spin("analysing");
        analyse_reading(file, reading, args)
    });
    bar.finish_and_clear();
    done
}

/// Reads and analyses one file.
pub(crate) fn analyse_file(file: &Path, args: &RingdownArgs) -> Result<Done, Failure> {
    analyse_reading(file, slipfit_io::read(file, &args.reading.options())?, args)
}

fn analyse_reading(file: &Path, reading: Reading, args: &RingdownArgs) -> Result<Done, Failure> {
    check_calibration(args.calibration_flag(), reading.record.unit())?;
    let mut options = args.options();
    if options.frequency_hz.is_none() {
        options.frequency_hz = named_frequency_hz(&reading);
    }
    heeded(&reading, args)?;
    let answer = analyse(&reading.record, &options).map_err(|e| Failure::analysing(file, &e))?;
    reached(&options, &answer)?;
    Ok(Done { reading, options, answer })
}

/// A flag that would change nothing is a mistake.
fn heeded(reading: &Reading, args: &RingdownArgs) -> Result<(), Failure> {
    let amplitudes = matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    if let Some(f) = args.options().frequency_hz.filter(|_| !amplitudes) {
        return Err(Failure::new(format!(
            "--frequency-hz {f}: only for a record of amplitudes; this one oscillates and has its own frequency"
        ))
        .hint("--band says where to look for it"));
    }
    if let Some(sheet) = args.reading.sheet.as_ref().filter(|_| reading.report.format == Format::Text) {
        return Err(Failure::new(format!("--sheet {sheet}: a text has no sheets"))
            .hint("--part chooses one of several tables side by side, --run one of several runs"));
    }
    Ok(())
}

/// A least amplitude that no amplitude reaches leaves nothing to fit.
fn reached(options: &Options, answer: &Answer) -> Result<(), Failure> {
    let (Some(least), Some(first)) = (options.min_amplitude, answer.parameter("initial_amplitude")) else {
        return Ok(());
    };
    if first.value.is_nan() || first.value > least {
        return Ok(());
    }
    let (unit, first) = (&answer.signal_unit, plain(first.value, 3, &answer.signal_unit));
    Err(Failure::new(format!("--min-amplitude {least} {unit}: the decay begins at {first} already")))
}

/// The frequency of the oscillation, where amplitudes alone were recorded and
/// the lines above the table name it `frequency_hz`.
pub(crate) fn named_frequency_hz(reading: &Reading) -> Option<f64> {
    if !matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn) {
        return None;
    }
    let named = reading.report.named_values.iter().find(|(name, _)| name == "frequency_hz")?;
    named.1.parse().ok().filter(|f: &f64| f.is_finite() && *f > 0.0)
}

/// A stiffness in N/m says nothing about an angle, nor a torsion stiffness about a length.
pub(crate) fn check_calibration(given: Option<(&'static str, bool)>, unit: &str) -> Result<(), Failure> {
    let angle = matches!(unit, "rad" | "mrad" | "deg" | "°" | "rev");
    let length = matches!(unit, "m" | "cm" | "mm" | "µm" | "um" | "nm" | "pm");
    match given {
        Some((flag, false)) if angle => {
            Err(Failure::new(format!("{flag} is for a displacement; the signal is in {unit}"))
                .hint("--torsion-stiffness or --inertia calibrates an angle, --unit changes the unit read"))
        }
        Some((flag, true)) if length => {
            Err(Failure::new(format!("{flag} is for an angle; the signal is in {unit}"))
                .hint("--stiffness or --mass calibrates a displacement, --unit changes the unit read"))
        }
        _ => Ok(()),
    }
}

/// An answer whose numbers are set by hand and then changed, for tests of output.
#[cfg(test)]
pub(crate) fn by_hand<T>(change: impl FnOnce(&mut Answer), look: impl FnOnce(&Analysed<'_>) -> T) -> T {
    use slipfit::Quantity;
    use slipfit::ringdown::{LossModel, Parameter};

    let decay = slipfit::Oscillator::kinematic(8.0, 0.03, 0.002)
        .and_then(|o| slipfit::motion::decay::FreeDecay::from_rest(&o, 0.35))
        .unwrap();
    let mut text = String::from("t (s);angle (rad)\n");
    for i in 0..1500 {
        let t = 0.02 * f64::from(i);
        text += &format!("{t:.2};{:.5}\n", decay.displacement(t) + 1e-4 * (7.7 * f64::from(i * i)).sin());
    }
    let reading = slipfit_io::read_text(text.as_bytes(), "swing.csv", &Default::default()).unwrap();
    let mut options = Options::default();
    options.model = Some(LossModel::ViscousSliding);
    let mut answer = analyse(&reading.record, &options).unwrap();

    let mut x_f = Quantity::normal(0.002, 2e-5, "rad");
    x_f.interval_95 = [0.001_98, 0.002_1];
    let mut drag = Quantity::normal(0.0, 2e-3, "1/(rad s)");
    drag.interval_95 = [0.0, 4e-3];
    answer.parameters = vec![
        Parameter { name: "frequency_hz", quantity: Quantity::normal(1.2732, 1.2e-5, "Hz") },
        Parameter { name: "decay_rate_per_s", quantity: Quantity::normal(0.0302, 4e-4, "1/s") },
        Parameter { name: "friction_displacement", quantity: x_f },
        Parameter { name: "sliding_rate", quantity: Quantity::normal(0.0102, 1e-4, "rad/s") },
        Parameter { name: "drag_rate", quantity: drag },
        Parameter { name: "initial_amplitude", quantity: Quantity::normal(0.35, 1e-5, "rad") },
    ];
    let template = answer.comparison[0].clone();
    answer.comparison = [
        (LossModel::ViscousSliding, 0.0),
        (LossModel::ViscousSlidingDrag, 7.3),
        (LossModel::Viscous, 1530.2),
    ]
    .into_iter()
    .map(|(model, delta_bic)| slipfit::ringdown::Candidate {
        model,
        delta_bic,
        rms: if delta_bic > 10.0 { 2.2e-3 } else { 1.0e-4 },
        converged: true,
        at_limit: model.has_drag().then_some("drag_rate"),
        decay_rate_per_s: 0.0302,
        friction_displacement: if model.has_sliding() { 0.002 } else { 0.0 },
        drag_rate: 0.0,
        ..template.clone()
    })
    .collect();
    answer.model = LossModel::ViscousSliding;
    answer.sliding.detected = true;
    answer.sliding.share_at_start = 0.41;
    answer.sliding.dominates_from_s = Some(16.0);
    answer.sliding.viscous_only_p_value = 0.0;
    answer.segment.start_s = 0.0;
    answer.segment.end_s = 24.0;
    answer.segment.samples = 1200;
    answer.segment.cycles = 30.6;
    answer.segment.start_reason = "the record starts";
    answer.segment.end_reason = "the motion comes to rest";
    answer.stop = Some(slipfit::ringdown::Stop {
        time_s: 24.1,
        position: 0.001_2,
        position_std_error: 2e-5,
        static_displacement: Some([0.001_2, 0.002_4]),
    });
    answer.diagnostics.method = "waveform";
    answer.diagnostics.noise_rms = 1e-4;
    answer.diagnostics.signal_to_noise_db = 68.0;
    answer.diagnostics.residual_excess = 1.02;
    answer.diagnostics.decay_times = 4.3;
    answer.diagnostics.left_out = 0;
    answer.warnings = Vec::new();
    change(&mut answer);
    look(&Analysed { file: Path::new("swing.csv"), reading: &reading, options: &options, answer: &answer })
}

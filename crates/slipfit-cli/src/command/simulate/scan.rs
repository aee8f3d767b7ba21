//! `slipfit simulate sweep` and `slipfit simulate levels`.

use super::oscillator::{driven_oscillator, friction, in_flags, oscillator};
use super::sampling::Noise;
use super::sheet::{Column, Digits, Parameters, Sheet, Step, converted};
use super::write;
use crate::args::{LevelsArgs, SampleArgs, SweepArgs};
use crate::failure::Failure;
use slipfit::motion::steady::Phasor;
use slipfit::motion::steady::scan::{Reading, chirp_with_friction, reading_with_friction, stepped};

pub(super) fn sweep(args: &SweepArgs, to: &write::Destinations) -> Result<(), Failure> {
    let unit = &args.sample.unit;
    let (o, x_0) = driven_oscillator(&args.oscillator, &args.drive, unit)?;
    let (start, stop) = (args.start_hz, args.stop_hz);
    let friction = friction(&args.oscillator.minus, &o, unit)?;
    let mut frequencies = spaced(start, stop, args.points, false);
    let readings: Vec<Reading> = match (args.sweep_time, args.wait) {
        (Some(s), _) => chirp_with_friction(&o, friction, x_0, [start, stop], s, args.points),
        (None, Some(wait)) => {
            let steps: Vec<_> = frequencies.map(|f| (x_0, f)).collect();
            stepped(&o, friction, &steps, wait)
        }
        (None, None) => frequencies.try_fold(Vec::new(), |mut all, f| {
            all.push(reading_with_friction(&o, friction, x_0, f)?);
            Ok(all)
        }),
    }
    .map_err(in_flags)?;
    let mut all = Parameters::of(&o, unit);
    all.uneven(friction, &o, unit);
    all.number("drive_amplitude", x_0, unit);
    if let Some(p) = args.drive.drive_force {
        all.force("drive_force", p, &o);
    }
    all.number("friction_ratio", o.friction_ratio(x_0), "");
    all.number("start_hz", start, "");
    all.number("stop_hz", stop, "");
    all.number("points", f64::from(args.points), "");
    match (args.sweep_time, args.wait) {
        (Some(s), _) => all.number("sweep_time_s", s, ""),
        (None, Some(s)) => all.number("wait_s", s, ""),
        (None, None) => all.text("settled", "every point is the steady motion"),
    }
    let description = ReadingsDescription {
        command: "sweep",
        title: "amplitude and phase of the fundamental over the frequency of the drive",
        parameters: all,
        column: Column::new("frequency", "Hz", Digits::Shortest),
        place: |r| r.frequency_hz,
    };
    record(description, &readings, &args.sample, to)
}

pub(super) fn levels(args: &LevelsArgs, to: &write::Destinations) -> Result<(), Failure> {
    let unit = &args.sample.unit;
    let o = oscillator(&args.oscillator, unit, |_| Ok(args.stop_amplitude))?;
    let frequency_hz = args.drive_frequency_hz.unwrap_or(o.frequency_hz());
    let friction = friction(&args.oscillator.minus, &o, unit)?;
    let mut amplitudes = spaced(args.start_amplitude, args.stop_amplitude, args.points, args.log);
    let readings: Vec<Reading> = match args.wait {
        Some(wait) => {
            let steps: Vec<_> = amplitudes.map(|x_0| (x_0, frequency_hz)).collect();
            stepped(&o, friction, &steps, wait)
        }
        None => amplitudes.try_fold(Vec::new(), |mut all, x_0| {
            all.push(reading_with_friction(&o, friction, x_0, frequency_hz)?);
            Ok(all)
        }),
    }
    .map_err(in_flags)?;
    let mut all = Parameters::of(&o, unit);
    all.uneven(friction, &o, unit);
    all.number("drive_frequency_hz", frequency_hz, "");
    all.number("start_amplitude", args.start_amplitude, unit);
    all.number("stop_amplitude", args.stop_amplitude, unit);
    all.number("points", f64::from(args.points), "");
    if let Some(wait) = args.wait {
        all.number("wait_s", wait, "");
    }
    let description = ReadingsDescription {
        command: "levels",
        title: "amplitude and phase of the fundamental over the amplitude of the drive",
        parameters: all,
        column: Column::new("drive amplitude", unit, Digits::Shortest),
        place: |r| r.drive_amplitude,
    };
    record(description, &readings, &args.sample, to)
}

/// `points` values from one end to the other, both reached exactly.
fn spaced(from: f64, to: f64, points: u32, log: bool) -> impl Iterator<Item = f64> {
    let last = points - 1;
    (0..points).map(move |i| match i {
        0 => from,
        i if i == last => to,
        i => {
            let part = f64::from(i) / f64::from(last);
            if log { from * (to / from).powf(part) } else { from + (to - from) * part }
        }
    })
}

/// Description of the readings.
struct ReadingsDescription {
    command: &'static str,
    title: &'static str,
    parameters: Parameters,
    /// Column of the varied quantity, and its value.
    column: Column,
    place: fn(&Reading) -> f64,
}

/// Writes the readings with the noise and resolution of the sensor.
fn record(
    description: ReadingsDescription,
    readings: &[Reading],
    sample: &SampleArgs,
    to: &write::Destinations,
) -> Result<(), Failure> {
    let largest = readings.iter().map(Reading::amplitude).fold(0.0, f64::max);
    let ReadingsDescription { command, title, mut parameters, column, place } = description;
    parameters.sensor(sample, largest);
    let mut noise = Noise::new(sample.seed, sample.noise_rms);
    let sheet = Sheet {
        command,
        title,
        parameters: parameters.0,
        columns: vec![
            column,
            Column::new("amplitude", &sample.unit, Digits::Shortest),
            Column::new("phase", "deg", Digits::Shortest),
        ],
        rows: readings.len() as u64,
        fill: Box::new(move |i, row| {
            let mut reading = readings[i as usize];
            reading.fundamental += Phasor::new(noise.next(), noise.next());
            let amplitude = converted(sample, largest, reading.amplitude());
            // A mass at rest has no phase, and the cell is empty.
            let phase_deg = reading.phase_rad().map_or(f64::NAN, f64::to_degrees);
            row.extend([place(&reading), amplitude, phase_deg]);
            Ok(Step::Row)
        }),
        even_rate_hz: None,
    };
    write::write(sheet, to)
}

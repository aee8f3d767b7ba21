//! `slipfit simulate driven`.

use super::decay::turning_point_columns;
use super::sheet::{Column, Digits, Parameters, Sheet, converted};
use super::{Noise, driven_oscillator, rows, spoken, write};
use crate::args::{Beginning, DrivenArgs};
use crate::failure::Failure;
use slipfit::simulate::{Drive, Event, EventKind, Motion};
use slipfit::steady::{HarmonicDrive, solve};
use std::f64::consts::TAU;

pub(super) fn run(args: &DrivenArgs) -> Result<(), Failure> {
    let (o, x_0) = driven_oscillator(&args.oscillator, &args.drive)?;
    let frequency_hz = args.drive_frequency_hz.unwrap_or(o.frequency_hz());
    let omega = TAU * frequency_hz;
    let said = |e: slipfit::Error| spoken(&e);
    let mut drive = Drive::harmonic(x_0, omega).map_err(said)?;
    if !args.turning_points {
        drive.check_sampling(args.sampling.rate_hz).map_err(said)?;
    }
    let rows = rows(args.sampling.duration, args.sampling.rate_hz)?;
    let (position, velocity) = match args.from {
        Beginning::Rest => (0.0, 0.0),
        Beginning::Steady => {
            solve(&o, &HarmonicDrive::new(x_0, omega).map_err(said)?).map_err(said)?.state.state(0.0)
        }
    };
    if let Some(off_at) = args.off_at {
        drive = drive.until(off_at).map_err(said)?;
    }
    let motion = Motion::new(&o, drive, 0.0, position, velocity).map_err(said)?;
    // A converter is set to what it is going to see.
    let full_scale = if args.sample.quantize_bits.is_some() {
        largest(motion.clone(), args.sampling.duration, position)
    } else {
        0.0
    };

    let unit = &args.sample.unit;
    let mut all = Parameters::of(&o, unit);
    all.number("drive_amplitude", x_0, unit);
    if let Some(p) = args.drive.drive_force {
        all.number("drive_force", p, "N");
    }
    all.number("drive_frequency_hz", frequency_hz, "");
    all.number("friction_ratio", o.friction_ratio(x_0), "");
    if let Some(off_at) = args.off_at {
        all.number("drive_off_at_s", off_at, "");
    }
    all.number("initial_position", position, unit);
    all.number("initial_velocity", velocity, &format!("{unit}/s"));
    all.number("duration_s", args.sampling.duration, "");
    all.number("rate_hz", args.sampling.rate_hz, "");
    all.sensor(&args.sample, full_scale);
    let mut sheet = Sheet {
        command: "driven",
        title: "exact motion under a harmonic drive, x_0 cos(2 pi f t), with sliding friction",
        parameters: all.0,
        columns: vec![
            Column::new("time", "s", Digits::Shortest),
            Column::new("displacement", unit, Digits::Seven),
        ],
        rows,
        fill: trace(args, motion.clone(), full_scale),
        even_rate_hz: Some(args.sampling.rate_hz),
    };
    if args.turning_points {
        let points: Vec<[f64; 2]> = turning_points(motion, args.sampling.duration).collect();
        sheet.rows = points.len() as u64;
        sheet.columns = turning_point_columns(unit);
        sheet.even_rate_hz = None;
        sheet.fill = Box::new(move |i, row| {
            row.extend(points[i as usize]);
            Ok(true)
        });
    }
    write::write(sheet, &args.out)
}

fn trace(args: &DrivenArgs, mut motion: Motion, full_scale: f64) -> super::sheet::Fill<'_> {
    let mut noise = Noise::new(args.sample.seed, args.sample.noise_rms);
    Box::new(move |i, row| {
        let time_s = i as f64 / args.sampling.rate_hz;
        let x = motion.state_at(time_s).map_err(|e| spoken(&e))?.position + noise.next();
        row.extend([time_s, converted(&args.sample, full_scale, x)]);
        Ok(true)
    })
}

fn turning_points(mut motion: Motion, until_s: f64) -> impl Iterator<Item = [f64; 2]> {
    let turned = |e: &Event| matches!(e.kind, EventKind::Turn | EventKind::Stop | EventKind::Rest);
    std::iter::from_fn(move || motion.next_event(until_s)).filter(turned).map(|e| [e.time_s, e.position])
}

fn largest(motion: Motion, until_s: f64, start: f64) -> f64 {
    let mut last = motion.clone();
    let end = last.state_at(until_s).map_or(0.0, |s| s.position.abs());
    turning_points(motion, until_s).fold(start.abs().max(end), |m, [_, x]| m.max(x.abs()))
}

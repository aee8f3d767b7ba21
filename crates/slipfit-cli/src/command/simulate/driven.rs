//! `slipfit simulate driven`.

use super::drive::{self, Kind};
use super::oscillator::{friction, in_flags, oscillator};
use super::sampling::{Noise, rows};
use super::sheet::{Column, Digits, Parameters, Sheet, Step, converted};
use super::turning::{turning_point_columns, turning_points};
use super::write;
use crate::args::{Beginning, DrivenArgs};
use crate::failure::{Failure, warning_line};
use crate::output;
use anstream::ColorChoice;
use slipfit::motion::simulate::Motion;
use slipfit::motion::steady::solve_with_friction;

pub(super) fn run(args: &DrivenArgs, to: &write::Destinations, color: ColorChoice) -> Result<(), Failure> {
    let unit = &args.sample.unit;
    let o = oscillator(&args.oscillator, unit, |o| drive::reference(&args.drive, o, unit))?;
    let friction = friction(&args.oscillator.minus, &o, unit)?;
    let wave = drive::wave(args, &o)?;
    if let Some(off_at) = args.off_at.filter(|off_at| *off_at >= args.sampling.duration) {
        let duration = args.sampling.duration;
        return Err(Failure::new(format!("--off-at {off_at}: the record ends before it, at {duration} s")));
    }
    if !args.turning_points {
        wave.drive.check_sampling(args.sampling.rate_hz).map_err(in_flags)?;
    }
    let rows = rows(args.sampling.duration, args.sampling.rate_hz)?;
    let (position, velocity) = match (args.from, &wave.kind) {
        (Beginning::Rest, _) => (0.0, 0.0),
        (Beginning::Steady, Kind::Harmonic { drive }) => {
            solve_with_friction(&o, friction, drive).map_err(in_flags)?.state.state(0.0)
        }
        (Beginning::Steady, _) => {
            return Err(Failure::new("--from steady is for one harmonic without a phase")
                .hint("--from rest and a longer --duration let any other drive settle"));
        }
    };
    for warning in &wave.warnings {
        output::print_error(&warning_line(warning), color);
    }
    let mut all = Parameters::of(&o, unit);
    all.uneven(friction, &o, unit);
    wave.describe(args, &o, &mut all);
    let mut drive = wave.drive;
    if let Some(off_at) = args.off_at {
        drive = drive.until(off_at).map_err(in_flags)?;
        all.number("drive_off_at_s", off_at, "");
    }
    let motion = Motion::with_friction(&o, friction, drive, 0.0, position, velocity).map_err(in_flags)?;
    // The full scale of a converter is set to the largest value of the motion.
    let full_scale = if args.sample.quantize_bits.is_some() {
        largest(motion.clone(), args.sampling.duration, position)
    } else {
        0.0
    };

    all.number("initial_position", position, unit);
    all.number("initial_velocity", velocity, &format!("{unit}/s"));
    all.number("duration_s", args.sampling.duration, "");
    all.number("rate_hz", args.sampling.rate_hz, "");
    all.sensor(&args.sample, full_scale);
    let title = match wave.kind {
        Kind::Harmonic { .. } => {
            "exact motion under a harmonic drive, x_0 cos(2 pi f t), with sliding friction"
        }
        Kind::Tones(_) => "exact motion under several harmonics with sliding friction",
        Kind::File { .. } => "exact motion under a sampled drive with sliding friction",
    };
    let mut sheet = Sheet {
        command: "driven",
        title,
        parameters: all.0,
        columns: vec![
            Column::new("time", "s", Digits::Shortest),
            Column::of_samples("displacement", unit, args.sampling.digits),
        ],
        rows,
        fill: trace(args, motion.clone(), full_scale),
        even_rate_hz: Some(args.sampling.rate_hz),
    };
    if args.turning_points {
        // Computed one at a time, so that memory use does not grow with their number.
        let mut points = turning_points(motion, args.sampling.duration);
        sheet.rows = u64::MAX;
        sheet.columns = turning_point_columns(unit);
        sheet.even_rate_hz = None;
        sheet.fill = Box::new(move |_, row| {
            let Some(point) = points.next() else { return Ok(Step::End) };
            row.extend(point);
            Ok(Step::Row)
        });
    }
    write::write(sheet, to)
}

fn trace(args: &DrivenArgs, mut motion: Motion, full_scale: f64) -> super::sheet::Fill<'_> {
    let mut noise = Noise::new(args.sample.seed, args.sample.noise_rms);
    Box::new(move |i, row| {
        let time_s = i as f64 / args.sampling.rate_hz;
        let x = motion.state_at(time_s).map_err(in_flags)?.position + noise.next();
        row.extend([time_s, converted(&args.sample, full_scale, x)]);
        Ok(Step::Row)
    })
}

fn largest(motion: Motion, until_s: f64, start: f64) -> f64 {
    let mut last = motion.clone();
    let end = last.state_at(until_s).map_or(0.0, |s| s.position.abs());
    turning_points(motion, until_s).fold(start.abs().max(end), |m, [_, x]| m.max(x.abs()))
}

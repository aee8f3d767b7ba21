//! `slipfit simulate`: records made by the exact motion.

use crate::args::{DecayArgs, OutputKind, SimulateArgs, SimulateCommand};
use crate::failure::Failure;
use crate::output;
use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};
use slipfit::Oscillator;
use slipfit::decay::FreeDecay;
use std::f64::consts::{PI, TAU};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// More rows than any table is read with.
const MOST_ROWS: f64 = 1e9;
/// Points of a cycle the lock-in sums over: exact for all harmonics below this.
const LOCK_IN_POINTS: u32 = 64;

pub(crate) fn run(args: &SimulateArgs) -> Result<ExitCode, Failure> {
    match &args.command {
        SimulateCommand::Decay(args) => decay(args),
    }
}

fn decay(args: &DecayArgs) -> Result<ExitCode, Failure> {
    let rows = (args.duration * args.rate_hz).floor() + 1.0;
    if rows > MOST_ROWS {
        return Err(Failure::new(format!("{rows:.0} rows asked for, at most {MOST_ROWS:.0} are written"))
            .hint("--duration or --rate-hz makes the record shorter"));
    }
    let oscillator = oscillator(args).map_err(|e| spoken(&e))?;
    let motion = FreeDecay::from_rest(&oscillator, args.amplitude).map_err(|e| spoken(&e))?;
    let target = args.out.as_deref().unwrap_or(Path::new("-"));
    output::to_path(target, |out| {
        write_header(out, args, &motion)?;
        write_rows(out, args, &motion, rows as u64)
    })?;
    Ok(ExitCode::SUCCESS)
}

fn oscillator(args: &DecayArgs) -> Result<Oscillator, slipfit::Error> {
    let mut builder = Oscillator::builder();
    if let Some(v) = args.frequency_hz {
        builder = builder.frequency_hz(v);
    }
    if let Some(v) = args.stiffness {
        builder = builder.stiffness(v);
    }
    if let Some(v) = args.mass {
        builder = builder.mass(v);
    }
    if let Some(v) = args.q {
        builder = builder.q_factor(v);
    }
    if let Some(v) = args.viscous {
        builder = builder.viscous_coefficient(v);
    }
    if let Some(v) = args.friction_displacement {
        builder = builder.friction_displacement(v);
    }
    if let Some(v) = args.coulomb_force {
        builder = builder.coulomb_force(v);
    }
    if let Some(v) = args.static_force {
        builder = builder.static_force(v);
    }
    builder.build()
}

/// The core names parameters as its functions do; here they are flags.
fn spoken(error: &slipfit::Error) -> Failure {
    let mut text = error.to_string();
    for (name, flag) in [
        ("frequency_hz", "--frequency-hz"),
        ("omega_0", "--frequency-hz"),
        ("viscous_coefficient", "--viscous"),
        ("q_factor", "--q"),
        ("friction_displacement", "--friction-displacement"),
        ("coulomb_force", "--coulomb-force"),
        ("static_force", "--static-force"),
    ] {
        text = text.replace(name, flag);
    }
    let failure = Failure::new(text);
    match error {
        slipfit::Error::MissingParameter { .. } => failure
            .hint("--frequency-hz, or two of --mass, --stiffness and --frequency-hz, fix the oscillator"),
        _ => failure,
    }
}

fn write_header(out: &mut dyn Write, args: &DecayArgs, motion: &FreeDecay) -> io::Result<()> {
    let o = motion.oscillator();
    let unit = &args.unit;
    writeln!(
        out,
        "# slipfit simulate decay: exact free decay with viscous and sliding friction, released at rest"
    )?;
    let mut line = |name: &str, value: Option<f64>, unit: &str| match value {
        Some(v) => writeln!(out, "# {name} = {}", format!("{} {unit}", number(v)).trim_end()),
        None => Ok(()),
    };
    line("frequency_hz", Some(o.frequency_hz()), "")?;
    line("decay_rate_per_s", Some(o.decay_rate_per_s()), "")?;
    line("q_factor", Some(o.q_factor()), "")?;
    line("friction_displacement", Some(o.friction_displacement()), unit)?;
    line("static_displacement", Some(o.static_displacement()), unit)?;
    line("mass", o.mass(), "kg")?;
    line("stiffness", o.stiffness(), "N/m")?;
    line("viscous_coefficient", o.viscous_coefficient(), "kg/s")?;
    line("coulomb_force", o.coulomb_force(), "N")?;
    line("static_force", o.static_force(), "N")?;
    line("amplitude", Some(args.amplitude), unit)?;
    line("stop_time_s", motion.stop().map(|s| s.time_s), "")?;
    line("stop_position", motion.stop().map(|s| s.position), unit)?;
    line("duration_s", Some(args.duration), "")?;
    line("rate_hz", Some(args.rate_hz), "")?;
    line("noise_rms", Some(args.noise_rms), unit)?;
    writeln!(out, "# seed = {} (ChaCha12, normal)", args.seed)?;
    if let Some(bits) = args.quantize_bits {
        writeln!(out, "# quantize_bits = {bits} (step {} {unit})", number(quantum(args, bits)))?;
    }
    match args.output {
        OutputKind::Waveform => writeln!(out, "time (s),displacement ({unit})"),
        OutputKind::Envelope => {
            writeln!(
                out,
                "# output = amplitude of the fundamental over one cycle about each instant; noise on X and Y"
            )?;
            writeln!(out, "time (s),amplitude ({unit})")
        }
    }
}

/// Shortest form that reads back to twelve digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

fn quantum(args: &DecayArgs, bits: u32) -> f64 {
    2.0 * (args.amplitude.abs() + 5.0 * args.noise_rms) / 2f64.powi(bits as i32)
}

fn write_rows(out: &mut dyn Write, args: &DecayArgs, motion: &FreeDecay, rows: u64) -> io::Result<()> {
    let mut rng = ChaCha12Rng::seed_from_u64(args.seed);
    let mut noise = || {
        let unit: f64 = StandardNormal.sample(&mut rng);
        args.noise_rms * unit
    };
    let half_period_s = motion.oscillator().half_period_s();
    for row in 0..rows {
        let time_s = row as f64 / args.rate_hz;
        let value = match args.output {
            OutputKind::Waveform => motion.displacement(time_s) + noise(),
            // The first cycle has no middle before half a period.
            OutputKind::Envelope if time_s < half_period_s => continue,
            OutputKind::Envelope => {
                let [x, y] = lock_in(motion, time_s);
                (x + noise()).hypot(y + noise())
            }
        };
        let value = match args.quantize_bits {
            Some(bits) => (value / quantum(args, bits)).round() * quantum(args, bits),
            None => value,
        };
        writeln!(out, "{time_s},{value:.6e}")?;
    }
    Ok(())
}

/// Fundamental of the cycle about `time_s`, `(2/T) ∫ x e^(-i omega t) dt`, phase counted from its middle.
fn lock_in(motion: &FreeDecay, time_s: f64) -> [f64; 2] {
    let half = motion.oscillator().half_period_s();
    let n = f64::from(LOCK_IN_POINTS);
    let (mut x, mut y) = (0.0, 0.0);
    for i in 0..LOCK_IN_POINTS {
        // Midpoints: for a periodic function as good as any rule gets.
        let cycle = (f64::from(i) + 0.5) / n - 0.5;
        let t = time_s + 2.0 * half * cycle;
        let (sin, cos) = (TAU * cycle).sin_cos();
        let value = motion.displacement(t);
        x += value * cos;
        y -= value * sin;
    }
    // Turned so that the decay stands on X, as a lock-in's auto-phase does.
    let (sin, cos) = (PI * time_s / half).sin_cos();
    [2.0 / n * (x * cos + y * sin), 2.0 / n * (y * cos - x * sin)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_in_shows_the_amplitude_on_x() {
        let o = Oscillator::kinematic(20.0, 0.0, 0.0).unwrap();
        let motion = FreeDecay::from_rest(&o, 2.0).unwrap();
        for t in [0.2, 0.77, 13.0] {
            let [x, y] = lock_in(&motion, t);
            assert!((x - 2.0).abs() < 1e-12 && y.abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn the_lock_in_is_blind_to_the_offset_left_at_the_stop() {
        let o = Oscillator::kinematic(20.0, 0.1, 0.1).unwrap();
        let motion = FreeDecay::from_rest(&o, 2.0).unwrap();
        let after = motion.stop().unwrap().time_s + 1.0;
        assert!(motion.displacement(after) != 0.0);
        let [x, y] = lock_in(&motion, after);
        assert!(x.hypot(y) < 1e-14);
    }

    #[test]
    fn header_numbers_read_well_and_back() {
        assert_eq!(number(32700.000000000004), "32700");
        assert_eq!(number(1.5e-12), "1.5e-12");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(f64::INFINITY), "inf");
    }
}

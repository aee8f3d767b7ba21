//! `slipfit simulate decay`.

use super::oscillator::{friction, in_flags, oscillator};
use super::sampling::{MOST_ROWS, Noise, rows};
use super::sheet::{Column, Digits, Parameters, Sheet, Step, converted};
use super::turning::{turning_point_columns, turning_points};
use super::write;
use crate::args::{DecayArgs, OutputKind};
use crate::failure::Failure;
use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, EventKind, Friction, Motion};
use std::f64::consts::{PI, TAU};

/// Points per cycle over which the lock-in sums; the sum is exact for all harmonics below this number.
const LOCK_IN_POINTS: u32 = 64;

pub(super) fn run(args: &DecayArgs, to: &write::Destinations) -> Result<(), Failure> {
    let rows = rows(args.sampling.duration, args.sampling.rate_hz)?;
    let unit = &args.sample.unit;
    let oscillator = oscillator(&args.oscillator, unit, |_| match args.amplitude.abs() {
        0.0 => Err(Failure::new("--beta is a ratio to --amplitude, which is zero")
            .hint("--friction-displacement or --coulomb-force gives friction by itself")),
        amplitude => Ok(amplitude),
    })?;
    let friction = friction(&args.oscillator.minus, &oscillator, unit)?;
    let motion = DecayMotion::new(&oscillator, friction, args.amplitude).map_err(in_flags)?;
    let mut sheet = Sheet {
        command: "decay",
        title: "exact free decay with viscous and sliding friction, released at rest",
        parameters: header(args, &oscillator, friction, &motion),
        columns: columns(args),
        rows,
        fill: fill(args, oscillator.half_period_s(), motion.clone()),
        even_rate_hz: (args.output == OutputKind::Waveform).then_some(args.sampling.rate_hz),
    };
    if args.turning_points {
        // The iterator ends after the last one, or the record ends.
        let most = args.sampling.duration / oscillator.half_period_s() + 2.0;
        if most > MOST_ROWS {
            return Err(Failure::new(format!("{most:.0} turning points asked for"))
                .hint("--duration makes the record shorter"));
        }
        let until_s = args.sampling.duration;
        let mut points: Box<dyn Iterator<Item = [f64; 2]>> = match motion {
            DecayMotion::Even(d) => Box::new(d.turning_points().map(|p| [p.time_s, p.position])),
            DecayMotion::Uneven(m) => {
                let start = [0.0, args.amplitude];
                Box::new(std::iter::once(start).chain(turning_points(*m, until_s)))
            }
        };
        sheet.rows = most as u64;
        sheet.even_rate_hz = None;
        sheet.columns = turning_point_columns(&args.sample.unit);
        sheet.fill = Box::new(move |_, row| {
            let Some(p) = points.next().filter(|p| p[0] <= until_s) else { return Ok(Step::End) };
            row.extend(p);
            Ok(Step::Row)
        });
    }
    write::write(sheet, to)
}

/// The closed form, or the event-driven solution if friction differs by direction.
#[derive(Clone)]
enum DecayMotion {
    Even(FreeDecay),
    Uneven(Box<Motion>),
}

impl DecayMotion {
    fn new(o: &Oscillator, friction: Friction, amplitude: f64) -> Result<Self, slipfit::Error> {
        if friction == Friction::of(o) {
            return FreeDecay::from_rest(o, amplitude).map(Self::Even);
        }
        let motion = Motion::with_friction(o, friction, Drive::none(), 0.0, amplitude, 0.0)?;
        Ok(Self::Uneven(Box::new(motion)))
    }

    /// Time and position of the stop, if there is one within `until_s`.
    fn stop(&self, until_s: f64) -> Option<[f64; 2]> {
        match self {
            Self::Even(d) => d.stop().map(|s| [s.time_s, s.position]),
            Self::Uneven(m) => {
                let mut m = m.clone();
                let rest = m.events(until_s).find(|e| e.kind == EventKind::Rest);
                rest.map(|e| [e.time_s, e.position])
            }
        }
    }

    /// Displacement; times must not decrease.
    fn displacement(&mut self, time_s: f64) -> Result<f64, slipfit::Error> {
        match self {
            Self::Even(d) => Ok(d.displacement(time_s)),
            Self::Uneven(m) => m.state_at(time_s).map(|s| s.position),
        }
    }
}

fn header(
    args: &DecayArgs,
    o: &Oscillator,
    friction: Friction,
    motion: &DecayMotion,
) -> Vec<super::sheet::Parameter> {
    let unit = &args.sample.unit;
    let mut all = Parameters::of(o, unit);
    all.uneven(friction, o, unit);
    all.number("amplitude", args.amplitude, unit);
    if let Some([time_s, position]) = motion.stop(args.sampling.duration) {
        all.number("stop_time_s", time_s, "");
        all.number("stop_position", position, unit);
    }
    all.number("duration_s", args.sampling.duration, "");
    all.number("rate_hz", args.sampling.rate_hz, "");
    all.sensor(&args.sample, args.amplitude);
    if args.output == OutputKind::Envelope {
        all.text(
            "output",
            "amplitude of the fundamental over one cycle about each instant; noise on X and Y",
        );
    }
    all.0
}

fn columns(args: &DecayArgs) -> Vec<Column> {
    let name = match args.output {
        OutputKind::Waveform => "displacement",
        OutputKind::Envelope => "amplitude",
    };
    vec![
        Column::new("time", "s", Digits::Shortest),
        Column::of_samples(name, &args.sample.unit, args.sampling.digits),
    ]
}

fn fill(args: &DecayArgs, half_period_s: f64, mut motion: DecayMotion) -> super::sheet::Fill<'_> {
    let mut noise = Noise::new(args.sample.seed, args.sample.noise_rms);
    Box::new(move |i, row| {
        let time_s = i as f64 / args.sampling.rate_hz;
        let value = match args.output {
            OutputKind::Waveform => motion.displacement(time_s).map_err(in_flags)? + noise.next(),
            // The first cycle has no centre before half a period.
            OutputKind::Envelope if time_s < half_period_s => return Ok(Step::LeftOut),
            OutputKind::Envelope => {
                // Cycles overlap: the motion stays at the start of this one for the next.
                motion.displacement(time_s - half_period_s).map_err(in_flags)?;
                let mut cycle = motion.clone();
                let [x, y] =
                    fundamental(half_period_s, time_s, |t| cycle.displacement(t)).map_err(in_flags)?;
                (x + noise.next()).hypot(y + noise.next())
            }
        };
        row.extend([time_s, converted(&args.sample, args.amplitude, value)]);
        Ok(Step::Row)
    })
}

/// Fundamental of the cycle around `time_s`, `(2/T) ∫ x e^(-i omega t) dt`, with the phase counted from its
/// centre.
pub(crate) fn lock_in(motion: &FreeDecay, time_s: f64) -> [f64; 2] {
    let exact = |t| Ok(motion.displacement(t));
    // The closed form is defined at every time.
    fundamental(motion.oscillator().half_period_s(), time_s, exact).unwrap_or_default()
}

fn fundamental(
    half: f64,
    time_s: f64,
    mut displacement: impl FnMut(f64) -> Result<f64, slipfit::Error>,
) -> Result<[f64; 2], slipfit::Error> {
    let n = f64::from(LOCK_IN_POINTS);
    let (mut x, mut y) = (0.0, 0.0);
    for i in 0..LOCK_IN_POINTS {
        // The midpoint rule: for a periodic function no rule is better.
        let cycle = (f64::from(i) + 0.5) / n - 0.5;
        let t = time_s + 2.0 * half * cycle;
        let (sin, cos) = (TAU * cycle).sin_cos();
        let value = displacement(t)?;
        x += value * cos;
        y -= value * sin;
    }
    // Rotated so that the decay is on X, as by a lock-in's auto-phase.
    let (sin, cos) = (PI * time_s / half).sin_cos();
    Ok([2.0 / n * (x * cos + y * sin), 2.0 / n * (y * cos - x * sin)])
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
            assert!((x - 2.0).abs() < 1e-12, "{x} {y}");
            assert!(y.abs() < 1e-12, "{x} {y}");
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
}

//! Resonance curves analysed with default options, apart from what a user knows about the drive.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::fmt::Write;
use std::ops::Range;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use slipfit::Parameter;
use slipfit::answer::Warning;
use slipfit::model::loss::LossTerm;
use slipfit::motion::steady::Phasor;
use slipfit::resonance::{Answer, Curve, DriveAmplitude, Options, analyse};

use super::choices::Choices;
use super::disturbance::{Chain, DISTURBANCES, Disturbance, Motion, PROPORTIONAL};
use super::measured_cells::{MeasuredCells, Scored};
use super::scores::{self, Estimated, Outcome, Scores, TrueValue};
use super::trials::{coverage_error, seed};
use crate::Failure;

const Q: [f64; 3] = [10.0, 100.0, 1_000.0];
/// Q of all curves with a disturbance.
const DISTURBED_Q: f64 = 100.0;
const BETA: [f64; 4] = [0.0, 0.1, 0.5, 0.9];
const POINTS: [usize; 3] = [13, 41, 201];
const OMEGA_0: f64 = TAU;
const X_0: f64 = 1.0;
/// Noise of one quadrature over the highest amplitude: 40 dB.
const NOISE: f64 = 0.01;
/// Extent of the window on either side, in full widths of the line.
const WINDOW: f64 = 3.0;

/// What is known about the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drive {
    Known,
    Reference,
    Shape,
}

const DRIVES: [Drive; 3] = [Drive::Known, Drive::Reference, Drive::Shape];

impl Drive {
    fn name(self) -> &'static str {
        match self {
            Drive::Known => "known",
            Drive::Reference => "reference",
            Drive::Shape => "shape",
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    disturbance: Disturbance,
    complex: bool,
    drive: Drive,
    points: usize,
    q: f64,
    beta: f64,
}

/// A cell with its curve and the reference curve, before instrument and noise are added.
struct Sweep {
    cell: Cell,
    number: u64,
    omega: Vec<f64>,
    clean: Vec<Phasor>,
    reference: Vec<Phasor>,
}

/// A cell with the scores of its curves.
struct Row {
    cell: Cell,
    seeds: u64,
    scores: Scores,
    /// Share of the answers with a background, a delay or a constant added to every amplitude.
    instrument: f64,
}

/// One analysed curve.
struct Analysed {
    outcome: Outcome,
    instrument: bool,
    took: Duration,
}

pub(super) fn run(choices: Choices) -> Result<ExitCode, Failure> {
    let mut measured = MeasuredCells::new();
    for (number, cell) in cells().into_iter().enumerate().filter(|(_, c)| c.name().contains(&choices.only)) {
        let Some(sweep) = cell.sweep(number as u64) else {
            eprintln!("{}: no exact curve", cell.name());
            continue;
        };
        measured.measure(choices.seeds, |curves: Range<u64>| {
            let seeds = curves.end - curves.start;
            let analysed: Vec<Analysed> = curves.into_par_iter().map(|s| sweep.analysed(s)).collect();
            let outcomes: Vec<Outcome> = analysed.iter().map(|a| a.outcome.clone()).collect();
            let n = analysed.len() as f64;
            let instrument = analysed.iter().filter(|a| a.instrument).count() as f64 / n;
            let row = Row { cell, seeds, scores: Scores::of(&outcomes, &cell.truth()), instrument };
            let mean = analysed.iter().map(|a| a.took).sum::<Duration>() / n as u32;
            eprintln!("{:60} | {} | {:.1} ms", cell.name(), row.line(), 1e3 * mean.as_secs_f64());
            row
        });
    }
    choices.publish("statistics_default_curves.md", &page(&measured, choices.seeds))?;
    Ok(ExitCode::SUCCESS)
}

fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for disturbance in DISTURBANCES {
        let every_q: &[f64] = if disturbance == Disturbance::Nothing { &Q } else { &[DISTURBED_Q] };
        for complex in [true, false] {
            if !complex && !disturbance.is_seen_in_amplitudes() {
                continue;
            }
            for drive in DRIVES {
                for points in POINTS {
                    for &q in every_q {
                        cells.extend(BETA.map(|beta| Cell { disturbance, complex, drive, points, q, beta }));
                    }
                }
            }
        }
    }
    cells
}

impl Cell {
    fn name(&self) -> String {
        let Self { disturbance, drive, points, q, beta, .. } = self;
        format!("{}; {}; {}; n={points}; Q={q}; beta={beta};", disturbance.name(), self.kind(), drive.name())
    }

    fn kind(&self) -> &'static str {
        if self.complex { "complex" } else { "amplitude" }
    }

    fn truth(&self) -> [TrueValue; 3] {
        [
            (Parameter::DECAY_RATE, OMEGA_0 / (2.0 * self.q)),
            (Parameter::FRICTION_DISPLACEMENT, FRAC_PI_4 * self.beta * X_0),
            (Parameter::NaturalFrequency, OMEGA_0 / TAU),
        ]
        .map(|(parameter, value)| TrueValue { parameter, value })
    }

    fn sweep(self, number: u64) -> Option<Sweep> {
        let [delta, x_f, _] = self.truth().map(|t| t.value);
        let half = 2.0 * WINDOW * delta / (1.0 - 0.5 * self.beta);
        let (low, high) = ((OMEGA_0 - half).max(0.5 * OMEGA_0), OMEGA_0 + half);
        let omega: Vec<f64> =
            (0..self.points).map(|i| low + (high - low) * i as f64 / (self.points - 1) as f64).collect();
        let own = [OMEGA_0, delta, X_0];
        let undisturbed = Motion::new(Disturbance::Nothing, own, 1.0);
        let amplitude = |w: &f64| undisturbed.at(*w, x_f).map(|z| z.norm());
        let highest = omega.iter().filter_map(amplitude).fold(0.0, f64::max);
        let motion = Motion::new(self.disturbance, own, highest);
        let clean = omega.iter().map(|w| motion.at(*w, x_f)).collect::<Option<_>>()?;
        let reference = omega.iter().map(|w| motion.at(*w, 0.0)).collect::<Option<_>>()?;
        Some(Sweep { cell: self, number, omega, clean, reference })
    }
}

impl Sweep {
    /// The points as the instrument reads them.
    fn measured(&self, clean: &[Phasor], chain: &Chain, rng: &mut ChaCha8Rng) -> Option<Curve> {
        let highest = clean.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let (first, last) = (self.omega[0], self.omega[self.omega.len() - 1]);
        let seen: Vec<Phasor> = clean
            .iter()
            .zip(&self.omega)
            .map(|(z, omega)| {
                let place = (2.0 * omega - first - last) / (last - first);
                let turned = z * Phasor::from_polar(1.0, chain.offset - place * chain.turn);
                let z = turned + chain.background * highest;
                let sigma = match self.cell.disturbance {
                    Disturbance::ProportionalNoise(part, floor) => (part * z.norm()).hypot(floor * highest),
                    _ => NOISE * highest,
                };
                let (a, b): (f64, f64) = (rng.sample(StandardNormal), rng.sample(StandardNormal));
                z + Phasor::new(a, b) * sigma
            })
            .collect();
        let hz = self.omega.iter().map(|w| w / TAU).collect();
        if self.cell.complex {
            Curve::complex(hz, seen).build().ok()
        } else {
            Curve::builder(hz, seen.iter().map(|z| z.norm()).collect()).build().ok()
        }
    }

    fn analysed(&self, seed_number: u64) -> Analysed {
        let own = seed(0xDEFA_C04E, &[self.number as f64]);
        let mut rng = ChaCha8Rng::seed_from_u64(seed_number.wrapping_mul(0x9E37_79B9) ^ own);
        let chain = Chain::new(self.cell.disturbance, &mut rng);
        let curve = self.measured(&self.clean, &chain, &mut rng);
        let mut options = Options::default();
        match self.cell.drive {
            Drive::Known => options.drive_amplitude = Some(DriveAmplitude { value: X_0, std_error: 0.0 }),
            // The friction-free curve is higher, and its background in proportion.
            Drive::Reference => options.reference = self.measured(&self.reference, &chain, &mut rng),
            Drive::Shape => {}
        }
        let begun = Instant::now();
        let answer = curve.and_then(|curve| analyse(&curve, &options).ok());
        let took = begun.elapsed();
        let instrument = answer.as_ref().map(|a| &a.instrument).is_some_and(|i| {
            i.background.is_some()
                || i.delay_s.is_some()
                || i.amplitude_offset.is_some()
                || i.noise_floor.is_some()
        });
        Analysed { outcome: answer.map_or_else(Outcome::default, |a| self.outcome(&a)), instrument, took }
    }

    fn outcome(&self, answer: &Answer) -> Outcome {
        let truth = self.cell.truth();
        let estimate = |t: &TrueValue| answer.parameter(t.parameter).map(|q| Estimated::of(q, t.value));
        // A warning that only names a fitted instrument term does not question the answer.
        let questions_answer = |w: &Warning| {
            !matches!(
                w,
                Warning::Background { .. }
                    | Warning::Delay { .. }
                    | Warning::AmplitudeOffset { .. }
                    | Warning::NoiseFloor { .. }
                    | Warning::PhaseSign
            )
        };
        Outcome {
            estimates: truth.iter().map(estimate).collect(),
            warned: answer.warnings.iter().any(questions_answer),
            sliding_detected: answer.sliding.detected,
            drag_chosen: answer.model.has(LossTerm::Drag),
            above_truth: None,
        }
    }
}

impl Row {
    fn line(&self) -> String {
        format!("{} | {:.0} %", self.scores.columns(), 100.0 * self.instrument)
    }
}

impl Scored for Row {
    /// Whether the coverage falls below 95 % by more than three of its standard errors, or friction is claimed too
    /// often where there is none.
    fn misses(&self) -> bool {
        let least = 0.95 - 3.0 * coverage_error(self.seeds as usize);
        let claimed = self.cell.beta == 0.0 && self.scores.sliding_detected > 0.05;
        claimed || self.scores.unwarned_outliers > 0.03 || self.scores.coverage.iter().any(|c| *c < least)
    }
}

const COLUMNS: &str = "δ | x_F | f₀ | outliers unwarned | friction claimed falsely | friction missed | drag chosen | refused | warned | instrument named";

/// Means over cells.
fn pooled(rows: &[&Row]) -> String {
    let cells: Vec<_> = rows.iter().map(|row| (&row.scores, row.cell.beta > 0.0)).collect();
    let mut text = scores::pooled(&cells);
    text.push(scores::mean_percent(rows.iter().map(|row| row.instrument)));
    text.join(" | ")
}

fn page(measured: &MeasuredCells<Row>, seeds: u64) -> String {
    let rows = &measured.rows;
    let mut text = format!(
        "# The default answer to a curve\n\nMade by `cargo xtask statistics --default-curves --write`, {seeds} curves \
         a cell. Exact curves (stops included) of {} cells, {WINDOW} widths of the line either side, white noise of \
         {} % of the highest amplitude in both quadratures; amplitudes are the modulus of the noisy response. The \
         whole analysis runs on each as every user gets it, no model named: the drive is *known*, follows from a \
         friction-free *reference* of the same length and instrument, or from the *shape* alone. A *disturbance* \
         adds a constant background at a random angle (of the reference too the same part of its height), a turn of the phase across the window, both, a crosstalk in \
         phase with the drive, or has a noise of {} % of each amplitude above a floor of {} % of the highest; \
         a *drag* is, at the highest amplitude, a part of the viscous loss; *Duffing* is a natural frequency moved by a \
         part of the half width of the line at the amplitude Q x₀; curves with such a term have Q {DISTURBED_Q}, the others Q 10, 100 and 1000. δ, x_F and f₀: share of the \
         95 % intervals that hold the truth; *outliers unwarned*: answers with one of the three more than four of its \
         standard errors off and no warning (naming a fitted term of the instrument is not counted as one). Friction is \
         *missed* where it is there and not significant, as it must be where the curve cannot tell.\n\n## Means over \
         β 0, 0.1, 0.5, 0.9 and Q\n\n| disturbance | data | drive | points | {COLUMNS} |\n{}|\n",
        rows.len(),
        100.0 * NOISE,
        100.0 * PROPORTIONAL[0],
        100.0 * PROPORTIONAL[1],
        "|---".repeat(14)
    );
    for disturbance in DISTURBANCES {
        for complex in [true, false] {
            for drive in DRIVES {
                for points in POINTS {
                    let of: Vec<&Row> = rows
                        .iter()
                        .filter(|r| {
                            let c = &r.cell;
                            c.disturbance == disturbance
                                && c.complex == complex
                                && c.drive == drive
                                && c.points == points
                        })
                        .collect();
                    let Some(first) = of.first() else { continue };
                    let (name, kind) = (disturbance.name(), first.cell.kind());
                    let _ =
                        writeln!(text, "| {name} | {kind} | {} | {points} | {} |", drive.name(), pooled(&of));
                }
            }
        }
    }
    let table = |rows: &[&Row]| {
        let mut table = format!(
            "| disturbance | data | drive | points | Q | β | curves | {COLUMNS} |\n{}|\n",
            "|---".repeat(17)
        );
        for row in rows {
            let Cell { disturbance, drive, points, q, beta, .. } = row.cell;
            let (name, kind, drive) = (disturbance.name(), row.cell.kind(), drive.name());
            let (curves, scores) = (row.seeds, pooled(&[*row]));
            let _ = writeln!(
                table,
                "| {name} | {kind} | {drive} | {points} | {q} | {beta} | {curves} | {scores} |"
            );
        }
        table
    };
    text += &measured.misses(
        "have a coverage more than three of its own standard errors below 95 %, unwarned outliers in more than 3 % of their \
         curves, or claim a friction that is not there in more than 5 %. A few do by chance: these cells",
        "curves",
        table,
    );
    text
}

//! Drive levels analysed with default options.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fmt::Write;
use std::ops::Range;
use std::process::ExitCode;

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use slipfit::Parameter;
use slipfit::answer::Warning;
use slipfit::levels::{Answer, Levels, Options, analyse};
use slipfit::motion::steady::Phasor;

use super::choices::Choices;
use super::disturbance::{Disturbance, Motion};
use super::measured_cells::{MeasuredCells, Scored};
use super::scores::{self, Estimated, Outcome, Scores, TrueValue};
use super::trials::{coverage_error, seed};
use crate::Failure;

const Q: f64 = 300.0;
const OMEGA_0: f64 = TAU;
/// Highest drive level.
const TOP: f64 = 1.0;
const LEVELS: [usize; 3] = [6, 12, 30];
/// Threshold over the highest level; no threshold coincides with a level.
const THRESHOLD: [f64; 4] = [0.0, 0.055, 0.31, 0.61];
/// Noise of one quadrature over the highest amplitude: 40 and 60 dB.
const NOISE: [f64; 2] = [0.01, 0.001];

/// Departure of the levels from viscous and sliding loss at resonance with white noise.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Departure {
    Nothing,
    /// A drag that is this part of the viscous loss at the highest amplitude.
    Drag(f64),
    /// A detector that reads the highest amplitude too low by this part; the deficit grows with the square of the
    /// amplitude.
    Compression(f64),
    /// A detector offset, added to every reading, as a part of the highest amplitude.
    Zero(f64),
    /// Part of the drive that the detector picks up at a random phase, over the highest amplitude.
    Crosstalk(f64),
    /// A drive frequency off the resonance by this part of the half width of the line.
    OffResonance(f64),
    /// Noise proportional to each amplitude by this factor, in addition to the white noise.
    ProportionalNoise(f64),
}

const DEPARTURES: [Departure; 10] = [
    Departure::Nothing,
    Departure::Drag(0.03),
    Departure::Drag(0.1),
    Departure::Drag(0.5),
    Departure::Compression(0.03),
    Departure::Zero(0.03),
    Departure::Crosstalk(0.003),
    Departure::Crosstalk(0.02),
    Departure::OffResonance(0.1),
    Departure::ProportionalNoise(0.01),
];

impl Departure {
    fn name(self) -> String {
        let percent = |part: f64| format!("{} %", 100.0 * part);
        match self {
            Self::Nothing => "none".to_owned(),
            Self::Drag(part) => format!("drag {}", percent(part)),
            Self::Compression(part) => format!("compression {}", percent(part)),
            Self::Zero(part) => format!("zero of the detector {}", percent(part)),
            Self::Crosstalk(part) => format!("crosstalk {}", percent(part)),
            Self::OffResonance(part) => format!("off resonance {}", percent(part)),
            Self::ProportionalNoise(part) => format!("noise {} of each", percent(part)),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    departure: Departure,
    levels: usize,
    threshold: f64,
    noise: f64,
}

/// A cell with its levels before instrument and noise are added.
struct Series {
    cell: Cell,
    number: u64,
    drive: Vec<f64>,
    clean: Vec<Phasor>,
}

struct Row {
    cell: Cell,
    seeds: u64,
    scores: Scores,
}

pub(super) fn run(choices: Choices) -> Result<ExitCode, Failure> {
    let mut measured = MeasuredCells::new();
    for (number, cell) in cells().into_iter().enumerate().filter(|(_, c)| c.name().contains(&choices.only)) {
        let series = cell.series(number as u64);
        measured.measure(choices.seeds, |records: Range<u64>| {
            let seeds = records.end - records.start;
            let outcomes: Vec<Outcome> = records.into_par_iter().map(|s| series.analysed(s)).collect();
            let row = Row { cell, seeds, scores: Scores::of(&outcomes, &cell.truth()) };
            eprintln!("{:60} | {}", cell.name(), row.scores.columns());
            row
        });
    }
    choices.publish("statistics_default_levels.md", &page(&measured, choices.seeds))?;
    Ok(ExitCode::SUCCESS)
}

fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for departure in DEPARTURES {
        for levels in LEVELS {
            for threshold in THRESHOLD {
                cells.extend(NOISE.map(|noise| Cell { departure, levels, threshold, noise }));
            }
        }
    }
    cells
}

impl Cell {
    fn name(&self) -> String {
        let Self { departure, levels, threshold, noise } = self;
        format!("{}; n={levels}; threshold={threshold}; noise={noise};", departure.name())
    }

    /// Distance of the drive from the resonance, in half widths of the line.
    fn detuning(&self) -> f64 {
        if let Departure::OffResonance(part) = self.departure { part } else { 0.0 }
    }

    /// Slope without friction at the frequency of the drive, and the threshold.
    fn truth(&self) -> [TrueValue; 2] {
        [(Parameter::Slope, Q / 1f64.hypot(self.detuning())), (Parameter::Threshold, self.threshold * TOP)]
            .map(|(parameter, value)| TrueValue { parameter, value })
    }

    fn series(self, number: u64) -> Series {
        let delta = OMEGA_0 / (2.0 * Q);
        let x_f = FRAC_PI_4 * self.threshold * TOP;
        let omega = OMEGA_0 + self.detuning() * delta;
        let highest = Q * (1.0 - self.threshold) * TOP;
        let disturbance = if let Departure::Drag(part) = self.departure {
            Disturbance::Drag(part)
        } else {
            Disturbance::Nothing
        };
        let level = |i: usize| {
            let x_0 = TOP * i as f64 / self.levels as f64;
            if x_0 <= self.threshold * TOP {
                return Some((x_0, Phasor::new(0.0, 0.0)));
            }
            // Closer to the threshold the motion stops within its cycle; few experiments measure there.
            let motion = Motion::new(disturbance, [OMEGA_0, delta, x_0], highest);
            Some((x_0, motion.at(omega, x_f)?)).filter(|_| x_0 > NEAREST * self.threshold * TOP)
        };
        let (drive, clean) = (1..=self.levels).filter_map(level).unzip();
        Series { cell: self, number, drive, clean }
    }
}

/// Lowest moving level over the threshold.
const NEAREST: f64 = 1.06;

impl Series {
    /// The levels as the instrument reads them.
    fn measured(&self, rng: &mut ChaCha8Rng) -> Option<Levels> {
        let Cell { departure, noise, .. } = self.cell;
        let highest = self.clean.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let crosstalk = if let Departure::Crosstalk(part) = departure {
            Phasor::from_polar(part * highest / TOP, rng.random_range(-PI..PI))
        } else {
            Phasor::new(0.0, 0.0)
        };
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        let mut read = |(z, drive): (&Phasor, &f64)| {
            let white = Phasor::new(normal(), normal()) * (noise * highest);
            let seen = (z + crosstalk * *drive + white).norm();
            match departure {
                Departure::Compression(part) => seen * (1.0 - part * (seen / highest).powi(2)),
                Departure::Zero(part) => seen + part * highest,
                Departure::ProportionalNoise(part) => (seen * (1.0 + part * normal())).abs(),
                _ => seen,
            }
        };
        let amplitude = self.clean.iter().zip(&self.drive).map(&mut read).collect();
        Levels::builder(self.drive.clone(), amplitude).unit("mm").drive_unit("mm").build().ok()
    }

    fn analysed(&self, seed_number: u64) -> Outcome {
        let own = seed(0x1E7E_1500, &[self.number as f64]);
        let mut rng = ChaCha8Rng::seed_from_u64(seed_number.wrapping_mul(0x9E37_79B9) ^ own);
        let answer = self.measured(&mut rng).and_then(|levels| analyse(&levels, &Options::default()).ok());
        answer.map_or_else(Outcome::default, |a| self.outcome(&a))
    }

    fn outcome(&self, answer: &Answer) -> Outcome {
        let estimate = |t: &TrueValue| answer.parameter(t.parameter).map(|q| Estimated::of(q, t.value));
        let is_bend = |w: &Warning| matches!(w, Warning::NotStraight { .. });
        // A warning that the threshold was extrapolated does not question the answer.
        let questions_answer = |w: &Warning| !matches!(w, Warning::ThresholdExtrapolated { .. });
        Outcome {
            estimates: self.cell.truth().iter().map(estimate).collect(),
            warned: answer.warnings.iter().any(questions_answer),
            sliding_detected: answer.detected,
            drag_chosen: answer.warnings.iter().any(is_bend),
            above_truth: None,
        }
    }
}

impl Scored for Row {
    /// Whether the coverage falls below 95 % by more than three of its standard errors, or friction is claimed too
    /// often where there is none.
    fn misses(&self) -> bool {
        let least = 0.95 - 3.0 * coverage_error(self.seeds as usize);
        let claimed = self.cell.threshold == 0.0 && self.scores.sliding_detected > 0.02;
        claimed || self.scores.unwarned_outliers > 0.01 || self.scores.coverage.iter().any(|c| *c < least)
    }
}

const COLUMNS: &str = "slope | threshold | outliers unwarned | friction claimed falsely | friction missed | bend named | refused | warned";

/// Means over cells.
fn pooled(rows: &[&Row]) -> String {
    let cells: Vec<_> = rows.iter().map(|row| (&row.scores, row.cell.threshold > 0.0)).collect();
    scores::pooled(&cells).join(" | ")
}

/// Errors and widths, one row for each number of levels and noise.
fn spread(rows: &[Row]) -> String {
    let mut text = format!(
        "\n## Errors and widths\n\nRoot mean square of the error, and mean half width of the 95 % interval, of the slope \
         over the slope and of the threshold over the highest level, over the same thresholds.\n\n| departure | levels | noise \
         | error of slope | half width | error of threshold | half width |\n{}|\n",
        "|---".repeat(7)
    );
    for departure in DEPARTURES {
        for levels in LEVELS {
            for noise in NOISE {
                let fits = |c: &Cell| c.departure == departure && c.levels == levels && c.noise == noise;
                let of: Vec<&Scores> = rows.iter().filter(|r| fits(&r.cell)).map(|r| &r.scores).collect();
                if of.is_empty() {
                    continue;
                }
                let mean = |of_one: &dyn Fn(&Scores) -> f64, unit: f64| {
                    100.0 * of.iter().map(|s| of_one(s)).sum::<f64>() / (of.len() as f64 * unit)
                };
                let figures = [(0, Q), (1, TOP)].map(|(k, unit)| {
                    let [error, width] = [mean(&|s| s.rms_error[k], unit), mean(&|s| s.half_width[k], unit)];
                    format!("{error:.2} % | {width:.2} %")
                });
                let (name, percent) = (departure.name(), 100.0 * noise);
                let _ = writeln!(text, "| {name} | {levels} | {percent} % | {} |", figures.join(" | "));
            }
        }
    }
    text
}

fn page(measured: &MeasuredCells<Row>, seeds: u64) -> String {
    let rows = &measured.rows;
    let mut text = format!(
        "# The default answer to drive levels\n\nMade by `cargo xtask statistics --default-levels --write`, {seeds} \
         records a cell. Exact amplitudes at resonance of {} cells, Q {Q}, evenly spaced levels up to the highest (none \
         closer above the threshold than {:.0} %), white noise in both quadratures of the amplitude, no errors given. A \
         *departure* is a *drag* over the viscous loss at the highest amplitude, a *compression* of the highest reading, \
         in proportion to the square, a *zero* that the detector adds to every reading, a *crosstalk* of the drive at a \
         random phase, a frequency beside the *resonance* in half widths of the line, or a *noise* as a part of each \
         amplitude. Slope and threshold: share of the 95 % intervals that hold the truth, which of a bend is that of \
         small amplitudes; *outliers unwarned*: answers with one of them more than four of its standard errors off and no \
         warning but that of an extrapolated threshold. Of six levels every answer is warned of where five or fewer move.\n\n\
         ## Means over thresholds of 0, 5.5, 31 and 61 % of the highest level\n\n\
         | departure | levels | noise | {COLUMNS} |\n{}|\n",
        rows.len(),
        100.0 * (NEAREST - 1.0),
        "|---".repeat(11)
    );
    for departure in DEPARTURES {
        for levels in LEVELS {
            for noise in NOISE {
                let fits = |c: &Cell| c.departure == departure && c.levels == levels && c.noise == noise;
                let of: Vec<&Row> = rows.iter().filter(|r| fits(&r.cell)).collect();
                if !of.is_empty() {
                    let (name, percent) = (departure.name(), 100.0 * noise);
                    let _ = writeln!(text, "| {name} | {levels} | {percent} % | {} |", pooled(&of));
                }
            }
        }
    }
    text += &spread(rows);
    let table = |rows: &[&Row]| {
        let mut table = format!(
            "| departure | levels | threshold | noise | records | {COLUMNS} |\n{}|\n",
            "|---".repeat(13)
        );
        for row in rows {
            let Cell { departure, levels, threshold, noise } = row.cell;
            let (name, records, percent) = (departure.name(), row.seeds, 100.0 * noise);
            let scores = pooled(&[*row]);
            let _ =
                writeln!(table, "| {name} | {levels} | {threshold} | {percent} % | {records} | {scores} |");
        }
        table
    };
    text += &measured.misses(
        "have a coverage more than three of its own standard errors below 95 %, unwarned outliers in more than 1 % of their \
         records, or claim a friction that is not there in more than 2 %. They",
        "records",
        table,
    );
    text
}

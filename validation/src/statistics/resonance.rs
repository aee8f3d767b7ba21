//! `cargo xtask statistics --resonance`: what the intervals of resonance curves are worth, on
//! exact curves whose truth is known, beside the paper's Lorentzian on the same curves.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a chore speaks to its terminal")]

use crate::Failure;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use slipfit::LossModel;
use slipfit::Parameter;
use slipfit::motion::steady::Phasor;
use slipfit::motion::steady::fundamental::{Fundamental, Point, fundamental};
use slipfit::resonance::{Curve, DriveAmplitude, Method, Options, analyse};
use std::f64::consts::{FRAC_PI_4, TAU};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Instant;

const Q: [f64; 4] = [5.0, 50.0, 1_000.0, 10_000.0];
const BETA: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 0.8, 0.95];
const POINTS: [usize; 3] = [41, 201, 801];
const OMEGA_0: f64 = TAU;
/// Drive amplitude.
const X_0: f64 = 1.0;
/// Noise of a quadrature over the highest amplitude: 50 dB.
const NOISE: f64 = 10e-4 * 3.162_277_660_168_38;
/// The window reaches this many widths of the line either side.
const WINDOW: f64 = 4.0;
/// With some 1700 figures, many miss by chance: those cells are asked again, so many times more.
const AGAIN: u64 = 5;

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

struct Prepared {
    cell: Cell,
    hz: Vec<f64>,
    clean: Vec<Phasor>,
    reference: Vec<Phasor>,
    sigma: f64,
    reference_sigma: f64,
    truth: [f64; 2],
    bound: [f64; 2],
}

struct Run {
    /// delta, x_F: unbounded estimate, covered.
    found: Option<[(f64, bool); 2]>,
    claimed: bool,
    /// Q and x_F by the paper's inversion.
    paper: Option<[f64; 2]>,
}

struct Outcome {
    repeats: usize,
    /// delta, x_F: bias over spread, spread over bound, coverage.
    figures: [[f64; 3]; 2],
    /// Bound of x_F over x_0, to see what the curve can tell at all.
    relative_bound: f64,
    claimed: f64,
    failed: usize,
    /// Paper: relative bias of Q and of x_F (over x_0 where there is no friction).
    paper: Option<[f64; 2]>,
}

impl Cell {
    fn name(&self) -> String {
        let kind = if self.complex { "complex" } else { "amplitude" };
        format!("Q={} beta={} n={} {kind} x_0 {}", self.q, self.beta, self.points, self.drive.name())
    }

    fn seed(&self) -> u64 {
        let parts = [
            self.q,
            self.beta,
            self.points as f64,
            f64::from(u8::from(self.complex)),
            self.drive as u8 as f64,
        ];
        parts.iter().fold(0xA5A5_1234, |seed, p| (seed ^ p.to_bits()).wrapping_mul(0x0000_0100_0000_01B3))
    }

    fn prepare(self) -> Option<Prepared> {
        let delta = OMEGA_0 / (2.0 * self.q);
        let x_f = FRAC_PI_4 * self.beta * X_0;
        let at = |omega: f64, delta: f64, x_f: f64| {
            fundamental(&Point { omega, omega_0: OMEGA_0, detuning: omega - OMEGA_0, delta, x_0: X_0, x_f })
        };
        // The line is wider than its viscous part, the less so the wider the window.
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
        Some(Prepared {
            cell: self,
            hz: omega.iter().map(|w| w / TAU).collect(),
            clean: all.iter().map(|f| f.value).collect(),
            reference: free.iter().map(|f| f.value).collect(),
            sigma,
            reference_sigma,
            truth: [delta, x_f],
            bound,
        })
    }

    /// Cramér-Rao bounds of delta and x_F with everything the fit leaves free.
    fn bound(
        &self,
        all: &[Fundamental],
        free: &[Fundamental],
        sigma: f64,
        reference: f64,
    ) -> Option<[f64; 2]> {
        // delta, x_F, omega_0, x_0, phase; of the reference delta, omega_0, phase.
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
        let part = DMatrix::from_fn(kept.len(), kept.len(), |i, j| information[(kept[i], kept[j])]);
        // Unit diagonal first: rates and lengths differ by many orders.
        let scale: Vec<f64> = (0..kept.len()).map(|i| 1.0 / part[(i, i)].sqrt()).collect();
        let unit = DMatrix::from_fn(kept.len(), kept.len(), |i, j| part[(i, j)] * scale[i] * scale[j]);
        let inverse = unit.try_inverse()?;
        Some([0, 1].map(|i| inverse[(i, i)].sqrt() * scale[i]))
    }
}

impl Prepared {
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

    fn run(&self, seed: u64) -> Run {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9) ^ self.cell.seed());
        let mut options = Options::default();
        options.model = Some(LossModel::VISCOUS_SLIDING);
        options.method = Method::Exact;
        let curve = self.curve(&self.clean, self.sigma, &mut rng);
        match self.cell.drive {
            Drive::Known => options.drive_amplitude = Some(DriveAmplitude { value: X_0, std_error: 0.0 }),
            Drive::Reference => {
                options.reference = self.curve(&self.reference, self.reference_sigma, &mut rng)
            }
            Drive::Unknown => {}
        }
        let Some(answer) = curve.and_then(|c| analyse(&c, &options).ok()) else {
            return Run { found: None, claimed: false, paper: None };
        };
        let one = |name: Parameter, truth: f64| {
            let q = answer.parameter(name)?;
            Some((q.unbounded_value, q.interval_95[0] <= truth && truth <= q.interval_95[1]))
        };
        let found = one(Parameter::DECAY_RATE, self.truth[0])
            .zip(one(Parameter::FRICTION_DISPLACEMENT, self.truth[1]));
        let paper = answer.paper.and_then(|p| Some([p.q_factor?, p.friction_displacement?]));
        Run { found: found.map(|(a, b)| [a, b]), claimed: answer.sliding.detected, paper }
    }

    fn summarise(&self, runs: &[Run]) -> Outcome {
        let good: Vec<_> = runs.iter().filter_map(|r| r.found).collect();
        let n = good.len() as f64;
        let figures = [0, 1].map(|k| {
            let mean = good.iter().map(|g| g[k].0).sum::<f64>() / n;
            let spread = (good.iter().map(|g| (g[k].0 - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let covered = good.iter().filter(|g| g[k].1).count() as f64 / n;
            [(mean - self.truth[k]) / spread, spread / self.bound[k], covered]
        });
        let papers: Vec<[f64; 2]> = runs.iter().filter_map(|r| r.paper).collect();
        let q = OMEGA_0 / (2.0 * self.truth[0]);
        let paper = (!papers.is_empty()).then(|| {
            let mean = |k: usize| papers.iter().map(|p| p[k]).sum::<f64>() / papers.len() as f64;
            let scale = if self.truth[1] > 0.0 { self.truth[1] } else { X_0 };
            [mean(0) / q - 1.0, (mean(1) - self.truth[1]) / scale]
        });
        Outcome {
            repeats: runs.len(),
            figures,
            relative_bound: self.bound[1] / X_0,
            claimed: runs.iter().filter(|r| r.claimed).count() as f64 / runs.len() as f64,
            failed: runs.len() - good.len(),
            paper,
        }
    }
}

/// Runs the table; `--seeds N`, `--only TEXT`, `--write`.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let value = |flag: &str| arguments.iter().position(|a| a == flag).and_then(|i| arguments.get(i + 1));
    let seeds: u64 = value("--seeds").and_then(|s| s.parse().ok()).unwrap_or(300);
    let only = value("--only").cloned().unwrap_or_default();
    let mut rows = Vec::new();
    for q in Q {
        for beta in BETA {
            for points in POINTS {
                for complex in [true, false] {
                    for drive in [Drive::Known, Drive::Reference, Drive::Unknown] {
                        let cell = Cell { q, beta, points, complex, drive };
                        if !cell.name().contains(&only) {
                            continue;
                        }
                        let begun = Instant::now();
                        let Some(prepared) = cell.prepare() else {
                            eprintln!("{}: no exact curve", cell.name());
                            continue;
                        };
                        let over = |seeds: std::ops::Range<u64>| {
                            let runs: Vec<_> = seeds.into_par_iter().map(|s| prepared.run(s)).collect();
                            prepared.summarise(&runs)
                        };
                        let mut o = over(0..seeds);
                        if !misses(&cell, &o).is_empty() {
                            o = over(seeds..seeds * (1 + AGAIN));
                        }
                        eprintln!(
                            "{:52} n={:5} delta {:+.2} {:.3} {:.3}  x_F {:+.2} {:.3} {:.3}  bound {:.1e} claimed {:.3} failed {} {:.1?}",
                            cell.name(),
                            o.repeats,
                            o.figures[0][0],
                            o.figures[0][1],
                            o.figures[0][2],
                            o.figures[1][0],
                            o.figures[1][1],
                            o.figures[1][2],
                            o.relative_bound,
                            o.claimed,
                            o.failed,
                            begun.elapsed()
                        );
                        rows.push((cell, o));
                    }
                }
            }
        }
    }
    let text = markdown(&rows, seeds);
    if arguments.iter().any(|a| a == "--write") {
        std::fs::write("docs/statistics_resonance.md", &text)?;
    } else {
        println!("{text}");
    }
    Ok(ExitCode::SUCCESS)
}

/// What a cell does not meet.
fn misses(cell: &Cell, o: &Outcome) -> Vec<String> {
    let tolerance = uncertainty(o.repeats);
    let mut list = Vec::new();
    for (name, [bias, spread, covered]) in ["δ", "x_F"].into_iter().zip(o.figures) {
        if bias.abs() > 0.15 {
            list.push(format!("{name} bias"));
        }
        if spread > 1.10 {
            list.push(format!("{name} spread"));
        }
        if !(0.93..=0.97).contains(&covered) {
            let chance = covered > 0.93 - tolerance && covered < 0.97 + tolerance;
            list.push(format!("{name} coverage{}", if chance { " (within chance)" } else { "" }));
        }
    }
    if cell.beta == 0.0 && o.claimed > 0.05 {
        list.push("sliding claimed".into());
    }
    if o.failed > 0 {
        list.push(format!("{} refused", o.failed));
    }
    list
}

/// Standard error of a coverage of 95 %.
fn uncertainty(repeats: usize) -> f64 {
    (0.95f64 * 0.05 / repeats as f64).sqrt()
}

fn markdown(rows: &[(Cell, Outcome)], seeds: u64) -> String {
    let mut text = format!(
        "# Bias, spread and coverage of resonance curves\n\nMade by `cargo xtask statistics --resonance --write`, \
         {seeds} repeats a cell; a cell that misses anything is run again with {AGAIN} times as many others, which \
         then stand alone (*repeats*). Exact curves (stops included), {WINDOW} widths of the line either side, white noise in \
         both quadratures 50 dB below the peak; amplitudes are the modulus of the noisy response. The whole analysis \
         runs on each; nothing is handed over but the model (viscous+sliding) and the drive where it is *known*; a \
         *reference* is a friction-free curve of the same length and noise ratio.\n\n*Bias* is over the spread \
         (wanted below 0.15), *spread* over the Cramér-Rao bound with the phase offset and, unless known, the drive \
         free (wanted at most 1.10), *covered* the share of 95 % intervals that hold the truth (wanted 93 to 97 %; \
         with {seeds} repeats itself uncertain by {:.1} %). Bias and spread are those of the unbounded estimate, coverage \
         that of the reported interval. *Bound* is the Cramér-Rao bound of x_F over x_0: above about 0.1 the shape \
         alone tells next to nothing; above 0.2 the second-order bias of least squares (Box, 1971) is taken out. *Paper Q* and *paper x_F* \
         are the mean errors of eq. (14) fitted to the same amplitudes and inverted with a = 4/3 (relative; over x_0 \
         where there is no friction).\n\n",
        100.0 * uncertainty(seeds as usize)
    );
    let met = rows.iter().filter(|(c, o)| misses(c, o).is_empty()).count();
    let by_chance = rows
        .iter()
        .filter(|(c, o)| {
            let m = misses(c, o);
            !m.is_empty() && m.iter().all(|m| m.contains("within chance"))
        })
        .count();
    let _ = writeln!(
        text,
        "{met} of {} cells meet everything; {by_chance} more miss only a coverage by no more than its own \
         uncertainty.\n",
        rows.len()
    );
    text.push_str(
        "| Q | β | points | data | x_0 | bound | δ bias | δ spread | δ covered | x_F bias | x_F spread | x_F covered \
         | sliding claimed | paper Q | paper x_F | repeats | misses |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (cell, o) in rows {
        let [d, x] = o.figures;
        let paper =
            o.paper.map_or(["".to_owned(), "".to_owned()], |p| p.map(|v| format!("{:+.0} %", 100.0 * v)));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.1e} | {:+.2} | {:.2} | {:.1} % | {:+.2} | {:.2} | {:.1} % | {:.0} % | {} | {} | {} | {} |",
            cell.q,
            cell.beta,
            cell.points,
            if cell.complex { "complex" } else { "amplitude" },
            cell.drive.name(),
            o.relative_bound,
            d[0],
            d[1],
            100.0 * d[2],
            x[0],
            x[1],
            100.0 * x[2],
            100.0 * o.claimed,
            paper[0],
            paper[1],
            o.repeats,
            misses(cell, o).join(", ")
        );
    }
    text
}

//! Ring-downs analysed with default options: the answer as every user gets it.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::ops::Range;
use std::process::ExitCode;
use std::time::Instant;

use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use slipfit::model::loss::LossTerm;
use slipfit::motion::decay::{AmplitudeLaw, FreeDecay};
use slipfit::motion::simulate::Drive;
use slipfit::motion::simulate::smooth::{self, SmoothMotion};
use slipfit::ringdown::{Answer, Options, analyse};
use slipfit::{Oscillator, Parameter, Record, SignalKind};

use super::bounds;
use super::choices::Choices;
use super::default_cells::{
    Cell, DERIVATIVE_Q, DRAG, FREQUENCY_HZ, NUISANCE_Q, NUISANCE_SHARE, Q, REST_Q, RecordedQuantity, SHARE,
    SNR_DB, cells,
};
use super::measured_cells::{MeasuredCells, Scored};
use super::nuisances::{DISTURBANCES, Nuisance, SECOND_RELEASE};
use super::scores::{Estimated, Outcome, Scores, TrueValue};
use super::trials::{coverage_error, mean_and_deviation, seed};
use crate::Failure;

/// Phase drift of a lock-in per decay time (rad), and its phase at the release.
const DETUNING_RAD: f64 = 0.4;
const LOCK_IN_PHASE_RAD: f64 = 0.7;
/// A record with fewer samples or cycles is not a ring-down.
const LEAST_SAMPLES: usize = 12;
const LEAST_CYCLES: f64 = 2.0;
/// Total number of samples over all repeats of a cell: long records are repeated less often.
const MOST_SAMPLES: f64 = 2e7;
/// Cells with longer records are skipped: a tenth of the length already carries the same information.
const LONGEST: usize = 1_000_000;

struct Decay {
    cell: Cell,
    time: Vec<f64>,
    clean: Vec<f64>,
    sigma: f64,
    oscillator: Oscillator,
    exact: FreeDecay,
    law: AmplitudeLaw,
    /// Smallest standard errors of decay rate and friction displacement (Cramér-Rao).
    bound: [f64; 2],
}

pub(super) fn run(choices: Choices) -> Result<ExitCode, Failure> {
    let mut measured = MeasuredCells::new();
    for cell in cells().into_iter().filter(|c| c.name().contains(&choices.only)) {
        let Some(decay) = cell.decay() else { continue };
        let repeats = choices.seeds.min((MOST_SAMPLES / decay.time.len() as f64).ceil() as u64).max(4);
        measured.measure(repeats, |records| decay.measured(records));
    }
    choices.publish("statistics_default.md", &page(&measured, choices.seeds))?;
    Ok(ExitCode::SUCCESS)
}

/// A cell with the scores of its records.
struct Row {
    cell: Cell,
    samples: usize,
    repeats: u64,
    scores: Scores,
    bound: [f64; 2],
    /// Whether the motion stops inside the record.
    stops: bool,
}

impl Row {
    /// Root mean square errors of decay rate and friction displacement over the Cramér-Rao bound.
    fn spread(&self) -> [f64; 2] {
        [0, 1].map(|k| self.scores.rms_error[k] / self.bound[k])
    }

    fn line(&self) -> String {
        let [delta, x_f] = self.spread();
        let Scores { compared, above_truth, worst_above_truth: worst, .. } = self.scores;
        format!(
            "| {} | {} | {} | {} | {delta:.2}, {x_f:.2} | {above_truth} of {compared} above the truth, by {worst:.2}",
            self.cell.row(),
            self.samples,
            self.repeats,
            self.scores.columns()
        )
    }
}

impl Scored for Row {
    /// Whether the coverage of a parameter falls below 95 % by more than three of its standard errors.
    fn misses(&self) -> bool {
        let least = 0.95 - 3.0 * coverage_error(self.repeats as usize);
        self.scores.coverage.iter().any(|c| *c < least)
    }
}

/// Means over cells, weighted by their repeats.
fn pooled(rows: &[&Row]) -> String {
    let repeats: f64 = rows.iter().map(|r| r.repeats as f64).sum();
    let mean = |value: &dyn Fn(&Scores) -> f64| {
        let sum: f64 = rows.iter().map(|r| r.repeats as f64 * value(&r.scores)).sum();
        format!("{:.1} %", 100.0 * sum / repeats)
    };
    let mut cells: Vec<String> = (0..4).map(|k| mean(&|s| s.coverage[k])).collect();
    let shares: [&dyn Fn(&Scores) -> f64; 5] =
        [&|s| s.unwarned_outliers, &|s| s.sliding_detected, &|s| s.drag_chosen, &|s| s.refused, &|s| {
            s.warned
        }];
    cells.extend(shares.map(mean));
    cells.extend([0, 1].map(|k| {
        let known: Vec<f64> = rows.iter().map(|r| r.spread()[k]).filter(|s| s.is_finite()).collect();
        median(known).map_or("–".to_owned(), |m| format!("{m:.2}"))
    }));
    cells.join(" | ")
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Number of answers, out of all whose motion was compared with the samples, that fit the samples worse than the true
/// parameters do: the search ended in another minimum.
fn minima(rows: &[Row]) -> String {
    let count = |of: &dyn Fn(&Row) -> bool| {
        let members = || rows.iter().filter(|r| of(r));
        let compared: usize = members().map(|r| r.scores.compared).sum();
        let above: usize = members().map(|r| r.scores.above_truth).sum();
        format!("{above} of {compared}")
    };
    let plain = |r: &Row| r.cell.plain(RecordedQuantity::Displacement);
    format!(
        "\n## The lowest minimum\n\nSum of squares of the reported motion over the samples of its window, above that of \
         the true motion: in {} records whose motion stops inside, in {} others.\n",
        count(&|r| plain(r) && r.stops),
        count(&|r| plain(r) && !r.stops)
    )
}

fn page(measured: &MeasuredCells<Row>, seeds: u64) -> String {
    let rows = &measured.rows;
    const COLUMNS: &str = "δ | x_F | f | A₀ | outliers unwarned | sliding claimed | drag chosen | refused | warned | δ spread | x_F spread";
    let mut text = format!(
        "# The default answer\n\nMade by `cargo xtask statistics --default --write`, up to {seeds} records a cell \
         (fewer of long records). Exact decays released at 1 with white noise, recorded for some decay times \
         1/δ, rest included where friction stops the motion before; amplitudes with Rician noise; velocities and accelerations of 2.5 decay times, x_F that of the displacement, A₀ times 2πf or its square. The whole \
         analysis runs on each as every user gets it: no option but the frequency of amplitudes. *Share* is the \
         sliding part of the loss at the start; δ, x_F, f and A₀: share of the 95 % intervals that hold the truth; \
         *outliers unwarned*: answers with one of the four more than four of its standard errors off and no \
         warning; *spread*: root mean square error of δ and x_F over the Cramér-Rao bound of the motion before the \
         stop (the median of the cells; of reported values, which cannot be negative, it may lie below 1). *Drag* is a part of what sliding leaves of the loss at the start; disturbances are added at \
         40 dB, 2.5 decay times, sliding shares 0, 0.2 and 0.5: noise of autocorrelation 0.9 or density 1/f in \
         place of the white, an offset that walks by 5 % and a phase that walks by 0.3 rad over the record, 5 % \
         of mains at 50 Hz (there beyond half the sampling rate), a range that ends at 85 %, one sample in 500 off by 0.2 to 2, \
         the mass held at 1 for half as long before its release, a second release from 0.7 behind the first, recorded as long, steps of 0.05 recorded for 8 decay times, a reading of x - 0.1 x³.\n\n## Means\n\n| cells | number | {COLUMNS} |\n{}|\n",
        "|---".repeat(13)
    );
    let mut group = |name: String, of: &dyn Fn(&Cell) -> bool| {
        let members: Vec<&Row> = rows.iter().filter(|r| of(&r.cell)).collect();
        if !members.is_empty() {
            let _ = writeln!(text, "| {name} | {} | {} |", members.len(), pooled(&members));
        }
    };
    let recorded = [
        (RecordedQuantity::Displacement, "displacement"),
        (RecordedQuantity::Envelope, "amplitudes"),
        (RecordedQuantity::LockIn, "lock-in"),
    ];
    for (what, name) in recorded {
        group(name.to_owned(), &|c| c.plain(what));
        for share in SHARE {
            group(format!("{name}, share {share}"), &|c| c.plain(what) && c.share == share);
        }
        for snr_db in SNR_DB {
            group(format!("{name}, {snr_db} dB"), &|c| c.plain(what) && c.snr_db == snr_db);
        }
        for q in Q {
            group(format!("{name}, Q {q}"), &|c| c.plain(what) && c.q == q);
        }
    }
    for q in REST_Q {
        group(format!("stops after some swings, Q {q}"), &|c| {
            c.plain(RecordedQuantity::Displacement) && c.q == q
        });
    }
    for (what, name) in
        [(RecordedQuantity::Velocity, "velocity"), (RecordedQuantity::Acceleration, "acceleration")]
    {
        for q in DERIVATIVE_Q {
            group(format!("{name}, Q {q}"), &|c| c.plain(what) && c.q == q);
        }
    }
    for drag in DRAG {
        for share in NUISANCE_SHARE {
            group(format!("drag {drag} of the rest, share {share}"), &|c| c.drag == drag && c.share == share);
        }
    }
    for nuisance in DISTURBANCES {
        for q in NUISANCE_Q {
            group(format!("{}, Q {q}", nuisance.name()), &|c| c.nuisance == nuisance && c.q == q);
        }
    }
    text.push_str(&minima(rows));
    let head = format!(
        "| Q | share | dB | decay times | samples a cycle | with | samples | records | {COLUMNS} |\n{}|",
        "|---".repeat(19)
    );
    let table = |rows: &[&Row]| {
        let line =
            |r: &&Row| format!("\n| {} | {} | {} | {} |", r.cell.row(), r.samples, r.repeats, pooled(&[*r]));
        format!("{head}{}\n", rows.iter().map(line).collect::<String>())
    };
    text += &measured.misses(
        "have a coverage more than three of its own standard errors below 95 %. Of some three thousand coverages a few do by \
         chance: these cells",
        "records",
        table,
    );
    text
}

impl Cell {
    /// The record without noise; `None` if it is too short for a ring-down.
    fn decay(self) -> Option<Decay> {
        let omega_0 = TAU * FREQUENCY_HZ;
        let total = omega_0 / (2.0 * self.q);
        let (drag, delta) = (self.drag * total, (1.0 - self.drag) * total);
        let x_f = self.share / (1.0 - self.share) * total * PI / (2.0 * omega_0);
        let oscillator = Oscillator::kinematic(omega_0, delta, x_f).ok()?;
        let exact = FreeDecay::from_rest(&oscillator, 1.0).ok()?;
        let law = AmplitudeLaw::new(1.0, 2.0 * omega_0 * x_f / PI, delta, drag).ok()?;
        let end = self.decay_times / total;
        let moving = exact.stop().map_or(end, |s| s.time_s.min(end));
        let rate = FREQUENCY_HZ * self.samples_per_cycle;
        let count = (end * rate) as usize;
        if moving * FREQUENCY_HZ < LEAST_CYCLES || !(LEAST_SAMPLES..=LONGEST).contains(&count) {
            return None;
        }
        let time: Vec<f64> = (0..count).map(|i| i as f64 / rate).collect();
        let mut clean = vec![0.0; count];
        match self.what {
            RecordedQuantity::Displacement if self.drag == 0.0 => exact.fill(&time, &mut clean).ok()?,
            // Divided by `omega_0` or its square, so that the amplitude is 1 here too.
            RecordedQuantity::Velocity | RecordedQuantity::Acceleration => {
                for (y, &t) in clean.iter_mut().zip(&time) {
                    let (x, v) = exact.state(t);
                    *y = match self.what {
                        _ if v == 0.0 && t > 0.0 => 0.0,
                        RecordedQuantity::Velocity => v / omega_0,
                        _ => -(x + x_f * v.signum()) - 2.0 * delta * v / omega_0.powi(2),
                    };
                }
            }
            RecordedQuantity::Displacement => {
                let coefficient = drag * 3.0 * PI / (4.0 * omega_0.powi(3));
                let law = smooth::drag(coefficient).ok()?;
                let mut motion = SmoothMotion::new(&oscillator, law, Drive::none(), 0.0, 1.0, 0.0).ok()?;
                for (x, &t) in clean.iter_mut().zip(&time) {
                    *x = motion.state_at(t).ok()?.position;
                }
            }
            RecordedQuantity::Envelope | RecordedQuantity::LockIn => {
                clean = time.iter().map(|&t| law.amplitude(t).max(0.0)).collect()
            }
        }
        let sigma = 10f64.powf(-self.snr_db / 20.0);
        let stop = match self.what {
            RecordedQuantity::Displacement | RecordedQuantity::Velocity | RecordedQuantity::Acceleration => {
                exact.stop().map_or(f64::INFINITY, |s| s.time_s)
            }
            RecordedQuantity::Envelope | RecordedQuantity::LockIn => {
                law.stop_time_s().unwrap_or(f64::INFINITY)
            }
        };
        let moving: Vec<f64> = time.iter().copied().filter(|t| *t <= stop).collect();
        let bound = match self.what {
            _ if self.drag > 0.0 || self.nuisance != Nuisance::None => [f64::NAN; 2],
            RecordedQuantity::Displacement => {
                bounds::of_motion([1.0, delta, x_f, 0.0, omega_0, 0.0], &moving, sigma)
            }
            RecordedQuantity::LockIn => bounds::of_amplitudes(&oscillator, 1.0, &moving, sigma),
            // Rician: near the noise level the information is not that of a normal distribution.
            RecordedQuantity::Envelope | RecordedQuantity::Velocity | RecordedQuantity::Acceleration => {
                [f64::NAN; 2]
            }
        };
        let again = FreeDecay::from_rest(&oscillator, SECOND_RELEASE).ok()?;
        let second = || time.iter().map(|t| again.displacement(*t)).collect();
        let (before, clean) = self.nuisance.with_surroundings(clean, second);
        let time = (0..clean.len()).map(|i| (i as f64 - before as f64) / rate).collect();
        Some(Decay { cell: self, time, clean, sigma, oscillator, exact, law, bound })
    }
}

impl Decay {
    fn stops(&self) -> bool {
        let end = self.time.last().copied().unwrap_or_default();
        self.exact.stop().is_some_and(|s| s.time_s < end)
    }

    /// True values for a window that begins at `start_s`.
    fn truth(&self, start_s: f64) -> [TrueValue; 4] {
        let (delta, x_f) = (self.oscillator.decay_rate_per_s(), self.oscillator.friction_displacement());
        let omega_0 = TAU * FREQUENCY_HZ;
        let x_f_recorded = match self.cell.what {
            RecordedQuantity::Velocity => x_f / omega_0,
            RecordedQuantity::Acceleration => x_f / omega_0.powi(2),
            _ => x_f,
        };
        let offset = self.oscillator.decay_offset();
        let second_s = 0.5 * self.time.len() as f64 / (FREQUENCY_HZ * self.cell.samples_per_cycle);
        let second = self.cell.nuisance == Nuisance::SecondRelease && start_s > second_s - 0.5 / FREQUENCY_HZ;
        let (first, start_s) = if second { (SECOND_RELEASE, start_s - second_s) } else { (1.0, start_s) };
        let amplitude = if self.cell.drag > 0.0 || !offset.is_finite() {
            self.law.amplitude(start_s)
        } else {
            (first + offset) * (-delta * start_s).exp() - offset
        };
        // The record is divided by `omega_0` or its square; lengths of a signal are displacements times the frequency
        // of the motion.
        let pulled = self.oscillator.omega_d() / omega_0;
        let amplitude = amplitude
            * match self.cell.what {
                RecordedQuantity::Velocity => pulled,
                RecordedQuantity::Acceleration => pulled * pulled,
                _ => 1.0,
            };
        let frequency = match self.cell.what {
            RecordedQuantity::Displacement | RecordedQuantity::Velocity | RecordedQuantity::Acceleration => {
                self.oscillator.omega_d() / TAU
            }
            RecordedQuantity::Envelope | RecordedQuantity::LockIn => FREQUENCY_HZ,
        };
        [
            (Parameter::DECAY_RATE, delta),
            (Parameter::FRICTION_DISPLACEMENT, x_f_recorded),
            (Parameter::Frequency, frequency),
            (Parameter::InitialAmplitude, amplitude),
        ]
        .map(|(parameter, value)| TrueValue { parameter, value })
    }

    /// The motion with a phase added and its amplitude unchanged.
    fn along(&self, phase: &[f64]) -> Vec<f64> {
        let omega = self.oscillator.omega_d();
        let at = |(&t, phase): (&f64, &f64)| {
            let shifted = (t + phase / omega).max(0.0);
            let (here, there) = (self.law.amplitude(t), self.law.amplitude(shifted));
            let factor = if here > 0.0 && there > 0.0 { here / there } else { 1.0 };
            factor * self.exact.displacement(shifted)
        };
        self.time.iter().zip(phase).map(at).collect()
    }

    /// The scores of the cell over these records.
    fn measured(&self, records: Range<u64>) -> Row {
        let started = Instant::now();
        let repeats = records.end - records.start;
        let outcomes: Vec<Outcome> = records.into_par_iter().map(|s| self.outcome(s)).collect();
        let row = Row {
            cell: self.cell,
            samples: self.time.len(),
            repeats,
            scores: Scores::of(&outcomes, &self.truth(0.0)),
            bound: self.bound,
            stops: self.stops(),
        };
        eprintln!("{} | {:.1?}", row.line(), started.elapsed() / repeats as u32);
        row
    }

    fn outcome(&self, number: u64) -> Outcome {
        let Cell { what, q, share, snr_db, decay_times, samples_per_cycle, nuisance, drag } = self.cell;
        let kind = what as u64 ^ (nuisance as u64) << 8 ^ drag.to_bits();
        let own = seed(0xDEFA_0171 ^ kind, &[q, share, snr_db, decay_times, samples_per_cycle]);
        let mut rng = ChaCha8Rng::seed_from_u64(number.wrapping_mul(0x9E37_79B9) ^ own);
        let mut quadrature = Vec::new();
        let signal: Vec<f64> = match what {
            RecordedQuantity::Displacement | RecordedQuantity::Velocity | RecordedQuantity::Acceleration => {
                let wandering = nuisance.phase(self.time.len(), &mut rng).map(|phase| self.along(&phase));
                let motion = wandering.as_ref().unwrap_or(&self.clean);
                nuisance.recorded(&self.time, motion, self.sigma, &mut rng)
            }
            RecordedQuantity::Envelope => {
                let mut noise = || self.sigma * rng.sample::<f64, _>(StandardNormal);
                self.clean.iter().map(|x| (x + noise()).hypot(noise())).collect()
            }
            RecordedQuantity::LockIn => {
                let turned = |phase: f64, rng: &mut ChaCha8Rng| {
                    let rate = DETUNING_RAD * self.oscillator.decay_rate_per_s();
                    let at = |(x, t): (&f64, &f64)| {
                        x * (phase + rate * t).cos() + self.sigma * rng.sample::<f64, _>(StandardNormal)
                    };
                    self.clean.iter().zip(&self.time).map(at).collect()
                };
                let in_phase = turned(LOCK_IN_PHASE_RAD, &mut rng);
                quadrature = turned(LOCK_IN_PHASE_RAD - 0.5 * PI, &mut rng);
                in_phase
            }
        };
        let mut options = Options::default();
        if matches!(what, RecordedQuantity::Envelope | RecordedQuantity::LockIn) {
            options.frequency_hz = Some(FREQUENCY_HZ);
        }
        let time = self.time.clone();
        let record = match what {
            RecordedQuantity::Displacement => Record::new(time, signal),
            RecordedQuantity::Velocity => {
                Record::new(time, signal).map(|r| r.with_kind(SignalKind::Velocity).with_unit("m/s"))
            }
            RecordedQuantity::Acceleration => {
                Record::new(time, signal).map(|r| r.with_kind(SignalKind::Acceleration).with_unit("m/s^2"))
            }
            RecordedQuantity::Envelope => {
                Record::new(time, signal).map(|r| r.with_kind(SignalKind::Envelope))
            }
            RecordedQuantity::LockIn => Record::lock_in(time, signal, quadrature),
        };
        let answered = record.and_then(|record| analyse(&record, &options).map(|answer| (record, answer)));
        let Ok((record, answer)) = answered else { return Outcome::default() };
        let estimates = self
            .truth(answer.segment.start_s)
            .iter()
            .map(|t| answer.parameter(t.parameter).map(|q| Estimated::of(q, t.value)))
            .collect::<Option<Vec<_>>>();
        Outcome {
            estimates,
            warned: !answer.warnings.is_empty(),
            sliding_detected: answer.sliding.detected,
            drag_chosen: answer.model.has(LossTerm::Drag),
            above_truth: self.above_truth(&record, &answer),
        }
    }

    /// Sum of squares of the reported motion over its window minus that of the true motion, over the variance of the
    /// noise; `None` if the samples are not a displacement or their noise is not white.
    fn above_truth(&self, record: &Record, answer: &Answer) -> Option<f64> {
        if !self.cell.plain(RecordedQuantity::Displacement) || answer.diagnostics.method != "waveform" {
            return None;
        }
        let [from, to] = answer.fit.range_s();
        let rest = answer.fit.rest_s().unwrap_or(f64::INFINITY);
        let (mut moving, mut still, mut truth) = (0.0, 0.0, 0.0);
        let mut at_rest = Vec::new();
        for ((t, clean), x) in self.time.iter().zip(&self.clean).zip(record.signal()) {
            if !(from..=to).contains(t) {
                continue;
            }
            let square = (x - answer.fit.signal_at(*t)).powi(2);
            truth += (x - clean).powi(2);
            if *t > rest {
                still += square;
                at_rest.push(*x);
            } else {
                moving += square;
            }
        }
        // A level at rest that does not determine the last swing is fitted freely: the smaller residual sum of
        // squares counts.
        if at_rest.len() > 1 {
            let (_, deviation) = mean_and_deviation(&at_rest);
            still = still.min((at_rest.len() - 1) as f64 * deviation.powi(2));
        }
        Some((moving + still - truth) / self.sigma.powi(2))
    }
}

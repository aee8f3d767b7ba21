//! One cell of the table: an oscillator, a noise, a nuisance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use slipfit::LossModel;
use slipfit::Parameter;
use slipfit::motion::decay::FreeDecay;
use slipfit::ringdown::{Options, analyse};
use slipfit::{Oscillator, Record};
use std::f64::consts::{PI, SQRT_2, TAU};

/// What disturbs the record beside white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Nuisance {
    None,
    /// Spring `k (x + alpha x³)`, 2 % frequency change over the decay.
    Hardening,
    /// Offset moving by 5 % of the first amplitude.
    OffsetDrift,
    /// Eight-bit converter over 1.2 times the first amplitude.
    EightBit,
    /// A tenth of the samples missing.
    MissingSamples,
    /// [`LEAD_IN_CYCLES`] of constant amplitude first, driven.
    DrivenLeadIn,
    /// Two fifths longer than the motion: at rest at the end.
    Rest,
}

impl Nuisance {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Nuisance::None => "none",
            Nuisance::Hardening => "frequency changes by 2 %",
            Nuisance::OffsetDrift => "offset drifts by 5 %",
            Nuisance::EightBit => "8-bit converter",
            Nuisance::MissingSamples => "10 % missing",
            Nuisance::DrivenLeadIn => "driven lead-in",
            Nuisance::Rest => "at rest at the end",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) q: f64,
    pub(crate) share: f64,
    pub(crate) snr_db: f64,
    pub(crate) nuisance: Nuisance,
}

/// A cell with its exact record and bounds.
pub(crate) struct Prepared {
    cell: Cell,
    time: Vec<f64>,
    clean: Vec<f64>,
    sigma: f64,
    delta: f64,
    x_f: f64,
    /// Cramér-Rao standard errors of delta and x_F.
    bound: [f64; 2],
}

/// One analysed record.
pub(crate) struct Run {
    /// delta, x_F: estimate, covered.
    found: Option<[(f64, bool); 2]>,
    claimed: bool,
}

/// A cell's figures.
pub(crate) struct Outcome {
    pub(crate) samples: usize,
    pub(crate) cycles: f64,
    /// delta, x_F: bias over spread, spread over bound, coverage.
    pub(crate) figures: [[f64; 3]; 2],
    pub(crate) claimed: f64,
    pub(crate) failed: usize,
}

const AMPLITUDE: f64 = 1.0;
const OMEGA_0: f64 = TAU;
/// One cycle a second: also seconds.
const LEAD_IN_CYCLES: f64 = 20.0;

impl Cell {
    pub(crate) fn name(&self) -> String {
        format!("Q={} share={} snr={} {}", self.q, self.share, self.snr_db, self.nuisance.name())
    }

    /// Different cells see different noise.
    fn seed(&self) -> u64 {
        let parts = [self.q, self.share, self.snr_db, self.nuisance as u8 as f64];
        parts.iter().fold(0x5117_F175, |seed, p| (seed ^ p.to_bits()).wrapping_mul(0x0000_0100_0000_01B3))
    }

    /// The noise-free record; `None` where friction holds the mass at once.
    pub(crate) fn prepare(self) -> Option<Prepared> {
        let delta = OMEGA_0 / (2.0 * self.q);
        // share = a0/(a0 + delta A) with a0 = 2 omega x_F/pi
        let x_f = self.share / (1.0 - self.share) * delta * AMPLITUDE * PI / (2.0 * OMEGA_0);
        if x_f >= AMPLITUDE {
            return None;
        }
        let truth = [AMPLITUDE, delta, x_f, 0.0, OMEGA_0, 0.0];
        let oscillator = Oscillator::kinematic(OMEGA_0, delta, x_f).ok()?;
        let decay = FreeDecay::from_rest(&oscillator, AMPLITUDE).ok()?;
        // Down to 3 % of the first amplitude, or to the stop.
        let offset = oscillator.decay_offset();
        let fall = ((AMPLITUDE + offset) / (0.03 * AMPLITUDE + offset)).ln() / delta;
        let stop = decay.stop().map_or(f64::INFINITY, |s| s.time_s);
        let end = if self.nuisance == Nuisance::Rest { 1.4 * stop } else { stop.min(fall) };
        if !end.is_finite() {
            return None;
        }
        let usual: f64 = match self.q {
            q if q < 10.0 => 60.3,
            q if q < 100.0 => 20.7,
            q if q < 5_000.0 => 8.3,
            _ => 5.3,
        };
        // A record of a cycle or two is sampled fast enough to hold 400 samples.
        let per_cycle = usual.max(400.3 / end);
        let count = (end * per_cycle) as usize;
        let mut time: Vec<f64> = (0..count).map(|i| i as f64 / per_cycle).collect();
        let mut clean = vec![0.0; count];
        if self.nuisance == Nuisance::Hardening {
            clean = hardening(delta, x_f, &time);
        } else {
            decay.fill(&time, &mut clean).ok()?;
        }
        match self.nuisance {
            Nuisance::OffsetDrift => {
                for (x, t) in clean.iter_mut().zip(&time) {
                    *x += 0.05 * AMPLITUDE * t / end;
                }
            }
            Nuisance::DrivenLeadIn => {
                let lead = LEAD_IN_CYCLES;
                let before = (lead * per_cycle) as usize;
                let mut driven: Vec<f64> =
                    (0..before).map(|i| AMPLITUDE * (TAU * (i as f64 / per_cycle - lead)).cos()).collect();
                driven.extend(&clean);
                clean = driven;
                let step = 1.0 / per_cycle;
                let shift = before as f64 * step;
                let gap = lead - shift;
                time = (0..before)
                    .map(|i| i as f64 * step)
                    .chain(time.iter().map(|t| t + shift + gap))
                    .collect();
            }
            _ => {}
        }
        let release_s = if self.nuisance == Nuisance::DrivenLeadIn { LEAD_IN_CYCLES } else { 0.0 };
        let free: Vec<f64> =
            time.iter().map(|t| t - release_s).filter(|t| (0.0..=stop).contains(t)).collect();
        let sigma = AMPLITUDE / SQRT_2 * 10f64.powf(-self.snr_db / 20.0);
        let bound = bounds(&truth, &free, sigma);
        Some(Prepared { cell: self, time, clean, sigma, delta, x_f, bound })
    }
}

/// Cramér-Rao standard errors of delta and x_F with amplitude, phase, frequency
/// and offset free, from central differences of the exact motion.
fn bounds(truth: &[f64; 6], time: &[f64], sigma: f64) -> [f64; 2] {
    let motion = |p: &[f64; 6]| -> Vec<f64> {
        let shifted: Vec<f64> = time.iter().map(|t| (t + p[3]).max(0.0)).collect();
        let omega_0 = p[4];
        let mut out = vec![0.0; time.len()];
        let filled = Oscillator::kinematic(omega_0, p[1].max(0.0), p[2].max(0.0))
            .and_then(|o| FreeDecay::from_rest(&o, p[0]))
            .and_then(|d| d.fill(&shifted, &mut out));
        if filled.is_err() {
            out.fill(f64::NAN);
        }
        out.iter().map(|x| x + p[5]).collect()
    };
    let columns: Vec<Vec<f64>> = (0..6)
        .map(|k| {
            let step = match k {
                1 => 1e-4 * truth[1],
                2 => 1e-4 * truth[2].max(1e-3 * truth[1] / OMEGA_0),
                3 => 1e-6,
                4 => 1e-7 * truth[1].max(1e-2),
                _ => 1e-5,
            };
            let (mut up, mut down) = (*truth, *truth);
            up[k] += step;
            // One-sided at the limits x_F = 0 and t = 0.
            let down_step = if (k == 2 && truth[2] == 0.0) || k == 3 { 0.0 } else { step };
            down[k] -= down_step;
            let (a, b) = (motion(&up), motion(&down));
            a.iter().zip(&b).map(|(a, b)| (a - b) / (step + down_step)).collect()
        })
        .collect();
    let information = nalgebra::DMatrix::from_fn(6, 6, |i, j| {
        columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>() / (sigma * sigma)
    });
    match information.try_inverse() {
        Some(c) => [c[(1, 1)].sqrt(), c[(2, 2)].sqrt()],
        None => [f64::NAN; 2],
    }
}

/// The decay of a hardening spring, integrated between its velocity's sign
/// changes by the classical Runge-Kutta method with 400 steps a cycle.
fn hardening(delta: f64, x_f: f64, time: &[f64]) -> Vec<f64> {
    // 3/8 alpha A² = 2 %
    let alpha = 0.02 * 8.0 / 3.0 / (AMPLITUDE * AMPLITUDE);
    let force =
        |x: f64, v: f64, s: f64| -2.0 * delta * v - OMEGA_0 * OMEGA_0 * (x + alpha * x * x * x + s * x_f);
    let h = 1.0 / 400.0;
    let step = |x: f64, v: f64, s: f64, h: f64| {
        let (k1x, k1v) = (v, force(x, v, s));
        let (k2x, k2v) = (v + 0.5 * h * k1v, force(x + 0.5 * h * k1x, v + 0.5 * h * k1v, s));
        let (k3x, k3v) = (v + 0.5 * h * k2v, force(x + 0.5 * h * k2x, v + 0.5 * h * k2v, s));
        let (k4x, k4v) = (v + h * k3v, force(x + h * k3x, v + h * k3v, s));
        (x + h / 6.0 * (k1x + 2.0 * k2x + 2.0 * k3x + k4x), v + h / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v))
    };
    let (mut t, mut x, mut v, mut s) = (0.0, AMPLITUDE, 0.0, -1.0);
    let mut out = Vec::with_capacity(time.len());
    let mut index = 0;
    while index < time.len() {
        // The whole step, or the part of it up to the turn.
        let (nx, nv) = step(x, v, s, h);
        let mut part = h;
        let turns = v != 0.0 && nv * s < 0.0;
        if turns {
            let (mut a, mut b) = (0.0, h);
            for _ in 0..60 {
                let m = 0.5 * (a + b);
                if step(x, v, s, m).1 * s < 0.0 { b = m } else { a = m }
            }
            part = b;
        }
        while index < time.len() && time[index] <= t + part {
            out.push(step(x, v, s, time[index] - t).0);
            index += 1;
        }
        if turns {
            x = step(x, v, s, part).0;
            v = 0.0;
            s = -s;
        } else {
            (x, v) = (nx, nv);
        }
        t += part;
    }
    out
}

impl Prepared {
    /// Adds the noise of one seed and analyses.
    pub(crate) fn run(&self, seed: u64) -> Run {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9) ^ self.cell.seed());
        let mut time = Vec::with_capacity(self.time.len());
        let mut signal = Vec::with_capacity(self.time.len());
        let lsb = 2.4 * AMPLITUDE / 256.0;
        for (t, x) in self.time.iter().zip(&self.clean) {
            let noise: f64 = rng.sample(StandardNormal);
            let mut value = x + self.sigma * noise;
            if self.cell.nuisance == Nuisance::EightBit {
                value = (value / lsb).round() * lsb;
            }
            if self.cell.nuisance == Nuisance::MissingSamples && rng.random::<f64>() < 0.1 {
                continue;
            }
            time.push(*t);
            signal.push(value);
        }
        let analysed = |model: Option<LossModel>| {
            let mut options = Options::default();
            options.model = model;
            Record::new(time.clone(), signal.clone()).and_then(|r| analyse(&r, &options))
        };
        let found = analysed(Some(LossModel::VISCOUS_SLIDING)).ok().and_then(|answer| {
            let one = |name: Parameter, truth: f64| {
                let q = answer.parameter(name)?;
                Some((q.unbounded_value, q.interval_95[0] <= truth && truth <= q.interval_95[1]))
            };
            let claimed = answer.sliding.detected;
            Some((
                [one(Parameter::DECAY_RATE, self.delta)?, one(Parameter::FRICTION_DISPLACEMENT, self.x_f)?],
                claimed,
            ))
        });
        Run { found: found.map(|f| f.0), claimed: found.is_some_and(|f| f.1) }
    }

    pub(crate) fn summarise(&self, runs: &[Run]) -> Outcome {
        let good: Vec<_> = runs.iter().filter_map(|r| r.found).collect();
        let n = good.len() as f64;
        let figures = [(0, self.delta), (1, self.x_f)].map(|(k, truth)| {
            let mean = good.iter().map(|g| g[k].0).sum::<f64>() / n;
            let spread = (good.iter().map(|g| (g[k].0 - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let covered = good.iter().filter(|g| g[k].1).count() as f64 / n;
            [(mean - truth) / spread, spread / self.bound[k], covered]
        });
        Outcome {
            samples: self.time.len(),
            cycles: self.time[self.time.len() - 1],
            figures,
            claimed: runs.iter().filter(|r| r.claimed).count() as f64 / runs.len() as f64,
            failed: runs.len() - good.len(),
        }
    }
}

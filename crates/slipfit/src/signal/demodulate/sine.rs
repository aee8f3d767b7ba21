//! Fit of one sine to a stretch of samples.

use std::f64::consts::TAU;

use super::criteria::Criteria;
use crate::inference::evidence;
use crate::inference::least_squares::{self, LeastSquares, Normal};
use crate::motion::steady::Phasor;

/// A sine whose frequency is also estimated.
pub(super) struct Sine {
    pub(super) omega: f64,
    pub(super) omega_std_error: f64,
}

/// `c cos(omega t) + s sin(omega t) + offset + drift t`, with time from the middle.
struct Problem<'a> {
    time: &'a [f64],
    values: &'a [f64],
    middle: f64,
    half: f64,
}

impl LeastSquares for Problem<'_> {
    fn parameters(&self) -> usize {
        5
    }

    fn observations(&self) -> f64 {
        self.time.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        if p[4] <= 0.0 {
            return false;
        }
        for (&t, &value) in self.time.iter().zip(self.values) {
            let u = t - self.middle;
            let (sin, cos) = (p[4] * u).sin_cos();
            let turned = u * (p[1] * cos - p[0] * sin);
            let drift = u / self.half;
            let model = p[0] * cos + p[1] * sin + p[2] + p[3] * drift;
            out.add_row(&[cos, sin, 1.0, drift, turned], value - model, 1.0);
        }
        true
    }
}

impl Sine {
    /// A sine of known frequency.
    pub(super) fn known(time: &[f64], values: &[f64], omega: f64) -> Option<Self> {
        (time.len() == values.len()).then_some(Self { omega, omega_std_error: 0.0 })
    }

    /// The frequency near `omega` with the best fit; `omega` itself if none is better.
    pub(super) fn refined(time: &[f64], values: &[f64], omega: f64, c: &Criteria) -> Option<Self> {
        let wave = Wave::fit(time, values, &PhaseLaw::steady(time, omega), c)?;
        let (first, last) = (time[0], time[time.len() - 1]);
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let problem = Problem { time, values, middle, half };
        let turn = wave.phasor * Phasor::from_polar(1.0, omega * (middle - wave.middle));
        let start = [turn.re, -turn.im, wave.offset, 0.0, omega];
        let fit = least_squares::minimise(&problem, &start, &[0, 1, 2, 3, 4])?;
        // A step of more than half a cycle over the stretch has lost the line.
        if (fit.parameters[4] - omega).abs() * half > TAU {
            return Some(Self { omega, omega_std_error: TAU / half });
        }
        let dof = (time.len() as f64 - 5.0).max(1.0);
        let noise = (fit.rss / dof).sqrt();
        Some(Self { omega: fit.parameters[4], omega_std_error: noise * fit.unit_std(4) })
    }
}

/// The phase of the drive over a stretch: `omega u + c_2 v² + c_3 v³`, with the time `u` from the middle and
/// `v = u/half`, because exciters change their speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhaseLaw {
    omega: f64,
    middle: f64,
    half: f64,
    bend: [f64; 2],
}

impl PhaseLaw {
    pub(super) fn steady(time: &[f64], omega: f64) -> Self {
        let (first, last) = (time[0], time[time.len() - 1]);
        Self { omega, middle: 0.5 * (first + last), half: 0.5 * (last - first), bend: [0.0; 2] }
    }

    /// Phase law fitted to the drive; curvature terms are added if they are significant.
    pub(super) fn of(time: &[f64], drive: &[f64], omega: f64, c: &Criteria) -> Self {
        let mut law = Self::steady(time, omega);
        let Some(blocks) = super::settle::phasors(time, drive, omega, c) else { return law };
        let mut phases = Vec::with_capacity(blocks.len());
        for block in &blocks {
            let phase = block.phasor.arg();
            let before = phases.last().copied().unwrap_or(phase);
            phases.push(phase - TAU * ((phase - before) / TAU).round());
        }
        let place = |i: usize| (blocks[i].middle_s + time[0] - law.middle) / law.half;
        let fit = |order: i32| {
            let columns = order as usize + 1;
            let rows =
                (0..blocks.len()).map(|i| ((0..=order).map(|k| place(i).powi(k)).collect(), phases[i], 1.0));
            least_squares::linear(rows, columns).filter(|_| blocks.len() > columns + 3)
        };
        let Some((_, _, mut rss)) = fit(1) else { return law };
        for order in 2..=3 {
            let Some((found, _, left)) = fit(order) else { break };
            let dof = (blocks.len() - order as usize - 1) as f64;
            if evidence::f_tail((rss - left) / (left / dof), 1.0, dof) < c.frequency_changes {
                law.omega = omega + found[1] / law.half;
                law.bend = [found[2], found.get(3).copied().unwrap_or(0.0)];
                rss = left;
            }
        }
        law
    }

    fn at(&self, time: f64) -> f64 {
        let u = time - self.middle;
        let v = u / self.half;
        self.omega * u + v * v * (self.bend[0] + v * self.bend[1])
    }

    /// Mean angular frequency over the stretch.
    pub(super) fn mean_omega(&self) -> f64 {
        self.omega + self.bend[1] / self.half
    }

    /// Root mean square deviation of the angular frequency from its mean.
    pub(super) fn wander(&self) -> f64 {
        // From c_2 2v + c_3 (3v² - 1) over -1..1, divided by the half length.
        let [b, c] = self.bend;
        (4.0 * b * b / 3.0 + 4.0 * c * c / 5.0).sqrt() / self.half
    }
}

/// Fit of a fundamental of known frequency, harmonics, offset and drift.
pub(super) struct Wave {
    /// Relative to the middle of the stretch, which is common to all waves of that stretch.
    pub(super) phasor: Phasor,
    /// Standard error of each of its quadratures.
    pub(super) std_error: f64,
    pub(super) offset: f64,
    pub(super) residual_rms: f64,
    pub(super) excess: f64,
    pub(super) middle: f64,
}

impl Wave {
    /// `None` if the samples do not determine it.
    pub(super) fn fit(time: &[f64], values: &[f64], law: &PhaseLaw, c: &Criteria) -> Option<Self> {
        let omega = law.mean_omega();
        let (first, last) = (*time.first()?, *time.last()?);
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let cycles = omega * (last - first) / TAU;
        let per_cycle = time.len() as f64 / cycles;
        // Enough samples are needed to separate harmonics from the fundamental, and enough cycles to separate them
        // from the drift.
        let harmonics = if cycles >= 3.0 && per_cycle >= 10.0 { 3 } else { 1 };
        let columns = 2 + 2 * harmonics;
        let row = |t: f64| {
            let u = t - middle;
            let mut row = Vec::with_capacity(columns);
            for n in 1..=harmonics {
                let (sin, cos) = (n as f64 * law.at(t)).sin_cos();
                row.extend([cos, sin]);
            }
            row.extend([1.0, u / half]);
            row
        };
        if time.len() <= columns || !(half > 0.0) {
            return None;
        }
        let rows = time.iter().zip(values).map(|(&t, &v)| (row(t), v, 1.0));
        let (found, covariance, rss) = least_squares::linear(rows, columns)?;
        let dof = (time.len() - columns) as f64;
        let variance = rss / dof;
        let residual =
            |i: usize| values[i] - row(time[i]).iter().zip(&found).map(|(a, b)| a * b).sum::<f64>();
        let residuals: Vec<f64> = (0..time.len()).map(residual).collect();
        let excess = excess(time, &residuals, omega, variance, c);
        let std_error = (0.5 * (covariance[(0, 0)] + covariance[(1, 1)]) * variance * excess).max(0.0).sqrt();
        Some(Self {
            phasor: Phasor::new(found[0], -found[1]),
            std_error,
            offset: found[columns - 2],
            residual_rms: variance.sqrt(),
            excess,
            middle,
        })
    }
}

/// Excess of the residuals at the frequency of the sine over white noise: variance of the phasors of single cycles
/// over the expected one.
fn excess(time: &[f64], residuals: &[f64], omega: f64, variance: f64, c: &Criteria) -> f64 {
    let Some(blocks) = super::settle::phasors(time, residuals, omega, c) else { return 1.0 };
    if blocks.len() < c.noise_blocks || variance <= 0.0 {
        return 1.0;
    }
    let n = blocks.len() as f64;
    let observed = blocks.iter().map(|b| b.phasor.norm_sqr()).sum::<f64>() / (2.0 * n);
    let expected = blocks.iter().map(|b| 2.0 * variance / b.samples as f64).sum::<f64>() / n;
    (observed / expected).max(1.0)
}

//! Residuals of a fitted motion: the fundamental of each block, the density of the noise, and harmonics.

use super::criteria::Criteria;
use super::envelope::{A0, law_of};
use super::wandering_phase::WanderingPhase;
use super::waveform::{OMEGA, Waveform};
use crate::inference::least_squares::Fit;
use crate::inference::noise::{autocorrelation, significant_inflation};
use crate::numeric::sum_of;
use crate::signal::blocks::{self, Block};
use crate::signal::noise_density::density_near;
use std::f64::consts::TAU;

/// Residual statistics of the blocks.
pub(super) struct Residuals {
    /// Residuals (data minus model), sample by sample.
    pub(super) residual: Vec<f64>,
    pub(super) in_phase: Fundamental,
    quadrature: Fundamental,
    /// Variance of the residuals.
    pub(super) variance: f64,
    /// Ratio of the spectral density of all residuals near the frequency of the motion to that of white
    /// noise, minus its standard error.
    coloured: f64,
    /// The same ratio for the second and third harmonic, from the density next to them.
    coloured_at_harmonics: f64,
    /// Variance of white noise with the spectral density that the residuals have at the lowest frequencies.
    pub(super) low_frequency: f64,
}

/// Residual fundamental of the blocks, in one phase.
pub(super) struct Fundamental {
    /// Ratio of its variance to that of white noise.
    pub(super) excess: f64,
    /// Degrees of freedom of that ratio.
    pub(super) freedom: f64,
    /// Autocorrelation between neighbouring blocks.
    pub(super) autocorrelation: f64,
    blocks: usize,
}

impl Fundamental {
    fn new(left: &[f64], variance: f64) -> Self {
        // The fitted parameters already absorbed their share of the variance of these blocks.
        let freedom = (left.len() as f64 - 3.0).max(1.0);
        Self {
            excess: left.iter().map(|s| s * s).sum::<f64>() / freedom / variance.max(f64::MIN_POSITIVE),
            freedom,
            autocorrelation: autocorrelation(left),
            blocks: left.len(),
        }
    }

    /// Factor by which the variance of the parameters exceeds that under white noise (variance inflation).
    fn variance_inflation(&self, significance: f64) -> f64 {
        let white = 1.0 + significance * (2.0 / self.blocks.max(1) as f64).sqrt();
        let excess = if self.excess > white { self.excess } else { 1.0 };
        excess * significant_inflation(self.autocorrelation, self.blocks, significance)
    }
}

impl Residuals {
    pub(super) fn new(problem: &Waveform, first: usize, fit: &Fit, points: &[Block]) -> Self {
        let residual = problem.residuals(&fit.parameters);
        let variance = fit.rss / (problem.counted() - fit.free.len() as f64).max(1.0);
        let (in_phase, quadrature): (Vec<f64>, Vec<f64>) =
            remaining_fundamental(problem, first, &residual, fit, points).into_iter().unzip();
        let density = density_near(problem.time, &residual, fit.parameters[OMEGA] / TAU);
        let coloured = density.map_or(0.0, |d| d.least_ratio());
        Self {
            in_phase: Fundamental::new(&in_phase, variance),
            quadrature: Fundamental::new(&quadrature, variance),
            variance,
            low_frequency: variance * density.map_or(0.0, |d| d.lowest),
            coloured,
            coloured_at_harmonics: density.map_or(0.0, |d| d.least_ratio_at_harmonics()),
            residual,
        }
    }

    /// [`variance_inflation`](Self::variance_inflation), including the effect of a wandering phase.
    pub(super) fn variance_inflation_with_walk(
        &self,
        wandering: Option<WanderingPhase>,
        criteria: &Criteria,
    ) -> f64 {
        let walked = wandering.map_or(1.0, |w| w.variance_ratio / self.variance.max(f64::MIN_POSITIVE));
        self.variance_inflation(criteria).max(walked)
    }

    /// Factor by which the variance of the parameters exceeds that under white noise (variance inflation).
    ///
    /// In few cycles a wandering phase biases the losses too: its excess variance is included if it is
    /// significant.
    fn variance_inflation(&self, criteria: &Criteria) -> f64 {
        let significance = criteria.inference.excess_significance;
        let in_phase = self.in_phase.variance_inflation(significance);
        let beyond_doubt =
            self.quadrature.variance_inflation(criteria.waveform.wandering_significance * significance);
        in_phase.max(beyond_doubt).max(self.coloured)
    }
}

/// Residual fundamental of each block inside the window that begins with sample `first`, in phase and in
/// quadrature, scaled such that white noise gives each component the variance of a sample.
pub(crate) fn remaining_fundamental(
    problem: &Waveform,
    first: usize,
    residual: &[f64],
    fit: &Fit,
    blocks: &[Block],
) -> Vec<(f64, f64)> {
    let inside = inside(first, residual.len(), blocks);
    let phases: Vec<_> = inside.iter().map(|b| problem.phase_at(&fit.parameters, b.time_s)).collect();
    blocks::demodulate(problem.time, residual, &inside, &phases)
        .iter()
        .map(|b| (b.amplitude / b.unit_variance.sqrt(), b.quadrature / b.unit_variance.sqrt()))
        .collect()
}

/// Blocks inside a window of `n` samples that begins with sample `first`, with indices relative to it.
fn inside(first: usize, n: usize, blocks: &[Block]) -> Vec<Block> {
    let within = blocks.iter().filter(|b| b.first >= first && b.end <= first + n);
    within.map(|b| Block { first: b.first - first, end: b.end - first, ..*b }).collect()
}

/// Residual harmonics of the motion, in standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Harmonics {
    /// Second and third harmonic in phase, with components that fall as the square and the cube of the
    /// amplitude.
    pub(crate) in_phase: [f64; 2],
    /// Third harmonic in quadrature with an amplitude that stays constant as the motion falls; zero if a
    /// proportional one fits better.
    pub(crate) steady: f64,
    /// The amplitude of the latter, in the unit of the signal.
    pub(crate) steady_amplitude: f64,
}

/// Residual harmonics of the motion; `None` if there are fewer than `samples_per_cycle` samples per cycle.
pub(super) fn harmonics(
    problem: &Waveform,
    first: usize,
    left: &Residuals,
    fit: &Fit,
    blocks: &[Block],
    samples_per_cycle: f64,
) -> Option<Harmonics> {
    let p = &fit.parameters;
    let n = left.residual.len();
    if problem.duration * p[OMEGA] / TAU * samples_per_cycle > n as f64 {
        return None;
    }
    let inside = inside(first, n, blocks);
    let law = law_of(p, p[OMEGA]);
    // Relative amplitude and residual harmonic, block by block.
    let order = |order: i32| {
        let times = f64::from(order);
        let multiple = |b: &Block| {
            let at = problem.phase_at(p, b.time_s);
            blocks::PhaseAt { phase: times * at.phase, omega: times * at.omega, ..at }
        };
        let phases: Vec<_> = inside.iter().map(multiple).collect();
        let relative = |b: &Block| law.amplitude(b.time_s - problem.origin) / p[A0];
        let left = blocks::demodulate(problem.time, &left.residual, &inside, &phases);
        left.into_iter().map(|b| (relative(&b), b)).collect::<Vec<(f64, Block)>>()
    };
    // Noise that is stronger at low frequencies, or at large amplitudes, produces apparent harmonics.
    let coloured = left.coloured_at_harmonics.max(1.0);
    let variance_in = |b: &Block| {
        let residual = &left.residual[b.first..b.end];
        sum_of(residual, |r| r * r) / residual.len().max(1) as f64
    };
    // The component proportional to a power of the amplitude, and its standard error.
    let part = |blocks: &[(f64, Block)], power: i32, of: fn(&Block) -> f64| {
        let (mut along, mut square, mut scatter) = (0.0, 0.0, 0.0);
        for (relative, b) in blocks {
            let weight = relative.powi(2 * power) / b.unit_variance;
            along += of(b) * relative.powi(power) / b.unit_variance;
            square += weight;
            scatter += weight * variance_in(b);
        }
        (along / square, (coloured * scatter.max(left.variance * square)).sqrt() / square)
    };
    let [second, third] = [order(2), order(3)];
    let in_phase = [(&second, 2), (&third, 3)].map(|(blocks, power)| {
        let (value, error) = part(blocks, power, |b| b.amplitude);
        value / error
    });
    let [steady, in_proportion] = [0, 1].map(|power| part(&third, power, |b| b.quadrature));
    let [errors, other] = [steady, in_proportion].map(|(value, error)| (value / error).abs());
    let found = Harmonics {
        in_phase,
        steady: if errors > other { errors } else { 0.0 },
        steady_amplitude: steady.0.abs(),
    };
    (in_phase[0] + in_phase[1] + errors + other).is_finite().then_some(found)
}

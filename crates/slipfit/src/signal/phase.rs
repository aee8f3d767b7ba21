//! Fit of one smooth phase to the phases of the blocks.
//!
//! With a smooth phase the amplitude can be computed as a signed projection: its mean remains the amplitude however
//! weak the signal, whereas the modulus has the Rice bias `E[R²] = A² + 2 sigma²`.

use super::blocks::{Block, PhaseAt};
use super::criteria::PhaseCriteria;
use super::phase_walk::{PhaseError, Smoothed, walk_rate};
use crate::inference::evidence::bic;
use crate::inference::least_squares::{Normal, linear, linear_of};
use crate::inference::noise::{ar1_variance_inflation, autocorrelation};
use crate::numeric::robust::median;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Dependence of the phase on time and amplitude: `phi = p0 + w (tau + c2 I2 + c4 I4 + d (tau - T/2)²/2)`, where
/// `I_k` is the integral of `A^k`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PhaseLaw {
    /// Angular frequency at vanishing amplitude, in the middle of the stretch, rad/s.
    pub(crate) omega: f64,
    /// Mean angular frequency over the stretch, the correction to it from weights that include a random walk, and the
    /// standard error of both.
    pub(crate) mean_omega: f64,
    pub(crate) mean_omega_walk_correction: f64,
    pub(crate) mean_omega_std: f64,
    pub(crate) quadratic: f64,
    pub(crate) quartic: f64,
    pub(crate) drift: f64,
    /// Whether a drift or a walk changes the frequency by more than a small part of the change due to the amplitude.
    pub(crate) wanders: bool,
    /// Variance added to the phase per second by a random walk, rad²/s; zero if none is detected.
    pub(crate) walk: f64,
    /// The same, limited to the part within cycles, which affects amplitudes.
    pub(crate) walk_in_cycles: f64,
}

impl PhaseLaw {
    /// Frequency shift by the amplitude as it also changes the loss. With a drift in time or a walk of similar size,
    /// the shift may be part of that, and none is assumed.
    pub(crate) fn backbone(&self) -> [f64; 2] {
        if self.wanders { [0.0; 2] } else { [self.quadratic, self.quartic] }
    }

    /// Reference angular frequency of amplitude laws and derivatives, rad/s: that at vanishing amplitude, or the mean
    /// if a drift or a walk makes it uncertain.
    pub(crate) fn reference_omega(&self) -> f64 {
        if self.wanders { self.mean_omega } else { self.omega }
    }

    /// Relative change of frequency at an amplitude.
    pub(crate) fn shift(&self, amplitude: f64) -> f64 {
        let s = amplitude * amplitude;
        s * (self.quadratic + s * self.quartic)
    }
}

/// Smooth phases at the blocks and the phase law.
#[derive(Debug, Clone)]
pub(crate) struct Smooth {
    pub(crate) at: Vec<PhaseAt>,
    pub(crate) law: PhaseLaw,
    /// Whether the law holds; otherwise the phase was smoothed locally.
    pub(crate) follows_law: bool,
}

/// Inverse variance of the phase of a block. The accuracy is limited to 1e-4 rad, because the exact motion itself
/// shifts the phase by x_F/A.
pub(crate) fn phase_weight(block: &Block, noise_rms: f64) -> f64 {
    let variance = block.unit_variance * noise_rms * noise_rms;
    let strength = block.amplitude.hypot(block.quadrature);
    1.0 / (variance / (strength * strength).max(f64::MIN_POSITIVE) + 1e-8)
}

/// Fits backbone laws of increasing complexity to the phases of `blocks`, selects one by the BIC, and falls back to
/// local smoothing if none holds.
///
/// `amplitude` is a smooth amplitude at the blocks, `noise_rms` the noise of one sample.
pub(crate) fn smooth(
    blocks: &[Block],
    amplitude: &[f64],
    noise_rms: f64,
    criteria: &PhaseCriteria,
) -> Option<Smooth> {
    let origin = blocks.first()?.time_s;
    let span = (blocks.last()?.time_s - origin).max(f64::MIN_POSITIVE);
    let tau: Vec<f64> = blocks.iter().map(|b| b.time_s - origin).collect();
    let scale = amplitude.iter().fold(0.0f64, |m, a| m.max(a.abs())).max(f64::MIN_POSITIVE);
    let square = integral(&tau, amplitude, |a| (a / scale).powi(2));
    let fourth = integral(&tau, amplitude, |a| (a / scale).powi(4));
    let weight: Vec<f64> = blocks.iter().map(|b| phase_weight(b, noise_rms)).collect();
    let mut phase: Vec<f64> = blocks.iter().map(|b| b.phase).collect();
    let omega_0 = {
        let total: f64 = weight.iter().sum();
        blocks.iter().zip(&weight).map(|(b, w)| b.omega * w).sum::<f64>() / total
    };
    let at = |j: usize, column: Column| match column {
        Column::One => 1.0,
        Column::Time => tau[j] / span,
        Column::Square => square[j] / span,
        Column::Fourth => fourth[j] / span,
        Column::Chirp => (tau[j] / span - 0.5).powi(2),
    };
    let row = |j: usize, columns: &[Column]| -> Vec<f64> { columns.iter().map(|c| at(j, *c)).collect() };
    // Only strong blocks are used: a weak one may be wrong by a turn, and an isolated strong one among weak ones is
    // noise.
    let is_strong = |j: usize| weight.get(j).is_some_and(|w| *w > criteria.least_weight);
    let beside_strong = |j: usize| j > 0 && is_strong(j - 1) || is_strong(j + 1);
    let strong: Vec<usize> = (0..blocks.len()).filter(|&j| is_strong(j) && beside_strong(j)).collect();
    if strong.len() < 2 {
        return None;
    }
    unslip(&mut phase, &tau, &weight, span, criteria.sure_weight);
    // Phases of thousands of turns are known to a ten-thousandth of a turn: the rounding of their squares would swamp
    // the residuals. Therefore a straight line is subtracted first, and the residuals of each law are summed
    // directly.
    let line = linear(strong.iter().map(|&j| (row(j, MODELS[0]), phase[j], weight[j])), MODELS[0].len())?.0;
    let rows: Vec<_> = strong.iter().map(|&j| EVERY.map(|column| at(j, column))).collect();
    let above: Vec<f64> = strong.iter().map(|&j| phase[j] - model_at(&row(j, MODELS[0]), &line)).collect();
    let mut sums = Normal::zeros(EVERY.len());
    for ((values, above), &j) in rows.iter().zip(&above).zip(&strong) {
        sums.add_row(values, *above, weight[j]);
    }
    let left_of = |c: &[f64], places: &[usize]| -> f64 {
        let left = rows.iter().zip(&above).zip(&strong).map(|((values, above), &j)| {
            let model: f64 = places.iter().zip(c).map(|(&k, c)| values[k] * c).sum();
            weight[j] * (above - model).powi(2)
        });
        left.sum()
    };
    let mut best: Option<Candidate> = None;
    for columns in MODELS {
        if strong.len() < columns.len() + 2 && columns.len() > 2 {
            continue;
        }
        let places: Vec<usize> = columns.iter().map(|c| *c as usize).collect();
        let Some((mut c, covariance, _)) = linear_of(&sums, &places) else { continue };
        let rss = left_of(&c, &places);
        c.iter_mut().zip(&line).for_each(|(c, line)| *c += line);
        let n = strong.len() as f64;
        // The noise and thus the scale is known: chi-squared is used, not its logarithm, unless the residuals exceed
        // it.
        let score =
            bic(rss.max(n), n, n, columns.len()) + if columns.len() > 2 { criteria.bic_price } else { 0.0 };
        if best.as_ref().is_none_or(|b| score < b.score) {
            best = Some(Candidate { score, columns, c, covariance, rss });
        }
    }
    let Candidate { columns, c, covariance, rss, .. } = best?;
    let n = strong.len() as f64;
    let excess = rss / (n - columns.len() as f64).max(1.0);
    let mean_square = rss / strong.iter().map(|&j| weight[j]).sum::<f64>();
    let model: Vec<f64> = (0..blocks.len()).map(|j| model_at(&row(j, columns), &c)).collect();
    for (p, m) in phase.iter_mut().zip(&model) {
        *p += TAU * ((m - *p) / TAU).round();
    }
    let left: Vec<f64> = phase.iter().zip(&model).map(|(p, m)| p - m).collect();
    // The error of a phase with a random walk grows with time.
    let residuals: Vec<f64> = strong.iter().map(|&j| (phase[j] - model[j]) * weight[j].sqrt()).collect();
    let scatters_little = excess < criteria.most_excess;
    let inflation =
        if scatters_little { 1.0 } else { ar1_variance_inflation(autocorrelation(&residuals).max(0.0)) };
    let errors: Vec<PhaseError> = strong
        .iter()
        .map(|&j| PhaseError {
            time_s: blocks[j].time_s,
            error: phase[j] - model[j],
            weight: weight[j],
            averaged_s: blocks[j].span_s / 6.0,
            smooth: row(j, columns),
        })
        .collect();
    let every = errors.iter().zip(&strong).map(|(e, &j)| PhaseError { smooth: row(j, &WIDEST), ..e.clone() });
    let is_selected = |k: usize| columns.contains(&WIDEST[k]);
    let walk = walk_rate(&every.collect::<Vec<_>>(), is_selected, criteria.walk_errors).unwrap_or(0.0);
    let get = |which: Column| columns.iter().position(|&x| x == which).map_or(0.0, |i| c[i]);
    let omega = get(Column::Time) / span;
    // Mean frequency over the stretch: the difference of two phases, each a combination of the coefficients.
    let last = blocks.len() - 1;
    let across: Vec<f64> = row(last, columns).iter().zip(row(0, columns)).map(|(a, b)| a - b).collect();
    let across_variance: f64 = (0..columns.len())
        .flat_map(|i| (0..columns.len()).map(move |k| (i, k)))
        .map(|(i, k)| across[i] * across[k] * covariance[(i, k)])
        .sum();
    // With weights that include the walk, the mean frequency is that from the first phase to the last.
    let with_walk = if walk > 0.0 { Smoothed::with_walk(&errors, walk) } else { None };
    let walked = with_walk.map(|smoothed| smoothed.combined(&DVector::from_column_slice(&across)));
    let (further, variance) = walked.unwrap_or((0.0, across_variance.max(0.0) * excess.max(1.0) * inflation));
    let shift = (get(Column::Square) + get(Column::Fourth)) / span / omega;
    let drift = 2.0 * get(Column::Chirp) / (span * span) / omega;
    // Changes over the stretch.
    let other = (drift * span).hypot((walk / span).sqrt() / omega);
    let law = PhaseLaw {
        omega,
        mean_omega: (model_at(&row(last, columns), &c) - model_at(&row(0, columns), &c)) / span,
        mean_omega_walk_correction: further / span,
        mean_omega_std: variance.max(0.0).sqrt() / span,
        quadratic: get(Column::Square) / span / omega / (scale * scale),
        quartic: get(Column::Fourth) / span / omega / scale.powi(4),
        drift,
        wanders: other != 0.0 && !(other < criteria.most_other * shift.abs()),
        walk,
        walk_in_cycles: walk,
    };
    // A phase error e reduces the amplitude by e²/2, which is tolerable as long as it stays below the noise.
    let mut errors: Vec<f64> = weight.iter().map(|w| 1.0 / w.sqrt()).collect();
    let typical_noise = median(&mut errors)?;
    let follows_law = omega > 0.0
        && (omega / omega_0 - 1.0).abs() < criteria.off_frequency
        && (scatters_little
            || 0.5 * mean_square < criteria.amplitude_cost * typical_noise
            || lags_by_friction(&strong, |j| row(j, columns), &left, [&weight, amplitude], criteria));
    // The loss of amplitude is compared with the errors of all amplitudes together.
    let lost: f64 = strong
        .iter()
        .map(|&j| weight[j] * (0.5 * ((phase[j] - model[j]).powi(2) - 1.0 / weight[j])).powi(2))
        .sum();
    let at = if follows_law && (scatters_little || lost < criteria.most_lost) {
        (0..blocks.len())
            .map(|j| {
                let a = amplitude[j];
                PhaseAt {
                    phase: model[j],
                    omega: omega * (1.0 + law.shift(a) + law.drift * (tau[j] - 0.5 * span)),
                    chirp: 0.0,
                    loss: 0.0,
                }
            })
            .collect()
    } else {
        local(&tau, &phase, &weight, criteria.smoothed_weight)
    };
    Some(Smooth { at, law, follows_law })
}

/// Whether phases follow the law (with residuals `left`), apart from the lag due to sliding friction. The equilibrium
/// position is displaced by `x_F` against the motion, so that the fundamental lags by `3/pi x_F/A` to first order;
/// terms of second order, large in the last swings before rest, count as an error of the phase. The last block may
/// contain the rest and have no phase.
fn lags_by_friction(
    strong: &[usize],
    row: impl Fn(usize) -> Vec<f64>,
    left: &[f64],
    [weight, amplitude]: [&[f64]; 2],
    criteria: &PhaseCriteria,
) -> bool {
    let row = |j: usize| [row(j), vec![1.0 / amplitude[j].abs()]].concat();
    let count = strong.first().map_or(0, |&j| row(j).len());
    let given = |blocks: &[usize], lag: f64| {
        let known_to = |j: usize| weight[j] / (1.0 + weight[j] * (lag / amplitude[j]).powi(4));
        linear(blocks.iter().map(|&j| (row(j), left[j], known_to(j))), count)
    };
    let lag = |c: &[f64]| c.last().copied().filter(|lag| *lag < 0.0);
    let lags = |blocks: &[usize]| {
        let beside_lag = given(blocks, 0.0).and_then(|(c, ..)| given(blocks, lag(&c)?));
        let dof = blocks.len() as f64 - count as f64;
        let most = criteria.most_excess * dof;
        dof >= 1.0 && beside_lag.is_some_and(|(c, _, rss)| lag(&c).is_some() && rss < most)
    };
    lags(strong) || strong.split_last().is_some_and(|(_, before)| lags(before))
}

/// Corrects turns lost in the noise: a line through the most accurate half of the phases so far predicts the next
/// ones.
fn unslip(phase: &mut [f64], tau: &[f64], weight: &[f64], span: f64, sure_weight: f64) {
    let n = phase.len();
    let sure = weight.iter().position(|&w| w < sure_weight).unwrap_or(n);
    let mut known = sure.max(4.min(n));
    while known < n {
        let from = known - (known / 2).clamp(4.min(known), 60);
        let rows = (from..known).map(|j| (vec![1.0, tau[j] / span], phase[j], weight[j].max(1.0)));
        let next = (known + (known / 4).clamp(1, 20)).min(n);
        if let Some((c, _, _)) = linear(rows, 2) {
            for j in known..next {
                let expected = c[0] + c[1] * tau[j] / span;
                phase[j] += TAU * ((expected - phase[j]) / TAU).round();
            }
        }
        known = next;
    }
}

fn model_at(row: &[f64], c: &[f64]) -> f64 {
    row.iter().zip(c).map(|(x, y)| x * y).sum()
}

/// One law fitted to the phases.
struct Candidate {
    score: f64,
    columns: &'static [Column],
    c: Vec<f64>,
    covariance: nalgebra::DMatrix<f64>,
    rss: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    One,
    Time,
    Square,
    Fourth,
    Chirp,
}

/// All columns, in order.
const EVERY: [Column; 5] = [Column::One, Column::Time, Column::Square, Column::Fourth, Column::Chirp];

/// Columns that are free while the random walk of the phase is estimated.
const WIDEST: [Column; 4] = [Column::One, Column::Time, Column::Square, Column::Chirp];

/// Each begins with a straight line.
const MODELS: [&[Column]; 5] = [
    &[Column::One, Column::Time],
    &[Column::One, Column::Time, Column::Square],
    &[Column::One, Column::Time, Column::Chirp],
    &[Column::One, Column::Time, Column::Square, Column::Fourth],
    &[Column::One, Column::Time, Column::Square, Column::Chirp],
];

/// Running integral of `f(amplitude)` over time, by the trapezoidal rule.
fn integral(tau: &[f64], amplitude: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for j in 1..tau.len() {
        sum += 0.5 * (f(amplitude[j - 1]) + f(amplitude[j])) * (tau[j] - tau[j - 1]);
        out.push(sum);
    }
    out
}

/// Weighted parabola through as many neighbours as have the required total weight.
fn local(tau: &[f64], phase: &[f64], weight: &[f64], enough: f64) -> Vec<PhaseAt> {
    let n = tau.len();
    (0..n)
        .map(|j| {
            let mut reach = 2;
            loop {
                let (a, b) = (j.saturating_sub(reach), (j + reach + 1).min(n));
                if weight[a..b].iter().sum::<f64>() > enough || (a == 0 && b == n) {
                    break;
                }
                reach += 1;
            }
            let (mut a, mut b) = (j.saturating_sub(reach), (j + reach + 1).min(n));
            // One-sided at the ends, but with the same number of points.
            if a == 0 {
                b = (2 * reach + 1).min(n);
            }
            if b == n {
                a = n.saturating_sub(2 * reach + 1);
            }
            let fit = |columns: usize| {
                linear(
                    (a..b).map(|i| {
                        let d = tau[i] - tau[j];
                        (vec![1.0, d, d * d][..columns].to_vec(), phase[i] - phase[j], weight[i])
                    }),
                    columns,
                )
            };
            match fit(3).or_else(|| fit(2)) {
                Some((c, _, _)) => PhaseAt {
                    phase: phase[j] + c[0],
                    omega: c[1],
                    chirp: c.get(2).map_or(0.0, |q| 2.0 * q),
                    loss: 0.0,
                },
                None => PhaseAt { phase: phase[j], omega: f64::NAN, chirp: 0.0, loss: 0.0 },
            }
        })
        .collect()
}

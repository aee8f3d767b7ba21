//! Effect of a randomly walking phase on the parameters of the exact motion.

use super::envelope::{A0, DELTA, X_F};
use super::waveform::{BACKBONE, OMEGA, PHASE, PHASE_SLOTS, PhaseSums, Waveform};
use crate::inference::least_squares::Fit;
use crate::signal::criteria::PhaseCriteria;
use crate::signal::phase_walk::{PhaseError, Smoothed, walk_rate};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Maximum number of phases used.
const MOST_PHASES: f64 = 160.0;
/// Minimum number of samples for the phase of a stretch.
const LEAST_SAMPLES: usize = 3;
/// Number of walk steps per cycle, and maximum in all, whose effect is summed: loss and friction respond to
/// steps within a cycle.
const STEPS_PER_CYCLE: f64 = 8.0;
const MOST_STEPS: usize = 384;

/// Effect of a random walk on a least-squares fit whose weights ignore it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WanderingPhase {
    /// Correction to the mean rate of the phase, rad/s, by a fit that accounts for the walk, and the variance
    /// of that rate.
    pub(crate) mean_rate: f64,
    pub(crate) rate_variance: f64,
    /// Largest ratio, over the losses and the amplitude, of the variance including the walk to that of the
    /// unit covariance.
    pub(crate) variance_ratio: f64,
}

impl WanderingPhase {
    /// `None` if the phases of the window show no walk in addition to white noise of `noise_rms` per sample.
    ///
    /// A step of the walk at `t_k` shifts all later samples by `dx/dphi`, and the parameters by
    /// `(JᵀJ)⁻¹ g_k`, with `g_k` the sum of `J dx/dphi` from `t_k` on; the steps are independent of each
    /// other.
    pub(crate) fn of(
        problem: &Waveform,
        fit: &Fit,
        noise_rms: f64,
        criteria: &PhaseCriteria,
    ) -> Option<Self> {
        let p = &fit.parameters;
        let moving_s = problem.moving_s(p);
        let errors = phase_errors(problem, fit, [noise_rms, moving_s], criteria.least_weight);
        let slots = smooth_slots(problem);
        // The offset is the last of the smooth parameters.
        let selected = |k: usize| slots.get(k).is_none_or(|slot| fit.free.contains(slot));
        let rate = walk_rate(&errors, selected, criteria.walk_errors)?;
        let mean = problem.mean_rate(p);
        let of_slot = |slot: &usize| mean.iter().find(|(k, _)| k == slot).map_or(0.0, |(_, d)| *d);
        // The offset does not contribute to the rate.
        let across: Vec<f64> = slots.iter().map(of_slot).chain([0.0]).collect();
        let (mean_rate, rate_variance) =
            Smoothed::with_walk(&errors, rate)?.combined(&DVector::from_vec(across));
        let cycles = moving_s * p[OMEGA] / TAU;
        let steps = ((STEPS_PER_CYCLE * cycles).ceil() as usize).clamp(2, MOST_STEPS);
        let free = &fit.free;
        let covariance =
            DMatrix::from_fn(free.len(), free.len(), |i, j| fit.unit_covariance[(free[i], free[j])]);
        let step_s = moving_s / steps as f64;
        let at_step = |k: usize| problem.time.partition_point(|t| *t < problem.origin + k as f64 * step_s);
        let borders: Vec<usize> = (1..steps).map(at_step).collect();
        let mut after = DVector::zeros(free.len());
        let mut variance = DMatrix::zeros(free.len(), free.len());
        for part in problem.along_phase(p, free, &borders)?.iter().skip(1).rev() {
            after += part;
            let moved = &covariance * &after;
            variance += &moved * moved.transpose() * (rate * step_s);
        }
        let at = |slot: usize| free.iter().position(|f| *f == slot);
        let white = noise_rms * noise_rms;
        let variance_ratio = [A0, X_F, DELTA]
            .into_iter()
            .filter_map(at)
            .map(|i| white + variance[(i, i)] / covariance[(i, i)].max(f64::MIN_POSITIVE))
            .fold(white, f64::max);
        Some(Self { mean_rate, rate_variance, variance_ratio })
    }
}

/// The phase parameters that are free while the random walk is estimated: all of them, since those selected
/// have already absorbed part of the walk.
fn smooth_slots(problem: &Waveform) -> Vec<usize> {
    PHASE_SLOTS.into_iter().filter(|slot| *slot != BACKBONE || problem.backbone.is_some()).collect()
}

/// Phase residuals of every half cycle, or of groups of whole cycles such that there are at most
/// [`MOST_PHASES`]: the projection of the residuals on `dx/dphi`.
///
/// An offset appears as a phase change that alternates between half cycles.
fn phase_errors(
    problem: &Waveform,
    fit: &Fit,
    [noise_rms, moving_s]: [f64; 2],
    least_weight: f64,
) -> Vec<PhaseError> {
    let p = &fit.parameters;
    let half_s = PI / p[OMEGA];
    let halves = moving_s / half_s;
    let per_phase = if halves <= MOST_PHASES { 1.0 } else { 2.0 * (0.5 * halves / MOST_PHASES).ceil() };
    let averaged = if per_phase == 1.0 { WITHIN_HALF_CYCLE } else { 1.0 / 6.0 };
    let smooth = smooth_slots(problem);
    let phase = (p[PHASE] + problem.observable.phase_lead()) / PI;
    let turn = phase.ceil() - phase;
    let mut errors = Vec::new();
    let count = ((moving_s - turn * half_s) / (per_phase * half_s)).floor();
    // A motion whose phase does not advance has no phase residuals.
    if !(half_s > 0.0 && (1.0..=MOST_PHASES).contains(&count)) {
        return errors;
    }
    let border_s = |k: usize| problem.origin + (turn + k as f64 * per_phase) * half_s;
    let border = |k: usize| problem.time.partition_point(|t| *t < border_s(k));
    let borders: Vec<usize> = (0..=count as usize).map(border).collect();
    let Some(parts) = problem.sums_by_phase(p, &borders) else { return errors };
    for (k, part) in parts.iter().enumerate().skip(1).take(count as usize) {
        let (first, end) = (borders[k - 1], borders[k]);
        let time_s = 0.5 * (border_s(k - 1) + border_s(k));
        let PhaseSums { along, offset, square } = *part;
        let weight = square / (noise_rms * noise_rms);
        let error = along / square;
        if end - first >= LEAST_SAMPLES && weight > least_weight && weight.is_finite() && error.is_finite() {
            let mut smooth = problem.phase_by(p, &smooth, time_s);
            smooth.push(offset / square);
            errors.push(PhaseError {
                time_s,
                error,
                weight,
                averaged_s: averaged * per_phase * half_s,
                smooth,
            });
        }
    }
    errors
}

/// Integral of `F (1 - F)`, with `F` the cumulative weight `u - sin(2 pi u)/(2 pi)` of the phases within a
/// half cycle.
const WITHIN_HALF_CYCLE: f64 = 0.103;

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::Options;
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::TAU;

    /// A phase that walks by 0.3 rad over the record: each interval must cover the true value.
    #[test]
    fn a_walking_phase_leaves_the_intervals_right() {
        let oscillator = Oscillator::kinematic(TAU * 1.7, 0.178, 0.00655).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let record = |seed: usize| {
            let time_s: Vec<f64> = (0..716).map(|i| f64::from(i) / 51.0).collect();
            let step = 0.3 / (time_s.len() as f64).sqrt();
            let mut phase = 0.0;
            let at = |(i, &t): (usize, &f64)| {
                phase += step * jitter(1000 * seed + i, 1);
                decay.displacement((t + phase / oscillator.omega_d()).max(0.0))
                    + 0.01 * jitter(1000 * seed + i, 2)
            };
            let signal = time_s.iter().enumerate().map(at).collect();
            Record::new(time_s, signal).expect("valid")
        };
        let truths = [
            (Parameter::Frequency, oscillator.omega_d() / TAU),
            (Parameter::DECAY_RATE, 0.178),
            (Parameter::FRICTION_DISPLACEMENT, 0.00655),
        ];
        for (parameter, truth) in truths {
            assert_held(record, &Options::default(), parameter, truth);
        }
    }
}

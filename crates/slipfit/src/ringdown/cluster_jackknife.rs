//! Variance of the losses between cycles, by the [jackknife](crate::inference::jackknife).

use super::envelope::{A0, DELTA, EnvelopeProblem, X_F};
use super::waveform::{OMEGA, RestLevel, Waveform};
use crate::inference::jackknife::{Cluster, MOST_CLUSTERS, variance_inflation};
use crate::inference::least_squares::Fit;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Positions, among the free parameters, of those whose variance is examined.
fn examined_parameters(fit: &Fit) -> Vec<usize> {
    [A0, X_F, DELTA].iter().filter_map(|slot| fit.free.iter().position(|f| f == slot)).collect()
}

/// Variance inflation from the scatter between cycles (or clusters of cycles, and the rest): the largest
/// ratio, over loss and amplitude, to the variance under white noise of `variance` per sample; 1 if it is not
/// significantly larger.
pub(super) fn inflation_of_samples(problem: &Waveform, fit: &Fit, variance: f64, significance: f64) -> f64 {
    let (p, free) = (&fit.parameters, &fit.free);
    let moving_s = problem.moving_s(p);
    let count = (moving_s * p[OMEGA] / TAU).round().min(MOST_CLUSTERS as f64);
    let cluster_s = moving_s / count;
    let at = |time_s: f64| problem.time.partition_point(|t| *t < problem.origin + time_s);
    let borders: Vec<usize> = (1..=count as usize).map(|k| at(k as f64 * cluster_s)).collect();
    let Some(mut parts) = problem.sums_of_parts(p, free, &borders) else { return 1.0 };
    // A rest with its own level carries no information about the motion.
    if problem.rest != RestLevel::Exact {
        parts.truncate(borders.len());
    }
    let clusters: Vec<Cluster> = parts.iter().map(|rows| Cluster::from_rows(free.len(), rows)).collect();
    variance_inflation(&clusters, &examined_parameters(fit), variance, significance)
}

/// The same for amplitudes, with `variance` at weight 1.
pub(super) fn inflation_of_amplitudes(
    problem: &EnvelopeProblem,
    fit: &Fit,
    variance: f64,
    significance: f64,
) -> f64 {
    let free = &fit.free;
    let points: Vec<(DVector<f64>, f64)> = problem
        .predictions(fit)
        .into_iter()
        .zip(&problem.weight)
        .map(|((left, by), weight)| {
            let root = weight.sqrt();
            (DVector::from_fn(free.len(), |k, _| root * by[free[k]]), root * left)
        })
        .collect();
    let together = points.len().div_ceil(MOST_CLUSTERS);
    let clusters: Vec<Cluster> = points
        .chunks(together.max(1))
        .map(|points| Cluster::from_observations(free.len(), points.iter().cloned()))
        .collect();
    variance_inflation(&clusters, &examined_parameters(fit), variance, significance)
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::Options;
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::{PI, TAU};

    fn assert_losses_held(q: f64, share: f64, record: impl Fn(&FreeDecay, usize) -> Record) {
        let delta = PI / q;
        let x_f = share / (1.0 - share) * delta / 4.0;
        let oscillator = Oscillator::kinematic(TAU, delta, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        for (parameter, truth) in [(Parameter::DECAY_RATE, delta), (Parameter::FRICTION_DISPLACEMENT, x_f)] {
            assert_held(|repeat| record(&decay, repeat), &Options::default(), parameter, truth);
        }
    }

    /// An encoder without noise reads the motion to its end and part of the rest; the first amplitude is 300
    /// steps.
    #[test]
    fn steps_without_noise_leave_the_intervals_right() {
        assert_losses_held(60.0, 0.5, |decay, repeat| {
            let end_s = 1.2 * decay.stop().expect("stops").time_s;
            let zero = (0.377 * repeat as f64).fract();
            let rate = 61.0 + repeat as f64;
            let read = |i: usize| (300.0 * decay.displacement(i as f64 / rate) + zero).round() / 300.0;
            Record::uniform(rate, (0..(rate * end_s) as usize).map(read).collect()).expect("valid")
        });
    }

    /// Noise thirty times as large at the start of the motion.
    #[test]
    fn noise_that_is_louder_at_the_start_leaves_the_intervals_right() {
        assert_losses_held(250.0, 0.3, |decay, repeat| {
            const N: usize = 4000;
            let noisy = |i: usize| {
                let t = i as f64 / 41.0;
                let noise = 0.005 * (1.0 + 29.0 * (-t / 5.0).exp());
                decay.displacement(t) + noise * jitter(repeat * N + i, 13)
            };
            Record::uniform(41.0, (0..N).map(noisy).collect()).expect("valid")
        });
    }
}

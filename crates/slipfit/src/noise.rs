//! Tools for unit tests: noise with the same values on every platform, records repeated with it, and motions under
//! any force.

use crate::ringdown::{Options, analyse};
use crate::{Parameter, Record};

/// Fails if more than four of 24 intervals miss the true value; 95 % intervals do so once in 200 times.
pub(crate) fn assert_held(
    record: impl Fn(usize) -> Record,
    options: &Options,
    parameter: Parameter,
    truth: f64,
) {
    let misses = |repeat: &usize| {
        let answer = analyse(&record(*repeat), options).expect("fits");
        let found = answer.parameter(parameter).expect("always reported");
        !(found.interval_95[0]..=found.interval_95[1]).contains(&truth)
    };
    let missed: Vec<usize> = (0..24).filter(misses).collect();
    assert!(missed.len() <= 4, "missed {truth} in records {missed:?} of 24");
}

/// Number `i` of sequence `k`, a sum of twelve uniform numbers: close to normal out to three standard deviations.
pub(crate) fn jitter(i: usize, k: u64) -> f64 {
    (0..12u64)
        .map(|j| {
            let x = (i as u64 * 12 + j + 1)
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(k.wrapping_mul(1_442_695_040_888_963_407));
            let x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            ((x ^ (x >> 32)) >> 11) as f64 / (1u64 << 53) as f64
        })
        .sum::<f64>()
        - 6.0
}

/// Displacement and velocity at `n` times `dt` apart of a mass released at `start` under a force `force(x, v)` over
/// the mass, by the classical Runge-Kutta rule with `parts` parts per step.
pub(crate) fn motion(
    force: impl Fn(f64, f64) -> f64,
    start: f64,
    n: usize,
    dt: f64,
    parts: usize,
) -> Vec<[f64; 2]> {
    let h = dt / parts as f64;
    let part = |[x, v]: [f64; 2]| {
        let (k1, l1) = (v, force(x, v));
        let (k2, l2) = (v + 0.5 * h * l1, force(x + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, force(x + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, force(x + h * k3, v + h * l3));
        [x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), v + h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4)]
    };
    let next = |state: &[f64; 2]| Some((0..parts).fold(*state, |state, _| part(state)));
    std::iter::successors(Some([start, 0.0]), next).take(n).collect()
}

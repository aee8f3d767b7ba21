//! Noise for unit tests, the same numbers wherever they run, and records repeated with it.

use crate::ringdown::{Options, analyse};
use crate::{Parameter, Record};

/// Fails where more than four of 24 intervals miss the truth, as 95 % intervals do once in 200 times.
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

/// Number `i` of sequence `k`, a sum of twelve even ones: as good as normal out to three
/// deviations.
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

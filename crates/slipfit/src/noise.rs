//! Noise for unit tests: the same numbers wherever they run.

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

//! Hostile numbers through every analysis: an answer of finite numbers or an error, never a panic.
//!
//! `PROPTEST_CASES` sets how many cases each test takes; the same generator is driven by coverage in
//! `cargo xtask fuzz --only ringdown,resonance,levels,series`.

mod hostile;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// As many cases as are asked for, others in every run; else these, the same in every run.
fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok());
    let rng_seed = if asked.is_some() { RngSeed::Random } else { RngSeed::Fixed(1) };
    ProptestConfig {
        cases: asked.unwrap_or(usual),
        rng_seed,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Bytes that libFuzzer found: a Q too small for a number.
#[test]
fn what_the_fuzzer_found_is_refused() {
    let mut found = vec![0xd3, 0x01, 0x00, 0xc5];
    found.extend([0xff; 27]);
    found.extend([0x00, 0xfc, 0x00]);
    found.extend([0x0a; 70]);
    found.extend([0x00, 0xbc]);
    hostile::levels(&found);
}

fn bytes() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..400)
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn ring_downs(bytes in bytes()) {
        hostile::ringdown(&bytes);
    }

    #[test]
    fn drive_levels(bytes in bytes()) {
        hostile::levels(&bytes);
    }
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn resonance_curves(bytes in bytes()) {
        hostile::resonance(&bytes);
    }

    #[test]
    fn series_of_measurements(bytes in bytes()) {
        hostile::series(&bytes);
    }
}

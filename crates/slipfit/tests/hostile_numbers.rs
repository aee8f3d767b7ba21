//! Hostile numbers through every analysis: an answer of finite numbers or an error, never a panic.
//!
//! `PROPTEST_CASES` sets the number of cases per test, `PROPTEST_RNG_SEED` selects them; the same generator is driven
//! by coverage in `cargo xtask fuzz --only ringdown,resonance,levels,series`.

mod hostile;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The requested number of cases, different in every run unless their seed is named; by default this number, the same
/// in every run.
fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok());
    let default = ProptestConfig::default();
    let rng_seed = if asked.is_some() { default.rng_seed } else { RngSeed::Fixed(1) };
    ProptestConfig { cases: asked.unwrap_or(usual), rng_seed, failure_persistence: None, ..default }
}

/// Bytes that libFuzzer found.
#[test]
fn what_the_fuzzer_found_is_answered_or_refused() {
    let bytes = |digits: &str| -> Vec<u8> {
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("text"), 16);
        digits.as_bytes().chunks(2).map(|pair| byte(pair).expect("digits")).collect()
    };
    // A Q too small to represent.
    hostile::levels(&bytes(&["d30100c5", &"ff".repeat(27), "00fc00", &"0a".repeat(70), "00bc"].concat()));
    // A correlation of ten million.
    hostile::levels(&bytes(
        "ff1800390182e9e9e216d8d5130d020228161616161616162100000000000000130d0202283a161616161616161616161616\
         ff0e9d0d",
    ));
    // A model of five further terms, and a drive that friction all but holds: both took seconds.
    hostile::ringdown(&bytes("8d8c575d8d76f51f2c73fe5d088df5"));
    hostile::resonance(&bytes("ff0000ff2c00ff07b533fa08b5333afa33250008"));
    // A series of ring-downs with further laws named: it took fourteen seconds.
    hostile::series(&bytes("26040000588e00000080000010016c3b2c6c6c6c6c263d6c6ca5cbbf0a"));
    // A phase that runs backwards, and a curve that the paper's inversion gives a negative Q.
    hostile::ringdown(&bytes("2400c8ffffffffffbfff002435fdf5e030002430"));
    hostile::resonance(&bytes("2effffeb402effffffffff000010263334260a26330007412d"));
    // A Q below the smallest normal number, and a frequency that is not finite in rad/s.
    hostile::levels(&bytes("13006ec7280080000c1405204205"));
    hostile::resonance(&bytes(
        "090202be5d1d020234203d00009a6b2800002800482800c2007328580228008328200a28de4b282ac128007400052800\
         0c0929003f0b1f00000000005b201913110072230028000000121f3d0000000000004a0000004e000720c86d8100478b\
         130e851e0080449a186dc02000",
    ));
    // Blocks of amplitudes closer together than the resolution of stamps late on the clock: the analysis did not end.
    hostile::ringdown(&bytes(
        "e717991cb6acdc32a2bda7ea9c60cb79493694fe806578eeed62b0e05541e07223d5fb57724479b4d13010c95946ee09\
         d81f88cdb664c673af22655ad8c95186e4ef68370d62ee2e08ce5a6f0a5449f105df1b4c6c1b74e8c65acc863574b4f2\
         41e853726c98d4d5bcc7d680ff905383724abeaa550733f70f89cd5a0e54cd9d12444bf34cc5035bc86579a14c8672d2\
         f20f831ba7d33bf6d74d4622f8a5f23b359a5a9021bc0f79e926651e7c758be58d8921361df3c03186d73f77fbc60c4a\
         e1eaa80666325e33f3c4ca24c89a6d8330b3ef19befc8a1f3c1d0692a37f51c96c43fb5bbd6f5591f60573c820e834f4\
         86676e521612545063634be998f8df1e328532006cbf91c50b1cc2",
    ));
    // Turning points at NaN, between which the steps of a further law did not end.
    hostile::ringdown(&bytes(
        "26c8597979640b4cd4544deb014573fbef386eb7e59ac66a43843c9fc506dce5e7e0d66026bd59311f7e5bbd1cbb17",
    ));
    hostile::ringdown(&bytes(
        "2bcd1a069ef41f71932596e58233d26a053502333510fce1954aaba43c6444ea5c6a76f32f3f3e976bdcbe294a04950de82d\
         c94504d9f15a49b6d4bc",
    ));
    // A period of the drive beyond the range of numbers.
    hostile::resonance(&bytes("ffff00083a3a2f08f9083a0859068d413a"));
    // A Q whose interval is small compared with its rounding.
    hostile::ringdown(&bytes("020202022614ddd40120f6712009530f00000db9001b14b490fc0e"));
    // An exponent of the loss that is undetermined.
    hostile::ringdown(&bytes(
        "1d0202650b2e4a380e4c20020220c15b50b0300000008cfd000000000028006d00aa2f3d0000000007280000004528000028\
         000028000028000028000028000000b90e00000000180000200002000000000000",
    ));
    // A fit whose frequency strayed far above the samples: it took two minutes.
    hostile::ringdown(&bytes(
        "0fa941ee62bce27e56b18675a8c042d37e011bd7ab8ebe7d025b737686acb134dca7e4b620b6155ecf82c4f3985a7703b8d9\
         6a3c1b945bffe776bdd0b752d77e6341307b66a294431d5e0b838f68e74fcba5f095",
    ));
    // Residuals over the smallest possible noise, and a Q that the paper's inversion puts beyond any limit: reported
    // as inf.
    hostile::resonance(&bytes(
        "0802022c03d001020210202f194d847e44007a6e0000000028000000af097ea4b91e0000000028492d007309002d1b1d144f\
         0a89a50002",
    ));
    hostile::resonance(&bytes(
        "200202972ffa203ed68628253d28a0dd2807c0206800000000002879f8001020e4051300000000c9521fce450c11ad97621f\
         d3000000005428e06700191e00bc881f2850be00027320ad029132f3238d1d0b02472097b20624ae4e20cc14000000002839\
         db00090002",
    ));
    // Sweeps up and down without noise, with a difference that is large relative to the smallest number.
    hostile::series(&bytes(
        "00000000006728000028000012b502020c270202028a20480320674909e01d000000f32c00003be1002019380005007d2827\
         26003505691e0000000010a0bb2335291b4300000202000000",
    ));
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
    #![proptest_config(cases(300))]

    #[test]
    fn resonance_curves(bytes in bytes()) {
        hostile::resonance(&bytes);
    }

    #[test]
    fn series_of_measurements(bytes in bytes()) {
        hostile::series(&bytes);
    }
}

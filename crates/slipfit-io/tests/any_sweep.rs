//! Any bytes are a resonance curve or are refused; nothing panics.

use proptest::prelude::*;
use slipfit_io::{ReadOptions, read_sweep_from};

fn answered(bytes: &[u8], options: &ReadOptions) {
    match read_sweep_from(bytes, "any", options) {
        Ok(reading) => {
            let curve = &reading.curve;
            assert!(!curve.is_empty());
            assert!(curve.len() as u64 <= reading.report.rows_read);
            assert!(curve.frequency_hz().iter().all(|f| f.is_finite() && *f > 0.0));
            assert!((0..curve.len()).all(|i| curve.response().amplitude(i) >= 0.0));
            assert!(!reading.report.taken.is_empty());
        }
        Err(error) => assert!(error.to_string().starts_with("any")),
    }
}

fn header() -> impl Strategy<Value = String> {
    let name = prop_oneof![
        Just("f (Hz)"),
        Just("T_s"),
        Just("omega"),
        Just("Frequency Shift (Hz)"),
        Just("Center Frequency (Hz)"),
        Just("R (dB)"),
        Just("amp"),
        Just("phase (deg)"),
        Just("Re"),
        Just("Im"),
        Just("X"),
        Just("Y"),
        Just("Gp"),
        Just("Bp"),
        Just("Rs"),
        Just("Xs"),
        Just("drive"),
        Just("amp err"),
        Just("t (s)"),
        Just("power (mW)"),
        Just("velocity (m/s)"),
        Just(""),
    ];
    prop::collection::vec(name, 1..5).prop_map(|names| names.join(","))
}

fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (-1e3..1e3f64).prop_map(|v| format!("{v:.3}")),
        1 => any::<f64>().prop_map(|v| v.to_string()),
        1 => Just(String::new()),
        1 => Just("nan".to_owned()),
        1 => Just("0".to_owned()),
        1 => Just("1e308".to_owned()),
        1 => Just("oops".to_owned()),
    ]
}

proptest! {
    #[test]
    fn random_bytes_are_answered_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        answered(&bytes, &ReadOptions::default());
    }

    #[test]
    fn random_tables_are_answered_or_refused(
        header in header(),
        rows in prop::collection::vec(prop::collection::vec(cell(), 1..5), 0..30),
        centre_hz in prop::option::of(any::<f64>()),
        unit in prop::option::of(prop_oneof![Just("dB"), Just("mm"), Just("?")]),
        frequency_unit in prop::option::of(prop_oneof![Just("kHz"), Just("ms"), Just("rad/s")]),
    ) {
        let mut text = header + "\n";
        for row in rows {
            text += &(row.join(",") + "\n");
        }
        let options = ReadOptions {
            centre_hz,
            unit: unit.map(str::to_owned),
            frequency_unit: frequency_unit.map(str::to_owned),
            ..ReadOptions::default()
        };
        answered(text.as_bytes(), &options);
    }
}

//! The way of every file, from its bytes to its answer: nothing panics.

use proptest::prelude::*;
use slipfit::ringdown::{Options, analyse};
use slipfit_io::{ReadOptions, read_from};

/// A file that is read and analysed: a decaying swing, once a tenth of a second.
fn sample_file() -> Vec<u8> {
    let mut text = String::from("Time (s);Angle (rad)\n");
    for i in 0..200 {
        let t = 0.1 * f64::from(i);
        text += &format!("{t:.2};{:.4}\n", (-0.1 * t).exp() * (4.0 * t).cos());
    }
    text.into_bytes()
}

fn answered(bytes: &[u8], rate_hz: Option<f64>) -> bool {
    let options = ReadOptions { rate_hz, ..ReadOptions::default() };
    read_from(bytes, "bytes", &options)
        .is_ok_and(|reading| analyse(&reading.record, &Options::default()).is_ok())
}

#[test]
fn the_file_unchanged_is_answered() {
    assert!(answered(&sample_file(), None));
}

/// Rows of numbers as a generator without sense would write them.
fn numbers() -> impl Strategy<Value = Vec<u8>> {
    let cell = prop_oneof![
        6 => (-1.0..1.0f64).prop_map(|v| format!("{v:.3}")),
        1 => any::<f64>().prop_map(|v| format!("{v:e}")),
        1 => prop::sample::select(vec!["", "nan", "inf", "1e308", "-1e-308", "0", "x"]).prop_map(str::to_owned),
    ];
    (prop::collection::vec(prop::collection::vec(cell, 1..4), 1..120), any::<bool>()).prop_map(
        |(rows, clock)| {
            let mut text = String::new();
            for (i, row) in rows.iter().enumerate() {
                if clock {
                    text += &format!("{i},");
                }
                text += &row.join(",");
                text.push('\n');
            }
            text.into_bytes()
        },
    )
}

proptest! {
    #[test]
    fn random_bytes_are_answered_or_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..3000),
        rate_hz in prop::option::of(prop_oneof![Just(100.0), any::<f64>()]),
    ) {
        answered(&bytes, rate_hz);
    }

    #[test]
    fn random_numbers_are_answered_or_refused(
        bytes in numbers(),
        rate_hz in prop::option::of(prop_oneof![Just(100.0), any::<f64>()]),
    ) {
        answered(&bytes, rate_hz);
    }

    #[test]
    fn a_damaged_file_is_answered_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 0..60),
        length in any::<prop::sample::Index>(),
    ) {
        let mut bytes = sample_file();
        for (at, byte, how) in changes {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => { bytes.remove(at); }
            }
        }
        bytes.truncate(length.index(bytes.len()) + 1);
        answered(&bytes, None);
    }

    #[test]
    fn a_sound_file_of_random_bytes_is_answered_or_refused(
        samples in prop::collection::vec(any::<u8>(), 0..2000),
        cut in 0..60usize,
        damage in prop::option::of((0..44usize, any::<u8>())),
    ) {
        let size = samples.len() as u32;
        let mut bytes = b"RIFF".to_vec();
        bytes.extend((36 + size).to_le_bytes());
        bytes.extend(b"WAVEfmt \x10\0\0\0\x01\0\x01\0");
        bytes.extend(8000u32.to_le_bytes());
        bytes.extend(16000u32.to_le_bytes());
        bytes.extend(b"\x02\0\x10\0data");
        bytes.extend(size.to_le_bytes());
        bytes.extend(&samples);
        if let Some((at, byte)) = damage {
            bytes[at] = byte;
        }
        bytes.truncate(bytes.len().saturating_sub(cut));
        answered(&bytes, None);
    }
}

//! Any bytes are read or refused, from the file to the answer, without a panic; the values in a table are the values
//! read.

use proptest::prelude::*;
use slipfit::ringdown::analyse;
use slipfit_io::{ReadOptions, read_from, read_sweep_from};

/// A file that is read and analysed: a decaying swing, sampled ten times per second.
fn sample_file() -> String {
    let mut text = String::from("# made up\nrate: 10\nTime (s);Angle (°);\"v (°/s)\"\n");
    for i in 0..200 {
        let t = 0.1 * f64::from(i);
        text += &format!("{t:.2};{:.4};{:.3e}\n", (-0.1 * t).exp() * (4.0 * t).cos(), (4.0 * t).sin());
    }
    text
}

/// Reads a record and analyses it; returns whether there is an answer.
fn answered(bytes: &[u8], options: &ReadOptions) -> bool {
    match read_from(bytes, "bytes", options) {
        Ok(reading) => {
            assert!(reading.record.signal().iter().all(|v| v.is_finite()));
            let clock = reading.record.clock_report();
            let left = clock.nonfinite() + clock.corrupt_stamps + clock.other_run_rows;
            assert_eq!(reading.record.len() + left, clock.rows);
            analyse(&reading.record, &Default::default()).is_ok()
        }
        Err(error) => {
            assert!(error.to_string().starts_with("bytes"), "{error}");
            false
        }
    }
}

/// Reads a curve.
fn as_curve(bytes: &[u8], options: &ReadOptions) {
    match read_sweep_from(bytes, "any", options) {
        Ok(reading) => {
            let curve = &reading.curve;
            assert!((1..=reading.report.rows_read).contains(&(curve.len() as u64)));
            assert!(curve.frequency_hz().iter().all(|f| f.is_finite() && *f > 0.0));
            assert!((0..curve.len()).all(|i| curve.response().amplitude(i) >= 0.0));
            assert!(!reading.report.taken.is_empty());
        }
        Err(error) => assert!(error.to_string().starts_with("any"), "{error}"),
    }
}

#[test]
fn the_file_unchanged_is_answered() {
    assert!(answered(sample_file().as_bytes(), &ReadOptions::default()));
}

fn options() -> impl Strategy<Value = ReadOptions> {
    let name = prop_oneof![Just("1"), Just("2"), Just("angle"), Just("t"), Just(""), Just("99")];
    (
        prop::option::weighted(0.2, name.clone()),
        prop::option::weighted(0.2, name.clone()),
        prop::option::weighted(0.1, name),
        prop::option::weighted(0.2, prop_oneof![Just(10.0), any::<f64>()]),
        prop::option::weighted(0.1, 0..4usize),
        prop::option::weighted(0.1, 0..4usize),
    )
        .prop_map(|(time, signal, quadrature, rate_hz, table, run)| ReadOptions {
            time: time.map(Into::into),
            signal: signal.map(Into::into),
            quadrature: quadrature.map(Into::into),
            rate_hz,
            part: table,
            run,
            ..ReadOptions::default()
        })
}

/// A reader that gives a few bytes at a time.
struct Trickle<'a>(&'a [u8], usize);

impl std::io::Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.1.min(self.0.len()).min(buffer.len());
        buffer[..n].copy_from_slice(&self.0[..n]);
        self.0 = &self.0[n..];
        Ok(n)
    }
}

/// Characters that occur in tables.
fn tabular() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(
        prop_oneof![
            6 => prop::sample::select(b"0123456789".to_vec()),
            4 => prop::sample::select(b",;\t .-+eE".to_vec()),
            2 => prop::sample::select(b"\r\n".to_vec()),
            1 => prop::sample::select(b"\"'#%|/()[]:=tsxNa\xb0\xc2".to_vec()),
        ],
        0..600,
    )
}

/// Rows of random numbers.
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

fn header() -> impl Strategy<Value = String> {
    let names = vec![
        "f (Hz)",
        "T_s",
        "omega",
        "Frequency Shift (Hz)",
        "Center Frequency (Hz)",
        "R (dB)",
        "amp",
        "phase (deg)",
        "Re",
        "Im",
        "X",
        "Y",
        "Gp",
        "Bp",
        "Rs",
        "Xs",
        "drive",
        "amp err",
        "t (s)",
        "power (mW)",
        "velocity (m/s)",
        "",
    ];
    let name = prop::sample::select(names);
    prop::collection::vec(name, 1..5).prop_map(|names| names.join(","))
}

fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (-1e3..1e3f64).prop_map(|v| format!("{v:.3}")),
        1 => any::<f64>().prop_map(|v| v.to_string()),
        5 => prop::sample::select(vec!["", "nan", "0", "1e308", "oops"]).prop_map(str::to_owned),
    ]
}

proptest! {
    #[test]
    fn random_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..2000), options in options()) {
        answered(&bytes, &options);
        as_curve(&bytes, &ReadOptions::default());
    }

    #[test]
    fn random_tables_of_numbers_are_read_or_refused(
        bytes in prop_oneof![tabular(), numbers()],
        options in options(),
    ) {
        answered(&bytes, &options);
    }

    #[test]
    fn a_damaged_file_is_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 0..60),
        length in any::<prop::sample::Index>(),
        options in options(),
    ) {
        let mut bytes = sample_file().into_bytes();
        for (at, byte, how) in changes {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => { bytes.remove(at); }
            }
        }
        bytes.truncate(length.index(bytes.len()) + 1);
        answered(&bytes, &options);
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
        as_curve(text.as_bytes(), &options);
    }

    #[test]
    fn the_size_of_reads_changes_nothing(size in 1..200usize) {
        let text = sample_file();
        let whole = read_from(text.as_bytes(), "f", &ReadOptions::default()).unwrap();
        let parts = read_from(Trickle(text.as_bytes(), size), "f", &ReadOptions::default()).unwrap();
        prop_assert_eq!(whole, parts);
    }

    #[test]
    fn a_table_in_any_dialect_reads_back_exactly(
        signal in prop::collection::vec(-1e6..1e6f64, 12..80),
        step in 1..1000u32,
        before in 0..3usize,
        after in 0..3usize,
        swapped in any::<bool>(),
        separator in prop::sample::select(vec![";", "\t", ",", " ", "|", " ; ", ", "]),
        comma in any::<bool>(),
        line_end in prop::sample::select(vec!["\n", "\r\n", "\r"]),
        header in any::<bool>(),
        preamble in 0..40usize,
        mark in any::<bool>(),
        quoted in any::<bool>(),
    ) {
        let comma = comma && !separator.contains(',');
        let quoted = quoted && separator != " ";
        let number = |v: f64| {
            let plain = format!("{v:?}");
            let local = if comma { plain.replace('.', ",") } else { plain };
            if quoted { format!("\"{local}\"") } else { local }
        };
        let mut text = String::from(if mark { "\u{feff}" } else { "" });
        for i in 0..preamble {
            text += &format!("{} line {i} of the preamble{line_end}", if i % 2 == 0 { "#" } else { "%" });
        }
        let filler = |n: usize, name: &str| (0..n).map(|i| format!("{name}{i}")).collect::<Vec<_>>();
        let arrange = |first: Vec<String>, time: String, value: String, last: Vec<String>| {
            let pair = if swapped { [value, time] } else { [time, value] };
            first.into_iter().chain(pair).chain(last).collect::<Vec<_>>().join(separator)
        };
        // Without a header, columns are identified by numbers only; then there are only two.
        let (before, after) = if header { (before, after) } else { (0, 0) };
        if header {
            let names = arrange(filler(before, "err"), "time_s".into(), "angle_rad".into(), filler(after, "sigma"));
            text += &format!("{names}{line_end}");
        }
        for (i, &value) in signal.iter().enumerate() {
            let time = f64::from(step) * 0.001 * i as f64;
            let pad = |n: usize| (0..n).map(|_| number(0.25)).collect::<Vec<_>>();
            text += &arrange(pad(before), number(time), number(value), pad(after));
            text += line_end;
        }
        let named = ReadOptions { signal: header.then(|| "angle".into()), ..ReadOptions::default() };
        let reading = read_from(text.as_bytes(), "table", &named);
        let reading = reading.map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
        prop_assert_eq!(reading.record.signal(), &signal[..], "{}", text);
        prop_assert_eq!(reading.report.rows_skipped(), 0);
        for i in 0..signal.len() {
            let time = f64::from(step) * 0.001 * i as f64;
            prop_assert!((reading.record.time_s(i) - time).abs() <= 1e-9 * f64::from(step));
        }
    }
}

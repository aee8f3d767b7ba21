//! No bytes make the reader panic, and what a table says is what is read.

use proptest::prelude::*;
use slipfit_io::{ReadOptions, read_from};

fn sample_file() -> String {
    let mut text = String::from("# made up\nrate: 10\nTime (s);Angle (°);\"v (°/s)\"\n");
    for i in 0..60 {
        let t = 0.1 * f64::from(i);
        text += &format!("{t:.2};{:.4};{:.3e}\n", (-0.1 * t).exp() * (4.0 * t).cos(), (4.0 * t).sin());
    }
    text
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

/// Characters that tables are made of.
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

proptest! {
    #[test]
    fn random_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..2000), options in options()) {
        if let Err(error) = read_from(&bytes[..], "bytes", &options) {
            prop_assert!(error.to_string().starts_with("bytes"));
        }
    }

    #[test]
    fn random_tabular_bytes_are_read_or_refused(bytes in tabular(), options in options()) {
        if let Ok(reading) = read_from(&bytes[..], "bytes", &options) {
            prop_assert!(reading.record.signal().iter().all(|v| v.is_finite()));
            let clock = reading.record.clock_report();
            let left = clock.nonfinite() + clock.corrupt_stamps + clock.other_run_rows;
            prop_assert_eq!(reading.record.len() + left, clock.rows);
        }
    }

    #[test]
    fn mutated_files_are_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 0..40),
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
        let _ = read_from(&bytes[..], "mutated", &options);
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
        // Without a header only numbers tell the columns: then there are two.
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

//! Tables written by other programs in various versions, compressions and byte orders: every file of
//! `validation/reference/writers` is the ring-down defined in its script, to the last digit.
#![cfg(all(feature = "arrow", feature = "excel", feature = "hdf5", feature = "parquet"))]

use std::path::PathBuf;

use slipfit_io::{ReadOptions, glance, glance_from, read, read_tables};

/// Every file except the script and its provenance.
fn files() -> Vec<(String, PathBuf)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/reference/writers");
    let named = |path: PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), path);
    let mut files: Vec<(String, PathBuf)> =
        std::fs::read_dir(folder).unwrap().map(|e| named(e.unwrap().path())).collect();
    files.retain(|(name, _)| !name.ends_with(".py") && !name.ends_with(".md"));
    files.sort();
    files
}

/// The ring-down in every file.
fn x(k: usize) -> f64 {
    let t = k as f64 / 50.0;
    (0.2 * (-0.15 * t).exp() * (std::f64::consts::TAU * 1.5 * t).cos() * 1e6).round() / 1e6
}

#[test]
fn every_writer_is_read_without_a_flag() {
    let mut count = 0;
    let tables = |(name, _): &(String, PathBuf)| !name.starts_with("constant_") && !name.starts_with("sound");
    for (name, path) in files().into_iter().filter(tables) {
        let reading = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let record = &reading.record;
        assert_eq!(record.len(), 400, "{name}");
        // Half a step of single precision; decimals are read as the nearest double.
        let tolerance = if name.contains("_f4") { 0.2 * f64::from(f32::EPSILON) } else { 1e-15 };
        for (k, value) in record.signal().iter().enumerate() {
            assert!((value - x(k)).abs() <= tolerance, "{name}, row {k}: {value} for {}", x(k));
        }
        let times = record.times_s(0..400);
        assert!((times[399] - times[0] - 7.98).abs() < 1e-6, "{name}: {} s", times[399] - times[0]);
        count += 1;
    }
    // The files come from pyarrow, polars, pandas, DuckDB, h5py and scipy.
    assert!(count >= 80, "{count} files");
}

#[test]
fn constants_that_pack_ten_thousandfold_are_read() {
    let mut count = 0;
    for (name, path) in files().into_iter().filter(|(name, _)| name.starts_with("constant_")) {
        let tables = read_tables(&path, usize::MAX).unwrap_or_else(|e| panic!("{e}"));
        let [table] = &tables.tables[..] else { panic!("{name}: {} tables", tables.tables.len()) };
        let column = |header: &str| &table.columns.iter().find(|c| c.header == header).unwrap().values;
        assert_eq!(table.rows(), 1 << 16, "{name}");
        assert!(column("gain").iter().all(|v| *v == 1.0), "{name}");
        assert!(column("offset").iter().all(|v| *v == 0.0), "{name}");
        for (k, value) in column("x").iter().enumerate() {
            let k = k as f64;
            assert_eq!(*value, (25.0 * (-k / 20000.0).exp() * (k / 50.0).cos()).round(), "{name}, row {k}");
        }
        count += 1;
    }
    assert!(count >= 11, "{count} files");
}

#[test]
fn an_arrow_file_without_its_footer_is_read_as_the_stream_it_is() {
    let (_, path) = files().into_iter().find(|(name, _)| name == "pyarrow_zstd_V5.arrow").unwrap();
    let bytes = std::fs::read(path).unwrap();
    let whole = slipfit_io::read_tables_from(&bytes[..], "whole", usize::MAX).unwrap();
    let cut = slipfit_io::read_tables_from(&bytes[..bytes.len() - 3], "cut", usize::MAX).unwrap();
    assert_eq!(cut.tables, whole.tables);
    // Three batches of 150 rows: if the footer and the last of them are lost, two remain.
    let footer = u32::from_le_bytes(bytes[bytes.len() - 10..bytes.len() - 6].try_into().unwrap()) as usize;
    let end = bytes.len() - 10 - footer - 16;
    let cut = slipfit_io::read_tables_from(&bytes[..end], "cut", usize::MAX).unwrap();
    assert_eq!(cut.tables[0].rows(), 300);
    assert_eq!(cut.tables[0].columns[1].values[..], whole.tables[0].columns[1].values[..300]);
}

#[test]
fn a_claim_beyond_what_the_packing_can_hold_is_refused() {
    let (_, path) = files().into_iter().find(|(name, _)| name == "pyarrow_zstd_V5.arrow").unwrap();
    let bytes = std::fs::read(path).unwrap();
    // 150 numbers of eight bytes: the claimed unpacked size of each packed column of the first batch.
    let claim = 1200_u64.to_le_bytes();
    let at = bytes.windows(8).position(|w| w == claim).unwrap();
    let mut bomb = bytes.clone();
    bomb[at..at + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let error = slipfit_io::read_tables_from(&bomb[..], "bomb", usize::MAX).unwrap_err().to_string();
    assert!(error.contains("claim to unpack to"), "{error}");
}

#[cfg(feature = "sound")]
#[test]
fn sounds_as_phones_pack_them_are_read() {
    use slipfit_io::{Format, TimeSource};
    let wave = |k: usize| {
        let t = k as f64 / 8000.0;
        (26000.0 * (-3.0 * t).exp() * (std::f64::consts::TAU * 200.0 * t).cos()).round() / 32768.0
    };
    for (name, format, lossless) in [
        ("sound.flac", Format::Flac, true),
        ("sound_alac.m4a", Format::Mp4, true),
        ("sound.m4a", Format::Mp4, false),
        ("sound.aac", Format::Aac, false),
        ("sound.mp3", Format::Mp3, false),
        ("sound.ogg", Format::Ogg, false),
    ] {
        let (_, path) = files().into_iter().find(|(file, _)| file == name).unwrap();
        let reading = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            (reading.report.format, reading.report.time.clone()),
            (format, Some(TimeSource::Rate(8000.0)))
        );
        let notes = reading.report.notes.iter().any(|note| note.text.contains("compressed with loss"));
        assert_eq!(notes, !lossless, "{name}");
        assert_eq!(reading.record.is_lossily_compressed(), !lossless, "{name}");
        let signal = reading.record.signal();
        // An encoder adds silence before the sound: at most three frames of 2048.
        let error = |lag: usize| {
            let rows = signal[lag..].iter().take(7000).enumerate();
            (rows.map(|(k, v)| (v - wave(k)).powi(2)).sum::<f64>() / 7000.0).sqrt()
        };
        let lags = 0..signal.len().saturating_sub(7000).min(6144) + 1;
        let least = lags.map(error).fold(f64::INFINITY, f64::min);
        // The root mean square of the sound is 0.23; codecs preserve what is audible, here to some per cent.
        let tolerance = if lossless { 1e-9 } else { 0.02 };
        assert!(least < tolerance, "{name}: {least} from the sound that was packed");
        // Truncated in the middle it is read as far as it goes, or refused; it does not panic.
        let bytes = std::fs::read(&path).unwrap();
        let _ = slipfit_io::read_from(&bytes[..bytes.len() / 2], name, &ReadOptions::default());
    }
}

#[test]
fn at_a_glance_a_file_is_the_record_that_reading_it_gives() {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let texts = ["classroom_pendulum.csv", "tuning_fork_9nN.csv", "tuning_fork_9nN_waveform.csv"];
    let texts = texts.map(|name| (name.to_owned(), PathBuf::from(examples).join(name)));
    let options = ReadOptions::default();
    let (mut count, mut in_part) = (0, 0);
    for (name, path) in files().into_iter().chain(texts) {
        let Ok(read) = read(&path, &options) else { continue };
        let bytes = std::fs::read(&path).unwrap();
        let from_bytes = glance_from(&bytes[..], &path.display().to_string(), 100, &options, Some(&options));
        for seen in [glance(&path, 100, &options, Some(&options)).unwrap(), from_bytes.unwrap()] {
            let record = seen.record.unwrap();
            assert_eq!(
                (&record.report.sha256, record.report.bytes),
                (&read.report.sha256, read.report.bytes)
            );
            assert_eq!((&seen.tables.sha256, seen.tables.bytes), (&read.report.sha256, read.report.bytes));
            assert!(seen.in_part || record == read, "{name}");
            in_part += usize::from(seen.in_part);
            count += 1;
        }
    }
    assert!(count > 150 && in_part < count / 10, "{in_part} of {count} in part");
}

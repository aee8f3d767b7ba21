//! Tables as other programs write them, in their versions, packings and byte orders: every file of
//! `validation/reference/writers` is the ring-down that its script states, to the last digit.
#![cfg(all(feature = "arrow", feature = "hdf5", feature = "parquet"))]
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::path::PathBuf;

use slipfit_io::{ReadOptions, read, read_tables};

/// Every file but the script and its provenance.
fn files() -> Vec<(String, PathBuf)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/reference/writers");
    let named = |path: PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), path);
    let mut files: Vec<(String, PathBuf)> =
        std::fs::read_dir(folder).unwrap().map(|e| named(e.unwrap().path())).collect();
    files.retain(|(name, _)| !name.ends_with(".py") && !name.ends_with(".md"));
    files.sort();
    files
}

/// The ring-down that every file holds.
fn x(k: usize) -> f64 {
    let t = k as f64 / 50.0;
    (0.2 * (-0.15 * t).exp() * (std::f64::consts::TAU * 1.5 * t).cos() * 1e6).round() / 1e6
}

#[test]
fn every_writer_is_read_without_a_flag() {
    let mut count = 0;
    for (name, path) in files().into_iter().filter(|(name, _)| !name.starts_with("constant_")) {
        let reading = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let record = &reading.record;
        assert_eq!(record.len(), 400, "{name}");
        // Half a step of single precision; decimals come as the nearest double.
        let tolerance = if name.contains("_f4") { 0.2 * f64::from(f32::EPSILON) } else { 1e-15 };
        for (k, value) in record.signal().iter().enumerate() {
            assert!((value - x(k)).abs() <= tolerance, "{name}, row {k}: {value} for {}", x(k));
        }
        let times = record.times_s(0..400);
        assert!((times[399] - times[0] - 7.98).abs() < 1e-6, "{name}: {} s", times[399] - times[0]);
        count += 1;
    }
    // All of them were there: pyarrow, polars, pandas, DuckDB, h5py, scipy.
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
        assert!(
            column("gain").iter().all(|v| *v == 1.0) && column("offset").iter().all(|v| *v == 0.0),
            "{name}"
        );
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
    // Three batches of 150 rows: a footer that is lost with the last of them leaves two.
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
    // 150 numbers of eight bytes: what each packed column of the first batch claims to unpack to.
    let claim = 1200_u64.to_le_bytes();
    let at = bytes.windows(8).position(|w| w == claim).unwrap();
    let mut bomb = bytes.clone();
    bomb[at..at + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let error = slipfit_io::read_tables_from(&bomb[..], "bomb", usize::MAX).unwrap_err().to_string();
    assert!(error.contains("claim to unpack to"), "{error}");
}

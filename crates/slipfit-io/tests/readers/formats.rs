//! Every format, with files written by other programs (`validation/reference/formats`): chosen columns, units, clocks
//! and every number.

use std::path::PathBuf;

use slipfit::SignalKind::{self, Acceleration, Displacement, Envelope, LockIn};
use slipfit::resonance::Response;
use slipfit_io::{
    ColumnTaken, Format, ReadError, ReadOptions, ReadProblem, Reading, read, read_sweep, read_tables,
};

fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../validation/reference/formats").join(name)
}

/// The ring-down in every file, as defined in `make.py`.
fn x(k: usize) -> f64 {
    let t = k as f64 / 50.0;
    (0.2 * (-0.15 * t).exp() * (std::f64::consts::TAU * 1.5 * t).cos() * 1e6).round() / 1e6
}

fn amplitude(k: usize) -> f64 {
    (-0.15 * k as f64 / 50.0).exp()
}

/// Expected result for a file.
struct Expected {
    file: &'static str,
    options: ReadOptions,
    format: Format,
    unit: &'static str,
    kind: SignalKind,
    sheet: &'static str,
    /// Ratio of the signal to the common one.
    gain: f64,
    tolerance: f64,
}

impl Default for Expected {
    fn default() -> Self {
        Self {
            file: "",
            options: ReadOptions::default(),
            format: Format::Text,
            unit: "",
            kind: Displacement,
            sheet: "",
            gain: 1.0,
            tolerance: 1e-12,
        }
    }
}

fn sheet(name: &str) -> ReadOptions {
    ReadOptions { sheet: Some(name.into()), ..Default::default() }
}

fn column(name: &str) -> ReadOptions {
    ReadOptions { signal: Some(name.into()), ..Default::default() }
}

fn rate() -> ReadOptions {
    ReadOptions { rate_hz: Some(50.0), ..Default::default() }
}

fn run(run: usize) -> ReadOptions {
    ReadOptions { run: Some(run), ..Default::default() }
}

fn got(file: &str, options: &ReadOptions) -> Reading {
    read(fixture(file), options).unwrap_or_else(|e| panic!("{e}"))
}

fn signal(reading: &Reading) -> &ColumnTaken {
    reading.report.column("signal").unwrap()
}

/// All notes on a file.
fn notes(file: &str) -> String {
    let notes = got(file, &ReadOptions::default()).report.notes;
    notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn offers(error: &ReadError, option: &str) -> bool {
    error.hints().iter().any(|hint| hint.option == Some(option))
}

#[rustfmt::skip]
fn expected() -> Vec<Expected> {
    use Format::{Arrow, Hdf5, Json, Mat5, NanoSurf, Npy, Npz, Parquet, Text, Tracker, Wav, Xls, Xlsx, Zip};
    let e = Expected::default;
    vec![
        Expected { file: "vectors.mat", format: Mat5, sheet: "t, x", ..e() },
        Expected { file: "packed.mat", format: Mat5, sheet: "t, x", ..e() },
        Expected { file: "struct.mat", format: Mat5, sheet: "run", unit: "rad", ..e() },
        Expected { file: "cells.mat", format: Mat5, sheet: "runs{2}", options: sheet("runs{2}"), gain: 2.0, ..e() },
        Expected { file: "integers.mat", format: Mat5, sheet: "counts", options: rate(), gain: 1e6, ..e() },
        Expected { file: "stereo16.wav", format: Wav, options: column("channel 1"), gain: 1e5 / 32768.0, tolerance: 1e-5, ..e() },
        Expected { file: "bytes8.wav", format: Wav, gain: 500.0 / 128.0, tolerance: 1.1e-3, ..e() },
        Expected { file: "float32.wav", format: Wav, tolerance: 1e-8, ..e() },
        Expected { file: "columns.npy", format: Npy, sheet: "x", ..e() },
        Expected { file: "fortran.npy", format: Npy, sheet: "x", ..e() },
        Expected { file: "wide.npy", format: Npy, sheet: "x", ..e() },
        Expected { file: "fields.npy", format: Npy, sheet: "n, time_s, angle_rad", unit: "rad", ..e() },
        Expected { file: "half.npy", format: Npy, sheet: "x", options: rate(), tolerance: 1e-4, ..e() },
        Expected { file: "arrays.npz", format: Npz, sheet: "displacement, time", ..e() },
        Expected { file: "packed.npz", format: Npz, sheet: "displacement, time", ..e() },
        Expected { file: "rate.npz", format: Npz, sheet: "x", ..e() },
        Expected { file: "interval.npz", format: Npz, sheet: "x", ..e() },
        Expected { file: "interval.mat", format: Mat5, sheet: "x", tolerance: 1e-8, ..e() },
        Expected { file: "rate_attribute.h5", format: Hdf5, sheet: "/data", unit: "m", ..e() },
        Expected { file: "waveform.h5", format: Hdf5, sheet: "/Waveforms/Channel 1", unit: "Volt", tolerance: 5.1e-6, ..e() },
        Expected { file: "groups.h5", format: Hdf5, sheet: "/run2", options: sheet("run2"), unit: "rad", gain: 2.0, ..e() },
        Expected { file: "groups.h5", format: Hdf5, sheet: "/run1", options: sheet("/run1/"), unit: "rad", ..e() },
        Expected { file: "compound.h5", format: Hdf5, sheet: "/swing", tolerance: 1e-8, ..e() },
        Expected { file: "big_endian.h5", format: Hdf5, sheet: "counts, t", gain: 1e6, ..e() },
        Expected { file: "matlab73.mat", format: Hdf5, sheet: "t, x", ..e() },
        Expected { file: "snappy.parquet", format: Parquet, unit: "rad", ..e() },
        Expected { file: "gzip_groups.parquet", format: Parquet, unit: "rad", ..e() },
        Expected { file: "polars.parquet", format: Parquet, unit: "mm", gain: 1e3, ..e() },
        Expected { file: "lz4.feather", format: Arrow, unit: "rad", ..e() },
        Expected { file: "zstd.feather", format: Arrow, unit: "rad", ..e() },
        Expected { file: "plain.arrows", format: Arrow, unit: "rad", ..e() },
        Expected { file: "sheets.xlsx", format: Xlsx, sheet: "Swing", unit: "rad", ..e() },
        Expected { file: "sheets.xlsx", format: Xlsx, sheet: "Second", options: sheet("second"), unit: "rad", gain: 2.0, ..e() },
        Expected { file: "sheets.xls", format: Xls, sheet: "Raw Data", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "sheets.xls", format: Xls, sheet: "Other", options: sheet("2"), unit: "m/s^2", kind: Acceleration, gain: 2.0, ..e() },
        Expected { file: "phyphox_comma_point.csv", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "phyphox_semicolon_point.csv", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "phyphox_semicolon_comma.csv", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "phyphox_tab_point.csv", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "phyphox_tab_comma.csv", unit: "m/s^2", kind: Acceleration, ..e() },
        Expected { file: "tracker_two.txt", options: column("mass A: x"), ..e() },
        Expected { file: "tracker_two.txt", options: column("mass B: x"), gain: 2.0, ..e() },
        Expected { file: "tracker_angle.txt", ..e() },
        Expected { file: "tracker.trk", format: Tracker, sheet: "mass A", options: column("x"), ..e() },
        Expected { file: "vernier.csv", unit: "m", ..e() },
        Expected { file: "vernier.csv", options: run(2), unit: "m", gain: 2.0, ..e() },
        Expected { file: "vernier_comma.csv", unit: "m", ..e() },
        Expected { file: "capstone.csv", unit: "rad", ..e() },
        Expected { file: "capstone.csv", options: run(2), unit: "rad", gain: 2.0, ..e() },
        Expected { file: "nanosurf.nid", format: NanoSurf, sheet: "group 0 channel 0 Deflection line 1", unit: "m", tolerance: 1e-9, ..e() },
        Expected { file: "moku.csv", options: column("2"), unit: "V", ..e() },
        Expected { file: "klipper.csv", unit: "mm/s^2", kind: Acceleration, gain: 9000.0, tolerance: 1e-6, ..e() },
        Expected { file: "objects.json", format: Json, unit: "rad", ..e() },
        Expected { file: "lists.json", format: Json, sheet: "angle (rad)", unit: "rad", ..e() },
        Expected { file: "packed.csv.gz", format: Text, unit: "rad", ..e() },
    ].into_iter().chain([
        Expected { file: "phyphox.zip", format: Zip, sheet: "Raw Data.csv", unit: "m/s^2", kind: Acceleration, ..e() },
    ]).collect()
}

#[test]
fn every_format_is_read_to_the_last_digit() {
    for want in expected() {
        let file = want.file;
        let reading = got(file, &want.options);
        let (record, report) = (&reading.record, &reading.report);
        assert_eq!(report.format, want.format, "{file}");
        assert_eq!(report.sheet, want.sheet, "{file}: {:?}", report.notes);
        assert_eq!(
            (record.unit(), record.kind()),
            (want.unit, want.kind),
            "{file}: {}",
            signal(&reading).why
        );
        assert_eq!((record.len(), report.rows_read, report.rows_skipped()), (400, 400, 0), "{file}");
        let close = want.tolerance * want.gain.max(1.0);
        for (k, value) in record.signal().iter().enumerate() {
            assert!(
                (value - want.gain * x(k)).abs() <= close,
                "{file}, row {k}: {value} for {}",
                want.gain * x(k)
            );
        }
        let span = record.time_s(399) - record.time_s(0);
        let paused = if file == "phyphox.zip" { 2.0 } else { 0.0 };
        assert!((span - 7.98 - paused).abs() < 1e-6, "{file}: {span} s");
        assert!(report.bytes > 0, "{file}");
        assert!(report.sha256.len() == 64, "{file}");
    }
}

#[test]
fn every_fixture_is_among_the_expected() {
    let elsewhere = [
        "labone.csv",
        "nanonis.dat",
        "keysight_zero_span.csv",
        "siglent_zero_span.csv",
        "stamps_gaps.parquet",
    ];
    let mut known: Vec<&str> = expected().iter().map(|e| e.file).collect();
    known.extend(elsewhere);
    known.extend([
        "complex.npz",
        "complex.h5",
        "complex.mat",
        "sweep.s1p",
        "sweep.s2p",
        "make.py",
        "PROVENANCE.md",
    ]);
    for entry in std::fs::read_dir(fixture("")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(known.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn times_of_phyphox_go_on_while_the_recording_was_paused() {
    let reading = got("phyphox.zip", &ReadOptions::default());
    let step = reading.record.time_s(201) - reading.record.time_s(200);
    assert!((step - 2.02).abs() < 1e-9, "{step}");
    assert!(
        reading.report.notes.iter().any(|n| n.text.contains("paused 1 times for 2.0 s")),
        "{:?}",
        reading.report.notes
    );
}

#[test]
fn ticks_of_an_unnamed_clock_are_asked_for() {
    let asked = read(fixture("labone.csv"), &ReadOptions::default()).unwrap_err();
    assert!(matches!(asked.problem, ReadProblem::NoTickRate { .. }), "{asked}");
    assert!(offers(&asked, "time_unit"), "{asked}");
    let clocked = ReadOptions { time_unit: Some("60 MHz".into()), ..Default::default() };
    let reading = got("labone.csv", &clocked);
    assert_eq!((reading.record.kind(), reading.record.unit()), (LockIn, "V"));
    assert!((reading.record.clock_report().median_step_s - 0.02).abs() < 1e-9);
    for (k, value) in reading.record.signal().iter().enumerate() {
        assert!((value - 1e-3 * amplitude(k)).abs() < 1e-11);
    }
}

#[test]
fn envelopes_and_levels_become_amplitudes() {
    let nanonis = got("nanonis.dat", &ReadOptions::default());
    assert_eq!((nanonis.record.kind(), nanonis.record.unit()), (Envelope, "m"));
    let named =
        |name: &str| nanonis.report.named_values.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
    assert_eq!((named("Experiment"), named("Comment")), (Some("data log"), Some("a, b: c")));
    assert_eq!(nanonis.report.dialect.as_ref().unwrap().convention, Some("Nanonis"));
    for file in ["keysight_zero_span.csv", "siglent_zero_span.csv"] {
        let reading = got(file, &ReadOptions::default());
        assert_eq!((reading.record.kind(), reading.record.unit()), (Envelope, "√mW"), "{file}");
        assert!((reading.record.time_s(399) - 7.98).abs() < 1e-3, "{file}");
        for (k, value) in reading.record.signal().iter().enumerate() {
            // Levels are written to 1e-4 dB.
            assert!((value / (0.01 * amplitude(k)) - 1.0).abs() < 1e-5, "{file}, row {k}: {value}");
        }
    }
}

#[test]
fn rows_without_a_value_are_left_out_and_counted() {
    let reading = got("stamps_gaps.parquet", &column("x"));
    assert_eq!((reading.report.rows_read, reading.report.rows_skipped()), (392, 8));
    assert_eq!(reading.report.skipped[0].first_row, 50);
    assert!((reading.record.time_s(391) - 7.96).abs() < 1e-6, "{}", reading.record.time_s(391));
}

#[test]
fn of_several_variables_none_is_guessed() {
    for (file, named) in [("groups.h5", ["`/run1`", "`/run2`"]), ("cells.mat", ["`runs{1}`", "`runs{2}`"])] {
        let error = read(fixture(file), &ReadOptions::default()).unwrap_err();
        assert!(matches!(error.problem, ReadProblem::SeveralTables { .. }), "{error}");
        let message = error.to_string();
        assert!(named.iter().all(|n| message.contains(n)), "{message}");
        assert!(offers(&error, "sheet"));
    }
    let error = read(fixture("groups.h5"), &sheet("run7")).unwrap_err().to_string();
    assert!(error.contains("sheet = run7"), "{error}");
    assert!(error.contains("`/run2`"), "{error}");
}

#[test]
fn sheets_that_were_not_read_are_named() {
    let notes = notes("sheets.xlsx");
    assert!(notes.contains("`Second`"), "{notes}");
    assert!(notes.contains("sheet `Notes`"), "{notes}");
}

#[test]
fn a_rate_named_by_a_variable_is_taken() {
    for file in
        ["integers.mat", "interval.mat", "rate.npz", "interval.npz", "rate_attribute.h5", "waveform.h5"]
    {
        let reading = got(file, &ReadOptions::default());
        assert_eq!(reading.report.time, Some(slipfit_io::TimeSource::Rate(50.0)), "{file}");
        assert!(notes(file).contains("the rate that the file names, 50 Hz"), "{file}: {}", notes(file));
    }
}

#[test]
fn a_complex_array_is_a_response_of_two_parts() {
    for file in ["complex.npz", "complex.h5", "complex.mat"] {
        let reading = read_sweep(&[fixture(file)], &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let Response::Complex(phasors) = reading.curve.response() else { panic!("{file}: no phasors") };
        assert_eq!(phasors.len(), 201, "{file}");
        for (i, found) in phasors.iter().enumerate() {
            let f = 99.0 + 0.01 * i as f64;
            let (a, b) = (1.0 - (f / 100.0).powi(2), 0.002);
            let wanted = [0.004 * a / (a * a + b * b), -0.004 * b / (a * a + b * b)];
            // Single precision of the MATLAB file, else rounding of 1 - (f/100)^2.
            let tolerance = if file.ends_with("mat") { 1e-6 } else { 1e-12 };
            assert!((found.re - wanted[0]).abs() < tolerance, "{file}, row {i}: {found:?}");
            assert!((found.im - wanted[1]).abs() < tolerance, "{file}, row {i}: {found:?}");
        }
    }
}

#[test]
fn angles_without_a_unit_are_said_to_be_so() {
    let notes = notes("tracker_angle.txt");
    assert!(notes.contains("degrees or radians"), "{notes}");
    assert!(notes.contains("unit says"), "{notes}");
}

#[test]
fn sweeps_are_read_as_tables() {
    let one = &read_tables(fixture("sweep.s1p"), usize::MAX).unwrap().tables[0];
    let headers: Vec<&str> = one.columns.iter().map(|c| c.header.as_str()).collect();
    assert_eq!(headers, ["Frequency (MHz)", "S11 in-phase", "S11 quadrature"]);
    assert_eq!((one.rows(), one.columns[0].values[100]), (201, 100.0));
    let two = &read_tables(fixture("sweep.s2p"), usize::MAX).unwrap().tables[0];
    assert_eq!((two.rows(), two.columns.len()), (201, 9));
    assert_eq!((two.columns[3].header.as_str(), two.columns[3].unit.as_str()), ("S21 magnitude (dB)", "dB"));
    assert_eq!((two.skipped[0].reason.as_str(), two.skipped[0].rows), ("noise data", 2));
    let peak = two.columns[3].values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((peak - 20.0 * (500.0_f64 / 600.0).log10()).abs() < 1e-5, "{peak}");
}

#[test]
fn tables_hold_every_column_and_the_requested_number_of_rows() {
    let tables = read_tables(fixture("snappy.parquet"), 7).unwrap();
    assert_eq!((tables.format, tables.tables.len()), (Format::Parquet, 1));
    let table = &tables.tables[0];
    assert_eq!((table.rows(), table.cut, table.columns.len()), (7, true, 2));
    assert!(table.notes.iter().any(|n| n.text.contains("label")), "{:?}", table.notes);
    let text = read_tables(fixture("capstone.csv"), usize::MAX).unwrap();
    assert_eq!((text.tables[0].rows(), text.tables[0].cut, text.tables[0].columns.len()), (400, false, 4));
    assert_eq!(text.dialect.unwrap().convention, Some("PASCO Capstone"));
}

//! Measured ring-downs are read with the expected columns, units, clocks and counts.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::path::PathBuf;

use slipfit::{Clock, SignalKind, answer::hint::Hint};
use slipfit_io::{Decimal, Delimiter, ReadOptions, ReadProblem, Reading, TimeSource, read};

slipfit_real_data::tests! {
    real_text_files_are_read_right,
    real_clocks_are_reported_as_they_are,
    real_files_with_a_choice_offer_it,
    real_files_without_times_ask_for_the_rate,
    real_rates_and_steps_are_taken_from_the_file,
    a_real_sound_is_read,
}

/// Path of a file of the ring-downs.
fn ringdown(file: &str) -> PathBuf {
    slipfit_real_data::path("ringdown").join(file)
}

/// Expected result for a file.
struct Expected {
    file: &'static str,
    rate_hz: Option<f64>,
    /// Time column, 0 if there is a rate; signal column.
    columns: (usize, usize),
    unit: &'static str,
    kind: SignalKind,
    rows: u64,
    skipped: u64,
    dialect: (Delimiter, Decimal),
    /// Time of the first and of the last sample, in s, and median step.
    first_s: f64,
    last_s: f64,
    step_s: f64,
    uniform: bool,
}

use Decimal::{Comma as DComma, Point};
use Delimiter::{Blanks, Comma, None as Single, Semicolon, Tab};
use SignalKind::{Acceleration, Displacement, Envelope};

#[rustfmt::skip]
const EXPECTED: &[Expected] = &[
    Expected { file: "pohl_brake_0mA.csv", rate_hz: None, columns: (1, 4), unit: "rad", kind: Displacement, rows: 4985, skipped: 0, dialect: (Semicolon, DComma), first_s: 0.0, last_s: 498.404, step_s: 0.1, uniform: false },
    Expected { file: "pohl_brake_100mA.csv", rate_hz: None, columns: (1, 4), unit: "rad", kind: Displacement, rows: 1590, skipped: 0, dialect: (Semicolon, DComma), first_s: 0.0, last_s: 158.902, step_s: 0.1, uniform: false },
    Expected { file: "pohl_brake_400mA.csv", rate_hz: None, columns: (1, 4), unit: "rad", kind: Displacement, rows: 241, skipped: 0, dialect: (Semicolon, DComma), first_s: 0.0, last_s: 24.001, step_s: 0.1, uniform: false },
    Expected { file: "pohl_brake_700mA.csv", rate_hz: None, columns: (1, 4), unit: "rad", kind: Displacement, rows: 98, skipped: 0, dialect: (Semicolon, DComma), first_s: 0.0, last_s: 9.700, step_s: 0.1, uniform: false },
    Expected { file: "bearing_pendulum_encoder.csv", rate_hz: None, columns: (1, 2), unit: "", kind: Displacement, rows: 22295, skipped: 0, dialect: (Comma, Point), first_s: 4.977, last_s: 74.634, step_s: 0.001, uniform: false },
    Expected { file: "video_pendulum_43cm.txt", rate_hz: None, columns: (1, 2), unit: "", kind: Displacement, rows: 4571, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 152.268, step_s: 0.0333, uniform: false },
    Expected { file: "video_pendulum_swapped_columns.txt", rate_hz: None, columns: (2, 1), unit: "", kind: Displacement, rows: 19553, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 651.455, step_s: 0.03332, uniform: true },
    Expected { file: "rotary_pendulum_no_time_column.txt", rate_hz: Some(1000.0), columns: (0, 1), unit: "", kind: Displacement, rows: 5000, skipped: 0, dialect: (Single, Point), first_s: 0.0, last_s: 4.999, step_s: 0.001, uniform: true },
    Expected { file: "seismometer.txt", rate_hz: None, columns: (1, 2), unit: "V", kind: Displacement, rows: 1288, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 128.7, step_s: 0.1, uniform: true },
    Expected { file: "seismometer_75mm.txt", rate_hz: None, columns: (1, 2), unit: "V", kind: Displacement, rows: 2616, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 261.5, step_s: 0.1, uniform: true },
    Expected { file: "seismometer_near_critical.txt", rate_hz: None, columns: (1, 2), unit: "V", kind: Displacement, rows: 203, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 20.2, step_s: 0.1, uniform: true },
    Expected { file: "string_pendulum.txt", rate_hz: None, columns: (1, 2), unit: "", kind: Displacement, rows: 2330, skipped: 0, dialect: (Blanks, Point), first_s: 0.0, last_s: 116.409, step_s: 0.05, uniform: false },
    Expected { file: "driven_then_free_pendulum.csv", rate_hz: None, columns: (1, 2), unit: "rad", kind: Displacement, rows: 621, skipped: 0, dialect: (Comma, Point), first_s: 0.05, last_s: 31.116, step_s: 0.05, uniform: false },
    Expected { file: "torsion_driven_103s_then_free.txt", rate_hz: None, columns: (1, 3), unit: "", kind: Displacement, rows: 8526, skipped: 0, dialect: (Tab, Point), first_s: 0.0, last_s: 170.5, step_s: 0.02, uniform: true },
    Expected { file: "membrane_dBm.txt", rate_hz: None, columns: (1, 2), unit: "√mW", kind: Envelope, rows: 9998, skipped: 0, dialect: (Comma, Point), first_s: 0.012, last_s: 119.976, step_s: 0.012, uniform: true },
    Expected { file: "phyphox_pendulum.csv", rate_hz: None, columns: (1, 2), unit: "m/s^2", kind: Acceleration, rows: 32304, skipped: 0, dialect: (Comma, Point), first_s: 0.026, last_s: 322.921, step_s: 0.01, uniform: false },
    Expected { file: "spring_sonar_decimal_comma.csv", rate_hz: None, columns: (1, 2), unit: "", kind: Displacement, rows: 11886, skipped: 0, dialect: (Semicolon, Point), first_s: 1.0, last_s: 119.85, step_s: 0.01, uniform: true },
    Expected { file: "spring_no_time_column.csv", rate_hz: Some(100.0), columns: (0, 1), unit: "mm", kind: Displacement, rows: 3039, skipped: 0, dialect: (Single, DComma), first_s: 0.0, last_s: 30.38, step_s: 0.01, uniform: true },
    Expected { file: "phone_accelerometer.txt", rate_hz: None, columns: (4, 1), unit: "", kind: Displacement, rows: 1182, skipped: 2, dialect: (Blanks, Point), first_s: 0.0, last_s: 23.812, step_s: 0.02, uniform: false },
    Expected { file: "two_mode_beats.txt", rate_hz: None, columns: (4, 1), unit: "m/sec^2", kind: Acceleration, rows: 879, skipped: 2, dialect: (Blanks, Point), first_s: 0.0, last_s: 17.685, step_s: 0.02, uniform: false },
    Expected { file: "two_tables_side_by_side.csv", rate_hz: None, columns: (1, 2), unit: "m/s^2", kind: Acceleration, rows: 141, skipped: 43, dialect: (Comma, Point), first_s: 0.0, last_s: 7.227, step_s: 0.052, uniform: false },
    Expected { file: "triple_pendulum_in_water.csv", rate_hz: None, columns: (1, 2), unit: "", kind: Displacement, rows: 1365, skipped: 1171, dialect: (Semicolon, Point), first_s: 0.0, last_s: 45.472, step_s: 0.0333, uniform: true },
];

fn columns(reading: &Reading) -> (usize, usize) {
    let time = match &reading.report.time {
        Some(TimeSource::Column(taken) | TimeSource::Intervals(taken)) => taken.column.number,
        _ => 0,
    };
    (time, reading.report.column("signal").unwrap().column.number)
}

fn real_text_files_are_read_right() {
    for want in EXPECTED {
        let options = ReadOptions { rate_hz: want.rate_hz, ..ReadOptions::default() };
        let reading = read(ringdown(want.file), &options).unwrap_or_else(|e| panic!("{e}"));
        let (file, record, report) = (want.file, &reading.record, &reading.report);
        assert_eq!(columns(&reading), want.columns, "{file}");
        assert_eq!((record.unit(), record.kind()), (want.unit, want.kind), "{file}");
        assert_eq!((report.rows_read, report.rows_skipped()), (want.rows, want.skipped), "{file}");
        assert_eq!(
            (report.dialect.as_ref().unwrap().delimiter, report.dialect.as_ref().unwrap().decimal),
            want.dialect,
            "{file}"
        );
        assert_eq!(record.len() as u64, want.rows, "{file}");
        let times = record.times_s(0..record.len());
        // A rebuilt clock is known to within its deviation from the stamps.
        let close_s = 6e-4 + record.clock_report().rebuilt_excess_s;
        assert!((times[0] - want.first_s).abs() < close_s, "{file}: starts at {}", times[0]);
        assert!(
            (times[times.len() - 1] - want.last_s).abs() < close_s,
            "{file}: ends at {}",
            times[times.len() - 1]
        );
        let step = record.clock_report().median_step_s;
        assert!((step / want.step_s - 1.0).abs() < 0.02, "{file}: step {step}");
        assert_eq!(record.clock().is_uniform(), want.uniform, "{file}");
    }
}

fn real_clocks_are_reported_as_they_are() {
    let clock = |file: &str| {
        let reading = read(ringdown(file), &ReadOptions::default()).unwrap();
        (reading.record.clock().clone(), reading.record.clock_report().clone())
    };
    let (_, encoder) = clock("bearing_pendulum_encoder.csv");
    assert_eq!(encoder.gaps, 1);
    assert!((encoder.longest_gap.unwrap().length_s - 30.667).abs() < 1e-3);
    assert!(encoder.step_spread > 1.0);
    let (rounded, report) = clock("video_pendulum_swapped_columns.txt");
    assert_eq!((report.repeated_stamps, report.rebuilt_quantum_s), (17801, Some(1.0)));
    let Clock::Uniform { interval_s, .. } = rounded else { panic!("{rounded:?}") };
    assert!((interval_s * 30.0127 - 1.0).abs() < 1e-4);
    let (_, report) = clock("triple_pendulum_in_water.csv");
    assert_eq!((report.repeated_stamps, report.rebuilt_quantum_s), (709, Some(0.1)));
    // Times rounded to three digits, with lost rows: the rate is advised.
    let video = read(ringdown("bychai_60deg.txt"), &ReadOptions::default()).unwrap();
    let advice = |n: &slipfit_io::Note| {
        n.hints.iter().any(|h| h.option == Some("rate_hz") && h.to_string().contains("30 is the rate"))
    };
    assert!(video.report.notes.iter().any(advice), "{:?}", video.report.notes);
    let (_, motor) = clock("driven_then_free_pendulum.csv");
    assert_eq!(motor.gaps, 1);
}

fn real_rates_and_steps_are_taken_from_the_file() {
    let reading = |file: &str| read(ringdown(file), &ReadOptions::default()).unwrap();
    let fork = reading("bicycle_fork.mat");
    assert_eq!(fork.report.time, Some(TimeSource::Rate(1000.0)));
    let rig = reading("highrate5_Test001.lvm");
    let Clock::Uniform { interval_s, .. } = *rig.record.clock() else { panic!("rounded times") };
    assert!((interval_s * 51_200.0 - 1.0).abs() < 1e-9, "{interval_s}");
    // A track in pixels next to an angle that was never filled in.
    let track = reading("pixels_240fps.csv");
    assert_eq!((columns(&track), track.record.kind()), ((1, 2), SignalKind::Displacement));
    for (file, time, duration_s) in
        [("lynch_acc.csv", 2, 4.032), ("giosue_senza.txt", 3, 91.5), ("ptibbets_idf_wah.mat", 1, 178.46)]
    {
        let reading = reading(file);
        assert_eq!(columns(&reading).0, time, "{file}");
        let found = reading.record.duration_s();
        assert!((found - duration_s).abs() < 0.06, "{file}: {found}");
    }
}

fn real_files_with_a_choice_offer_it() {
    let tables = ringdown("two_tables_side_by_side.csv");
    let second = read(&tables, &ReadOptions { part: Some(2), ..Default::default() }).unwrap();
    assert_eq!((columns(&second), second.report.parts, second.record.len()), ((5, 6), 2, 184));
    let first = read(&tables, &ReadOptions::default()).unwrap();
    assert_eq!((first.report.parts, first.report.part), (2, 1));
    assert!(
        first.report.notes.iter().any(|note| note.hints.iter().any(|h| h.option == Some("part"))),
        "{:?}",
        first.report.notes
    );
    let pendulum = ringdown("triple_pendulum_in_water.csv");
    let third = read(&pendulum, &ReadOptions { run: Some(3), ..Default::default() }).unwrap();
    assert_eq!((columns(&third), third.report.runs), ((7, 8), 3));
    let pohl = ringdown("pohl_brake_400mA.csv");
    let velocity =
        read(pohl, &ReadOptions { signal: Some("ableitung".into()), ..Default::default() }).unwrap();
    assert_eq!((columns(&velocity), velocity.record.kind()), ((1, 5), SignalKind::Velocity));
    // Its first and last cells are empty: both are counted.
    assert_eq!((velocity.report.rows_read, velocity.report.rows_skipped()), (239, 2));
}

fn real_files_without_times_ask_for_the_rate() {
    let ask = |file: &str| read(ringdown(file), &ReadOptions::default()).unwrap_err();
    let rotary = ask("rotary_pendulum_no_time_column.txt");
    assert!(matches!(rotary.problem, ReadProblem::NoTime { rate_hz: Some(1000.0), .. }), "{rotary}");
    assert!(
        rotary.hints()[0]
            == Hint::new("rate_hz", "takes the rate named in the file's first lines").with(1000.0)
    );
    let spring = ask("spring_no_time_column.csv");
    assert!(spring.hints()[0].to_string().starts_with("rate_hz = RATE"), "{spring}");
}

fn a_real_sound_is_read() {
    let bell = read(ringdown("bell_440hz.wav"), &ReadOptions::default()).unwrap();
    assert_eq!(bell.report.time, Some(TimeSource::Rate(44100.0)));
    assert_eq!(bell.report.bytes, 2_355_756);
    // 16 bit mono with a header of 44 bytes and tags at the end.
    assert!((1_177_000..=1_177_856).contains(&bell.record.len()), "{}", bell.record.len());
    assert!(bell.record.signal().iter().all(|v| v.abs() <= 1.0));
}

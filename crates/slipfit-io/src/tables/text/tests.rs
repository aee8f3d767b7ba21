use std::fmt::Write as _;

use slipfit::{Clock, SignalKind, answer::hint::spelled};

use super::*;
use crate::{Decimal, Delimiter, ReadError, ReadOptions, Reading, TimeSource, hashing::Hashing, read_from};

fn read(text: impl AsRef<[u8]>) -> Reading {
    read_with(text, &ReadOptions::default()).unwrap()
}

fn read_with(text: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Reading, ReadError> {
    read_from(text.as_ref(), "file.csv", options)
}

fn error(text: impl AsRef<[u8]>, options: &ReadOptions) -> (String, String) {
    let error = read_with(text, options).unwrap_err();
    (error.to_string(), spelled(&error.hints(), &|option, _| option.to_owned()))
}

/// A decaying oscillation: times and samples.
fn ring(i: usize) -> (f64, f64) {
    let t = i as f64 / 16.0;
    (t, (1000.0 * (-0.05 * t).exp() * (2.0 * t).cos()).round() / 1000.0)
}

/// The rows of a table whose cells `row` makes.
fn table_of(header: &str, n: usize, row: impl Fn(usize, f64, f64) -> String) -> String {
    let mut text = String::from(header);
    for i in 0..n {
        let (t, x) = ring(i);
        let _ = writeln!(text, "{}", row(i, t, x));
    }
    text
}

fn assert_is_ring(reading: &Reading, n: usize) {
    assert_eq!(reading.record.len(), n);
    for i in 0..n {
        let (t, x) = ring(i);
        assert_eq!(reading.record.signal()[i], x, "sample {i}");
        assert!((reading.record.time_s(i) - t).abs() < 1e-9, "time {i}");
    }
}

fn time_column(reading: &Reading) -> usize {
    match &reading.report.time {
        Some(TimeSource::Column(taken) | TimeSource::Intervals(taken)) => taken.column.number,
        _ => 0,
    }
}

fn signal(reading: &Reading) -> &crate::ColumnTaken {
    reading.report.column("signal").unwrap()
}

fn note(reading: &Reading, at: usize) -> &str {
    &reading.report.notes[at].text
}

#[test]
fn every_delimiter_and_decimal_mark_is_read() {
    for (separator, delimiter) in [
        (",", Delimiter::Comma),
        (";", Delimiter::Semicolon),
        ("\t", Delimiter::Tab),
        ("|", Delimiter::Bar),
        ("  ", Delimiter::Blanks),
        (", ", Delimiter::Comma),
        (" ; ", Delimiter::Semicolon),
    ] {
        for (mark, decimal) in [(".", Decimal::Point), (",", Decimal::Comma)] {
            if mark == "," && separator.contains(',') {
                continue;
            }
            let text = table_of("", 50, |_, t, x| format!("{t:.4}{separator}{x:.3}").replace('.', mark));
            let reading = read(&text);
            assert_is_ring(&reading, 50);
            assert_eq!(reading.report.dialect.as_ref().unwrap().delimiter, delimiter, "{text}");
            assert_eq!(reading.report.dialect.as_ref().unwrap().decimal, decimal, "{text}");
        }
    }
}

#[test]
fn every_line_end_and_a_missing_last_one_is_read() {
    let text = table_of("t,x\n", 40, |_, t, x| format!("{t},{x}"));
    for end in ["\n", "\r\n", "\r", "\r\r\n"] {
        let reading = read(text.replace('\n', end));
        assert_is_ring(&reading, 40);
        assert_eq!(reading.report.dialect.as_ref().unwrap().header_row, Some(1));
        assert_is_ring(&read(text.trim_end().replace('\n', end)), 40);
    }
}

#[test]
fn every_encoding_of_loggers_is_read() {
    let text = table_of("Zeit (s);Winkel (°)\n", 40, |_, t, x| format!("{t};{x}"));
    let utf16 = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
    for (bytes, encoding) in [
        (text.as_bytes().to_vec(), "UTF-8"),
        (marked(b"\xef\xbb\xbf", text.as_bytes()), "UTF-8"),
        (latin, "windows-1252"),
        (marked(b"\xff\xfe", &utf16(u16::to_le_bytes)), "UTF-16LE"),
        (marked(b"\xfe\xff", &utf16(u16::to_be_bytes)), "UTF-16BE"),
        (utf16(u16::to_le_bytes), "UTF-16LE"),
        (utf16(u16::to_be_bytes), "UTF-16BE"),
    ] {
        let reading = read(bytes);
        assert_is_ring(&reading, 40);
        assert_eq!(reading.report.dialect.as_ref().unwrap().encoding, encoding);
        assert_eq!(reading.record.unit(), "°", "{encoding}");
    }
}

#[test]
fn a_long_utf16_file_is_read_across_chunks() {
    let text = table_of("t\tx (mm)\n", 60_000, |_, t, x| format!("{t}\t{x}"));
    let bytes: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert!(bytes.len() > 4 * HEAD);
    assert_is_ring(&read(bytes), 60_000);
}

#[test]
fn a_long_file_is_read_across_chunks_and_its_hash_is_of_all_bytes() {
    let text = table_of("t,x\n", 100_000, |_, t, x| format!("{t},{x}"));
    let reading = read(&text);
    assert_is_ring(&reading, 100_000);
    assert_eq!(reading.report.bytes, text.len() as u64);
    // sha256 of nothing but itself is known: FIPS 180-4 test vector "abc".
    let mut abc = Hashing::new(&b"abc"[..], None);
    std::io::copy(&mut abc, &mut std::io::sink()).unwrap();
    assert_eq!(abc.finish().0, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

#[test]
fn a_preamble_of_forty_lines_is_passed_over_and_its_values_kept() {
    let mut preamble = String::from("Voltage, ChA, Run #1\n");
    for i in 0..37 {
        let _ = writeln!(preamble, "# remark {i}: 1, 2, 3");
    }
    preamble += "Operator;Nobody\nRate = 16\nTime ( s )\tVoltage ( V )\n";
    let reading = read(table_of(&preamble, 40, |_, t, x| format!("{t}\t{x}")));
    assert_is_ring(&reading, 40);
    assert_eq!(reading.report.dialect.as_ref().unwrap().first_data_row, 42);
    assert_eq!(reading.report.dialect.as_ref().unwrap().header_row, Some(41));
    assert!(reading.report.named_values.contains(&("Rate".into(), "16".into())));
}

#[test]
fn a_header_in_a_remark_and_one_with_units_below_are_read() {
    let reading = read(table_of("% a title\n% time [s], power [V]\n", 40, |_, t, x| format!("{t},{x}")));
    assert_eq!(reading.report.columns[1].header, "power [V]");
    let reading = read(table_of("Time,Channel A\n(ms),(mV)\n\n", 40, |_, t, x| format!("{},{x}", t * 1e3)));
    assert_is_ring(&reading, 40);
    assert_eq!(reading.record.unit(), "mV");
    let reading = read(table_of("Time (s)  Angle (rad)\n", 40, |_, t, x| format!("{t}  {x}")));
    assert_eq!(reading.record.unit(), "rad");
    let reading = read(table_of("# time [s] angle [rad]\n", 40, |_, t, x| format!("{t} {x}")));
    assert_eq!(reading.record.unit(), "rad");
}

#[test]
fn quoted_cells_and_headers_with_separators_are_read() {
    let text = table_of("\"Time (s), from start\",\"Angle, \"\"left\"\" (rad)\"\n", 40, |_, t, x| {
        format!("\"{t}\",\"{x}\"")
    });
    let reading = read(text);
    assert_is_ring(&reading, 40);
    assert_eq!(reading.report.columns[1].header, "Angle, \"left\" (rad)");
    let text = table_of("\"Zeit (s)\",\"Weg (mm)\"\n", 40, |_, t, x| {
        format!("\"{t:.4}\",\"{x:.3}\"").replace('.', ",").replace("\",,\"", "\",\"")
    });
    assert_is_ring(&read(text), 40);
}

#[test]
fn rows_without_a_sample_are_counted_by_reason_with_their_first_row() {
    let text = table_of("t,x\n", 60, |i, t, x| match i {
        10 | 20 => format!("{t},NaN"),
        30 => format!("{t}"),
        31 => format!("{t},oops"),
        40 => format!("# {t},{x}"),
        50 => String::new(),
        55 => format!("{t},{x},7,8"),
        _ => format!("{t},{x}"),
    });
    let reading = read(text);
    let found: Vec<(String, u64, u64)> =
        reading.report.skipped.iter().map(|s| (s.reason.clone(), s.rows, s.first_row)).collect();
    let want = |reason: &str, rows, first| (reason.to_owned(), rows, first);
    assert_eq!(
        found,
        [
            want("no value in column 2", 2, 12),
            want("row ends before column 2", 1, 32),
            want("`oops` in column 2 is not a number", 1, 33),
            want("remark", 1, 42),
            want("blank line", 1, 52),
        ]
    );
    assert_eq!(reading.report.rows_read, 54);
    assert_eq!(reading.report.rows_read + reading.report.rows_skipped(), 60);
}

#[test]
fn columns_are_taken_by_name_number_or_part_of_a_name() {
    let text = table_of("t (s);alpha (rad);beta angle (rad)\n", 40, |_, t, x| format!("{t};{};{x}", 2.0 * x));
    for wanted in ["3", "beta angle (rad)", "BETA ANGLE", "beta"] {
        let options = ReadOptions { signal: Some(wanted.into()), ..Default::default() };
        let reading = read_with(&text, &options).unwrap();
        assert_is_ring(&reading, 40);
        assert_eq!(signal(&reading).why, "column 3 `beta angle (rad)`: asked for");
    }
    let ask = |wanted: &str| error(&text, &ReadOptions { signal: Some(wanted.into()), ..Default::default() });
    assert_eq!(
        ask("gamma").0,
        "file.csv: signal = gamma: no such column; there are column 1 `t (s)`, column 2 `alpha (rad)`, column 3 `beta angle (rad)`"
    );
    assert_eq!(
        ask("rad").0,
        "file.csv: signal = rad: could be column 2 `alpha (rad)`, column 3 `beta angle (rad)`"
    );
    assert!(ask("4").0.contains("no such column"));
    assert!(ask("0").0.contains("no such column"));
    assert!(ask("").0.contains("no such column"));
}

#[test]
fn a_position_is_preferred_to_its_derivatives_and_to_spectra() {
    let header =
        "Frequenz f / Hz;FFT / rad;Zeit t / s;Geschwindigkeit v / rad/s;Beschleunigung / rad/s²;Weg / rad\n";
    let reading =
        read(table_of(header, 60, |i, t, x| format!("{i};{};{t};{};{};{x}", 9 * i, 9.0 * x, 99.0 * x)));
    assert_is_ring(&reading, 60);
    assert_eq!((time_column(&reading), signal(&reading).column.number), (3, 6));
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
}

#[test]
fn kinds_follow_names_and_units() {
    for (header, kind, unit) in [
        ("t,v (m/s)\n", SignalKind::Velocity, "m/s"),
        ("t,ω (rad/s)\n", SignalKind::Velocity, "rad/s"),
        ("t,Acceleration y (m/s²)\n", SignalKind::Acceleration, "m/s²"),
        ("t,a (g)\n", SignalKind::Acceleration, "g"),
        ("t,Amplitude (mm)\n", SignalKind::Displacement, "mm"),
        ("t,Angle (deg)\n", SignalKind::Displacement, "deg"),
    ] {
        let reading = read(table_of(header, 40, |_, t, x| format!("{t},{x}")));
        assert_eq!((reading.record.kind(), reading.record.unit()), (kind, unit), "{header}");
    }
    let reading = read(table_of("t,R (V)\n", 40, |_, t, x| format!("{t},{}", x * x + 0.1)));
    assert_eq!(reading.record.kind(), SignalKind::Envelope);
    let options =
        ReadOptions { kind: Some(SignalKind::Velocity), unit: Some("mm/s".into()), ..Default::default() };
    let reading = read_with(table_of("t,x\n", 40, |_, t, x| format!("{t},{x}")), &options).unwrap();
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Velocity, "mm/s"));
}

#[test]
fn decibels_become_linear_amplitudes() {
    let text = table_of("time [s], power [dBm]\n", 40, |i, t, _| format!("{t}, {}", -20.0 - 0.5 * i as f64));
    let reading = read(&text);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Envelope, "√mW"));
    // -20 dBm is 0.01 mW, whose root is 0.1.
    assert!((reading.record.signal()[0] - 0.1).abs() < 1e-15);
    let options = ReadOptions { unit: Some("dB".into()), ..Default::default() };
    let reading = read_with(text.replace("power [dBm]", "level"), &options).unwrap();
    assert!((reading.record.signal()[0] - 0.1).abs() < 1e-15);
    assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Envelope, ""));
}

#[test]
fn lock_in_outputs_are_read_as_a_pair() {
    let row = |_, t, x: f64| format!("{t},{x},{},{},30", 2.0 * x, 3.0 * x.abs());
    for (header, options) in [
        ("t (s),X (V),Y (V),R (V),Theta (deg)\n", ReadOptions::default()),
        ("t,In-Phase,Quadrature,c,d\n", ReadOptions::default()),
        (
            "t,a,b,c,d\n",
            ReadOptions { signal: Some("2".into()), quadrature: Some("3".into()), ..Default::default() },
        ),
    ] {
        let reading = read_with(table_of(header, 40, row), &options).unwrap();
        assert_eq!(reading.record.kind(), SignalKind::LockIn, "{header}");
        let quadrature = reading.record.quadrature().unwrap();
        assert!(quadrature.iter().zip(reading.record.signal()).all(|(q, x)| *q == 2.0 * x), "{header}");
    }
    let reading =
        read(table_of("t (s),R (V),Theta (deg)\n", 40, |i, t, x| format!("{t},{},{i}", x.abs() + 0.1)));
    assert_eq!((reading.record.kind(), signal(&reading).column.number), (SignalKind::Envelope, 2));
}

#[test]
fn positions_in_two_directions_are_no_lock_in() {
    let reading = read(table_of("t\tx\ty\n", 200, |_, t, x| format!("{t}\t{}\t{x}", 0.1 * x * x)));
    assert_eq!(reading.record.kind(), SignalKind::Displacement);
    assert_eq!(signal(&reading).column.number, 3);
}

#[test]
fn time_units_come_from_headers_and_may_be_overridden() {
    for (header, factor) in [
        ("Δt (ms),x\n", 1e3),
        ("time_us,x\n", 1e6),
        ("t [ns],x\n", 1e9),
        ("Zeit / s,x\n", 1.0),
        ("t (µs),x\n", 1e6),
    ] {
        assert_is_ring(&read(table_of(header, 40, |_, t, x| format!("{},{x}", t * factor))), 40);
    }
    assert_is_ring(&read(table_of("Time (min),x\n", 40, |_, t, x| format!("{},{x}", t / 60.0))), 40);
    let text = table_of("t (s),x\n", 40, |_, t, x| format!("{},{x}", t * 1e3));
    let unit = |unit: &str| ReadOptions { time_unit: Some(unit.into()), ..Default::default() };
    assert_is_ring(&read_with(&text, &unit("ms")).unwrap(), 40);
    let (message, hint) = error(&text, &unit("fortnight"));
    assert_eq!(message, "file.csv: time_unit = fortnight: no unit known here");
    assert!(hint.starts_with("time_unit takes"));
}

#[test]
fn steps_since_the_row_before_are_summed() {
    let text = table_of("", 60, |i, _, x| format!("{x} 0.1 {}", if i == 0 { 0.0 } else { 62.5 }));
    let reading = read(text);
    assert!(matches!(reading.report.time, Some(TimeSource::Intervals(_))));
    assert_is_ring(&reading, 60);
}

#[test]
fn tables_side_by_side_and_runs_in_groups_are_chosen() {
    let text = table_of("Time (s),x (mm),,Time (s),x (mm)\n", 40, |i, t, x| {
        if i < 30 { format!("{},{},,{t},{x}", t + 1.0, 2.0 * x) } else { format!(",,,{t},{x}") }
    });
    let first = read(&text);
    assert_eq!((first.report.parts, first.report.part, first.record.len()), (2, 1, 30));
    assert!(first.report.notes.iter().any(|n| n.hints[0].option == Some("part")));
    let table = |n| ReadOptions { part: Some(n), ..Default::default() };
    assert_is_ring(&read_with(&text, &table(2)).unwrap(), 40);
    assert_eq!(error(&text, &table(3)).0, "file.csv: part = 3: the file has 2");
    for header in [
        "t1,theta1,omega1,t2,theta2,omega2\n",
        "Time (s) Run #1,Angle (rad) Run #1,v (rad/s) Run #1,Time (s) Run #2,Angle (rad) Run #2,v (rad/s) Run #2\n",
        "Latest: Time (s),Latest: Angle (rad),Latest: v (rad/s),Run 1: Time (s),Run 1: Angle (rad),Run 1: v (rad/s)\n",
    ] {
        let text = table_of(header, 40, |_, t, x| format!("{},{},{x},{t},{x},{}", t + 1.0, 2.0 * x, 5.0 * x));
        assert_eq!(read(&text).record.signal()[0], 2.0, "{header}");
        let second = read_with(&text, &ReadOptions { run: Some(2), ..Default::default() }).unwrap();
        assert_is_ring(&second, 40);
        assert_eq!((second.report.runs, second.report.run), (2, 2));
        let by_column =
            read_with(&text, &ReadOptions { signal: Some("5".into()), ..Default::default() }).unwrap();
        assert_is_ring(&by_column, 40);
    }
    let shared =
        table_of("Time (s),Angle (rad) Run #1,Angle (rad) Run #2\n", 40, |_, t, x| format!("{t},9,{x}"));
    assert_is_ring(&read_with(&shared, &ReadOptions { run: Some(2), ..Default::default() }).unwrap(), 40);
}

#[test]
fn a_rate_stands_for_a_time_column_and_a_missing_one_is_asked_for() {
    let text = table_of("Position (mm) Run #1\n", 60, |i, _, x| {
        if i == 30 { "--".into() } else { format!("{x:.3}").replace('.', ",") }
    });
    let (message, hint) = error(&text, &ReadOptions::default());
    assert_eq!(message, "file.csv: no column of times among column 1 `Position (mm) Run #1`");
    assert!(hint.starts_with("rate_hz"), "{hint}");
    let rated = ReadOptions { rate_hz: Some(16.0), ..Default::default() };
    let reading = read_with(&text, &rated).unwrap();
    assert_eq!((reading.record.len(), reading.record.unit()), (59, "mm"));
    assert!((reading.record.time_s(30) - 31.0 / 16.0).abs() < 1e-12);
    let hinted = format!("angle_deg, sample_rate\n45, 1000\n{}", table_of("", 40, |_, _, x| x.to_string()));
    assert!(error(&hinted, &ReadOptions::default()).1.starts_with("rate_hz takes"));
    let both = ReadOptions { time: Some("1".into()), ..rated };
    assert_eq!(error(&text, &both).0, "file.csv: time = 1: not together with a sampling rate");
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-310] {
        let (_, hint) = error(&text, &ReadOptions { rate_hz: Some(rate_hz), ..Default::default() });
        assert!(hint.contains("rate_hz"));
    }
}

#[test]
fn names_that_do_not_fit_the_columns_give_way_to_the_numbers() {
    let reading = read(table_of("x y dx dy\n", 60, |_, t, x| format!("{x}\t{t}")));
    assert_is_ring(&reading, 60);
    assert_eq!(
        note(&reading, 0),
        "line 1 names 4 columns (`x y dx dy`) but the rows hold 2: its names were not used"
    );
    let reading = read(table_of("time,angle\n", 60, |_, t, x| format!("{x},{t}")));
    assert_eq!(time_column(&reading), 2);
    let note = "column 1 `time` is named like a time but does not go up; column 2 `angle` does";
    assert_eq!(self::note(&reading, 0), note);
}

#[test]
fn bad_files_are_refused_with_a_reason_and_a_way_out() {
    let message = |bytes: &[u8]| error(bytes, &ReadOptions::default()).0;
    assert_eq!(message(b""), "file.csv: the file is empty");
    assert_eq!(message(b" \r\n\t\n"), "file.csv: the file is empty");
    assert_eq!(message(b"\xef\xbb\xbf"), "file.csv: the file is empty");
    assert_eq!(
        message(b"hello\nworld\n"),
        "file.csv: no table of numbers in the first 2 lines; the first line reads `hello`"
    );
    assert!(message(b"t,x\n0,1\n").ends_with("column 2 `x`: usable rows 1, needed at least 8"));
    let nan = table_of("t,x\n", 40, |_, t, _| format!("{t},NaN"));
    assert_eq!(
        message(nan.as_bytes()),
        "file.csv: no column could be the signal among column 1 `t`, column 2 `x`"
    );
    let blank = table_of("t,x\n", 40, |i, t, x| if i > 4 { format!("{t},") } else { format!("{t},{x}") });
    assert_eq!(
        message(blank.as_bytes()),
        "file.csv: column 2 `x`: usable rows 5, needed at least 8; left out: no value in column 2 (row 7 and others)"
    );
    let constant = table_of("t,x\n", 40, |_, t, _| format!("{t},0.5"));
    assert_eq!(message(constant.as_bytes()), "file.csv: column 2 `x` is constant (0.5): nothing oscillates");
    let backwards = table_of("t (s),x (m)\n", 40, |_, t, x| format!("{},{x}", 9.0 - t));
    let (text, hint) = error(&backwards, &ReadOptions::default());
    assert_eq!(text, "file.csv, row 3: column 1 `t (s)`: time goes backwards (9 s, then 8.9375 s)");
    assert!(hint.contains("time "));
    assert_eq!(message(b"t,x\n1,2\0\n"), "file.csv: this is not text: byte 0x00 at position 7");
    assert_eq!(message(b"BZh9"), "file.csv: this is a bzip2 file, which is not read yet");
    let still = table_of("t,x\n", 40, |_, _, x| format!("3,{x}"));
    assert_eq!(message(still.as_bytes()), "file.csv: time stands still: every stamp is 3 s");
}

#[test]
fn a_line_without_end_is_no_table() {
    let mut text = table_of("t,x\n", 40, |_, t, x| format!("{t},{x}"));
    text.extend(std::iter::repeat_n("1,", LONGEST_LINE));
    let message = error(&text, &ReadOptions::default()).0;
    assert_eq!(message, "file.csv, row 42: a line of more than 4194304 bytes: this is not a table");
    let message = error("1 ".repeat(HEAD), &ReadOptions::default()).0;
    assert!(message.starts_with("file.csv, row 1: a line of more than"), "{message}");
}

#[test]
fn a_file_that_starts_again_keeps_its_longest_run() {
    let mut text = table_of("t,x\n", 30, |_, t, x| format!("{t},{x}"));
    text += &table_of("t,x\n", 50, |_, t, x| format!("{t},{x}"));
    let reading = read(text);
    assert_is_ring(&reading, 50);
    assert_eq!(reading.record.clock_report().resets, 1);
    assert_eq!(reading.report.skipped[0].reason, "`t` in column 1 is not a number");
}

#[test]
fn a_ring_down_is_told_from_its_drive_by_its_numbers() {
    let text = table_of("", 2000, |i, t, x| {
        let drive = if i < 900 { 30.0 * (2.0 * t).sin() } else { 0.0 };
        format!("{t}\t{drive}\t{x}")
    });
    let reading = read(text);
    assert_is_ring(&reading, 2000);
    assert_eq!(signal(&reading).why, "column 3: oscillates and dies down most among column 2, column 3");
    assert!(matches!(reading.record.clock(), Clock::Uniform { .. }));
}

#[test]
fn rows_with_words_beside_their_numbers_are_read() {
    let reading = read(table_of("time,state,angle\n", 40, |_, t, x| format!("{t},OK,{x}")));
    assert_is_ring(&reading, 40);
    assert_eq!(signal(&reading).column.number, 3);
    let clock = table_of("time,angle\n", 40, |i, _, x| format!("noon and {i},{x}"));
    let (message, hint) = error(&clock, &ReadOptions::default());
    assert_eq!(message, "file.csv: no column of times among column 1 `time`, column 2 `angle`");
    assert!(hint.starts_with("rate_hz"));
}

#[test]
fn key_value_cells_beside_the_first_rows_are_no_header() {
    let text = table_of("", 60, |i, t, x| {
        let key = if i < 5 { "Record Length,2.5e3" } else { "," };
        format!("{key},,{t},{x}")
    });
    let reading = read(text);
    assert_eq!((time_column(&reading), signal(&reading).column.number), (4, 5));
    assert_eq!(reading.report.columns[3].header, "");
    assert!(note(&reading, 0).starts_with("line 5 holds numbers"));
}

#[test]
fn a_counter_of_rows_is_no_time_unless_named_or_asked_for() {
    let text = table_of("", 60, |i, _, x| format!("{i},{x}"));
    assert!(error(&text, &ReadOptions::default()).1.contains("time "));
    let asked = ReadOptions { time: Some("1".into()), ..Default::default() };
    assert_eq!(read_with(&text, &asked).unwrap().record.time_s(59), 59.0);
    assert_eq!(read(format!("time (s),x\n{text}")).record.time_s(59), 59.0);
    let rated = ReadOptions { rate_hz: Some(16.0), ..Default::default() };
    assert_is_ring(&read_with(&text, &rated).unwrap(), 60);
}

#[test]
fn whole_numbers_some_apart_are_milliseconds_and_said_to_be() {
    let reading = read(table_of("", 64, |i, _, x| format!("{} {x}", i * 50)));
    assert_eq!(reading.record.duration_s(), 3.15);
    assert!(note(&reading, 0).contains("50.0 apart: they were taken as milliseconds"));
}

#[test]
fn equal_steps_under_the_name_of_a_step_are_summed() {
    assert_is_ring(&read(table_of("dt (ms),x (mm)\n", 40, |_, _, x| format!("62.5,{x}"))), 40);
}

#[test]
fn names_units_and_the_step_of_labview_are_kept() {
    let header = "LabVIEW Measurement,\nSeparator,Comma\n***End_of_Header***,\n,\nChannels,2,,\n\
                  Samples,300,300,\nY_Unit_Label,m/s^2,V,\nX_Dimension,Time,Time,\nX0,0.0,0.0,\n\
                  Delta_X,1.953125E-5,1.953125E-5,\n***End_of_Header***,,,\n\
                  X_Value,Acceleration_0,Voltage,Comment\n";
    let row = |i: usize, _: f64, x: f64| format!("{:.5},{x},{}", i as f64 * 1.953_125e-5, (i * 7919) % 13);
    let options = ReadOptions { signal: Some("Acceleration_0".into()), ..Default::default() };
    let reading = read_with(table_of(header, 300, row), &options).unwrap();
    assert_eq!(reading.report.dialect.as_ref().unwrap().convention, Some("LabVIEW"));
    assert_eq!(signal(&reading).column.header, "Acceleration_0");
    assert_eq!((time_column(&reading), reading.record.unit()), (1, "m/s^2"));
    assert_eq!(reading.record.kind(), SignalKind::Acceleration);
    let Clock::Uniform { interval_s, .. } = *reading.record.clock() else { panic!("rounded times") };
    assert!((interval_s / 1.953_125e-5 - 1.0).abs() < 1e-12, "{interval_s}");
    // Times that are no multiples of the step stay.
    let row = |i: usize, _: f64, x: f64| format!("{:.5},{x},1", i as f64 * 2.0e-5);
    let step = read(table_of(header, 300, row)).record.clock_report().median_step_s;
    assert!((step - 2.0e-5).abs() < 1e-9, "{step}");
}

#[test]
fn names_of_labview_without_its_first_lines_are_kept() {
    let reading = read(table_of("X_Value\tT5\tExpansion Out\tComment\n", 99, |_, t, x| {
        format!("{t:.6}\t{}\t{x}", 50.0 + 0.01 * t)
    }));
    assert_eq!((time_column(&reading), signal(&reading).column.number), (1, 3));
    assert_eq!(signal(&reading).column.header, "Expansion Out");
}

#[test]
fn clocks_since_1970_are_in_their_unit_and_give_way_to_seconds_since_the_start() {
    let stamp = |t: f64| 1_662_729_295_900_810_000_u64 + (t * 1e9) as u64;
    let both = table_of("time,seconds_elapsed,x\n", 99, |_, t, x| format!("{},{t},{x}", stamp(t)));
    let reading = read(both);
    assert_eq!(time_column(&reading), 2);
    assert_is_ring(&reading, 99);
    for (unit, divisor) in [("ns", 1), ("us", 1_000), ("ms", 1_000_000)] {
        let one = table_of("time,x\n", 99, |_, t, x| format!("{},{x}", stamp(t) / divisor));
        let reading = read(one);
        assert!((reading.record.clock_report().median_step_s - 0.0625).abs() < 1e-3, "{unit}");
        assert!((reading.record.duration_s() - 6.125).abs() < 2e-3, "{unit}");
        assert!(note(&reading, 0).contains(&format!("were taken as {unit}")), "{}", note(&reading, 0));
    }
}

#[test]
fn names_and_units_on_two_lines_of_remarks_are_joined() {
    let header = "#Creator: buffer\n#Time A\tPos A\n#[s]\t[au]\n";
    let reading = read(table_of(header, 99, |_, t, x| format!("{t}\t{x}")));
    assert_is_ring(&reading, 99);
    assert_eq!(signal(&reading).column.header, "Pos A (au)");
    assert_eq!(reading.record.unit(), "au");
}

#[test]
fn each_sensor_has_its_own_times() {
    let header = "#Time A\tPos A\tTime B\tPos B\n#[s]\t[au]\t[s]\t[au]\n";
    let still = |i: usize| 500.0 + 0.01 * ((i * 7919) % 3) as f64;
    let row = |i: usize, t: f64, x: f64| format!("{}\t{}\t{t}\t{x}", t + 0.025, still(i));
    let reading = read(table_of(header, 99, row));
    assert_eq!((time_column(&reading), signal(&reading).column.number), (3, 4));
    assert_is_ring(&reading, 99);
}

#[test]
fn files_that_are_not_read_are_named_with_the_way_out() {
    for (bytes, named, way) in [
        (&b"TDSm\x0e\0\0\0i\x12\0\0"[..], "LabVIEW TDMS", "npTDMS"),
        (b"MDF     4.10    asammdf", "ASAM MDF", "asammdf"),
        (b"    -1\n    58\nbeam\n 1.0 2.0\n", "universal file", "pyuff"),
        (b"\x80\x04\x95\x10\0\0\0\0\0\0\0]", "Python pickle", "numpy.savez"),
    ] {
        let (message, hint) = error(bytes, &ReadOptions::default());
        assert!(message.contains(named), "{message}; {hint}");
        assert!(hint.contains(way), "{message}; {hint}");
    }
}

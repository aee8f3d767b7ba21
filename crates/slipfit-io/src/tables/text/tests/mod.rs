//! Text as written by loggers.

mod columns;

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

/// A table whose rows are made by `row`.
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
    // A known SHA-256: FIPS 180-4 test vector "abc".
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
    let said: Vec<String> = reading.report.skipped.iter().map(ToString::to_string).collect();
    assert_eq!(said[0], "2 rows (no value in column 2), the first in row 12");
    assert_eq!(said[1], "row 32 (row ends before column 2)");
    assert_eq!(reading.report.rows_read, 54);
    assert_eq!(reading.report.rows_read + reading.report.rows_skipped(), 60);
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
    assert!(message(b"t,x\n0,1\n").ends_with("column 2 `x` has only 1 usable row; at least 8 are needed"));
    let nan = table_of("t,x\n", 40, |_, t, _| format!("{t},NaN"));
    assert_eq!(
        message(nan.as_bytes()),
        "file.csv: no column could be the signal; the file has column 1 `t`, column 2 `x`"
    );
    let blank = table_of("t,x\n", 40, |i, t, x| if i > 4 { format!("{t},") } else { format!("{t},{x}") });
    assert_eq!(
        message(blank.as_bytes()),
        "file.csv: column 2 `x` has only 5 usable rows; at least 8 are needed; left out: no value in column 2 (row 7 and others)"
    );
    let constant = table_of("t,x\n", 40, |_, t, _| format!("{t},0.5"));
    assert_eq!(message(constant.as_bytes()), "file.csv: column 2 `x` is constant (0.5): nothing oscillates");
    let backwards = table_of("t (s),x (m)\n", 40, |_, t, x| format!("{},{x}", 9.0 - t));
    let (text, hint) = error(&backwards, &ReadOptions::default());
    let told = "file.csv, row 3: column 1 `t (s)`: time goes backwards (9 s, then 8.9375 s), as in every step: the record \
                runs from its end to its start; reverse its rows";
    assert_eq!(text, told);
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
    assert_eq!((reading.report.runs, reading.report.run), (2, 2));
    assert_eq!(
        reading.report.notes[1].to_string(),
        "the clock restarts: 2 runs follow one another; number 2, the longest, was read; run reads another"
    );
}

#[test]
fn each_run_of_a_file_that_starts_again_can_be_asked_for() {
    let lengths = [30, 50, 20];
    let run = |n: &usize| table_of("", *n, |_, t, x| format!("{t},{x}"));
    let text = format!("t,x\n{}", lengths.iter().map(run).collect::<String>());
    let of = |run: usize| read_with(&text, &ReadOptions { run: Some(run), ..Default::default() });
    for (number, length) in (1..).zip(lengths) {
        let reading = of(number).unwrap();
        assert_is_ring(&reading, length);
        assert_eq!((reading.report.runs, reading.report.run), (3, number));
        assert_eq!(reading.report.rows_read, 100);
        let said = format!("3 runs follow one another; number {number} was read");
        assert!(note(&reading, 1).ends_with(&said), "{:?}", reading.report.notes);
    }
    for none in [0, 4] {
        assert_eq!(of(none).unwrap_err().to_string(), format!("file.csv: run = {none}: the file has only 3"));
    }
}

#[test]
fn a_run_that_is_not_there_is_refused_with_and_without_times() {
    let second = ReadOptions { run: Some(2), ..Default::default() };
    let timed = table_of("t,x\n", 40, |_, t, x| format!("{t},{x}"));
    assert_eq!(error(&timed, &second).0, "file.csv: run = 2: the file has only 1");
    let rated = ReadOptions { rate_hz: Some(16.0), ..second };
    let bare = table_of("x\n", 40, |_, _, x| x.to_string());
    assert_eq!(error(&bare, &rated).0, "file.csv: run = 2: the file has only 1");
    let first = ReadOptions { run: Some(1), ..rated };
    assert_is_ring(&read_with(&bare, &first).unwrap(), 40);
}

#[test]
fn rows_with_words_beside_their_numbers_are_read() {
    let reading = read(table_of("time,state,angle\n", 40, |_, t, x| format!("{t},OK,{x}")));
    assert_is_ring(&reading, 40);
    assert_eq!(signal(&reading).column.number, 3);
    let clock = table_of("time,angle\n", 40, |i, _, x| format!("noon and {i},{x}"));
    let (message, hint) = error(&clock, &ReadOptions::default());
    assert_eq!(message, "file.csv: no column of times; the file has column 1 `time`, column 2 `angle`");
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
    assert_eq!((reading.record.len(), reading.report.rows_skipped()), (60, 0));
    assert!(note(&reading, 0).starts_with("columns 1 to 3 hold settings next to the first 5 rows"));
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
    // Times that are not multiples of the step are kept.
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
fn names_and_units_on_two_lines_of_remarks_are_joined() {
    let header = "#Creator: buffer\n#Time A\tPos A\n#[s]\t[au]\n";
    let reading = read(table_of(header, 99, |_, t, x| format!("{t}\t{x}")));
    assert_is_ring(&reading, 99);
    assert_eq!(signal(&reading).column.header, "Pos A (au)");
    assert_eq!(reading.record.unit(), "au");
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

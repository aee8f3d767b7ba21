//! Headers of units only, headers of three rows, wrapped values, and columns that are not a signal.

use slipfit::SignalKind;
use slipfit_io::{ReadOptions, Reading, SweepReading, TimeSource, read_from, read_sweep_from};

const ROWS: usize = 240;

/// A decaying oscillation: time (s) and position.
fn swing(k: usize) -> (f64, f64) {
    let t = k as f64 * 0.02;
    (t, (1e5 * (-0.1 * t).exp() * (9.0 * t).cos()).round() / 1e3)
}

fn rows(of: impl Fn(usize) -> String) -> String {
    (0..ROWS).map(|k| of(k) + "\n").collect()
}

fn read(text: &str) -> Reading {
    read_from(text.as_bytes(), "swing.csv", &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn notes(reading: &Reading) -> String {
    reading.report.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Compares every number of a record of the swing over 4.78 s.
fn assert_is_swing(reading: &Reading) {
    let record = &reading.record;
    assert_eq!(record.len(), ROWS);
    for k in 0..ROWS {
        assert!((record.signal()[k] - swing(k).1).abs() < 1e-9, "row {k}");
        assert!((record.time_s(k) - record.time_s(0) - swing(k).0).abs() < 1e-9, "row {k}");
    }
}

#[test]
fn units_alone_name_the_columns() {
    for (header, unit, kind) in [
        ("s,V", "V", SignalKind::Displacement),
        ("ms,mV", "mV", SignalKind::Displacement),
        ("s,mm", "mm", SignalKind::Displacement),
        ("s,m/s", "m/s", SignalKind::Velocity),
        ("s,g", "g", SignalKind::Acceleration),
        ("s,m", "m", SignalKind::Displacement),
    ] {
        let scale = if header.starts_with("ms") { 1e3 } else { 1.0 };
        let text = format!("{header}\n{}", rows(|k| format!("{},{}", swing(k).0 * scale, swing(k).1)));
        let reading = read(&text);
        assert_is_swing(&reading);
        assert_eq!((reading.record.unit(), reading.record.kind()), (unit, kind), "{header}");
        assert_eq!(notes(&reading), "", "{header}");
    }
    let reading = sweep("Hz,V", |f, a, _| format!("{f},{a}"), &ReadOptions::default());
    assert_eq!(reading.curve.unit(), "V");
    assert!((reading.curve.frequency_hz()[0] - 76.0).abs() < 1e-9);
    // If one of them is not a unit, they are names.
    assert_eq!(
        read(&format!("t,v\n{}", rows(|k| format!("{},{}", swing(k).0, swing(k).1)))).record.unit(),
        ""
    );
}

#[test]
fn a_third_row_of_a_header_leaves_names_and_units() {
    for third in ["run 7\tfork 3", "Comments\t", "----\t----", "FLOAT\tFLOAT", "CH0\tCH1"] {
        let cells = rows(|k| format!("{:.0}\t{}", 1e3 * swing(k).0, swing(k).1));
        let reading = read(&format!("Time\tDeflection\r\nms\tV\r\n{third}\r\n{cells}"));
        assert_is_swing(&reading);
        assert_eq!(
            (reading.record.unit(), reading.record.kind()),
            ("V", SignalKind::Displacement),
            "{third}"
        );
        assert!(notes(&reading).contains("line 3 below the units was not read"), "{}", notes(&reading));
    }
    let cells = rows(|k| format!("\"2024-03-12 10:22:{:05.2}\",{k},{},12.6", 10.0 + swing(k).0, swing(k).1));
    let text = "\"TOA5\",\"CR6\",\"CR6\",\"1234\",\"CR6.Std.08\",\"CPU:prog.CR6\",\"12345\",\"Fast\"\n\
                \"TIMESTAMP\",\"RECORD\",\"Accel_Z\",\"BattV\"\n\"TS\",\"RN\",\"m/s^2\",\"Volts\"\n\
                \"\",\"\",\"Smp\",\"Smp\"\n";
    let reading = read(&format!("{text}{cells}"));
    assert_is_swing(&reading);
    assert_eq!((reading.record.unit(), reading.record.kind()), ("m/s^2", SignalKind::Acceleration));
    assert_eq!(reading.report.column("signal").unwrap().column.header, "Accel_Z (m/s^2)");
}

/// The values of the swing, `width` per line.
fn wrapped(width: usize) -> String {
    let values: Vec<String> = (0..ROWS - 1).map(|k| format!("{:12.3}", swing(k).1)).collect();
    values.chunks(width).map(|line| line.concat() + "\n").collect()
}

#[test]
fn values_wrapped_over_several_columns_are_one_signal() {
    let n = ROWS - 1;
    for (width, header, unit, kind) in [
        (
            5,
            format!(
                "PEER NGA STRONG MOTION\nRoof, 090\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   {n}, DT=   .0200 SEC,"
            ),
            "G",
            SignalKind::Acceleration,
        ),
        (
            6,
            format!(
                "TIMESERIES AM_R1_00_ENN_D, {n} samples, 50 sps, 2024-03-12T10:22:33.0, SLIST, INTEGER, Counts"
            ),
            "Counts",
            SignalKind::Displacement,
        ),
        (
            6,
            format!(
                "TIMESERIES AM_R1_00_ENN_D, {n} samples, 50 sps, 2024-03-12T10:22:33.0, SLIST, INTEGER, Counts"
            ),
            "Counts",
            SignalKind::Displacement,
        ),
        (
            8,
            format!(
                "Roof Chan 3, {n} points of accel data equally spaced at .020 sec, in cm/sec2.  (8f12.3)"
            ),
            "cm/sec2",
            SignalKind::Acceleration,
        ),
        (5, format!("# NPTS = {n}\n# dt = 0.02"), "", SignalKind::Displacement),
    ] {
        let mut lines = wrapped(width);
        if header.starts_with("TIMESERIES") {
            // With tabs, including one at the end of each line.
            let tabs = |line: &str| {
                line.split_whitespace().map(|cell| format!("{cell}\t")).collect::<String>() + "\n"
            };
            lines = lines.lines().map(tabs).collect();
        }
        let reading = read(&format!("{header}\n{lines}"));
        let record = &reading.record;
        assert_eq!((record.len(), record.unit(), record.kind()), (n, unit, kind), "{header}");
        assert!(matches!(reading.report.time, Some(TimeSource::Rate(rate)) if (rate - 50.0).abs() < 1e-9));
        for k in 0..n {
            assert!((record.signal()[k] - swing(k).1).abs() < 1e-9, "{header}: value {k}");
        }
        let said = format!("the {n} values that the header states stand in");
        assert!(notes(&reading).contains(&said), "{}", notes(&reading));
    }
    // If there are as many rows as values stated in the header, rows are rows.
    let text =
        format!("# NPTS = {ROWS}\n# dt = 0.02\n{}", rows(|k| format!("{} {}", swing(k).1, 0.1 * swing(k).1)));
    assert_eq!(read(&text).record.len(), ROWS);
    const LONG: usize = 300_000;
    let long: String = (0..LONG).map(|k| format!("{:.2} {:.7}\n", swing(k).0, swing(k % ROWS).1)).collect();
    assert!(long.len() > 4 << 20);
    assert_eq!(read(&format!("# {LONG} points\n# dt = 0.02\n{long}")).record.len(), LONG);
}

#[test]
fn a_wrapped_value_that_is_missing_is_counted() {
    let text = wrapped(5).replacen(&format!("{:12.3}", swing(12).1), &format!("{:>12}", "n/a"), 1);
    let reading = read(&format!("NPTS= {}, DT= .02 SEC\n{text}", ROWS - 1));
    assert_eq!(reading.report.rows_read, ROWS as u64 - 2);
    assert_eq!(reading.report.skipped.iter().map(|s| (s.first_row, s.rows)).collect::<Vec<_>>(), [(13, 1)]);
}

/// A resonance at 80 Hz: frequency, amplitude and phase in degrees.
fn resonance(k: usize) -> (f64, f64, f64) {
    let f = 76.0 + 0.04 * k as f64;
    let (re, im) = (6400.0 - f * f, 0.8 * f);
    (f, 100.0 / re.hypot(im), -im.atan2(re).to_degrees())
}

fn sweep(header: &str, row: impl Fn(f64, f64, f64) -> String, options: &ReadOptions) -> SweepReading {
    let text = format!(
        "{header}\n{}",
        rows(|k| {
            let (f, a, p) = resonance(k);
            row(f, a, p)
        })
    );
    read_sweep_from(text.as_bytes(), "sweep.csv", options).unwrap_or_else(|e| panic!("{header}: {e}"))
}

fn assert_is_resonance(reading: &SweepReading, what: &str) {
    assert_eq!(reading.curve.frequency_hz().len(), ROWS, "{what}");
    for k in 0..ROWS {
        let (f, a, _) = resonance(k);
        assert!(
            (reading.curve.frequency_hz()[k] - f).abs() < 1e-6,
            "{what}: {}",
            reading.curve.frequency_hz()[k]
        );
        assert!((reading.curve.response().amplitude(k) / a - 1.0).abs() < 1e-6, "{what}");
    }
}

#[test]
fn a_column_that_stays_as_it_is_is_no_response_beside_one_that_moves() {
    let options = ReadOptions::default();
    let reading = sweep(
        "Frequency (Hz),Reference (V),Signal (V),Phase (deg)",
        |f, a, p| format!("{f},1,{a},{p}"),
        &options,
    );
    assert_is_resonance(&reading, "reference");
    assert_eq!(reading.report.column("amplitude").unwrap().column.number, 3);
}

#[test]
fn multiples_of_hertz_and_their_names_are_units_of_frequency() {
    for (unit, factor) in [
        ("1000 Hz", 1e3),
        ("x1000 Hz", 1e3),
        ("10^3 Hz", 1e3),
        ("kilohertz", 1e3),
        ("megahertz", 1e6),
        ("cpm", 1.0 / 60.0),
    ] {
        let header = format!("Frequency ({unit}),Amplitude (V)");
        let reading = sweep(&header, |f, a, _| format!("{},{a}", f / factor), &ReadOptions::default());
        assert_is_resonance(&reading, unit);
        assert!(reading.report.notes.iter().all(|n| !n.to_string().contains("names no unit")), "{unit}");
    }
}

#[test]
fn parts_of_one_scattering_parameter_are_read_together() {
    let choose = |real: Option<&str>, amplitude: Option<&str>| ReadOptions {
        real: real.map(str::to_owned),
        amplitude: amplitude.map(str::to_owned),
        ..ReadOptions::default()
    };
    let parts = |a: f64, p: f64| (a * p.to_radians().cos(), a * p.to_radians().sin());
    let ri = |f: f64, a: f64, p: f64| {
        let (re, im) = parts(a, p);
        format!("{f:.2} 0.9 0.1 {re:.12} {im:.12} {re:.12} {im:.12} 0.9 0.2")
    };
    for (real, header) in [("4", "S21"), ("6", "S12")] {
        let reading = sweep("! VNA\n# Hz S RI R 50", ri, &choose(Some(real), None));
        assert_is_resonance(&reading, header);
        let imaginary = reading.report.column("imaginary").unwrap();
        assert!(imaginary.column.header.starts_with(header), "{imaginary:?}");
    }
    // By default the reflection is read, with a hint on how to select the transmission.
    let reading = sweep("! VNA\n# Hz S RI R 50", ri, &ReadOptions::default());
    let hints: Vec<(&str, Option<String>)> = reading
        .report
        .notes
        .iter()
        .flat_map(|note| &note.hints)
        .map(|hint| (hint.option.unwrap_or_default(), hint.value.as_ref().map(|v| format!("{v:?}"))))
        .collect();
    let options: Vec<&str> = hints.iter().map(|(option, _)| *option).collect();
    assert!(options.contains(&"real") && options.contains(&"imaginary"), "{hints:?}");
    let ma = |f: f64, a: f64, p: f64| format!("{f:.2} 0.9 0.1 {a:.12} {p:.9} {a:.12} {p:.9} 0.9 0.2");
    for (amplitude, phase) in [("4", 5), ("6", 7)] {
        let reading = sweep("! VNA\n# Hz S MA R 50", ma, &choose(None, Some(amplitude)));
        assert_is_resonance(&reading, amplitude);
        assert_eq!(reading.report.column("phase").unwrap().column.number, phase);
    }
}

#[test]
fn phases_over_pi_are_multiples_of_it() {
    for header in ["φ/π", "phase/pi", "Phase [π]", "phi (units of pi)"] {
        let header = format!("Frequency (Hz),Amplitude (V),{header}");
        let reading = sweep(&header, |f, a, p| format!("{f},{a},{}", p / 180.0), &ReadOptions::default());
        let slipfit::resonance::Response::Complex(z) = reading.curve.response() else { panic!("{header}") };
        let phase = z[ROWS / 2].arg();
        assert!((phase - resonance(ROWS / 2).2.to_radians()).abs() < 1e-6, "{header}: {phase}");
    }
}

#[test]
fn a_column_says_more_than_the_name_of_its_file() {
    let row = |k: usize| {
        let (t, x) = swing(k);
        format!("{t:.2},{x},{},{}", -0.2 * x, -81.0 * x)
    };
    for (header, kind) in [
        ("t,x,v,a", SignalKind::Displacement),
        ("Time (s),position (m),Velocity (m/s),Acceleration (m/s^2)", SignalKind::Displacement),
        ("t,x,y,z", SignalKind::Acceleration),
    ] {
        let text = format!("{header}\n{}", rows(row));
        let options = ReadOptions { signal: Some("2".to_owned()), ..ReadOptions::default() };
        let reading = read_from(text.as_bytes(), "motion_acc.csv", &options).unwrap();
        assert_eq!(reading.record.kind(), kind, "{header}");
    }
}

#[test]
fn letters_of_channels_and_pins_are_no_accelerations() {
    for header in ["A", "a0", "A0", "Channel A"] {
        let reading =
            read(&format!("Time (s),{header}\n{}", rows(|k| format!("{},{}", swing(k).0, swing(k).1))));
        assert_eq!(reading.record.kind(), SignalKind::Displacement, "{header}");
    }
    let pins = read(&format!("t,a0,a1\n{}", rows(|k| format!("{},7,{}", swing(k).0, swing(k).1))));
    assert_eq!(
        (pins.record.kind(), pins.report.column("signal").unwrap().column.number),
        (SignalKind::Displacement, 3)
    );
    let reading = read(&format!("t,a\n{}", rows(|k| format!("{},{}", swing(k).0, swing(k).1))));
    assert_eq!(reading.record.kind(), SignalKind::Acceleration);
}

#[test]
fn pieces_of_lines_before_the_first_row_leave_the_clock_in_milliseconds() {
    let cells = rows(|k| format!("{},{}", 20 * k, swing(k).1));
    for before in ["", "34,12.\n7.12\n", "7.5,1\n", "52340,0.4\nStarting ...\n", "512\nready\n"] {
        let reading = read(&format!("{before}{cells}"));
        assert!(notes(&reading).contains("taken as milliseconds"), "{before}: {}", notes(&reading));
    }
    // A line of words after the first row is not a header.
    for stray in ["ready,go", "20,oops", "ready"] {
        let cells = cells.replacen('\n', &format!("\n{stray}\n"), 1);
        let reading = read(&format!("Time (ms),x (mm)\n{cells}"));
        assert_is_swing(&reading);
        assert_eq!((reading.record.unit(), reading.report.skipped[0].rows), ("mm", 1), "{stray}");
    }
}

#[test]
fn day_numbers_get_the_hint_of_days() {
    for day in [45_363.0, 739_323.0] {
        let cells = rows(|k| format!("{:.10},{}", day + 0.4 + swing(k).0 / 86_400.0, swing(k).1));
        let reading = read(&format!("Time,Angle (rad)\n{cells}"));
        assert!(notes(&reading).contains("days"), "{}", notes(&reading));
    }
    let reading = read(&format!("Time,Angle (rad)\n{}", rows(|k| format!("{},{}", swing(k).0, swing(k).1))));
    assert!(!notes(&reading).contains("days"), "{}", notes(&reading));
}

#[test]
fn lines_of_an_oscilloscope_name_the_unit_of_its_samples() {
    for line in ["Vertical Units,V", "YUnits:,Volt", "\"VUnit\",\"V\""] {
        let cells = rows(|k| format!("{},{}", swing(k).0, swing(k).1));
        let reading = read(&format!("Model,X1\n{line}\nHorizontal Units,s\nTIME,CH1\n{cells}"));
        assert_eq!(reading.record.unit().chars().next(), Some('V'), "{line}");
    }
}

#[test]
fn headers_of_blocks_are_no_samples() {
    let block = |from: usize| {
        let rows: String = (from..from + ROWS / 2).map(|k| format!("\t{:.6}\n", swing(k).1)).collect();
        format!(
            "Channels\t1\t\nSamples\t{}\t\nDate\t2024/03/12\t\nX0\t{}\t\nDelta_X\t0.020000\t\n***End_of_Header***\t\t\n\
             X_Value\tVoltage_0\tComment\n{rows}\t\t\n",
            ROWS / 2,
            from as f64 * 0.02
        )
    };
    let text = format!(
        "LabVIEW Measurement\t\nSeparator\tTab\nMulti_Headings\tYes\nX_Columns\tNo\n***End_of_Header***\t\n\t\n{}{}",
        block(0),
        block(ROWS / 2)
    );
    let reading = read(&text);
    let record = &reading.record;
    let at = |k: usize| (record.time_s(k) - record.time_s(0), record.signal()[k]);
    let last = record.len() - 1;
    assert_eq!(reading.report.rows_read, ROWS as u64, "{:?}", reading.report.skipped);
    let (t, x) = at(last);
    assert!((x - swing(ROWS - 1).1).abs() < 1e-9 && t < 5.0, "{t} s: {x}");
    assert!(reading.report.skipped.iter().any(|s| s.reason.contains("block's header") && s.rows == 7));
}

#[test]
fn rows_between_brackets_are_rows() {
    for ends in [["[", "]"], ["(", "),"], ["[", "],"]] {
        let reading = read(&rows(|k| format!("{}{:.2}, {}{}", ends[0], swing(k).0, swing(k).1, ends[1])));
        assert_is_swing(&reading);
    }
}

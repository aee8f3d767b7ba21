//! Texts with several tables below each other, each with its own header.

use slipfit_io::{ReadOptions, SweepReading, read_from, read_sweep_from, read_tables_from};

const ROWS: usize = 200;

/// A decaying oscillation in m: time (s) and position.
fn swing(k: usize) -> (f64, f64) {
    let t = k as f64 * 0.02;
    (t, 0.1 * (-0.1 * t).exp() * (9.0 * t).cos())
}

fn rows(of: impl Fn(usize) -> String) -> String {
    (0..ROWS).map(|k| of(k) + "\n").collect()
}

fn in_mm(k: usize) -> String {
    let (t, x) = swing(k);
    format!("{:.0},{:.4}", 1e3 * t, 1e3 * x)
}

fn in_metres(k: usize) -> String {
    let (t, x) = swing(k);
    format!("{t:.2},{x:.7}")
}

fn with_sheet(sheet: &str) -> ReadOptions {
    ReadOptions { sheet: Some(sheet.to_owned()), ..ReadOptions::default() }
}

/// Reads a swing of 4 s that begins at 100 mm; returns the notes.
fn assert_is_swing(text: &str, options: &ReadOptions, unit: &str) -> Vec<String> {
    let reading = read_from(text.as_bytes(), "stacked.csv", options).unwrap();
    let record = &reading.record;
    assert_eq!((record.len(), record.unit()), (ROWS, unit));
    assert!((record.time_s(ROWS - 1) - record.time_s(0) - 3.98).abs() < 1e-9);
    let scale = if unit == "m" { 1.0 } else { 1e3 };
    assert!((record.signal()[0] / scale - 0.1).abs() < 1e-7);
    reading.report.notes.iter().map(ToString::to_string).collect()
}

#[test]
fn tables_with_headers_of_their_own_are_read_apart() {
    let metres = rows(in_metres);
    let text = format!("Time (s),Position (m)\n{metres}\nTime (ms),Position (mm)\n{}", rows(in_mm));
    let notes = assert_is_swing(&text, &ReadOptions::default(), "m");
    assert!(
        notes.iter().any(|n| n.contains("of 2 tables, `table 1` was read") && n.contains("`table 2`")),
        "{notes:?}"
    );
    assert_is_swing(&text, &with_sheet("table 2"), "mm");
    assert_is_swing(&text, &with_sheet("2"), "mm");
    // Without a blank line, and with a different unit in one column only.
    let text = format!(
        "Time (s),Position (m)\n{metres}Time (s),Position (mm)\n{}",
        rows(|k| {
            let (t, x) = swing(k);
            format!("{t:.2},{:.4}", 1e3 * x)
        })
    );
    assert_is_swing(&text, &ReadOptions::default(), "m");
    assert_is_swing(&text, &with_sheet("2"), "mm");
    // Titles are their names.
    let text =
        format!("Left\nTime (s),Position (m)\n{metres}\nRight\nTime (ms),Position (mm)\n{}", rows(in_mm));
    assert_is_swing(&text, &with_sheet("right"), "mm");
}

#[test]
fn the_first_table_that_fits_is_read_and_rows_keep_their_lines() {
    let temperatures: String = (0..40).map(|k| format!("{k},{:.2}\n", 21.0 + 0.01 * f64::from(k))).collect();
    let text = format!(
        "One\nTime (s),Temperature (C)\n{temperatures}\nTwo\nTime (ms),Position (mm)\n{}",
        rows(in_mm)
    );
    let notes = assert_is_swing(&text, &ReadOptions::default(), "mm");
    assert!(notes.iter().any(|n| n.contains("`Two` was read")), "{notes:?}");
    let first = format!("(mm)\n{}\n", in_mm(0));
    // A force next to the times is used if no table contains a motion.
    let forces = rows(|k| format!("{:.2},{:.3}", swing(k).0, 0.1 * swing(k).1));
    let below = format!("One\nTime (s),Force (N)\n{forces}\nTwo\nTime (ms),Position (mm)\n{}", rows(in_mm));
    assert_is_swing(&below, &ReadOptions::default(), "mm");
    let broken = text.replace(&first, &format!("{first}10,oops\n"));
    let report = read_from(broken.as_bytes(), "stacked.csv", &ReadOptions::default()).unwrap().report;
    assert_eq!(report.skipped.iter().map(|s| (s.first_row, s.rows)).collect::<Vec<_>>(), [(47, 1)]);
    let dialect = report.dialect.unwrap();
    assert_eq!((dialect.header_row, dialect.first_data_row), (Some(45), 46));
}

#[test]
fn tables_of_other_widths_are_found_above_and_below_the_longest() {
    let wide = rows(|k| {
        let (t, x) = swing(k);
        format!("{t:.2},{x:.7},{:.3}", 0.3 * x)
    });
    let short: String = (0..20).map(|k| format!("{k},{}\n", 50 + k % 3)).collect();
    let text = format!(
        "Frequency (Hz),Noise (dB)\n{short}\nTime (s),Position (m),Force (N)\n{wide}\nTime (s),Load (N)\n{short}"
    );
    let tables = read_tables_from(text.as_bytes(), "stacked.csv", usize::MAX).unwrap().tables;
    let shapes: Vec<(usize, usize)> =
        tables.iter().map(|table| (table.columns.len(), table.rows())).collect();
    assert_eq!(shapes, [(2, 20), (3, ROWS), (2, 20)]);
    assert_eq!(tables[2].columns[1].header, "Load (N)");
}

#[test]
fn runs_of_the_same_columns_stay_one_table() {
    let run = rows(in_metres);
    for header in
        ["Time (s),Position (m)\n", "\nRun 2\nTime (s),Position (m)\n", "\n\"Time (s)\",\"Position (m)\"\n"]
    {
        let text = format!("Time (s),Position (m)\n{run}{header}{run}");
        let reading = read_from(text.as_bytes(), "runs.csv", &ReadOptions::default()).unwrap();
        assert_eq!((reading.report.runs, reading.record.len()), (2, ROWS), "{header}");
    }
    // Words among the rows are not a header.
    let text = format!("Time (s),Position (m)\n{run}paused,resumed\n{run}");
    let reading = read_from(text.as_bytes(), "runs.csv", &ReadOptions::default()).unwrap();
    assert_eq!(reading.report.runs, 2);
}

/// A resonance at 80 Hz: frequency, amplitude and phase in degrees.
fn resonance(k: usize) -> (f64, f64, f64) {
    let f = 76.0 + 0.04 * k as f64;
    let (re, im) = (6400.0 - f * f, 0.8 * f);
    (f, 100.0 / re.hypot(im), -im.atan2(re).to_degrees())
}

fn sweep(text: &str, options: &ReadOptions) -> SweepReading {
    read_sweep_from(text.as_bytes(), "vna.csv", options).unwrap()
}

#[test]
fn channels_of_a_network_analyser_are_curves_of_their_own() {
    let of = |amplitude: &dyn Fn(f64, f64) -> f64| {
        rows(|k| {
            let (f, a, p) = resonance(k);
            format!("{f},{:.7}", amplitude(a, p))
        })
    };
    let block = |channel: u32, name: &str, rows: &str| {
        format!("BEGIN CH{channel}_DATA\nFreq(Hz),{name}\n{rows}END\n\n")
    };
    let linear = of(&|a, _| a);
    for (name, second) in [("S21 Phase(deg)", of(&|_, p| p)), ("S21 Lin Mag(U)", of(&|a, _| 0.5 * a))] {
        let text = format!(
            "!CSV A.01.01\n!Keysight Technologies\n\n{}{}",
            block(1, "S21 Lin Mag(U)", &linear),
            block(2, name, &second)
        );
        let reading = sweep(&text, &ReadOptions::default());
        assert_eq!(reading.curve.frequency_hz().len(), ROWS);
        assert!((reading.curve.response().amplitude(0) - resonance(0).1).abs() < 1e-6);
        let notes: Vec<String> = reading.report.notes.iter().map(ToString::to_string).collect();
        assert!(notes.iter().any(|n| n.contains("of 2 tables, `CH1_DATA` was read")), "{notes:?}");
        if name.contains("Mag") {
            let second = sweep(&text, &with_sheet("ch2"));
            assert!((second.curve.response().amplitude(0) - 0.5 * resonance(0).1).abs() < 1e-6);
        }
    }
}

#[test]
fn a_table_below_a_long_one_is_left_out_and_counted() {
    const LONG: usize = 600_000;
    let mut text = String::from("Time (s),Position (m)\n");
    for k in 0..LONG {
        let (t, x) = swing(k);
        text += &format!("{t:.2},{x:.7}\n");
    }
    assert!(text.len() > 9 << 20);
    text += "\nTime (ms),Position (mm)\n";
    text += &rows(in_mm);
    let reading = read_from(text.as_bytes(), "long.csv", &ReadOptions::default()).unwrap();
    assert_eq!(reading.record.len(), LONG);
    let skipped = &reading.report.skipped;
    let other = skipped.iter().find(|s| s.reason.contains("another table")).unwrap();
    assert_eq!((other.first_row, other.rows), (LONG as u64 + 3, ROWS as u64 + 1));
}

//! Records as written by loggers and buffers.

use slipfit_io::{ReadOptions, Reading, read_from};

fn read(text: &str, options: &ReadOptions) -> Reading {
    read_from(text.as_bytes(), "swing.csv", options).unwrap_or_else(|e| panic!("{e}"))
}

fn swing(i: u32) -> f64 {
    let t = 0.05 * f64::from(i);
    (-0.1 * t).exp() * (5.0 * t).cos()
}

#[test]
fn numbers_that_stand_for_none_are_left_out_and_counted() {
    for (mark, rows) in [
        ("-999", vec![0, 1, 2, 3, 4]),
        ("-999", vec![100, 101]),
        ("9999", vec![399]),
        ("1e30", vec![0, 399]),
        ("9.91E+37", vec![50, 60, 70]),
        ("-9999.99", vec![398, 399]),
    ] {
        let row = |i: u32| {
            let value = if rows.contains(&i) { mark.to_owned() } else { swing(i).to_string() };
            format!("{},{value}\n", 0.05 * f64::from(i))
        };
        // A blank line, so that rows are not simply lines minus a header.
        let lines: Vec<String> = (0..400).map(row).collect();
        let text = format!("time (s),x (m)\n\n{}", lines.concat());
        let reading = read(&text, &ReadOptions::default());
        assert_eq!(reading.record.len(), 400 - rows.len(), "{mark}");
        assert_eq!(reading.report.rows_read as usize, 400 - rows.len(), "{mark}");
        let sentinel =
            reading.report.skipped.iter().find(|s| s.reason.contains("stands for no value")).unwrap();
        assert_eq!(
            (sentinel.rows as usize, sentinel.first_row),
            (rows.len(), u64::from(rows[0]) + 3),
            "{mark}"
        );
        assert!(sentinel.reason.contains("column 2"), "{}", sentinel.reason);
        assert!(reading.record.signal().iter().all(|v| v.abs() <= 1.0), "{mark}");
    }
}

#[test]
fn samples_at_a_rate_keep_their_time_where_a_number_stands_for_none() {
    let text: String = (0..400)
        .map(|i| if i == 100 || i == 101 { "-999\n".to_owned() } else { format!("{}\n", swing(i)) })
        .collect();
    let options = ReadOptions { rate_hz: Some(20.0), ..Default::default() };
    let reading = read(&format!("x (m)\n{text}"), &options);
    assert_eq!((reading.record.len(), reading.report.rows_read), (398, 398));
    assert!((reading.record.time_s(100) - 102.0 / 20.0).abs() < 1e-12, "{}", reading.record.time_s(100));
    assert_eq!(reading.report.skipped[0].first_row, 102);
}

#[test]
fn echoes_that_a_motion_detector_lost_are_left_out_and_counted() {
    for lost in ["6.000", "0.000"] {
        let row = |i: u32| {
            let value = if i % 29 == 3 { lost.to_owned() } else { format!("{:.4}", 0.8 + 0.2 * swing(i)) };
            format!("{},{value}\n", 0.05 * f64::from(i))
        };
        let text = format!("Time (s),Position (m)\n{}", (0..400).map(row).collect::<String>());
        let reading = read(&text, &ReadOptions::default());
        assert_eq!((reading.record.len(), reading.report.rows_skipped()), (386, 14), "{lost}");
        assert_eq!(reading.report.skipped[0].first_row, 5, "{lost}");
        assert!(reading.report.skipped[0].reason.contains("stands for no value"));
    }
}

#[test]
fn the_column_that_swings_is_found_beneath_what_stands_for_none() {
    let text: String = (0..400)
        .map(|i| {
            let x = if i < 8 { -999.0 } else { swing(i) };
            format!("{},{},{x}\n", 0.05 * f64::from(i), 0.01 * f64::from(i % 7))
        })
        .collect();
    let reading = read(&format!("time (s),x (m),y (m)\n{text}"), &ReadOptions::default());
    assert_eq!(reading.report.column("signal").unwrap().column.number, 3);
}

#[test]
fn cells_with_units_and_errors_are_numbers() {
    let text: String = (0..100)
        .map(|i| format!("{:.2} s;{:.4} \u{b1} 0.01 mm\n", 0.05 * f64::from(i), swing(i)))
        .collect::<String>()
        .replace('.', ",");
    let reading = read(&format!("Zeit;Weg\n{text}"), &ReadOptions::default());
    assert_eq!((reading.record.len(), reading.record.unit()), (100, "mm"));
    assert!((reading.record.signal()[10] - swing(10)).abs() < 1e-4);
    assert!((reading.record.time_s(99) - 4.95).abs() < 1e-9);
    assert!(
        reading.report.notes.iter().any(|n| n.text.contains("cells hold more than numbers")),
        "{:?}",
        reading.report.notes
    );
}

#[test]
fn a_unit_given_against_that_of_the_header_is_stated() {
    let text: String = (0..400).map(|i| format!("{},{}\n", 0.05 * f64::from(i), swing(i))).collect();
    let stated = |unit: &str, header: &str| {
        let options = ReadOptions { unit: Some(unit.to_owned()), ..Default::default() };
        let notes = read(&format!("t (s),{header}\n{text}"), &options).report.notes;
        notes.iter().any(|n| n.text.contains("is headed mm; its numbers were taken as m, the unit given"))
    };
    assert!(stated("m", "x (mm)"));
    assert!(!stated("mm", "x (mm)"));
    assert!(!stated("m", "x"));
}

//! Sheets of workbooks that contain more than a table.
#![cfg(feature = "excel")]

use std::io::{Cursor, Write as _};

use slipfit::SignalKind;
use slipfit_io::{ReadOptions, Reading, TimeSource, read_from};
use zip::write::{SimpleFileOptions, ZipWriter};

fn swing(row: usize) -> f64 {
    let t = 0.02 * row as f64;
    0.2 * (-0.15 * t).exp() * (9.0 * t).cos()
}

/// A number or a word.
type Cell = Result<f64, &'static str>;

/// A table of 400 rows that begins at a given row and column, with other cells around it.
fn cells(
    header: [&'static str; 2],
    step: f64,
    at: [usize; 2],
    others: &[(usize, usize, Cell)],
) -> Vec<Vec<Option<Cell>>> {
    let mut rows = vec![vec![None; at[1] + 8]; at[0] + 401];
    for (column, name) in header.into_iter().enumerate() {
        rows[at[0]][at[1] + column] = Some(Err(name));
    }
    for k in 0..400 {
        rows[at[0] + 1 + k][at[1]] = Some(Ok(step * k as f64));
        rows[at[0] + 1 + k][at[1] + 1] = Some(Ok(swing(k)));
    }
    for &(row, column, cell) in others {
        rows[row][column] = Some(cell);
    }
    rows
}

fn archive(members: &[(&str, String)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in members {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(text.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The cells as an Excel workbook; `style` is that of the first column.
fn xlsx(rows: &[Vec<Option<Cell>>], style: usize) -> Vec<u8> {
    let cell = |row: usize, column: usize, cell: &Cell| {
        let name = format!("{}{}", char::from(b'A' + column as u8), row + 1);
        match cell {
            Ok(number) if column == 0 => format!(r#"<c r="{name}" s="{style}"><v>{number}</v></c>"#),
            Ok(number) => format!(r#"<c r="{name}"><v>{number}</v></c>"#),
            Err(word) => format!(r#"<c r="{name}" t="inlineStr"><is><t>{word}</t></is></c>"#),
        }
    };
    let row = |(row, cells): (usize, &Vec<Option<Cell>>)| {
        let filled = cells.iter().enumerate().filter_map(|(column, c)| Some(cell(row, column, c.as_ref()?)));
        format!(r#"<row r="{}">{}</row>"#, row + 1, filled.collect::<String>())
    };
    let sheet: String = rows.iter().enumerate().map(row).collect();
    archive(&[
        ("xl/workbook.xml", r#"<workbook><sheets><sheet name="S" r:id="r1"/></sheets></workbook>"#.to_owned()),
        (
            "xl/_rels/workbook.xml.rels",
            r#"<Relationships><Relationship Id="r1" Target="worksheets/s.xml"/></Relationships>"#.to_owned(),
        ),
        (
            "xl/styles.xml",
            r#"<styleSheet><numFmts><numFmt numFmtId="164" formatCode="yyyy-mm-dd h:mm:ss"/></numFmts><cellXfs><xf numFmtId="0"/><xf numFmtId="164"/></cellXfs></styleSheet>"#.to_owned(),
        ),
        ("xl/worksheets/s.xml", format!("<worksheet><sheetData>{sheet}</sheetData></worksheet>")),
    ])
}

/// The cells as a LibreOffice spreadsheet.
fn ods(rows: &[Vec<Option<Cell>>]) -> Vec<u8> {
    let cell = |cell: &Option<Cell>| match cell {
        None => "<table:table-cell/>".to_owned(),
        Some(Ok(number)) => {
            format!(r#"<table:table-cell office:value-type="float" office:value="{number}"/>"#)
        }
        Some(Err(word)) => {
            format!(
                r#"<table:table-cell office:value-type="string"><text:p>{word}</text:p></table:table-cell>"#
            )
        }
    };
    let row = |cells: &Vec<Option<Cell>>| {
        format!("<table:table-row>{}</table:table-row>", cells.iter().map(cell).collect::<String>())
    };
    let sheet: String = rows.iter().map(row).collect();
    archive(&[
        ("mimetype", "application/vnd.oasis.opendocument.spreadsheet".to_owned()),
        (
            "content.xml",
            format!(
                r#"<office:document-content><table:table table:name="S">{sheet}</table:table></office:document-content>"#
            ),
        ),
    ])
}

/// Compares all samples of the table; returns the record and the notes.
fn whole(bytes: &[u8], what: &str) -> (Reading, String) {
    let reading = read_from(bytes, what, &ReadOptions::default()).unwrap_or_else(|e| panic!("{what}: {e}"));
    let found: Vec<f64> = reading.record.signal().to_vec();
    let wanted: Vec<f64> = (0..400).map(swing).collect();
    assert_eq!(found, wanted, "{what}");
    assert!((reading.record.time_s(399) - 7.98).abs() < 1e-9, "{what}: {}", reading.record.time_s(399));
    let notes: Vec<&str> = reading.report.notes.iter().map(|note| note.text.as_str()).collect();
    let notes = notes.join("\n");
    (reading, notes)
}

#[test]
fn values_beside_the_first_rows_take_no_header_and_no_row() {
    let in_ms = ["Time [ms]", "Acceleration [m/s^2]"];
    let statistics = [(1, 3, Err("Mean")), (1, 4, Ok(0.5)), (2, 3, Err("Std")), (2, 4, Ok(0.1))];
    let parameter = [(0, 2, Err("Length (m)")), (1, 2, Ok(0.2))];
    let further = [(10, 5, Err("Mean")), (10, 6, Ok(0.5))];
    for (what, others) in [("statistics", &statistics[..]), ("parameter", &parameter), ("further", &further)]
    {
        let rows = cells(in_ms, 20.0, [0, 0], others);
        for bytes in [xlsx(&rows, 0), ods(&rows)] {
            let (reading, notes) = whole(&bytes, what);
            assert_eq!((reading.record.kind(), reading.record.unit()), (SignalKind::Acceleration, "m/s^2"));
            assert!(notes.contains("next to the table: "), "{what}: {notes}");
        }
    }
    let (reading, notes) = whole(&xlsx(&cells(in_ms, 20.0, [0, 0], &statistics), 0), "notes");
    assert!(notes.contains("left out 4 cells, D2 to E3, next to the table"), "{notes}");
    assert!(notes.contains("`Mean 0.5`, `Std 0.1`"), "{notes}");
    let named =
        |name: &str| reading.report.named_values.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
    assert_eq!((named("Mean"), named("Std")), (Some("0.5"), Some("0.1")));
    // The table begins elsewhere, below a title.
    let around = [(1, 0, Err("Swing")), (5, 0, Err("run")), (5, 7, Err("Mean")), (5, 8, Ok(0.5))];
    whole(&xlsx(&cells(["Time [s]", "Angle [rad]"], 0.02, [4, 2], &around), 0), "offset");
}

#[test]
fn a_rate_beside_samples_without_times_is_taken() {
    for (what, others) in [
        ("beside", vec![(2, 3, Err("Sample rate (Hz)")), (2, 4, Ok(50.0))]),
        ("above", vec![(0, 1, Err("Sample rate (Hz)")), (0, 2, Ok(50.0))]),
    ] {
        let mut rows = cells(["", "x (mm)"], 0.02, [1, 0], &others);
        rows.iter_mut().skip(1).for_each(|row| row[0] = None);
        let (reading, notes) = whole(&xlsx(&rows, 0), what);
        assert_eq!(reading.report.time, Some(TimeSource::Rate(50.0)), "{what}: {notes}");
    }
}

#[test]
fn dates_of_excel_are_dates() {
    // 2024-03-12 10:22:33, counted in days from 1899-12-30.
    let mut rows = cells(["Timestamp", "Angle (rad)"], 0.02 / 86400.0, [0, 0], &[]);
    for row in &mut rows[1..] {
        row[0] = row[0].map(|days: Cell| days.map(|days| 45_363.432_326_388_89 + days));
    }
    let reading = read_from(&xlsx(&rows, 1)[..], "dates", &ReadOptions::default()).unwrap();
    let notes: String = reading.report.notes.iter().map(|note| note.text.as_str()).collect();
    assert!(notes.contains("column 1 holds date and time, such as `2024-03-12 10:22:33.000"), "{notes}");
    assert!(!notes.contains("1970"), "{notes}");
    let times = reading.record.times_s(0..400);
    for (k, time) in times.iter().enumerate() {
        // Times in days are resolved to 0.6 microseconds.
        assert!((time - 37_353.0 - 0.02 * k as f64).abs() < 1e-6, "row {k}: {time}");
    }
    // Times of day remain in seconds.
    rows[1..].iter_mut().for_each(|row| row[0] = row[0].map(|days: Cell| days.map(|days| days - 45_363.0)));
    let reading = read_from(&xlsx(&rows, 1)[..], "times", &ReadOptions::default()).unwrap();
    assert!((reading.record.time_s(0) - 37_353.0).abs() < 1e-6, "{}", reading.record.time_s(0));
}

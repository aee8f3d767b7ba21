//! JSON in the arrangements that programs write.

use slipfit::SignalKind;
use slipfit_io::{Format, ReadOptions, TimeSource, read_from};

use crate::texts::{ROWS, STEP_S, swing, x};

#[test]
fn json_of_any_arrangement_is_the_same_record() {
    let t = |k: usize| k as f64 * STEP_S;
    let joined = |row: &dyn Fn(usize) -> String, by: &str| (0..ROWS).map(row).collect::<Vec<_>>().join(by);
    let rows = joined(&|k| format!("[{:?}, {:?}]", t(k), x(k)), ",\n  ");
    let objects = |by| joined(&|k| format!("{{\"t (s)\": {:?}, \"x (mm)\": {:?}}}", t(k), x(k)), by);
    let times = joined(&|k| format!("{:?}", t(k)), ", ");
    let values = joined(&|k| format!("{:?}", x(k)), ", ");
    let by_index = |value: fn(f64) -> f64| joined(&|k| format!("\"{k}\": {:?}", value(k as f64)), ", ");
    let (index_t, index_x) = (by_index(|k| k * STEP_S), by_index(|k| x(k as usize)));
    for (text, unit) in [
        (format!("[\n  {rows}\n]\n"), ""),
        (format!("[[\"t (s)\", \"x (mm)\"], {rows}]"), "mm"),
        (format!("[[{times}], [{values}]]"), ""),
        (format!("[{}]", objects(", ")), "mm"),
        (objects("\n"), "mm"),
        (format!("{{\"t (s)\": [{times}], \"x (mm)\": [{values}]}}"), "mm"),
        (format!("{{\"data\": [{rows}]}}"), ""),
        (
            format!(
                "{{\"device\": {{\"id\": 7}}, \"run\": {{\"t (s)\": [{times}], \"x (mm)\": [{values}]}}}}"
            ),
            "mm",
        ),
        (format!("{{\"t (s)\": {{{index_t}}}, \"x (mm)\": {{{index_x}}}}}"), "mm"),
        (format!("{{\"columns\": [\"t (s)\", \"x (mm)\"], \"index\": [0, 1], \"data\": [{rows}]}}"), "mm"),
        (format!("{{\"fs\": 50, \"x (mm)\": [{values}]}}"), "mm"),
        (
            format!(
                "{{\"results\": [{{\"series\": [{{\"name\": \"swing\", \"columns\": [\"t (s)\", \"x (mm)\"], \"values\": [{rows}]}}]}}]}}"
            ),
            "mm",
        ),
        (joined(&|k| format!("{{\"ms\": {}, \"acc\": {{\"x (mm)\": {:?}}}}}", 20 * k, x(k)), "\n"), "mm"),
        (
            joined(&|k| format!("{{\"at\": \"12:34:{:06.3}\", \"x (mm)\": \"{}\"}}", 5.0 + t(k), x(k)), "\n"),
            "mm",
        ),
    ] {
        let reading = swing(text.as_bytes());
        assert_eq!(reading.record.unit(), unit, "{text:.80}");
        assert_eq!(reading.report.format, Format::Json, "{text:.80}");
    }
}

#[test]
fn channels_of_json_have_a_name_a_unit_and_a_rate_each() {
    let channel = |name: &str, rate: u32| {
        let values: Vec<String> = (0..ROWS).map(|k| format!("{:?}", x(k))).collect();
        let values = values.join(", ");
        format!(
            "{{\"name\": \"{name}\", \"unit\": \"rad\", \"sampleRate\": {rate}, \"samples\": [{values}]}}"
        )
    };
    let alone = swing(format!("{{\"channels\": [{}]}}", channel("Angle", 50)).as_bytes());
    assert_eq!((alone.record.unit(), &*alone.report.columns[0].header), ("rad", "Angle (rad)"));
    let text = format!("{{\"channels\": [{}, {}]}}", channel("Base", 10), channel("Angle", 50));
    for (sheet, rate_hz) in [("channels.1", 10.0), ("channels.2", 50.0)] {
        let options = ReadOptions { sheet: Some(sheet.to_owned()), ..Default::default() };
        let reading = read_from(text.as_bytes(), "swing.json", &options).unwrap();
        assert_eq!(reading.report.time, Some(TimeSource::Rate(rate_hz)), "{sheet}");
    }
}

#[test]
fn rows_of_several_sensors_are_tables_named_after_them() {
    let row = |sensor: &str, k: usize, gain: f64| {
        let t = k as f64 * STEP_S;
        format!("{{\"sensor\": \"{sensor}\", \"seconds_elapsed\": \"{t:?}\", \"z\": \"{:?}\"}}", gain * x(k))
    };
    let read = |text: &str, sheet: Option<&str>| {
        let options = ReadOptions { sheet: sheet.map(str::to_owned), ..Default::default() };
        read_from(text.as_bytes(), "swing.json", &options)
    };
    for (sensor, kind) in [
        ("Accelerometer", SignalKind::Acceleration),
        ("Gyroscope", SignalKind::Velocity),
        ("Pendulum", SignalKind::Displacement),
    ] {
        let rows: Vec<String> = (0..ROWS).map(|k| row(sensor, k, 1.0)).collect();
        let reading = swing(format!("[{}]", rows.join(", ")).as_bytes());
        assert_eq!((reading.record.kind(), &*reading.report.sheet), (kind, sensor));
    }
    let both = |k| [row("Accelerometer", k, 1.0), row("Gravity", k, 2.0)].join(", ");
    let rows: Vec<String> = (0..ROWS).map(both).collect();
    let text = format!("[{{\"version\": 3, \"sensor\": \"Metadata\"}}, {}]", rows.join(", "));
    let reading = read(&text, Some("accelerometer")).unwrap();
    assert_eq!(reading.record.kind(), SignalKind::Acceleration);
    assert_eq!(reading.record.signal(), (0..ROWS).map(x).collect::<Vec<_>>());
    assert!(reading.report.named_values.contains(&("version".to_owned(), "3".to_owned())));
    let reading = read(&text, Some("gravity")).unwrap();
    assert_eq!(reading.record.signal(), (0..ROWS).map(|k| 2.0 * x(k)).collect::<Vec<_>>());
    let refused = read(&text, None).unwrap_err();
    assert!(refused.to_string().contains("`Accelerometer` (seconds_elapsed, z); `Gravity`"), "{refused}");
    assert!(refused.hints().iter().any(|hint| hint.option == Some("sheet")), "{refused}");
}

#[test]
fn missing_values_of_json_are_counted_and_broken_json_is_refused() {
    let object = |k: usize| {
        let value = if k % 50 == 7 {
            ["null", "NaN", "\"overflow\""][k / 50 % 3].to_owned()
        } else {
            x(k).to_string()
        };
        format!("{{\"t\": {:?}, \"x\": {value}}}", k as f64 * STEP_S)
    };
    let text = (0..ROWS).map(object).collect::<Vec<_>>().join("\n");
    let reading = read_from(text.as_bytes(), "swing.json", &ReadOptions::default()).unwrap();
    assert_eq!((reading.record.len(), reading.report.rows_skipped()), (ROWS - 6, 6));
    assert_eq!(reading.report.skipped[0].first_row, 8, "{:?}", reading.report.skipped);
    let said = |text: &str| {
        read_from(text.as_bytes(), "swing.json", &ReadOptions::default()).unwrap_err().to_string()
    };
    for (text, problem) in [
        (&text[..text.len() - 5], "line 300"),
        (&text[..text.len() - 5], "cannot be read as"),
        ("{\"name\": \"pendulum\"}", "no table in it can be read: it holds no list of numbers"),
        ("[[[[1, 2], [\"a\"]]]]", "no table of numbers"),
    ] {
        assert!(said(text).contains(problem), "{}", said(text));
    }
    // Names that are different in every row would require a table of a million cells.
    let scattered: Vec<String> = (0..3000).map(|k| format!("{{\"a{k}\": {k}}}")).collect();
    assert!(said(&format!("[{}]", scattered.join(","))).contains("scattered over 3000 rows"));
    let several = format!("{{\"a\": [{text}], \"b\": [{text}]}}", text = text.replace('\n', ","));
    assert!(said(&several).contains("`a` (t, x); `b` (t, x)"), "{}", said(&several));
}

//! The files of `examples/` through the browser's face: the same answers as through the libraries.

use serde_json::Value;
use slipfit_wasm::{Analysis, File, Options, analyse, preview};

fn example(name: &str) -> Vec<u8> {
    let path = format!("{}/../../examples/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn options(json: &str) -> Options {
    Options::parse(json).unwrap_or_else(|e| panic!("{json}: {}", e.message))
}

#[test]
fn every_example_is_known_for_what_it_is() {
    for (name, expected) in [
        ("classroom_pendulum.csv", Analysis::Ringdown),
        ("tuning_fork_9nN.csv", Analysis::Ringdown),
        ("tuning_fork_9nN_sweep.csv", Analysis::Resonance),
        ("tuning_fork_9nN_levels.csv", Analysis::Levels),
    ] {
        let bytes = example(name);
        let seen = preview(&File { name, bytes: &bytes }, &Options::default()).unwrap();
        assert_eq!((name, seen.analysis), (name, expected));
        assert_eq!(seen.format, "delimited text");
    }
}

#[test]
fn the_json_is_that_of_the_contract() {
    let bytes = example("classroom_pendulum.csv");
    let file = File { name: "classroom_pendulum.csv", bytes: &bytes };
    let answered = analyse(&file, None, &options(r#"{"torsion_stiffness": [12, 0.5]}"#)).unwrap();
    let reading = slipfit_io::read_from(&bytes[..], file.name, &Default::default()).unwrap();
    let mut asked = slipfit::ringdown::Options::default();
    asked.calibration = Some(slipfit::Calibration::Stiffness { value: 12.0, std_error: 0.5 });
    let answer = slipfit::ringdown::analyse(&reading.record, &asked).unwrap();
    let analysed = slipfit_report::AnalysedRingdown {
        file: file.name.as_ref(),
        reading: &reading,
        options: &asked,
        answer: &answer,
    };
    let mut expected = Vec::new();
    slipfit_report::json::ringdown(&mut expected, &analysed).unwrap();
    assert_eq!(answered.json.as_bytes(), expected);
    assert_eq!(answered.command, "slipfit ringdown classroom_pendulum.csv --torsion-stiffness '12±0.5'");
}

#[test]
fn the_document_holds_what_a_page_lays_out() {
    let bytes = example("classroom_pendulum.csv");
    let answered = analyse(&File { name: "a.csv", bytes: &bytes }, None, &Options::default()).unwrap();
    let document = &answered.document;
    assert!(document["sentence"].as_str().unwrap().starts_with("Sliding friction carries 43 %"));
    let rows = document["parameters"].as_array().unwrap();
    let friction = rows.iter().find(|r| r["words"] == "friction displacement").unwrap();
    assert_eq!((&friction["value"], &friction["unit"]), (&Value::from("2.0001"), &Value::from("mrad")));
    assert_eq!(document["panels"].as_array().unwrap().len(), 4);
    let trace = answered.trace.unwrap();
    assert_eq!((trace.time_s.len(), trace.unit.as_str()), (3001, "rad"));
    assert!(trace.fitted[0].is_some_and(|x| (x - trace.signal[0]).abs() < 0.01));
}

#[test]
fn a_curve_takes_its_reference() {
    let (bytes, free) = (example("tuning_fork_9nN_sweep.csv"), example("tuning_fork_free_sweep.csv"));
    let reference = File { name: "free.csv", bytes: &free };
    let file = File { name: "fork.csv", bytes: &bytes };
    let answered = analyse(&file, Some(&reference), &Options::default()).unwrap();
    let json: Value = serde_json::from_str(&answered.json).unwrap();
    assert_eq!(json["drive_source"], "reference");
    assert_eq!(answered.command, "slipfit resonance fork.csv --reference free.csv");
}

#[test]
fn options_of_another_analysis_change_nothing() {
    let bytes = example("tuning_fork_9nN_levels.csv");
    let file = File { name: "levels.csv", bytes: &bytes };
    let plain = analyse(&file, None, &Options::default()).unwrap();
    let other = analyse(&file, None, &options(r#"{"signal": "3", "band_hz": [1, 2], "run": null}"#)).unwrap();
    assert_eq!(plain, other);
}

#[test]
fn what_cannot_be_read_is_refused_with_what_helps() {
    let refused = |bytes: &[u8]| {
        let refusal = analyse(&File { name: "a.csv", bytes }, None, &Options::default()).unwrap_err();
        (refusal.message, refusal.hints)
    };
    assert_eq!(refused(b"").0, "a.csv: the file is empty");
    let (message, hints) = refused(b"x (m)\n1\n-1\n1\n-1\n1\n-1\n1\n-1\n1\n");
    assert!(message.starts_with("a.csv: "), "{message}");
    assert!(hints.iter().any(|h| h.option == Some("rate_hz")), "{hints:?}");
}

#[test]
fn a_constant_of_the_other_coordinate_is_refused() {
    let bytes = example("classroom_pendulum.csv");
    let file = File { name: "a.csv", bytes: &bytes };
    let refusal = analyse(&file, None, &options(r#"{"stiffness": [12, 0]}"#)).unwrap_err();
    assert!(refusal.message.contains("rad"), "{}", refusal.message);
}

#[test]
fn a_choice_that_is_none_is_refused_by_name() {
    for (json, says) in [
        (r#"{"colour": 1}"#, "unknown field `colour`"),
        (r#"{"model": "magic"}"#, "model magic"),
        (r#"{"kind": "smell"}"#, "kind smell"),
        (r#"{"rate_hz": "fast"}"#, "invalid type"),
        ("[", "options: "),
    ] {
        let refusal = Options::parse(json).unwrap_err();
        assert!(refusal.message.contains(says), "{json}: {}", refusal.message);
    }
}

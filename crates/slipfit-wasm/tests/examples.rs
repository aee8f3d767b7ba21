//! The files of `examples/` through the interface for the browser: the same answers as through the libraries.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use serde_json::Value;
use slipfit_wasm::{Analysis, Answered, Options, Output, Refusal, Session};

fn example(name: &str) -> Vec<u8> {
    let path = format!("{}/../../examples/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn session(name: &str, bytes: &[u8]) -> Session {
    Session::new(name, bytes.to_vec(), None)
}

fn analyse(name: &str, bytes: &[u8], options: &Options) -> Result<Answered, Refusal> {
    session(name, bytes).analyse(options)
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
        let seen = session(name, &bytes).preview(&Options::default()).unwrap();
        assert_eq!((name, seen.analysis), (name, expected));
        assert_eq!(seen.format, "delimited text");
    }
}

#[test]
fn the_json_is_that_of_the_contract() {
    let bytes = example("classroom_pendulum.csv");
    let name = "classroom_pendulum.csv";
    let answered = analyse(name, &bytes, &options(r#"{"torsion_stiffness": [12, 0.5]}"#)).unwrap();
    let reading = slipfit_io::read_from(&bytes[..], name, &Default::default()).unwrap();
    let mut asked = slipfit::ringdown::Options::default();
    asked.calibration = Some(slipfit::Calibration::Stiffness { value: 12.0, std_error: 0.5 });
    let answer = slipfit::ringdown::analyse(&reading.record, &asked).unwrap();
    let analysed = slipfit_report::AnalysedRingdown {
        file: name.as_ref(),
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
    let mut session = session("a.csv", &bytes);
    let answered = session.analyse(&Options::default()).unwrap();
    let document: Value = serde_json::from_str(answered.document.get()).unwrap();
    assert!(document["sentence"].as_str().unwrap().starts_with("Sliding friction carries 43 %"));
    let rows = document["parameters"].as_array().unwrap();
    let friction = rows.iter().find(|r| r["words"] == "friction displacement").unwrap();
    assert_eq!((&friction["value"], &friction["unit"]), (&Value::from("2.0001"), &Value::from("mrad")));
    assert_eq!(document["panels"].as_array().unwrap().len(), 4);
    let trace = session.trace().unwrap();
    assert_eq!([trace.time_s.len(), trace.signal.len(), trace.fitted.len()], [3001; 3]);
    assert!((trace.fitted[0] - trace.signal[0]).abs() < 0.01);
    session.analyse(&options(r#"{"end_s": 20}"#)).unwrap();
    let [inside, outside] = [500, 2500].map(|i| session.trace().unwrap().fitted[i]);
    assert!(inside.is_finite() && outside.is_nan(), "{inside} and {outside}");
}

#[test]
fn a_curve_takes_its_reference() {
    let (bytes, free) = (example("tuning_fork_9nN_sweep.csv"), example("tuning_fork_free_sweep.csv"));
    let answered =
        Session::new("fork.csv", bytes, Some(("free.csv", free))).analyse(&Options::default()).unwrap();
    let json: Value = serde_json::from_str(&answered.json).unwrap();
    assert_eq!(json["drive_source"], "reference");
    assert_eq!(answered.command, "slipfit resonance fork.csv --reference free.csv");
}

#[test]
fn options_of_another_analysis_change_nothing() {
    let bytes = example("tuning_fork_9nN_levels.csv");
    let answered =
        |options: &Options| serde_json::to_string(&analyse("levels.csv", &bytes, options).unwrap()).unwrap();
    let plain = answered(&Options::default());
    assert_eq!(plain, answered(&options(r#"{"signal": "3", "band_hz": [1, 2], "run": null}"#)));
}

#[test]
fn what_cannot_be_read_is_refused_with_what_helps() {
    let refused = |bytes: &[u8]| {
        let refusal = analyse("a.csv", bytes, &Options::default()).unwrap_err();
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
    let refusal = analyse("a.csv", &bytes, &options(r#"{"stiffness": [12, 0]}"#)).unwrap_err();
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

/// Everything a page shows and exports of an answer.
fn everything(session: &mut Session, options: &Options) -> String {
    session.preview(options).unwrap();
    let answered = session.analyse(options).unwrap();
    let outputs =
        [Output::Csv, Output::Svg, Output::Html, Output::Markdown].map(|what| session.output(what).unwrap());
    format!("{}\n{:?}\n{}", serde_json::to_string(&answered).unwrap(), session.trace(), outputs.join("\n"))
}

#[test]
fn a_session_answers_again_and_again_as_a_new_one() {
    for name in ["classroom_pendulum.csv", "tuning_fork_9nN_sweep.csv", "tuning_fork_9nN_levels.csv"] {
        let bytes = example(name);
        let mut kept = session(name, &bytes);
        // The last of them reads the record otherwise, the one before it analyses it otherwise.
        for chosen in ["{}", r#"{"end_s": 30, "model": "viscous+sliding"}"#, r#"{"unit": "mm"}"#, "{}"] {
            let (kept, new) = (
                everything(&mut kept, &options(chosen)),
                everything(&mut session(name, &bytes), &options(chosen)),
            );
            assert!(kept == new, "{name} with {chosen}");
        }
    }
}

#[test]
fn a_refused_choice_leaves_no_answer_of_the_one_before() {
    let bytes = example("classroom_pendulum.csv");
    let mut session = session("a.csv", &bytes);
    session.analyse(&Options::default()).unwrap();
    session.analyse(&options(r#"{"signal": "9"}"#)).unwrap_err();
    assert_eq!(session.trace(), None);
    assert!(session.output(Output::Csv).unwrap_err().message.contains("no answer"));
    session.analyse(&Options::default()).unwrap();
    assert!(session.output(Output::Csv).unwrap().contains("time_s,amplitude"));
}

#[test]
fn what_is_made_where_it_is_asked_for_is_of_the_last_answer() {
    let bytes = example("classroom_pendulum.csv");
    let mut session = session("a.csv", &bytes);
    let sentence = |answered: &Answered| {
        let json: Value = serde_json::from_str(&answered.json).unwrap();
        json["sentence"].as_str().unwrap().to_owned()
    };
    let whole = sentence(&session.analyse(&Options::default()).unwrap());
    let short = sentence(&session.analyse(&options(r#"{"end_s": 20}"#)).unwrap());
    assert_ne!(whole, short);
    assert!(session.output(Output::Csv).unwrap().contains(&short));
    let html = session.output(Output::Html).unwrap();
    assert!(html.contains("slipfit ringdown a.csv --end 20") && html.matches("<svg").count() >= 4);
    assert!(session.output(Output::Markdown).unwrap().contains(&short));
    assert!(session.output(Output::Svg).unwrap().ends_with("</svg>\n"));
}

//! Real answers keep the contract.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

mod common;

use common::{example, root, slipfit, stdout};
use serde_json::Value;

fn schema() -> Value {
    serde_json::from_str(&std::fs::read_to_string(root().join("docs/schema/ringdown-1.json")).unwrap())
        .unwrap()
}

fn answer(file: &str, more: &[&str]) -> Value {
    let text = stdout(slipfit().arg("ringdown").arg(example(file)).args(["--json", "-"]).args(more));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{file}: {e}\n{text}"))
}

fn answers() -> Vec<Value> {
    vec![
        answer("classroom_pendulum.csv", &[]),
        answer("classroom_pendulum.csv", &["--inertia", "0.05±0.001", "--start", "1", "--end", "20"]),
        // Without viscous damping the quality factor is infinite.
        answer("classroom_pendulum.csv", &["--model", "sliding", "--band", "0.5", "1.2"]),
        answer("tuning_fork_9nN.csv", &["--stiffness", "10000(200)"]),
        answer("tuning_fork_9nN.csv", &["--lockin-time-constant", "20e-6", "--lockin-order", "2"]),
        answer("tuning_fork_9nN_waveform.csv", &["--mass", "2.369e-7"]),
    ]
}

#[test]
fn answers_keep_to_the_schema() {
    let validator = jsonschema::draft202012::new(&schema()).unwrap();
    for answer in answers() {
        let errors: Vec<String> =
            validator.iter_errors(&answer).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(errors.is_empty(), "{errors:#?}");
    }
}

#[test]
fn the_schema_is_able_to_refuse() {
    let validator = jsonschema::draft202012::new(&schema()).unwrap();
    let mut answer = answer("classroom_pendulum.csv", &[]);
    assert!(validator.is_valid(&answer));
    answer["sliding"]["detected"] = Value::from("yes");
    assert!(!validator.is_valid(&answer));
    answer["sliding"].as_object_mut().unwrap().remove("detected");
    assert!(!validator.is_valid(&answer));
}

/// Every key written is described; a schema that allows more would not notice.
#[test]
fn no_key_is_undocumented() {
    let schema = schema();
    for answer in answers() {
        check_described(&answer, &schema, &schema, "");
    }
}

fn check_described(value: &Value, schema: &Value, root: &Value, path: &str) {
    let schema = match schema.get("$ref").and_then(Value::as_str) {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
        None => schema,
    };
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let path = format!("{path}/{key}");
                let described = schema.get("properties").and_then(|p| p.get(key));
                let described = described.unwrap_or_else(|| panic!("{path} is not in the schema"));
                check_described(inner, described, root, &path);
            }
        }
        Value::Array(list) => {
            for inner in list {
                check_described(inner, &schema["items"], root, path);
            }
        }
        _ => {}
    }
}

#[test]
fn an_infinite_quality_factor_is_null() {
    let answer = answer("classroom_pendulum.csv", &["--model", "sliding"]);
    assert_eq!(answer["model"], "sliding");
    assert_eq!(answer["parameters"]["q_factor"]["value"], Value::Null);
    assert_eq!(answer["parameters"]["decay_rate_per_s"]["value"], 0.0);
}

#[test]
fn calibrated_answers_give_forces_near_the_truth() {
    let answer = answer("tuning_fork_9nN_waveform.csv", &["--stiffness", "10000±200"]);
    let force = &answer["parameters"]["coulomb_force"];
    assert_eq!(force["unit"], "N");
    let (value, error) = (force["value"].as_f64().unwrap(), force["std_error"].as_f64().unwrap());
    // Five standard errors: the seed is fixed, the claim is that units are right.
    assert!((value - 15e-9).abs() < 5.0 * error, "{force}");
    assert!(error < 1e-9, "{force}");
    // Two per cent of the stiffness are in the uncertainty.
    assert!(error > 0.02 * 15e-9, "{force}");
}

#[test]
fn the_hash_is_that_of_the_file() {
    use sha2::{Digest, Sha256};
    let digest = Sha256::digest(std::fs::read(example("classroom_pendulum.csv")).unwrap());
    let hex: String = digest.iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(answer("classroom_pendulum.csv", &[])["input"]["sha256"], hex);
}

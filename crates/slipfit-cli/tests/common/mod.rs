//! Shared by the tests of the command.
#![allow(dead_code, reason = "each test binary uses some of it")]

use assert_cmd::Command;
use serde_json::Value;
use std::path::PathBuf;

/// The command, independent of the terminal and preferences of the person testing.
pub(crate) fn slipfit() -> Command {
    let mut command = Command::cargo_bin("slipfit").unwrap();
    command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env_remove("COLUMNS");
    command
}

/// Root of the workspace.
pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// An example shipped with the project.
pub(crate) fn example(name: &str) -> PathBuf {
    root().join("examples").join(name)
}

/// Standard output of a run that must succeed.
pub(crate) fn stdout(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The schema of a command's answer.
pub(crate) fn schema(command: &str) -> Value {
    let path = root().join(format!("docs/schema/{command}-1.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Checks that every written key is in the schema, which itself allows further keys.
pub(crate) fn keeps_to_schema(answer: &Value, command: &str) {
    let mut schema = schema(command);
    refuse_other_keys(&mut schema);
    let validator = jsonschema::draft202012::new(&schema).unwrap();
    let errors: Vec<String> =
        validator.iter_errors(answer).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

fn refuse_other_keys(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if map.get("properties").is_some_and(Value::is_object) {
                map.entry("additionalProperties").or_insert(Value::Bool(false));
            }
            map.values_mut().for_each(refuse_other_keys);
        }
        Value::Array(list) => list.iter_mut().for_each(refuse_other_keys),
        _ => {}
    }
}

//! Checks that the schemas of docs/schema are those of the types.

use super::series::SeriesEnvelope;
use super::{CurveEnvelope, LevelsEnvelope, RingdownEnvelope, SimulatedRecord};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};
use std::path::Path;

/// The schema of one command's answer.
fn schema<T: JsonSchema>(command: &str, units: &str) -> Value {
    let mut schema = contract::<T>(command);
    schema["title"] = format!("Answer of `slipfit {command}`").into();
    schema["description"] = format!(
        "{units} A number that is not finite is null. Keys may be added; none vanishes or changes its \
         meaning while `schema` stays the same."
    )
    .into();
    constant(&mut schema, "command", command);
    schema
}

/// The schema of a type, with the identifier of its contract.
fn contract<T: JsonSchema>(command: &str) -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    as_written(&mut schema);
    schema["$id"] =
        format!("https://github.com/slipfit/slipfit/blob/main/docs/schema/{command}-1.json").into();
    constant(&mut schema, "schema", &format!("slipfit/{command}-1"));
    schema
}

/// Restricts a key to one value.
fn constant(schema: &mut Value, key: &str, value: &str) {
    let property = &mut schema["properties"][key];
    *property = json!({ "description": property["description"], "const": value });
}

/// Adapts a schema to what is written: null for a number that is not finite, descriptions without the link
/// brackets and line ends of the source.
fn as_written(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            map.remove("format");
            if map.get("type") == Some(&json!("number")) {
                map.insert("type".to_owned(), json!(["number", "null"]));
            }
            if let Some(Value::String(text)) = map.get_mut("description") {
                let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
                *text = words.replace("[`", "`").replace("`]", "`").replace("`None`", "null");
            }
            map.values_mut().for_each(as_written);
        }
        Value::Array(list) => list.iter_mut().for_each(as_written),
        _ => {}
    }
}

/// `SLIPFIT_WRITE=1 cargo test -p slipfit-report schema` renews the files.
#[test]
fn the_schemas_are_those_of_the_types() {
    let clock = "Times are in seconds on the record's clock; displacements and amplitudes in the unit of the \
                 signal (input.unit).";
    let curve = "Displacements and amplitudes are in the unit of the signal (input.unit).";
    let levels = "Amplitudes are in input.unit, drive levels in input.drive_unit.";
    let mut simulated = contract::<SimulatedRecord<'_>>("simulate");
    simulated["title"] = "slipfit simulate --json".into();
    let schemas = [
        ("ringdown", schema::<RingdownEnvelope<'_>>("ringdown", clock)),
        ("resonance", schema::<CurveEnvelope<'_>>("resonance", curve)),
        ("levels", schema::<LevelsEnvelope<'_>>("levels", levels)),
        ("series", schema::<SeriesEnvelope<'_>>("series", "Displacements are in `unit`.")),
        ("simulate", simulated),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema");
    for (command, schema) in schemas {
        let path = folder.join(format!("{command}-1.json"));
        if std::env::var_os("SLIPFIT_WRITE").is_some() {
            std::fs::write(&path, format!("{schema:#}\n")).unwrap();
        }
        let stored: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        assert!(stored == schema, "{} differs from the types: SLIPFIT_WRITE=1 renews it", path.display());
    }
}

//! JSON shapes that derives do not give: names for parameters and models, maps for lists of pairs,
//! columns for lists of points.

use super::comparison::Values;
use super::hint::{Hint, HintValue};
use super::parameter::{Parameter, Parameters};
use super::warning::Warning;
use crate::model::loss::LossModel;
use serde::{Serialize, Serializer};

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

/// A warning with its text and what helps.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Warning"))]
struct WarningText {
    /// Machine-readable code.
    code: &'static str,
    /// What was found.
    message: String,
    /// What helps.
    hints: Vec<HintText>,
}

/// An option that helps, by its field, with its value where one is known.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Hint"))]
struct HintText {
    option: Option<&'static str>,
    value: Option<ValueText>,
    advice: String,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum ValueText {
    Number(f64),
    Range([f64; 2]),
    Text(String),
}

impl From<Hint> for HintText {
    fn from(hint: Hint) -> Self {
        let value = hint.value.map(|value| match value {
            HintValue::Number(number) => ValueText::Number(number),
            HintValue::Range(limits) => ValueText::Range(limits),
            HintValue::Text(word) => ValueText::Text(word),
        });
        Self { option: hint.option, value, advice: hint.advice.into_owned() }
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let hints = self.hints().into_iter().map(HintText::from).collect();
        WarningText { code: self.code(), message: self.to_string(), hints }.serialize(serializer)
    }
}

impl Serialize for LossModel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(feature = "schema")]
mod schema {
    use super::*;
    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
    use std::borrow::Cow;

    macro_rules! names {
        ($type:ty, $name:literal, $all:expr) => {
            impl JsonSchema for $type {
                fn schema_name() -> Cow<'static, str> {
                    $name.into()
                }

                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    let names: Vec<&str> = $all.map(|item| item.name()).collect();
                    json_schema!({ "type": "string", "enum": names })
                }
            }
        };
    }

    names!(Parameter, "Parameter", Parameter::all());
    names!(LossModel, "LossModel", LossModel::ALL.into_iter());

    /// The same schema as another type's.
    macro_rules! same_as {
        ($type:ty, $other:ty) => {
            impl JsonSchema for $type {
                fn schema_name() -> Cow<'static, str> {
                    <$other>::schema_name()
                }

                fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                    <$other>::json_schema(generator)
                }
            }
        };
    }

    same_as!(Warning, WarningText);

    macro_rules! map_of {
        ($type:ty, $name:literal, $value:ty) => {
            impl JsonSchema for $type {
                fn schema_name() -> Cow<'static, str> {
                    $name.into()
                }

                fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                    let value = generator.subschema_for::<$value>();
                    json_schema!({ "type": "object", "additionalProperties": value })
                }
            }
        };
    }

    map_of!(Parameters, "Parameters", crate::Quantity);
    map_of!(Values, "Values", Option<f64>);
}

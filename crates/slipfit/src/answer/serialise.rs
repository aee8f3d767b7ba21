//! JSON shapes that derives do not give: names for parameters and models, maps for lists of pairs,
//! columns for lists of points.

use super::comparison::Values;
use super::parameter::{Parameter, Parameters};
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

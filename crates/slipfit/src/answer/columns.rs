//! Lists of points as columns, because a notebook needs arrays rather than an array of objects.

/// Declares the columns to which a list of points is converted in JSON, and a module with their serialiser:
/// `#[serde(serialize_with = "module::serialize")]`, `#[schemars(with = "module::Columns")]`. Their schema contains the
/// descriptions of the fields of a point.
macro_rules! columns {
    ($module:ident of $point:ty { $($field:ident: $type:ty),+ $(,)? }) => {
        #[cfg(feature = "serde")]
        pub(crate) mod $module {
            /// The points, column by column.
            #[derive(serde::Serialize)]
            pub(crate) struct Columns {
                $($field: Vec<$type>),+
            }

            pub(crate) fn serialize<S: serde::Serializer>(
                points: &[$point],
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                let columns = Columns { $($field: points.iter().map(|p| p.$field).collect()),+ };
                serde::Serialize::serialize(&columns, serializer)
            }

            #[cfg(feature = "schema")]
            impl schemars::JsonSchema for Columns {
                fn schema_name() -> std::borrow::Cow<'static, str> {
                    format!("{}s", <$point as schemars::JsonSchema>::schema_name()).into()
                }

                fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                    $crate::answer::columns::schema(
                        &<$point as schemars::JsonSchema>::json_schema(generator),
                        &[$(stringify!($field)),+],
                    )
                }
            }
        }
    };
}
pub(crate) use columns;

/// Schema with one list for each field of a point.
#[cfg(feature = "schema")]
pub(crate) fn schema(point: &schemars::Schema, fields: &[&'static str]) -> schemars::Schema {
    let column = |field: &&'static str| {
        let mut item = point.get("properties").and_then(|all| all.get(field)).cloned().unwrap_or_default();
        let description = item.as_object_mut().and_then(|item| item.remove("description"));
        let column = schemars::json_schema!({ "description": description, "type": "array", "items": item });
        (*field, column)
    };
    let columns: std::collections::BTreeMap<&str, schemars::Schema> = fields.iter().map(column).collect();
    schemars::json_schema!({
        "description": "The points, column by column.",
        "type": "object",
        "properties": columns,
        "required": fields,
    })
}

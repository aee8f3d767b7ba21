//! Lists of points as columns: a notebook wants arrays, not an array of objects.

/// Declares the columns that a list of points becomes in JSON, and a module with their serialiser:
/// `#[serde(serialize_with = "module::serialize")]`, `#[schemars(with = "module::Columns")]`.
macro_rules! columns {
    ($module:ident of $point:ty { $($field:ident: $type:ty),+ $(,)? }) => {
        #[cfg(feature = "serde")]
        pub(crate) mod $module {
            /// The points, column by column.
            #[derive(serde::Serialize)]
            #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
        }
    };
}
pub(crate) use columns;

//! Errors of a table as a whole.

use arrow_schema::{ArrowError, DataType, Schema};

/// Error in a table or in the options.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A column that does not exist.
    #[error("there is no column `{name}`; there are {columns}")]
    NoColumn {
        /// Its name.
        name: String,
        /// The columns that exist.
        columns: String,
    },
    /// Several columns of the same name.
    #[error("there are several columns `{name}`")]
    AmbiguousColumn {
        /// Their name.
        name: String,
    },
    /// A column of the wrong type.
    #[error("the column `{name}` is {found}; it must be {needed}")]
    ColumnType {
        /// Its name.
        name: String,
        /// Its type.
        found: DataType,
        /// The type that is needed.
        needed: &'static str,
    },
    /// A column of an extension type, whose stored numbers are not its values.
    #[error("the column `{name}` is of the extension type {extension}; it must be {needed}")]
    Extension {
        /// Its name.
        name: String,
        /// The name of its extension type.
        extension: String,
        /// The type that is needed.
        needed: &'static str,
    },
    /// An option that is out of range or conflicts with another.
    #[error("{option}: {problem}")]
    Option {
        /// The field of [`Options`](crate::Options).
        option: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// The caller cancelled the work.
    #[error("cancelled before its end")]
    Cancelled,
    /// An error of Arrow.
    #[error("{0}")]
    Arrow(#[from] ArrowError),
}

/// Maximum number of columns named in a message.
const NAMED: usize = 20;

/// The index of the column of this name.
///
/// # Errors
/// There is no such column, or more than one.
pub(crate) fn place(schema: &Schema, name: &str) -> Result<usize, Error> {
    let fields = schema.fields();
    let mut places = (0..fields.len()).filter(|at| fields[*at].name() == name);
    match (places.next(), places.next()) {
        (Some(place), None) => Ok(place),
        (Some(_), Some(_)) => Err(Error::AmbiguousColumn { name: name.to_owned() }),
        (None, _) => {
            let mut known: Vec<String> =
                fields.iter().take(NAMED).map(|field| format!("`{}`", field.name())).collect();
            match fields.len() {
                0 => known.push("none".to_owned()),
                all if all > NAMED => known.push(format!("others, {all} in all")),
                _ => {}
            }
            Err(Error::NoColumn { name: name.to_owned(), columns: known.join(", ") })
        }
    }
}

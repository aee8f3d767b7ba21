//! What is wrong with a table as a whole.

use arrow_schema::{ArrowError, DataType, Schema};

/// A table that cannot be meant.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A column that is not there.
    #[error("there is no column `{name}`; there are {columns}")]
    NoColumn {
        /// Its name.
        name: String,
        /// Those there are.
        columns: String,
    },
    /// Several columns of one name.
    #[error("there are several columns `{name}`")]
    AmbiguousColumn {
        /// Their name.
        name: String,
    },
    /// A column of another type than needed.
    #[error("the column `{name}` is {found}; it must be {needed}")]
    ColumnType {
        /// Its name.
        name: String,
        /// Its type.
        found: DataType,
        /// What would do.
        needed: &'static str,
    },
    /// An option out of range or beside another.
    #[error("{option}: {problem}")]
    Option {
        /// The field of [`Options`](crate::Options).
        option: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// The caller asked for an end.
    #[error("cancelled before its end")]
    Cancelled,
    /// Arrow refused.
    #[error("{0}")]
    Arrow(#[from] ArrowError),
}

/// Columns that a message names.
const NAMED: usize = 20;

/// The place of the column of this name.
///
/// # Errors
/// There is none, or more than one.
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

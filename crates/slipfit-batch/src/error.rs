//! What is wrong with a table as a whole.

use arrow_schema::{ArrowError, DataType};

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
    #[error("ended before its end")]
    Cancelled,
    /// Arrow refused.
    #[error("{0}")]
    Arrow(#[from] ArrowError),
}

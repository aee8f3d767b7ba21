//! Columns of a table and their values.

use slipfit::Quantity;

/// Declares the columns of a table, each with its value, and the row of one file.
macro_rules! columns {
    (|$reading:ident: &$read:ty, $answer:ident: &$found:ty| {
        $($kind:ident $name:literal = $value:expr,)+
    }) => {
        pub(crate) const COLUMNS: &[Column] = &[$(Column::$kind($name)),+];

        pub(crate) fn row(file: &Path, $reading: &$read, $answer: &$found) -> Row {
            let codes: Vec<&str> = $answer.warnings.iter().map(slipfit::answer::Warning::code).collect();
            Row::answered(file, &codes, COLUMNS, vec![$(Value::$kind($value)),+])
        }
    };
}
pub(super) use columns;

/// A number of a quantity; NaN, written as an empty cell, if the analysis has none.
fn of(quantity: Option<&Quantity>, number: impl Fn(&Quantity) -> f64) -> f64 {
    quantity.map_or(f64::NAN, number)
}

pub(super) fn value(quantity: Option<&Quantity>) -> f64 {
    of(quantity, |q| q.value)
}

pub(super) fn std_error(quantity: Option<&Quantity>) -> f64 {
    of(quantity, |q| q.std_error)
}

/// Ends of the 95 % interval.
pub(super) fn low(quantity: Option<&Quantity>) -> f64 {
    of(quantity, |q| q.interval_95[0])
}

pub(super) fn high(quantity: Option<&Quantity>) -> f64 {
    of(quantity, |q| q.interval_95[1])
}

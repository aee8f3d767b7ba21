//! Cells of a sheet.

use super::text;

/// Row and column of a cell, from 0.
pub(super) type Place = (u32, u32);

/// A cell whose place in the text is not yet known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    Number(f64),
    Text(String),
}

/// One day, the unit of times in spreadsheets.
const DAY_S: f64 = 86400.0;
/// Number of days above which a cell that shows a time is a date: no measurement lasts that long.
const DATES: f64 = 15_000.0;

impl Cell {
    /// A cell that shows a time: a date, counted in days from an origin `before_1970` days before 1970, or the seconds
    /// of a time of day or a duration.
    pub(crate) fn time(days: f64, before_1970: f64) -> Self {
        let stamp = if days > DATES { text::stamp(days - before_1970) } else { None };
        stamp.map_or(Self::Number(days * DAY_S), Self::Text)
    }
}

//! Cells of a sheet.

use super::text;

/// Row and column of a cell, from 0.
pub(super) type Place = (u32, u32);

/// A cell before its place in the text is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    Number(f64),
    Text(String),
}

/// A day, in which spreadsheets count times.
const DAY_S: f64 = 86400.0;
/// Days beyond which a cell that shows a time is a date: no measurement lasts as long.
const DATES: f64 = 15_000.0;

impl Cell {
    /// A cell that shows a time: a date, counted in days from a first one that is so many days before 1970, or the
    /// seconds of a time of day or a duration.
    pub(crate) fn time(days: f64, before_1970: f64) -> Self {
        let stamp = if days > DATES { text::stamp(days - before_1970) } else { None };
        stamp.map_or(Self::Number(days * DAY_S), Self::Text)
    }
}

//! Turning points instead of samples.

use super::sheet::{Column, Digits};
use slipfit::motion::simulate::{Event, EventKind, Motion};

/// Number of digits that determine any double.
const ALL: usize = 17;

pub(super) fn turning_point_columns(unit: &str) -> Vec<Column> {
    let digits = Digits::Significant(ALL);
    vec![Column::new("time", "s", digits), Column::new("turning point", unit, digits)]
}

/// Time and position of each, stops included, up to `until_s`.
pub(super) fn turning_points(mut motion: Motion, until_s: f64) -> impl Iterator<Item = [f64; 2]> {
    let turned = |e: &Event| matches!(e.kind, EventKind::Turn | EventKind::Stop | EventKind::Rest);
    std::iter::from_fn(move || motion.next_event(until_s)).filter(turned).map(|e| [e.time_s, e.position])
}

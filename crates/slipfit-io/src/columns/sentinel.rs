//! Sentinels, i.e. numbers that stand for no value: `-999`, `9999`, `9.9e37`, and lost echoes of a motion detector.

use crate::report::Skipped;

/// A number that stands for no value, and its occurrences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sentinel {
    pub(crate) value: f64,
    /// How often it occurs.
    pub(crate) count: usize,
    /// Where it occurs first.
    pub(crate) first: usize,
}

/// Maximum number of different sentinels in a column.
const MOST: usize = 4;
/// Minimum distance of a repeated number from the range of all others, in units of that range.
const OUTSIDE: f64 = 10.0;
/// The same for a repeated number of the form that instruments write for missing values.
const OUTSIDE_KNOWN_FORM: f64 = 2.0;
/// The same for a number in rare single samples of a record.
const OUTSIDE_ISOLATED: f64 = 0.5;
/// Minimum number of such samples.
const FEWEST_ISOLATED: usize = 5;
/// At most one in this many samples is such a sample.
const RARE: usize = 8;
/// No instrument measures values from here on: 1e30, 9.9e37 (SCPI), the largest of single precision.
const NO_QUANTITY: f64 = 1e30;

/// The number that unmistakably stands for no value: the least or the greatest, identical to the last digit in several
/// rows or of the form that instruments write, and far outside all others.
pub(crate) fn find(values: &[f64]) -> Option<Sentinel> {
    let (low, high) = ends(values).or_else(|| range(values, |_| true))?;
    // Nearly every column has a number in the middle of its range, which a range extended by a sentinel does not have.
    let margin = (high - low) / (OUTSIDE_KNOWN_FORM + 1.0);
    if values.iter().any(|v| *v > low + margin && *v < high - margin) {
        return None;
    }
    let candidates = if low.abs() > high.abs() { [low, high] } else { [high, low] };
    candidates.into_iter().find_map(|value| as_sentinel(values, value))
}

/// The least and the greatest number, computed in several lanes; `None` if they are not finite and different.
fn ends(values: &[f64]) -> Option<(f64, f64)> {
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for chunk in values.chunks(LANES) {
        for (lane, v) in chunk.iter().enumerate() {
            low[lane] = if *v < low[lane] { *v } else { low[lane] };
            high[lane] = if *v > high[lane] { *v } else { high[lane] };
        }
    }
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    (low < high && low.is_finite() && high.is_finite()).then_some((low, high))
}

/// The same for the finite numbers selected by `counts`.
fn range(values: &[f64], counts: impl Fn(f64) -> bool) -> Option<(f64, f64)> {
    let ends = values
        .iter()
        .filter(|v| v.is_finite() && counts(**v))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (ends.0 < ends.1).then_some(ends)
}

fn as_sentinel(values: &[f64], value: f64) -> Option<Sentinel> {
    let (low, high) = range(values, |v| v != value)?;
    let gap = (low - value).max(value - high);
    let times = gap / (high - low);
    if !(times > OUTSIDE_KNOWN_FORM) {
        return None;
    }
    let count = values.iter().filter(|v| **v == value).count();
    let known_form = has_sentinel_form(value);
    let unmistakable = if known_form && count > 1 {
        times > OUTSIDE_KNOWN_FORM
    } else {
        (known_form || count > 1) && times > OUTSIDE
    };
    let first = values.iter().position(|v| *v == value)?;
    (unmistakable && 2 * count < values.len()).then_some(Sentinel { value, count, first })
}

/// The least or the greatest number of a record, if single samples repeatedly have it to the last digit and half the
/// range of all others separates it from them: motion detectors write such numbers if they receive no echo, or that of
/// the wall behind. A motion has values close to its extremes, and clipping holds several successive samples.
fn find_isolated(values: &[f64]) -> Option<Sentinel> {
    let (low, high) = ends(values).or_else(|| range(values, |_| true))?;
    let margin = (high - low) * OUTSIDE_ISOLATED / (1.0 + OUTSIDE_ISOLATED);
    let stands_apart = |value: f64| {
        let near = |v: &f64| *v != value && (*v - value).abs() < margin;
        !values.iter().any(near)
    };
    [low, high].into_iter().filter(|value| stands_apart(*value)).find_map(|value| {
        let count = values.iter().filter(|v| **v == value).count();
        let runs = values.chunk_by(|a, b| (*a == value) == (*b == value));
        let alone = runs.filter(|run| run.len() == 1 && run[0] == value).count();
        let often = count >= FEWEST_ISOLATED && 10 * alone >= 8 * count;
        let (first, others) = (values.iter().position(|v| *v == value)?, range(values, |v| v != value));
        (often && RARE * count <= values.len() && others.is_some()).then_some(Sentinel {
            value,
            count,
            first,
        })
    })
}

/// Whether a number has the form that instruments and programs write for missing values: nines, or beyond all
/// quantities.
fn has_sentinel_form(value: f64) -> bool {
    let size = value.abs();
    if size >= NO_QUANTITY {
        return true;
    }
    let text = size.to_string();
    let mut digits = text.bytes().filter(|b| *b != b'.');
    (3..=10).contains(&text.len()) && digits.all(|b| b == b'9')
}

impl Sentinel {
    /// Account of the rows it removes from a column, numbered from 1; the first of them is line `row`.
    pub(crate) fn skipped(self, column: usize, row: u64) -> Skipped {
        let reason = format!(
            "{} in column {column}, far outside all other values, stands for no value",
            written(self.value)
        );
        Skipped { reason, rows: self.count as u64, first_row: row }
    }
}

fn written(value: f64) -> String {
    if value.abs() < 1e6 { value.to_string() } else { format!("{value:e}") }
}

/// All sentinels of a column, each hidden (NaN) before the next search.
pub(crate) fn hide(values: &mut [f64]) -> Vec<Sentinel> {
    hide_each(values, find)
}

/// The same for samples in order of time.
pub(crate) fn hide_in_record(values: &mut [f64]) -> Vec<Sentinel> {
    hide_each(values, |values| find(values).or_else(|| find_isolated(values)))
}

fn hide_each(values: &mut [f64], find: impl Fn(&[f64]) -> Option<Sentinel>) -> Vec<Sentinel> {
    let mut found = Vec::new();
    while found.len() < MOST
        && let Some(sentinel) = find(values)
    {
        values.iter_mut().filter(|v| **v == sentinel.value).for_each(|v| *v = f64::NAN);
        found.push(sentinel);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn with(marks: &[(usize, f64)]) -> Vec<f64> {
        let mut values: Vec<f64> = (0..200).map(|i| (f64::from(i) * 0.3).cos() * 5.0).collect();
        marks.iter().for_each(|(at, value)| values[*at] = *value);
        values
    }

    #[test]
    fn what_instruments_write_for_no_value_is_found() {
        for (marks, value, count) in [
            (&[(0, -999.0), (1, -999.0)][..], -999.0, 2),
            (&[(7, 9999.0)], 9999.0, 1),
            (&[(7, 99.9), (8, 99.9)], 99.9, 2),
            (&[(3, 9.9e37), (90, 9.9e37)], 9.9e37, 2),
            (&[(199, 1e30)], 1e30, 1),
            (&[(3, -500.0), (90, -500.0)], -500.0, 2),
        ] {
            let found = find(&with(marks)).map(|s| (s.value, s.count, s.first));
            assert_eq!(found, Some((value, count, marks[0].0)), "{marks:?}");
        }
        let mut several = with(&[(0, -999.0), (1, -999.0), (50, 1e30), (60, 9999.0), (61, 9999.0)]);
        let values: Vec<f64> = hide(&mut several).iter().map(|s| s.value).collect();
        assert_eq!(values, [1e30, 9999.0, -999.0]);
        assert_eq!(several.iter().filter(|v| v.is_nan()).count(), 5);
    }

    #[test]
    fn jolts_rails_and_rest_are_values() {
        for marks in [
            // A jolt, and a value repeated by chance that is not as far off.
            &[(7, -500.0)][..],
            &[(7, 60.0), (9, 60.0)],
            // The rail of a converter close above the signal.
            &[(7, 9.99), (8, 9.99), (9, 9.99)],
        ] {
            assert_eq!(find(&with(marks)), None, "{marks:?}");
        }
        let held: Vec<f64> = (0..100).map(|i| if i < 60 { 999.0 } else { f64::from(i % 3) }).collect();
        assert_eq!(find(&held), None, "most of the record");
        let two: Vec<f64> = (0..100).map(|i| if i == 9 { 999.0 } else { 0.0 }).collect();
        assert_eq!(find(&two), None, "nothing else moves");
        assert_eq!(find(&[]), None);
    }

    #[test]
    fn lost_echoes_are_found_in_records_alone() {
        let lost = |value: f64, at: &dyn Fn(usize) -> bool| -> Vec<f64> {
            let swing = |i: usize| 0.8 + 0.2 * (0.3 * i as f64).cos();
            (0..400).map(|i| if at(i) { value } else { swing(i) }).collect()
        };
        // The motion ranges from 0.6 to 1.0.
        for value in [0.0, 4.0, 1.3] {
            let mut values = lost(value, &|i| i % 23 == 7);
            assert_eq!(find(&values), None, "{value}: no word and not as far off as those");
            let found = hide_in_record(&mut values);
            assert_eq!(found, [Sentinel { value, count: 18, first: 7 }]);
        }
        for (values, why) in [
            (lost(1.3, &|i| i % 100 == 7), "four by chance"),
            (lost(1.3, &|i| i % 23 < 4), "several at a time: the end of a range"),
            (lost(1.15, &|i| i % 23 == 7), "not far enough"),
            (lost(1.3, &|i| i % 5 == 0), "too often"),
            (lost(0.8, &|i| i % 23 == 7), "in the middle"),
        ] {
            assert_eq!(find_isolated(&values), None, "{why}");
        }
    }

    proptest! {
        #[test]
        fn values_of_any_size_are_looked_at(mut values in prop::collection::vec(any::<f64>(), 0..60)) {
            let rows = values.iter().filter(|v| v.is_finite()).count();
            let left_out: usize = hide_in_record(&mut values).iter().map(|s| s.count).sum();
            prop_assert_eq!(values.iter().filter(|v| v.is_finite()).count() + left_out, rows);
        }
    }
}

//! Advice on times with so few significant digits that stamps repeat and no even clock fits them.
//!
//! `slipfit::Record` restores an even clock if all stamps are roundings of it. If rows are missing there is no such
//! clock, and the best estimate is the rate of the first rows, whose times are well resolved.

use slipfit::answer::hint::Hint;

use crate::report::Note;

/// Maximum number of significant digits of coarse times.
const FEW_DIGITS: usize = 4;
/// Minimum share of stamps equal to the previous one.
const REPEATED: f64 = 0.2;
/// Maximum number of stamps examined.
const MOST: usize = 1 << 22;

/// Note on such times: how they are rounded, and the rate of the first of them.
pub(super) fn advice(time_s: &[f64]) -> Option<Note> {
    if time_s.len() > MOST {
        return None;
    }
    let repeated = time_s.windows(2).filter(|w| w[0] == w[1]).count();
    if (repeated as f64) < REPEATED * time_s.len() as f64 || time_s.windows(2).any(|w| w[1] < w[0]) {
        return None;
    }
    let written: Vec<(usize, i32)> = time_s.iter().map(|t| digits_and_decimals(*t)).collect();
    let digits = written.iter().map(|(digits, _)| *digits).max().filter(|d| *d <= FEW_DIGITS)?;
    // If there are as many decimal places at the end as at the beginning, all times have the same rounding step, which
    // `Record` handles.
    let decade = |t: f64| t.abs().log10().floor();
    let last = decade(*time_s.last()?);
    let decimals = |of_last: bool| {
        let of = time_s.iter().zip(&written).filter(|(t, _)| (decade(**t) == last) == of_last);
        of.map(|(_, (_, decimals))| *decimals).max()
    };
    if decimals(false)? <= decimals(true)? {
        return None;
    }
    let text = format!(
        "the times are rounded to {digits} digits, {repeated} of {} repeat, and no uniform clock fits them",
        time_s.len()
    );
    // The last row of the decade before the one in which stamps begin to repeat.
    let first = time_s.windows(2).position(|w| w[0] == w[1])?;
    let fine = (1..first).rev().find(|&k| decade(time_s[k]) < decade(time_s[first])).unwrap_or(first);
    // Up to the first missing row.
    let lost = |k: &usize| time_s[*k] - time_s[k - 1] > 1.5 * (time_s[1] - time_s[0]);
    let fine = (2..=fine).find(lost).map_or(fine, |k| k - 1);
    let span = time_s[fine] - time_s[0];
    let quantum = quantum(time_s[fine], digits);
    let hint = if fine > 2 && span > quantum {
        let (rows, rounding) = (fine as f64, 0.5 * quantum);
        let rate = fewest_digits_between(rows / (span + rounding), rows / (span - rounding));
        Hint::new("rate_hz", format!("is the rate of the first {fine} rows")).with(rate)
    } else {
        Hint::new("rate_hz", "gives the rate")
    };
    Some(Note { text, hints: vec![hint] })
}

/// The number with the fewest digits between two positive numbers.
fn fewest_digits_between(low: f64, high: f64) -> f64 {
    let middle = 0.5 * (low + high);
    let with = |digits: usize| format!("{middle:.digits$e}").parse().unwrap_or(middle);
    (0..8).map(with).find(|r| (low..=high).contains(r)).unwrap_or(middle)
}

/// Number of significant digits of the shortest decimal form of this number, and its number of decimal places.
fn digits_and_decimals(value: f64) -> (usize, i32) {
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
    (digits, digits as i32 - 1 - exponent.parse().unwrap_or(0))
}

/// Value of one unit in the last of `digits` significant digits.
fn quantum(value: f64, digits: usize) -> f64 {
    if value == 0.0 { 0.0 } else { 10f64.powi(value.abs().log10().floor() as i32 + 1 - digits as i32) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipfit::answer::hint::HintValue;

    /// A time as written by `%.2E`.
    fn three_digits(t: f64) -> f64 {
        format!("{t:.2e}").parse().unwrap()
    }

    #[test]
    fn of_a_clock_that_lost_rows_the_rate_is_advised() {
        let rows = (0..3600).filter(|k| !(900..930).contains(k));
        let stamps: Vec<f64> = rows.map(|k| three_digits(f64::from(k) / 30.0)).collect();
        let note = advice(&stamps).expect("coarse");
        let said = note.to_string();
        assert!(said.contains("no uniform clock fits"), "{said}");
        assert!(said.ends_with("is the rate of the first 299 rows"), "{said}");
        assert_eq!(note.hints[0].value, Some(HintValue::Number(30.0)));
    }

    #[test]
    fn there_is_none_on_times_of_one_rounding_or_of_many_digits() {
        let fixed: Vec<f64> = (0..1000).map(|k| (f64::from(k) / 3.0).round() / 10.0).collect();
        let stuck: Vec<f64> = (0..1000).map(|k| f64::from(k / 2) * 0.123_457).collect();
        for stamps in [fixed, stuck, vec![0.0; 50], Vec::new(), vec![1.0]] {
            assert_eq!(advice(&stamps), None);
        }
    }
}

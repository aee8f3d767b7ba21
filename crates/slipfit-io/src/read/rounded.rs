//! Times written with a few significant digits: fine at first, so coarse later that stamps repeat.
//!
//! Where a number of digits after the point is kept, the step of rounding is one throughout, and
//! `slipfit::Record` puts the clock together again. Here it grows by ten with every decade.

use crate::report::Note;

/// Significant digits that make times coarse.
const FEW_DIGITS: usize = 4;
/// Share of stamps that are that of the row before.
const REPEATED: f64 = 0.2;
/// More stamps are left as they are.
const MOST: usize = 1 << 22;
/// Steps of the search for the interval; each makes its bracket two thirds as long.
const STEPS: usize = 120;

/// What became of such times.
#[derive(Debug, PartialEq)]
pub(super) enum Rounded {
    /// They are those of an even clock now.
    Rebuilt(Note),
    /// They are as they were.
    Left(Note),
}

/// Puts an even clock in place of the stamps where all of them are roundings of it; where none fits,
/// advises the rate that the first stamps have.
pub(super) fn rebuild(time_s: &mut [f64]) -> Option<Rounded> {
    if time_s.len() > MOST {
        return None;
    }
    let repeated = time_s.windows(2).filter(|w| w[0] == w[1]).count();
    if (repeated as f64) < REPEATED * time_s.len() as f64 || time_s.windows(2).any(|w| w[1] < w[0]) {
        return None;
    }
    let written: Vec<(usize, i32)> = time_s.iter().map(|t| written(*t)).collect();
    let digits = written.iter().map(|(digits, _)| *digits).max().filter(|d| *d <= FEW_DIGITS)?;
    // As many digits behind the point at the end as at the beginning: one step of rounding
    // throughout, which is the record's to see.
    let decade = |t: f64| t.abs().log10().floor();
    let last = decade(*time_s.last()?);
    let behind = |of_last: bool| {
        let of = time_s.iter().zip(&written).filter(|(t, _)| (decade(**t) == last) == of_last);
        of.map(|(_, (_, behind))| *behind).max()
    };
    if behind(false)? <= behind(true)? {
        return None;
    }
    let quanta: Vec<f64> = time_s.iter().map(|t| quantum(*t, digits)).collect();
    if let Some((start, step)) = even_clock(time_s, &quanta) {
        time_s.iter_mut().enumerate().for_each(|(k, t)| *t = start + k as f64 * step);
        let text = format!(
            "the times are rounded to {digits} digits and repeat: they were put on the even clock of {:.5} Hz that they \
             are roundings of",
            1.0 / step
        );
        return Some(Rounded::Rebuilt(Note::new(text).hint("rate_hz", "says otherwise")));
    }
    let text = format!(
        "the times are rounded to {digits} digits, {repeated} of {} repeat, and no even clock fits them",
        time_s.len()
    );
    // The last row of the decade before the one in which stamps begin to repeat.
    let first = time_s.windows(2).position(|w| w[0] == w[1])?;
    let fine = (1..first).rev().find(|&k| decade(time_s[k]) < decade(time_s[first])).unwrap_or(first);
    // Up to the first row that is missing.
    let lost = |k: &usize| time_s[*k] - time_s[k - 1] > 1.5 * (time_s[1] - time_s[0]);
    let fine = (2..=fine).find(lost).map_or(fine, |k| k - 1);
    let span = time_s[fine] - time_s[0];
    let advice = if fine > 2 && span > quanta[fine] {
        let (rows, rounding) = (fine as f64, 0.5 * quanta[fine]);
        let rate = roundest(rows / (span + rounding), rows / (span - rounding));
        format!("takes the rate of the first {fine}, {rate}")
    } else {
        "gives the rate".to_owned()
    };
    Some(Rounded::Left(Note::new(text).hint("rate_hz", advice)))
}

/// The number of fewest digits between two above zero.
fn roundest(low: f64, high: f64) -> f64 {
    let middle = 0.5 * (low + high);
    let with = |digits: usize| format!("{middle:.digits$e}").parse().unwrap_or(middle);
    (0..8).map(with).find(|r| (low..=high).contains(r)).unwrap_or(middle)
}

/// Significant digits of the shortest number that is this one, and its digits behind the point.
fn written(value: f64) -> (usize, i32) {
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
    (digits, digits as i32 - 1 - exponent.parse().unwrap_or(0))
}

/// The last of so many digits.
fn quantum(value: f64, digits: usize) -> f64 {
    if value == 0.0 { 0.0 } else { 10f64.powi(value.abs().log10().floor() as i32 + 1 - digits as i32) }
}

/// Start and step of an even clock that rounds to all stamps, each by half its quantum at the most.
///
/// For a step the starts that fit lie between the largest of `t - q/2 - k step` and the least of
/// `t + q/2 - k step`. Their distance is a concave function of the step: its maximum is found by
/// thirds, and a clock fits where it is not below zero.
fn even_clock(time_s: &[f64], quanta: &[f64]) -> Option<(f64, f64)> {
    let starts = |step: f64| {
        time_s.iter().zip(quanta).enumerate().fold(
            (f64::NEG_INFINITY, f64::INFINITY),
            |(low, high), (k, (t, q))| {
                let start = t - k as f64 * step;
                (low.max(start - 0.5 * q), high.min(start + 0.5 * q))
            },
        )
    };
    let room = |step: f64| {
        let (low, high) = starts(step);
        high - low
    };
    let mean = (time_s.last()? - time_s.first()?) / (time_s.len() - 1) as f64;
    let (mut short, mut long) = (0.5 * mean, 2.0 * mean);
    for _ in 0..STEPS {
        let (a, b) = (short + (long - short) / 3.0, long - (long - short) / 3.0);
        if room(a) < room(b) { short = a } else { long = b }
    }
    let step = 0.5 * (short + long);
    let (low, high) = starts(step);
    // A clock that starts at zero is written so, exactly.
    let slack = 1e-9 * step;
    (high >= low - slack && step > 0.0).then_some((0.5 * (low + high), step))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A time as `%.2E` writes it.
    fn three_digits(t: f64) -> f64 {
        format!("{t:.2e}").parse().unwrap()
    }

    #[test]
    fn times_of_three_digits_are_put_on_the_clock_they_are_roundings_of() {
        let mut stamps: Vec<f64> = (0..3600).map(|k| three_digits(f64::from(k) / 30.0)).collect();
        let Some(Rounded::Rebuilt(note)) = rebuild(&mut stamps) else { panic!("not rebuilt") };
        let note = note.text;
        assert!(note.contains("rounded to 3 digits"), "{note}");
        assert!(note.contains("30.00"), "{note}");
        for (k, t) in stamps.iter().enumerate() {
            // Half a quantum of the last time that still moves with every row.
            assert!((t - k as f64 / 30.0).abs() < 2e-3, "row {k}: {t}");
        }
    }

    #[test]
    fn a_clock_that_lost_rows_is_left_and_its_rate_advised() {
        let rows = (0..3600).filter(|k| !(900..930).contains(k));
        let mut stamps: Vec<f64> = rows.map(|k| three_digits(f64::from(k) / 30.0)).collect();
        let before = stamps.clone();
        let Some(Rounded::Left(note)) = rebuild(&mut stamps) else { panic!("not left") };
        assert_eq!(stamps, before);
        let said = note.spelled(&|option, _| option.to_owned());
        assert!(said.contains("no even clock fits"), "{said}");
        assert!(said.ends_with("first 299, 30"), "{said}");
    }

    #[test]
    fn times_of_one_rounding_or_of_many_digits_are_left() {
        let fixed: Vec<f64> = (0..1000).map(|k| (f64::from(k) / 3.0).round() / 10.0).collect();
        let stuck: Vec<f64> = (0..1000).map(|k| f64::from(k / 2) * 0.123_457).collect();
        for mut stamps in [fixed, stuck, vec![0.0; 50], Vec::new(), vec![1.0]] {
            let before = stamps.clone();
            assert_eq!(rebuild(&mut stamps), None);
            assert_eq!(stamps, before);
        }
    }
}

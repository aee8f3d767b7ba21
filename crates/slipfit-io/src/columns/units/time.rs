//! Units of time: names in several languages, multiples of them, and ticks of a clock.

use super::list::listed;
use std::borrow::Cow;

/// Conversion from a unit of time to seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Seconds {
    /// Seconds as they are.
    Same,
    /// Longer units.
    Times(f64),
    /// Shorter units. With a division, 651 ms are 0.651 s to the last digit, and a clock written with few digits
    /// remains recognisable as such.
    Over(f64),
}

impl Seconds {
    /// A time in seconds.
    #[inline]
    pub(crate) fn of(self, time: f64) -> f64 {
        match self {
            Self::Same => time,
            Self::Times(factor) => time * factor,
            Self::Over(divisor) => time / divisor,
        }
    }
}

/// Units of time by their length; spellings are separated by blanks.
const TIMES: &[(Seconds, &str)] = &[
    (
        Seconds::Same,
        "s sec secs sek second seconds sekunde sekunden seconde secondes secondi secondo segundo segundos сек с 秒",
    ),
    (
        Seconds::Over(1e3),
        "ms msec msecs msek millis millisec millisecond milliseconds millisekunden millisecondes millisecondi milisegundos \
         мс мсек 毫秒 ミリ秒",
    ),
    (
        Seconds::Over(1e6),
        "us usec usecs \u{b5}s \u{3bc}s \u{b5}sec \u{3bc}sec micros microsec microsecond microseconds mikrosekunden \
         microsecondes microsecondi microsegundos мкс 微秒 マイクロ秒",
    ),
    (
        Seconds::Over(1e9),
        "ns nsec nsecs nanos nanosec nanosecs nanosecond nanoseconds nanosekunden nanosecondes nanosecondi nanosegundos нс",
    ),
    (Seconds::Over(1e12), "ps"),
    (Seconds::Times(60.0), "min minute minutes minuten мин"),
    (Seconds::Times(3600.0), "h hr hour hours"),
    (Seconds::Times(86400.0), "day days"),
];

/// A unit of time in lower case, or a multiple of one.
pub(super) fn named(unit: &str) -> Option<Seconds> {
    let unit = &without_marks(unit);
    plain(unit).or_else(|| scaled(unit)).or_else(|| part(unit))
}

/// Removes the full stop of an abbreviation and LaTeX markup: `msec.`, `$\mu$s`, `\si{\ms}`.
fn without_marks(unit: &str) -> Cow<'_, str> {
    let unit = unit.trim_end_matches('.');
    if !unit.contains(['\\', '$']) {
        return Cow::Borrowed(unit);
    }
    let inner = ["\\si{", "\\unit{"].iter().find_map(|name| unit.strip_prefix(name)?.strip_suffix('}'));
    Cow::Owned(inner.unwrap_or(unit).replace("\\mu", "\u{3bc}").replace(['\\', '$', '{', '}'], ""))
}

/// A fraction of a unit of time: `sec/100`.
fn part(unit: &str) -> Option<Seconds> {
    let (unit, divisor) = unit.split_once('/')?;
    let divisor: f64 = divisor.parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0)?;
    Some(divided(plain(unit.trim())?, divisor))
}

fn plain(unit: &str) -> Option<Seconds> {
    TIMES.iter().find(|(_, names)| listed(names, unit)).map(|(seconds, _)| *seconds)
}

/// A multiple of a unit of time: `10ms`, `x 10 ms`, `1/100 s`, `10^-3 s`, `1e-6 s`.
fn scaled(unit: &str) -> Option<Seconds> {
    let unit = unit.trim_start_matches(['x', '\u{d7}', '*', ' ']);
    let digits = |c: char| c.is_ascii_digit();
    let power = unit.strip_prefix("10").map(|rest| rest.strip_prefix("**").unwrap_or(rest));
    let power = power.and_then(|rest| rest.strip_prefix("^-").or_else(|| rest.strip_prefix('-')));
    let (divisor, rest) = if let Some(rest) = power {
        let end = rest.find(|c| !digits(c))?;
        (10f64.powi(rest[..end].parse().ok()?), &rest[end..])
    } else if let Some(rest) = unit.strip_prefix("1/").filter(|rest| rest.starts_with(digits)) {
        let end = rest.find(|c| !digits(c))?;
        (rest[..end].parse().ok()?, &rest[end..])
    } else {
        // The `e` of `1e-3`.
        let is_number = |c: char| digits(c) || c == '.';
        let end = unit.find(|c| !is_number(c)).filter(|end| *end > 0)?;
        let exponent =
            unit[end..].strip_prefix("e-").map(|rest| rest.len() - rest.trim_start_matches(digits).len());
        let end = exponent.filter(|length| *length > 0).map_or(end, |length| end + 2 + length);
        (1.0 / unit[..end].parse::<f64>().ok()?, &unit[end..])
    };
    let unit = rest.trim_start_matches(['*', '\u{b7}', '\u{d7}', ' ']);
    let known = plain(unit).filter(|_| divisor.is_finite() && divisor > 0.0)?;
    Some(divided(known, divisor))
}

fn divided(unit: Seconds, divisor: f64) -> Seconds {
    match unit {
        Seconds::Same => Seconds::Over(divisor),
        Seconds::Over(of_unit) => Seconds::Over(of_unit * divisor),
        Seconds::Times(of_unit) => Seconds::Times(of_unit / divisor),
    }
}

/// Rate of a clock whose ticks are the unit: `60 M` of `60 MHz`.
pub(super) fn tick_rate(text: &str) -> Option<f64> {
    let (number, factor) = match text.trim_end().chars().next_back()? {
        'k' => (text.trim_end().strip_suffix('k')?, 1e3),
        'm' => (text.trim_end().strip_suffix('m')?, 1e6),
        'g' => (text.trim_end().strip_suffix('g')?, 1e9),
        _ => (text, 1.0),
    };
    number.trim().parse::<f64>().ok().map(|n| n * factor).filter(|hz| hz.is_finite() && *hz > 0.0)
}

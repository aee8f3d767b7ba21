//! Dates and times of day in cells: ISO 8601 and the formats of loggers and spreadsheets.

/// A cell that is a date, a time of day or both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamp {
    /// Days since 1970, if there is a date.
    pub(super) day: Option<i64>,
    /// Seconds since midnight.
    seconds: f64,
    /// Whether it contains a time of day.
    pub(super) timed: bool,
}

impl Stamp {
    /// Seconds since the midnight before `day`; without a date, since any midnight. Counted from 1970, they would only
    /// be resolved to a quarter of a microsecond.
    pub(super) fn since(self, day: i64) -> f64 {
        self.day.map_or(0.0, |own| (own - day) as f64 * DAY_S) + self.seconds
    }
}

const MONTHS: [&str; 12] =
    ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
const DAY_S: f64 = 86400.0;
/// Years of a measurement; other years are numbers that look like a date.
const YEARS: std::ops::RangeInclusive<i64> = 1900..=2200;

/// Reads `2024-05-01T12:34:56.789Z`, `01.05.2024 12:34:56,789`, `5/1/2024 1:34:56 PM`, `01-May-2024 12:34:56`,
/// `12:34:56.789`, `34:56.789`; `None` for anything else.
///
/// In `5/1/2024` the month comes first, unless it is above 12; with points or hyphens the day comes first.
pub(super) fn read(text: &str) -> Option<Stamp> {
    let text = text.trim();
    if text.len() > 40 || !text.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    // A `t` after a letter belongs to a month.
    let bytes = text.as_bytes();
    let splits = |at: usize| match bytes[at] {
        b'T' | b't' => at > 0 && bytes[at - 1].is_ascii_digit(),
        byte => byte == b' ',
    };
    let split = (0..bytes.len()).find(|at| splits(*at));
    let (first, rest) = match split {
        Some(at) => (&text[..at], text[at + 1..].trim_start()),
        None => (text, ""),
    };
    let timed = !rest.is_empty();
    // A year may have two digits if a time of day follows.
    if let Some(day) = date(first).or_else(|| if timed { date(&of_this_century(first)?) } else { None }) {
        let seconds = if timed { time_of_day(rest)? } else { 0.0 };
        return Some(Stamp { day: Some(day), seconds, timed });
    }
    time_of_day(text).map(|seconds| Stamp { day: None, seconds, timed: true })
}

/// The stamp for a number of days since 1970, to a microsecond, which is about the resolution of a double, in a form
/// accepted by `read`; only the date for midnight.
#[cfg(any(feature = "excel", test))]
pub(crate) fn written(days: f64) -> Option<String> {
    const TICKS_PER_SECOND: i64 = 1_000_000;
    const TICKS_PER_DAY: i64 = 86_400 * TICKS_PER_SECOND;
    if !days.is_finite() {
        return None;
    }
    let ticks = ((days - days.floor()) * TICKS_PER_DAY as f64).round() as i64;
    let (day, ticks) = ((days.floor() as i64).checked_add(ticks / TICKS_PER_DAY)?, ticks % TICKS_PER_DAY);
    // Years in cycles of 400 from March 0000 on, as in `date`.
    let since = day.checked_add(719_468).filter(|since| (0..=1_000_000).contains(since))?;
    let (era, of_era) = (since / 146_097, since % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day_of_month = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let date = format!("{:04}-{month:02}-{day_of_month:02}", 400 * era + year + next);
    let (seconds, rest) = (ticks / TICKS_PER_SECOND, ticks % TICKS_PER_SECOND);
    let (h, m, s) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    Some(if ticks == 0 { date } else { format!("{date} {h:02}:{m:02}:{s:02}.{rest:06}") })
}

/// `11/03/2023` of `11/03/23`.
fn of_this_century(text: &str) -> Option<String> {
    let (before, year) = text.split_at_checked(text.len().checked_sub(2)?)?;
    let short = before.ends_with(['/', '.']) && before.len() <= 6 && digits(year, 2).is_some();
    short.then(|| format!("{before}20{year}"))
}

fn digits(text: &str, most: usize) -> Option<i64> {
    let plain = (1..=most).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    plain.then(|| text.parse().ok()).flatten()
}

/// Days since 1970.
fn date(text: &str) -> Option<i64> {
    // ISO 8601 without hyphens is accepted only before a `T`; alone it is a number.
    let mark = text.bytes().find(|byte| !byte.is_ascii_digit())?;
    if !matches!(mark, b'-' | b'/' | b'.') {
        return None;
    }
    let mark = char::from(mark);
    let mut parts = text.split(mark);
    let (Some(a), Some(b), Some(c), None) = (parts.next(), parts.next(), parts.next(), parts.next()) else {
        return None;
    };
    let month_name = |word: &str| {
        let word = word.to_lowercase();
        let fits = |m: &&str| word.starts_with(*m) && word.chars().all(char::is_alphabetic);
        MONTHS.iter().position(fits).map(|i| i as i64 + 1)
    };
    let (year, month, day) = if a.len() == 4 {
        (digits(a, 4)?, digits(b, 2).or_else(|| month_name(b))?, digits(c, 2)?)
    } else if c.len() == 4 {
        let (first, year) = (digits(a, 2)?, digits(c, 4)?);
        match month_name(b) {
            Some(month) => (year, month, first),
            None => {
                let second = digits(b, 2)?;
                let month_first = (mark == '/' && first <= 12) || second > 12;
                if month_first { (year, first, second) } else { (year, second, first) }
            }
        }
    } else {
        return None;
    };
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !YEARS.contains(&year) || !(1..=length).contains(&day) {
        return None;
    }
    // Days since March 0000 with leap years; 1970-01-01 is day 719468.
    let (y, m) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    Some(365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 719_468)
}

/// Seconds since midnight, in UTC if an offset is given.
fn time_of_day(text: &str) -> Option<f64> {
    if !text.contains(':') {
        return None;
    }
    let lower = text.trim().to_ascii_lowercase();
    let (clock, half) = match lower.strip_suffix("am").or_else(|| lower.strip_suffix("a.m.")) {
        Some(clock) => (clock.trim_end(), Some(0.0)),
        None => match lower.strip_suffix("pm").or_else(|| lower.strip_suffix("p.m.")) {
            Some(clock) => (clock.trim_end(), Some(12.0)),
            None => (&*lower, None),
        },
    };
    let (clock, offset_s) = match clock.strip_suffix('z').or_else(|| clock.strip_suffix(" utc")) {
        Some(clock) => (clock.trim_end(), 0.0),
        None => match clock.rfind(['+', '-']) {
            Some(at) => (clock[..at].trim_end(), offset(&clock[at..])?),
            None => (clock, 0.0),
        },
    };
    let parts: Vec<&str> = clock.split(':').collect();
    let (hours, minutes, seconds) = match parts[..] {
        [h, m, s] => (digits(h, 2)? as f64, digits(m, 2)?, fraction(s)?),
        // Of two parts, minutes and seconds if the last has a fraction. `12:30` is ambiguous.
        [m, s] if s.contains(['.', ',']) => (0.0, digits(m, 2)?, fraction(s)?),
        [h, m, s, ms] => (digits(h, 2)? as f64, digits(m, 2)?, fraction(s)? + digits(ms, 3)? as f64 / 1e3),
        _ => return None,
    };
    if hours >= 24.0 || minutes >= 60 || seconds >= 61.0 {
        return None;
    }
    let hours = half.map_or(hours, |half| hours % 12.0 + half);
    Some(3600.0 * hours + 60.0 * minutes as f64 + seconds - offset_s)
}

/// Seconds with a fraction after a point or a comma.
fn fraction(text: &str) -> Option<f64> {
    let (whole, rest) = text.split_once(['.', ',']).unwrap_or((text, "0"));
    digits(whole, 2)?;
    let plain = !rest.is_empty() && rest.len() <= 12 && rest.bytes().all(|b| b.is_ascii_digit());
    plain.then(|| format!("{whole}.{rest}").parse().ok()).flatten()
}

/// `+02:00`, `-0530` or `+02` in seconds.
fn offset(text: &str) -> Option<f64> {
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let plain: String = text[1..].chars().filter(|c| *c != ':').collect();
    if !plain.is_ascii() {
        return None;
    }
    let minutes = match plain.len() {
        2 => 60 * digits(&plain, 2)?,
        4 => 60 * digits(&plain[..2], 2)? + digits(&plain[2..], 2)?,
        _ => return None,
    };
    Some(sign * 60.0 * minutes as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_of_many_writers_are_the_same_second() {
        // date -u -d '2024-05-01 13:34:56' +%s
        let second = 1_714_570_496.0;
        for (text, seconds) in [
            ("2024-05-01T13:34:56Z", second),
            ("2024-05-01T13:34:56.5Z", second + 0.5),
            ("2024-05-01 13:34:56,25", second + 0.25),
            ("2024-05-01T15:34:56+02:00", second),
            ("2024-05-01T08:04:56-0530", second),
            ("2024/05/01 13:34:56", second),
            ("01.05.2024 13:34:56", second),
            ("5/1/2024 1:34:56 PM", second),
            ("05/01/24 01:34:56 PM", second),
            ("01.05.24 13:34:56", second),
            ("01-May-2024 13:34:56", second),
            ("01-OCT-2024t13:34:56", second + 153.0 * 86400.0),
            ("1-Sept-2024 13:34:56", second + 123.0 * 86400.0),
            ("01-August-2024 13:34:56", second + 92.0 * 86400.0),
            ("1970-01-01", 0.0),
            // date -u -d '2000-02-29 00:00:01' +%s
            ("2000-02-29 00:00:01", 951_782_401.0),
        ] {
            let stamp = read(text).unwrap_or_else(|| panic!("{text}"));
            assert!(stamp.day.is_some(), "{text}: {stamp:?}");
            assert!((stamp.since(0) - seconds).abs() < 1e-6, "{text}: {stamp:?}");
        }
        for (text, seconds) in [
            ("13:34:56.789", 48_896.789),
            ("1:02:03", 3723.0),
            ("12:00:00 am", 0.0),
            ("02:03.5", 123.5),
            ("13:34:56:250", 48_896.25),
        ] {
            let stamp = read(text).unwrap_or_else(|| panic!("{text}"));
            assert!(stamp.day.is_none(), "{text}: {stamp:?}");
            assert!((stamp.since(7) - seconds).abs() < 1e-9, "{text}: {stamp:?}");
        }
    }

    #[test]
    fn what_is_written_is_read_as_the_same_instant() {
        assert_eq!(written(19_794.432_326_388_89).as_deref(), Some("2024-03-12 10:22:33.000000"));
        assert_eq!(written(11_016.0).as_deref(), Some("2000-02-29"));
        // A fraction of a tick before midnight.
        assert_eq!(written(11_016.999_999_999_999_9).as_deref(), Some("2000-03-01"));
        for day in (-25_000..83_000).step_by(97) {
            let days = day as f64 + 0.625;
            let stamp = written(days).and_then(|text| read(&text)).map(|stamp| (stamp.day, stamp.seconds));
            assert_eq!(stamp, Some((Some(day), 54_000.0)));
        }
        for days in [f64::NAN, f64::INFINITY, -1e9, 1e9, 1e300] {
            assert_eq!(written(days), None);
        }
    }

    #[test]
    fn numbers_and_what_is_no_day_are_no_stamps() {
        for text in [
            "12:30",
            "2024",
            "1.5",
            "1.2.3",
            "2024-13-01",
            "2024-02-30",
            "25:00:00",
            "12:61:00",
            "-12:00:00",
            "1-2-3",
            "1.5.24",
            "11/03/23",
            "192.168.1.2012",
            "10/20",
            "",
            "T",
            "2024-05-01Tx",
            "2024-05-01 12",
            "1e5",
            "3:4:5:6:7",
            "12:00:0é",
            // Found by fuzzing: multi-byte characters where digits are expected.
            "1-∞!",
            "12:00:00+\u{feff}&",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}

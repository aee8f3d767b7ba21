//! Units as they stand in headers.

use slipfit::SignalKind;

/// From a unit of time to seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Seconds {
    /// Seconds as they are.
    Same,
    /// Longer units.
    Times(f64),
    /// Shorter units. Divided, 651 ms are 0.651 s to the last digit, and a
    /// clock written with few digits stays recognisable as such.
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

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Measures {
    /// Time.
    Time(Seconds),
    /// A signal of a kind.
    Signal(SignalKind),
    /// A level in dB: linear amplitude is `10^(x/20)`, in the unit named.
    Level(&'static str),
    /// Something that is neither.
    Other,
}

const SECONDS: &[(&str, Seconds)] = &[
    ("s", Seconds::Same),
    ("sec", Seconds::Same),
    ("secs", Seconds::Same),
    ("sek", Seconds::Same),
    ("second", Seconds::Same),
    ("seconds", Seconds::Same),
    ("sekunde", Seconds::Same),
    ("sekunden", Seconds::Same),
    ("seconde", Seconds::Same),
    ("secondes", Seconds::Same),
    ("secondi", Seconds::Same),
    ("secondo", Seconds::Same),
    ("segundo", Seconds::Same),
    ("segundos", Seconds::Same),
    ("сек", Seconds::Same),
    ("с", Seconds::Same),
    ("秒", Seconds::Same),
    ("ms", Seconds::Over(1e3)),
    ("msec", Seconds::Over(1e3)),
    ("millis", Seconds::Over(1e3)),
    ("millisecond", Seconds::Over(1e3)),
    ("milliseconds", Seconds::Over(1e3)),
    ("millisekunden", Seconds::Over(1e3)),
    ("us", Seconds::Over(1e6)),
    ("usec", Seconds::Over(1e6)),
    ("\u{b5}s", Seconds::Over(1e6)),
    ("\u{3bc}s", Seconds::Over(1e6)),
    ("micros", Seconds::Over(1e6)),
    ("microsecond", Seconds::Over(1e6)),
    ("microseconds", Seconds::Over(1e6)),
    ("ns", Seconds::Over(1e9)),
    ("nanosecond", Seconds::Over(1e9)),
    ("nanoseconds", Seconds::Over(1e9)),
    ("ps", Seconds::Over(1e12)),
    ("min", Seconds::Times(60.0)),
    ("minute", Seconds::Times(60.0)),
    ("minutes", Seconds::Times(60.0)),
    ("minuten", Seconds::Times(60.0)),
    ("h", Seconds::Times(3600.0)),
    ("hr", Seconds::Times(3600.0)),
    ("hour", Seconds::Times(3600.0)),
    ("hours", Seconds::Times(3600.0)),
];

/// Lengths, angles and electrical signals that stand for them.
const POSITIONS: &[&str] = &[
    "m",
    "meter",
    "metre",
    "meters",
    "dm",
    "cm",
    "mm",
    "um",
    "\u{b5}m",
    "\u{3bc}m",
    "nm",
    "pm",
    "fm",
    "in",
    "inch",
    "ft",
    "mil",
    "px",
    "pixel",
    "pixels",
    "rad",
    "mrad",
    "urad",
    "\u{b5}rad",
    "\u{3bc}rad",
    "nrad",
    "deg",
    "degree",
    "degrees",
    "grad",
    "\u{b0}",
    "rev",
    "revs",
    "turn",
    "turns",
    "arcsec",
    "arcmin",
    "v",
    "mv",
    "uv",
    "\u{b5}v",
    "\u{3bc}v",
    "nv",
    "kv",
    "volt",
    "volts",
    "a",
    "ma",
    "ua",
    "\u{b5}a",
    "\u{3bc}a",
    "na",
    "pa",
    "counts",
    "count",
    "lsb",
    "adc",
    "a.u.",
    "arb",
    "au",
    "%",
];

const ACCELERATIONS: &[&str] = &["g", "mg", "ug", "\u{b5}g", "gal"];

const OTHERS: &[&str] = &[
    "hz",
    "khz",
    "mhz",
    "ghz",
    "n",
    "mn",
    "kn",
    "kg",
    "\u{b0}c",
    "degc",
    "mbar",
    "bar",
    "hpa",
    "mw",
    "nm/rad",
    "n/m",
    "ohm",
    "\u{3a9}",
    "v^2",
    "db/hz",
    "v/\u{221a}hz",
    "rad^2",
    "m^2",
];

/// What a unit measures, or `None` if it is not known.
pub(crate) fn measures(unit: &str) -> Option<Measures> {
    let unit = tidy(unit);
    if let Some(hz) = unit.strip_suffix("hz").and_then(tick_rate) {
        return Some(Measures::Time(Seconds::Over(hz)));
    }
    if let Some(&(_, seconds)) = SECONDS.iter().find(|(name, _)| *name == unit) {
        return Some(Measures::Time(seconds));
    }
    match unit.as_str() {
        "db" | "dbc" | "dbfs" | "db re" => return Some(Measures::Level("")),
        "dbm" => return Some(Measures::Level("\u{221a}mW")),
        "dbv" => return Some(Measures::Level("V")),
        "dbmv" => return Some(Measures::Level("mV")),
        "dbuv" | "db\u{b5}v" | "db\u{3bc}v" => return Some(Measures::Level("\u{b5}V")),
        _ => {}
    }
    if OTHERS.contains(&unit.as_str()) {
        return Some(Measures::Other);
    }
    if ACCELERATIONS.contains(&unit.as_str()) {
        return Some(Measures::Signal(SignalKind::Acceleration));
    }
    if POSITIONS.contains(&unit.as_str()) {
        return Some(Measures::Signal(SignalKind::Displacement));
    }
    for (suffix, kind) in [
        ("/s^2", SignalKind::Acceleration),
        ("/s2", SignalKind::Acceleration),
        ("/s**2", SignalKind::Acceleration),
        ("/s/s", SignalKind::Acceleration),
        ("s^-2", SignalKind::Acceleration),
        ("/sec^2", SignalKind::Acceleration),
        ("/s", SignalKind::Velocity),
        ("/sec", SignalKind::Velocity),
        ("s^-1", SignalKind::Velocity),
    ] {
        let base = unit.strip_suffix(suffix).map(|base| base.trim_end_matches(['*', '\u{b7}', ' ']));
        if base.is_some_and(|base| POSITIONS.contains(&base)) {
            return Some(Measures::Signal(kind));
        }
    }
    None
}

/// The rate of a clock whose ticks are the unit, `60 M` of `60 MHz`.
fn tick_rate(text: &str) -> Option<f64> {
    let (number, factor) = match text.trim_end().chars().next_back()? {
        'k' => (text.trim_end().strip_suffix('k')?, 1e3),
        'm' => (text.trim_end().strip_suffix('m')?, 1e6),
        'g' => (text.trim_end().strip_suffix('g')?, 1e9),
        _ => (text, 1.0),
    };
    number.trim().parse::<f64>().ok().map(|n| n * factor).filter(|hz| hz.is_finite() && *hz > 0.0)
}

/// Lower case, without blanks around operators, powers as `^2`.
fn tidy(unit: &str) -> String {
    unit.trim()
        .to_lowercase()
        .replace('\u{2212}', "-")
        .replace('\u{b2}', "^2")
        .replace("\u{207b}\u{b9}", "^-1")
        .replace("\u{207b}^2", "^-2")
        .replace(" / ", "/")
        .replace(" ^", "^")
        .replace(" s^", "s^")
        .replace("s-1", "s^-1")
        .replace("s-2", "s^-2")
        .replace("(s^2)", "s^2")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_by_many_spellings() {
        for unit in ["m/s^2", "m/s²", "m s^-2", "mm/s2", "g", "rad/s/s", "m s⁻²", "m·s^-2"] {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Acceleration)), "{unit}");
        }
        for unit in ["rad/s", "deg / s", "°/s", "m s-1", "mm/sec"] {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Velocity)), "{unit}");
        }
        for unit in ["rad", "°", "V", "µm", "μm", " mm "] {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Displacement)), "{unit}");
        }
        assert_eq!(measures("ms"), Some(Measures::Time(Seconds::Over(1e3))));
        assert_eq!(measures("dBm"), Some(Measures::Level("√mW")));
        assert_eq!(measures("Hz"), Some(Measures::Other));
        assert_eq!(measures("60 MHz"), Some(Measures::Time(Seconds::Over(60e6))));
        assert_eq!(measures("1.8GHz"), Some(Measures::Time(Seconds::Over(1.8e9))));
        assert_eq!(measures("horse"), None);
    }
}

//! Units as written in headers.

mod list;
mod product;
mod time;

use std::f64::consts::{PI, SQRT_2, TAU};

use slipfit::SignalKind;
use slipfit::model::displacement::{Coordinate, DisplacementUnit, derivative};

pub(crate) use list::listed;
pub(crate) use time::Seconds;

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

/// Lengths, angles and the electrical signals that represent them.
const POSITIONS: &str = "m meter metre meters dm cm mm um \u{b5}m \u{3bc}m nm pm fm in inch ft mil px pixel pixels \
    rad mrad urad \u{b5}rad \u{3bc}rad nrad deg degree degrees grad \u{b0} rev revs turn turns arcsec arcmin \
    v mv uv \u{b5}v \u{3bc}v nv kv volt volts a ma ua \u{b5}a \u{3bc}a na pa counts count lsb adc a.u. arb au %";

const ACCELERATIONS: &str = "g mg ug \u{b5}g gal";

const OTHERS: &str = "hz khz mhz ghz n mn kn kg \u{b0}c degc mbar bar hpa mw nm/rad n/m ohm \u{3a9} v^2 db/hz \
    v/\u{221a}hz rad^2 m^2";

const LEVELS: &[(&str, &str)] = &[
    ("", "db dbc dbfs"),
    ("\u{221a}mW", "dbm"),
    ("V", "dbv"),
    ("mV", "dbmv"),
    ("\u{b5}V", "dbuv db\u{b5}v db\u{3bc}v"),
];

/// Forces and torques by which a response is divided.
const FORCES: &[&str] = &[
    "/N",
    "/kN",
    "/daN",
    "/mN",
    "/uN",
    "/\u{b5}N",
    "/\u{3bc}N",
    "/nN",
    "/lbf",
    "/kgf",
    "/Nm",
    "/(N m)",
    "/(N*m)",
    "/(N\u{b7}m)",
];

/// Square root of a bandwidth.
const ROOT_HERTZ: &[&str] =
    &["/\u{221a}Hz", "/\u{221a}(Hz)", "/sqrt(Hz)", "/rtHz", "/rt(Hz)", "/Hz^0.5", "/Hz^(1/2)", "/Hz^1/2"];

/// Suffixes of units, with the factor that converts their numbers to amplitudes.
const MULTIPLES: &[(&str, f64)] = &[
    ("peak-to-peak", 0.5),
    ("peak to peak", 0.5),
    ("pk-pk", 0.5),
    ("pkpk", 0.5),
    ("p-p", 0.5),
    ("ptp", 0.5),
    ("pp", 0.5),
    ("rms", SQRT_2),
    ("eff", SQRT_2),
    ("peak", 1.0),
    ("pk", 1.0),
];

/// Units of power, whose square roots are amplitudes.
const POWERS: &str = "w mw uw \u{b5}w \u{3bc}w nw";

/// What a unit measures, or `None` if it is not known.
pub(crate) fn measures(unit: &str) -> Option<Measures> {
    plain(unit).or_else(|| {
        let (base, _) = numerator(unit).or_else(|| Some((multiple(unit)?.0, "")))?;
        plain(base).filter(|known| matches!(known, Measures::Signal(_)))
    })
}

/// Whether this is a known unit.
pub(crate) fn is_known(unit: &str) -> bool {
    measures(unit).is_some() || hertz(unit).is_some() || radians(unit).is_some()
}

/// What a unit measures, without a suffix such as peak to peak and without division by a force.
fn plain(unit: &str) -> Option<Measures> {
    let (written, unit) = (unit.to_lowercase(), tidy(unit));
    if let Some(hz) = unit.strip_suffix("hz").and_then(time::tick_rate) {
        return Some(Measures::Time(Seconds::Over(hz)));
    }
    if let Some(seconds) = time::named(&unit) {
        return Some(Measures::Time(seconds));
    }
    if unit == "db re" {
        return Some(Measures::Level(""));
    }
    if let Some((linear, _)) = LEVELS.iter().find(|(_, names)| listed(names, &unit)) {
        return Some(Measures::Level(linear));
    }
    if listed(OTHERS, &unit) {
        return Some(Measures::Other);
    }
    if listed(ACCELERATIONS, &unit) {
        return Some(Measures::Signal(SignalKind::Acceleration));
    }
    let is_position = |unit: &str| listed(POSITIONS, unit) || DisplacementUnit::named(unit).is_some();
    if is_position(&unit) {
        return Some(Measures::Signal(SignalKind::Displacement));
    }
    let (base, order) = derivative(&written)?;
    let kind = if order == 1 { SignalKind::Velocity } else { SignalKind::Acceleration };
    is_position(&base).then_some(Measures::Signal(kind))
}

/// The unit of a response and what it is divided by: `m/s^2` and `/N` for `(m/s^2)/N`, `nm` and `/√Hz` for `nm/√Hz`.
pub(crate) fn numerator(unit: &str) -> Option<(&str, &str)> {
    let unit = unit.trim();
    let ends: Vec<usize> = unit.match_indices('/').map(|(at, _)| at).filter(|at| *at > 0).collect();
    let is_known = |at: &&usize| {
        let tail = &unit[**at..];
        FORCES.contains(&tail) || ROOT_HERTZ.iter().any(|end| tail.eq_ignore_ascii_case(end))
    };
    let at = *ends.iter().find(is_known)?;
    Some((bare(unit[..at].trim()), &unit[at..]))
}

/// Whether a unit is that of a response divided by a force.
pub(crate) fn is_per_force(unit: &str) -> bool {
    numerator(unit).is_some_and(|(_, of)| FORCES.contains(&of))
}

/// A unit without enclosing brackets.
fn bare(unit: &str) -> &str {
    let inner = unit.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).map(str::trim);
    inner.filter(|inner| !inner.contains(['(', ')'])).unwrap_or(unit)
}

/// Base unit and factor to amplitudes of a unit that states the measure of the oscillation: peak to peak, effective or
/// peak.
pub(crate) fn multiple(unit: &str) -> Option<(&str, f64)> {
    let unit = unit.trim();
    let of = |(end, factor): &(&str, f64)| {
        let at = unit.len().checked_sub(end.len())?;
        let (base, tail) = (unit.get(..at)?, unit.get(at..)?);
        let base = base.trim_end_matches([' ', '_', '-', ',']);
        let known = || base.is_empty() || matches!(plain(base), Some(Measures::Signal(_)));
        (tail.eq_ignore_ascii_case(end) && known()).then_some((base, *factor))
    };
    MULTIPLES.iter().find_map(of)
}

/// Unit of the square roots of a power spectral density: `nm/√Hz` for `nm^2/Hz`.
pub(crate) fn root_of_density(unit: &str) -> Option<String> {
    let unit = unit.trim();
    let at = unit.len().checked_sub(3)?;
    let square = unit.get(at..).filter(|tail| tail.eq_ignore_ascii_case("/hz")).and(unit.get(..at))?.trim();
    let square = square.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).unwrap_or(square);
    let base = bare(["^2", "\u{b2}", "**2", "2"].iter().find_map(|end| square.strip_suffix(end))?.trim());
    let known = matches!(plain(base), Some(Measures::Signal(_)));
    known.then(|| format!("{base}/\u{221a}Hz"))
}

/// Unit of the linear amplitudes given by levels in `unit`.
pub(crate) fn linear_unit(unit: &str) -> Option<&'static str> {
    match measures(unit) {
        Some(Measures::Level(linear)) => Some(linear),
        _ => None,
    }
}

/// The linear amplitude of a level in dB, `10^(x/20)`.
pub(crate) fn from_decibels(level: f64) -> f64 {
    10f64.powf(level / 20.0)
}

/// Unit of the amplitudes whose squares are in `unit`: `V` for `V^2`, `\u{221a}mW` for `mW`.
pub(crate) fn root_of_square(unit: &str) -> Option<String> {
    let unit = unit.trim();
    if listed(POWERS, &unit.to_lowercase()) {
        return Some(format!("\u{221a}{unit}"));
    }
    let base = bare(["^2", "\u{b2}", "**2"].iter().find_map(|end| unit.strip_suffix(end))?.trim());
    let signal = |unit: &str| matches!(plain(unit), Some(Measures::Signal(_)));
    (!signal(unit) && signal(base)).then(|| base.to_owned())
}

/// Whether a unit is a time derivative of a position, written in several words: `m s^-2`.
pub(super) fn is_derivative(unit: &str) -> bool {
    derivative(unit).is_some() && matches!(plain(unit), Some(Measures::Signal(_)))
}

/// Factor to Hz of numbers in a unit of frequency.
pub(crate) fn hertz(unit: &str) -> Option<f64> {
    let unit = unit.trim().replace(['\u{b7}', ' '], "").replace("\u{207b}\u{b9}", "^-1");
    let unit = bare(&unit);
    // Prefixes that differ only in case: mHz and MHz.
    let mega = unit.starts_with('M');
    Some(match unit.to_lowercase().as_str() {
        _ if unit == "mHz" => 1e-3,
        "hz" | "cps" | "hertz" => 1.0,
        _ if is_per_second(unit) => 1.0,
        "khz" | "kilohertz" => 1e3,
        "mhz" | "megahertz" => 1e6,
        "ghz" | "gigahertz" => 1e9,
        "millihertz" => 1e-3,
        "uhz" | "\u{b5}hz" | "\u{3bc}hz" => 1e-6,
        "rad/s" | "rads^-1" | "rads-1" | "rad/sec" | "s^-1rad" => 1.0 / TAU,
        "krad/s" => 1e3 / TAU,
        "mrad/s" if mega => 1e6 / TAU,
        "mrad/s" => 1e-3 / TAU,
        "deg/s" | "\u{b0}/s" | "deg/sec" | "\u{b0}/sec" | "dps" => 1.0 / 360.0,
        "rpm" | "cpm" | "1/min" | "u/min" | "min^-1" | "/min" => 1.0 / 60.0,
        _ => return None,
    })
}

/// Whether a unit is the reciprocal second, which is Hz for frequencies and rad/s for angular frequencies.
pub(crate) fn is_per_second(unit: &str) -> bool {
    let unit = unit.trim().to_lowercase().replace("\u{207b}\u{b9}", "^-1");
    matches!(bare(&unit), "1/s" | "1/sec" | "s^-1" | "s-1" | "sec^-1")
}

/// Factor to radians of numbers in a unit of angle; phases may also be in cycles and in multiples of pi.
pub(crate) fn radians(unit: &str) -> Option<f64> {
    match tidy(unit).as_str() {
        "cycle" | "cycles" | "cyc" | "cycl" | "periods" | "zyklen" | "2pi" | "2\u{3c0}" => return Some(TAU),
        "pi" | "\u{3c0}" | "units of pi" | "units of \u{3c0}" | "pi rad" | "\u{3c0} rad" | "rad/pi"
        | "rad/\u{3c0}" => return Some(PI),
        _ => {}
    }
    DisplacementUnit::named(unit).filter(|unit| unit.coordinate == Coordinate::Angle).map(|unit| unit.si)
}

/// [`ratio`] of units that are single names, with or without a common divisor.
fn ratio_of_names(from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    if let Some((base, factor)) = multiple(from) {
        return Some(factor * ratio_of_names(base, to)?);
    }
    if let Some((base, factor)) = multiple(to) {
        return Some(ratio_of_names(from, base)? / factor);
    }
    if let (Some((from, of)), Some((to, other))) = (numerator(from), numerator(to)) {
        return if of == other { ratio_of_names(from, to) } else { None };
    }
    let seconds = |unit: &str| match plain(unit)? {
        Measures::Time(seconds) => Some(seconds.of(1.0)),
        _ => None,
    };
    let volts = |unit: &str| with_prefix(unit, &["volts", "volt", "v"]);
    let amperes = |unit: &str| with_prefix(unit, &["amperes", "ampere", "a"]);
    let metres = |unit: &str| {
        let known = DisplacementUnit::named(unit).filter(|unit| unit.coordinate == Coordinate::Length)?;
        Some(known.si)
    };
    let factor = |known: &dyn Fn(&str) -> Option<f64>| Some(known(from)? / known(to)?);
    factor(&hertz)
        .or_else(|| factor(&seconds))
        .or_else(|| factor(&metres))
        .or_else(|| factor(&radians))
        .or_else(|| factor(&volts))
        .or_else(|| factor(&amperes))
        .or_else(|| factor(&siemens))
        .or_else(|| factor(&ohms))
        .or_else(|| factor(&|unit| with_prefix(unit, &["newtons", "newton", "n"])))
        .or_else(|| factor(&|unit| with_prefix(unit, &["grams", "gram", "g"])))
        .or_else(|| factor(&pascals))
        .or_else(|| factor(&|unit| with_prefix(unit, &["watts", "watt", "w"])))
}

/// Factor from numbers in one unit to numbers in another of the same quantity, each a name or a product of names.
pub(crate) fn ratio(from: &str, to: &str) -> Option<f64> {
    ratio_of_names(from, to).or_else(|| product::ratio(from, to, ratio_of_names))
}

/// Factor to Pa of numbers in a unit of pressure.
fn pascals(unit: &str) -> Option<f64> {
    let bars = || with_prefix(unit, &["bars", "bar"]).map(|bars| 1e5 * bars);
    with_prefix(unit, &["pascals", "pascal", "pa"]).or_else(bars)
}

/// Factor to S of numbers in a unit of conductance.
pub(crate) fn siemens(unit: &str) -> Option<f64> {
    with_prefix(unit, &["siemens", "mho", "s"])
}

/// Factor to Ω of numbers in a unit of resistance.
pub(crate) fn ohms(unit: &str) -> Option<f64> {
    with_prefix(unit, &["ohms", "ohm", "\u{3c9}"])
}

/// Factor of the SI prefix before one of these names, which are in lower case; prefixes are case-sensitive, names are
/// not.
fn with_prefix(unit: &str, names: &[&str]) -> Option<f64> {
    let unit = unit.trim();
    let prefix = |name: &&str| {
        let (at, _) = unit.char_indices().rev().nth(name.chars().count() - 1)?;
        (unit[at..].to_lowercase() == **name).then(|| unit[..at].trim())
    };
    Some(match names.iter().find_map(prefix)? {
        "" => 1.0,
        "G" => 1e9,
        "M" => 1e6,
        "k" => 1e3,
        "h" => 1e2,
        "m" => 1e-3,
        "u" | "\u{b5}" | "\u{3bc}" => 1e-6,
        "n" => 1e-9,
        "p" => 1e-12,
        _ => return None,
    })
}

/// Unit after integration over time: `m/s` and `m/s^2` become `m`.
pub(crate) fn integrated(unit: &str) -> String {
    let unit = unit.trim();
    if let Some((base, of)) = numerator(unit) {
        return format!("{}{of}", integrated(base));
    }
    let cut = || {
        ["/s^2", "/s\u{b2}", "/s2", "/s/s", "/s", " s^-2", " s^-1"]
            .iter()
            .find_map(|end| unit.strip_suffix(end))
    };
    let base = derivative(unit).map(|(base, _)| base).or_else(|| cut().map(|base| base.trim().to_owned()));
    match (base, unit) {
        (Some(base), _) => base,
        (None, "" | "F") => unit.to_owned(),
        (None, "g") => "g s^2".to_owned(),
        (None, other) => format!("{other} s"),
    }
}

/// Lower case, without blanks around operators, powers as `^2`.
fn tidy(unit: &str) -> String {
    unit.trim()
        .to_lowercase()
        .replace('\u{2212}', "-")
        .replace('\u{b2}', "^2")
        .replace("\u{207b}\u{b9}", "^-1")
        .replace("\u{207b}^2", "^-2")
        .replace("\u{207b}\u{b3}", "^-3")
        .replace("\u{207b}\u{2076}", "^-6")
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
        for unit in [
            "m/s^2",
            "m/s²",
            "m s^-2",
            "mm/s2",
            "g",
            "rad/s/s",
            "m s⁻²",
            "m·s^-2",
            "ms⁻²",
            "m*s^-2",
            "m/(s^2)",
            "m/s/s",
            "m/sec^2",
            "m s-2",
            "m s**-2",
            "m/s**2",
            "meter / second ** 2",
            "V/s²",
        ] {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Acceleration)), "{unit}");
        }
        for unit in
            ["rad/s", "deg / s", "°/s", "m s-1", "mm/sec", "ms⁻¹", "rad s-1", "deg/sec", "dps", "inch/s"]
        {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Velocity)), "{unit}");
        }
        for unit in ["rad", "°", "V", "µm", "μm", " mm ", "metre", "Inch", "angstrom", "Å", "micron"] {
            assert_eq!(measures(unit), Some(Measures::Signal(SignalKind::Displacement)), "{unit}");
        }
        assert_eq!(measures("ms"), Some(Measures::Time(Seconds::Over(1e3))));
        assert_eq!(measures("dBm"), Some(Measures::Level("√mW")));
        assert_eq!(measures("Hz"), Some(Measures::Other));
        assert_eq!(measures("60 MHz"), Some(Measures::Time(Seconds::Over(60e6))));
        assert_eq!(measures("1.8GHz"), Some(Measures::Time(Seconds::Over(1.8e9))));
        for (unit, divisor) in [
            ("ms", 1e3),
            ("мс", 1e3),
            ("µsec", 1e6),
            ("nsecs", 1e9),
            ("1/100 s", 100.0),
            ("10ms", 100.0),
            ("x 10 ms", 100.0),
            ("10^-3 s", 1e3),
            ("10⁻³ s", 1e3),
            ("1e-6 s", 1e6),
            ("0.5 ms", 2e3),
        ] {
            let Some(Measures::Time(Seconds::Over(found))) = measures(unit) else { panic!("{unit}") };
            assert!((found / divisor - 1.0).abs() < 1e-12, "{unit}: {found}");
        }
        assert_eq!(measures("2 min"), Some(Measures::Time(Seconds::Times(120.0))));
        for unit in ["1/s", "1/min", "10^-3", "10", "1/0 s", "0 s", "x", "1/100", "e-3 s", "1.2.3 s"] {
            assert!(!matches!(measures(unit), Some(Measures::Time(_))), "{unit}");
        }
        assert_eq!(measures("horse"), None);
    }

    #[test]
    fn units_per_force_and_per_root_of_a_bandwidth_keep_the_kind_of_their_numerator() {
        for (unit, kind, integrated_once) in [
            ("m/s/N", SignalKind::Velocity, "m/N"),
            ("(m/s)/N", SignalKind::Velocity, "m/N"),
            ("(m/s\u{b2})/N", SignalKind::Acceleration, "m/N"),
            ("m/s^2/N", SignalKind::Acceleration, "m/N"),
            ("g/N", SignalKind::Acceleration, "g s^2/N"),
            ("mm/N", SignalKind::Displacement, "mm s/N"),
            ("g/\u{221a}Hz", SignalKind::Acceleration, "g s^2/\u{221a}Hz"),
        ] {
            assert_eq!(measures(unit), Some(Measures::Signal(kind)), "{unit}");
            assert_eq!(integrated(unit), integrated_once, "{unit}");
        }
        for (unit, integrated_once) in
            [("ms⁻²", "m"), ("m s-1", "m"), ("rad/sec", "rad"), ("dps", "deg"), ("V/s", "V")]
        {
            assert_eq!(integrated(unit), integrated_once, "{unit}");
        }
        assert!(is_per_force("m/s/N") && !is_per_force("nm/\u{221a}Hz") && !is_per_force("N"));
        assert_eq!([measures("N"), measures("/N")], [Some(Measures::Other), None]);
    }

    #[test]
    fn parts_of_an_oscillation_and_densities_are_units_of_amplitudes() {
        for (unit, wanted) in [
            ("mVpp", Some(("mV", 0.5))),
            ("V pp", Some(("V", 0.5))),
            ("mm p-p", Some(("mm", 0.5))),
            ("Vrms", Some(("V", SQRT_2))),
            ("V_rms", Some(("V", SQRT_2))),
            ("g pk", Some(("g", 1.0))),
            ("pp", Some(("", 0.5))),
            ("mm", None),
            ("\u{b5}", None),
        ] {
            assert_eq!(multiple(unit), wanted, "{unit}");
        }
        for (unit, root) in [
            ("nm^2/Hz", Some("nm/\u{221a}Hz")),
            ("nm\u{b2}/Hz", Some("nm/\u{221a}Hz")),
            ("(m/s^2)^2/Hz", Some("m/s^2/\u{221a}Hz")),
            ("g2/Hz", Some("g/\u{221a}Hz")),
            ("nm/Hz", None),
            ("1/Hz", None),
            ("Hz", None),
            ("\u{b2}/Hz", None),
        ] {
            assert_eq!(root_of_density(unit).as_deref(), root, "{unit}");
        }
    }

    #[test]
    fn phases_are_counted_in_cycles_and_in_multiples_of_pi_too() {
        for (unit, wanted) in [("cycles", TAU), ("rev", TAU), ("\u{3c0} rad", PI), ("deg", 1f64.to_radians())]
        {
            assert_eq!(radians(unit), Some(wanted), "{unit}");
        }
        assert_eq!(radians("Hz"), None);
    }

    #[test]
    fn units_of_frequency_are_known_by_many_spellings() {
        assert_eq!(hertz("mHz"), Some(1e-3));
        assert_eq!(hertz("MHz"), Some(1e6));
        assert_eq!(hertz("kHz"), Some(1e3));
        assert_eq!(hertz("rad / s"), Some(1.0 / TAU));
        assert_eq!(hertz("rpm"), Some(1.0 / 60.0));
        assert_eq!(hertz("rad s\u{207b}\u{b9}"), Some(1.0 / TAU));
        for unit in ["1/s", "(1/s)", "s^-1", "s\u{207b}\u{b9}", "s-1"] {
            assert_eq!((hertz(unit), is_per_second(unit)), (Some(1.0), true), "{unit}");
        }
        assert_eq!(hertz("horse"), None);
    }

    #[test]
    fn conductances_and_resistances_have_prefixes() {
        for (unit, wanted) in [
            ("S", 1.0),
            ("siemens", 1.0),
            ("mS", 1e-3),
            ("ms", 1e-3),
            ("\u{b5}S", 1e-6),
            ("\u{3bc}S", 1e-6),
            ("uS", 1e-6),
            ("nS", 1e-9),
            ("mmho", 1e-3),
        ] {
            assert_eq!(siemens(unit), Some(wanted), "{unit}");
        }
        for (unit, wanted) in
            [("Ohm", 1.0), ("\u{2126}", 1.0), ("k\u{3a9}", 1e3), ("m\u{3a9}", 1e-3), ("MOhm", 1e6)]
        {
            assert_eq!(ohms(unit), Some(wanted), "{unit}");
        }
        assert_eq!([siemens("V"), siemens(""), ohms("horse")], [None; 3]);
    }

    #[test]
    fn products_of_one_quantity_have_a_ratio() {
        for (from, to, expected) in [
            ("N/mm", "N/m", 1e3),
            ("kN/m", "N/m", 1e3),
            ("kg/s²", "N/m", 1.0),
            ("g cm^2", "kg m²", 1e-7),
            ("mN m/deg", "N m/rad", 1e-3 * 180.0 / std::f64::consts::PI),
            ("N*s/mm", "kg/s", 1e3),
            ("µm/V", "m/V", 1e-6),
            ("mm/m", "1", 1e-3),
            ("1/ms", "1/s", 1e3),
        ] {
            let found = ratio(from, to).unwrap_or(f64::NAN);
            assert!((found / expected - 1.0).abs() < 1e-12, "{from} in {to}: {found}");
        }
        for (from, to) in [("N/m", "N m"), ("horse/m", "N/m"), ("N/m", "kg"), ("N//m", "N/m")] {
            assert_eq!(ratio(from, to), None, "{from} in {to}");
        }
    }
}

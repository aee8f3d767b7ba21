//! Headers of columns: name, unit and run.

use super::{
    multiple::multiple_of_hertz,
    units::{self, Measures, Seconds},
};

/// A column as described by its header.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Name {
    /// The header as written, without surrounding quotes and blanks.
    pub(crate) header: String,
    /// The header without unit and run.
    pub(crate) bare: String,
    /// The unit as written; empty if none was recognised.
    pub(crate) unit: String,
    /// Run of the column, such as `run #2` or `latest`.
    pub(crate) run: Option<String>,
}

impl Name {
    /// Splits a header into its parts.
    pub(crate) fn parse(header: &str) -> Self {
        let header = header.trim().trim_matches('"').trim().replace("\"\"", "\"");
        let (rest, run) = split_run(&header);
        let (bare, unit) = split_unit(&rest);
        Self { header, bare, unit, run }
    }

    /// A header with a separately stated unit.
    #[cfg(any(feature = "arrow", feature = "parquet"))]
    pub(crate) fn with_unit(header: &str, unit: Option<&str>) -> Self {
        unit.map_or_else(|| Self::parse(header), |unit| Self::parse(&format!("{header} ({unit})")))
    }

    /// The unit, if it is known.
    pub(crate) fn measures(&self) -> Option<Measures> {
        units::measures(&self.unit)
    }

    /// Name for comparing columns of several runs: letters only, in lower case.
    pub(crate) fn stem(&self) -> String {
        self.bare.to_lowercase().chars().filter(|c| c.is_alphabetic()).collect()
    }

    /// Whether the column is named like a time step between rows.
    pub(crate) fn is_step(&self) -> bool {
        let bare = self.bare.to_lowercase();
        ["dt", "δt"].contains(&bare.trim())
            || ["interval", "intervall", "previous", "delta t", "delta_t"].iter().any(|w| bare.contains(w))
    }
}

/// Words in lower case, separated by digits and punctuation.
pub(crate) fn words(text: &str) -> Vec<String> {
    text.to_lowercase()
        .split(|c: char| !c.is_alphabetic())
        .filter(|w| !w.is_empty())
        .map(str::to_owned)
        .collect()
}

/// Splits `Run #2`, `Data Set 1:` or `Latest:` off a header.
fn split_run(header: &str) -> (String, Option<String>) {
    // Network analysers write the part of a trace before its name: `re:Trc1_S21`.
    let is_part = |before: &str| {
        let part = before.trim().to_lowercase();
        ["re", "im", "db", "mag", "lin", "ang", "arg", "phase", "real", "imag"].contains(&part.as_str())
    };
    // `GMT+01:00` is a time-zone offset.
    let is_clock = |before: &str, after: &str| {
        before.ends_with(|c: char| c.is_ascii_digit()) && after.starts_with(|c: char| c.is_ascii_digit())
    };
    if let Some((before, after)) = header.split_once(':')
        && !after.trim().is_empty()
        && !is_part(before)
        && !is_clock(before, after)
        && !before.contains(['(', '['])
    {
        return (after.trim().to_owned(), Some(before.trim().to_lowercase()));
    }
    let lower = header.to_ascii_lowercase();
    for word in ["run", "trial", "messung", "durchgang", "essai", "prova", "ensayo"] {
        let Some(at) = find_word(&lower, word) else { continue };
        let tail = &lower[at + word.len()..];
        let number = tail.trim_start_matches([' ', '#', '_']);
        let digits = number.len() - number.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        if digits == 0 {
            continue;
        }
        let end = at + word.len() + (tail.len() - number.len()) + digits;
        let rest =
            format!("{} {}", header[..at].trim_end_matches([' ', ',', '_', '-']), header[end..].trim());
        return (rest.trim().to_owned(), Some(format!("{word} {}", &number[..digits])));
    }
    (header.to_owned(), None)
}

fn find_word(text: &str, word: &str) -> Option<usize> {
    let at = text.find(word)?;
    let begins = text[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric());
    begins.then_some(at)
}

/// Splits the unit off a header: `Time (s)`, `power [dBm]`, `Weg / rad`, `Angle/rad`, `time_ms`, `U in V`, `Zeit s`.
fn split_unit(text: &str) -> (String, String) {
    // Onset loggers write the sensor after the unit.
    let text = text.split(" (LGR S/N").next().unwrap_or(text);
    if is_time_alone(text) {
        return (text.to_owned(), text.to_owned());
    }
    if let Some(volts_or_amperes) = of_circuit(text) {
        return (text.to_owned(), volts_or_amperes.to_owned());
    }
    let bracketed =
        [('[', ']'), ('(', ')'), ('{', '}'), ('（', '）')].into_iter().filter_map(|(open, close)| {
            let (from, to) = (text.find(open)?, text.rfind(close)?);
            let unit = text.get(from + open.len_utf8()..to)?.trim();
            let rest = format!("{} {}", text[..from].trim(), text[to + close.len_utf8()..].trim());
            Some((rest.trim_end().trim_end_matches('/').trim().to_owned(), unit.to_owned()))
        });
    let known = |unit: &str| {
        let of_frequency = || multiple_of_hertz(unit).is_some();
        units::measures(unit).is_some() || units::radians(unit).is_some() || of_frequency()
    };
    let like_one = |unit: &str| unit.len() > 1 && !unit.contains(char::is_whitespace);
    let first = |serves: &dyn Fn(&str) -> bool| bracketed.clone().find(|(_, unit)| serves(unit));
    if let Some(parts) = first(&known).or_else(|| first(&like_one)) {
        return parts;
    }
    // A unit of several words: `a m s^-2`.
    let last_words = text.match_indices(' ').map(|(at, _)| text.split_at(at)).find(|(bare, unit)| {
        let is_unit = unit.trim().contains(' ') && units::is_derivative(unit);
        is_unit && !bare.trim().is_empty() && !bare.ends_with([' ', '/', ','])
    });
    if let Some((bare, unit)) = last_words
        && !bare.ends_with(" in")
    {
        return (bare.trim().to_owned(), unit.trim().to_owned());
    }
    for mark in [" / ", " in ", "/", ", ", " ", "_"] {
        let parts = match mark {
            "/" | " / " => text.split_once(mark),
            _ => text.rsplit_once(mark),
        };
        if let Some((bare, unit)) = parts
            && !bare.trim().is_empty()
            && (units::measures(unit).is_some()
                || matches!(mark.trim(), "in" | "/") && units::hertz(unit).is_some()
                || mark.contains('/') && matches!(unit.trim().to_lowercase().as_str(), "pi" | "\u{3c0}"))
            // `Expansion In` is not a length in inches.
            && !(mark == " " && unit.eq_ignore_ascii_case("in"))
            // `U_in` is not a voltage in inches either.
            && !(mark == "_" && unit.eq_ignore_ascii_case("in") && is_electrical(bare))
            && (mark.contains('/') || mark == " in " || unit.len() > 1 || unit == "s" || is_letter_of(bare, mark, unit))
        {
            return (bare.trim().to_owned(), unit.trim().to_owned());
        }
    }
    match joined_time(text) {
        Some(at) => (text[..at].to_owned(), text[at..].to_owned()),
        None => (text.to_owned(), String::new()),
    }
}

/// Whether a header consists only of a unit of short times: `us`, `ms`, `micros`.
fn is_time_alone(text: &str) -> bool {
    let is_word = text.chars().all(char::is_alphabetic) && text != "ps";
    is_word && matches!(units::measures(text), Some(Measures::Time(Seconds::Over(_))))
}

/// Unit of a quantity that a circuit simulator names by node or part: V of `V(out)`, A of `I(R1)`. `v(t)` is a function
/// of time.
fn of_circuit(text: &str) -> Option<&'static str> {
    let (letter, rest) = text.split_once('(')?;
    let node = rest.strip_suffix(')')?;
    let is_node = node.chars().count() > 1
        && node.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | ',' | '+' | '-'))
        && node.starts_with(|c: char| c.is_ascii_alphabetic())
        && units::measures(node).is_none()
        && units::hertz(node).is_none();
    match letter {
        "V" | "v" if is_node => Some("V"),
        "I" | "i" if is_node => Some("A"),
        _ => None,
    }
}

/// Whether one letter after a separator is a unit: `U_V`, `ax_g` of accelerations, and `Position, m`.
fn is_letter_of(bare: &str, mark: &str, unit: &str) -> bool {
    let first = || words(bare).first().cloned().unwrap_or_default();
    mark == ", " && matches!(unit, "m" | "g" | "V")
        || mark == "_"
            && match unit {
                // In curves this names a drive level, which divides the response unconverted.
                "V" => !["drive", "excit", "antrieb"].iter().any(|part| bare.to_lowercase().contains(part)),
                "g" => {
                    let lower = bare.to_lowercase();
                    ["acc", "beschl", "vib"].iter().any(|part| lower.contains(part))
                        || units::listed("a ax ay az x y z", &first())
                }
                _ => false,
            }
}

/// Position of a unit of time that is joined to its name: `TimeUS`, `timestampNs`, `elapsedMillis`, `timems`.
fn joined_time(text: &str) -> Option<usize> {
    let is_short = |unit: &str| matches!(units::measures(unit), Some(Measures::Time(Seconds::Over(_))));
    let lower_before = |at: usize| text[..at].ends_with(char::is_lowercase);
    let camel = text
        .char_indices()
        .filter(|(at, c)| c.is_uppercase() && lower_before(*at))
        .map(|(at, _)| at)
        .find(|at| text[*at..].chars().all(char::is_alphabetic) && is_short(&text[*at..]));
    let of_time = || {
        let name = ["timestamp", "time"].into_iter().find(|name| {
            let start = text.get(..name.len());
            start.is_some_and(|start| start.eq_ignore_ascii_case(name)) && is_short(&text[name.len()..])
        })?;
        Some(name.len())
    };
    camel.or_else(of_time)
}

/// Whether a name denotes a voltage, a current or a channel.
fn is_electrical(bare: &str) -> bool {
    ["u", "v", "i", "ch"].contains(&bare.trim().to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_off_headers() {
        for (header, bare, unit) in [
            ("Time (s)", "Time", "s"),
            ("Time ( s )", "Time", "s"),
            ("Zeit t / s", "Zeit t", "s"),
            ("Weg &b_A1 / rad", "Weg &b_A1", "rad"),
            ("zeiliche Ableitung w_1 / rad/s", "zeiliche Ableitung w_1", "rad/s"),
            ("AngVel/rad/s", "AngVel", "rad/s"),
            ("Angle/rad", "Angle", "rad"),
            ("power [dBm]", "power", "dBm"),
            ("Δt (ms)", "Δt", "ms"),
            ("time_ms", "time", "ms"),
            ("Linear Acceleration x (m/s^2)", "Linear Acceleration x", "m/s^2"),
            ("Position (mm) Run #1", "Position", "mm"),
            ("Data Set 1:Position(m)", "Position", "m"),
            ("U in mV", "U", "mV"),
            ("ω in 1/s", "ω", "1/s"),
            ("ω / s^-1", "ω", "s^-1"),
            ("ω/(1/s)", "ω", "1/s"),
            ("Drehzahl in rpm", "Drehzahl", "rpm"),
            ("Expansion In", "Expansion In", ""),
            ("U_in", "U_in", ""),
            ("gap_in", "gap", "in"),
            ("theta1", "theta1", ""),
            ("Winkel (°)", "Winkel", "°"),
            ("us", "us", "us"),
            ("µs", "µs", "µs"),
            ("usec", "usec", "usec"),
            ("TimeUS", "Time", "US"),
            ("timestampNs", "timestamp", "Ns"),
            ("timestamp_ms", "timestamp", "ms"),
            ("elapsedMillis", "elapsed", "Millis"),
            ("timems", "time", "ms"),
            ("Time (msec.)", "Time", "msec."),
            ("Time (ms) [rel]", "Time [rel]", "ms"),
            ("Time (rel) [ms]", "Time (rel)", "ms"),
            ("時間 [ミリ秒]", "時間", "ミリ秒"),
            (r"t [\si{\ms}]", "t", r"\si{\ms}"),
            (r"t [$\mu$s]", "t", r"$\mu$s"),
            ("Time [Sec/100]", "Time", "Sec/100"),
            ("Время (мс)", "Время", "мс"),
            ("t [1/100 s]", "t", "1/100 s"),
            ("time(10ms)", "time", "10ms"),
            ("Time [x 10ms]", "Time", "x 10ms"),
            ("t (10^-3 s)", "t", "10^-3 s"),
            ("STATUS", "STATUS", ""),
            ("times", "times", ""),
            ("a m s^-2", "a", "m s^-2"),
            ("a / m s⁻²", "a", "m s⁻²"),
            ("v in m s-1", "v", "m s-1"),
            ("v / ms⁻¹", "v", "ms⁻¹"),
            ("ax (m/(s^2))", "ax", "m/(s^2)"),
            ("a (meter / second ** 2)", "a", "meter / second ** 2"),
            ("V(out)", "V(out)", "V"),
            ("V(n001)", "V(n001)", "V"),
            ("I(R1)", "I(R1)", "A"),
            ("v(m/s)", "v", "m/s"),
            ("v(t)", "v(t)", ""),
            ("V (V)", "V", "V"),
            ("U_V", "U", "V"),
            ("drive_V", "drive_V", ""),
            ("ax_g", "ax", "g"),
            ("gz_dps", "gz", "dps"),
            ("omega_g", "omega_g", ""),
            ("x_m", "x_m", ""),
            ("Accel, g (LGR S/N: 2345)", "Accel", "g"),
        ] {
            let name = Name::parse(header);
            assert_eq!((name.bare.as_str(), name.unit.as_str()), (bare, unit), "{header}");
        }
    }

    #[test]
    fn runs_are_taken_off_headers() {
        assert_eq!(Name::parse("Angle (rad) Run #12").run.as_deref(), Some("run 12"));
        assert_eq!(Name::parse("Latest: Time (s)").run.as_deref(), Some("latest"));
        assert_eq!(Name::parse("Data Set 2:Time(s)").run.as_deref(), Some("data set 2"));
        assert_eq!(Name::parse("Angle (rad)").run, None);
        assert_eq!(Name::parse("re:Trc1_S21").run, None);
        assert_eq!(Name::parse("Date Time, GMT+01:00").run, None);
        assert_eq!(Name::parse("Trunk angle").run, None);
    }
}

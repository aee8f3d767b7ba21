//! Headers of columns: name, unit and run.

use super::units::{self, Measures};

/// A column as its header describes it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Name {
    /// The header as written, quotes and blanks around it removed.
    pub(crate) header: String,
    /// The header without unit and run.
    pub(crate) bare: String,
    /// The unit as written; empty if none was recognised.
    pub(crate) unit: String,
    /// Which run it belongs to, such as `run #2` or `latest`.
    pub(crate) run: Option<String>,
}

impl Name {
    /// Takes a header apart.
    pub(crate) fn parse(header: &str) -> Self {
        let header = header.trim().trim_matches('"').trim().replace("\"\"", "\"");
        let (rest, run) = split_run(&header);
        let (bare, unit) = split_unit(&rest);
        Self { header, bare, unit, run }
    }

    /// A header and the unit stated apart from it.
    #[cfg(any(feature = "arrow", feature = "parquet"))]
    pub(crate) fn with_unit(header: &str, unit: Option<&str>) -> Self {
        unit.map_or_else(|| Self::parse(header), |unit| Self::parse(&format!("{header} ({unit})")))
    }

    /// The unit, if it is known.
    pub(crate) fn measures(&self) -> Option<Measures> {
        units::measures(&self.unit)
    }

    /// Name for comparing columns of several runs: no digits, no case.
    pub(crate) fn stem(&self) -> String {
        self.bare.to_lowercase().chars().filter(|c| c.is_alphabetic()).collect()
    }

    /// Whether the column is named like a time between rows.
    pub(crate) fn is_step(&self) -> bool {
        let bare = self.bare.to_lowercase();
        ["dt", "δt"].contains(&bare.trim())
            || ["interval", "intervall", "previous", "delta t", "delta_t"].iter().any(|w| bare.contains(w))
    }
}

/// Words in lower case; digits end a word, marks separate.
pub(crate) fn words(text: &str) -> Vec<String> {
    text.to_lowercase()
        .split(|c: char| !c.is_alphabetic())
        .filter(|w| !w.is_empty())
        .map(str::to_owned)
        .collect()
}

/// Takes `Run #2`, `Data Set 1:` or `Latest:` off a header.
fn split_run(header: &str) -> (String, Option<String>) {
    // A network analyser writes a part of a trace before its name: `re:Trc1_S21`.
    let is_part = |before: &str| {
        let part = before.trim().to_lowercase();
        ["re", "im", "db", "mag", "lin", "ang", "arg", "phase", "real", "imag"].contains(&part.as_str())
    };
    if let Some((before, after)) = header.split_once(':')
        && !after.trim().is_empty()
        && !is_part(before)
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

/// Takes the unit off a header: `Time (s)`, `power [dBm]`, `Weg / rad`,
/// `Angle/rad`, `time_ms`, `U in V`, `Zeit s`.
fn split_unit(text: &str) -> (String, String) {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('（', '）')] {
        if let (Some(from), Some(to)) = (text.find(open), text.rfind(close))
            && from < to
        {
            let unit = text[from + open.len_utf8()..to].trim();
            let rest = format!("{} {}", text[..from].trim(), text[to + close.len_utf8()..].trim());
            let rest = rest.trim_end().trim_end_matches('/');
            let known = units::measures(unit).is_some() || units::radians(unit).is_some();
            if known || (unit.len() > 1 && !unit.contains(char::is_whitespace)) {
                return (rest.trim().to_owned(), unit.to_owned());
            }
        }
    }
    for mark in [" / ", " in ", "/", ", ", " ", "_"] {
        let parts = match mark {
            "/" | " / " => text.split_once(mark),
            _ => text.rsplit_once(mark),
        };
        if let Some((bare, unit)) = parts
            && !bare.trim().is_empty()
            && (units::measures(unit).is_some()
                || matches!(mark.trim(), "in" | "/") && units::hertz(unit).is_some())
            // `Expansion In` is no length in inches.
            && !(mark == " " && unit.eq_ignore_ascii_case("in"))
            // Nor is `U_in` a voltage in inches.
            && !(mark == "_" && unit.eq_ignore_ascii_case("in") && is_electrical(bare))
            && (mark.contains('/') || mark == " in " || unit.len() > 1 || unit == "s")
        {
            return (bare.trim().to_owned(), unit.trim().to_owned());
        }
    }
    (text.to_owned(), String::new())
}

/// Whether a name is that of a voltage, a current or a channel.
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
        assert_eq!(Name::parse("Trunk angle").run, None);
    }
}

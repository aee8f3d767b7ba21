//! What a header says about its column.

use slipfit::SignalKind;

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

/// What a column may be taken for, by its name alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Role {
    Time,
    /// A signal; the greater rank is preferred.
    Signal {
        rank: u8,
        kind: SignalKind,
        like: &'static str,
    },
    /// In-phase output of a lock-in.
    InPhase,
    /// Quadrature output of a lock-in.
    Quadrature,
    /// Not the signal, whatever it holds.
    Never,
    Unknown,
}

impl Name {
    /// Takes a header apart.
    pub(crate) fn parse(header: &str) -> Self {
        let header = header.trim().trim_matches('"').trim().replace("\"\"", "\"");
        let (rest, run) = split_run(&header);
        let (bare, unit) = split_unit(&rest);
        Self { header, bare, unit, run }
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

    /// What the column may be taken for.
    pub(crate) fn role(&self) -> Role {
        let words = words(&self.bare);
        // Short words mean something only in front: the A of `Weg b_A` is an index.
        let begins = |list: &[&str]| words.first().is_some_and(|w| list.contains(&w.as_str()));
        let has = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
        let within = |list: &[&str]| words.iter().any(|w| list.iter().any(|part| w.contains(part)));
        let measures = self.measures();
        if self.header.is_empty() {
            return Role::Unknown;
        }
        if has(NEVER) || within(NEVER_WITHIN) || measures == Some(Measures::Other) {
            return Role::Never;
        }
        if matches!(measures, Some(Measures::Time(_)))
            || has(TIME)
            || begins(TIME_SHORT)
            || within(TIME_WITHIN)
        {
            let is_signal = matches!(measures, Some(Measures::Signal(_) | Measures::Level(_)));
            if !is_signal {
                return Role::Time;
            }
        }
        if words.concat().contains(IN_PHASE) {
            return Role::InPhase;
        }
        if has(QUADRATURE) {
            return Role::Quadrature;
        }
        let signal = |rank, kind, like| Role::Signal { rank, kind, like };
        if let Some(Measures::Level(_)) = measures {
            return signal(90, SignalKind::Envelope, "named like a level in dB");
        }
        let derived = has(DERIVATIVE) || within(DERIVATIVE);
        if measures == Some(Measures::Signal(SignalKind::Acceleration))
            || within(ACCELERATION)
            || begins(ACCELERATION_SHORT)
        {
            let rank = if has(ABSOLUTE) || within(ABSOLUTE) { 30 } else { 50 };
            return signal(rank, SignalKind::Acceleration, "named like an acceleration");
        }
        if measures == Some(Measures::Signal(SignalKind::Velocity))
            || derived
            || within(VELOCITY)
            || begins(VELOCITY_SHORT)
        {
            return signal(60, SignalKind::Velocity, "named like a velocity");
        }
        if within(ENVELOPE) || begins(ENVELOPE_SHORT) {
            return signal(80, SignalKind::Envelope, "named like an amplitude");
        }
        if within(ANGLE) || begins(ANGLE_SHORT) {
            return signal(100, SignalKind::Displacement, "named like an angle");
        }
        if within(POSITION) || begins(POSITION_SHORT) {
            return signal(100, SignalKind::Displacement, "named like a position");
        }
        if measures == Some(Measures::Signal(SignalKind::Displacement))
            || within(ELECTRICAL)
            || begins(ELECTRICAL_SHORT)
        {
            return signal(70, SignalKind::Displacement, "named like a measured signal");
        }
        Role::Unknown
    }
}

const TIME: &[&str] = &[
    "time",
    "timed",
    "times",
    "timestamp",
    "zeit",
    "laufzeit",
    "tempo",
    "temps",
    "tiempo",
    "tid",
    "tijd",
    "czas",
    "aika",
    "zaman",
    "čas",
    "idő",
    "время",
    "час",
    "时间",
    "時間",
    "시간",
    "elapsed",
    "seconds",
    "millis",
    "clock",
    "sekunden",
    "secondi",
    "segundos",
    "hora",
];
const TIME_SHORT: &[&str] = &["t", "dt", "δt", "sec", "secs", "ms"];
const TIME_WITHIN: &[&str] = &["time", "zeit", "tiempo", "timestamp"];
/// Columns beside the motion: its uncertainty, its drive, its spectrum.
const NEVER: &[&str] = &[
    "sigma",
    "err",
    "error",
    "errors",
    "unc",
    "uncert",
    "uncertainty",
    "std",
    "stdev",
    "fehler",
    "unsicherheit",
    "incertezza",
    "errore",
    "erreur",
    "incertidumbre",
    "freq",
    "frequency",
    "frequenz",
    "frequenza",
    "fréquence",
    "frecuencia",
    "f",
    "index",
    "idx",
    "nr",
    "sample",
    "samples",
    "no",
    "drive",
    "antrieb",
    "excitation",
    "temperature",
    "temperatur",
    "temp",
    "pressure",
    "druck",
    "force",
    "kraft",
    "forza",
    "fit",
    "model",
    "residual",
    "residuals",
    "mass",
    "masse",
    "massa",
    "energy",
    "energie",
    "row",
    "frame",
    "fps",
    "n",
    "period",
    "periode",
    "date",
    "datum",
    "fecha",
];
const NEVER_WITHIN: &[&str] = &["fft", "uncert", "residu", "frequen"];
const IN_PHASE: &str = "inphase";
const QUADRATURE: &[&str] = &["quadrature", "quad"];
const DERIVATIVE: &[&str] = &["ableitung", "derivative", "derivata", "dérivée", "derivada"];
const ACCELERATION: &[&str] = &["accel", "beschleunig", "acelera", "accélér", "ускорен", "加速度"];
const ACCELERATION_SHORT: &[&str] = &["a", "ax", "ay", "az", "acc", "gx", "gy", "gz"];
const ABSOLUTE: &[&str] = &["absolut", "betrag", "norm", "abs", "total", "magnitude"];
const VELOCITY: &[&str] =
    &["veloc", "speed", "geschwindig", "vitesse", "omega", "angvel", "gyro", "скорость", "速度"];
const VELOCITY_SHORT: &[&str] = &["v", "vx", "vy", "vz", "w", "ω", "vel"];
const ENVELOPE: &[&str] =
    &["magnitude", "envelope", "einhüllende", "hüllkurve", "inviluppo", "amplitud", "power"];
const ENVELOPE_SHORT: &[&str] = &["r", "mag", "amp"];
const ANGLE: &[&str] =
    &["angle", "angol", "ángul", "angul", "winkel", "theta", "угол", "角度", "twist", "rotation"];
const ANGLE_SHORT: &[&str] = &["θ", "ϑ", "phi", "φ", "ϕ", "alpha", "α", "ang"];
const POSITION: &[&str] = &[
    "position",
    "posizion",
    "posici",
    "displace",
    "auslenk",
    "weg",
    "elongat",
    "elongac",
    "spostament",
    "déplacem",
    "deplacem",
    "desplaz",
    "ausschlag",
    "deflection",
    "distanc",
    "distanz",
    "abstand",
    "waveform",
    "переме",
    "位移",
];
const POSITION_SHORT: &[&str] =
    &["x", "y", "z", "pos", "disp", "s", "height", "höhe", "altezza", "length", "dist"];
const ELECTRICAL: &[&str] = &["voltag", "spannung", "tension", "voltaj", "signal", "detector", "photodiode"];
const ELECTRICAL_SHORT: &[&str] =
    &["u", "volt", "volts", "ch", "cha", "chb", "kanal", "canal", "adc", "value", "wert"];

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
    if let Some((before, after)) = header.split_once(':')
        && !after.trim().is_empty()
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
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let (Some(from), Some(to)) = (text.find(open), text.rfind(close))
            && from < to
        {
            let unit = text[from + open.len_utf8()..to].trim();
            let rest = format!("{} {}", text[..from].trim(), text[to + close.len_utf8()..].trim());
            if units::measures(unit).is_some() || (unit.len() > 1 && !unit.contains(char::is_whitespace)) {
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
            && units::measures(unit).is_some()
            && (mark.contains('/') || mark == " in " || unit.len() > 1 || unit == "s")
        {
            return (bare.trim().to_owned(), unit.trim().to_owned());
        }
    }
    (text.to_owned(), String::new())
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
        assert_eq!(Name::parse("Trunk angle").run, None);
    }

    #[test]
    fn roles_follow_the_words() {
        for header in
            ["Time (s)", "t", "timestamp", "Zeit t / s", "Tempo", "Δt (ms)", "Timed", "t1", "Temps (s)"]
        {
            assert_eq!(Name::parse(header).role(), Role::Time, "{header}");
        }
        let kind = |header| match Name::parse(header).role() {
            Role::Signal { kind, .. } => Some(kind),
            _ => None,
        };
        assert_eq!(kind("Weg &b_A1 / rad"), Some(SignalKind::Displacement));
        assert_eq!(kind("zeiliche Ableitung w_1 / rad/s"), Some(SignalKind::Velocity));
        assert_eq!(kind("AngVel/rad/s"), Some(SignalKind::Velocity));
        assert_eq!(kind("With TMD (m/s^2)"), Some(SignalKind::Acceleration));
        assert_eq!(kind("power [dBm]"), Some(SignalKind::Envelope));
        assert_eq!(kind("omega1"), Some(SignalKind::Velocity));
        assert_eq!(kind("Voltage ( V )"), Some(SignalKind::Displacement));
        for header in ["FFT f_3 / rad", "Frequenz f / Hz", "sigma", "Neue Größe f_2 / V"] {
            assert_eq!(Name::parse(header).role(), Role::Never, "{header}");
        }
    }
}

//! What a header says about a column of a resonance curve.

use crate::columns::{
    names::{Name, words},
    units::Measures,
};

/// What a column may be taken for, by its name and unit alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Role {
    Frequency,
    /// From a centre.
    Shift,
    Centre,
    Period,
    Amplitude,
    Phase,
    Real,
    Imaginary,
    /// Quartz: real and imaginary part of the admittance.
    Conductance,
    Susceptance,
    /// Quartz: real and imaginary part of the impedance in series.
    Resistance,
    Reactance,
    Drive,
    StdError,
    Time,
    /// Beside the curve: a counter, a file name, a temperature, a spectrum.
    Never,
    Unknown,
}

const SHIFT: &[&str] = &["shift", "detun", "verstimm", "offset", "delta"];
const SHIFT_SHORT: &[&str] = &["df", "δf", "dω", "δω", "dw", "∆f"];
const CENTRE: &[&str] = &["center", "centre", "mitten", "carrier", "central"];
const FREQUENCY: &[&str] = &["freq", "frequen", "fréquen", "frecuen", "kreisfrequ", "puls", "част", "频率"];
const FREQUENCY_SHORT: &[&str] =
    &["f", "ν", "nu", "hz", "khz", "mhz", "ghz", "omega", "ω", "w", "rpm", "drehzahl"];
const PERIOD: &[&str] = &["period", "schwingungsdauer", "umlauf"];
const TIME: &[&str] = &["time", "zeit", "tempo", "temps", "tiempo", "timestamp", "elapsed", "время"];
const AMPLITUDE: &[&str] = &[
    "amplitud",
    "ampiezza",
    "magnitud",
    "betrag",
    "response",
    "respons",
    "transmiss",
    "ausschlag",
    "амплит",
    "振幅",
    "level",
    "pegel",
    "power",
    "gain",
    "deflection",
    "elongat",
];
const AMPLITUDE_SHORT: &[&str] = &[
    "a", "amp", "ampl", "mag", "r", "max", "peak", "pk", "pp", "vpp", "rms", "abs", "s", "db", "dbm", "y",
    "z",
];
const PHASE: &[&str] = &["phase", "fase", "phas", "phasenv", "фаз"];
const PHASE_SHORT: &[&str] = &["phi", "φ", "ϕ", "theta", "θ", "ϑ", "arg", "ph", "angle", "lag"];
const REAL: &[&str] = &["re", "real", "realteil", "inphase", "reale", "réel"];
const IMAGINARY: &[&str] = &["im", "imag", "imaginary", "imaginärteil", "quadrature", "quad", "immaginaria"];
const DRIVE: &[&str] =
    &["drive", "driving", "antrieb", "excit", "anreg", "erreg", "force", "kraft", "forza", "stimul"];
const DRIVE_SHORT: &[&str] = &["input", "exc", "force"];
const STD_ERROR: &[&str] =
    &["sigma", "err", "error", "unc", "std", "stdev", "fehler", "errore", "erreur", "se", "σ"];
const STD_ERROR_WITHIN: &[&str] = &["uncert", "unsicher", "incert", "stderr"];
const NEVER: &[&str] = &[
    "index",
    "idx",
    "nr",
    "no",
    "n",
    "row",
    "source",
    "file",
    "temp",
    "temperature",
    "temperatur",
    "outliers",
    "samples",
    "points",
    "q",
    "vswr",
    "fwhm",
    "date",
    "datum",
    "run",
    "id",
    "label",
    "comment",
];
const NEVER_WITHIN: &[&str] = &["resid", "fft", "outlier", "temperat", "pressure", "bandwidth"];

/// Units of a frequency, with what turns them into Hz.
pub(super) fn to_hz(unit: &str) -> Option<f64> {
    const TAU: f64 = std::f64::consts::TAU;
    let unit = unit.trim().replace(['\u{b7}', ' '], "");
    // The one prefix that only its case tells: mHz and MHz.
    if unit == "mHz" {
        return Some(1e-3);
    }
    let factor = match unit.to_lowercase().as_str() {
        "hz" | "1/s" | "s^-1" | "s-1" | "cps" | "hertz" => 1.0,
        "khz" => 1e3,
        "mhz" => 1e6,
        "ghz" => 1e9,
        "uhz" | "\u{b5}hz" | "\u{3bc}hz" => 1e-6,
        "rad/s" | "rads^-1" | "rads-1" | "rad/sec" | "s^-1rad" => 1.0 / TAU,
        "krad/s" => 1e3 / TAU,
        "mrad/s" => {
            if unit.starts_with('M') {
                1e6 / TAU
            } else {
                1e-3 / TAU
            }
        }
        "deg/s" | "\u{b0}/s" => 1.0 / 360.0,
        "rpm" | "1/min" | "u/min" | "min^-1" | "/min" => 1.0 / 60.0,
        _ => return None,
    };
    Some(factor)
}

/// What the column may be taken for.
pub(super) fn role(name: &Name) -> Role {
    if name.header.is_empty() {
        return Role::Unknown;
    }
    let bare = name.bare.trim();
    let mut words = words(bare);
    // `S21` and `|x|` have their letters; `Re(X)` two words.
    let first = words.first().cloned().unwrap_or_default();
    let has = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    let begins = |list: &[&str]| list.contains(&first.as_str());
    let within = |list: &[&str]| words.iter().any(|w| list.iter().any(|part| w.contains(part)));
    let measures = name.measures();
    if has(STD_ERROR) || within(STD_ERROR_WITHIN) {
        return Role::StdError;
    }
    if within(NEVER_WITHIN) {
        return Role::Never;
    }
    // `Oscillation Control>Center Frequency (Hz)` and `Frequency Shift (Hz)` before `Frequency`.
    let frequency = to_hz(&name.unit).is_some() && unit_is_frequency(&name.unit) || within(FREQUENCY);
    if within(CENTRE) && frequency {
        return Role::Centre;
    }
    if within(SHIFT) && frequency || begins(SHIFT_SHORT) {
        return Role::Shift;
    }
    let in_phase = words.concat().starts_with("inphase");
    if within(PHASE) && !in_phase {
        return Role::Phase;
    }
    if begins(REAL) || in_phase {
        return Role::Real;
    }
    if begins(IMAGINARY) {
        return Role::Imaginary;
    }
    if within(DRIVE) || has(DRIVE_SHORT) {
        return Role::Drive;
    }
    if within(PERIOD) || (matches!(measures, Some(Measures::Time(_))) && bare == "T") {
        return Role::Period;
    }
    if within(TIME) || (matches!(measures, Some(Measures::Time(_))) && ["t", "T"].contains(&bare)) {
        return Role::Time;
    }
    if within(FREQUENCY) || unit_is_frequency(&name.unit) {
        return Role::Frequency;
    }
    if let Some(role) = quartz(bare, &name.unit) {
        return role;
    }
    let angular =
        ["deg", "\u{b0}", "rad", "degree", "degrees", "grad"].contains(&name.unit.to_lowercase().as_str());
    if begins(PHASE_SHORT) || bare.starts_with('<') || bare.starts_with('\u{2220}') {
        // An oscillator's angle is a response; the phase of one is called so or stands in degrees.
        let is_angle = begins(&["theta", "θ", "ϑ", "angle"]) && !angular;
        return if is_angle { Role::Unknown } else { Role::Phase };
    }
    if within(AMPLITUDE) || bare.starts_with('|') || matches!(measures, Some(Measures::Level(_))) {
        return Role::Amplitude;
    }
    if begins(FREQUENCY_SHORT) {
        return Role::Frequency;
    }
    if bare == "T" {
        return Role::Period;
    }
    if bare == "t" {
        return Role::Time;
    }
    if begins(AMPLITUDE_SHORT) || (begins(&["x"]) && words.len() == 1) {
        return Role::Amplitude;
    }
    if has(NEVER) {
        return Role::Never;
    }
    words.retain(|w| w.len() > 1);
    Role::Unknown
}

fn unit_is_frequency(unit: &str) -> bool {
    let lower = unit.trim().to_lowercase();
    to_hz(unit).is_some() && !matches!(lower.as_str(), "deg/s" | "\u{b0}/s" | "mrad/s" | "1/s")
}

/// `Gp`, `Bp (S)`, `Rs (Ohm)`, `Xs`.
fn quartz(bare: &str, unit: &str) -> Option<Role> {
    let unit = unit.trim().to_lowercase();
    let siemens = ["s", "ms", "us", "\u{b5}s", "\u{3bc}s", "siemens", "mho"].contains(&unit.as_str());
    let ohm = ["ohm", "ohms", "\u{3c9}", "kohm", "k\u{3c9}", "\u{2126}"].contains(&unit.as_str());
    match bare.trim().to_lowercase().as_str() {
        "gp" | "conductance" | "leitwert" => Some(Role::Conductance),
        "g" if unit.is_empty() || siemens => Some(Role::Conductance),
        "bp" | "susceptance" => Some(Role::Susceptance),
        "b" if unit.is_empty() || siemens => Some(Role::Susceptance),
        "rs" | "resistance" => Some(Role::Resistance),
        "xs" | "reactance" | "reaktanz" => Some(Role::Reactance),
        "r" if ohm => Some(Role::Resistance),
        "x" if ohm => Some(Role::Reactance),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_follow_the_words() {
        for (header, wanted) in [
            ("f_Hz", Role::Frequency),
            ("freq", Role::Frequency),
            ("Frequenz f / Hz", Role::Frequency),
            ("Omega", Role::Frequency),
            ("ω (rad/s)", Role::Frequency),
            ("MHz", Role::Frequency),
            ("Frequency Shift (Hz)", Role::Shift),
            ("Center Frequency (Hz)", Role::Centre),
            ("T_s", Role::Period),
            ("Period (ms)", Role::Period),
            ("amp_rad", Role::Amplitude),
            ("A_Skt", Role::Amplitude),
            ("Amplitude (m)", Role::Amplitude),
            ("|Zs|", Role::Amplitude),
            ("S21 (dB)", Role::Amplitude),
            ("X[%]", Role::Amplitude),
            ("phase_deg", Role::Phase),
            ("phi[deg]", Role::Phase),
            ("Phase (rad)", Role::Phase),
            ("<Zs", Role::Phase),
            ("Re(X)", Role::Real),
            ("Im (V)", Role::Imaginary),
            ("drive_V", Role::Drive),
            ("drive_amp", Role::Drive),
            ("Excitation (V)", Role::Drive),
            ("sigma_A", Role::StdError),
            ("amp err", Role::StdError),
            ("Gp", Role::Conductance),
            ("Bp", Role::Susceptance),
            ("Rs", Role::Resistance),
            ("Xs (Ω)", Role::Reactance),
            ("resid_rms_rad", Role::Never),
            ("FFT fft / rad", Role::Never),
            ("n_outliers", Role::Never),
            ("source", Role::Never),
            ("Zeit t / s", Role::Time),
            ("Weg", Role::Unknown),
            ("", Role::Unknown),
        ] {
            assert_eq!(role(&Name::parse(header)), wanted, "{header}");
        }
    }

    #[test]
    fn units_of_frequency_are_known_by_many_spellings() {
        assert_eq!(to_hz("mHz"), Some(1e-3));
        assert_eq!(to_hz("MHz"), Some(1e6));
        assert_eq!(to_hz("kHz"), Some(1e3));
        assert_eq!(to_hz("rad / s"), Some(1.0 / std::f64::consts::TAU));
        assert_eq!(to_hz("rpm"), Some(1.0 / 60.0));
        assert_eq!(to_hz("horse"), None);
    }
}

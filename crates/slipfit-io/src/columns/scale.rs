//! Conversion of the numbers of a column to amplitudes.

use std::f64::consts::SQRT_2;

use super::{
    name::words,
    units::{self, listed},
};

/// How an amplitude is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scale {
    Linear,
    /// Another measure of an oscillation, such as peak to peak; the factor converts it to an amplitude.
    Times(f64),
    /// `10^(x/20)`.
    Decibel,
    /// The square of an amplitude.
    Power,
}

impl Scale {
    pub(crate) fn linear(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Times(factor) => value * factor,
            Self::Decibel => units::from_decibels(value),
            Self::Power => value.sqrt(),
        }
    }

    /// Standard error of an amplitude in `unit`, given the standard error of its written value, in `error_unit`.
    ///
    /// For decibels and squares the error may also be written in the unit of the amplitude.
    pub(crate) fn error(self, error: f64, error_unit: &str, amplitude: f64, unit: &str) -> f64 {
        let same_kind = |is_other: bool| error_unit.trim().is_empty() || is_other;
        match self {
            Self::Times(factor) if same_kind(error_unit.trim() == unit.trim()) => error * factor,
            Self::Decibel if same_kind(units::linear_unit(error_unit).is_some()) => {
                error * amplitude * std::f64::consts::LN_10 / 20.0
            }
            Self::Power if same_kind(units::root_of_square(error_unit).is_some()) => {
                of_root(error, amplitude, 1.0)
            }
            _ => error * units::ratio(error_unit.trim(), unit.trim()).unwrap_or(1.0),
        }
    }

    /// Factor to amplitudes, if there is one.
    pub(crate) fn factor(self) -> Option<f64> {
        match self {
            Self::Linear => Some(1.0),
            Self::Times(factor) => Some(factor),
            Self::Decibel | Self::Power => None,
        }
    }
}

/// Standard error of `root = sqrt(times value)`, given that of the value; near zero, that of a value as large as its
/// error.
pub(super) fn of_root(error: f64, root: f64, times: f64) -> f64 {
    0.5 * times * error / root.max((times * error).sqrt())
}

/// How numbers are written, according to their unit, or to their name if no unit is given.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Written {
    pub(super) scale: Scale,
    /// The unit of the amplitudes.
    pub(super) unit: String,
    /// Description of the conversion, if any.
    pub(super) done: Option<String>,
}

/// How amplitudes are written: by their unit and, if no other unit was requested, by the name of their column.
pub(super) fn written(unit: &str, name: Option<&str>) -> Written {
    let linear = || Written { scale: Scale::Linear, unit: unit.to_owned(), done: None };
    if let Some(linear) = units::linear_unit(unit) {
        return levels(unit, linear);
    }
    if let Some(root) = units::root_of_density(unit) {
        let done = format!(
            "a power spectral density: its square root was taken, in {root}, as for the response to a \
             drive of equal strength at all frequencies"
        );
        return Written { scale: Scale::Power, unit: root, done: Some(done) };
    }
    if let Some(root) = units::root_of_square(unit) {
        return power("a power", root);
    }
    if let Some((base, factor)) = units::multiple(unit) {
        return times(factor, base);
    }
    let Some(name) = name else { return linear() };
    let lower = name.to_lowercase();
    // `db:Trc1_S21`, `dB(S21)`.
    let decibels = words(name).first().is_some_and(|first| matches!(first.as_str(), "db" | "dbm"));
    if decibels && units::measures(unit).is_none() {
        return levels("dB", "");
    }
    if is_square(&lower) {
        let root = if unit.is_empty() { String::new() } else { format!("\u{221a}{unit}") };
        return power("named like the square of an amplitude", root);
    }
    if unit.is_empty() || is_arbitrary(unit) {
        if words(name).iter().any(|word| listed(POWERS, word)) {
            return power("named like a power", String::new());
        }
        if words(name).iter().any(|word| word == "psd") {
            let done = "named like a power spectral density: its square root was taken".to_owned();
            return Written { scale: Scale::Power, unit: String::new(), done: Some(done) };
        }
    }
    let of_name = ["peak to peak", "peak-to-peak", "peak2peak", "pk-pk", "p-p", "spitze-spitze"];
    let peak_to_peak = of_name.iter().any(|part| lower.contains(part))
        || words(name).iter().any(|word| matches!(word.as_str(), "pp" | "vpp" | "upp" | "ptp" | "pkpk"));
    let effective = words(name)
        .iter()
        .any(|word| matches!(word.as_str(), "rms" | "vrms" | "urms" | "eff" | "ueff" | "effektivwert"));
    match (peak_to_peak, effective) {
        (true, _) => times(0.5, unit),
        (false, true) => times(SQRT_2, unit),
        (false, false) => linear(),
    }
}

/// Names of powers.
const POWERS: &str = "power leistung puissance potenza potencia";

/// Names of quantities that may be powers or amplitudes.
const EITHER: &str = "power leistung puissance potenza potencia intensity intensit\u{e4}t intensit\u{e9} intensit\u{e0} \
    intensidad";

/// Whether a name may denote a power that neither its unit nor a square in its name identifies.
pub(super) fn may_be_power(unit: &str, name: &str) -> bool {
    let said = units::linear_unit(unit).is_some() || written(unit, Some(name)).scale != Scale::Linear;
    !said && words(name).iter().any(|word| listed(EITHER, word))
}

/// Whether a name in lower case denotes a square: `|a|^2`, `x\u{b2}`, `amplitude squared`.
fn is_square(lower: &str) -> bool {
    let lower = lower.trim();
    let ends = ["^2", "\u{b2}", "**2", "squared", "quadrat"];
    ends.iter().any(|end| lower.strip_suffix(end).is_some_and(|base| !base.is_empty()))
}

/// Whether a unit is arbitrary.
fn is_arbitrary(unit: &str) -> bool {
    listed("a.u. a.u au arb arb. arb.u. arb.units %", &unit.trim().to_lowercase())
}

fn power(what: &str, root: String) -> Written {
    let done = Some(format!("{what}: its square root was taken"));
    Written { scale: Scale::Power, unit: root, done }
}

fn levels(written: &str, linear: &str) -> Written {
    let done = Some(format!("levels in {written} were converted to linear values, 10^(x/20)"));
    Written { scale: Scale::Decibel, unit: linear.to_owned(), done }
}

/// Numbers that differ from amplitudes by a factor.
fn times(factor: f64, unit: &str) -> Written {
    let (scale, what) = if factor == 1.0 {
        return Written { scale: Scale::Linear, unit: unit.to_owned(), done: None };
    } else if factor < 1.0 {
        (Scale::Times(factor), "peak to peak: halved to amplitudes")
    } else {
        (Scale::Times(factor), "effective values: multiplied by the square root of 2 to amplitudes")
    };
    let of = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
    Written { scale, unit: unit.to_owned(), done: Some(format!("{what}{of}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_say_how_amplitudes_are_written() {
        for (unit, name, scale, of_amplitudes) in [
            ("mVpp", "amplitude", Scale::Times(0.5), "mV"),
            ("mV", "Vpp", Scale::Times(0.5), "mV"),
            ("mm", "Peak-to-peak", Scale::Times(0.5), "mm"),
            ("g", "RMS acceleration", Scale::Times(SQRT_2), "g"),
            ("nm^2/Hz", "PSD", Scale::Power, "nm/\u{221a}Hz"),
            ("", "psd_x", Scale::Power, ""),
            ("", "dB", Scale::Decibel, ""),
            ("", "db:Trc1_S21", Scale::Decibel, ""),
            ("S21", "dB", Scale::Decibel, ""),
            ("", "|A|^2", Scale::Power, ""),
            ("V^2", "X\u{b2}", Scale::Power, "V"),
            ("nm^2", "A", Scale::Power, "nm"),
            ("", "R squared", Scale::Power, ""),
            ("a.u.", "Power", Scale::Power, ""),
            ("mW", "Power", Scale::Power, "\u{221a}mW"),
            ("V", "Power", Scale::Linear, "V"),
            ("", "intensity", Scale::Linear, ""),
            ("m/s^2", "A", Scale::Linear, "m/s^2"),
            ("dBm", "S21", Scale::Decibel, "\u{221a}mW"),
            ("nm/\u{221a}Hz", "ASD", Scale::Linear, "nm/\u{221a}Hz"),
            ("mm", "stopped", Scale::Linear, "mm"),
        ] {
            let found = written(unit, Some(name));
            assert_eq!((found.scale, found.unit.as_str()), (scale, of_amplitudes), "{name} ({unit})");
            assert_eq!(found.done.is_some(), scale != Scale::Linear, "{name} ({unit})");
        }
        for (unit, name, may_be) in [
            ("V", "Power", true),
            ("", "intensity", true),
            ("a.u.", "Intensity", true),
            ("mW", "Power", false),
            ("", "Power", false),
            ("dBm", "Power", false),
            ("V", "Amplitude", false),
        ] {
            assert_eq!(may_be_power(unit, name), may_be, "{name} ({unit})");
        }
        // A requested unit takes precedence over a name.
        assert_eq!(written("mV", None).scale, Scale::Linear);
    }
}

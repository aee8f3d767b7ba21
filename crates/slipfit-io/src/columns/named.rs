//! Information from the values named outside a table.

use super::units::{self, Measures};

/// Values from `name: value` and `name = value` lines, and from a row of names above a row of values.
pub(crate) fn values(lines: impl Iterator<Item = String>) -> Vec<(String, String)> {
    let mut values: Vec<(String, String)> = Vec::new();
    let mut before: Vec<String> = Vec::new();
    for plain in lines {
        let cells: Vec<String> =
            plain.split([',', ';', '\t']).map(|c| c.trim().trim_matches('"').to_owned()).collect();
        let numeric = |c: &String| c.parse::<f64>().is_ok();
        if let Some((name, value)) = plain.split_once([':', '=']) {
            values.push((name.trim().to_owned(), value.trim().to_owned()));
        } else if cells.iter().all(numeric) && before.len() == cells.len() {
            values.extend(before.drain(..).zip(cells.iter().cloned()).filter(|(name, _)| !name.is_empty()));
        } else if cells.len() >= 2
            && (!numeric(&cells[0]) && numeric(&cells[1]) || is_vertical_unit(&cells[0]))
        {
            values.push((cells[0].clone(), cells[1].clone()));
        }
        before = if cells.iter().any(numeric) { Vec::new() } else { cells };
    }
    values
}

/// A value without surrounding separators: `,Volt` of `YUnits:,Volt`.
fn plain(value: &str) -> &str {
    value.trim_matches([',', ';', '\t', ' ', '"'])
}

/// Whether a line names the vertical unit of an oscilloscope: `Vertical Units`.
fn is_vertical_unit(name: &str) -> bool {
    let letters: String = name.to_lowercase().chars().filter(|c| c.is_alphabetic()).collect();
    ["verticalunit", "verticalunits", "yunit", "yunits", "vunit", "vunits"].contains(&letters.as_str())
}

/// A unit of the signal named in the preamble.
pub(super) fn named_unit(values: &[(String, String)]) -> Option<&str> {
    let is_unit =
        |name: &str| ["unit", "einheit", "unità", "unidad"].iter().any(|u| name.to_lowercase().contains(u));
    let signal = |unit: &str| matches!(units::measures(unit), Some(Measures::Signal(_) | Measures::Level(_)));
    let found = values.iter().find(|(name, value)| is_unit(name) && signal(plain(value)));
    found.map(|(_, value)| plain(value))
}

/// A sampling rate (Hz) named in the preamble.
pub(super) fn named_rate_hz(values: &[(String, String)]) -> Option<f64> {
    values.iter().find_map(|(name, value)| {
        let name = name.to_lowercase();
        let rate = [
            "sample_rate",
            "sample rate",
            "sampling rate",
            "samplerate",
            "actualrate",
            "actual rate",
            "actual_rate",
            "scanrate",
            "scan rate",
            "abtastrate",
            "sampling frequency",
            "samplingfrequency",
        ];
        // PicoScope and Keysight oscilloscopes use such names for the step.
        let interval = [
            "sample interval",
            "sampling interval",
            "sample_interval",
            "dt",
            "abtastintervall",
            "tinterval",
            "xinc",
        ];
        let mut parts = value.split_whitespace();
        let number: f64 = parts.next()?.parse().ok()?;
        let unit = parts.next().unwrap_or_default().to_lowercase();
        let short = [
            "fs",
            "fs_hz",
            "f_s",
            "f_sample",
            "fsample",
            "fsamp",
            "samplingrate",
            "rate",
            "rate_hz",
            "sampling_rate",
            "sampling_frequency",
        ];
        let found = if rate.iter().any(|r| name.contains(r)) || short.contains(&name.as_str()) {
            let factor = if unit.starts_with('k') || name.contains("khz") { 1e3 } else { 1.0 };
            number * factor
        } else if interval.iter().any(|r| name == *r || (r.len() > 2 && name.contains(r))) {
            let factor = if unit == "ms" || name.contains("ms") { 1e3 } else { 1.0 };
            factor / number
        } else {
            return None;
        };
        (found > 0.0 && found.is_finite()).then_some(found)
    })
}

//! The calls that give the same answer elsewhere: a command line and a Python call.

use crate::{Analysis, Options};
use serde_json::Value;

/// The command line: `slipfit ringdown swing.csv --band 79 82`.
pub(crate) fn command(analysis: Analysis, file: &str, reference: Option<&str>, options: &Options) -> String {
    let mut words = vec!["slipfit".to_owned(), analysis.name().to_owned(), not_a_flag(file)];
    if let Some(reference) = reference {
        words.extend(["--reference".to_owned(), reference.to_owned()]);
    }
    for (name, value) in options.of(analysis) {
        words.push(flag(name));
        match value {
            Value::Array(pair) if name == "band_hz" => words.extend(pair.iter().map(Value::to_string)),
            Value::Array(pair) => words.push(uncertain(pair)),
            Value::Bool(on) => words.push(if *on { "on" } else { "off" }.to_owned()),
            Value::String(text) => words.push(text.clone()),
            other => words.push(other.to_string()),
        }
    }
    // A word with a zero byte cannot be typed.
    let quoted = |word: &String| shlex::try_quote(word).map(|q| q.into_owned()).unwrap_or_default();
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// The call in Python: `slipfit.read("swing.csv", unit="mm")`, then `slipfit.ringdown(…, band_hz=(79, 82))`.
pub(crate) fn python(analysis: Analysis, file: &str, reference: Option<&str>, options: &Options) -> String {
    let reader = match analysis {
        Analysis::Ringdown => "read",
        Analysis::Resonance => "read_curve",
        Analysis::Levels => "read_levels",
    };
    let spelled = |(name, value): (&str, &Value)| {
        let value = match value {
            Value::Array(pair) => {
                let items: Vec<String> = pair.iter().map(Value::to_string).collect();
                format!("({})", items.join(", "))
            }
            Value::Bool(on) => if *on { "True" } else { "False" }.to_owned(),
            Value::String(word) => text(word),
            other => other.to_string(),
        };
        format!(", {name}={value}")
    };
    let (of_reading, of_analysis): (Vec<_>, Vec<_>) =
        options.of(analysis).partition(|(name, _)| is_of_reading(name));
    let reading: String = of_reading.into_iter().map(spelled).collect();
    let read = |file: &str| format!("slipfit.{reader}({}{reading})", text(file));
    let chosen: String = of_analysis.into_iter().map(spelled).collect();
    let free = reference.map(|free| format!(", reference={}", read(free))).unwrap_or_default();
    format!(
        "import slipfit\n\nmeasured = {}\nprint(slipfit.{}(measured{free}{chosen}))",
        read(file),
        analysis.name()
    )
}

/// Whether an option belongs to the reading of the file.
fn is_of_reading(name: &str) -> bool {
    const OF_ANALYSIS: [&str; 23] = [
        "band_hz",
        "start_s",
        "end_s",
        "min_amplitude",
        "model",
        "law",
        "lockin_time_constant_s",
        "lockin_order",
        "frequency_hz",
        "drive_amplitude",
        "method",
        "background",
        "delay",
        "amplitude_offset",
        "noise_floor",
        "phase_offset",
        "duffing",
        "drive_gain",
        "q_factor",
        "stiffness",
        "mass",
        "torsion_stiffness",
        "inertia",
    ];
    !OF_ANALYSIS.contains(&name)
}

/// The flag of an option; most have the same name.
fn flag(name: &str) -> String {
    match name {
        "band_hz" => "--band",
        "start_s" => "--start",
        "end_s" => "--end",
        "lockin_time_constant_s" => "--lockin-time-constant",
        "q_factor" => "--q",
        "method" => "--response",
        other => return format!("--{}", other.replace('_', "-")),
    }
    .to_owned()
}

/// Prefixes a file name that begins like a flag.
fn not_a_flag(file: &str) -> String {
    if file.starts_with('-') { format!("./{file}") } else { file.to_owned() }
}

fn uncertain(pair: &[Value]) -> String {
    match pair {
        [value, error] if error.as_f64() != Some(0.0) => format!("{value}±{error}"),
        [value, ..] => value.to_string(),
        [] => String::new(),
    }
}

/// A string literal: escapes of JSON mean the same in Python.
fn text(word: &str) -> String {
    Value::from(word).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_in_both_calls() {
        let chosen =
            r#"{"band_hz": [79, 82.5], "stiffness": [12000, 300], "signal": "a \"b\"", "drive": "2"}"#;
        let options = Options::parse(chosen).unwrap();
        assert_eq!(
            command(Analysis::Ringdown, "-my swing.csv", None, &options),
            "slipfit ringdown './-my swing.csv' --band 79 82.5 --signal 'a \"b\"' --stiffness '12000±300'"
        );
        let python = python(Analysis::Ringdown, "a.csv", None, &options);
        assert!(
            python.ends_with(
                "measured = slipfit.read(\"a.csv\", signal=\"a \\\"b\\\"\")\nprint(slipfit.ringdown(measured, band_hz=(79, 82.5), stiffness=(12000, 300)))"
            ),
            "{python}"
        );
    }

    #[test]
    fn switches_and_exact_values_are_spelled_as_the_command_takes_them() {
        let options = Options::parse(r#"{"delay": false, "drive_amplitude": [0.5, 0]}"#).unwrap();
        assert_eq!(
            command(Analysis::Resonance, "a.csv", Some("free.csv"), &options),
            "slipfit resonance a.csv --reference free.csv --delay off --drive-amplitude 0.5"
        );
    }
}

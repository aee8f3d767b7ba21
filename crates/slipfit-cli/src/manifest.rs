//! The manifest of a series: which files, under which conditions, what they share.
//!
//! A measurement takes the flags of its command as keys, `_` for `-`, so that
//! whatever can be typed can be written down.

use crate::args::{Cli, Command, Uncertain};
use crate::failure::Failure;
use clap::Parser;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use slipfit::Calibration;
use slipfit::series::{Condition, Shared};
use std::path::{Path, PathBuf};

/// Keys of a measurement that belong to the series as a whole, and what to say.
const NOT_HERE: &[(&str, &str)] = &[
    ("json", "output is asked for on the command line"),
    ("plot", "output is asked for on the command line"),
    ("csv", "output is asked for on the command line"),
    ("html", "output is asked for on the command line"),
    ("md", "output is asked for on the command line"),
    ("latex", "output is asked for on the command line"),
    ("table", "output is asked for on the command line"),
    ("resume", "output is asked for on the command line"),
    ("force", "output is asked for on the command line"),
    ("strict", "output is asked for on the command line"),
    ("quiet", "output is asked for on the command line"),
    ("color", "output is asked for on the command line"),
    ("stiffness", "one stiffness holds for the series: it stands above the measurements"),
    ("mass", "one mass holds for the series: it stands above the measurements"),
    ("torsion_stiffness", "one stiffness holds for the series: it stands above the measurements"),
    ("inertia", "one inertia holds for the series: it stands above the measurements"),
];

/// The file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    title: Option<String>,
    unit: Option<String>,
    condition: Option<String>,
    condition_unit: Option<String>,
    #[serde(default)]
    shared: Vec<String>,
    stiffness: Option<Number>,
    mass: Option<Number>,
    torsion_stiffness: Option<Number>,
    inertia: Option<Number>,
    #[serde(default)]
    measurement: Vec<Entry>,
}

#[derive(Debug, Deserialize)]
struct Entry {
    name: Option<String>,
    ringdown: Option<PathBuf>,
    sweep: Option<Files>,
    levels: Option<PathBuf>,
    condition: Option<Number>,
    value: Option<Number>,
    scale: Option<f64>,
    #[serde(flatten)]
    flags: toml::Table,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Files {
    One(PathBuf),
    Several(Vec<PathBuf>),
}

/// A number, alone or as text with its uncertainty.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum Number {
    Plain(f64),
    Text(String),
}

/// What a manifest asks for.
#[derive(Debug)]
pub(crate) struct Manifest {
    /// Of the file's bytes, in hexadecimal.
    pub(crate) sha256: String,
    pub(crate) title: String,
    /// Unit of displacements in the table, if it is given.
    pub(crate) unit: Option<String>,
    /// What the condition is, such as `load`.
    pub(crate) condition: String,
    pub(crate) condition_unit: String,
    pub(crate) shared: Shared,
    pub(crate) calibration: Option<Calibration>,
    /// Whether the constant is one of a torsion pendulum.
    pub(crate) angular: bool,
    pub(crate) entries: Vec<Asked>,
}

impl Manifest {
    /// Every file it names.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.entries.iter().flat_map(|entry| -> Vec<&Path> {
            match &entry.command {
                Command::Ringdown(args) => args.inputs().collect(),
                Command::Resonance(args) => args.inputs().collect(),
                Command::Levels(args) => vec![&args.file],
                _ => Vec::new(),
            }
        })
    }
}

/// One measurement: its command as if it had been typed.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) name: String,
    pub(crate) condition: Condition,
    pub(crate) scale: Option<f64>,
    pub(crate) command: Command,
}

/// Reads a manifest; its paths are relative to its own folder.
pub(crate) fn read(path: &Path) -> Result<Manifest, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let manifest = parse(&text, folder).map_err(|said| {
        Failure::new(format!("{}: {said}", path.display())).hint("https://github.com/slipfit/slipfit/blob/main/docs/series.md and slipfit help series say what a manifest holds")
    })?;
    let digest = Sha256::digest(text.as_bytes());
    Ok(Manifest { sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(), ..manifest })
}

fn parse(text: &str, folder: &Path) -> Result<Manifest, String> {
    let written: Written = toml::from_str(text).map_err(|e| e.to_string().trim_end().to_owned())?;
    if written.measurement.is_empty() {
        return Err("no [[measurement]] stands in it".to_owned());
    }
    let condition_unit = written.condition_unit.clone().unwrap_or_default();
    let (calibration, angular) = calibration(&written)?;
    let mut entries = Vec::with_capacity(written.measurement.len());
    for (i, entry) in written.measurement.iter().enumerate() {
        let named = || match &entry.name {
            Some(name) => format!("measurement {} `{name}`", i + 1),
            None => format!("measurement {}", i + 1),
        };
        entries.push(asked(entry, folder, &condition_unit).map_err(|said| format!("{}: {said}", named()))?);
    }
    // Two measurements of one name could not be told apart.
    for i in 0..entries.len() {
        let same = entries[..i].iter().filter(|e| e.name == entries[i].name).count();
        if same > 0 {
            entries[i].name = format!("{} ({})", entries[i].name, same + 1);
        }
    }
    Ok(Manifest {
        sha256: String::new(),
        title: written.title.unwrap_or_default(),
        unit: written.unit,
        condition: written.condition.unwrap_or_else(|| "condition".to_owned()),
        condition_unit,
        shared: shared(&written.shared)?,
        calibration,
        angular,
        entries,
    })
}

fn calibration(written: &Written) -> Result<(Option<Calibration>, bool), String> {
    let given: Vec<(&str, &Number)> = [
        ("stiffness", &written.stiffness),
        ("mass", &written.mass),
        ("torsion_stiffness", &written.torsion_stiffness),
        ("inertia", &written.inertia),
    ]
    .into_iter()
    .filter_map(|(name, number)| number.as_ref().map(|n| (name, n)))
    .collect();
    match given[..] {
        [] => Ok((None, false)),
        [(name, number)] => {
            let u = number.above_zero().map_err(|e| format!("{name}: {e}"))?;
            let (value, std_error) = (u.value, u.std_error);
            let stiff = name.ends_with("stiffness");
            let constant = if stiff {
                Calibration::Stiffness { value, std_error }
            } else {
                Calibration::Mass { value, std_error }
            };
            Ok((Some(constant), matches!(name, "torsion_stiffness" | "inertia")))
        }
        [(a, _), (b, _), ..] => Err(format!("{a} and {b} are both given: one of them calibrates the forces")),
    }
}

fn shared(names: &[String]) -> Result<Shared, String> {
    let mut shared = Shared::default();
    for name in names {
        match name.as_str() {
            "natural_frequency" | "natural_frequency_hz" => shared.natural_frequency = true,
            "drive_amplitude" => shared.drive_amplitude = true,
            "decay_rate" | "decay_rate_per_s" => shared.decay_rate = true,
            "stiffness" | "mass" | "torsion_stiffness" | "inertia" => {
                return Err(format!("shared: {name} is shared by standing above the measurements"));
            }
            other => {
                return Err(format!(
                    "shared: `{other}` cannot be shared; natural_frequency, drive_amplitude and decay_rate can"
                ));
            }
        }
    }
    Ok(shared)
}

fn asked(entry: &Entry, folder: &Path, unit: &str) -> Result<Asked, String> {
    let at = |p: &PathBuf| folder.join(p);
    let (word, files): (&str, Vec<PathBuf>) = match (&entry.ringdown, &entry.sweep, &entry.levels) {
        (Some(file), None, None) => ("ringdown", vec![at(file)]),
        (None, Some(Files::One(file)), None) => ("resonance", vec![at(file)]),
        (None, Some(Files::Several(files)), None) => ("resonance", files.iter().map(at).collect()),
        (None, None, Some(file)) => ("levels", vec![at(file)]),
        (None, None, None) => return Err("one of ringdown, sweep and levels names its file".to_owned()),
        _ => return Err("ringdown, sweep and levels exclude each other".to_owned()),
    };
    let name = match &entry.name {
        Some(name) => name.clone(),
        None => files
            .first()
            .and_then(|f| f.file_name())
            .map_or_else(|| word.to_owned(), |n| n.to_string_lossy().into_owned()),
    };
    if let Some(scale) = entry.scale.filter(|s| !(s.is_finite() && *s > 0.0)) {
        return Err(format!("scale = {scale}: must be above zero"));
    }
    let mut line: Vec<std::ffi::OsString> = vec!["slipfit".into(), word.into()];
    line.extend(files.into_iter().map(Into::into));
    for (key, value) in &entry.flags {
        if let Some((_, why)) = NOT_HERE.iter().find(|(k, _)| k == key) {
            return Err(format!("{key}: {why}"));
        }
        line.extend(flag(key, value, folder)?.into_iter().map(Into::into));
    }
    let command = Cli::try_parse_from(line).map_err(|e| complaint(&e))?.command;
    Ok(Asked { name, condition: condition(entry, unit)?, scale: entry.scale, command })
}

/// A key and its value as they would be typed.
fn flag(key: &str, value: &toml::Value, folder: &Path) -> Result<Vec<String>, String> {
    let text = |value: &toml::Value| match value {
        toml::Value::String(s) if key == "reference" => Ok(folder.join(s).display().to_string()),
        toml::Value::String(s) => Ok(s.clone()),
        toml::Value::Integer(i) => Ok(i.to_string()),
        toml::Value::Float(f) => Ok(f.to_string()),
        other => Err(format!("{key}: a {} cannot stand here", other.type_str())),
    };
    let name = format!("--{}", key.replace('_', "-"));
    match value {
        toml::Value::Boolean(true) => Ok(vec![name]),
        toml::Value::Boolean(false) => Ok(Vec::new()),
        // `model` is given once for each of its values, a pair of frequencies at once.
        toml::Value::Array(list) if key == "model" => {
            let texts: Vec<String> = list.iter().map(text).collect::<Result<_, _>>()?;
            Ok(texts.into_iter().flat_map(|t| [name.clone(), t]).collect())
        }
        toml::Value::Array(list) => {
            let mut words = vec![name];
            for item in list {
                words.push(text(item)?);
            }
            Ok(words)
        }
        // A value that begins with a sign is no flag.
        single => Ok(vec![format!("{name}={}", text(single)?)]),
    }
}

/// What clap says, without its advice for the command line.
fn complaint(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let first = text.lines().next().unwrap_or_default();
    first.trim_start_matches("error:").trim().to_owned()
}

fn condition(entry: &Entry, unit: &str) -> Result<Condition, String> {
    let beside = |text: &str| if unit.is_empty() { text.to_owned() } else { format!("{text} {unit}") };
    let (label, own) = match &entry.condition {
        None => (String::new(), None),
        Some(Number::Plain(value)) => (beside(&value.to_string()), Some([*value, 0.0])),
        Some(Number::Text(text)) => {
            let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != ')' && c != '%');
            (text.clone(), pair(number).ok())
        }
    };
    let value = match &entry.value {
        Some(Number::Plain(value)) => Some([*value, 0.0]),
        Some(Number::Text(text)) => Some(pair(text).map_err(|e| format!("value: {e}"))?),
        None => own,
    };
    let label = if label.is_empty() {
        value.map_or_else(|| "(none)".to_owned(), |v| beside(&v[0].to_string()))
    } else {
        label
    };
    if let Some([value, _]) = value.filter(|v| !v[0].is_finite()) {
        return Err(format!("value = {value}: must be a finite number"));
    }
    Ok(Condition { label, value })
}

/// A value of any sign with its standard error.
fn pair(text: &str) -> Result<[f64; 2], String> {
    if let Ok(value) = text.trim().parse::<f64>() {
        return Ok([value, 0.0]);
    }
    let negative = text.trim().starts_with('-');
    let u: Uncertain = text.trim().trim_start_matches('-').parse()?;
    Ok([if negative { -u.value } else { u.value }, u.std_error])
}

impl Number {
    fn above_zero(&self) -> Result<Uncertain, String> {
        match self {
            Self::Plain(value) => value.to_string().parse(),
            Self::Text(text) => text.parse(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Manifest, String> {
        parse(text, Path::new("data"))
    }

    #[test]
    fn a_manifest_is_read() {
        let m = read(
            r#"
            title = "Pohl wheel"
            condition = "brake current"
            condition_unit = "mA"
            shared = ["natural_frequency", "drive_amplitude"]
            torsion_stiffness = "0.02±0.001"
            [[measurement]]
            ringdown = "a.csv"
            condition = 400
            start = 1.5
            band = [0.3, 0.9]
            model = "viscous+sliding"
            [[measurement]]
            name = "swept"
            sweep = ["b.csv", "c.csv"]
            condition = "0.4(1) A"
            reference = "free.csv"
            model = ["paper", "viscous"]
            [[measurement]]
            levels = "d.csv"
            condition = "wet"
            value = "-2±0.5"
            scale = 1e-3
            "#,
        )
        .unwrap();
        assert!(m.angular && m.shared.natural_frequency && !m.shared.decay_rate);
        assert_eq!(m.entries[0].condition, Condition { label: "400 mA".into(), value: Some([400.0, 0.0]) });
        let Command::Ringdown(args) = &m.entries[0].command else { panic!() };
        assert_eq!(args.files, [Path::new("data/a.csv")]);
        assert_eq!((args.options().start_s, args.options().band_hz), (Some(1.5), Some([0.3, 0.9])));
        assert_eq!((m.entries[0].name.as_str(), m.entries[1].name.as_str()), ("a.csv", "swept"));
        let Command::Resonance(args) = &m.entries[1].command else { panic!() };
        assert_eq!(args.files.len(), 2);
        assert_eq!(args.reference.as_deref(), Some(Path::new("data/free.csv")));
        assert_eq!(args.options().method, slipfit::resonance::Method::Paper);
        assert_eq!(m.entries[1].condition.value, Some([0.4, 0.1]));
        assert_eq!(m.entries[2].condition, Condition { label: "wet".into(), value: Some([-2.0, 0.5]) });
        assert_eq!(m.entries[2].scale, Some(1e-3));
    }

    #[test]
    fn what_cannot_be_meant_is_said() {
        for (text, word) in [
            ("", "no [[measurement]]"),
            ("stifness = 3\n", "stifness"),
            ("[[measurement]]\ncondition = 1\n", "one of ringdown, sweep and levels"),
            ("[[measurement]]\nringdown = 'a'\nsweep = 'b'\n", "exclude"),
            ("[[measurement]]\nringdown = 'a'\nbamd = [1, 2]\n", "--bamd"),
            ("[[measurement]]\nringdown = 'a'\nstart = 'soon'\n", "soon"),
            ("[[measurement]]\nringdown = 'a'\nplot = 'x.svg'\n", "command line"),
            ("[[measurement]]\nringdown = 'a'\nmass = 3\n", "above the measurements"),
            ("mass = 1\nstiffness = 2\n[[measurement]]\nringdown = 'a'\n", "both given"),
            ("mass = -1\n[[measurement]]\nringdown = 'a'\n", "above zero"),
            ("shared = ['colour']\n[[measurement]]\nringdown = 'a'\n", "`colour` cannot be shared"),
            ("[[measurement]]\nringdown = 'a'\nscale = -1\n", "scale"),
            ("[[measurement\n", "TOML"),
        ] {
            let said = read(text).unwrap_err();
            assert!(said.contains(word), "{text}: {said}");
        }
    }
}

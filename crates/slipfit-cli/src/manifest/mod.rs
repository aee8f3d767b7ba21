//! The manifest of a series: which files, under which conditions, and what they share.
//!
//! A measurement takes the options of its command as keys, with `_` for `-`: the same structures are filled from
//! both.

mod condition;
mod keys;
#[cfg(test)]
mod tests;

use crate::args::{
    CurveArgs, LevelAnalysisArgs, LevelReadingArgs, ReadingArgs, ResonanceAnalysisArgs, RingdownAnalysisArgs,
    Uncertain,
};
use crate::failure::Failure;
use condition::{Number, Written, condition, in_one_unit};
use keys::{Keys, Problem};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use slipfit::Calibration;
use slipfit::model::displacement::Coordinate;
use slipfit::series::{Condition, Shared};
use slipfit::{levels, resonance, ringdown};
use slipfit_io::ReadOptions;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of a measurement that belong elsewhere, and where.
const ELSEWHERE: &[(&[&str], &str)] = &[
    (
        &[
            "json", "html", "md", "latex", "csv", "plot", "table", "resume", "force", "strict", "quiet",
            "color",
        ],
        "output is asked for on the command line",
    ),
    (
        &["stiffness", "mass", "torsion_stiffness", "inertia"],
        "one constant holds for the series: it stands above the measurements",
    ),
];

/// Options of one measurement that exclude each other.
const EXCLUSIVE: [[&str; 2]; 5] = [
    ["real", "amplitude"],
    ["real", "phase"],
    ["imaginary", "amplitude"],
    ["imaginary", "phase"],
    ["drive_gain", "q"],
];

/// The keys above the measurements.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Heading {
    title: String,
    unit: Option<String>,
    condition: Option<String>,
    condition_unit: String,
    shared: Vec<String>,
    stiffness: Option<Uncertain>,
    mass: Option<Uncertain>,
    torsion_stiffness: Option<Uncertain>,
    inertia: Option<Uncertain>,
}

/// The keys of every measurement.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct EntryKeys {
    name: Option<String>,
    ringdown: Option<PathBuf>,
    sweep: Option<Files>,
    levels: Option<PathBuf>,
    condition: Option<Number>,
    value: Option<Number>,
    scale: Option<f64>,
}

/// A friction-free reference of a sweep.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Reference {
    reference: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Files {
    One(PathBuf),
    Several(Vec<PathBuf>),
}

/// Contents of a manifest.
#[derive(Debug)]
pub(crate) struct Manifest {
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub(crate) sha256: String,
    pub(crate) title: String,
    /// Unit of displacements in the table, if it is given.
    pub(crate) unit: Option<String>,
    /// What the condition is, such as `load`.
    pub(crate) condition: String,
    pub(crate) condition_unit: String,
    pub(crate) shared: Shared,
    /// One constant for all measurements, and the kind of coordinate it applies to.
    pub(crate) calibration: Option<(Calibration, Coordinate)>,
    pub(crate) entries: Vec<Entry>,
}

/// One measurement.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) name: String,
    pub(crate) condition: Condition,
    pub(crate) scale: Option<f64>,
    pub(crate) source: Source,
    /// Notes on the options of the measurement.
    pub(crate) notes: Vec<String>,
}

/// Where the data of a measurement are and how they are analysed.
#[derive(Debug)]
pub(crate) enum Source {
    Ringdown {
        file: PathBuf,
        reading: ReadOptions,
        options: ringdown::Options,
    },
    Sweep {
        files: Vec<PathBuf>,
        reference: Option<PathBuf>,
        reading: Box<ReadOptions>,
        options: Box<resonance::Options>,
        /// The unit of their drive amplitude, if it is not that of the response.
        drive_unit: Option<String>,
    },
    Levels {
        file: PathBuf,
        reading: ReadOptions,
        options: levels::Options,
    },
}

impl Manifest {
    /// All files it names.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.entries.iter().flat_map(|entry| match &entry.source {
            Source::Ringdown { file, .. } | Source::Levels { file, .. } => vec![file.as_path()],
            Source::Sweep { files, reference, .. } => {
                files.iter().chain(reference).map(PathBuf::as_path).collect()
            }
        })
    }
}

/// Reads a manifest; its paths are relative to its own folder.
pub(crate) fn read(path: &Path) -> Result<Manifest, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let manifest = parse(&text, folder).map_err(|problem| {
        Failure::new(format!("{}: {}", path.display(), problem.in_text(&text))).hint("https://github.com/slipfit/slipfit/blob/main/docs/series.md and slipfit help series describe the manifest")
    })?;
    let digest = Sha256::digest(text.as_bytes());
    Ok(Manifest { sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(), ..manifest })
}

fn parse(text: &str, folder: &Path) -> Result<Manifest, Problem> {
    let mut table = DeTable::parse(text).map_err(|e| Problem::from_toml(&e))?;
    let written = table.get_mut().remove("measurement");
    let mut keys = Keys::new(table);
    let heading: Heading = keys.take()?;
    keys.know(&["measurement"]);
    keys.finish(&[])?;
    let (mut entries, mut conditions, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (i, keys) in measurements(written)?.into_iter().enumerate() {
        places.push(keys.at);
        let (entry, condition) = entry(keys, i + 1, folder, &heading.condition_unit)?;
        entries.push(entry);
        conditions.push(condition);
    }
    let at = |(i, message): (usize, String)| {
        Problem::new(message, places[i]).within(&format!("measurement {}", i + 1))
    };
    let condition_unit = in_one_unit(&mut conditions, &heading.condition_unit).map_err(at)?;
    for i in 0..entries.len() {
        let condition = &conditions[i].condition;
        let same = |other: &&Written| {
            other.condition.label == condition.label && other.condition.value != condition.value
        };
        if conditions[..i].iter().any(|other| same(&other)) {
            let problem = format!(
                "condition {:?} has another value above: one label is one condition",
                condition.label
            );
            return Err(at((i, problem)));
        }
        entries[i].condition = condition.clone();
    }
    // Two measurements of the same name could not be distinguished.
    for i in 0..entries.len() {
        let same = entries[..i].iter().filter(|e| e.name == entries[i].name).count();
        if same > 0 {
            entries[i].name = format!("{} ({})", entries[i].name, same + 1);
        }
    }
    Ok(Manifest {
        sha256: String::new(),
        shared: shared(&heading.shared).map_err(|e| Problem::new(e, 0))?,
        calibration: calibration(&heading).map_err(|e| Problem::new(e, 0))?,
        title: heading.title,
        unit: heading.unit,
        condition: heading.condition.unwrap_or_else(|| "condition".to_owned()),
        condition_unit,
        entries,
    })
}

/// The tables `[[measurement]]`.
fn measurements(written: Option<Spanned<DeValue<'_>>>) -> Result<Vec<Keys<'_>>, Problem> {
    let Some(written) = written else { return Err(Problem::new("it contains no [[measurement]]", 0)) };
    let at = written.span().start;
    let wrong = |at| Problem::new("measurement: a table for each, [[measurement]]", at);
    let DeValue::Array(list) = written.into_inner() else { return Err(wrong(at)) };
    let each = list.into_iter().map(|value| {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Ok(Keys::new(Spanned::new(span, table))),
            _ => Err(wrong(span.start)),
        }
    });
    each.collect()
}

fn calibration(heading: &Heading) -> Result<Option<(Calibration, Coordinate)>, String> {
    use Coordinate::{Angle, Length};
    let given: Vec<_> = [
        ("stiffness", heading.stiffness, Length),
        ("mass", heading.mass, Length),
        ("torsion_stiffness", heading.torsion_stiffness, Angle),
        ("inertia", heading.inertia, Angle),
    ]
    .into_iter()
    .filter_map(|(name, number, coordinate)| Some((name, number?, coordinate)))
    .collect();
    match given[..] {
        [] => Ok(None),
        [(name, Uncertain { value, std_error }, coordinate)] => {
            let constant = if name.ends_with("stiffness") {
                Calibration::Stiffness { value, std_error }
            } else {
                Calibration::Mass { value, std_error }
            };
            Ok(Some((constant, coordinate)))
        }
        [(a, ..), (b, ..), ..] => {
            Err(format!("{a} and {b} are both given: one of them calibrates the forces"))
        }
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

fn entry(mut keys: Keys<'_>, number: usize, folder: &Path, unit: &str) -> Result<(Entry, Written), Problem> {
    let start = keys.at;
    let entry: EntryKeys = keys.take()?;
    let heading = match &entry.name {
        Some(name) => format!("measurement {number} `{name}`"),
        None => format!("measurement {number}"),
    };
    let within = |problem: Problem| problem.within(&heading);
    let here = |message: String| Problem::new(message, start).within(&heading);
    for [one, other] in EXCLUSIVE {
        if keys.has(one) && keys.has(other) {
            return Err(here(format!("{one} and {other} exclude each other")));
        }
    }
    let mut notes = Vec::new();
    let (word, source) = match (&entry.ringdown, &entry.sweep, &entry.levels) {
        (Some(file), None, None) => {
            let reading = keys.take::<ReadingArgs>().map_err(within)?.options();
            let options = keys.take::<RingdownAnalysisArgs>().map_err(within)?.options();
            ("ringdown", Source::Ringdown { file: folder.join(file), reading, options })
        }
        (None, Some(files), None) => {
            let files = match files {
                Files::One(file) => vec![folder.join(file)],
                Files::Several(files) => files.iter().map(|file| folder.join(file)).collect(),
            };
            let reading = Box::new(keys.take::<CurveArgs>().map_err(within)?.options());
            let analysis = keys.take::<ResonanceAnalysisArgs>().map_err(within)?;
            let reference = keys.take::<Reference>().map_err(within)?.reference.map(|file| folder.join(file));
            notes.extend(analysis.old_spelling());
            let (options, drive_unit) = (Box::new(analysis.options()), analysis.drive_unit());
            ("resonance", Source::Sweep { files, reference, reading, options, drive_unit })
        }
        (None, None, Some(file)) => {
            let reading = keys.take::<LevelReadingArgs>().map_err(within)?.options();
            let options = keys.take::<LevelAnalysisArgs>().map_err(within)?.options();
            ("levels", Source::Levels { file: folder.join(file), reading, options })
        }
        (None, None, None) => {
            let meant = keys.meant(&["ringdown", "sweep", "levels"]);
            let meant = meant.map(|(key, meant)| format!("`{key}`: did you mean `{meant}`?"));
            let named = || keys.names_file().map(|key| format!("`{key}` does not say of what the file is"));
            let said = meant.or_else(named).map(|said| format!("; {said}")).unwrap_or_default();
            return Err(here(format!(
                "the file is missing: give one of the keys ringdown, sweep or levels{said}"
            )));
        }
        _ => return Err(here("ringdown, sweep and levels exclude each other".to_owned())),
    };
    keys.finish(ELSEWHERE).map_err(within)?;
    if let Some(scale) = entry.scale.filter(|s| !(s.is_finite() && *s > 0.0)) {
        return Err(here(format!("scale = {scale}: must be above zero")));
    }
    let written = condition(entry.condition.as_ref(), entry.value.as_ref(), unit).map_err(here)?;
    let condition = written.condition.clone();
    let file = match &source {
        Source::Ringdown { file, .. } | Source::Levels { file, .. } => Some(file),
        Source::Sweep { files, .. } => files.first(),
    };
    let file = file.and_then(|f| f.file_name()).map(|n| n.to_string_lossy().into_owned());
    let name = entry.name.or(file).unwrap_or_else(|| word.to_owned());
    Ok((Entry { name, condition, scale: entry.scale, source, notes }, written))
}

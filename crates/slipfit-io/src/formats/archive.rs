//! ZIP archives: NPZ, phyphox, Tracker's `.trz`, or texts packed together.

use std::io::Cursor;

use super::{npy, tracker};
use crate::tables::unpack::{Archive, unpack};
use crate::{
    columns::named,
    error::ReadProblem,
    format::Format,
    tables::{
        arrays::{self, NamedValues},
        table::LoadedTables,
        text,
    },
};

/// Content of the member `mimetype` of a LibreOffice spreadsheet.
const ODS: &[u8] = b"application/vnd.oasis.opendocument.spreadsheet";
/// Maximum number of members examined.
const MOST_MEMBERS: usize = 1000;

/// Reads an archive of any of these kinds; only the first `most_cells` cells of each sheet of a workbook.
#[cfg_attr(not(feature = "excel"), expect(unused_variables, reason = "only workbooks have sheets"))]
pub(crate) fn tables(bytes: Vec<u8>, most_cells: usize) -> Result<(LoadedTables, Format), ReadProblem> {
    let mut archive = Archive::new(Cursor::new(bytes)).map_err(|e| Format::Zip.broken(e))?;
    let mut names: Vec<String> =
        archive.file_names().take(MOST_MEMBERS).flatten().map(|n| n.into_owned()).collect();
    names.sort_unstable();
    let ends = |name: &str, with: &str| name.to_ascii_lowercase().ends_with(with);
    if names.iter().any(|n| n == "xl/workbook.xml") {
        #[cfg(feature = "excel")]
        return Ok((super::xlsx::tables(&mut archive, most_cells)?, Format::Xlsx));
        #[cfg(not(feature = "excel"))]
        return Err(ReadProblem::Unsupported(Format::Xlsx));
    }
    if member(&mut archive, "mimetype").is_ok_and(|m| m.starts_with(ODS)) {
        #[cfg(feature = "excel")]
        return Ok((super::ods::tables(&mut archive, most_cells)?, Format::Ods));
        #[cfg(not(feature = "excel"))]
        return Err(ReadProblem::Unsupported(Format::Ods));
    }
    if names.iter().any(|n| ends(n, ".npy")) {
        return Ok((npz(&mut archive, &names)?, Format::Npz));
    }
    let holds = |wanted: &str| names.iter().any(|name| name == wanted);
    if holds("header.properties") {
        return Err(ReadProblem::Unsupported(Format::Jpk));
    }
    if holds("version") && holds("metadata") {
        return Err(ReadProblem::Unsupported(Format::Sigrok));
    }
    if let Some(name) = names.iter().find(|n| ends(n, ".trk")) {
        let track = member(&mut archive, name)?;
        return Ok((tracker::tables(&track)?, Format::Tracker));
    }
    let texts: Vec<&String> =
        names.iter().filter(|n| [".csv", ".txt", ".tsv", ".dat"].iter().any(|e| ends(n, e))).collect();
    if texts.is_empty() {
        let first: Vec<&str> = names.iter().take(6).map(String::as_str).collect();
        return Err(Format::Zip.broken(format!("no table is known among its members {}", first.join(", "))));
    }
    Ok((packed_texts(&mut archive, &texts)?, Format::Zip))
}

fn member(archive: &mut Archive, name: &str) -> Result<Vec<u8>, ReadProblem> {
    let member = archive.by_name(name).map_err(|e| Format::Zip.broken(format!("{name}: {e}")))?;
    // The size stated for a member is not trusted.
    unpack(member).map_err(|e| Format::Zip.broken(format!("{name}: {e}")))
}

fn npz(archive: &mut Archive, names: &[String]) -> Result<LoadedTables, ReadProblem> {
    let (mut found, mut notes, mut named) = (Vec::new(), Vec::new(), NamedValues::new());
    for name in names {
        let Some(plain) = name.strip_suffix(".npy") else { continue };
        let (parent, own) = plain.rsplit_once('/').unwrap_or(("", plain));
        match member(archive, name).and_then(|bytes| npy::contents(&bytes, parent, own)) {
            Ok(contents) => {
                found.extend(contents.arrays);
                named.extend(contents.named);
                notes.extend(contents.note.map(|n| format!("{own}: {n}")));
            }
            Err(problem) => notes.push(format!("{own} was not read: {problem}")),
        }
    }
    if found.is_empty() {
        return Err(Format::Zip.broken(format!("no array in it holds rows of numbers; {}", notes.join("; "))));
    }
    let mut tables = arrays::tables(found, &named);
    tables.note_all(&notes);
    Ok(tables)
}

/// Texts packed together, as in phyphox exports: tables next to `meta/`.
fn packed_texts(archive: &mut Archive, names: &[&String]) -> Result<LoadedTables, ReadProblem> {
    let (meta, data): (Vec<&String>, Vec<&String>) =
        names.iter().copied().partition(|n| n.starts_with("meta/") || n.contains("/meta/"));
    let mut tables = LoadedTables::default();
    let mut problems = Vec::new();
    for name in data {
        match member(archive, name).and_then(|bytes| text::load_tables(&bytes)) {
            Ok(held) => tables.absorb(held, name.rsplit('/').next().unwrap_or(name)),
            Err(problem) => problems.push(format!("{name} was not read: {problem}")),
        }
    }
    if tables.is_empty() {
        return Err(Format::Zip.broken(problems.join("; ")));
    }
    let mut named_values = Vec::new();
    for name in &meta {
        let Ok(bytes) = member(archive, name) else { continue };
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if name.ends_with("time.csv") {
            problems.extend(phyphox_pauses(&mut tables, &text));
        } else {
            named_values.extend(named::values(text.lines().map(str::to_owned)));
        }
    }
    tables.note_all(&problems);
    tables.name_all(&named_values);
    Ok(tables)
}

/// The clock of a phyphox experiment stops during a pause, while the oscillator continues to swing; `meta/time.csv`
/// gives the duration of the pause. Times after a pause are shifted by it.
fn phyphox_pauses(tables: &mut LoadedTables, text: &str) -> Option<String> {
    let mut pauses: Vec<(f64, f64)> = Vec::new();
    let mut paused: Option<(f64, f64)> = None;
    for line in text.lines() {
        let cells: Vec<&str> = line.split([',', ';', '\t']).map(|c| c.trim().trim_matches('"')).collect();
        let number = |i: usize| cells.get(i).and_then(|c| c.parse::<f64>().ok()).filter(|v| v.is_finite());
        let (Some(event), Some(experiment_s), Some(system_s)) = (cells.first(), number(1), number(2)) else {
            continue;
        };
        match (*event, paused) {
            ("PAUSE", _) => paused = Some((experiment_s, system_s)),
            ("START", Some((at, since))) if system_s > since => {
                pauses.push((at, system_s - since));
                paused = None;
            }
            _ => {}
        }
    }
    if pauses.is_empty() {
        return None;
    }
    tables.map_times(|time_s| {
        time_s + pauses.iter().filter(|(at, _)| time_s > *at).map(|(_, length)| length).sum::<f64>()
    });
    let total: f64 = pauses.iter().map(|(_, length)| length).sum();
    Some(format!(
        "the recording was paused {} times for {total:.1} s in all, according to meta/time.csv: times \
         after a pause were shifted by its length",
        pauses.len()
    ))
}

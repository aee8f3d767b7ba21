//! NanoSurf .nid: an INI header, then the samples of every channel.

use crate::{
    columns::head::Head,
    error::ReadProblem,
    format::Format,
    tables::binary::{Kind, Stored},
    tables::table::LoadedTables,
};

/// Maximum number of points along a line.
const MOST_POINTS: usize = 1 << 28;

/// The header: sections with their keys.
struct Header<'a> {
    text: &'a str,
}

impl<'a> Header<'a> {
    fn section(&self, name: &str) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
        let open = format!("[{name}]");
        let mut lines = self.text.lines().map(str::trim);
        lines.by_ref().find(|l| *l == open);
        lines.take_while(|l| !l.starts_with('[')).filter_map(|l| l.split_once('='))
    }

    fn value(&self, section: &str, key: &str) -> Option<&'a str> {
        self.section(section).find(|(k, _)| k.trim() == key).map(|(_, v)| v.trim())
    }

    fn number(&self, section: &str, key: &str) -> Option<f64> {
        self.value(section, key)?.parse().ok().filter(|v: &f64| v.is_finite())
    }
}

/// One table per line of each channel group.
pub(crate) fn tables(bytes: &[u8]) -> Result<LoadedTables, ReadProblem> {
    let end = memchr::memmem::find(bytes, b"#!")
        .ok_or_else(|| Format::NanoSurf.broken("no samples follow its header (#!)"))?;
    let text = crate::tables::text::decoded(&bytes[..end]);
    let header = Header { text: &text };
    let mut samples = &bytes[end + 2..];
    let mut tables = LoadedTables::default();
    // Groups and channels are numbered; the samples follow in this order.
    let mut channels: Vec<(u32, u32, &str)> = header
        .section("DataSet")
        .filter_map(|(key, name)| {
            let (group, channel) = key.trim().strip_prefix("Gr")?.split_once("-Ch")?;
            Some((group.parse().ok()?, channel.parse().ok()?, name.trim()))
        })
        .collect();
    channels.sort_unstable();
    let mut notes = Vec::new();
    for (group, channel, section) in channels {
        let points = header.number(section, "Points").unwrap_or(0.0).max(0.0) as usize;
        let lines = header.number(section, "Lines").unwrap_or(1.0).max(0.0) as usize;
        let bits = header.number(section, "SaveBits").unwrap_or(16.0);
        let bytes_each = match bits as u32 {
            bits @ (8 | 16 | 32) => bits as usize / 8,
            _ => return Err(Format::NanoSurf.broken(format!("[{section}] samples of {bits} bits"))),
        };
        let stored = Stored { kind: Kind::Signed, bytes: bytes_each, big_endian: false };
        let full = 2f64.powi(8 * bytes_each as i32);
        if points > MOST_POINTS {
            return Err(Format::NanoSurf.broken(format!("[{section}] names {points} points a line")));
        }
        let needed = points.checked_mul(lines).and_then(|n| n.checked_mul(bytes_each));
        let there = needed.filter(|n| *n <= samples.len()).unwrap_or(samples.len());
        let (own, rest) = samples.split_at(there);
        samples = rest;
        if needed != Some(there) {
            notes.push(format!("[{section}] ends early: {there} bytes of its samples are there"));
        }
        let (low, range) = (header.number(section, "Dim2Min"), header.number(section, "Dim2Range"));
        let (low, range) = (low.unwrap_or(0.0), range.unwrap_or(1.0));
        let name = header.value(section, "Dim2Name").unwrap_or("signal");
        let unit = header.value(section, "Dim2Unit").unwrap_or_default();
        let (x_name, x_unit) = (header.value(section, "Dim0Name"), header.value(section, "Dim0Unit"));
        let (x_min, x_range) = (header.number(section, "Dim0Min"), header.number(section, "Dim0Range"));
        let (x_min, x_range) = (x_min.unwrap_or(0.0), x_range.unwrap_or(0.0));
        for (line, raw) in own.chunks(points.max(1) * bytes_each).enumerate() {
            let whole = raw.len() / bytes_each;
            if whole < 2 {
                continue;
            }
            let values: Vec<f64> =
                stored.all(raw).into_iter().map(|v| low + range * (v / full + 0.5)).collect();
            let steps = points.saturating_sub(1).max(1) as f64;
            let x = (0..whole).map(|i| x_min + x_range * i as f64 / steps).collect();
            let x_name = x_name.unwrap_or("Time").trim_end_matches('*');
            let head = Head {
                name: format!("group {group} channel {channel} {name} line {}", line + 1),
                ..Head::of([format!("{x_name} ({})", x_unit.unwrap_or("s")), format!("{name} ({unit})")])
            };
            tables.push(head, vec![x, values], Vec::new());
        }
    }
    if tables.is_empty() {
        return Err(Format::NanoSurf.broken("no channel in it holds a line of samples"));
    }
    tables.note_all(&notes);
    Ok(tables)
}

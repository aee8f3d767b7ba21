//! Writes a table as CSV, NPY, sound, Parquet or JSON.

use super::parquet;
use super::sheet::{Digits, Parameter, Sheet, Value, number};
use crate::args::{OutArgs, RecordFormat, SamplingArgs};
use crate::failure::Failure;
use crate::output::{Outputs, Target};
use crate::progress;
use slipfit_report::escape;
use slipfit_report::json::{SimulatedColumn, SimulatedParameter, SimulatedRecord, simulated};
use std::io::{self, Cursor, Write};
use std::path::Path;

/// Maximum number of values kept in memory for the formats that need all of them.
const MOST_VALUES: u64 = 200_000_000;

/// Checked destinations of a table.
pub(super) struct Destinations {
    /// `None` if only JSON is requested on standard output.
    table: Option<Target>,
    format: RecordFormat,
    json: Option<Target>,
}

impl Destinations {
    /// The same for samples, with the requested number of digits, which applies to text only.
    pub(super) fn of_samples(
        out: &OutArgs,
        sampling: &SamplingArgs,
        input: Option<&Path>,
    ) -> Result<Self, Failure> {
        let to = Self::new(out, input)?;
        if let Some(digits) = sampling.digits.filter(|_| to.table.is_none() || to.format != RecordFormat::Csv)
        {
            return Err(Failure::new(format!(
                "--digits {digits}: only CSV has a number of digits; the other formats contain the whole numbers"
            ))
            .hint("leave it out, or write CSV with --out FILE.csv"));
        }
        Ok(to)
    }

    /// The destinations of a run that reads `input`.
    pub(super) fn new(out: &OutArgs, input: Option<&Path>) -> Result<Self, Failure> {
        let mut outputs = Outputs::new(out.replace.force, input)?;
        let json = out.json.as_deref().map(|path| outputs.add("--json", path)).transpose()?;
        let path = out.out.as_deref().unwrap_or(Path::new("-"));
        let format = out.format.map_or_else(|| by_ending(path), Ok)?;
        let json_alone = json.as_ref().is_some_and(Target::is_stdout) && path == Path::new("-");
        let table = if json_alone { None } else { Some(outputs.add("--out", path)?) };
        Ok(Self { table, format, json })
    }
}

/// Writes the table to its destinations.
pub(super) fn write(sheet: Sheet<'_>, to: &Destinations) -> Result<(), Failure> {
    // A spinner would disturb rows that are printed on a terminal.
    let screen = to.table.iter().chain(&to.json).any(Target::is_stdout);
    progress::with_spinner("simulating", screen, || write_all(sheet, to))
}

fn write_all(mut sheet: Sheet<'_>, to: &Destinations) -> Result<(), Failure> {
    if let (Some(table), None) = (&to.table, &to.json) {
        // Row by row if the format allows it, so that memory use does not grow.
        match to.format {
            RecordFormat::Csv => return stream(&mut sheet, table),
            RecordFormat::Parquet => return parquet::stream(&mut sheet, table),
            _ => {}
        }
    }
    let rows = collect(&mut sheet)?;
    if let Some(table) = &to.table {
        match to.format {
            RecordFormat::Csv => table.write(|out| {
                csv_header(out, &sheet)?;
                rows.chunks(sheet.columns.len()).try_for_each(|row| csv_row(out, &sheet, row))
            })?,
            RecordFormat::Npy => {
                let bytes = npy(&rows, sheet.columns.len());
                table.write(|out| out.write_all(&bytes))?;
            }
            RecordFormat::Wav => {
                let bytes = wav(&sheet, &rows)?;
                table.write(|out| out.write_all(&bytes))?;
            }
            RecordFormat::Parquet => parquet::write(&sheet, &rows, table)?,
        }
    }
    if let Some(target) = &to.json {
        let whole = as_json(&sheet, &rows);
        target.write(|out| simulated(out, &whole))?;
    }
    Ok(())
}

fn by_ending(path: &Path) -> Result<RecordFormat, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("npy") => Ok(RecordFormat::Npy),
        Some("wav") => Ok(RecordFormat::Wav),
        Some("parquet") => Ok(RecordFormat::Parquet),
        // Any other extension means text.
        _ => Ok(RecordFormat::Csv),
    }
}

fn stream(sheet: &mut Sheet<'_>, target: &Target) -> Result<(), Failure> {
    let mut out = target.open()?;
    let name = target.named().display().to_string();
    let failed = |e: io::Error| Failure::writing(&name, &e);
    csv_header(&mut out, sheet).map_err(failed)?;
    sheet.for_each(|sheet, row| csv_row(&mut out, sheet, row).map_err(failed))?;
    out.finish()
}

fn collect(sheet: &mut Sheet<'_>) -> Result<Vec<f64>, Failure> {
    let mut all = Vec::new();
    sheet.for_each(|_, row| {
        if all.len() as u64 >= MOST_VALUES {
            return Err(Failure::new(format!(
                "more than {MOST_VALUES} values, which only CSV and Parquet take"
            ))
            .hint("--duration or --rate-hz makes the record shorter"));
        }
        all.extend_from_slice(row);
        Ok(())
    })?;
    Ok(all)
}

fn csv_header(out: &mut dyn Write, sheet: &Sheet<'_>) -> io::Result<()> {
    writeln!(out, "# slipfit simulate {}: {}", sheet.command, sheet.title)?;
    for Parameter { name, value, unit } in &sheet.parameters {
        let value = match value {
            Value::Number(v) => number(*v),
            Value::Text(text) => text.clone(),
        };
        writeln!(out, "# {name} = {}", escape::csv_comment(format!("{value} {unit}").trim_end()))?;
    }
    let names: Vec<String> = sheet.columns.iter().map(|column| escape::csv(&column.heading())).collect();
    writeln!(out, "{}", names.join(","))
}

fn csv_row(out: &mut dyn Write, sheet: &Sheet<'_>, row: &[f64]) -> io::Result<()> {
    for (i, (column, value)) in sheet.columns.iter().zip(row).enumerate() {
        if i > 0 {
            out.write_all(b",")?;
        }
        match column.digits {
            // Nothing was measured.
            _ if value.is_nan() => {}
            Digits::Shortest => write!(out, "{value}")?,
            Digits::ShortestPower => write!(out, "{value:e}")?,
            Digits::Significant(digits) => write!(out, "{value:.*e}", digits.saturating_sub(1))?,
        }
    }
    out.write_all(b"\n")
}

/// A NumPy array (format 1.0) of little-endian doubles, shape (rows, columns), C order.
fn npy(rows: &[f64], columns: usize) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let shape = (rows.len() / columns.max(1), columns);
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape:?}, }}");
    // NumPy aligns the values to 64 bytes; the length of the header takes two bytes and a line feed ends it.
    let before = MAGIC.len() + 2 + header.len() + 1;
    header.push_str(&" ".repeat(before.next_multiple_of(64) - before));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(rows.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn wav(sheet: &Sheet<'_>, rows: &[f64]) -> Result<Vec<u8>, Failure> {
    let rate_hz = sheet.even_rate_hz.ok_or_else(|| {
        Failure::new("a sound file holds an evenly sampled waveform; this record is not one")
            .hint("write .csv or .npy")
    })?;
    if rate_hz.fract() != 0.0 || !(1.0..=4e9).contains(&rate_hz) {
        return Err(Failure::new(format!(
            "--rate-hz = {rate_hz} is out of range for a sound file; allowed: whole numbers from 1 to 4e9"
        )));
    }
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: rate_hz as u32,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let failed = |e: hound::Error| Failure::new(format!("the sound could not be written: {e}"));
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).map_err(failed)?;
    for row in rows.chunks(sheet.columns.len()) {
        writer.write_sample(row[1] as f32).map_err(failed)?;
    }
    writer.finalize().map_err(failed)?;
    Ok(with_software(bytes.into_inner()))
}

/// The sound with the name of this program added, as the chunk `LIST` of type `INFO`.
fn with_software(mut sound: Vec<u8>) -> Vec<u8> {
    let mut name = format!("slipfit {}\0", env!("CARGO_PKG_VERSION")).into_bytes();
    let length = (name.len() as u32).to_le_bytes();
    // Chunks begin at even offsets.
    name.resize(name.len().next_multiple_of(2), 0);
    let mut info = b"INFOISFT".to_vec();
    info.extend(length);
    info.extend(name);
    sound.extend(b"LIST");
    sound.extend((info.len() as u32).to_le_bytes());
    sound.extend(info);
    // Above 4 GB the total size does not fit its field, whatever is appended.
    let size = u32::try_from(sound.len() - 8).unwrap_or(u32::MAX);
    sound[4..8].copy_from_slice(&size.to_le_bytes());
    sound
}

/// The record with all parameters of the simulation.
fn as_json<'a>(sheet: &'a Sheet<'_>, rows: &[f64]) -> SimulatedRecord<'a> {
    let parameters = sheet.parameters.iter().map(|p| {
        let value = match &p.value {
            Value::Number(value) => SimulatedParameter::Number { value: *value, unit: &p.unit },
            Value::Text(text) => SimulatedParameter::Text { text },
        };
        (p.name, value)
    });
    let width = sheet.columns.len();
    let columns = sheet.columns.iter().enumerate().map(|(i, column)| SimulatedColumn {
        name: column.name,
        unit: &column.unit,
        values: rows.iter().skip(i).step_by(width).copied().collect(),
    });
    SimulatedRecord::new(sheet.command, sheet.title, parameters, columns.collect())
}

//! A table as CSV, NPY, sound, Parquet or JSON.

use super::parquet;
use super::sheet::{Column, Digits, Parameter, Sheet, Value, number};
use crate::args::{OutArgs, RecordFormat};
use crate::failure::Failure;
use crate::output;
use serde_json::{Map, json};
use slipfit_report::json::write as write_json;
use std::io::{self, Cursor, Write};
use std::path::Path;

/// Values kept in memory for the formats that need them all.
const MOST_VALUES: u64 = 200_000_000;

/// Writes the table wherever it was asked for.
pub(super) fn write(mut sheet: Sheet<'_>, out: &OutArgs) -> Result<(), Failure> {
    let target = out.out.as_deref().unwrap_or(Path::new("-"));
    let format = out.format.map_or_else(|| by_ending(target), Ok)?;
    let json_alone = out.json.as_deref().is_some_and(output::is_stdout) && output::is_stdout(target);
    if format == RecordFormat::Csv && out.json.is_none() {
        return stream(&mut sheet, target);
    }
    if format == RecordFormat::Parquet && out.json.is_none() {
        return parquet::stream(&mut sheet, target);
    }
    let rows = collect(&mut sheet)?;
    if !json_alone {
        match format {
            RecordFormat::Csv => {
                output::to_path(target, |out| {
                    csv_header(out, &sheet)?;
                    rows.chunks(sheet.columns.len()).try_for_each(|row| csv_row(out, &sheet, row))
                })?;
            }
            RecordFormat::Npy => {
                let bytes = npy(&rows, sheet.columns.len());
                output::to_path(target, |out| out.write_all(&bytes))?;
            }
            RecordFormat::Wav => {
                let bytes = wav(&sheet, &rows)?;
                output::to_path(target, |out| out.write_all(&bytes))?;
            }
            RecordFormat::Parquet => parquet::write(&sheet, &rows, target)?,
        }
    }
    if let Some(path) = &out.json {
        let whole = as_json(&sheet, &rows);
        output::to_path(path, |out| write_json(out, &whole))?;
    }
    Ok(())
}

fn by_ending(path: &Path) -> Result<RecordFormat, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("npy") => Ok(RecordFormat::Npy),
        Some("wav") => Ok(RecordFormat::Wav),
        Some("parquet") => Ok(RecordFormat::Parquet),
        // Any other name is text, as it always was.
        _ => Ok(RecordFormat::Csv),
    }
}

/// CSV row by row: memory stays flat.
fn stream(sheet: &mut Sheet<'_>, target: &Path) -> Result<(), Failure> {
    let (name, mut out) = output::open(target)?;
    let failed = |e: io::Error| Failure::writing(&name, &e);
    csv_header(&mut out, sheet).map_err(failed)?;
    sheet.for_each(|sheet, row| csv_row(&mut out, sheet, row).map_err(failed))?;
    out.flush().map_err(failed)
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
        writeln!(out, "# {name} = {}", format!("{value} {unit}").trim_end())?;
    }
    let names: Vec<String> = sheet.columns.iter().map(Column::heading).collect();
    writeln!(out, "{}", names.join(","))
}

fn csv_row(out: &mut dyn Write, sheet: &Sheet<'_>, row: &[f64]) -> io::Result<()> {
    for (i, (column, value)) in sheet.columns.iter().zip(row).enumerate() {
        if i > 0 {
            out.write_all(b",")?;
        }
        match column.digits {
            Digits::Shortest => write!(out, "{value}")?,
            Digits::Seven => write!(out, "{value:.6e}")?,
            Digits::All => write!(out, "{value:.16e}")?,
        }
    }
    out.write_all(b"\n")
}

/// A NumPy array (format 1.0) of little-endian doubles, shape (rows, columns), C order.
fn npy(rows: &[f64], columns: usize) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let shape = (rows.len() / columns.max(1), columns);
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape:?}, }}");
    // NumPy aligns the values to 64 bytes; the header's length takes two and a line feed ends it.
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
        Failure::new("a sound file holds an evenly sampled waveform; this is none").hint("write .csv or .npy")
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
    Ok(bytes.into_inner())
}

fn as_json(sheet: &Sheet<'_>, rows: &[f64]) -> serde_json::Value {
    let parameters: Map<String, serde_json::Value> = sheet
        .parameters
        .iter()
        .map(|p| {
            let value = match &p.value {
                Value::Number(v) => json!({"value": v, "unit": p.unit}),
                Value::Text(text) => json!({"text": text}),
            };
            (p.name.to_owned(), value)
        })
        .collect();
    let width = sheet.columns.len();
    let columns: Vec<serde_json::Value> = sheet
        .columns
        .iter()
        .enumerate()
        .map(|(i, c)| {
            let values: Vec<f64> = rows.iter().skip(i).step_by(width).copied().collect();
            json!({"name": c.name, "unit": c.unit, "values": values})
        })
        .collect();
    json!({
        "schema": "slipfit/simulate-1",
        "program": "slipfit",
        "version": env!("CARGO_PKG_VERSION"),
        "command": format!("simulate {}", sheet.command),
        "title": sheet.title,
        "parameters": parameters,
        "rows": rows.len() / width.max(1),
        "columns": columns,
    })
}

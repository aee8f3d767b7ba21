//! A table as Parquet: one column of doubles each, with every parameter in the file's metadata.

use super::sheet::{Parameter, Sheet, Value};
use crate::failure::Failure;
use crate::output::{Sink, Target};
use ::parquet::basic::{Repetition, Type as Physical};
use ::parquet::data_type::DoubleType;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;
use std::sync::Arc;

/// Number of rows per row group, which are kept in memory.
const GROUP: usize = 1 << 16;

/// Writes the rows as they are computed, so that memory use does not grow.
pub(super) fn stream(sheet: &mut Sheet<'_>, target: &Target) -> Result<(), Failure> {
    let mut file = Table::create(sheet, target)?;
    sheet.for_each(|_, row| file.push(row))?;
    file.finish()
}

/// Writes rows that are already computed, one after the other.
pub(super) fn write(sheet: &Sheet<'_>, rows: &[f64], target: &Target) -> Result<(), Failure> {
    let mut file = Table::create(sheet, target)?;
    for row in rows.chunks(sheet.columns.len()) {
        file.push(row)?;
    }
    file.finish()
}

struct Table {
    name: String,
    writer: SerializedFileWriter<Sink>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    fn create(sheet: &Sheet<'_>, target: &Target) -> Result<Self, Failure> {
        let name = target.named().display().to_string();
        let sink = target.open()?;
        let made = schema(sheet).and_then(|schema| {
            // Numbers with noise neither repeat nor compress well.
            let properties = WriterProperties::builder()
                .set_created_by(format!("slipfit {}", env!("CARGO_PKG_VERSION")))
                .set_dictionary_enabled(false)
                .set_key_value_metadata(Some(metadata(sheet)))
                .build();
            SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties))
        });
        let writer = made.map_err(|e| failed(&name, e))?;
        Ok(Self { name, writer, columns: vec![Vec::new(); sheet.columns.len()] })
    }

    fn push(&mut self, row: &[f64]) -> Result<(), Failure> {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value);
        }
        if self.columns[0].len() >= GROUP { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Failure> {
        let put = |writer: &mut SerializedFileWriter<Sink>, columns: &mut [Vec<f64>]| {
            let mut group = writer.next_row_group()?;
            for values in columns {
                if let Some(mut column) = group.next_column()? {
                    column.typed::<DoubleType>().write_batch(values, None, None)?;
                    column.close()?;
                }
                values.clear();
            }
            group.close().map(|_| ())
        };
        put(&mut self.writer, &mut self.columns).map_err(|e| failed(&self.name, e))
    }

    fn finish(mut self) -> Result<(), Failure> {
        if !self.columns[0].is_empty() {
            self.flush()?;
        }
        self.writer.into_inner().map_err(|e| failed(&self.name, e))?.finish()
    }
}

/// Columns named as in CSV, so that the same readers recognise them.
fn schema(sheet: &Sheet<'_>) -> Result<Type, ParquetError> {
    let fields = sheet
        .columns
        .iter()
        .map(|c| {
            let heading = c.heading();
            let column = Type::primitive_type_builder(&heading, Physical::DOUBLE);
            column.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
        })
        .collect::<Result<_, _>>()?;
    Type::group_type_builder("slipfit").with_fields(fields).build()
}

/// As in the header of CSV; numbers unrounded, followed by their unit.
fn metadata(sheet: &Sheet<'_>) -> Vec<KeyValue> {
    let mut all = vec![
        KeyValue::new("program".to_owned(), format!("slipfit {}", env!("CARGO_PKG_VERSION"))),
        KeyValue::new("command".to_owned(), format!("simulate {}", sheet.command)),
        KeyValue::new("title".to_owned(), sheet.title.to_owned()),
    ];
    all.extend(sheet.parameters.iter().map(|Parameter { name, value, unit }| {
        let value = match value {
            Value::Number(v) => format!("{v} {unit}").trim_end().to_owned(),
            Value::Text(text) => text.clone(),
        };
        KeyValue::new((*name).to_owned(), value)
    }));
    all
}

fn failed(name: &str, error: ParquetError) -> Failure {
    if let ParquetError::External(inner) = &error
        && let Some(io) = inner.downcast_ref::<std::io::Error>()
    {
        return Failure::writing(name, io);
    }
    Failure::new(format!("{name}: cannot be written: {error}"))
}

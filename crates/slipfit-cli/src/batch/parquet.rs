//! Rows as Parquet: one typed column each, with empty cells missing.

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use slipfit_report::row::{Column, Kind, Row, Value};
use std::sync::Arc;

const FIRST: [Column; 3] = [Column::text("file"), Column::text("status"), Column::text("reason")];

pub(super) fn render(rows: &[Row], columns: &'static [Column]) -> Result<Vec<u8>, ParquetError> {
    let all: Vec<&Column> = FIRST.iter().chain(columns).collect();
    let fields = all.iter().map(|c| field(c).map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("slipfit").with_fields(fields).build()?;
    let properties =
        WriterProperties::builder().set_created_by(format!("slipfit {}", crate::version::long())).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for index in 0..all.len() {
        if let Some(mut column) = group.next_column()? {
            let cells = rows.iter().map(|row| match index {
                0 => Value::text(&row.file),
                1 => Value::text(row.status.name()),
                2 => Value::text(&row.reason),
                _ => row.values[index - FIRST.len()].clone(),
            });
            put(&mut column, all[index].kind, cells)?;
            column.close()?;
        }
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Count => (Physical::INT64, None),
        Kind::Flag => (Physical::BOOLEAN, None),
    };
    Type::primitive_type_builder(column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
}

fn put(
    column: &mut SerializedColumnWriter<'_>,
    kind: Kind,
    cells: impl Iterator<Item = Value>,
) -> Result<(), ParquetError> {
    // Level 1 is a value, 0 a missing one.
    let mut levels: Vec<i16> = Vec::new();
    let (mut texts, mut numbers, mut counts, mut flags) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(cell != Value::None));
        match cell {
            Value::None => {}
            Value::Text(text) => texts.push(ByteArray::from(text.into_bytes())),
            Value::Number(v) => numbers.push(v),
            // A count above the range of an i64 cannot occur in a file.
            Value::Count(n) => counts.push(i64::try_from(n).unwrap_or(i64::MAX)),
            Value::Flag(b) => flags.push(b),
        }
    }
    let levels = Some(&levels[..]);
    match kind {
        Kind::Text => column.typed::<ByteArrayType>().write_batch(&texts, levels, None),
        Kind::Number => column.typed::<DoubleType>().write_batch(&numbers, levels, None),
        Kind::Count => column.typed::<Int64Type>().write_batch(&counts, levels, None),
        Kind::Flag => column.typed::<BoolType>().write_batch(&flags, levels, None),
    }
    .map(|_| ())
}

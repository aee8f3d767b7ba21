//! Parquet files, read row group by row group.

use std::io::{self, Read};

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::{
    columns::{head::Head, name::Name},
    error::ReadProblem,
    format::Format,
    input::Input,
    report::Skipped,
    tables::binary::{Kind, Stored},
    tables::guard,
    tables::table::{BATCH, Batch, Sink, TableSource},
};

/// Runs a decoder of the `parquet` crate, which panics on some corrupt files.
fn decoded<T>(decode: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ReadProblem> {
    guard::guarded(Format::Parquet, decode, |e| Format::Parquet.broken(e))
}

/// An open Parquet file.
pub(crate) struct Parquet {
    reader: Box<dyn FileReader>,
    head: Head,
    /// Index in the file of each column that holds numbers.
    columns: Vec<usize>,
}

/// A file whose end is an error: the crate skips what a corrupt header claims, two thousand million lists, one by one,
/// as long as reading nothing is not an error.
struct Chunks<R>(R);

impl<R: Length> Length for Chunks<R> {
    fn len(&self) -> u64 {
        self.0.len()
    }
}

impl<R: ChunkReader> ChunkReader for Chunks<R> {
    type T = NotPastTheEnd<R::T>;

    fn get_read(&self, start: u64) -> parquet::errors::Result<Self::T> {
        self.0.get_read(start).map(NotPastTheEnd)
    }

    fn get_bytes(&self, start: u64, length: usize) -> parquet::errors::Result<bytes::Bytes> {
        self.0.get_bytes(start, length)
    }
}

struct NotPastTheEnd<R>(R);

impl<R: Read> Read for NotPastTheEnd<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer)? {
            0 if !buffer.is_empty() => Err(io::ErrorKind::UnexpectedEof.into()),
            n => Ok(n),
        }
    }
}

impl Parquet {
    /// Reads the footer.
    pub(crate) fn open(input: Input) -> Result<Self, ReadProblem> {
        let (size, input) = input.size().map_err(ReadProblem::Io)?;
        let reader: Box<dyn FileReader> = match input {
            Input::File(file) => Box::new(decoded(|| SerializedFileReader::new(Chunks(file)))?),
            Input::Bytes(bytes) => {
                let bytes = bytes::Bytes::from(bytes.into_inner());
                Box::new(decoded(|| SerializedFileReader::new(Chunks(bytes)))?)
            }
        };
        check_places(reader.metadata(), size)?;
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        let mut head = Head::default();
        let mut columns = Vec::new();
        for (i, column) in schema.columns().iter().enumerate() {
            if Meaning::of(column).is_some() && column.max_rep_level() == 0 {
                head.names.push(Name::with_unit(&column.path().string(), time_unit(column)));
                columns.push(i);
            } else {
                head.note_not_numbers(&column.path().string());
            }
        }
        for pair in reader.metadata().file_metadata().key_value_metadata().into_iter().flatten() {
            // Schemas of other programs are also stored here; they are not values.
            if let Some(value) = pair.value.as_ref().filter(|v| v.len() < 200) {
                head.named_values.push((pair.key.clone(), value.clone()));
            }
        }
        if columns.is_empty() {
            return Err(Format::Parquet.broken("no column in it holds numbers"));
        }
        Ok(Self { reader, head, columns })
    }
}

/// Rejects columns that lie outside the file: the crate does not check their offsets.
fn check_places(metadata: &parquet::file::metadata::ParquetMetaData, size: u64) -> Result<(), ReadProblem> {
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
        let length = column.compressed_size();
        let end = start.checked_add(length).and_then(|end| u64::try_from(end).ok());
        if start < 0 || length < 0 || column.data_page_offset() < 0 || end.is_none_or(|end| end > size) {
            return Err(
                Format::Parquet.broken(format!("column `{}` lies outside of the file", column.column_path()))
            );
        }
    }
    Ok(())
}

/// The unit of a time stamp, if the column is declared as one; older writers declare it by the converted type alone.
fn time_unit(column: &ColumnDescriptor) -> Option<&'static str> {
    if column.physical_type() == Type::INT96 {
        return Some("ns");
    }
    let unit = match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(t)), _) => &t.unit,
        (Some(LogicalType::Time(t)), _) => &t.unit,
        (None, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => &TimeUnit::MILLIS,
        (None, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => &TimeUnit::MICROS,
        _ => return None,
    };
    Some(match unit {
        TimeUnit::MILLIS => "ms",
        TimeUnit::MICROS => "us",
        TimeUnit::NANOS => "ns",
    })
}

/// Meaning of the stored words of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    /// The numbers as they are.
    Plain,
    /// Unsigned integers.
    Unsigned,
    /// Sixteen-bit floats.
    Half,
    /// Integers divided by a power of ten.
    Decimal(f64),
}

impl Meaning {
    /// `None` if the column holds no numbers.
    fn of(column: &ColumnDescriptor) -> Option<Self> {
        let physical = column.physical_type();
        let fixed = physical == Type::FIXED_LEN_BYTE_ARRAY;
        let short = !fixed || (1..=16).contains(&column.type_length());
        if physical == Type::BYTE_ARRAY || !short {
            return None;
        }
        let converted = column.converted_type();
        match column.logical_type_ref() {
            Some(LogicalType::Decimal(d)) => Some(Self::Decimal(10f64.powi(d.scale))),
            None if converted == ConvertedType::DECIMAL => {
                Some(Self::Decimal(10f64.powi(column.type_scale())))
            }
            Some(LogicalType::Float16) if column.type_length() == 2 => Some(Self::Half),
            _ if fixed => None,
            Some(LogicalType::Integer(i)) if !i.is_signed => Some(Self::Unsigned),
            None if matches!(converted, ConvertedType::UINT_32 | ConvertedType::UINT_64) => {
                Some(Self::Unsigned)
            }
            _ => Some(Self::Plain),
        }
    }

    fn of_i32(self, v: i32) -> f64 {
        match self {
            Self::Unsigned => f64::from(v.cast_unsigned()),
            Self::Decimal(unit) => f64::from(v) / unit,
            _ => f64::from(v),
        }
    }

    fn of_i64(self, v: i64) -> f64 {
        match self {
            Self::Unsigned => v.cast_unsigned() as f64,
            Self::Decimal(unit) => v as f64 / unit,
            _ => v as f64,
        }
    }

    /// Sixteen-bit floats begin with the low byte, decimals with the high byte.
    fn of_bytes(self, bytes: &[u8]) -> f64 {
        match self {
            Self::Decimal(unit) => {
                let negative = bytes.first().is_some_and(|b| *b >= 0x80);
                let mut word = [if negative { 0xff } else { 0 }; 16];
                let from = word.len() - bytes.len().min(16);
                word[from..].copy_from_slice(&bytes[..bytes.len().min(16)]);
                i128::from_be_bytes(word) as f64 / unit
            }
            _ => Stored::new(Kind::Float, 2, false).map_or(f64::NAN, |half| half.read(bytes)),
        }
    }
}

/// A column being read, with the buffer for its numbers.
struct Running {
    reader: ColumnReader,
    meaning: Meaning,
    nullable: i16,
    values: Vec<f64>,
}

impl Running {
    /// Reads up to `rows` rows; those without a value are NaN.
    fn fill(&mut self, rows: usize) -> Result<(), ParquetError> {
        self.values.clear();
        let (nullable, meaning) = (self.nullable, self.meaning);
        let values = &mut self.values;
        macro_rules! read {
            ($reader:expr, $as:expr) => {{
                while values.len() < rows {
                    let (mut numbers, mut levels) = (Vec::new(), Vec::new());
                    let wanted = if nullable > 0 { Some(&mut levels) } else { None };
                    let (records, ..) =
                        $reader.read_records(rows - values.len(), wanted, None, &mut numbers)?;
                    if records == 0 {
                        break;
                    }
                    let mut numbers = numbers.into_iter().map($as);
                    if nullable > 0 {
                        values.extend(levels.iter().map(|level| {
                            if *level == nullable { numbers.next().unwrap_or(f64::NAN) } else { f64::NAN }
                        }));
                    } else {
                        values.extend(numbers);
                    }
                }
            }};
        }
        match &mut self.reader {
            ColumnReader::BoolColumnReader(r) => read!(r, |v| f64::from(u8::from(v))),
            ColumnReader::Int32ColumnReader(r) => read!(r, |v| meaning.of_i32(v)),
            ColumnReader::Int64ColumnReader(r) => read!(r, |v| meaning.of_i64(v)),
            ColumnReader::Int96ColumnReader(r) => read!(r, |v| v.to_nanos() as f64),
            ColumnReader::FixedLenByteArrayColumnReader(r) => read!(r, |v| meaning.of_bytes(v.data())),
            ColumnReader::FloatColumnReader(r) => read!(r, f64::from),
            ColumnReader::DoubleColumnReader(r) => read!(r, |v| v),
            ColumnReader::ByteArrayColumnReader(_) => {}
        }
        Ok(())
    }
}

impl TableSource for Parquet {
    fn heads(&self) -> Vec<&Head> {
        vec![&self.head]
    }

    fn scan(&mut self, _: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        let metadata = self.reader.metadata();
        let schema = metadata.file_metadata().schema_descr_ptr();
        for group in 0..metadata.num_row_groups() {
            let row_group = decoded(|| self.reader.get_row_group(group))?;
            let open = |&w: &usize| {
                let index = self.columns[w];
                let reader = row_group.get_column_reader(index)?;
                let nullable = schema.column(index).max_def_level();
                let meaning = Meaning::of(&schema.column(index)).unwrap_or(Meaning::Plain);
                Ok(Running { reader, meaning, nullable, values: Vec::new() })
            };
            let mut running = decoded(|| wanted.iter().map(open).collect::<Result<Vec<_>, ParquetError>>())?;
            loop {
                for column in &mut running {
                    decoded(|| column.fill(BATCH))?;
                }
                // Columns of one group have equal lengths, except in a corrupt file.
                let rows = running.iter().map(|c| c.values.len()).min().unwrap_or(0);
                let batch: Vec<&[f64]> = running.iter().map(|c| &c.values[..rows]).collect();
                if rows > 0 && !sink(Batch::of(&batch)) {
                    return Ok(Vec::new());
                }
                if rows < BATCH {
                    break;
                }
            }
        }
        Ok(Vec::new())
    }
}

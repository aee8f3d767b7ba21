//! Arrow IPC: files (also called Feather) and streams, message by message.
//!
//! A file is a stream between two magic words and a footer that lists its batches. Most programs read the footer, and
//! polars omits the frame of the first message; a file without its footer is read as a stream, as far as it is intact.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::{Array as _, ArrayRef, cast::AsArray as _, types};
use arrow_buffer::Buffer;
use arrow_ipc::{
    CompressionType, MessageHeader, convert::try_fb_to_schema, reader, root_as_footer, root_as_message,
};
use arrow_schema::{DataType, Schema, SchemaRef, TimeUnit};

use crate::{
    columns::{head::Head, name::Name},
    error::ReadProblem,
    format::Format,
    report::Skipped,
    tables::guard,
    tables::table::{Batch, Sink, TableSource},
};

const MAGIC: &[u8] = b"ARROW1\0\0";
const MAGIC_END: &[u8] = b"ARROW1";
/// Maximum expansion factor: LZ4 encodes 255 repeated bytes by one byte of length, Zstandard 128 KiB by a block of four
/// bytes.
const MOST_EXPANSION: [(CompressionType, usize); 2] =
    [(CompressionType::LZ4_FRAME, 255), (CompressionType::ZSTD, 1 << 15)];

/// Whether bytes begin like streams from before 2019: with the length of the first message, without a marker before it,
/// and the offsets of its root and of the table that describes it.
pub(crate) fn is_unmarked(head: &[u8]) -> bool {
    let word = |at: usize| Some(u32::from_le_bytes(head.get(at..at + 4)?.try_into().ok()?) as usize);
    let root = || {
        let (length, root) = (word(0)?, word(4)?);
        let place = root.checked_add(4).filter(|place| *place < head.len())?;
        let vtable = head.get(place.checked_sub(word(place)?)?..)?.first_chunk::<4>()?;
        let [size, fields] = [[vtable[0], vtable[1]], [vtable[2], vtable[3]]].map(u16::from_le_bytes);
        Some(
            length % 4 == 0
                && (root + 4..1 << 20).contains(&length)
                && (4..64).contains(&size)
                && fields < 64,
        )
    };
    root().unwrap_or(false)
}

/// A file in memory whose schema has been read.
pub(crate) struct Arrow {
    bytes: Buffer,
    schema: SchemaRef,
    head: Head,
    /// Index in the schema of each column that holds numbers.
    columns: Vec<usize>,
    /// The messages after the schema.
    messages: Vec<Framed>,
}

/// A message: the byte ranges of its description and of its body, after which the next one begins.
struct Framed {
    description: std::ops::Range<usize>,
    body: std::ops::Range<usize>,
}

/// The message at an offset; `None` at the end of the stream or of the bytes.
fn framed(bytes: &[u8], at: usize) -> Result<Option<Framed>, ReadProblem> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    // Older writers omit the marker.
    let (length, start) = match word(at) {
        Some(u32::MAX) => (word(at + 4), at + 8),
        other => (other, at + 4),
    };
    let Some(length) = length.filter(|l| *l > 0) else { return Ok(None) };
    let end = start.saturating_add(length as usize);
    if end > bytes.len() {
        return Ok(None);
    }
    let message = root_as_message(&bytes[start..end]).map_err(|e| Format::Arrow.broken(e))?;
    let body = usize::try_from(message.bodyLength())
        .map_err(|_| Format::Arrow.broken("a body of negative length"))?;
    let body_end =
        end.checked_add(body).ok_or_else(|| Format::Arrow.broken("a body longer than any memory"))?;
    if body_end > bytes.len() {
        return Ok(None);
    }
    Ok(Some(Framed { description: start..end, body: end..body_end }))
}

/// The schema and the messages listed in the footer of a file; `None` if there is no footer.
fn by_footer(bytes: &[u8]) -> Option<(Schema, Vec<Framed>)> {
    let end = bytes.len().checked_sub(MAGIC_END.len() + 4)?;
    let length = u32::from_le_bytes(bytes[end..end + 4].try_into().ok()?) as usize;
    if !bytes.starts_with(MAGIC) || !bytes.ends_with(MAGIC_END) {
        return None;
    }
    let footer = root_as_footer(bytes.get(end.checked_sub(length)?..end)?).ok()?;
    let schema = try_fb_to_schema(footer.schema()?).ok()?;
    let (mut messages, mut before) = (Vec::new(), 0);
    for block in footer.recordBatches().into_iter().flatten() {
        let at = usize::try_from(block.offset()).ok()?;
        let message = framed(&bytes[..end - length], at).ok()??;
        // A batch that is listed repeatedly could unpack to any size.
        if at < before {
            return None;
        }
        before = message.body.end;
        messages.push(message);
    }
    Some((schema, messages))
}

/// The schema and the messages of a stream, as far as it is intact.
fn by_stream(bytes: &[u8]) -> Result<(Schema, Vec<Framed>), ReadProblem> {
    let at = if bytes.starts_with(MAGIC) { MAGIC.len() } else { 0 };
    let first = framed(bytes, at)?.ok_or_else(|| Format::Arrow.broken("it ends before its schema"))?;
    let message = root_as_message(&bytes[first.description]).map_err(|e| Format::Arrow.broken(e))?;
    let schema =
        message.header_as_schema().ok_or_else(|| Format::Arrow.broken("it does not begin with a schema"))?;
    let schema = try_fb_to_schema(schema).map_err(|e| Format::Arrow.broken(e))?;
    let (mut messages, mut at) = (Vec::new(), first.body.end);
    while let Some(message) = framed(bytes, at)? {
        at = message.body.end;
        messages.push(message);
    }
    Ok((schema, messages))
}

impl Arrow {
    /// Reads the schema and finds the batches.
    pub(crate) fn open(bytes: Vec<u8>) -> Result<Self, ReadProblem> {
        let (schema, messages) = by_footer(&bytes).map_or_else(|| by_stream(&bytes), Ok)?;
        let mut head = Head::default();
        let mut columns = Vec::new();
        for (i, field) in schema.fields().iter().enumerate() {
            if is_number(field.data_type()) {
                let stated = field.metadata().get("unit").or_else(|| field.metadata().get("units"));
                let unit = stated.map(String::as_str).or_else(|| time_unit(field.data_type()));
                head.names.push(Name::with_unit(field.name(), unit));
                columns.push(i);
            } else {
                head.note_not_numbers(field.name());
            }
        }
        for (name, value) in schema.metadata().iter().filter(|(_, v)| v.len() < 200) {
            head.named_values.push((name.clone(), value.clone()));
        }
        head.named_values.sort_unstable();
        if columns.is_empty() {
            return Err(Format::Arrow.broken("no column in it holds numbers"));
        }
        Ok(Self { bytes: Buffer::from_vec(bytes), schema: Arc::new(schema), head, columns, messages })
    }
}

fn is_number(kind: &DataType) -> bool {
    let other = matches!(
        kind,
        DataType::Interval(_) | DataType::Decimal32(..) | DataType::Decimal64(..) | DataType::Decimal256(..)
    );
    kind.is_primitive() && !other || *kind == DataType::Boolean
}

fn time_unit(kind: &DataType) -> Option<&'static str> {
    let (DataType::Timestamp(unit, _)
    | DataType::Duration(unit)
    | DataType::Time32(unit)
    | DataType::Time64(unit)) = kind
    else {
        return None;
    };
    Some(match unit {
        TimeUnit::Second => "s",
        TimeUnit::Millisecond => "ms",
        TimeUnit::Microsecond => "us",
        TimeUnit::Nanosecond => "ns",
    })
}

/// The numbers of an array; NaN for missing values.
fn numbers(array: &ArrayRef) -> Vec<f64> {
    macro_rules! read {
        ($type:ident, $as:expr) => {
            array
                .as_primitive_opt::<types::$type>()
                .map(|a| a.iter().map(|v| v.map_or(f64::NAN, $as)).collect())
        };
    }
    let integer = |v: i64| v as f64;
    let found: Option<Vec<f64>> = match array.data_type() {
        DataType::Float64 => read!(Float64Type, |v| v),
        DataType::Float32 => read!(Float32Type, f64::from),
        DataType::Float16 => read!(Float16Type, f64::from),
        DataType::Int8 => read!(Int8Type, f64::from),
        DataType::Int16 => read!(Int16Type, f64::from),
        DataType::Int32 => read!(Int32Type, f64::from),
        DataType::Int64 => read!(Int64Type, integer),
        DataType::UInt8 => read!(UInt8Type, f64::from),
        DataType::UInt16 => read!(UInt16Type, f64::from),
        DataType::UInt32 => read!(UInt32Type, f64::from),
        DataType::UInt64 => read!(UInt64Type, |v| v as f64),
        DataType::Timestamp(TimeUnit::Second, _) => read!(TimestampSecondType, integer),
        DataType::Timestamp(TimeUnit::Millisecond, _) => read!(TimestampMillisecondType, integer),
        DataType::Timestamp(TimeUnit::Microsecond, _) => read!(TimestampMicrosecondType, integer),
        DataType::Timestamp(TimeUnit::Nanosecond, _) => read!(TimestampNanosecondType, integer),
        DataType::Duration(TimeUnit::Second) => read!(DurationSecondType, integer),
        DataType::Duration(TimeUnit::Millisecond) => read!(DurationMillisecondType, integer),
        DataType::Duration(TimeUnit::Microsecond) => read!(DurationMicrosecondType, integer),
        DataType::Duration(TimeUnit::Nanosecond) => read!(DurationNanosecondType, integer),
        DataType::Time32(TimeUnit::Second) => read!(Time32SecondType, f64::from),
        DataType::Time32(_) => read!(Time32MillisecondType, f64::from),
        DataType::Time64(TimeUnit::Microsecond) => read!(Time64MicrosecondType, integer),
        DataType::Time64(_) => read!(Time64NanosecondType, integer),
        DataType::Decimal128(_, scale) => {
            let unit = 10f64.powi(i32::from(*scale));
            read!(Decimal128Type, |v| v as f64 / unit)
        }
        DataType::Boolean => array
            .as_boolean_opt()
            .map(|a| a.iter().map(|v| v.map_or(f64::NAN, |v| f64::from(u8::from(v)))).collect()),
        _ => None,
    };
    found.unwrap_or_else(|| vec![f64::NAN; array.len()])
}

/// Rejects columns that lie outside their batch, and packed columns that claim to unpack to more than their compression
/// or the memory budget allows: memory is allocated according to the claim.
fn check_claims(batch: &arrow_ipc::RecordBatch<'_>, body: &[u8]) -> Result<(), ReadProblem> {
    let codec = batch.compression().map(|packing| packing.codec());
    let expansion =
        MOST_EXPANSION.iter().find(|(known, _)| Some(*known) == codec).map_or(1, |(_, most)| *most);
    let mut claims = 0_usize;
    for buffer in batch.buffers().into_iter().flatten() {
        let range = usize::try_from(buffer.offset()).ok().zip(usize::try_from(buffer.length()).ok());
        let packed = range.and_then(|(at, length)| body.get(at..at.checked_add(length)?));
        let packed = packed.ok_or_else(|| Format::Arrow.broken("a column lies outside of its batch"))?;
        if codec.is_some()
            && let Some(claim) = packed.first_chunk::<8>()
        {
            // A negative value marks a buffer that is not packed.
            claims = claims.saturating_add(usize::try_from(i64::from_le_bytes(*claim)).unwrap_or(0));
        }
    }
    if claims > guard::budget(body.len(), expansion) {
        return Err(Format::Arrow.broken(format!("{} packed bytes claim to unpack to {claims}", body.len())));
    }
    Ok(())
}

impl TableSource for Arrow {
    fn heads(&self) -> Vec<&Head> {
        vec![&self.head]
    }

    fn scan(&mut self, _: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        // A projection keeps the order of the file.
        let mut projection: Vec<usize> = wanted.iter().map(|&w| self.columns[w]).collect();
        projection.sort_unstable();
        projection.dedup();
        let dictionaries = HashMap::new();
        for frame in &self.messages {
            let message = root_as_message(&self.bytes[frame.description.clone()])
                .map_err(|e| Format::Arrow.broken(e))?;
            if message.header_type() != MessageHeader::RecordBatch {
                continue;
            }
            let batch = message
                .header_as_record_batch()
                .ok_or_else(|| Format::Arrow.broken("a batch without its head"))?;
            let body = self.bytes.slice_with_length(frame.body.start, frame.body.len());
            check_claims(&batch, &body)?;
            let decode = || {
                let (schema, version) = (Arc::clone(&self.schema), message.version());
                reader::read_record_batch(&body, batch, schema, &dictionaries, Some(&projection), &version)
            };
            let read = guard::guarded(Format::Arrow, decode, |e| Format::Arrow.broken(e))?;
            let columns: Vec<Vec<f64>> = wanted
                .iter()
                .map(|&w| {
                    let place = projection.binary_search(&self.columns[w]).unwrap_or(0);
                    numbers(read.column(place))
                })
                .collect();
            let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            if read.num_rows() > 0 && !sink(Batch::of(&slices)) {
                break;
            }
        }
        Ok(Vec::new())
    }
}

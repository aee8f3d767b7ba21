//! Which format a file is in, and its way from there.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    time::SystemTime,
};

use crate::{
    Format, ReadOptions, ReadProblem, Reading, Tables, archive, format,
    hashing::{Hashing, Watch},
    input::Input,
    mat5, nanosurf, npy, samples,
    table::{self, TableSource},
    text, touchstone, tracker, wav,
};

/// A file, or bytes that come once.
pub(crate) enum Origin<'a> {
    File(File),
    Stream(Box<dyn Read + 'a>),
}

/// What a file turned out to be.
enum Opened<'a> {
    /// Text from its beginning on, of a size if it is known.
    Text(Box<dyn Read + 'a>, Option<u64>),
    Tables(Box<dyn TableSource>, Format),
}

/// A record from any format, from text only if `only_text`.
pub(crate) fn record(
    origin: Origin<'_>,
    name: &str,
    only_text: bool,
    options: &ReadOptions,
    watch: Option<Watch<'_>>,
) -> Result<Reading, ReadProblem> {
    let ((mut reading, format), sha256, bytes) = with(origin, only_text, watch, |opened| match opened {
        Opened::Text(reader, size) => Ok((text::read(reader, size, options)?, Format::Text)),
        Opened::Tables(mut source, format) => Ok((samples::read(&mut *source, format, options)?, format)),
    })?;
    reading.report.format = format;
    (reading.report.sha256, reading.report.bytes) = (sha256, bytes);
    name.clone_into(&mut reading.report.path);
    Ok(reading)
}

/// All tables of any format, of each its first `most_rows` rows.
pub(crate) fn tables(origin: Origin<'_>, name: &str, most_rows: usize) -> Result<Tables, ReadProblem> {
    let ((tables, format, dialect), sha256, bytes) = with(origin, false, None, |opened| {
        let (mut source, format): (Box<dyn TableSource>, Format) = match opened {
            Opened::Text(reader, _) => (Box::new(text::hold(reader, most_rows)?), Format::Text),
            Opened::Tables(source, format) => (source, format),
        };
        let count = source.heads().len();
        let tables = (0..count).map(|t| table::gather(&mut *source, t, most_rows));
        Ok((tables.collect::<Result<Vec<_>, _>>()?, format, source.dialect()))
    })?;
    Ok(Tables { path: name.to_owned(), format, sha256, bytes, dialect, tables })
}

/// Opens a file, lets `then` read it, and gives its fingerprint and length too.
fn with<T>(
    origin: Origin<'_>,
    only_text: bool,
    watch: Option<Watch<'_>>,
    then: impl FnOnce(Opened<'_>) -> Result<T, ReadProblem>,
) -> Result<(T, String, u64), ReadProblem> {
    let size = match &origin {
        Origin::File(file) => file.metadata().ok().map(|m| m.len()),
        Origin::Stream(_) => None,
    };
    let mut file = match &origin {
        Origin::File(file) => file.try_clone().ok(),
        Origin::Stream(_) => None,
    };
    let reader: Box<dyn Read> = match origin {
        Origin::File(file) => Box::new(file),
        Origin::Stream(reader) => reader,
    };
    let mut hashing = Hashing::new(reader, watch);
    let mut head = Vec::with_capacity(format::HEAD);
    hashing.by_ref().take(format::HEAD as u64).read_to_end(&mut head).map_err(ReadProblem::Io)?;
    let format = Format::of(&head);
    let done = match format {
        Format::Text => then(Opened::Text(Box::new(head.chain(&mut hashing)), size))?,
        Format::Gzip if !only_text => unpacked(head.chain(&mut hashing), then)?,
        other if only_text => return Err(ReadProblem::Unsupported(other)),
        other => {
            // These are read from several places: a file as it is, a stream once it is held.
            let held = file.as_ref().and_then(|f| f.try_clone().ok());
            let before = held.as_ref().and_then(stamp);
            let mut input = match file.take() {
                Some(file) => {
                    io::copy(&mut hashing, &mut io::sink()).map_err(ReadProblem::Io)?;
                    Input::File(file)
                }
                None => {
                    hashing.read_to_end(&mut head).map_err(ReadProblem::Io)?;
                    Input::of(head)
                }
            };
            input.seek(SeekFrom::Start(0)).map_err(ReadProblem::Io)?;
            let done = source(input, other).and_then(|(source, format)| then(Opened::Tables(source, format)));
            // The hash and the tables are read one after the other: both must see the same bytes.
            if before != held.as_ref().and_then(stamp) {
                return Err(ReadProblem::Changed);
            }
            done?
        }
    };
    // What follows the samples belongs to the file.
    io::copy(&mut hashing, &mut io::sink()).map_err(ReadProblem::Io)?;
    let (sha256, bytes) = hashing.finish();
    Ok((done, sha256, bytes))
}

/// Length and time of the last change.
fn stamp(file: &File) -> Option<(u64, SystemTime)> {
    let about = file.metadata().ok()?;
    Some((about.len(), about.modified().ok()?))
}

/// What a gzip file holds: text streams, anything else is held.
fn unpacked<T>(
    packed: impl Read,
    then: impl FnOnce(Opened<'_>) -> Result<T, ReadProblem>,
) -> Result<T, ReadProblem> {
    let mut reader = flate2::read::MultiGzDecoder::new(packed);
    let mut head = Vec::with_capacity(format::HEAD);
    let begun = reader.by_ref().take(format::HEAD as u64).read_to_end(&mut head);
    if let Err(error) = begun
        && head.is_empty()
    {
        return Err(ReadProblem::Broken { format: Format::Gzip, reason: error.to_string() });
    }
    match Format::of(&head) {
        Format::Text => then(Opened::Text(Box::new(head.chain(reader)), None)),
        Format::Gzip => Err(ReadProblem::Unsupported(Format::Gzip)),
        other => {
            reader
                .read_to_end(&mut head)
                .map_err(|error| ReadProblem::Broken { format: Format::Gzip, reason: error.to_string() })?;
            let (source, format) = source(Input::of(head), other)?;
            then(Opened::Tables(source, format))
        }
    }
}

/// The tables of a format that is no text, and what it is more precisely.
fn source(input: Input, format: Format) -> Result<(Box<dyn TableSource>, Format), ReadProblem> {
    let bytes = |input: Input| input.into_bytes().map_err(ReadProblem::Io);
    let source: Box<dyn TableSource> = match format {
        Format::Wav => Box::new(wav::Sound::open(input)?),
        Format::Mat5 => Box::new(mat5::tables(&bytes(input)?)?),
        Format::Npy => Box::new(npy::tables(&bytes(input)?)?),
        Format::Zip => return archive::tables(bytes(input)?),
        #[cfg(feature = "excel")]
        Format::Xls => Box::new(crate::xls::tables(bytes(input)?)?),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => Box::new(crate::hdf5::tables(bytes(input)?)?),
        #[cfg(feature = "parquet")]
        Format::Parquet => Box::new(crate::parquet::Parquet::open(input)?),
        #[cfg(feature = "arrow")]
        Format::Arrow => Box::new(crate::arrow::Arrow::open(bytes(input)?)?),
        Format::Touchstone => Box::new(touchstone::tables(&bytes(input)?)?),
        Format::Tracker => Box::new(tracker::tables(&bytes(input)?)?),
        Format::NanoSurf => Box::new(nanosurf::tables(&bytes(input)?)?),
        other => return Err(ReadProblem::Unsupported(other)),
    };
    Ok((source, format))
}

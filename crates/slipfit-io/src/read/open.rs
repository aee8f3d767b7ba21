//! From a file or a stream of any format to its tables, with its fingerprint.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::Path,
    time::SystemTime,
};

use crate::tables::unpack::unpack;
use crate::{
    error::{ReadError, ReadProblem},
    format::{self, Format},
    formats::{self, json, mat5, nanosurf, npy, touchstone, tracker, wav},
    hashing::Hashing,
    input::Input,
    report::{Dialect, ReadReport},
    tables::{
        table::{self, LoadedTable, TableSource, Tables},
        text::Text,
    },
};

/// A file, a stream that can be read once, or bytes in memory.
pub(crate) enum Origin<'a> {
    File(File),
    Stream(Box<dyn Read + 'a>),
    /// Bytes in memory, with their SHA-256 in hexadecimal.
    Hashed(&'a [u8], String),
}

/// The format of a file, its dialect, its SHA-256 in hexadecimal and its length in bytes.
#[derive(Clone)]
pub(crate) struct Fingerprint {
    pub(super) format: Format,
    pub(super) dialect: Option<Dialect>,
    pub(super) sha256: String,
    pub(super) bytes: u64,
}

impl Fingerprint {
    /// Writes it into the report of a file with this name.
    pub(super) fn write(self, report: &mut ReadReport, name: &str) {
        name.clone_into(&mut report.path);
        report.format = self.format;
        // The dialect of the table read takes precedence, if there are several.
        report.dialect = report.dialect.take().or(self.dialect);
        (report.sha256, report.bytes) = (self.sha256, self.bytes);
    }
}

impl Origin<'_> {
    /// A file and its name; `-` is standard input. A pipe or a device, which is not a regular file, is read once.
    pub(crate) fn file(path: &Path) -> Result<(Self, String), ReadError> {
        if path.as_os_str() == "-" {
            return Ok((Self::Stream(Box::new(io::stdin().lock())), "standard input".to_owned()));
        }
        let name = path.display().to_string();
        let opened = File::open(path).and_then(|file| {
            let kind = file.metadata()?.file_type();
            if kind.is_dir() {
                return Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder"));
            }
            Ok(if kind.is_file() { Self::File(file) } else { Self::Stream(Box::new(file)) })
        });
        opened.map(|origin| (origin, name.clone())).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))
    }
}

/// All tables of a file of any format, with the first `most_rows` rows of each.
pub(crate) fn tables(origin: Origin<'_>, name: &str, most_rows: usize) -> Result<Tables, ReadError> {
    let (tables, fingerprint) = opened(origin, None, None, |source| gathered(source, most_rows))
        .map_err(|problem| ReadError::new(name, problem))?;
    Ok(described(tables, fingerprint, name))
}

/// The tables of a file with this name.
pub(super) fn described(tables: Vec<LoadedTable>, fingerprint: Fingerprint, name: &str) -> Tables {
    let Fingerprint { format, dialect, sha256, bytes } = fingerprint;
    let tables = tables.into_iter().map(Into::into).collect();
    Tables { path: name.to_owned(), format, sha256, bytes, dialect, tables }
}

/// All tables of a source, with the first `most_rows` rows of each.
pub(super) fn gathered(
    source: &mut dyn TableSource,
    most_rows: usize,
) -> Result<Vec<LoadedTable>, ReadProblem> {
    (0..source.heads().len()).map(|table| table::gather(source, table, most_rows)).collect()
}

/// Opens a file, in the given format if there is one, lets `then` read its tables, and also returns its fingerprint.
pub(super) fn opened<T>(
    origin: Origin<'_>,
    format: Option<Format>,
    watch: Option<&mut dyn FnMut(u64)>,
    then: impl FnOnce(&mut dyn TableSource) -> Result<T, ReadProblem>,
) -> Result<(T, Fingerprint), ReadProblem> {
    opened_in_part(origin, format, watch, usize::MAX, then)
}

/// As [`opened`], but only with the first `most_cells` cells of a sheet that is costly to decode.
pub(super) fn opened_in_part<T>(
    origin: Origin<'_>,
    given: Option<Format>,
    watch: Option<&mut dyn FnMut(u64)>,
    most_cells: usize,
    then: impl FnOnce(&mut dyn TableSource) -> Result<T, ReadProblem>,
) -> Result<(T, Fingerprint), ReadProblem> {
    let (reader, mut file, known): (Box<dyn Read>, Option<File>, Option<String>) = match origin {
        Origin::File(file) => (Box::new(file.try_clone().map_err(ReadProblem::Io)?), Some(file), None),
        Origin::Stream(reader) => (reader, None, None),
        Origin::Hashed(bytes, sha256) => (Box::new(bytes), None, Some(sha256)),
    };
    let size = file.as_ref().and_then(|file| file.metadata().ok()).map(|m| m.len());
    let watched = file.as_ref().and_then(|file| file.try_clone().ok());
    let before = watched.as_ref().and_then(stamp);
    let mut hashing = Hashing::new(reader, watch).known(known);
    let (head, whole) = beginning(&mut hashing);
    whole.map_err(ReadProblem::Io)?;
    let format = match (format_of(&head), given) {
        (Format::Gzip, _) => Format::Gzip,
        (told, given) => given.unwrap_or(told),
    };
    let source = match format {
        Format::Text => text(head.chain(&mut hashing), size),
        Format::Gzip => unpacked(head.chain(&mut hashing), given, most_cells),
        other => {
            // These formats need random access: a file is used directly, a stream is first read into memory.
            let input = match file.take() {
                Some(mut file) => {
                    io::copy(&mut hashing, &mut io::sink()).map_err(ReadProblem::Io)?;
                    file.seek(SeekFrom::Start(0)).map_err(ReadProblem::Io)?;
                    Input::File(file)
                }
                None => {
                    let mut bytes = head;
                    hashing.read_to_end(&mut bytes).map_err(ReadProblem::Io)?;
                    Input::of(bytes)
                }
            };
            source(input, other, most_cells)
        }
    };
    let done = source.and_then(|(mut source, format)| {
        let done = then(&mut *source)?;
        Ok((done, format, source.dialect(0)))
    });
    // The hash and the tables are read one after the other: both must be based on the same bytes.
    let is_stream = matches!(format, Format::Text | Format::Gzip);
    if !is_stream && before != watched.as_ref().and_then(stamp) {
        return Err(ReadProblem::Changed);
    }
    let (done, format, dialect) = done?;
    // Bytes after the samples belong to the file.
    io::copy(&mut hashing, &mut io::sink()).map_err(ReadProblem::Io)?;
    let (sha256, bytes) = hashing.finish();
    Ok((done, Fingerprint { format, dialect, sha256, bytes }))
}

/// Length and time of the last change.
fn stamp(file: &File) -> Option<(u64, SystemTime)> {
    let about = file.metadata().ok()?;
    Some((about.len(), about.modified().ok()?))
}

type Opened<'a> = (Box<dyn TableSource + 'a>, Format);

/// The bytes from which the format is detected, and whether reading them succeeded.
fn beginning(reader: &mut impl Read) -> (Vec<u8>, io::Result<usize>) {
    let mut head = Vec::with_capacity(format::HEAD);
    let whole = reader.take(format::HEAD as u64).read_to_end(&mut head);
    (head, whole)
}

fn text<'a>(reader: impl Read + 'a, size: Option<u64>) -> Result<Opened<'a>, ReadProblem> {
    Ok((Box::new(Text::open(reader, size)?), Format::Text))
}

/// Content of a gzip file: text is streamed, other formats are held in memory.
fn unpacked<'a>(
    packed: impl Read + 'a,
    given: Option<Format>,
    most_cells: usize,
) -> Result<Opened<'a>, ReadProblem> {
    let broken = |error: io::Error| Format::Gzip.broken(error);
    let mut reader = flate2::read::MultiGzDecoder::new(packed);
    let (head, whole) = beginning(&mut reader);
    if head.is_empty() {
        whole.map_err(broken)?;
    }
    match given.unwrap_or_else(|| format_of(&head)) {
        Format::Text => text(io::Cursor::new(head).chain(reader), None),
        Format::Gzip => Err(ReadProblem::Unsupported(Format::Gzip)),
        other => {
            let whole = unpack(io::Cursor::new(head).chain(reader)).map_err(broken)?;
            source(Input::of(whole), other, most_cells)
        }
    }
}

/// The format of a file that begins with `head`; text by default.
fn format_of(head: &[u8]) -> Format {
    Format::by_magic(head).unwrap_or_else(|| {
        if Format::is_universal(head) {
            Format::Universal
        } else if tracker::fits(head) {
            Format::Tracker
        } else if touchstone::fits(head) {
            Format::Touchstone
        } else if is_arrow_stream(head) {
            Format::Arrow
        } else {
            Format::by_structure(head).unwrap_or(Format::Text)
        }
    })
}

#[cfg(feature = "arrow")]
use formats::arrow::is_unmarked as is_arrow_stream;
#[cfg(not(feature = "arrow"))]
fn is_arrow_stream(_: &[u8]) -> bool {
    false
}

/// The tables of a format other than text, and the more precise format.
fn source<'a>(input: Input, format: Format, most_cells: usize) -> Result<Opened<'a>, ReadProblem> {
    let bytes = |input: Input| input.into_bytes().map_err(ReadProblem::Io);
    let source: Box<dyn TableSource> = match format {
        Format::Wav => Box::new(wav::Sound::open(input)?),
        Format::Mat5 => Box::new(mat5::tables(&bytes(input)?)?),
        Format::Npy => Box::new(npy::tables(&bytes(input)?)?),
        Format::Zip | Format::Npz | Format::Xlsx | Format::Ods => {
            let (tables, format) = formats::archive::tables(bytes(input)?, most_cells)?;
            return Ok((Box::new(tables), format));
        }
        #[cfg(feature = "excel")]
        Format::Xls => Box::new(formats::xls::tables(bytes(input)?)?),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => Box::new(formats::hdf5::tables(bytes(input)?)?),
        #[cfg(feature = "parquet")]
        Format::Parquet => Box::new(formats::parquet::Parquet::open(input)?),
        #[cfg(feature = "arrow")]
        Format::Arrow => Box::new(formats::arrow::Arrow::open(bytes(input)?)?),
        #[cfg(feature = "sound")]
        Format::Flac | Format::Mp3 | Format::Mp4 | Format::Ogg | Format::Aac => {
            Box::new(formats::sound::PackedSound::open(bytes(input)?, format)?)
        }
        Format::Json => Box::new(json::tables(&bytes(input)?)?),
        Format::Touchstone => Box::new(touchstone::tables(&bytes(input)?)?),
        Format::Tracker => Box::new(tracker::tables(&bytes(input)?)?),
        Format::NanoSurf => Box::new(nanosurf::tables(&bytes(input)?)?),
        other => return Err(ReadProblem::Unsupported(other)),
    };
    Ok((source, format))
}

//! Files in, records out.
//!
//! Measured oscillations come in the dialect of whatever logger, lock-in,
//! phone or spreadsheet wrote them. [`read`] finds out how a file is written,
//! which of its columns are time and signal and in which units, and returns a
//! [`slipfit::Record`] with a [`ReadReport`] that accounts for every choice
//! and every row.
//!
//! ```
//! use slipfit_io::{ReadOptions, read_text};
//! let mut file = String::from("Zeit t / s;Weg / mm\n");
//! for i in 0..100 {
//!     let t = 0.1 * f64::from(i);
//!     let x = 5.0 * (-0.2 * t).exp() * (3.0 * t).cos();
//!     file += &format!("{t:.1};{x:.3}\n").replace('.', ",");
//! }
//! let reading = read_text(file.as_bytes(), "swing.csv", &ReadOptions::default())?;
//! assert_eq!(reading.record.len(), 100);
//! assert_eq!(reading.record.unit(), "mm");
//! assert_eq!(reading.report.signal.why, "column 2 `Weg / mm`: named like a position");
//! # Ok::<(), slipfit_io::ReadError>(())
//! ```

mod error;
mod format;
mod hashing;
mod options;
mod report;
mod text;
mod wav;

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

pub use error::{ReadError, ReadProblem};
pub use format::Format;
pub use options::ReadOptions;
pub use report::{
    ColumnInfo, ColumnTaken, Decimal, Delimiter, Dialect, ReadReport, Reading, Skipped, TimeSource,
};

/// Reads a file of any format known.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Reading, ReadError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let file = File::open(path).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))?;
    let size = file.metadata().map(|m| m.len()).ok();
    dispatch(file, size, &name, None, options).map_err(|problem| ReadError::new(&name, problem))
}

/// Reads any format known from a stream; `name` stands for it in the report
/// and in errors.
///
/// The stream is read once, from front to back, and never held as a whole.
///
/// # Errors
/// As [`read`].
pub fn read_from(reader: impl Read, name: &str, options: &ReadOptions) -> Result<Reading, ReadError> {
    dispatch(reader, None, name, None, options).map_err(|problem| ReadError::new(name, problem))
}

/// Reads delimited text; `name` stands for it in the report and in errors.
///
/// The text is read once, from front to back, and never held as a whole: what
/// is kept are the samples and a window of some hundred kilobytes, of some
/// megabytes where columns without telling names must be told apart by their
/// numbers.
///
/// # Errors
/// As [`read`]; any other format is refused.
pub fn read_text(reader: impl Read, name: &str, options: &ReadOptions) -> Result<Reading, ReadError> {
    dispatch(reader, None, name, Some(Format::Text), options).map_err(|problem| ReadError::new(name, problem))
}

/// Tells the format, reads it and takes the fingerprint on the way.
fn dispatch(
    reader: impl Read,
    size: Option<u64>,
    name: &str,
    only: Option<Format>,
    options: &ReadOptions,
) -> Result<Reading, ReadProblem> {
    let mut hashing = hashing::Hashing::new(reader);
    let mut head = Vec::with_capacity(format::HEAD);
    hashing.by_ref().take(format::HEAD as u64).read_to_end(&mut head).map_err(ReadProblem::Io)?;
    let format = Format::of(&head);
    let whole = head.chain(&mut hashing);
    let mut reading = match format {
        Format::Text => text::read(whole, size, options)?,
        Format::Wav if only.is_none() => wav::read(whole, options)?,
        other => return Err(ReadProblem::Unsupported(other)),
    };
    // What follows the samples belongs to the file.
    io::copy(&mut hashing, &mut io::sink()).map_err(ReadProblem::Io)?;
    (reading.report.sha256, reading.report.bytes) = hashing.finish();
    name.clone_into(&mut reading.report.path);
    Ok(reading)
}

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

mod archive;
mod arrays;
#[cfg(feature = "arrow")]
mod arrow;
mod columns;
mod dispatch;
mod error;
mod format;
#[cfg(any(feature = "arrow", feature = "hdf5", feature = "parquet"))]
mod guard;
mod hashing;
#[cfg(feature = "hdf5")]
mod hdf5;
mod input;
mod mat5;
mod nanosurf;
mod npy;
mod options;
#[cfg(feature = "parquet")]
mod parquet;
mod report;
mod samples;
#[cfg(feature = "excel")]
mod sheet;
mod sweep;
mod table;
mod text;
mod touchstone;
mod tracker;
mod wav;
#[cfg(feature = "excel")]
mod xls;
#[cfg(feature = "excel")]
mod xlsx;

use std::{fs::File, io::Read, path::Path};

use dispatch::Origin;

pub use error::{ReadError, ReadProblem};
pub use format::Format;
#[cfg(any(feature = "arrow", feature = "hdf5", feature = "parquet"))]
pub use guard::panic_becomes_error;
pub use options::ReadOptions;
pub use report::{
    ColumnInfo, ColumnTaken, Decimal, Delimiter, Dialect, ReadReport, Reading, Skipped, TimeSource,
};
pub use sweep::{
    LevelOptions, LevelReading, Run, SweepOptions, SweepProblem, SweepReading, SweepReport, read_levels,
    read_sweep, read_sweep_from,
};
pub use table::{Column, Table, Tables};

/// Reads a file of any format known.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Reading, ReadError> {
    let (name, file) = open(path.as_ref())?;
    dispatch::record(Origin::File(file), &name, false, options, None).map_err(|p| ReadError::new(&name, p))
}

/// As [`read`], telling `watch` now and then how many bytes of the file have been read.
///
/// Text is decoded as it is read; other formats are decoded once all of their bytes have
/// passed.
///
/// # Errors
/// As [`read`].
///
/// ```
/// # let file = std::env::temp_dir().join(format!("watched-{}.csv", std::process::id()));
/// # std::fs::write(&file, "t (s),x (m)\n0,3\n1,-2\n2,3\n3,-2\n4,2\n5,-1\n6,1\n7,-1\n8,0\n")?;
/// let mut seen = 0;
/// let reading = slipfit_io::read_watched(&file, &Default::default(), &mut |bytes| seen = bytes)?;
/// assert_eq!(seen, reading.report.bytes);
/// # std::fs::remove_file(file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_watched(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    watch: &mut dyn FnMut(u64),
) -> Result<Reading, ReadError> {
    let (name, file) = open(path.as_ref())?;
    dispatch::record(Origin::File(file), &name, false, options, Some(watch))
        .map_err(|p| ReadError::new(&name, p))
}

/// Reads any format known from a stream; `name` stands for it in the report
/// and in errors.
///
/// Text, packed by gzip or not, is read once, from front to back, and never
/// held as a whole; other formats are, because they are read from several
/// places.
///
/// # Errors
/// As [`read`].
pub fn read_from(reader: impl Read, name: &str, options: &ReadOptions) -> Result<Reading, ReadError> {
    let origin = Origin::Stream(Box::new(reader));
    dispatch::record(origin, name, false, options, None).map_err(|problem| ReadError::new(name, problem))
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
    let origin = Origin::Stream(Box::new(reader));
    dispatch::record(origin, name, true, options, None).map_err(|problem| ReadError::new(name, problem))
}

/// All tables of a file of any format known, with every column of their first
/// `most_rows` rows, before anything is chosen from them.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
///
/// ```
/// let file = std::env::temp_dir().join(format!("sweep-{}.csv", std::process::id()));
/// std::fs::write(&file, "f (Hz),R (V)\n99,0.1\n100,0.7\n101,0.2\n")?;
/// let tables = slipfit_io::read_tables(&file, usize::MAX)?;
/// let sweep = &tables.tables[0];
/// assert_eq!((sweep.rows(), sweep.columns[0].unit.as_str()), (3, "Hz"));
/// assert_eq!(sweep.columns[1].values, [0.1, 0.7, 0.2]);
/// # std::fs::remove_file(file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_tables(path: impl AsRef<Path>, most_rows: usize) -> Result<Tables, ReadError> {
    let (name, file) = open(path.as_ref())?;
    dispatch::tables(Origin::File(file), &name, most_rows).map_err(|p| ReadError::new(&name, p))
}

/// As [`read_tables`], from a stream; `name` stands for it.
///
/// # Errors
/// As [`read_tables`].
pub fn read_tables_from(reader: impl Read, name: &str, most_rows: usize) -> Result<Tables, ReadError> {
    let origin = Origin::Stream(Box::new(reader));
    dispatch::tables(origin, name, most_rows).map_err(|problem| ReadError::new(name, problem))
}

fn open(path: &Path) -> Result<(String, File), ReadError> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))?;
    Ok((name, file))
}

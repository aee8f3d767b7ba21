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

use std::{fs::File, path::Path};

pub use error::{ReadError, ReadProblem};
pub use format::Format;
pub use options::ReadOptions;
pub use report::{
    ColumnInfo, ColumnTaken, Decimal, Delimiter, Dialect, ReadReport, Reading, Skipped, TimeSource,
};
pub use text::read_text;

/// Reads a file of any format known.
///
/// # Errors
/// [`ReadError`], naming the file and what would help.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Reading, ReadError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let file = File::open(path).map_err(|e| ReadError::new(&name, ReadProblem::Io(e)))?;
    let size = file.metadata().map(|m| m.len()).ok();
    text::read_sized(file, size, &name, options)
}

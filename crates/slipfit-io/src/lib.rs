//! Readers for measured files.
//!
//! Loggers, lock-ins, phones and spreadsheets write measured oscillations in many dialects. [`read`] detects the
//! dialect of a file, its columns of time and signal and their units, and returns a [`slipfit::Record`] with a
//! [`ReadReport`] that accounts for every choice and every row.
//!
//! ```
//! use slipfit_io::{ReadOptions, read_from};
//! let mut file = String::from("Zeit t / s;Weg / mm\n");
//! for i in 0..100 {
//!     let t = 0.1 * f64::from(i);
//!     let x = 5.0 * (-0.2 * t).exp() * (3.0 * t).cos();
//!     file += &format!("{t:.1};{x:.3}\n").replace('.', ",");
//! }
//! let reading = read_from(file.as_bytes(), "swing.csv", &ReadOptions::default())?;
//! assert_eq!(reading.record.len(), 100);
//! assert_eq!(reading.record.unit(), "mm");
//! let signal = reading.report.column("signal").expect("a record has a signal");
//! assert_eq!(signal.why, "column 2 `Weg / mm`: named like a position");
//! # Ok::<(), slipfit_io::ReadError>(())
//! ```

mod columns;
mod error;
mod format;
mod formats;
mod hashing;
mod input;
mod options;
mod read;
mod report;
mod stack;
mod tables;

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use read::open::Origin;

pub use error::{Needed, OptionProblem, ReadError, ReadProblem};
pub use format::Format;
pub use options::ReadOptions;
pub use read::glance::Glance;
pub use report::{
    ColumnInfo, ColumnTaken, Decimal, Delimiter, Dialect, DrivenRecord, LevelReading, Note, ReadReport,
    Reading, Skipped, SweepReading, TimeSource,
};
pub use stack::Stack;
#[cfg(any(feature = "arrow", feature = "hdf5", feature = "parquet", feature = "sound"))]
pub use tables::guard::panic_becomes_error;
pub use tables::table::{Column, Table, Tables};

/// Reads a record from a file of any known format; `-` is standard input.
///
/// A pipe or a device is read once, from start to end; formats that need random access are then held in memory, as by
/// [`read_from`].
///
/// # Errors
/// [`ReadError`], with the name of the file and hints.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Reading, ReadError> {
    let (origin, name) = Origin::file(path.as_ref())?;
    read::record::read(origin, &name, options, None)
}

/// As [`read`]; `watch` is called from time to time with the number of bytes of the file read so far.
///
/// Text is decoded while it is read; other formats are decoded after all of their bytes have been read.
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
    let (origin, name) = Origin::file(path.as_ref())?;
    read::record::read(origin, &name, options, Some(watch))
}

/// As [`read`], from a stream; `name` identifies it in the report and in errors.
///
/// Text, gzip-compressed or not, is read once, from start to end, and never held as a whole: only the samples and a
/// window of some megabytes are kept. Other formats are held in memory, because they need random access.
///
/// # Errors
/// As [`read`].
pub fn read_from(reader: impl Read, name: &str, options: &ReadOptions) -> Result<Reading, ReadError> {
    read::record::read(Origin::Stream(Box::new(reader)), name, options, None)
}

/// All tables of a file of any known format, with every column of their first `most_rows` rows, before any columns are
/// selected.
///
/// # Errors
/// [`ReadError`], with the name of the file and hints.
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
    let (origin, name) = Origin::file(path.as_ref())?;
    read::open::tables(origin, &name, most_rows)
}

/// As [`read_tables`], from a stream; `name` identifies it.
///
/// # Errors
/// As [`read_tables`].
pub fn read_tables_from(reader: impl Read, name: &str, most_rows: usize) -> Result<Tables, ReadError> {
    read::open::tables(Origin::Stream(Box::new(reader)), name, most_rows)
}

/// Content of a file and how it would be read: the first `most_rows` rows of its tables, the record with the options
/// `record` and, if `curve` is given, the curve over frequency.
///
/// Nothing is analysed. Only the first thousands of cells of each sheet of a workbook are read.
///
/// # Errors
/// [`ReadError`] if the file contains no table.
///
/// ```
/// # let file = std::env::temp_dir().join(format!("glance-{}.csv", std::process::id()));
/// std::fs::write(&file, "f (Hz),R (V)\n99,0.1\n100,0.7\n101,0.2\n")?;
/// let options = slipfit_io::ReadOptions::default();
/// let seen = slipfit_io::glance(&file, 1000, &options, Some(&options))?;
/// assert!(seen.record.is_err());
/// assert!(seen.curve.is_some_and(|c| c.report.named));
/// # std::fs::remove_file(file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn glance(
    path: impl AsRef<Path>,
    most_rows: usize,
    record: &ReadOptions,
    curve: Option<&ReadOptions>,
) -> Result<Glance, ReadError> {
    let (origin, name) = Origin::file(path.as_ref())?;
    read::glance::glance(origin, &name, most_rows, record, curve)
}

/// As [`glance`], from a stream; `name` identifies it.
///
/// # Errors
/// As [`glance`].
///
/// ```
/// let file = "f (Hz),R (V)\n99,0.1\n100,0.7\n101,0.2\n";
/// let options = slipfit_io::ReadOptions::default();
/// let seen = slipfit_io::glance_from(file.as_bytes(), "sweep.csv", 1000, &options, Some(&options))?;
/// assert_eq!((seen.tables.tables[0].columns.len(), seen.curve.is_some()), (2, true));
/// # Ok::<(), slipfit_io::ReadError>(())
/// ```
pub fn glance_from(
    reader: impl Read,
    name: &str,
    most_rows: usize,
    record: &ReadOptions,
    curve: Option<&ReadOptions>,
) -> Result<Glance, ReadError> {
    read::glance::glance(Origin::Stream(Box::new(reader)), name, most_rows, record, curve)
}

/// The files of a folder in the order of their names, without hidden files and without folders.
///
/// # Errors
/// The folder cannot be read.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("swings-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// for name in ["b.csv", "a.csv", ".hidden"] {
///     std::fs::write(folder.join(name), "")?;
/// }
/// assert_eq!(slipfit_io::files_in(&folder)?, [folder.join("a.csv"), folder.join("b.csv")]);
/// # std::fs::remove_dir_all(folder)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn files_in(folder: impl AsRef<Path>) -> std::io::Result<Vec<PathBuf>> {
    read::driven::files(folder.as_ref())
}

/// Reads a resonance curve: from one file that contains it, or from several files or a folder of driven records, one
/// per frequency.
///
/// # Errors
/// [`ReadError`], with the name of the file and hints.
pub fn read_sweep(paths: &[PathBuf], options: &ReadOptions) -> Result<SweepReading, ReadError> {
    read::curve::read_paths(paths, options)
}

/// Reads a resonance curve from a stream; `name` identifies it in the report and in errors.
///
/// # Errors
/// As [`read_sweep`].
///
/// ```
/// use slipfit_io::{ReadOptions, read_sweep_from};
/// let file = "f (kHz);R (dBm);phi (deg)\n32,5;-40;-10\n32,75;-20;-90\n33;-40;-170\n";
/// let reading = read_sweep_from(file.as_bytes(), "fork.csv", &ReadOptions::default())?;
/// assert_eq!(reading.curve.frequency_hz(), [32500.0, 32750.0, 33000.0]);
/// assert!((reading.curve.response().amplitude(1) - 0.1).abs() < 1e-12);
/// assert_eq!(reading.curve.unit(), "√mW");
/// # Ok::<(), slipfit_io::ReadError>(())
/// ```
pub fn read_sweep_from(
    reader: impl Read,
    name: &str,
    options: &ReadOptions,
) -> Result<SweepReading, ReadError> {
    read::curve::read(Origin::Stream(Box::new(reader)), name, options)
}

/// Factor from numbers in the unit `from` to numbers in the unit `to`; `None` if they are not known to be units of the
/// same quantity (length, angle, time, frequency, voltage, current, conductance, resistance, force, mass, pressure,
/// power, and products of the usual ones).
///
/// ```
/// assert_eq!(slipfit_io::unit_factor("mm", "m"), Some(1e-3));
/// assert_eq!(slipfit_io::unit_factor("mm/N", "m/N"), Some(1e-3));
/// assert_eq!(slipfit_io::unit_factor("mbar", "hPa"), Some(1.0));
/// assert_eq!(slipfit_io::unit_factor("kN/m", "kg/s^2"), Some(1e3));
/// assert_eq!(slipfit_io::unit_factor("V", "m"), None);
/// ```
#[must_use]
pub fn unit_factor(from: &str, to: &str) -> Option<f64> {
    columns::units::ratio(from.trim(), to.trim())
}

/// The unit in the name of a column, as extracted from headers; `None` if the name contains no known unit: a word in
/// brackets may be anything else.
///
/// ```
/// use slipfit_io::unit_of_name;
/// assert_eq!(unit_of_name("time (ms)").as_deref(), Some("ms"));
/// assert_eq!(unit_of_name("t/ms").as_deref(), Some("ms"));
/// assert_eq!(unit_of_name("f [kHz]").as_deref(), Some("kHz"));
/// assert_eq!(unit_of_name("time (local)"), None);
/// assert_eq!(unit_of_name("time"), None);
/// ```
#[must_use]
pub fn unit_of_name(name: &str) -> Option<String> {
    Some(columns::name::Name::parse(name).unit).filter(|unit| columns::units::is_known(unit))
}

/// The unit of the amplitudes `10^(x/20)` of levels `x` in this unit; `None` if it is not a unit of levels.
///
/// ```
/// use slipfit_io::unit_of_levels;
/// assert_eq!(unit_of_levels("dBV"), Some("V"));
/// assert_eq!(unit_of_levels("dB"), Some(""));
/// assert_eq!(unit_of_levels("V"), None);
/// ```
#[must_use]
pub fn unit_of_levels(unit: &str) -> Option<&'static str> {
    columns::units::linear_unit(unit.trim())
}

/// Decodes bytes of a file as headers are decoded: UTF-8, else Windows-1252.
///
/// ```
/// assert_eq!(slipfit_io::text_of(b"Gr\xf6\xdfe (\xb5m)"), "Größe (µm)");
/// ```
#[must_use]
pub fn text_of(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    tables::text::decoded(bytes)
}

/// Reads drive levels and the resulting amplitudes.
///
/// A table that also has a column of frequencies holds one curve per level; the height of its peak is used
/// ([`slipfit::levels::peak_height`]), or the largest amplitude if the points do not determine it.
///
/// # Errors
/// [`ReadError`], with the name of the file and hints.
pub fn read_levels(path: impl AsRef<Path>, options: &ReadOptions) -> Result<LevelReading, ReadError> {
    let (origin, name) = Origin::file(path.as_ref())?;
    read::levels::read(origin, &name, options)
}

/// As [`read_levels`], from a stream; `name` identifies it.
///
/// # Errors
/// As [`read_levels`].
pub fn read_levels_from(
    reader: impl Read,
    name: &str,
    options: &ReadOptions,
) -> Result<LevelReading, ReadError> {
    read::levels::read(Origin::Stream(Box::new(reader)), name, options)
}

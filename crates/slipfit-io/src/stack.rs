//! Arrays of three dimensions with a trace in each pixel, read in parts.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use crate::error::{ReadError, ReadProblem};
use crate::format::Format;
use crate::formats::npy;
use crate::tables::binary::Stored;

/// An open array of three dimensions; its numbers remain in the file until they are requested.
///
/// Supported are NumPy's `.npy` in C order, data sets of HDF5, and arrays of zarr, which are folders.
pub struct Stack {
    file: String,
    shape: [usize; 3],
    unit: String,
    source: Source,
}

enum Source {
    Npy {
        file: File,
        first: u64,
        stored: Stored,
    },
    #[cfg(feature = "hdf5")]
    Hdf5(Box<crate::formats::hdf5::Cube>),
    #[cfg(feature = "zarr")]
    Zarr(crate::formats::zarr::Cube),
}

impl Stack {
    /// Opens an array; `name` is its path in an HDF5 file or a zarr store with several three-dimensional arrays.
    ///
    /// # Errors
    /// [`ReadError`] if the file cannot be read, has another format, or contains no such array or several.
    pub fn open(path: impl AsRef<Path>, name: Option<&str>) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let opened = opened(path, name);
        let (shape, unit, source) = opened.map_err(|problem| ReadError::new(&file, problem))?;
        Ok(Self { file, shape, unit, source })
    }

    /// Lengths along the three axes, in the order of the file.
    pub fn shape(&self) -> [usize; 3] {
        self.shape
    }

    /// The unit that the file states for its numbers; empty if none.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The numbers within a range of indices along `axis`, 0 or 1, and over the full length of the other axes, in C
    /// order.
    ///
    /// # Errors
    /// [`ReadError`] for a range outside the array, an axis along which it cannot be read in parts, or a file that ends
    /// early or violates its format.
    pub fn part(&mut self, axis: usize, range: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let shape = self.shape;
        let read = if axis > 1 || range.start > range.end || range.end > shape[axis] {
            let reason = format!("there is no part {range:?} of axis {axis} of an array of {shape:?}");
            Err(ReadProblem::NoStack { reason })
        } else {
            match &mut self.source {
                Source::Npy { file, first, stored } => npy_part(file, *first, *stored, shape, axis, range),
                #[cfg(feature = "hdf5")]
                Source::Hdf5(cube) => cube.part(axis, range),
                #[cfg(feature = "zarr")]
                Source::Zarr(cube) => cube.part(axis, range),
            }
        };
        read.map_err(|problem| ReadError::new(&self.file, problem))
    }
}

impl std::fmt::Debug for Stack {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { file, shape, unit, .. } = self;
        f.debug_struct("Stack").field("file", file).field("shape", shape).field("unit", unit).finish()
    }
}

/// Maximum number of bytes of a NumPy header.
const HEADER: u64 = 1 << 16;

fn opened(path: &Path, name: Option<&str>) -> Result<([usize; 3], String, Source), ReadProblem> {
    #[cfg(feature = "zarr")]
    if path.is_dir() {
        let (shape, unit, cube) = crate::formats::zarr::cube(path, name)?;
        return Ok((shape, unit, Source::Zarr(cube)));
    }
    let mut file = File::open(path).map_err(ReadProblem::Io)?;
    let mut head = Vec::new();
    file.by_ref().take(HEADER).read_to_end(&mut head).map_err(ReadProblem::Io)?;
    if head.is_empty() {
        return Err(ReadProblem::Empty);
    }
    if head.starts_with(b"\x93NUMPY") {
        if let Some(name) = name {
            let reason = format!("{name:?} names an array, and a .npy file holds one without a name");
            return Err(ReadProblem::NoStack { reason });
        }
        let (shape, stored, first) = npy::cube(&head)?;
        let length = file.metadata().map_err(ReadProblem::Io)?.len();
        let numbers = shape.iter().try_fold(stored.bytes as u64, |n, d| n.checked_mul(*d as u64));
        if numbers.and_then(|n| n.checked_add(first)).is_none_or(|needed| needed > length) {
            return Err(Format::Npy.broken("it ends before the numbers that its header names"));
        }
        return Ok((shape, String::new(), Source::Npy { file, first, stored }));
    }
    #[cfg(feature = "hdf5")]
    if Format::by_magic(&head) == Some(Format::Hdf5) {
        let (shape, unit, cube) = crate::formats::hdf5::cube(path, name)?;
        return Ok((shape, unit, Source::Hdf5(Box::new(cube))));
    }
    let _ = name;
    Err(ReadProblem::NoStack { reason: "it is neither a .npy file nor HDF5 nor a zarr store".to_owned() })
}

fn npy_part(
    file: &mut File,
    first: u64,
    stored: Stored,
    [planes, rows, columns]: [usize; 3],
    axis: usize,
    range: Range<usize>,
) -> Result<Vec<f64>, ReadProblem> {
    // Whole planes are contiguous; rows are contiguous within each plane.
    let (stretches, step, unit) =
        if axis == 0 { (1, 0, rows * columns) } else { (planes, rows * columns, columns) };
    let length = range.len() * unit;
    let mut bytes = vec![0; length * stored.bytes];
    let mut values = Vec::with_capacity(stretches * length);
    for stretch in 0..stretches {
        let begin = (stretch * step + range.start * unit) as u64 * stored.bytes as u64;
        file.seek(SeekFrom::Start(first + begin)).map_err(ReadProblem::Io)?;
        file.read_exact(&mut bytes).map_err(ReadProblem::Io)?;
        values.extend(bytes.chunks_exact(stored.bytes).map(|number| stored.read(number)));
    }
    Ok(values)
}

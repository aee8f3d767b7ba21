//! Tables of named columns: their sources, tables made from arrays and sheets, and text.

pub(crate) mod arrays;
pub(crate) mod binary;
#[cfg(feature = "excel")]
mod cell;
#[cfg(any(feature = "arrow", feature = "hdf5", feature = "parquet", feature = "sound"))]
pub(crate) mod guard;
#[cfg(any(feature = "hdf5", feature = "zarr"))]
pub(crate) mod known;
#[cfg(feature = "excel")]
pub(crate) mod sheet;
#[cfg(feature = "excel")]
mod side_cells;
pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod unpack;

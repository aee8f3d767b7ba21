//! File formats, one module each: from bytes to tables of named columns.

pub(crate) mod archive;
#[cfg(feature = "arrow")]
pub(crate) mod arrow;
#[cfg(feature = "hdf5")]
pub(crate) mod hdf5;
pub(crate) mod json;
pub(crate) mod mat5;
pub(crate) mod nanosurf;
pub(crate) mod npy;
#[cfg(feature = "excel")]
pub(crate) mod ods;
#[cfg(feature = "excel")]
mod package;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
#[cfg(feature = "sound")]
pub(crate) mod sound;
pub(crate) mod touchstone;
pub(crate) mod tracker;
pub(crate) mod wav;
#[cfg(feature = "excel")]
pub(crate) mod xls;
#[cfg(feature = "excel")]
pub(crate) mod xlsx;
#[cfg(feature = "zarr")]
pub(crate) mod zarr;

//! `slipfit map`.

use super::{ReplaceArgs, value::positive};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Examples:
  slipfit map stack.npy --dt 1e-3 --table map.csv --plot map.png
      viscous and sliding loss in each pixel of an array of shape (y, x, t)
  slipfit map scan.h5 --data /forward/amplitude --dt 1e-3 --frequency-hz 75e3 --resume blocks --table map.npy
      a data set larger than memory; after an interruption the same command goes on";

/// Viscous and sliding loss of a trace in each pixel, as images.
///
/// Reads an array of three axes from NumPy's .npy, HDF5 or zarr, some tens of megabytes at a time, and fits
/// viscous and sliding loss to every pixel. A pixel that cannot be fitted is reported with the reason.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct MapArgs {
    /// An array of three axes, two of pixels and one of time: .npy, HDF5 or the folder of a zarr store
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    /// Path of the data set, if an HDF5 file or a zarr store has several of three axes
    #[arg(long, value_name = "PATH", help_heading = "Reading")]
    pub(crate) data: Option<String>,

    /// Sampling interval [s]
    #[arg(long, value_name = "S", value_parser = positive, help_heading = "Reading")]
    pub(crate) dt: f64,

    /// The time axis: 0, 1 or 2
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=2), default_value_t = 2, help_heading = "Reading")]
    pub(crate) axis: u8,

    /// Unit of the numbers, such as nm, V, dBm; that of the file unless given. Levels in dB become amplitudes
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    pub(crate) unit: Option<String>,

    /// What the numbers are
    #[arg(long, value_enum, default_value = "amplitude", help_heading = "Reading")]
    pub(crate) kind: Kind,

    /// One fit to amplitudes, or the whole analysis of each pixel
    #[arg(long, value_enum, default_value = "fit", help_heading = "Analysis")]
    pub(crate) method: Method,

    /// Frequency of the oscillation [Hz], which amplitudes do not contain: converts rates to friction
    /// displacements
    #[arg(long, value_name = "F", value_parser = positive, help_heading = "Analysis")]
    pub(crate) frequency_hz: Option<f64>,

    /// Use amplitudes up to the first one below this value, in their unit
    #[arg(long, value_name = "A", value_parser = positive, help_heading = "Analysis")]
    pub(crate) min_amplitude: Option<f64>,

    /// One row per pixel: .csv or .arrow; one image per column: .npy or .zarr
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) table: Option<PathBuf>,

    /// Draw images with their colour bars and histograms; .png, or .svg, which shows the trace of the pixel under
    /// the pointer
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,

    /// Keep finished blocks in this folder, and reuse those with the same numbers and options
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub(crate) resume: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,

    /// Print nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

/// What the numbers of a stack are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    Amplitude,
    Displacement,
    Velocity,
    Acceleration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    Fit,
    Analyse,
}

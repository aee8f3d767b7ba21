//! `slipfit ringdown`.

use super::{AnswerArgs, ReadingArgs, TableArgs, Uncertain, finite, positive};
use clap::Args;
use slipfit::Calibration;
use slipfit::LossModel;
use slipfit::ringdown::{LowPass, Options};
use std::path::{Path, PathBuf};

const AFTER_HELP: &str = "\
Examples:
  slipfit ringdown swing.csv
      reads the file as it is, finds the free decay, answers
  slipfit ringdown scope.txt --rate-hz 1000 --signal 3
      a file without a time column; the signal is its third column
  slipfit ringdown fork.csv --stiffness 12000±300 --plot fork.svg
      forces in newtons, and a picture of the fit
  slipfit ringdown beam.csv --band 70 90
      one of several modes
  slipfit ringdown lockin.csv --frequency-hz 32700 --lockin-time-constant 1e-3 --lockin-order 4
      an amplitude recorded behind a lock-in's low-pass
  slipfit ringdown swing.csv --html swing.html
      a report to hand in: one page with pictures, equations and sources
  slipfit ringdown runs/*.csv --table runs.md --plot runs.svg
      many files at once, one row each, and a picture across them
  slipfit ringdown swing.csv --json - | jq .sliding
      the answer for a script";

/// Viscous and sliding loss from a measured free decay.
///
/// Reads text of any dialect, sound, workbooks, MATLAB, NumPy, HDF5, Parquet and
/// more, and says which columns it took and why; slipfit inspect shows a file.
/// Finds the free decay in the record by itself (a driven lead-in, a jolt, rest
/// and noise at the end are left out), fits viscous, sliding and drag losses
/// alone and together, and reports the model the data prefer with the evidence
/// for it. The frequency may change with amplitude and the offset may drift.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct RingdownArgs {
    /// The record, in any format that is known; several make a table
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) reading: ReadingArgs,

    /// Use nothing before this instant [s]
    #[arg(long, value_name = "S", value_parser = finite, allow_negative_numbers = true, help_heading = "Analysis")]
    start: Option<f64>,

    /// Use nothing after this instant [s]
    #[arg(long, value_name = "S", value_parser = finite, allow_negative_numbers = true, help_heading = "Analysis")]
    end: Option<f64>,

    /// Follow the decay down to this amplitude only [unit of the signal]
    #[arg(long, value_name = "A", value_parser = positive, help_heading = "Analysis")]
    min_amplitude: Option<f64>,

    /// Only oscillations between these frequencies [Hz]
    #[arg(long, num_args = 2, value_names = ["LO", "HI"], value_parser = positive, help_heading = "Analysis")]
    band: Option<Vec<f64>>,

    /// Report this model, whichever the data prefer: viscous, sliding, viscous+sliding, viscous+drag,
    /// sliding+drag, viscous+sliding+drag
    #[arg(long, value_name = "NAME", help_heading = "Analysis")]
    model: Option<LossModel>,

    /// Time constant of the lock-in's output filter [s]
    #[arg(
        long,
        value_name = "S",
        value_parser = positive,
        requires = "lockin_order",
        help_heading = "Analysis"
    )]
    lockin_time_constant: Option<f64>,

    /// Order of that filter: 1 for 6 dB/octave, 4 for 24 dB/octave
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=8),
        requires = "lockin_time_constant",
        help_heading = "Analysis"
    )]
    lockin_order: Option<u32>,

    /// Frequency of the oscillation [Hz], where the record holds amplitudes only
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Analysis")]
    frequency_hz: Option<f64>,

    #[command(flatten)]
    calibration: CalibrationArgs,

    #[command(flatten)]
    pub(crate) out: AnswerArgs,

    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// At most one mechanical constant.
#[derive(Debug, Args)]
#[group(multiple = false)]
pub(crate) struct CalibrationArgs {
    /// Stiffness k [N/m], for a displacement in m: 12000, 12000±300, 12000(300)
    #[arg(long, value_name = "K", allow_negative_numbers = true, help_heading = "Forces")]
    stiffness: Option<Uncertain>,

    /// Mass m [kg], for a displacement in m
    #[arg(long, value_name = "M", allow_negative_numbers = true, help_heading = "Forces")]
    mass: Option<Uncertain>,

    /// Torsion stiffness [N m/rad], for an angle
    #[arg(long, value_name = "K", allow_negative_numbers = true, help_heading = "Forces")]
    torsion_stiffness: Option<Uncertain>,

    /// Moment of inertia [kg m²], for an angle
    #[arg(long, value_name = "I", allow_negative_numbers = true, help_heading = "Forces")]
    inertia: Option<Uncertain>,
}

impl RingdownArgs {
    /// Every file that is read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(PathBuf::as_path)
    }

    pub(crate) fn options(&self) -> Options {
        let mut options = Options::default();
        options.start_s = self.start;
        options.end_s = self.end;
        options.min_amplitude = self.min_amplitude;
        options.band_hz = match self.band.as_deref() {
            Some(&[low, high]) => Some([low, high]),
            _ => None,
        };
        options.model = self.model;
        options.lockin = self
            .lockin_time_constant
            .zip(self.lockin_order)
            .map(|(time_constant_s, order)| LowPass { time_constant_s, order });
        options.frequency_hz = self.frequency_hz;
        options.calibration = self.calibration.constant();
        options
    }

    /// The flag of the calibration given, and whether it is meant for angles.
    pub(crate) fn calibration_flag(&self) -> Option<(&'static str, bool)> {
        self.calibration.flag()
    }
}

impl CalibrationArgs {
    /// The flag of the calibration given, and whether it is meant for angles.
    pub(crate) fn flag(&self) -> Option<(&'static str, bool)> {
        [
            (self.stiffness.is_some(), "--stiffness", false),
            (self.mass.is_some(), "--mass", false),
            (self.torsion_stiffness.is_some(), "--torsion-stiffness", true),
            (self.inertia.is_some(), "--inertia", true),
        ]
        .into_iter()
        .find_map(|(given, flag, angular)| given.then_some((flag, angular)))
    }

    pub(crate) fn constant(&self) -> Option<Calibration> {
        let stiffness = self.stiffness.or(self.torsion_stiffness);
        let mass = self.mass.or(self.inertia);
        stiffness
            .map(|u| Calibration::Stiffness { value: u.value, std_error: u.std_error })
            .or_else(|| mass.map(|u| Calibration::Mass { value: u.value, std_error: u.std_error }))
    }
}

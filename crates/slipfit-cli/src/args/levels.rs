//! `slipfit levels`.

use super::AnswerArgs;
use super::calibration::CalibrationArgs;
use super::value::{FormatName, Positive, Text, Uncertain, number, text};
use clap::Args;
use serde::Deserialize;
use slipfit::levels::Options;
use slipfit_io::ReadOptions;
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Examples:
  slipfit levels levels.csv
      threshold and slope; with drive and amplitude both lengths or both angles also Q and x_F
  slipfit levels lockin.csv --drive 1 --amplitude 3 --drive-gain 2.4e-9±0.1e-9
      a drive in volts, each 2.4 nm at the base
  slipfit levels lockin.csv --q 9300±200 --frequency-hz 32757 --stiffness 12000
      the same with Q from a ring-down, and forces";

/// Sliding friction from amplitudes at resonance against the drive level.
///
/// Without sliding friction, the amplitude is proportional to the drive. With it, the line has the same slope but
/// begins at a threshold 4F/(pi k), below which the mass sticks. Reads one row for each level, or one curve for
/// each level, of which the peak height is used.
#[derive(Debug, Args)]
#[command(name = "levels", after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct LevelFitArgs {
    /// The table: drive levels and amplitudes
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    #[command(flatten)]
    pub(crate) reading: LevelReadingArgs,

    #[command(flatten)]
    pub(crate) analysis: LevelAnalysisArgs,

    #[command(flatten)]
    pub(crate) calibration: CalibrationArgs,

    #[command(flatten)]
    pub(crate) out: AnswerArgs,
}

// Columns and units of levels.
#[derive(Debug, Clone, Default, Args, Deserialize)]
#[serde(default)]
pub(crate) struct LevelReadingArgs {
    /// Format, if the first bytes do not identify it: text, mat, hdf5, parquet, arrow, ...
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    format: Option<FormatName>,

    /// Column of the drive levels, by number (from 1) or name
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    drive: Option<Text>,

    /// Column of the amplitudes
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    amplitude: Option<Text>,

    /// Column of the real part (X of a lock-in): the amplitude is the modulus of both
    #[arg(long, value_name = "COL", conflicts_with = "amplitude", help_heading = "Reading")]
    real: Option<Text>,

    /// Column of the imaginary part (Y of a lock-in)
    #[arg(long, value_name = "COL", conflicts_with = "amplitude", help_heading = "Reading")]
    imaginary: Option<Text>,

    /// Column of the standard errors of the amplitudes
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    std_error: Option<Text>,

    /// Unit of the amplitudes, such as nm, V, dB
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    unit: Option<Text>,

    /// Unit of the drive levels
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    drive_unit: Option<Text>,

    /// Which of several sheets, variables or groups: name, part of the name, or number
    #[arg(long, value_name = "NAME", help_heading = "Reading")]
    sheet: Option<Text>,
}

// Independently known quantities.
#[derive(Debug, Clone, Default, Args, Deserialize)]
#[serde(default)]
pub(crate) struct LevelAnalysisArgs {
    /// Frequency of the resonance [Hz], for the decay rate
    #[arg(long, value_name = "HZ", help_heading = "Analysis")]
    frequency_hz: Option<Positive>,

    /// Drive amplitude at the base, in the unit of the amplitudes, per unit of the drive level, such as
    /// 2.4e-9±0.1e-9
    #[arg(long, value_name = "G", conflicts_with = "q", help_heading = "Analysis")]
    drive_gain: Option<Uncertain>,

    /// Quality factor of the viscous loss, instead of --drive-gain
    #[arg(long, value_name = "Q", help_heading = "Analysis")]
    q: Option<Uncertain>,
}

impl LevelFitArgs {
    /// All options of the analysis.
    pub(crate) fn options(&self) -> Options {
        let mut options = self.analysis.options();
        options.calibration = self.calibration.constant();
        options
    }
}

impl LevelReadingArgs {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.format.as_ref().map(|f| f.format),
            drive: text(&self.drive),
            amplitude: text(&self.amplitude),
            real: text(&self.real),
            imaginary: text(&self.imaginary),
            std_error: text(&self.std_error),
            unit: text(&self.unit),
            drive_unit: text(&self.drive_unit),
            sheet: text(&self.sheet),
            ..ReadOptions::default()
        }
    }
}

impl LevelAnalysisArgs {
    /// All options except the calibration.
    pub(crate) fn options(&self) -> Options {
        let pair = |u: Option<Uncertain>| u.map(|u| [u.value, u.std_error]);
        let mut options = Options::default();
        options.frequency_hz = number(self.frequency_hz);
        options.drive_gain = pair(self.drive_gain);
        options.q_factor = pair(self.q);
        options
    }
}

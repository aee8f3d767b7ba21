//! `slipfit ringdown`.

use super::calibration::CalibrationArgs;
use super::value::{Finite, Law, Loss, Positive, band, model_help, number};
use super::{AnswerArgs, ReadingArgs, TableArgs};
use crate::failure::Failure;
use clap::Args;
use glob::Pattern;
use serde::Deserialize;
use slipfit::ringdown::{LowPass, Options};
use std::path::PathBuf;

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
  slipfit ringdown runs --glob '*.csv' --table runs.csv
      every file of a folder
  slipfit ringdown swing.csv --json - | jq .sliding
      the answer for a script
  logger | slipfit ringdown -
      a record from standard input";

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
    /// The record, in any supported format, `-` for standard input; several, or a folder, make a table
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    /// In folders, read only files with such names, such as '*.csv'
    #[arg(long, value_name = "PATTERN", value_parser = Pattern::new, help_heading = "Reading")]
    pub(crate) glob: Option<Pattern>,

    #[command(flatten)]
    pub(crate) reading: ReadingArgs,

    #[command(flatten)]
    pub(crate) analysis: RingdownAnalysisArgs,

    #[command(flatten)]
    pub(crate) calibration: CalibrationArgs,

    #[command(flatten)]
    pub(crate) out: AnswerArgs,

    #[command(flatten)]
    pub(crate) table: TableArgs,
}

// Options fixed before the analysis.
#[derive(Debug, Clone, Default, Args, Deserialize)]
#[serde(default)]
pub(crate) struct RingdownAnalysisArgs {
    /// Use nothing before this time [s]
    #[arg(long, value_name = "S", help_heading = "Analysis")]
    start: Option<Finite>,

    /// Use nothing after this time [s]
    #[arg(long, value_name = "S", help_heading = "Analysis")]
    end: Option<Finite>,

    /// Follow the decay only down to this amplitude [unit of the signal]
    #[arg(long, value_name = "A", help_heading = "Analysis")]
    min_amplitude: Option<Positive>,

    /// Use only oscillations between these frequencies [Hz]
    #[arg(long, num_args = 2, value_names = ["LO", "HI"], help_heading = "Analysis")]
    band: Option<Vec<Positive>>,

    // Its help is generated from the list of loss terms.
    #[arg(long, help = model_help(false), value_name = "NAME", help_heading = "Analysis")]
    model: Option<Loss>,

    /// Also draw the loss against amplitude without a model, with its confidence band: free, or rising to require
    /// a loss that grows with the amplitude
    #[arg(long, value_name = "LAW", help_heading = "Analysis")]
    law: Option<Law>,

    /// Time constant of the lock-in's output filter [s]
    #[arg(long, value_name = "S", requires = "lockin_order", help_heading = "Analysis")]
    lockin_time_constant: Option<Positive>,

    /// Order of that filter: 1 for 6 dB/octave, 4 for 24 dB/octave
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=8),
        requires = "lockin_time_constant",
        help_heading = "Analysis"
    )]
    lockin_order: Option<u32>,

    /// Frequency of the oscillation [Hz], if the record holds amplitudes only
    #[arg(long, value_name = "HZ", help_heading = "Analysis")]
    frequency_hz: Option<Positive>,
}

impl RingdownArgs {
    /// Checks that a pattern is given together with a folder: it does not apply to files that are named.
    pub(crate) fn check_glob(&self) -> Result<(), Failure> {
        let Some(pattern) = &self.glob else { return Ok(()) };
        // A path that does not exist is refused when it is read.
        let is_file = |path: &PathBuf| path.as_os_str() == "-" || path.exists() && !path.is_dir();
        if !self.files.iter().all(is_file) {
            return Ok(());
        }
        Err(Failure::new(format!("--glob {pattern}: selects files in folders, and no folder is given"))
            .hint("give the folder, with the pattern in quotes so that the shell does not replace it; or leave --glob out"))
    }

    /// All files that are read, with each folder replaced by the files in it. A folder that is empty or cannot be
    /// read stays, and its row reports that.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let fits = |file: &PathBuf| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            self.glob.as_ref().is_none_or(|pattern| pattern.matches(&name))
        };
        let files = |path: &PathBuf| match slipfit_io::files_in(path) {
            Ok(files) if path.is_dir() => {
                let fitting: Vec<PathBuf> = files.into_iter().filter(fits).collect();
                if fitting.is_empty() { vec![path.clone()] } else { fitting }
            }
            _ => vec![path.clone()],
        };
        self.files.iter().flat_map(files).collect()
    }

    /// All options fixed before the analysis.
    pub(crate) fn options(&self) -> Options {
        let mut options = self.analysis.options();
        options.calibration = self.calibration.constant();
        options
    }
}

impl RingdownAnalysisArgs {
    /// All options except the calibration.
    pub(crate) fn options(&self) -> Options {
        let mut options = Options::default();
        options.start_s = self.start.map(|t| t.0);
        options.end_s = self.end.map(|t| t.0);
        options.min_amplitude = number(self.min_amplitude);
        options.band_hz = band(self.band.as_deref());
        options.model = self.model.map(|m| m.0);
        options.law = self.law.map(|l| l.0);
        options.lockin = self
            .lockin_time_constant
            .zip(self.lockin_order)
            .map(|(time_constant, order)| LowPass { time_constant_s: time_constant.0, order });
        options.frequency_hz = number(self.frequency_hz);
        options
    }
}

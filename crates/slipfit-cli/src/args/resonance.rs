//! `slipfit resonance`.

use super::curve::CurveArgs;
use super::ringdown::CalibrationArgs;
use super::{AnswerArgs, TableArgs, Uncertain, positive};
use clap::{Args, ValueEnum};
use slipfit::LossModel;
use slipfit::resonance::{DriveAmplitude, Method, Options, Terms};
use std::path::{Path, PathBuf};
use std::str::FromStr;

const AFTER_HELP: &str = "\
Examples:
  slipfit resonance sweep.csv --reference free.csv
      the drive amplitude from a friction-free curve of the same drive
  slipfit resonance sweep.csv --drive-amplitude 0.0625±0.001 --plot sweep.svg
      the drive amplitude known
  slipfit resonance runs/ --drive 3
      one raw record for each frequency; column 3 is the drive
  slipfit resonance pendulum.csv --frequency-unit rad/s --band 0.5 0.9
      a unit the file does not name; one of several peaks
  slipfit resonance runs/*.csv --reference free.csv --table runs.csv
      many curves at once, one row each
  slipfit resonance fork.dat --model paper
      the effective Lorentzian of the paper, its bias beside the answer";

/// Viscous and sliding loss from a resonance curve.
///
/// Reads amplitude, or amplitude and phase, over frequency from a file of any
/// dialect and says which columns it took and why; several files or a folder
/// are raw records, one for each frequency, and are demodulated; with --table
/// each file is a curve of its own. Fits the exact
/// fundamental of the driven oscillator with sliding friction, compares the
/// loss models, and says what the curve can and cannot tell. Friction is told
/// from viscous loss far better with --reference or --drive-amplitude.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct ResonanceArgs {
    /// The curve; several files or a folder: one raw record for each frequency
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) curve: CurveArgs,

    /// A friction-free curve of the same drive, fitted jointly; read with the same flags
    #[arg(long, value_name = "FREE", conflicts_with = "drive_amplitude", help_heading = "Analysis")]
    pub(crate) reference: Option<PathBuf>,

    /// Drive amplitude x_0, in the response's unit, such as 0.0625±0.001; with a column of drive
    /// levels the one at their mean
    #[arg(long, value_name = "X0", help_heading = "Analysis")]
    drive_amplitude: Option<Uncertain>,

    /// How the response is computed: exact (the default), leading, paper; or a loss model to report:
    /// viscous, sliding, viscous+sliding, viscous+drag, sliding+drag, viscous+sliding+drag. May be
    /// given twice, once for each
    #[arg(long, value_name = "NAME", num_args = 1, help_heading = "Analysis")]
    model: Vec<Model>,

    /// Only points between these frequencies [Hz]
    #[arg(long, num_args = 2, value_names = ["LO", "HI"], value_parser = positive, help_heading = "Analysis")]
    band: Option<Vec<f64>>,

    /// A constant complex background (crosstalk, feed-through): on, off; as needed unless given
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    background: Option<Switch>,

    /// A delay of the signal chain: on, off; as needed unless given
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    delay: Option<Switch>,

    /// A constant phase offset: on, off; on unless given
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    phase_offset: Option<Switch>,

    /// A frequency that moves with the amplitude (Duffing): on, off; as needed unless given
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    duffing: Option<Switch>,

    #[command(flatten)]
    pub(crate) calibration: CalibrationArgs,

    #[command(flatten)]
    pub(crate) out: AnswerArgs,

    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// A way to compute the response, or a loss model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Model {
    Method(Method),
    Loss(LossModel),
}

impl FromStr for Model {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().to_lowercase().as_str() {
            "exact" => Ok(Self::Method(Method::Exact)),
            "leading" => Ok(Self::Method(Method::Leading)),
            "paper" => Ok(Self::Method(Method::Paper)),
            other => other.parse().map(Self::Loss).map_err(|_| {
                "exact, leading and paper are known, and the loss models viscous, sliding, viscous+sliding, \
                 viscous+drag, sliding+drag, viscous+sliding+drag"
                    .to_owned()
            }),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    On,
    Off,
}

impl ResonanceArgs {
    /// Every file that is read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().chain(&self.reference).map(PathBuf::as_path)
    }

    /// Everything but the reference, which is a file.
    pub(crate) fn options(&self) -> Options {
        let switch = |s: Option<Switch>| s.map(|s| s == Switch::On);
        let mut options = Options::default();
        options.band_hz = match self.band.as_deref() {
            Some(&[low, high]) => Some([low, high]),
            _ => None,
        };
        for model in &self.model {
            match model {
                Model::Method(method) => options.method = *method,
                Model::Loss(loss) => options.model = Some(*loss),
            }
        }
        options.drive_amplitude =
            self.drive_amplitude.map(|u| DriveAmplitude { value: u.value, std_error: u.std_error });
        let mut terms = Terms::default();
        terms.background = switch(self.background);
        terms.delay = switch(self.delay);
        terms.phase_offset = switch(self.phase_offset);
        terms.duffing = switch(self.duffing);
        options.terms = terms;
        options.calibration = self.calibration.constant();
        options
    }
}

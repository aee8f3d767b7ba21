//! `slipfit resonance`.

use super::calibration::CalibrationArgs;
use super::curve::CurveArgs;
use super::value::{InUnit, Positive, band, loss_model, model_help};
use super::{AnswerArgs, TableArgs};
use clap::{Args, ValueEnum};
use serde::Deserialize;
use serde::de::{self, Deserializer};
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
  slipfit resonance fork.dat --response paper
      the effective Lorentzian of the paper, its bias beside the answer";

/// Viscous and sliding loss from a resonance curve.
///
/// Reads amplitude, or amplitude and phase, over frequency from a file of any dialect and says which columns it
/// took and why. Several files or a folder are raw records, one per frequency, and are demodulated; with --table
/// each file is a curve of its own. Fits the exact fundamental of the driven oscillator with sliding friction,
/// compares the loss models, and says what the curve can and cannot determine. Friction is separated from viscous
/// loss far better with --reference or --drive-amplitude.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct ResonanceArgs {
    /// The curve; several files or a folder: one raw record per frequency
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) curve: CurveArgs,

    /// A friction-free curve of the same oscillator and drive, fitted jointly with shared delay, drag and Duffing
    /// term; read with the same flags
    #[arg(long, value_name = "FREE", conflicts_with = "drive_amplitude", help_heading = "Analysis")]
    pub(crate) reference: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) analysis: ResonanceAnalysisArgs,

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
pub(crate) struct ResonanceAnalysisArgs {
    /// Drive amplitude x_0 (half of peak to peak), in the unit of the response or the unit given after it, such
    /// as 0.0625±0.001 or "1 nm"; with a column of drive levels, the amplitude at their mean
    #[arg(long, value_name = "X0", help_heading = "Analysis")]
    drive_amplitude: Option<InUnit>,

    /// How the response is computed: exact (the default), leading, paper
    #[arg(long, value_enum, value_name = "NAME", hide_possible_values = true, help_heading = "Analysis")]
    response: Option<Response>,

    // Its help is generated from the list of loss terms.
    #[arg(long, help = model_help(true), value_name = "NAME", num_args = 1, help_heading = "Analysis")]
    #[serde(deserialize_with = "one_or_several")]
    model: Vec<Model>,

    /// Use only points between these frequencies [Hz]
    #[arg(long, num_args = 2, value_names = ["LO", "HI"], help_heading = "Analysis")]
    band: Option<Vec<Positive>>,

    /// A constant complex background (crosstalk, feed-through): on or off; if not given, fitted if the
    /// data need it
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    background: Option<Switch>,

    /// A delay of the signal chain: on or off; if not given, fitted if the data need it
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    delay: Option<Switch>,

    /// A constant offset of every amplitude of a curve without phases (zero of the detector): on or off; if
    /// not given, fitted if the data need it
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    amplitude_offset: Option<Switch>,

    /// A noise floor added in quadrature to every amplitude of a curve without phases (spectrum analyser, rms):
    /// on or off; if not given, fitted if the data need it
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    noise_floor: Option<Switch>,

    /// A constant phase offset: on or off; on unless given
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    phase_offset: Option<Switch>,

    /// A frequency that depends on the amplitude (Duffing): on or off; if not given, fitted if the data
    /// need it
    #[arg(long, value_enum, value_name = "WHEN", hide_possible_values = true, help_heading = "Analysis")]
    duffing: Option<Switch>,
}

/// How the response is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Response {
    Exact,
    Leading,
    Paper,
}

impl From<Response> for Method {
    fn from(response: Response) -> Self {
        match response {
            Response::Exact => Self::Exact,
            Response::Leading => Self::Leading,
            Response::Paper => Self::Paper,
        }
    }
}

/// Value of `--model`: a loss model, or a response in its former spelling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Model {
    Loss(LossModel),
    Response(Response),
}

impl FromStr for Model {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let word = text.trim().to_lowercase();
        if let Ok(response) = Response::from_str(&word, true) {
            return Ok(Self::Response(response));
        }
        loss_model(&word).map(Self::Loss)
    }
}

/// A model, or a list of them.
fn one_or_several<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Model>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        One(String),
        Several(Vec<String>),
    }
    let words = match Written::deserialize(from)? {
        Written::One(word) => vec![word],
        Written::Several(words) => words,
    };
    words.iter().map(|w| w.parse().map_err(|e| de::Error::custom(format!("{w}: {e}")))).collect()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Switch {
    On,
    Off,
}

impl ResonanceArgs {
    /// All files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().chain(&self.reference).map(PathBuf::as_path)
    }

    /// All options except the reference, which is a file.
    pub(crate) fn options(&self) -> Options {
        let mut options = self.analysis.options();
        options.calibration = self.calibration.constant();
        options
    }
}

impl ResonanceAnalysisArgs {
    /// The unit of the drive amplitude, if it is not that of the response.
    pub(crate) fn drive_unit(&self) -> Option<String> {
        self.drive_amplitude.as_ref().and_then(|given| given.unit.clone())
    }

    /// A note if the response is named by `--model`, its former spelling.
    pub(crate) fn old_spelling(&self) -> Option<String> {
        self.model.iter().find_map(|model| match model {
            Model::Response(response) => {
                let word = format!("{response:?}").to_lowercase();
                Some(format!("--model {word} is --response {word} now; --model names a loss model"))
            }
            Model::Loss(_) => None,
        })
    }

    /// All options except the reference and the calibration.
    pub(crate) fn options(&self) -> Options {
        let switch = |s: Option<Switch>| s.map(|s| s == Switch::On);
        let mut options = Options::default();
        options.band_hz = band(self.band.as_deref());
        for model in &self.model {
            match model {
                Model::Response(response) => options.method = (*response).into(),
                Model::Loss(loss) => options.model = Some(*loss),
            }
        }
        if let Some(response) = self.response {
            options.method = response.into();
        }
        let of =
            |given: &InUnit| DriveAmplitude { value: given.number.value, std_error: given.number.std_error };
        options.drive_amplitude = self.drive_amplitude.as_ref().map(of);
        let mut terms = Terms::default();
        terms.background = switch(self.background);
        terms.delay = switch(self.delay);
        terms.amplitude_offset = switch(self.amplitude_offset);
        terms.noise_floor = switch(self.noise_floor);
        terms.phase_offset = switch(self.phase_offset);
        terms.duffing = switch(self.duffing);
        options.terms = terms;
        options
    }
}

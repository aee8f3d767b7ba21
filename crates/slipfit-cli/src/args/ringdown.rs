//! `slipfit ringdown`.

use super::{Uncertain, finite, positive};
use clap::{Args, ValueEnum};
use slipfit::SignalKind;
use slipfit::ringdown::{Calibration, LossModel, LowPass, Options};
use slipfit_io::ReadOptions;
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
  slipfit ringdown swing.csv --json - | jq .sliding
      the answer for a script";

/// Viscous and sliding loss from a measured free decay.
///
/// Reads delimited text of any dialect and says which columns it took and why.
/// Finds the free decay in the record by itself (a driven lead-in, a jolt, rest
/// and noise at the end are left out), fits viscous, sliding and drag losses
/// alone and together, and reports the model the data prefer with the evidence
/// for it. The frequency may change with amplitude and the offset may drift.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct RingdownArgs {
    /// The record: text in columns, one row per sample
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    /// Column of the times, by number (from 1) or name
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    time: Option<String>,

    /// Column of the signal (of a lock-in: its X output)
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    signal: Option<String>,

    /// Column of a lock-in's Y output
    #[arg(long, value_name = "COL", help_heading = "Reading")]
    quadrature: Option<String>,

    /// Unit of the times: s, ms, us, ns, min, h
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    time_unit: Option<String>,

    /// Unit of the signal, such as rad, deg, mm, V, dBm
    #[arg(long, value_name = "UNIT", help_heading = "Reading")]
    unit: Option<String>,

    /// What the signal is
    #[arg(long, value_enum, value_name = "KIND", help_heading = "Reading", hide_possible_values = false)]
    kind: Option<Kind>,

    /// Samples per second, where the file has no times
    #[arg(long, value_name = "RATE", value_parser = positive, help_heading = "Reading")]
    rate_hz: Option<f64>,

    /// Which of several tables side by side, from 1
    #[arg(long, value_name = "N", help_heading = "Reading")]
    table: Option<usize>,

    /// Which of several runs in groups of columns, from 1
    #[arg(long, value_name = "N", help_heading = "Reading")]
    run: Option<usize>,

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

    /// Write the whole answer as JSON, `-` for standard output
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,

    /// Draw data, fit, residuals and loss; .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,

    /// Write envelope, fit and residuals as CSV
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) csv: Option<PathBuf>,

    /// Exit with status 1 on any warning
    #[arg(long, help_heading = "Output")]
    pub(crate) strict: bool,

    /// Print nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

/// At most one mechanical constant.
#[derive(Debug, Args)]
#[group(multiple = false)]
struct CalibrationArgs {
    /// Stiffness k [N/m], for a displacement in m: 12000, 12000±300, 12000(300)
    #[arg(long, value_name = "K", help_heading = "Forces")]
    stiffness: Option<Uncertain>,

    /// Mass m [kg], for a displacement in m
    #[arg(long, value_name = "M", help_heading = "Forces")]
    mass: Option<Uncertain>,

    /// Torsion stiffness [N m/rad], for an angle
    #[arg(long, value_name = "K", help_heading = "Forces")]
    torsion_stiffness: Option<Uncertain>,

    /// Moment of inertia [kg m²], for an angle
    #[arg(long, value_name = "I", help_heading = "Forces")]
    inertia: Option<Uncertain>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Position or angle
    Displacement,
    /// Its first derivative
    Velocity,
    /// Its second derivative
    Acceleration,
    /// Amplitude of the oscillation
    Envelope,
    /// X and Y outputs of a lock-in
    LockIn,
}

impl From<Kind> for SignalKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Displacement => Self::Displacement,
            Kind::Velocity => Self::Velocity,
            Kind::Acceleration => Self::Acceleration,
            Kind::Envelope => Self::Envelope,
            Kind::LockIn => Self::LockIn,
        }
    }
}

impl RingdownArgs {
    pub(crate) fn read_options(&self) -> ReadOptions {
        ReadOptions {
            time: self.time.clone(),
            signal: self.signal.clone(),
            quadrature: self.quadrature.clone(),
            time_unit: self.time_unit.clone(),
            signal_unit: self.unit.clone(),
            kind: self.kind.map(Into::into),
            rate_hz: self.rate_hz,
            table: self.table,
            run: self.run,
        }
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
        let c = &self.calibration;
        [
            (c.stiffness.is_some(), "--stiffness", false),
            (c.mass.is_some(), "--mass", false),
            (c.torsion_stiffness.is_some(), "--torsion-stiffness", true),
            (c.inertia.is_some(), "--inertia", true),
        ]
        .into_iter()
        .find_map(|(given, flag, angular)| given.then_some((flag, angular)))
    }
}

impl CalibrationArgs {
    fn constant(&self) -> Option<Calibration> {
        let stiffness = self.stiffness.or(self.torsion_stiffness);
        let mass = self.mass.or(self.inertia);
        stiffness
            .map(|u| Calibration::Stiffness { value: u.value, std_error: u.std_error })
            .or_else(|| mass.map(|u| Calibration::Mass { value: u.value, std_error: u.std_error }))
    }
}

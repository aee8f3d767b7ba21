//! `slipfit simulate`.

use super::{finite, not_negative, positive};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Records made by the exact motion, to test an analysis or plan a measurement.
#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    #[command(subcommand)]
    pub(crate) command: SimulateCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SimulateCommand {
    Decay(Box<DecayArgs>),
}

const DECAY_AFTER_HELP: &str = "\
Examples:
  slipfit simulate decay --frequency-hz 1.2 --q 60 --friction-displacement 0.002 \\
      --unit rad --amplitude 0.4 --duration 40 --rate-hz 50 --noise-rms 5e-4 --out swing.csv
      a pendulum that comes to rest, with noise
  slipfit simulate decay --frequency-hz 32700 --stiffness 1e4 --viscous 20e-6 \\
      --coulomb-force 15e-9 --amplitude 25e-9 --duration 0.1 --rate-hz 20e3 --output envelope
      the amplitude of a tuning fork as a lock-in shows it

The noise comes from the ChaCha12 generator of rand_chacha seeded with --seed, through the
normal distribution of rand_distr: the same command gives the same bytes.";

/// A free decay with viscous and sliding friction, released at rest.
///
/// Writes CSV with every parameter in its header. The oscillator is given
/// either by --frequency-hz, --q and --friction-displacement, or physically by
/// two of --mass, --stiffness and --frequency-hz, with --viscous and
/// --coulomb-force; the two may be mixed.
#[derive(Debug, Args)]
#[command(after_help = DECAY_AFTER_HELP, after_long_help = DECAY_AFTER_HELP)]
pub(crate) struct DecayArgs {
    /// Undamped frequency [Hz]
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) frequency_hz: Option<f64>,

    /// Stiffness k [N/m]
    #[arg(long, value_name = "K", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) stiffness: Option<f64>,

    /// Mass m [kg]
    #[arg(long, value_name = "M", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) mass: Option<f64>,

    /// Quality factor of the viscous loss alone
    #[arg(long, value_name = "Q", value_parser = positive, conflicts_with = "viscous", help_heading = "Oscillator")]
    pub(crate) q: Option<f64>,

    /// Viscous coefficient gamma [N s/m = kg/s]
    #[arg(long, value_name = "GAMMA", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) viscous: Option<f64>,

    /// Friction displacement x_F = F/k [unit of the displacement]
    #[arg(
        long,
        value_name = "X",
        value_parser = not_negative,
        conflicts_with = "coulomb_force",
        help_heading = "Oscillator"
    )]
    pub(crate) friction_displacement: Option<f64>,

    /// Sliding friction force F [N]
    #[arg(long, value_name = "F", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) coulomb_force: Option<f64>,

    /// Static friction force F_s [N]; equal to the sliding one unless given
    #[arg(long, value_name = "F", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) static_force: Option<f64>,

    /// Amplitude at the release
    #[arg(long, value_name = "A", value_parser = finite, allow_negative_numbers = true, help_heading = "Record")]
    pub(crate) amplitude: f64,

    /// Unit of the displacement, for the header
    #[arg(long, value_name = "UNIT", default_value = "m", help_heading = "Record")]
    pub(crate) unit: String,

    /// Length of the record [s]
    #[arg(long, value_name = "S", value_parser = positive, help_heading = "Record")]
    pub(crate) duration: f64,

    /// Samples per second
    #[arg(long, value_name = "RATE", value_parser = positive, help_heading = "Record")]
    pub(crate) rate_hz: f64,

    /// Root mean square of white noise; of an envelope, on each of X and Y
    #[arg(long, value_name = "RMS", value_parser = not_negative, default_value_t = 0.0, help_heading = "Record")]
    pub(crate) noise_rms: f64,

    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Record")]
    pub(crate) seed: u64,

    /// Round to a converter of so many bits, full scale at the amplitude and five times the noise
    #[arg(
        long,
        value_name = "BITS",
        value_parser = clap::value_parser!(u32).range(2..=32),
        help_heading = "Record"
    )]
    pub(crate) quantize_bits: Option<u32>,

    /// What to record
    #[arg(long, value_enum, value_name = "WHAT", default_value = "waveform", help_heading = "Record")]
    pub(crate) output: OutputKind,

    /// Where to write; standard output unless given
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OutputKind {
    /// The displacement itself
    Waveform,
    /// Its amplitude, as a lock-in with a fast filter gives it
    Envelope,
}

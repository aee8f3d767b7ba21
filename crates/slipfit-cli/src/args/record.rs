//! Options of every simulated record: oscillator, sensor and output.

use super::{ReplaceArgs, not_negative, positive};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

// A doc comment here would replace that of the command.
#[derive(Debug, Args)]
pub(crate) struct OscillatorArgs {
    /// Undamped frequency [Hz]
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) frequency_hz: Option<f64>,

    /// Stiffness k [N/m; for an angle N m/rad], whatever the unit of the displacement
    #[arg(long, value_name = "K", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) stiffness: Option<f64>,

    /// Mass m [kg; for an angle the moment of inertia, kg m²]
    #[arg(long, value_name = "M", value_parser = positive, help_heading = "Oscillator")]
    pub(crate) mass: Option<f64>,

    /// Quality factor of the viscous loss alone
    #[arg(
        long,
        value_name = "Q",
        value_parser = positive,
        conflicts_with = "viscous",
        help_heading = "Oscillator"
    )]
    pub(crate) q: Option<f64>,

    /// Viscous coefficient gamma [N s/m = kg/s; for an angle N m s/rad]
    #[arg(long, value_name = "GAMMA", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) viscous: Option<f64>,

    /// Friction displacement x_F = F/k [unit of the displacement]
    #[arg(
        long,
        value_name = "X",
        value_parser = not_negative,
        conflicts_with_all = ["coulomb_force", "beta"],
        help_heading = "Oscillator"
    )]
    pub(crate) friction_displacement: Option<f64>,

    /// Sliding friction force F [N; for an angle N m]
    #[arg(
        long,
        value_name = "F",
        value_parser = not_negative,
        conflicts_with = "beta",
        help_heading = "Oscillator"
    )]
    pub(crate) coulomb_force: Option<f64>,

    /// Sliding friction relative to the drive or the release, 4F/(pi k x_0)
    #[arg(long, value_name = "BETA", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) beta: Option<f64>,

    /// Static friction force F_s [N]; equal to the sliding one unless given
    #[arg(
        long,
        value_name = "F",
        value_parser = not_negative,
        conflicts_with = "static_displacement",
        help_heading = "Oscillator"
    )]
    pub(crate) static_force: Option<f64>,

    /// Static friction as a displacement F_s/k [unit of the displacement]
    #[arg(long, value_name = "X", value_parser = not_negative, help_heading = "Oscillator")]
    pub(crate) static_displacement: Option<f64>,

    #[command(flatten)]
    pub(crate) minus: MinusArgs,
}

// Friction against motion to negative x, if it differs from that in the other direction.
#[derive(Debug, Args)]
pub(crate) struct MinusArgs {
    /// Sliding friction against motion to negative x, F-/k; the same in both directions unless given
    #[arg(
        long,
        value_name = "X",
        value_parser = not_negative,
        conflicts_with = "coulomb_force_minus",
        help_heading = "Friction that differs by direction"
    )]
    pub(crate) friction_displacement_minus: Option<f64>,

    /// The same as a force F- [N]
    #[arg(long, value_name = "F", value_parser = not_negative, help_heading = "Friction that differs by direction")]
    pub(crate) coulomb_force_minus: Option<f64>,

    /// Static friction against a pull to negative x, F_s-/k, at least F-/k; that in the other direction unless
    /// given
    #[arg(
        long,
        value_name = "X",
        value_parser = not_negative,
        conflicts_with = "static_force_minus",
        help_heading = "Friction that differs by direction"
    )]
    pub(crate) static_displacement_minus: Option<f64>,

    /// The same as a force F_s- [N]
    #[arg(long, value_name = "F", value_parser = not_negative, help_heading = "Friction that differs by direction")]
    pub(crate) static_force_minus: Option<f64>,
}

// The sensor: its unit, noise and converter.
#[derive(Debug, Args)]
pub(crate) struct SampleArgs {
    /// Unit of the displacement, to which forces over the stiffness are converted; a unit that is neither a
    /// length nor an angle allows displacements only
    #[arg(long, value_name = "UNIT", default_value = "m", help_heading = "Record")]
    pub(crate) unit: String,

    /// Root mean square of white noise; for amplitudes, on each of X and Y
    #[arg(long, value_name = "RMS", value_parser = not_negative, default_value_t = 0.0, help_heading = "Record")]
    pub(crate) noise_rms: f64,

    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Record")]
    pub(crate) seed: u64,

    /// Round to a converter of this many bits, whose full scale is the amplitude plus five times the noise
    #[arg(
        long,
        value_name = "BITS",
        value_parser = clap::value_parser!(u32).range(2..=32),
        help_heading = "Record"
    )]
    pub(crate) quantize_bits: Option<u32>,
}

// Where the record is written.
#[derive(Debug, Args)]
pub(crate) struct OutArgs {
    /// Where to write; standard output unless given
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) out: Option<PathBuf>,

    /// File format, if the extension (.csv, .npy, .wav, .parquet) does not determine it
    #[arg(long, value_enum, value_name = "FORM", help_heading = "Output")]
    pub(crate) format: Option<RecordFormat>,

    /// Write parameters and samples as JSON as well, `-` for standard output
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,
}

/// File format of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RecordFormat {
    /// Text, with every parameter in lines before the table
    Csv,
    /// NumPy array of rows and columns, 64-bit; parameters with --json
    Npy,
    /// Sound, 32-bit float, in the unit of the record; parameters with --json
    Wav,
    /// Parquet, each column of 64-bit numbers; every parameter in its metadata
    Parquet,
}

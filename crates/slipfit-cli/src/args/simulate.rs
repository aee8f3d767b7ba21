//! `slipfit simulate`.

use super::record::{OscillatorArgs, OutArgs, SampleArgs};
use super::{finite, not_negative, positive};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Simulated records of the exact motion, to test an analysis or plan a measurement.
#[derive(Debug, Args)]
#[command(long_about = "Simulated records of the exact motion, to test an analysis or plan a measurement.")]
pub(crate) struct SimulateArgs {
    #[command(subcommand)]
    pub(crate) command: SimulateCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SimulateCommand {
    Decay(Box<DecayArgs>),
    Driven(Box<DrivenArgs>),
    Sweep(Box<SweepArgs>),
    Levels(Box<LevelsArgs>),
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
normal distribution of rand_distr: the same command gives the same bytes. On another
system the last digit of a sample may differ.";

/// A free decay with viscous and sliding friction, released at rest.
///
/// Writes CSV with every parameter in its header. The oscillator is given
/// either by --frequency-hz, --q and --friction-displacement, or physically by
/// two of --mass, --stiffness and --frequency-hz, with --viscous and
/// --coulomb-force; the two may be mixed.
#[derive(Debug, Args)]
#[command(after_help = DECAY_AFTER_HELP, after_long_help = DECAY_AFTER_HELP)]
pub(crate) struct DecayArgs {
    #[command(flatten)]
    pub(crate) oscillator: OscillatorArgs,

    /// Displacement at the release; below zero on the other side of the rest position, zero for noise alone
    #[arg(long, value_name = "A", value_parser = finite, help_heading = "Record")]
    pub(crate) amplitude: f64,

    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,

    #[command(flatten)]
    pub(crate) sample: SampleArgs,

    /// What to record
    #[arg(long, value_enum, value_name = "WHAT", default_value = "waveform", help_heading = "Record")]
    pub(crate) output: OutputKind,

    /// Write time and position of each turning point instead of samples, at 17 digits and without noise
    #[arg(long, help_heading = "Record")]
    pub(crate) turning_points: bool,

    #[command(flatten)]
    pub(crate) out: OutArgs,
}

// Length, sampling rate and digits of samples.
#[derive(Debug, Args)]
pub(crate) struct SamplingArgs {
    /// Length of the record [s]
    #[arg(long, value_name = "S", value_parser = positive, help_heading = "Record")]
    pub(crate) duration: f64,

    /// Samples per second
    #[arg(long, value_name = "RATE", value_parser = positive, help_heading = "Record")]
    pub(crate) rate_hz: f64,

    /// Significant digits of the samples in CSV; as many as read back to the same number unless given
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u8).range(1..=17),
        conflicts_with = "turning_points",
        help_heading = "Output"
    )]
    pub(crate) digits: Option<u8>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OutputKind {
    /// The displacement itself
    Waveform,
    /// Its amplitude, as a lock-in with a fast filter gives it
    Envelope,
}

const DRIVEN_AFTER_HELP: &str = "\
Examples:
  slipfit simulate driven --frequency-hz 1 --q 50 --beta 0.9 --drive-amplitude 1 \\
      --drive-frequency-hz 0.97 --duration 100 --rate-hz 50
      from rest towards the steady motion
  slipfit simulate driven --mass 0.1 --stiffness 40 --viscous 0.02 --coulomb-force 0.05 \\
      --static-force 0.08 --drive-force 0.1 --drive-frequency-hz 0.4 --duration 60 --rate-hz 200 \\
      --turning-points
      a slow drive that sticks and slips: where it turns and where it stops
  slipfit simulate driven --frequency-hz 32700 --stiffness 1e4 --viscous 20e-6 --coulomb-force 15e-9 \\
      --drive-amplitude 2e-11 --from steady --off-at 0.01 --duration 0.05 --rate-hz 500e3
      a ring-down as it begins in practice: the drive switched off
  slipfit simulate driven --frequency-hz 1 --q 20 --friction-displacement 0.3 \\
      --tone 0.4,1 --tone 1.2,0.4,90 --duration 100 --rate-hz 50
      two harmonics, the second a quarter ahead";

/// The motion under any drive, from rest or from steady motion, including its stops.
///
/// The drive moves the base, x_0 cos(2 pi f t), or pulls with a force, P cos(2 pi f t), which is equivalent to
/// x_0 = P/k; --tone adds further harmonics, --drive-file takes any other waveform. Friction may also be given by
/// its ratio to the drive, --beta = 4F/(pi k x_0).
#[derive(Debug, Args)]
#[command(after_help = DRIVEN_AFTER_HELP, after_long_help = DRIVEN_AFTER_HELP)]
// The generated usage line is wider than the screen.
#[command(
    override_usage = "slipfit simulate driven [OPTIONS] --duration <S> --rate-hz <RATE>\n           <--drive-amplitude <X>|--drive-force <P>|--tone <HZ,X[,DEG]>|--drive-file <FILE>>"
)]
pub(crate) struct DrivenArgs {
    #[command(flatten)]
    pub(crate) oscillator: OscillatorArgs,

    #[command(flatten)]
    pub(crate) drive: WaveArgs,

    /// Frequency of the drive [Hz]; that of the oscillator unless given
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Drive")]
    pub(crate) drive_frequency_hz: Option<f64>,

    /// Initial state
    #[arg(long, value_enum, value_name = "STATE", default_value = "rest", help_heading = "Drive")]
    pub(crate) from: Beginning,

    /// Switch the drive off at this instant [s]
    #[arg(long, value_name = "S", value_parser = not_negative, help_heading = "Drive")]
    pub(crate) off_at: Option<f64>,

    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,

    #[command(flatten)]
    pub(crate) sample: SampleArgs,

    /// Write time and position of each turning point instead of samples, at 17 digits and without noise
    #[arg(long, help_heading = "Record")]
    pub(crate) turning_points: bool,

    #[command(flatten)]
    pub(crate) out: OutArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Beginning {
    /// At rest, at zero
    Rest,
    /// In steady motion
    Steady,
}

// Any drive.
#[derive(Debug, Args)]
#[group(required = true, multiple = true)]
pub(crate) struct WaveArgs {
    /// Amplitude x_0 of the base [unit of the displacement]
    #[arg(
        long,
        value_name = "X",
        value_parser = positive,
        conflicts_with = "drive_force",
        help_heading = "Drive"
    )]
    pub(crate) drive_amplitude: Option<f64>,

    /// Amplitude P of a force instead [N]
    #[arg(long, value_name = "P", value_parser = positive, help_heading = "Drive")]
    pub(crate) drive_force: Option<f64>,

    /// Harmonic of the base: frequency [Hz], amplitude, and phase ahead of a cosine [deg], zero unless given; may
    /// be repeated
    #[arg(long, value_name = "HZ,X[,DEG]", value_parser = Tone::parse, help_heading = "Drive")]
    pub(crate) tone: Vec<Tone>,

    /// Positions of the base over time from a file, interpolated linearly between samples
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["drive_amplitude", "drive_force", "tone", "drive_frequency_hz"],
        help_heading = "Drive"
    )]
    pub(crate) drive_file: Option<PathBuf>,
}

/// One harmonic of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tone {
    pub(crate) frequency_hz: f64,
    pub(crate) amplitude: f64,
    pub(crate) phase_deg: f64,
}

impl Tone {
    fn parse(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').collect();
        let (frequency, amplitude, phase) = match parts[..] {
            [f, x] => (f, x, "0"),
            [f, x, p] => (f, x, p),
            _ => return Err("write it as HZ,X or HZ,X,DEG, such as 0.4,1.5,90".to_owned()),
        };
        let named = |what: &str, e: String| format!("{what} {e}");
        Ok(Self {
            frequency_hz: positive(frequency).map_err(|e| named("the frequency:", e))?,
            amplitude: finite(amplitude).map_err(|e| named("the amplitude:", e))?,
            phase_deg: finite(phase).map_err(|e| named("the phase:", e))?,
        })
    }
}

// The amplitude of the drive, as a displacement or a force.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct DriveArgs {
    /// Amplitude x_0 of the base [unit of the displacement]
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Drive")]
    pub(crate) drive_amplitude: Option<f64>,

    /// Amplitude P of a force instead [N]
    #[arg(long, value_name = "P", value_parser = positive, help_heading = "Drive")]
    pub(crate) drive_force: Option<f64>,
}

const SWEEP_AFTER_HELP: &str = "\
Examples:
  slipfit simulate sweep --frequency-hz 32700 --stiffness 1e4 --viscous 20e-6 --coulomb-force 15e-9 \\
      --drive-amplitude 1.2e-11 --start-hz 32670 --stop-hz 32730 --points 121 --out fork.csv
      a resonance curve with sliding friction, every point settled
  slipfit simulate sweep --frequency-hz 1 --q 50 --beta 0.8 --drive-amplitude 1 \\
      --start-hz 1.06 --stop-hz 0.94 --sweep-time 600
      swept downwards in ten minutes: the motion lags behind
  slipfit simulate sweep --frequency-hz 1 --q 50 --beta 0.8 --drive-amplitude 1 \\
      --start-hz 0.94 --stop-hz 1.06 --points 25 --wait 5
      stepped, five seconds at each frequency: not enough to settle";

/// Amplitude and phase over frequency, as an instrument records them.
///
/// Each point is the exact steady motion including its stops, as after a long wait. With --wait, it is what a
/// lock-in shows after that time at each frequency, where the motion is steady at the first one. With
/// --sweep-time, it is recorded during a slow sweep up or down. Amplitude and phase are those of the fundamental;
/// if the mass rests, there is no phase and the cell is empty.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_AFTER_HELP, after_long_help = SWEEP_AFTER_HELP)]
// The generated usage line is wider than the screen.
#[command(
    override_usage = "slipfit simulate sweep [OPTIONS] --start-hz <HZ> --stop-hz <HZ>\n                              <--drive-amplitude <X>|--drive-force <P>>"
)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) oscillator: OscillatorArgs,

    #[command(flatten)]
    pub(crate) drive: DriveArgs,

    /// First frequency [Hz]
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Sweep")]
    pub(crate) start_hz: f64,

    /// Last frequency [Hz]; below the first to sweep down
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Sweep")]
    pub(crate) stop_hz: f64,

    /// Number of frequencies recorded
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_000_000), default_value_t = 101, help_heading = "Sweep")]
    pub(crate) points: u32,

    /// Sweep continuously in this time [s], instead of waiting at each point
    #[arg(long, value_name = "S", value_parser = positive, help_heading = "Sweep")]
    pub(crate) sweep_time: Option<f64>,

    /// Wait this long at each frequency [s]; the motion continues from one frequency to the next and is steady at
    /// the first; the fundamental is that of the drive cycle after the wait
    #[arg(
        long,
        value_name = "S",
        value_parser = not_negative,
        conflicts_with = "sweep_time",
        help_heading = "Sweep"
    )]
    pub(crate) wait: Option<f64>,

    #[command(flatten)]
    pub(crate) sample: SampleArgs,

    #[command(flatten)]
    pub(crate) out: OutArgs,
}

const LEVELS_AFTER_HELP: &str = "\
Examples:
  slipfit simulate levels --frequency-hz 1 --q 50 --friction-displacement 0.01 \\
      --start-amplitude 0.002 --stop-amplitude 0.1 --points 50
      nothing moves below the threshold, then a straight line of slope Q";

/// Amplitude at resonance against drive level.
///
/// The exact steady motion including its stops, at the frequency of the oscillator or at --drive-frequency-hz. If
/// the mass rests, there is no phase and the cell is empty.
#[derive(Debug, Args)]
#[command(after_help = LEVELS_AFTER_HELP, after_long_help = LEVELS_AFTER_HELP)]
pub(crate) struct LevelsArgs {
    #[command(flatten)]
    pub(crate) oscillator: OscillatorArgs,

    /// First drive amplitude x_0 [unit of the displacement]
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Levels")]
    pub(crate) start_amplitude: f64,

    /// Last drive amplitude x_0 [unit of the displacement]; --beta refers to it
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Levels")]
    pub(crate) stop_amplitude: f64,

    /// Number of levels recorded
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_000_000), default_value_t = 51, help_heading = "Levels")]
    pub(crate) points: u32,

    /// Space the levels by a constant ratio instead of a constant step
    #[arg(long, help_heading = "Levels")]
    pub(crate) log: bool,

    /// Frequency of the drive [Hz]; that of the oscillator unless given
    #[arg(long, value_name = "HZ", value_parser = positive, help_heading = "Levels")]
    pub(crate) drive_frequency_hz: Option<f64>,

    /// Wait this long at each level [s] instead of until the motion is steady, as it is at the first level; the
    /// fundamental is that of the drive cycle after the wait
    #[arg(long, value_name = "S", value_parser = not_negative, help_heading = "Levels")]
    pub(crate) wait: Option<f64>,

    #[command(flatten)]
    pub(crate) sample: SampleArgs,

    #[command(flatten)]
    pub(crate) out: OutArgs,
}

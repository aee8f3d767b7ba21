//! The arguments of the command line.

mod answer;
mod app;
mod calibration;
mod curve;
mod inspect;
mod levels;
mod map;
mod pages;
mod reading;
mod record;
mod resonance;
mod ringdown;
mod series;
mod shell;
mod simulate;
mod value;

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Parser, Subcommand, ValueEnum};

pub(crate) use answer::{AnswerArgs, ReplaceArgs, TableArgs};
pub(crate) use app::AppArgs;
pub(crate) use curve::CurveArgs;
pub(crate) use inspect::InspectArgs;
pub(crate) use levels::{LevelAnalysisArgs, LevelFitArgs, LevelReadingArgs};
pub(crate) use map::{Kind as MapKind, MapArgs, Method as MapMethod};
pub(crate) use pages::{AtlasArgs, PaperArgs};
pub(crate) use reading::{ReadingArgs, quoted};
pub(crate) use record::{MinusArgs, OscillatorArgs, OutArgs, RecordFormat, SampleArgs};
pub(crate) use resonance::{ResonanceAnalysisArgs, ResonanceArgs};
pub(crate) use ringdown::{RingdownAnalysisArgs, RingdownArgs};
pub(crate) use series::SeriesArgs;
pub(crate) use shell::{CompletionsArgs, ManArgs};
pub(crate) use simulate::{
    Beginning, DecayArgs, DriveArgs, DrivenArgs, LevelsArgs, OutputKind, SimulateArgs, SimulateCommand,
    SweepArgs, Tone, WaveArgs,
};
pub(crate) use value::Uncertain;
use value::{finite, not_negative, positive};

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

const AFTER_HELP: &str = "\
Examples:
  slipfit ringdown swing.csv
      how much of the loss is viscous, how much is sliding, and how sure that is
  slipfit ringdown swing.csv --plot swing.svg --json swing.json
      the same, with a picture and everything in machine-readable form
  slipfit inspect swing.csv
      what the file holds, how it would be read, and the command for it
  slipfit help ringdown
      every option of a command

Files are written beside their place and renamed: a full disk or a kill leaves the old one whole.
No output may be an input. A file that slipfit did not write is replaced with --force only; its
own it knows by their schema, first comment, last line or metadata (.npy has room for none).

Exit status: 0 done (of several files at least one), 1 warnings or a failed file under --strict, 2 failed,
130 interrupted.";

/// Tells sliding friction from viscous damping in any oscillator.
///
/// Give it a measured decay of a pendulum, a tuning fork, a membrane, a
/// building: it finds the free decay in the record, fits it with every loss
/// law, and says how much of the loss is viscous, how much is sliding
/// (Coulomb, dry) friction, and how sure that is.
#[derive(Debug, Parser)]
#[command(name = "slipfit", version = crate::version::long(), after_help = AFTER_HELP, styles = STYLES)]
#[command(max_term_width = 100, propagate_version = true, disable_help_subcommand = false)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// When to colour the output: auto (on a terminal, unless NO_COLOR is set), always, never
    #[arg(
        long,
        value_enum,
        value_name = "WHEN",
        default_value = "auto",
        hide_possible_values = true,
        global = true,
        help_heading = "Output",
        display_order = 900
    )]
    pub(crate) color: Color,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Ringdown(Box<RingdownArgs>),
    Resonance(Box<ResonanceArgs>),
    Levels(Box<LevelFitArgs>),
    Series(SeriesArgs),
    Map(Box<MapArgs>),
    Inspect(Box<InspectArgs>),
    App(AppArgs),
    Simulate(SimulateArgs),
    Paper(PaperArgs),
    Atlas(AtlasArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Color {
    Auto,
    Always,
    Never,
}

impl From<Color> for anstream::ColorChoice {
    fn from(color: Color) -> Self {
        match color {
            Color::Auto => Self::Auto,
            Color::Always => Self::Always,
            Color::Never => Self::Never,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}

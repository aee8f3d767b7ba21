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

use clap::builder::StyledStr;
use clap::builder::styling::{AnsiColor, Styles};
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use std::any::TypeId;
use std::path::Path;

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
    Beginning, DecayArgs, DriveArgs, DrivenArgs, LevelsArgs, OutputKind, SamplingArgs, SimulateArgs,
    SimulateCommand, SweepArgs, Tone, WaveArgs,
};
use value::{
    Finite, InUnit, Inertia, Mass, Positive, Stiffness, TorsionStiffness, count, finite, not_negative,
    positive,
};
pub(crate) use value::{Uncertain, similar};

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

Files are written under another name and renamed: a full disk or a kill leaves the old file whole.
No output may be an input. A file that slipfit did not write is replaced only with --force; slipfit
recognises its own by schema, first comment, last line or metadata (.npy has room for none).

Exit status: 0 done (of several files at least one), 1 warnings or a failed file under --strict,
2 failed, 130 interrupted.";

/// Separates sliding friction from viscous damping in any oscillator.
///
/// Give it a measured decay of a pendulum, a tuning fork, a membrane, a building: it finds the free decay in the
/// record, fits it with every loss law, and reports how much of the loss is viscous, how much is sliding
/// (Coulomb, dry) friction, and how certain that is.
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

/// Parses the command line; ends the program if it is wrong or asks for help.
pub(crate) fn parse() -> Cli {
    let matches =
        with_signs(Cli::command()).try_get_matches().unwrap_or_else(|error| without_command(error).exit());
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut Cli::command()).exit())
}

/// The error, with what to type if a file is given in place of a command.
fn without_command(mut error: clap::Error) -> clap::Error {
    let word = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(word)) => word.clone(),
        _ => return error,
    };
    if Path::new(&word).exists() || Path::new(&word).extension().is_some() {
        let file = quoted(&word);
        let tips = [
            format!("slipfit ringdown {file} analyses a measured decay"),
            format!("slipfit inspect {file} shows what the file holds"),
        ];
        let tips = tips.into_iter().map(StyledStr::from).collect();
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    }
    error
}

/// The command with a sign allowed before every number, so that the parser of the value reports what is wrong
/// with it; clap itself takes `-1` for an option.
fn with_signs(command: clap::Command) -> clap::Command {
    let signed = |arg: Arg| match arg.get_action().takes_values() && !arg.is_positional() {
        // Clap does not accept `-1e-3` and `-5±1` as numbers.
        true if is_number(&arg) => arg.allow_hyphen_values(true),
        true => arg.allow_negative_numbers(true),
        false => arg,
    };
    command.mut_args(signed).mut_subcommands(with_signs)
}

fn is_number(arg: &Arg) -> bool {
    let id = arg.get_value_parser().type_id();
    let numbers = [
        TypeId::of::<f64>(),
        TypeId::of::<usize>(),
        TypeId::of::<u64>(),
        TypeId::of::<u32>(),
        TypeId::of::<u16>(),
        TypeId::of::<u8>(),
        TypeId::of::<Finite>(),
        TypeId::of::<Positive>(),
        TypeId::of::<Uncertain>(),
        TypeId::of::<InUnit>(),
        TypeId::of::<Stiffness>(),
        TypeId::of::<Mass>(),
        TypeId::of::<TorsionStiffness>(),
        TypeId::of::<Inertia>(),
        TypeId::of::<Tone>(),
    ];
    numbers.iter().any(|number| id == *number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        with_signs(Cli::command()).debug_assert();
    }

    #[test]
    fn a_sign_before_a_number_is_no_option() {
        fn check(command: &clap::Command, checked: &mut usize) {
            // The value names of numbers in the help; COL, NAME and FILE are words.
            const NUMBERS: &str = "A BETA BITS F G GAMMA HI HZ HZ,X[,DEG] I K LO M N P Q RATE RMS S X X0";
            for arg in command.get_arguments() {
                let names = arg.get_value_names().unwrap_or_default();
                if names.iter().any(|name| NUMBERS.split(' ').any(|number| name == number)) {
                    assert!(arg.is_allow_hyphen_values_set(), "{} {}", command.get_name(), arg.get_id());
                    *checked += 1;
                }
            }
            command.get_subcommands().for_each(|command| check(command, checked));
        }
        let (mut command, mut checked) = (with_signs(Cli::command()), 0);
        command.build();
        check(&command, &mut checked);
        assert!(checked > 50, "{checked}");
    }
}

//! `slipfit inspect`.

use super::ReadingArgs;
use clap::Args;
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Examples:
  slipfit inspect swing.csv
      format, tables, columns, units, clock, first rows, a small plot
  slipfit inspect runs.xlsx --sheet \"Run 3\"
      one of several sheets, variables, groups or tracks";

/// What a file holds and how it would be read, without analysing it.
///
/// Shows the format, every table with its columns and units, the columns that would be taken and why, the clock
/// with its gaps, the number of oscillations of the signal, the first rows and a small plot, and ends with the
/// command that analyses the file. Nothing is fitted, so the answer is immediate.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct InspectArgs {
    /// The file, in any supported format
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

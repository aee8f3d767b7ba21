//! `slipfit series`.

use super::AnswerArgs;
use clap::Args;
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Examples:
  slipfit series brake.toml
      friction and damping at each condition, by ring-down and by resonance
  slipfit series brake.toml --latex table.tex --plot table.svg
      the table for a paper, and its picture
  slipfit series brake.toml --html brake.html
      a report to hand in, equations and sources included

The manifest, in short (docs/series.md has it whole):

  stiffness = \"12000±300\"        # or mass, torsion_stiffness, inertia; forces in newtons
  shared = [\"natural_frequency\", \"drive_amplitude\"]

  [[measurement]]
  ringdown = \"free.csv\"          # or sweep = , levels =
  condition = \"400 mA\"";

/// Friction and damping of one oscillator from several measurements.
///
/// Ring-downs, sweeps and level sweeps, each under a condition (a load, a current, a pressure), are analysed
/// individually and jointly. The answer is the table of the paper: friction and damping at each condition by
/// ring-down and by resonance, and whether the two agree. If the condition is a load, the answer includes
/// friction against load.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct SeriesArgs {
    /// The list of measurements, a TOML file
    #[arg(value_name = "MANIFEST")]
    pub(crate) manifest: PathBuf,

    #[command(flatten)]
    pub(crate) out: AnswerArgs,
}

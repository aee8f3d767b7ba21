//! `slipfit paper` and `slipfit atlas`.

use super::ReplaceArgs;
use clap::Args;
use std::path::PathBuf;

/// Figures and statements of the paper, computed and compared with the exact motion.
///
/// "Effect of sliding friction in harmonic oscillators" by Vitorino, Vieira and Rodrigues: Fig. 1 and Fig. 2 as
/// SVG, PNG and CSV, and a page, paper.md, that compares what is printed, what holds, and the error made.
#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// Folder to write to; created if needed
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub(crate) out: PathBuf,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,

    /// Seed of the noise in the ring-downs of Fig. 2
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Output")]
    pub(crate) seed: u64,
}

/// Where each approximation of the paper may be used.
///
/// Errors of eq. (8), of eq. (14) with a = 4/3, of eq. (16) and of phi_1 = 0 against the exact motion, over Q
/// from 2 to 1e5 and beta from 0 to 0.99, as heat maps (SVG, PNG) and CSV.
#[derive(Debug, Args)]
pub(crate) struct AtlasArgs {
    /// Folder to write to; created if needed
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub(crate) out: PathBuf,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,

    /// Number of values of Q, evenly spaced in its logarithm
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=400), default_value_t = 48, help_heading = "Map")]
    pub(crate) q_points: u32,

    /// Number of values of beta
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=400), default_value_t = 34, help_heading = "Map")]
    pub(crate) beta_points: u32,
}

//! `slipfit app`.

use clap::Args;
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Examples:
  slipfit app
      the page in the browser of this machine: open, record or simulate, and analyse
  slipfit app swing.csv sweep.csv
      the same, with these files answered in it";

/// The page for the browser, served on this machine only.
///
/// Opens the browser at an address that contains a random token and refuses requests without it. Everything is
/// computed in the page: no file leaves the machine. Ends with Ctrl-C.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, after_long_help = AFTER_HELP)]
pub(crate) struct AppArgs {
    /// Files to open in the page, in any supported format
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,

    /// Port of 127.0.0.1 to serve at; 0 takes any free port
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Serving")]
    pub(crate) port: u16,

    /// Print the address without opening a browser
    #[arg(long, help_heading = "Serving")]
    pub(crate) no_browser: bool,
}

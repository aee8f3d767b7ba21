//! Options for the output of an answer.

use clap::Args;
use std::path::{Path, PathBuf};

// A doc comment here would replace that of the command.
#[derive(Debug, Args)]
pub(crate) struct AnswerArgs {
    /// Write the whole answer as JSON, `-` for standard output
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,

    /// Write the report as one page of HTML, its figures inside
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) html: Option<PathBuf>,

    /// Write the tables as Markdown
    #[arg(long = "md", alias = "markdown", value_name = "PATH", help_heading = "Output")]
    pub(crate) markdown: Option<PathBuf>,

    /// Write the tables as LaTeX
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) latex: Option<PathBuf>,

    /// Write the numbers behind the figure as CSV
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) csv: Option<PathBuf>,

    /// Draw data, fit and residuals; .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,

    /// Exit with status 1 on any warning
    #[arg(long, help_heading = "Output")]
    pub(crate) strict: bool,

    /// Print nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

// Options for overwriting files.
#[derive(Debug, Args)]
pub(crate) struct ReplaceArgs {
    /// Replace files that slipfit did not write; otherwise such a file is an error
    #[arg(long, help_heading = "Output")]
    pub(crate) force: bool,
}

// Options for a table of one row per file.
#[derive(Debug, Args)]
pub(crate) struct TableArgs {
    /// One row per file as a table, written as files are done: .csv, .json, .md, .tex or .parquet
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) table: Option<PathBuf>,

    /// Continue a table that was interrupted
    #[arg(long, requires = "table", help_heading = "Output")]
    pub(crate) resume: bool,
}

impl AnswerArgs {
    /// The requested files, with their flags.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        [
            ("--json", &self.json),
            ("--html", &self.html),
            ("--md", &self.markdown),
            ("--latex", &self.latex),
            ("--csv", &self.csv),
        ]
        .into_iter()
        .filter_map(|(flag, path)| Some((flag, path.as_deref()?)))
    }
}

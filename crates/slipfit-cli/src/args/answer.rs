//! Where an answer goes.

use crate::failure::Failure;
use crate::output;
use clap::Args;
use slipfit_report::plot::Format;
use std::path::{Path, PathBuf};

// A doc comment here would replace that of the command.
#[derive(Debug, Args)]
pub(crate) struct AnswerArgs {
    /// Write the whole answer as JSON, `-` for standard output
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) json: Option<PathBuf>,

    /// Write a report to hand in as one page of HTML, its pictures inside
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) html: Option<PathBuf>,

    /// Write the tables as Markdown
    #[arg(long = "md", alias = "markdown", value_name = "PATH", help_heading = "Output")]
    pub(crate) markdown: Option<PathBuf>,

    /// Write the tables as LaTeX
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) latex: Option<PathBuf>,

    /// Write the numbers behind the picture as CSV
    #[arg(long, value_name = "PATH", help_heading = "Output")]
    pub(crate) csv: Option<PathBuf>,

    /// Draw data, fit and residuals; .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,

    /// Exit with status 1 on any warning
    #[arg(long, help_heading = "Output")]
    pub(crate) strict: bool,

    /// Print nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,
}

// One row a file.
#[derive(Debug, Args)]
pub(crate) struct TableArgs {
    /// One row per file as a table, written as files are done: .csv, .json, .md, .tex or .parquet
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) table: Option<PathBuf>,

    /// Go on with a table that was interrupted
    #[arg(long, requires = "table", help_heading = "Output")]
    pub(crate) resume: bool,
}

impl AnswerArgs {
    /// The format of the picture asked for, by the ending of its name.
    pub(crate) fn plot_format(&self) -> Result<Option<Format>, Failure> {
        let Some(path) = &self.plot else { return Ok(None) };
        let unknown =
            || Failure::new(format!("--plot {}: no picture format is known by that ending", path.display()));
        Format::of(path).map(Some).ok_or_else(|| unknown().hint("name the file .svg or .png"))
    }

    /// The files asked for, with their flags.
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

    /// Whether one of them is standard output, which then has no room for the report.
    ///
    /// # Errors
    /// Two outputs into one stream could not be told apart.
    pub(crate) fn speaks(&self) -> Result<bool, Failure> {
        let spoken: Vec<&str> =
            self.files().filter(|(_, path)| output::is_stdout(path)).map(|f| f.0).collect();
        match spoken.as_slice() {
            [one, other, ..] => Err(Failure::new(format!("{one} and {other} both go to standard output"))
                .hint("name a file for all but one of them")),
            spoken => Ok(!spoken.is_empty()),
        }
    }
}

//! From an answer to the files, the report and the doubts of it.

use crate::args::AnswerArgs;
use crate::failure::Failure;
use crate::output;
use anstream::ColorChoice;
use slipfit_report::plot::{Format, Picture};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// Exit status of a doubtful answer under `--strict`.
const DOUBTFUL: u8 = 1;

type Bytes<'a> = &'a dyn Fn(&mut dyn Write) -> io::Result<()>;
type Text<'a> = &'a dyn Fn() -> String;

/// The ways out of an analysis.
pub(crate) struct Faces<'a> {
    pub(crate) picture: Option<Vec<u8>>,
    pub(crate) csv: Bytes<'a>,
    pub(crate) json: Bytes<'a>,
    pub(crate) html: Text<'a>,
    pub(crate) markdown: Text<'a>,
    pub(crate) latex: Text<'a>,
    pub(crate) report: &'a dyn Fn(&[&Path]) -> String,
    pub(crate) warnings: Vec<String>,
}

/// A figure in its file format.
pub(crate) fn drawn(picture: &Picture, format: Format) -> Result<Vec<u8>, Failure> {
    picture.render(format).ok_or_else(|| Failure::new("the picture could not be drawn"))
}

/// Writes the files asked for, then the report, then the doubts.
pub(crate) fn show(out: &AnswerArgs, faces: &Faces<'_>, color: ColorChoice) -> Result<ExitCode, Failure> {
    let spoken = out.speaks()?;
    let mut written: Vec<&Path> = Vec::new();
    if let (Some(path), Some(picture)) = (&out.plot, &faces.picture) {
        output::to_path(path, |o| o.write_all(picture))?;
        written.push(path);
    }
    for (flag, path) in out.files() {
        let text = |text: Text<'_>| output::to_path(path, |o| o.write_all(text().as_bytes()));
        match flag {
            "--json" => output::to_path(path, faces.json)?,
            "--csv" => output::to_path(path, faces.csv)?,
            "--html" => text(faces.html)?,
            "--md" => text(faces.markdown)?,
            _ => text(faces.latex)?,
        }
        if !output::is_stdout(path) {
            written.push(path);
        }
    }
    if !out.quiet {
        // On a terminal both streams meet: the doubts come after the answer.
        if !spoken {
            output::print(&(faces.report)(&written), color)?;
        }
        output::print_error(&faces.warnings.concat(), color);
    }
    let doubtful = out.strict && !faces.warnings.is_empty();
    Ok(if doubtful { ExitCode::from(DOUBTFUL) } else { ExitCode::SUCCESS })
}

//! From an answer to the files, the report and the warnings.

use crate::args::AnswerArgs;
use crate::failure::{Failure, WARNED};
use crate::output::{self, Outputs, Target};
use anstream::ColorChoice;

use slipfit_report::page::{self, Document};
use slipfit_report::plot::{Format, Picture};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

type Bytes<'a> = &'a dyn Fn(&mut dyn Write) -> io::Result<()>;
type Text<'a> = &'a dyn Fn() -> String;

/// Where an answer goes, checked.
pub(crate) struct Destinations {
    pub(crate) plot: Option<(Target, Format)>,
    /// With their flags.
    files: Vec<(&'static str, Target)>,
}

impl Destinations {
    /// Those of a run that reads `inputs`.
    pub(crate) fn new<'a>(
        out: &AnswerArgs,
        inputs: impl IntoIterator<Item = &'a Path>,
    ) -> Result<Self, Failure> {
        let mut outputs = Outputs::new(out.replace.force, inputs)?;
        let plot = plot_target(out, &mut outputs)?;
        let files = out.files().map(|(flag, path)| Ok((flag, outputs.add(flag, path)?)));
        Ok(Self { plot, files: files.collect::<Result<_, Failure>>()? })
    }
}

/// Where the picture goes, and the format that the ending of its name asks for.
pub(crate) fn plot_target(
    out: &AnswerArgs,
    outputs: &mut Outputs,
) -> Result<Option<(Target, Format)>, Failure> {
    let Some(path) = &out.plot else { return Ok(None) };
    let format = Format::of(path).ok_or_else(|| {
        Failure::new(format!("--plot {}: no picture format is known by that ending", path.display()))
            .hint("name the file .svg or .png")
    })?;
    Ok(Some((outputs.add("--plot", path)?, format)))
}

/// The ways out of an analysis.
pub(crate) struct Faces<'a> {
    pub(crate) picture: &'a dyn Fn() -> Picture,
    pub(crate) csv: Bytes<'a>,
    pub(crate) json: Bytes<'a>,
    pub(crate) document: &'a dyn Fn() -> Document<'a>,
    /// In place of the document's tables as Markdown and LaTeX.
    pub(crate) tables: Option<[Text<'a>; 2]>,
    pub(crate) report: &'a dyn Fn(&[&Path]) -> String,
    pub(crate) warnings: Vec<String>,
}

/// A figure in its file format.
pub(crate) fn drawn(picture: &Picture, format: Format) -> Result<Vec<u8>, Failure> {
    picture.render(format).ok_or_else(|| Failure::new("the picture could not be drawn"))
}

/// Writes the files asked for, then the report, then the warnings.
pub(crate) fn show(
    out: &AnswerArgs,
    to: &Destinations,
    faces: &Faces<'_>,
    color: ColorChoice,
) -> Result<ExitCode, Failure> {
    let mut written: Vec<&Path> = Vec::new();
    if let Some((target, format)) = &to.plot {
        let picture = drawn(&(faces.picture)(), *format)?;
        target.write(|o| o.write_all(&picture))?;
        written.push(target.named());
    }
    for (flag, target) in &to.files {
        let text = match (*flag, faces.tables) {
            ("--json", _) => {
                target.write(faces.json)?;
                None
            }
            ("--csv", _) => {
                target.write(faces.csv)?;
                None
            }
            ("--html", _) => Some(page::html(&(faces.document)())),
            ("--md", Some([markdown, _])) => Some(markdown()),
            ("--md", None) => Some(page::markdown(&(faces.document)())),
            (_, Some([_, latex])) => Some(latex()),
            (_, None) => Some(page::latex(&(faces.document)())),
        };
        if let Some(text) = text {
            target.write(|o| o.write_all(text.as_bytes()))?;
        }
        if !target.is_stdout() {
            written.push(target.named());
        }
    }
    if !out.quiet {
        // On a terminal both streams meet: the warnings come after the answer. Standard output
        // that holds an answer already has no room for the report.
        if !to.files.iter().any(|(_, target)| target.is_stdout()) {
            output::print(&(faces.report)(&written), color)?;
        }
        output::print_error(&faces.warnings.concat(), color);
    }
    let warned = out.strict && !faces.warnings.is_empty();
    Ok(if warned { ExitCode::from(WARNED) } else { ExitCode::SUCCESS })
}

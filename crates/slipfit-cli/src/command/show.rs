//! Writes the files, the report and the warnings of an answer.

use crate::args::AnswerArgs;
use crate::failure::{Failure, WARNED, WARNING, note_line, spelled};
use crate::output::{self, Outputs, Target};
use crate::version::provenance;
use anstream::ColorChoice;
use slipfit_report::plot::{Format, Picture};
use slipfit_report::{Document, Provenance, Report, page, terminal};
use std::path::Path;
use std::process::ExitCode;

/// Checked destinations of an answer.
pub(crate) struct Destinations {
    pub(crate) plot: Option<(Target, Format)>,
    /// With their flags.
    files: Vec<(&'static str, Target)>,
}

impl Destinations {
    /// The destinations of a run that reads `inputs`.
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

/// Destination of the figure, and the format given by its extension.
pub(crate) fn plot_target(
    out: &AnswerArgs,
    outputs: &mut Outputs,
) -> Result<Option<(Target, Format)>, Failure> {
    let Some(path) = &out.plot else { return Ok(None) };
    let format = Format::of(path).ok_or_else(|| {
        Failure::new(format!("--plot {}: no picture format with this extension is known", path.display()))
            .hint("name the file .svg or .png")
    })?;
    Ok(Some((outputs.add("--plot", path)?, format)))
}

/// A figure in its file format.
pub(crate) fn drawn(picture: &Picture, format: Format) -> Result<Vec<u8>, Failure> {
    picture.render(format).ok_or_else(|| Failure::new("the picture could not be drawn"))
}

/// Writes the requested files, then the report, then the warnings and a note on how the program was used.
pub(crate) fn show(
    out: &AnswerArgs,
    to: &Destinations,
    report: &dyn Report,
    note: Option<String>,
    color: ColorChoice,
) -> Result<ExitCode, Failure> {
    let document = report.document(&spelled);
    let mut written = Vec::new();
    if let Some((target, format)) = &to.plot {
        let picture = drawn(&report.figure(), *format)?;
        target.write(|o| o.write_all(&picture))?;
        written.push(target.named().display().to_string());
    }
    let provenance = provenance();
    for (flag, target) in &to.files {
        let text = |text: fn(&Document<'_>, &Provenance) -> String| {
            target.write(|o| o.write_all(text(&document, &provenance).as_bytes()))
        };
        match *flag {
            "--json" => target.write(|o| report.write_json(o))?,
            "--csv" => target.write(|o| report.write_csv(o))?,
            "--html" => text(page::html)?,
            "--md" => text(page::markdown)?,
            _ => text(page::latex)?,
        }
        if !target.is_stdout() {
            written.push(target.named().display().to_string());
        }
    }
    if !out.quiet {
        // On a terminal both streams appear together, so the warnings follow the answer. If an answer already
        // goes to standard output, the report is not printed there.
        if !to.files.iter().any(|(_, target)| target.is_stdout()) {
            output::print(&terminal::screen(&document, &written), color)?;
        }
        let warnings = document.warnings().iter().map(|w| terminal::warning(w, WARNING));
        let note = note.map(|note| note_line(&note));
        output::print_error(&warnings.chain(note).collect::<String>(), color);
    }
    let warned = out.strict && !document.warnings().is_empty();
    Ok(if warned { ExitCode::from(WARNED) } else { ExitCode::SUCCESS })
}

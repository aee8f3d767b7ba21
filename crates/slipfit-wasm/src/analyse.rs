//! From bytes to the answer and all of its reports.

use crate::refusal::{Advice, Refusal};
use crate::spelling::{command, python};
use crate::trace::Trace;
use crate::words::words;
use crate::{Analysis, File, Options, preview};
use serde::Serialize;
use serde_json::Value;
use slipfit::answer::Warning;
use slipfit::{SignalKind, levels, resonance, ringdown};
use slipfit_io::{Format, Reading, SweepReading};
use slipfit_report::plot::Format as PictureFormat;
use slipfit_report::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, Provenance, Report, page, terminal};

/// An answer with everything a page shows of it or hands out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answered {
    /// Which analysis answered.
    pub analysis: Analysis,
    /// The whole answer: what the command writes with `--json`, byte for byte.
    pub json: String,
    /// Words, tables and panels: [`slipfit_report::Document`].
    pub document: Value,
    /// What limits the answer.
    pub warnings: Vec<RaisedWarning>,
    /// The record, where it was one.
    pub trace: Option<Trace>,
    /// The numbers behind the figure.
    pub csv: String,
    /// The figure.
    pub svg: String,
    /// The report to hand in.
    pub html: String,
    /// The same as Markdown.
    pub markdown: String,
    /// The report of a screen of 80 columns.
    pub screen: String,
    /// The command that gives the same answer.
    pub command: String,
    /// The call in Python that does.
    pub python: String,
}

/// A warning and what helps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RaisedWarning {
    /// Machine-readable, as in the JSON.
    pub code: &'static str,
    /// What was found.
    pub message: String,
    /// What helps.
    pub hints: Vec<Advice>,
}

/// Reads a file and analyses it; `reference` is a friction-free curve for a resonance curve.
///
/// # Errors
/// [`Refusal`], with what would help, where the file cannot be read or analysed.
pub fn analyse(
    file: &File<'_>,
    reference: Option<&File<'_>>,
    options: &Options,
) -> Result<Answered, Refusal> {
    let analysis = match options.analysis {
        Some(analysis) => analysis,
        None => preview(file, options)?.analysis,
    };
    match analysis {
        Analysis::Ringdown => ring_down(file, options),
        Analysis::Resonance => curve(file, reference, options),
        Analysis::Levels => level_sweep(file, options),
    }
}

fn ring_down(file: &File<'_>, chosen: &Options) -> Result<Answered, Refusal> {
    let reading = slipfit_io::read_from(file.bytes, file.name, &chosen.read_options(Analysis::Ringdown)?)?;
    let mut options = chosen.ringdown()?;
    check_used(&reading, &options, chosen)?;
    let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Ringdown.core(), file.name, &e);
    check_constant(chosen, reading.record.unit()).map_err(refused)?;
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    let answer = ringdown::analyse(&reading.record, &options).map_err(refused)?;
    options.check_reached(&answer).map_err(refused)?;
    let analysed =
        AnalysedRingdown { file: file.name.as_ref(), reading: &reading, options: &options, answer: &answer };
    let mut answered = report(Analysis::Ringdown, &analysed, &answer.warnings, file, None, chosen)?;
    answered.trace = Some(Trace::new(&reading, &answer));
    Ok(answered)
}

fn curve(file: &File<'_>, reference: Option<&File<'_>>, chosen: &Options) -> Result<Answered, Refusal> {
    let read = chosen.read_options(Analysis::Resonance)?;
    let read = |file: &File<'_>| slipfit_io::read_sweep_from(file.bytes, file.name, &read);
    let free: Option<SweepReading> = reference.map(read).transpose()?;
    let reading = read(file)?;
    let mut options = chosen.resonance()?;
    if let Some(free) = &free {
        let (unit, other) = (reading.curve.unit(), free.curve.unit());
        if unit != other {
            return Err(Refusal::new(format!(
                "reference {}: its amplitudes are in `{other}`, those of {} in `{unit}`; unit says what both are in",
                free.report.path, reading.report.path
            )));
        }
        options.reference = Some(free.curve.clone());
    }
    let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Resonance.core(), file.name, &e);
    check_constant(chosen, reading.curve.unit()).map_err(refused)?;
    let answer = resonance::analyse(&reading.curve, &options).map_err(refused)?;
    let analysed =
        AnalysedCurve { reading: &reading, reference: free.as_ref(), options: &options, answer: &answer };
    report(Analysis::Resonance, &analysed, &answer.warnings, file, reference, chosen)
}

fn level_sweep(file: &File<'_>, chosen: &Options) -> Result<Answered, Refusal> {
    let reading =
        slipfit_io::read_levels_from(file.bytes, file.name, &chosen.read_options(Analysis::Levels)?)?;
    let mut options = chosen.levels()?;
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Levels.core(), file.name, &e);
    check_constant(chosen, reading.levels.unit()).map_err(refused)?;
    let answer = levels::analyse(&reading.levels, &options).map_err(refused)?;
    let analysed = AnalysedLevels { reading: &reading, options: &options, answer: &answer };
    report(Analysis::Levels, &analysed, &answer.warnings, file, None, chosen)
}

/// A choice that would change nothing is a mistake, as it is on a command line.
fn check_used(reading: &Reading, options: &ringdown::Options, chosen: &Options) -> Result<(), Refusal> {
    let amplitudes = matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    if let Some(f) = options.frequency_hz.filter(|_| !amplitudes) {
        return Err(Refusal::new(format!(
            "frequency {f} Hz: only for a record of amplitudes; this one oscillates and has its own \
             frequency. A band says where to look for it"
        )));
    }
    let has_sheet = chosen.of(Analysis::Ringdown).any(|(name, _)| name == "sheet");
    if has_sheet && reading.report.format == Format::Text {
        return Err(Refusal::new(
            "sheet: a text has no sheets; part chooses one of several tables side by side, run one of several runs",
        ));
    }
    Ok(())
}

fn check_constant(chosen: &Options, unit: &str) -> Result<(), slipfit::Error> {
    chosen.coordinate().map_or(Ok(()), |coordinate| coordinate.check_unit(unit))
}

fn report(
    analysis: Analysis,
    analysed: &dyn Report,
    warnings: &[Warning],
    file: &File<'_>,
    reference: Option<&File<'_>>,
    chosen: &Options,
) -> Result<Answered, Refusal> {
    let failed = |what: &str, e: &dyn std::fmt::Display| Refusal::new(format!("{}: {what}: {e}", file.name));
    let document = analysed.document(&words);
    let reference = reference.map(|reference| reference.name);
    let command = command(analysis, file.name, reference, chosen);
    let provenance = Provenance { version: crate::simulate::VERSION.to_owned(), call: command.clone() };
    let text = |write: &dyn Fn(&mut Vec<u8>) -> std::io::Result<()>| {
        let mut bytes = Vec::new();
        write(&mut bytes).map_err(|e| failed("the report", &e))?;
        String::from_utf8(bytes).map_err(|e| failed("the report", &e))
    };
    let svg = analysed.figure().render(PictureFormat::Svg).unwrap_or_default();
    let raised = |w: &Warning| RaisedWarning {
        code: w.code(),
        message: w.to_string(),
        hints: w.hints().iter().map(Advice::from).collect(),
    };
    Ok(Answered {
        analysis,
        json: text(&|out| analysed.write_json(out))?,
        csv: text(&|out| analysed.write_csv(out))?,
        html: page::html(&document, &provenance),
        markdown: page::markdown(&document, &provenance),
        screen: terminal::screen(&document, &[]),
        svg: String::from_utf8(svg).map_err(|e| failed("the figure", &e))?,
        warnings: warnings.iter().map(raised).collect(),
        python: python(analysis, file.name, reference, chosen),
        command,
        trace: None,
        document: serde_json::to_value(&document).map_err(|e| failed("the report", &e))?,
    })
}

//! A file opened by a user: previewed, analysed again after each change of options, and reported on request.

use crate::analysed::Analysed;
use crate::preview::{CachedPreview, Preview};
use crate::refusal::{Advice, Refusal};
use crate::spelling::{command, python};
use crate::trace::Trace;
use crate::words::words;
use crate::{Analysis, File, Options};
use serde::{Deserialize, Serialize};
use serde_json::value::{RawValue, to_raw_value};
use slipfit::answer::Warning;
use slipfit_io::{ReadOptions, Reading};
use slipfit_report::plot::Format as PictureFormat;
use slipfit_report::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, Provenance, Report, page};
use std::fmt::Display;
use std::io::Write;

/// A file with its friction-free reference, what was read from it, and the last answer.
///
/// A record is read once: an analysis uses what the preview has read, unless options change how it is read.
///
/// ```
/// use slipfit_wasm::{Options, Output, Session};
/// let mut text = String::from("time (s),angle (rad)\n");
/// for i in 0..600 {
///     let t = 0.05 * f64::from(i);
///     text += &format!("{t},{}\n", 0.3 * (-0.05 * t).exp() * (6.3 * t).cos());
/// }
/// let mut session = Session::new("swing.csv", text.into_bytes(), None);
/// let answered = session.analyse(&Options::default()).unwrap();
/// assert!(answered.json.starts_with("{\n  \"schema\": \"slipfit/ringdown-1\""));
/// assert_eq!(answered.command, "slipfit ringdown swing.csv");
/// assert!(session.output(Output::Svg).unwrap().starts_with("<svg"));
/// ```
#[derive(Debug)]
pub struct Session {
    name: String,
    bytes: Vec<u8>,
    reference: Option<(String, Vec<u8>)>,
    cached_preview: Option<CachedPreview>,
    /// The record, as read with these options.
    record: Option<(ReadOptions, Reading)>,
    answered: Option<Last>,
}

/// The last answer, and the calls that reproduce it elsewhere.
#[derive(Debug)]
struct Last {
    analysed: Analysed,
    command: String,
    python: String,
}

/// What a page shows of an answer.
#[derive(Debug, Clone, Serialize)]
pub struct Answered {
    /// The analysis that was made.
    pub analysis: Analysis,
    /// The whole answer: what the command writes with `--json`, byte for byte.
    pub json: String,
    /// Words, tables and panels as JSON: [`slipfit_report::Document`].
    pub document: Box<RawValue>,
    /// What limits the answer.
    pub warnings: Vec<RaisedWarning>,
    /// The command that gives the same answer.
    pub command: String,
    /// The call in Python that gives the same answer.
    pub python: String,
}

/// A warning and its hints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RaisedWarning {
    /// Machine-readable, as in the JSON.
    pub code: &'static str,
    /// What was found.
    pub message: String,
    /// What helps.
    pub hints: Vec<Advice>,
}

/// Further outputs of an answer, made on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Output {
    /// The numbers behind the figure.
    Csv,
    /// The figure.
    Svg,
    /// The report to hand in.
    Html,
    /// The same report as Markdown.
    Markdown,
}

impl Session {
    /// A file; `reference` is a friction-free curve for a resonance curve, by name and bytes.
    #[must_use]
    pub fn new(name: &str, bytes: Vec<u8>, reference: Option<(&str, Vec<u8>)>) -> Self {
        let reference = reference.map(|(name, bytes)| (name.to_owned(), bytes));
        Self { name: name.to_owned(), bytes, reference, cached_preview: None, record: None, answered: None }
    }

    /// Looks at the file without an analysis.
    ///
    /// # Errors
    /// [`Refusal`] if it holds no table, or has a format that cannot be read here.
    ///
    /// ```
    /// use slipfit_wasm::{Analysis, Options, Session};
    /// let bytes = b"f (Hz),R (V)\n99,0.1\n100,0.7\n101,0.2\n".to_vec();
    /// let seen = Session::new("sweep.csv", bytes, None).preview(&Options::default()).unwrap();
    /// assert_eq!((seen.analysis, seen.tables[0].columns.len()), (Analysis::Resonance, 2));
    /// ```
    pub fn preview(&mut self, options: &Options) -> Result<Preview, Refusal> {
        let read_by = CachedPreview::read_by(options)?;
        if let Some(cached) = self.cached_preview.as_ref().filter(|cached| cached.read_by == read_by) {
            return Ok(cached.preview(options.analysis));
        }
        let (cached, record) = CachedPreview::new(&File { name: &self.name, bytes: &self.bytes }, read_by)?;
        self.answered = None;
        self.record = record.map(|record| (cached.read_by.clone(), record));
        Ok(self.cached_preview.insert(cached).preview(options.analysis))
    }

    /// Analyses the file.
    ///
    /// # Errors
    /// [`Refusal`], with hints, if the file cannot be read or analysed.
    pub fn analyse(&mut self, options: &Options) -> Result<Answered, Refusal> {
        let analysis = match options.analysis {
            Some(analysis) => analysis,
            None => self.preview(options)?.analysis,
        };
        self.answered = None;
        let file = File { name: &self.name, bytes: &self.bytes };
        let analysed = match analysis {
            Analysis::Ringdown => {
                let record = record(&mut self.record, &file, options.read_options(analysis)?)?;
                Analysed::ringdown(file.name, record, options)?
            }
            Analysis::Resonance => {
                let reference = self.reference.as_ref().map(|(name, bytes)| File { name, bytes });
                Analysed::resonance(&file, reference.as_ref(), options)?
            }
            Analysis::Levels => Analysed::levels(&file, options)?,
        };
        let reference = self.reference.as_ref().map(|(name, _)| name.as_str());
        let reference = reference.filter(|_| analysis == Analysis::Resonance);
        self.answered = Some(Last {
            analysed,
            command: command(analysis, &self.name, reference, options),
            python: python(analysis, &self.name, reference, options),
        });
        self.answer(analysis)
    }

    fn answer(&self, analysis: Analysis) -> Result<Answered, Refusal> {
        let Last { analysed, command, python } = self.last()?;
        let raised = |w: &Warning| RaisedWarning {
            code: w.code(),
            message: w.to_string(),
            hints: w.hints().iter().map(Advice::from).collect(),
        };
        let document = self.reported(|report| to_raw_value(&report.document(&words)))?;
        Ok(Answered {
            analysis,
            json: self.written(|report, out| report.write_json(out))?,
            document: document.map_err(|e| self.failed(&e))?,
            warnings: analysed.warnings().iter().map(raised).collect(),
            command: command.clone(),
            python: python.clone(),
        })
    }

    /// The record of the last answer with its fit, for drawing; `None` for a curve or for levels.
    #[must_use]
    pub fn trace(&self) -> Option<Trace> {
        match (&self.record, &self.answered) {
            (Some((_, reading)), Some(Last { analysed: Analysed::Ringdown { answer, .. }, .. })) => {
                Some(Trace::new(&reading.record, answer))
            }
            _ => None,
        }
    }

    /// Another output of the last answer.
    ///
    /// # Errors
    /// [`Refusal`] without an answer.
    pub fn output(&self, output: Output) -> Result<String, Refusal> {
        let call = self.last()?.command.clone();
        let provenance = Provenance { version: crate::simulate::VERSION.to_owned(), call };
        match output {
            Output::Csv => self.written(|report, out| report.write_csv(out)),
            Output::Svg => {
                let svg = self.reported(|report| report.figure().render(PictureFormat::Svg))?;
                self.text(svg.unwrap_or_default())
            }
            Output::Html => self.reported(|report| page::html(&report.document(&words), &provenance)),
            Output::Markdown => self.reported(|report| page::markdown(&report.document(&words), &provenance)),
        }
    }

    fn last(&self) -> Result<&Last, Refusal> {
        self.answered.as_ref().ok_or_else(|| self.failed(&"there is no answer yet"))
    }

    /// The result of `make` for the report of the last answer.
    fn reported<T>(&self, make: impl FnOnce(&dyn Report) -> T) -> Result<T, Refusal> {
        match (&self.last()?.analysed, &self.record) {
            (Analysed::Ringdown { options, answer }, Some((_, reading))) => {
                Ok(make(&AnalysedRingdown { file: self.name.as_ref(), reading, options, answer }))
            }
            (Analysed::Ringdown { .. }, None) => Err(self.failed(&"there is no record")),
            (Analysed::Resonance { reading, reference, options, answer }, _) => {
                Ok(make(&AnalysedCurve { reading, reference: reference.as_deref(), options, answer }))
            }
            (Analysed::Levels { reading, options, answer }, _) => {
                Ok(make(&AnalysedLevels { reading, options, answer }))
            }
        }
    }

    fn written(
        &self,
        write: impl FnOnce(&dyn Report, &mut dyn Write) -> std::io::Result<()>,
    ) -> Result<String, Refusal> {
        let mut bytes = Vec::new();
        self.reported(|report| write(report, &mut bytes))?.map_err(|e| self.failed(&e))?;
        self.text(bytes)
    }

    fn text(&self, bytes: Vec<u8>) -> Result<String, Refusal> {
        String::from_utf8(bytes).map_err(|e| self.failed(&e))
    }

    fn failed(&self, why: &dyn Display) -> Refusal {
        Refusal::new(format!("{}: the report: {why}", self.name))
    }
}

/// Reads the record with `read_by`, unless that is the record already held.
fn record<'a>(
    cached: &'a mut Option<(ReadOptions, Reading)>,
    file: &File<'_>,
    read_by: ReadOptions,
) -> Result<&'a Reading, Refusal> {
    let fits = cached.as_ref().is_some_and(|(by, _)| *by == read_by);
    let read = match cached.take().filter(|_| fits) {
        Some(read) => read,
        None => {
            let reading = slipfit_io::read_from(file.bytes, file.name, &read_by)?;
            (read_by, reading)
        }
    };
    Ok(&cached.insert(read).1)
}

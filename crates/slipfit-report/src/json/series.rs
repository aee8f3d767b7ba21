//! The answer to a series, including each measurement on its own.

use super::options::Constant;
use super::{VERSION, write};
use crate::{AnalysedSeries, Sentence};
use serde::Serialize;
use slipfit::Parameters;
use slipfit::answer::Warning;
use slipfit::series::{ConditionRow, Joint, LawFit, RepeatScatter, SingleAnswer};
use std::io::{self, Write};

/// Writes the whole answer to a series.
pub fn series(out: &mut dyn Write, analysed: &AnalysedSeries<'_>) -> io::Result<()> {
    write(out, &SeriesEnvelope::new(analysed))
}

#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct SeriesEnvelope<'a> {
    /// Name and version of this contract.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The command that wrote it.
    command: &'static str,
    /// The manifest as named by the caller.
    manifest: &'a str,
    /// Its title; empty without one.
    title: &'a str,
    /// What the conditions are.
    condition: &'a str,
    /// Unit of their values; empty if unknown.
    condition_unit: &'a str,
    /// Unit to which displacements were converted.
    unit: &'a str,
    /// Parameters shared by all measurements.
    shared: Vec<&'static str>,
    /// The constant that turns displacements into forces.
    calibration: Option<Constant>,
    /// The answer in words.
    sentence: String,
    /// One row for each condition: Table 1 of the paper.
    table: &'a [ConditionRow],
    /// p value of the agreement of ring-down and resonance at every condition.
    agreement_p_value: Option<f64>,
    /// Scatter of repeated measurements beyond their errors; null if there is none.
    scatter: Option<RepeatScatter>,
    /// The joint fit; null if there is none.
    joint: Option<&'a Joint>,
    /// Laws of friction against load, best first; empty without numeric conditions.
    laws: &'a [LawFit],
    /// Each measurement alone, in the order of the manifest.
    measurements: Vec<Alone<'a>>,
    /// What limits the answer.
    warnings: &'a [Warning],
}

impl<'a> SeriesEnvelope<'a> {
    fn new(analysed: &AnalysedSeries<'a>) -> Self {
        let (answer, heading, options) = (analysed.answer, analysed.heading, analysed.options);
        let shared = [
            (heading.shared.natural_frequency, "natural_frequency"),
            (heading.shared.drive_amplitude, "drive_amplitude"),
            (heading.shared.decay_rate, "decay_rate"),
        ];
        Self {
            schema: "slipfit/series-1",
            version: VERSION,
            command: "series",
            manifest: &heading.path,
            title: &heading.title,
            condition: &heading.condition,
            condition_unit: &heading.condition_unit,
            unit: &options.unit,
            shared: shared.into_iter().filter_map(|(is, name)| is.then_some(name)).collect(),
            calibration: options.calibration.and_then(Constant::new),
            sentence: answer.sentence(),
            table: &answer.table,
            agreement_p_value: answer.agreement_p_value,
            scatter: answer.scatter,
            joint: answer.joint.as_ref(),
            laws: &answer.laws,
            measurements: (0..answer.singles.len()).map(|i| Alone::new(analysed, i)).collect(),
            warnings: &answer.warnings,
        }
    }
}

/// One measurement of a series on its own.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Alone<'a> {
    /// Its name.
    name: &'a str,
    /// `ringdown`, `sweep` or `levels`.
    #[cfg_attr(test, schemars(extend("enum" = ["ringdown", "sweep", "levels"])))]
    kind: &'static str,
    /// Its condition.
    condition: &'a str,
    /// Its file.
    path: &'a str,
    /// SHA-256 of its bytes.
    sha256: &'a str,
    /// Unit of the file.
    unit: &'a str,
    /// Factor that converts it to the unit of the series.
    scale: f64,
    /// Why it could not be analysed; null if it was.
    error: Option<String>,
    /// Its answer in words; empty without one.
    sentence: String,
    /// Its parameters; empty without an answer.
    parameters: Parameters,
    /// What limits its answer.
    warnings: &'a [Warning],
    /// Other remarks for the reader.
    notes: &'a [String],
}

impl<'a> Alone<'a> {
    fn new(analysed: &AnalysedSeries<'a>, i: usize) -> Self {
        let (name, single) = &analysed.answer.singles[i];
        let (input, measurement) = (&analysed.inputs[i], &analysed.measurements[i]);
        let (sentence, warnings): (String, &[Warning]) = match single {
            Ok(SingleAnswer::RingDown(a)) => (a.sentence(), &a.warnings),
            Ok(SingleAnswer::Sweep(a)) => (a.sentence(), &a.warnings),
            Ok(SingleAnswer::Levels(a)) => (a.sentence(), &a.warnings),
            _ => (String::new(), &[]),
        };
        Self {
            name,
            kind: input.kind,
            condition: &measurement.condition.label,
            path: &input.path,
            sha256: &input.sha256,
            unit: &input.unit,
            scale: measurement.scale,
            error: single.as_ref().err().map(ToString::to_string),
            sentence,
            parameters: single.as_ref().map(|a| a.parameters().clone()).unwrap_or_default(),
            warnings,
            notes: &input.notes,
        }
    }
}

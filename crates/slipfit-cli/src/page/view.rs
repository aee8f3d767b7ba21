//! What each analysis has to say in a report.

use super::method::{of_levels, of_resonance, of_ringdown, of_series};
use super::{Document, Doubt, Input, Table};
use crate::command::levels::AnalysedLevels;
use crate::command::resonance::AnalysedCurve;
use crate::command::ringdown::Analysed;
use crate::command::series::AnalysedSeries;
use crate::{plot, report};
use slipfit::SignalKind;
use slipfit_io::SweepReading;
use std::path::Path;

pub(crate) fn ringdown<'a>(analysed: &'a Analysed<'a>) -> Document<'a> {
    let answer = analysed.answer;
    let mut models = Table::new("Models on the same data", report::ringdown::model_rows(answer));
    models.chosen = answer.comparison.iter().position(|c| c.model == answer.model);
    models.note = model_note(answer.comparison.iter().all(|c| c.converged));
    let bare = matches!(analysed.reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    Document {
        command: "ringdown",
        subject: name_of(analysed.file),
        sentence: answer.sentence(),
        parameters: report::ringdown::told(answer),
        tables: vec![models],
        facts: report::account::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_ringdown(answer, bare),
        inputs: vec![Input {
            path: analysed.file.display().to_string(),
            sha256: analysed.reading.report.sha256.clone(),
        }],
        pictures: Box::new(|| plot::ringdown_panels(analysed)),
    }
}

pub(crate) fn resonance<'a>(analysed: &'a AnalysedCurve<'a>) -> Document<'a> {
    let answer = analysed.answer;
    let mut models = Table::new("Models on the same data", report::resonance::model_rows(answer));
    models.chosen = answer.comparison.iter().position(|c| c.model == answer.model);
    models.note = model_note(answer.comparison.iter().all(|c| c.converged));
    let input = |r: &SweepReading| Input { path: r.report.path.clone(), sha256: r.report.sha256.clone() };
    Document {
        command: "resonance",
        subject: name_of(Path::new(&analysed.reading.report.path)),
        sentence: answer.sentence(),
        parameters: report::resonance::told(answer),
        tables: vec![models],
        facts: report::resonance::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_resonance(answer),
        inputs: std::iter::once(analysed.reading).chain(analysed.reference).map(input).collect(),
        pictures: Box::new(|| plot::resonance_panels(analysed)),
    }
}

pub(crate) fn levels<'a>(analysed: &'a AnalysedLevels<'a>) -> Document<'a> {
    let answer = analysed.answer;
    Document {
        command: "levels",
        subject: name_of(Path::new(&analysed.reading.path)),
        sentence: report::levels_sentence(answer),
        parameters: report::levels::told(answer),
        tables: Vec::new(),
        facts: report::levels::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_levels(answer),
        inputs: vec![Input { path: analysed.reading.path.clone(), sha256: analysed.reading.sha256.clone() }],
        pictures: Box::new(|| plot::levels_panels(analysed)),
    }
}

pub(crate) fn series<'a>(analysed: &'a AnalysedSeries<'a>) -> Document<'a> {
    let answer = analysed.answer;
    let title = &analysed.manifest.title;
    let mut table = Table::new("Friction and damping at each condition", report::series::rows(analysed));
    table.note = "z: difference of the two ways over its standard error.".to_owned();
    let manifest =
        Input { path: analysed.path.display().to_string(), sha256: analysed.manifest.sha256.clone() };
    let files = analysed.inputs.iter().map(|i| Input { path: i.path.clone(), sha256: i.sha256.clone() });
    Document {
        command: "series",
        subject: if title.is_empty() { name_of(analysed.path) } else { title.clone() },
        sentence: report::series_sentence(answer),
        parameters: Vec::new(),
        tables: vec![table],
        facts: report::series::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_series(answer),
        inputs: std::iter::once(manifest).chain(files).collect(),
        pictures: Box::new(|| plot::series_panels(analysed)),
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn model_note(settled: bool) -> String {
    if settled { String::new() } else { format!("* {}", report::UNSETTLED) }
}

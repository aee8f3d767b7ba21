//! What each analysis has to say in a report.

use super::method::{of_levels, of_resonance, of_ringdown, of_series};
use super::{Document, Doubt, Input, Table};
use crate::AnalysedCurve;
use crate::AnalysedLevels;
use crate::AnalysedRingdown;
use crate::AnalysedSeries;
use crate::Provenance;
use crate::Sentence;
use crate::{plot, terminal};
use slipfit::SignalKind;
use slipfit_io::SweepReading;
use std::path::Path;

/// The report of a ring-down.
pub fn ringdown<'a>(analysed: &'a AnalysedRingdown<'a>, provenance: &'a Provenance) -> Document<'a> {
    let answer = analysed.answer;
    let mut models = Table::new("Models on the same data", terminal::ringdown::model_rows(answer));
    models.chosen = answer.comparison.iter().position(|c| c.model == answer.model);
    models.note = model_note(answer.comparison.iter().all(|c| c.converged));
    let bare = matches!(analysed.reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    Document {
        provenance,
        command: "ringdown",
        subject: name_of(analysed.file),
        sentence: answer.sentence(),
        parameters: terminal::ringdown::told(answer),
        tables: vec![models],
        facts: terminal::account::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_ringdown(answer, bare),
        inputs: vec![Input {
            path: analysed.file.display().to_string(),
            sha256: analysed.reading.report.sha256.clone(),
        }],
        pictures: Box::new(|| plot::ringdown_panels(analysed)),
    }
}

/// The report of a resonance curve.
pub fn resonance<'a>(analysed: &'a AnalysedCurve<'a>, provenance: &'a Provenance) -> Document<'a> {
    let answer = analysed.answer;
    let mut models = Table::new("Models on the same data", terminal::resonance::model_rows(answer));
    models.chosen = answer.comparison.iter().position(|c| c.model == answer.model);
    models.note = model_note(answer.comparison.iter().all(|c| c.converged));
    let input = |r: &SweepReading| Input { path: r.report.path.clone(), sha256: r.report.sha256.clone() };
    Document {
        provenance,
        command: "resonance",
        subject: name_of(Path::new(&analysed.reading.report.path)),
        sentence: answer.sentence(),
        parameters: terminal::resonance::told(answer),
        tables: vec![models],
        facts: terminal::resonance::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_resonance(answer),
        inputs: std::iter::once(analysed.reading).chain(analysed.reference).map(input).collect(),
        pictures: Box::new(|| plot::resonance_panels(analysed)),
    }
}

/// The report of drive levels.
pub fn levels<'a>(analysed: &'a AnalysedLevels<'a>, provenance: &'a Provenance) -> Document<'a> {
    let answer = analysed.answer;
    Document {
        provenance,
        command: "levels",
        subject: name_of(Path::new(&analysed.reading.path)),
        sentence: answer.sentence(),
        parameters: terminal::levels::told(answer),
        tables: Vec::new(),
        facts: terminal::levels::account(analysed),
        warnings: answer.warnings.iter().map(|w| Doubt { code: w.code(), text: w.to_string() }).collect(),
        method: of_levels(answer),
        inputs: vec![Input { path: analysed.reading.path.clone(), sha256: analysed.reading.sha256.clone() }],
        pictures: Box::new(|| plot::levels_panels(analysed)),
    }
}

/// The report of a series.
pub fn series<'a>(analysed: &'a AnalysedSeries<'a>, provenance: &'a Provenance) -> Document<'a> {
    let answer = analysed.answer;
    let title = &analysed.heading.title;
    let mut table = Table::new("Friction and damping at each condition", terminal::series::rows(analysed));
    table.note = "z: difference of the two ways over its standard error.".to_owned();
    let manifest = Input { path: analysed.heading.path.clone(), sha256: analysed.heading.sha256.clone() };
    let files = analysed.inputs.iter().map(|i| Input { path: i.path.clone(), sha256: i.sha256.clone() });
    Document {
        provenance,
        command: "series",
        subject: if title.is_empty() { name_of(Path::new(&analysed.heading.path)) } else { title.clone() },
        sentence: answer.sentence(),
        parameters: Vec::new(),
        tables: vec![table],
        facts: terminal::series::account(analysed),
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
    if settled { String::new() } else { format!("* {}", terminal::UNSETTLED) }
}

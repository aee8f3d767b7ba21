//! `slipfit series`: several measurements of one oscillator and their joint result.

use super::show::{Destinations, show};
use crate::args::SeriesArgs;
use crate::failure::{Failure, spelled};
use crate::manifest::{self, Entry, Source};
use crate::progress;
use anstream::ColorChoice;
use slipfit::answer::hint::Analysis;
use slipfit::model::displacement::DisplacementUnit;
use slipfit::series::{Data, Measurement, Options, analyse, common_unit};
use slipfit_io::Note;
use slipfit_report::{AnalysedSeries, SeriesHeading, SeriesInput as Input};
use std::process::ExitCode;

pub(crate) fn run(args: &SeriesArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let manifest = manifest::read(&args.manifest)?;
    let inputs = std::iter::once(args.manifest.as_path()).chain(manifest.inputs());
    let to = Destinations::new(&args.out, inputs)?;
    let mut measurements = Vec::new();
    let mut inputs = Vec::new();
    for entry in &manifest.entries {
        let (data, input) = progress::with_spinner("reading", args.out.quiet, || read(entry))?;
        inputs.push(input);
        measurements.push(Measurement {
            name: entry.name.clone(),
            condition: entry.condition.clone(),
            data,
            scale: 1.0,
        });
    }
    let first = inputs.first().map_or("", |i| i.unit.as_str());
    let coordinate = manifest.calibration.map(|(_, coordinate)| coordinate);
    let unit = common_unit(coordinate, manifest.unit.as_deref(), first);
    for ((measurement, input), entry) in measurements.iter_mut().zip(&mut inputs).zip(&manifest.entries) {
        measurement.scale = scale(entry, input, &unit)?;
    }
    let mut options = Options::default();
    options.shared = manifest.shared;
    options.calibration = manifest.calibration.map(|(constant, _)| constant);
    options.unit = unit;
    options.condition_unit = manifest.condition_unit.clone();
    let answer = progress::with_spinner("analysing", args.out.quiet, || analyse(&measurements, &options))
        .map_err(|e| Failure::analysing(Analysis::Resonance, &args.manifest, &e))?;
    let heading = SeriesHeading {
        path: args.manifest.display().to_string(),
        sha256: manifest.sha256.clone(),
        title: manifest.title.clone(),
        condition: manifest.condition.clone(),
        condition_unit: manifest.condition_unit.clone(),
        shared: manifest.shared,
    };
    let analysed = AnalysedSeries {
        heading: &heading,
        inputs: &inputs,
        measurements: &measurements,
        options: &options,
        answer: &answer,
    };
    show(&args.out, &to, &analysed, None, color)
}

/// Remarks on what was read, with the flags of this program.
fn in_flags(notes: &[Note]) -> Vec<String> {
    notes.iter().map(|note| note.spelled(&spelled)).collect()
}

fn read(entry: &Entry) -> Result<(Data, Input), Failure> {
    let (data, mut input) = match &entry.source {
        Source::Ringdown { file, reading, options } => {
            let reading = slipfit_io::read(file, reading)?;
            let mut options = options.clone();
            options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "ringdown",
                unit: reading.record.displacement_unit(),
                notes: in_flags(&reading.report.notes),
            };
            (Data::RingDown { record: Box::new(reading.record), options: Box::new(options) }, input)
        }
        Source::Sweep { files, reference, reading, options, drive_unit } => {
            let [own, of_reference] = super::resonance::reading_options(reading, files, reference.as_deref());
            let reference = super::resonance::read_reference(reference.as_deref(), &of_reference)?;
            let given = ((**options).clone(), drive_unit.clone());
            let (reading, options) = super::resonance::prepare(files, &own, given, reference.as_ref())?;
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "sweep",
                unit: reading.curve.unit().to_owned(),
                notes: in_flags(&reading.report.notes),
            };
            (Data::Sweep { curve: Box::new(reading.curve), options: Box::new(options) }, input)
        }
        Source::Levels { file, reading, options } => {
            let (reading, options) = super::levels::prepare(file, reading, options.clone())?;
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "levels",
                unit: reading.levels.unit().to_owned(),
                notes: in_flags(&reading.report.notes),
            };
            (Data::Levels { levels: Box::new(reading.levels), options: Box::new(options) }, input)
        }
    };
    input.notes.extend(entry.notes.iter().cloned());
    Ok((data, input))
}

/// The factor from the unit of a measurement to the common one.
fn scale(entry: &Entry, input: &mut Input, unit: &str) -> Result<f64, Failure> {
    if let Some(scale) = entry.scale {
        return Ok(scale);
    }
    if input.unit.is_empty() && !unit.is_empty() {
        input
            .notes
            .push(format!("no unit is named: its numbers were taken as {unit}; unit or scale gives another"));
        return Ok(1.0);
    }
    DisplacementUnit::factor(&input.unit, unit).map_err(|_| {
        Failure::new(format!("{}: its unit is `{}`, that of the series `{unit}`", entry.name, input.unit))
            .hint("the key scale gives the factor, the key unit the unit of the file")
    })
}

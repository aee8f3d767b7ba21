//! `slipfit series`: several measurements of one oscillator and what they agree on.

use super::show::{Destinations, Faces, show};
use crate::args::{Command, SeriesArgs};
use crate::failure::{Failure, spelled, warned};
use crate::manifest::{self, Asked, Manifest};
use crate::version::provenance;
use anstream::ColorChoice;
use slipfit::series::{Data, Measurement, Options, analyse};
use slipfit_io::Note;
use slipfit_report::{AnalysedSeries, SeriesHeading, SeriesInput as Input, json, page, plot, terminal};
use std::process::ExitCode;

pub(crate) fn run(args: &SeriesArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    let manifest = manifest::read(&args.manifest)?;
    let inputs = std::iter::once(args.manifest.as_path()).chain(manifest.inputs());
    let to = Destinations::new(&args.out, inputs)?;
    let mut measurements = Vec::new();
    let mut inputs = Vec::new();
    for asked in &manifest.entries {
        let (data, input) = read(asked)?;
        inputs.push(input);
        measurements.push(Measurement {
            name: asked.name.clone(),
            condition: asked.condition.clone(),
            data,
            scale: 1.0,
        });
    }
    let unit = common_unit(&manifest, &inputs);
    for ((measurement, input), asked) in measurements.iter_mut().zip(&mut inputs).zip(&manifest.entries) {
        measurement.scale = scale(asked, input, &unit)?;
    }
    let mut options = Options::default();
    options.shared = manifest.shared;
    options.calibration = manifest.calibration;
    options.unit = unit;
    options.condition_unit = manifest.condition_unit.clone();
    let answer =
        analyse(&measurements, &options).map_err(|e| Failure::analysing_curve(&args.manifest, &e))?;
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
    let provenance = provenance();
    let picture = to.picture(|| plot::series(&analysed))?;
    let faces = Faces {
        picture,
        csv: &|out| out.write_all(terminal::series_table(&analysed, terminal::Form::Csv).as_bytes()),
        json: &|out| json::series(out, &analysed),
        html: &|| page::html(&page::series(&analysed, &provenance)),
        markdown: &|| terminal::series_table(&analysed, terminal::Form::Markdown),
        latex: &|| terminal::series_table(&analysed, terminal::Form::Latex),
        report: &|written| terminal::series(&analysed, written),
        warnings: answer.warnings.iter().map(warned).collect(),
    };
    show(&args.out, &to, &faces, color)
}

/// Remarks on what was read, with the flags of this program.
fn in_flags_of(notes: &[Note]) -> Vec<String> {
    notes.iter().map(|note| note.spelled(&spelled)).collect()
}

fn read(asked: &Asked) -> Result<(Data, Input), Failure> {
    match &asked.command {
        Command::Ringdown(args) => {
            // One measurement an entry: the manifest gives one file.
            let reading = slipfit_io::read(&args.files[0], &args.reading.options())?;
            let mut options = args.options();
            if options.frequency_hz.is_none() {
                options.frequency_hz = reading.named_frequency_hz();
            }
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "ringdown",
                unit: reading.record.unit().to_owned(),
                notes: in_flags_of(&reading.report.notes),
            };
            Ok((Data::RingDown { record: Box::new(reading.record), options: Box::new(options) }, input))
        }
        Command::Resonance(args) => {
            let (reading, _, options) = super::resonance::prepare(args)?;
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "sweep",
                unit: reading.curve.unit().to_owned(),
                notes: in_flags_of(&reading.report.notes),
            };
            Ok((Data::Sweep { curve: Box::new(reading.curve), options: Box::new(options) }, input))
        }
        Command::Levels(args) => {
            let (reading, options) = super::levels::prepare(args)?;
            let input = Input {
                path: reading.report.path,
                sha256: reading.report.sha256,
                kind: "levels",
                unit: reading.levels.unit().to_owned(),
                notes: in_flags_of(&reading.report.notes),
            };
            Ok((Data::Levels { levels: Box::new(reading.levels), options: Box::new(options) }, input))
        }
        _ => Err(Failure::new(format!("{}: not a measurement", asked.name))),
    }
}

/// The unit displacements of all measurements are turned into.
fn common_unit(manifest: &Manifest, inputs: &[Input]) -> String {
    let first = inputs.first().map_or("", |i| i.unit.as_str());
    match &manifest.unit {
        _ if manifest.calibration.is_some() => {
            // Forces follow from SI displacements.
            if manifest.angular { "rad" } else { "m" }.to_owned()
        }
        Some(unit) => unit.trim().to_owned(),
        None => first.to_owned(),
    }
}

/// The factor from the unit of a measurement to the common one.
fn scale(asked: &Asked, input: &mut Input, unit: &str) -> Result<f64, Failure> {
    if let Some(scale) = asked.scale {
        return Ok(scale);
    }
    if input.unit == unit {
        return Ok(1.0);
    }
    if let (Some((from, a)), Some((to, b))) = (in_si(&input.unit), in_si(unit))
        && a == b
    {
        return Ok(from / to);
    }
    if input.unit.is_empty() {
        input.notes.push(format!(
            "no unit is named: its numbers were taken as {unit}; unit or scale says otherwise"
        ));
        return Ok(1.0);
    }
    Err(Failure::new(format!("{}: it is in `{}`, the series in `{unit}`", asked.name, input.unit))
        .hint("scale = gives the factor between the two, unit = says what the file is in"))
}

/// A displacement's unit in m or rad, and which of the two.
fn in_si(unit: &str) -> Option<(f64, char)> {
    let found = match unit.trim() {
        "m" => (1.0, 'm'),
        "dm" => (0.1, 'm'),
        "cm" => (1e-2, 'm'),
        "mm" => (1e-3, 'm'),
        "um" | "µm" | "μm" => (1e-6, 'm'),
        "nm" => (1e-9, 'm'),
        "pm" => (1e-12, 'm'),
        "fm" => (1e-15, 'm'),
        "rad" => (1.0, 'r'),
        "mrad" => (1e-3, 'r'),
        "urad" | "µrad" | "μrad" => (1e-6, 'r'),
        "deg" | "°" | "degrees" => (1f64.to_radians(), 'r'),
        "rev" | "turn" | "turns" => (std::f64::consts::TAU, 'r'),
        _ => return None,
    };
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::in_si;

    #[test]
    fn units_of_one_kind_are_turned_into_each_other() {
        assert_eq!(in_si("mm"), Some((1e-3, 'm')));
        assert!((in_si("rev").unwrap().0 / in_si("deg").unwrap().0 - 360.0).abs() < 1e-9);
        assert_eq!(in_si("V"), None);
    }
}

//! An answer with its options, from which every report is made.

use crate::refusal::Refusal;
use crate::{Analysis, File, Options};
use slipfit::answer::Warning;
use slipfit::{SignalKind, levels, resonance, ringdown};
use slipfit_io::{Format, LevelReading, Reading, SweepReading};

/// Options and answer of an analysis. The record of a ring-down stays in [`crate::Session`] for the next one.
#[derive(Debug)]
pub(crate) enum Analysed {
    Ringdown {
        options: ringdown::Options,
        answer: Box<ringdown::Answer>,
    },
    Resonance {
        reading: Box<SweepReading>,
        reference: Option<Box<SweepReading>>,
        options: Box<resonance::Options>,
        answer: Box<resonance::Answer>,
    },
    Levels {
        reading: Box<LevelReading>,
        options: levels::Options,
        answer: Box<levels::Answer>,
    },
}

impl Analysed {
    pub(crate) fn ringdown(name: &str, reading: &Reading, chosen: &Options) -> Result<Self, Refusal> {
        let mut options = chosen.ringdown()?;
        check_used(reading, &options, chosen)?;
        let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Ringdown.core(), name, &e);
        check_constant(chosen, reading.record.unit()).map_err(refused)?;
        options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
        let answer = ringdown::analyse(&reading.record, &options).map_err(refused)?;
        options.check_reached(&answer).map_err(refused)?;
        Ok(Self::Ringdown { options, answer: Box::new(answer) })
    }

    pub(crate) fn resonance(
        file: &File<'_>,
        reference: Option<&File<'_>>,
        chosen: &Options,
    ) -> Result<Self, Refusal> {
        let read = chosen.read_options(Analysis::Resonance)?;
        let read = |file: &File<'_>| slipfit_io::read_sweep_from(file.bytes, file.name, &read);
        let reference = reference.map(read).transpose()?.map(Box::new);
        let reading = Box::new(read(file)?);
        let mut options = chosen.resonance()?;
        if let Some(free) = &reference {
            let (unit, other) = (reading.curve.unit(), free.curve.unit());
            if unit != other {
                return Err(Refusal::new(format!(
                    "reference {}: its amplitudes are in `{other}`, those of {} in `{unit}`; give the unit of both curves",
                    free.report.path, reading.report.path
                )));
            }
            options.reference = Some(free.curve.clone());
        }
        let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Resonance.core(), file.name, &e);
        check_constant(chosen, reading.curve.unit()).map_err(refused)?;
        let answer = Box::new(resonance::analyse(&reading.curve, &options).map_err(refused)?);
        Ok(Self::Resonance { reading, reference, options: Box::new(options), answer })
    }

    pub(crate) fn levels(file: &File<'_>, chosen: &Options) -> Result<Self, Refusal> {
        let read = chosen.read_options(Analysis::Levels)?;
        let reading = Box::new(slipfit_io::read_levels_from(file.bytes, file.name, &read)?);
        let mut options = chosen.levels()?;
        options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
        let refused = |e: slipfit::Error| Refusal::analysing(Analysis::Levels.core(), file.name, &e);
        check_constant(chosen, reading.levels.unit()).map_err(refused)?;
        let answer = Box::new(levels::analyse(&reading.levels, &options).map_err(refused)?);
        Ok(Self::Levels { reading, options, answer })
    }

    pub(crate) fn warnings(&self) -> &[Warning] {
        match self {
            Self::Ringdown { answer, .. } => &answer.warnings,
            Self::Resonance { answer, .. } => &answer.warnings,
            Self::Levels { answer, .. } => &answer.warnings,
        }
    }
}

/// An option without effect is an error, as on a command line.
fn check_used(reading: &Reading, options: &ringdown::Options, chosen: &Options) -> Result<(), Refusal> {
    let amplitudes = matches!(reading.record.kind(), SignalKind::Envelope | SignalKind::LockIn);
    if options.frequency_hz.is_some() && !amplitudes {
        return Err(Refusal::new(
            "a frequency is only for records of amplitudes; that of this one is fitted. A band limits the \
             frequencies",
        ));
    }
    let has_sheet = chosen.of(Analysis::Ringdown).any(|(name, _)| name == "sheet");
    if has_sheet && reading.report.format == Format::Text {
        return Err(Refusal::new(
            "sheet: a text file has no sheets; part chooses one of several tables side by side, run one of \
             several runs",
        ));
    }
    Ok(())
}

fn check_constant(chosen: &Options, unit: &str) -> Result<(), slipfit::Error> {
    chosen.coordinate().map_or(Ok(()), |coordinate| coordinate.check_unit(unit))
}

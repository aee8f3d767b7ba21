//! Analyses of one measurement.

use super::choices::{Constants, LevelsChoices, ResonanceChoices, RingdownChoices};
use super::{Analysed, Answer};
use crate::failure::{core_error, option_error};
use crate::interrupt::interruptible;
use crate::reading::{Curve, Levels, Record};
use pyo3::prelude::*;
use slipfit::answer::hint::Analysis;
use slipfit::{levels, resonance, ringdown};
use slipfit_io::SweepReading;
use std::sync::Arc;

/// Refuses options with which no free decay can be analysed.
#[pyfunction]
pub(crate) fn check_ringdown(py: Python<'_>, choices: RingdownChoices, constants: Constants) -> PyResult<()> {
    let mut options = choices.options(py)?;
    options.calibration = constants.given(py)?.map(|(_, constant, _)| constant);
    options.check().map_err(|error| core_error(py, Analysis::Ringdown, &error))
}

/// Analyses a free decay.
#[pyfunction]
pub(crate) fn ringdown_answer(
    py: Python<'_>,
    record: &Record,
    choices: RingdownChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let mut options = choices.options(py)?;
    let reading = Arc::clone(&record.reading);
    options.calibration = constants.calibration(py, reading.record.unit())?;
    if options.frequency_hz.is_some() && reading.record.kind().oscillates() {
        let message = "frequency_hz is only for records of amplitudes; the frequency of this one is fitted; band_hz \
                       limits the frequencies";
        return Err(option_error(py, "frequency_hz", message));
    }
    options.frequency_hz = options.frequency_hz.or_else(|| reading.named_frequency_hz());
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || {
        let answer = ringdown::analyse(&held.record, &asked)?;
        asked.check_reached(&answer)?;
        Ok(answer)
    })?
    .map_err(|error| core_error(py, Analysis::Ringdown, &error))?;
    Ok(Answer(Analysed::Ringdown { reading, options, answer: Box::new(answer) }))
}

/// Adds the reference to the options; it must be in the unit of the curve.
pub(super) fn refer(
    py: Python<'_>,
    options: &mut resonance::Options,
    reading: &SweepReading,
    reference: Option<&SweepReading>,
) -> PyResult<()> {
    let Some(reference) = reference else { return Ok(()) };
    let (unit, other) = (reading.curve.unit(), reference.curve.unit());
    if unit != other {
        let message = format!(
            "reference={:?}: its amplitudes are in `{other}`, those of {} in `{unit}`; give the unit of both curves with unit=",
            reference.report.path, reading.report.path
        );
        return Err(option_error(py, "reference", message));
    }
    options.reference = Some(reference.curve.clone());
    Ok(())
}

/// Analyses a resonance curve.
#[pyfunction]
pub(crate) fn resonance_answer(
    py: Python<'_>,
    curve: &Curve,
    reference: Option<&Curve>,
    choices: ResonanceChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let mut options = choices.options(py)?;
    let reading = Arc::clone(&curve.reading);
    let reference = reference.map(|r| Arc::clone(&r.reading));
    options.calibration = constants.calibration(py, reading.curve.unit())?;
    refer(py, &mut options, &reading, reference.as_deref())?;
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || resonance::analyse(&held.curve, &asked))?
        .map_err(|error| core_error(py, Analysis::Resonance, &error))?;
    let options = Box::new(options);
    Ok(Answer(Analysed::Curve { reading, reference, options, answer: Box::new(answer) }))
}

/// Analyses amplitudes over drive levels.
#[pyfunction]
pub(crate) fn levels_answer(
    py: Python<'_>,
    levels: &Levels,
    choices: LevelsChoices,
    constants: Constants,
) -> PyResult<Answer> {
    let reading = Arc::clone(&levels.reading);
    let mut options = choices.options(&reading);
    options.calibration = constants.calibration(py, reading.levels.unit())?;
    let (held, asked) = (Arc::clone(&reading), options.clone());
    let answer = interruptible(py, move || levels::analyse(&held.levels, &asked))?
        .map_err(|error| core_error(py, Analysis::Levels, &error))?;
    Ok(Answer(Analysed::Levels { reading, options, answer: Box::new(answer) }))
}

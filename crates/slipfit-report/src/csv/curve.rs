//! Curves and levels with their fits as tidy CSV.

use super::unit_or_unknown;
use crate::AnalysedCurve;
use crate::AnalysedLevels;
use crate::Sentence;
use slipfit::Parameters;
use slipfit::resonance::CurvePoint;
use std::io::{self, Write};

/// One row per point; the parameters stand in the header. A value that does
/// not exist (no phase) is an empty cell. The reference's points come after
/// the curve's own.
pub fn resonance(out: &mut dyn Write, analysed: &AnalysedCurve<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    head(out, "resonance", &analysed.reading.report.path, &analysed.reading.report.sha256)?;
    writeln!(out, "# {}", answer.sentence())?;
    writeln!(out, "# model = {}, {}", answer.model, crate::json::method(answer.method))?;
    parameters(out, &answer.parameters)?;
    writeln!(
        out,
        "# amplitude, std_error, fitted_amplitude, residual, residual_across in {}",
        unit_or_unknown(&answer.unit)
    )?;
    writeln!(
        out,
        "curve,frequency_hz,amplitude,phase_rad,std_error,drive,fitted_amplitude,fitted_phase_rad,residual,\
         residual_across,stops"
    )?;
    rows(out, "measured", &answer.points)?;
    if let Some(reference) = &answer.reference {
        rows(out, "reference", &reference.points)?;
    }
    Ok(())
}

fn rows(out: &mut dyn Write, name: &str, points: &[CurvePoint]) -> io::Result<()> {
    for p in points {
        write!(out, "{name}")?;
        cells(
            out,
            &[
                p.frequency_hz,
                p.amplitude,
                p.phase_rad.unwrap_or(f64::NAN),
                p.std_error,
                p.drive,
                p.fitted_amplitude,
                if p.phase_rad.is_some() { p.fitted_phase_rad } else { f64::NAN },
                p.residual,
                if p.phase_rad.is_some() { p.residual_across } else { f64::NAN },
            ],
        )?;
        writeln!(out, ",{}", p.stops)?;
    }
    Ok(())
}

/// One row per level.
pub fn levels(out: &mut dyn Write, analysed: &AnalysedLevels<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    head(out, "levels", &analysed.reading.path, &analysed.reading.sha256)?;
    writeln!(out, "# {}", answer.sentence())?;
    parameters(out, &answer.parameters)?;
    writeln!(
        out,
        "# drive in {}; amplitude, std_error, fitted, residual in {}",
        unit_or_unknown(&answer.drive_unit),
        unit_or_unknown(&answer.unit)
    )?;
    writeln!(out, "drive,amplitude,std_error,fitted,residual,moving")?;
    for p in &answer.points {
        write!(out, "{}", p.drive)?;
        cells(out, &[p.amplitude, p.std_error, p.fitted, p.amplitude - p.fitted])?;
        writeln!(out, ",{}", p.moving)?;
    }
    Ok(())
}

fn head(out: &mut dyn Write, command: &str, path: &str, sha256: &str) -> io::Result<()> {
    writeln!(out, "# slipfit {} {command}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# file = {}", path.replace(['\n', '\r'], " "))?;
    writeln!(out, "# sha256 = {sha256}")
}

fn parameters(out: &mut dyn Write, parameters: &Parameters) -> io::Result<()> {
    for (name, q) in parameters.iter() {
        let [low, high] = q.interval_95;
        writeln!(out, "# {name} = {} +- {} {} (95 %: {low} to {high})", q.value, q.std_error, q.unit)?;
    }
    Ok(())
}

fn cells(out: &mut dyn Write, values: &[f64]) -> io::Result<()> {
    for value in values {
        out.write_all(b",")?;
        if value.is_finite() {
            write!(out, "{value}")?;
        }
    }
    Ok(())
}

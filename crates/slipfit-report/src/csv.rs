//! The numbers behind the figures as tidy CSV, unrounded, with the parameters in the header.
//!
//! A value that does not exist (no fit outside the segment, no phase, no frequency of a bare envelope) is an
//! empty cell.

use crate::escape::{csv as quoted, csv_comment as comment};
use crate::{AnalysedCurve, AnalysedLevels, AnalysedRingdown, AnalysedSeries, Sentence};
use slipfit::resonance::{CurvePoint, Method};
use slipfit::series::Estimate;
use slipfit::{Parameters, Quantity};
use std::io::{self, Write};

/// One row for each short stretch of the record.
pub fn ringdown(out: &mut dyn Write, analysed: &AnalysedRingdown<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    let file = analysed.file.display().to_string();
    head(out, "ringdown", &file, &analysed.reading.report.sha256)?;
    writeln!(out, "# {}", comment(&answer.sentence()))?;
    writeln!(out, "# model = {}", answer.model)?;
    parameters(out, &answer.parameters)?;
    writeln!(out, "# amplitude, std_error, fitted, residual in {}", unit(&answer.signal_unit))?;
    let free = answer.free_law.as_ref();
    if let Some(law) = free {
        let per = if law.friction_displacement.is_some() { "cycle" } else { "second" };
        writeln!(out, "# free_loss and its 95 % band: loss of amplitude per {per} without a model")?;
        quantity(out, "free_loss_limit_per_s", &law.limit)?;
        quantity(out, "free_loss_slope", &law.slope)?;
    }
    let columns = if free.is_some() { ",free_loss,free_loss_low_95,free_loss_high_95" } else { "" };
    writeln!(out, "time_s,amplitude,std_error,fitted,residual,frequency_hz,used{columns}")?;
    for p in &answer.envelope {
        let residual = p.amplitude - p.fitted;
        let cells = [p.time_s, p.amplitude, p.std_error, p.fitted, residual, p.frequency_hz];
        write!(out, "{},{}", numbers(cells), p.used)?;
        if let Some(law) = free {
            let here = law.at(p.amplitude).filter(|_| p.used);
            let band = here.map_or([f64::NAN; 3], |h| [h.loss_per_cycle, h.low_95, h.high_95]);
            write!(out, ",{}", numbers(band))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// One row for each point of the curve, then of the reference.
pub fn resonance(out: &mut dyn Write, analysed: &AnalysedCurve<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    head(out, "resonance", &analysed.reading.report.path, &analysed.reading.report.sha256)?;
    writeln!(out, "# {}", comment(&answer.sentence()))?;
    writeln!(out, "# model = {}, {}", answer.model, method(answer.method))?;
    parameters(out, &answer.parameters)?;
    writeln!(
        out,
        "# amplitude, std_error, fitted_amplitude, residual, residual_across in {}",
        unit(&answer.unit)
    )?;
    writeln!(
        out,
        "curve,frequency_hz,amplitude,phase_rad,std_error,drive,fitted_amplitude,fitted_phase_rad,residual,\
         residual_across,stops"
    )?;
    points(out, "measured", &answer.points)?;
    answer.reference.as_ref().map_or(Ok(()), |r| points(out, "reference", &r.points))
}

fn method(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::Leading => "leading",
        Method::Paper => "paper",
        _ => "other",
    }
}

fn points(out: &mut dyn Write, curve: &str, points: &[CurvePoint]) -> io::Result<()> {
    for p in points {
        let with_phase = |value: f64| if p.phase_rad.is_some() { value } else { f64::NAN };
        let cells = [
            p.frequency_hz,
            p.amplitude,
            p.phase_rad.unwrap_or(f64::NAN),
            p.std_error,
            p.drive,
            p.fitted_amplitude,
            with_phase(p.fitted_phase_rad),
            p.residual,
            with_phase(p.residual_across),
        ];
        writeln!(out, "{curve},{},{}", numbers(cells), p.stops)?;
    }
    Ok(())
}

/// One row for each level.
pub fn levels(out: &mut dyn Write, analysed: &AnalysedLevels<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    head(out, "levels", &analysed.reading.report.path, &analysed.reading.report.sha256)?;
    writeln!(out, "# {}", comment(&answer.sentence()))?;
    parameters(out, &answer.parameters)?;
    writeln!(
        out,
        "# drive in {}; amplitude, std_error, fitted, residual in {}",
        unit(&answer.drive_unit),
        unit(&answer.unit)
    )?;
    writeln!(out, "drive,amplitude,std_error,fitted,residual,moving")?;
    for p in &answer.points {
        let cells = [p.drive, p.amplitude, p.std_error, p.fitted, p.amplitude - p.fitted];
        writeln!(out, "{},{}", numbers(cells), p.moving)?;
    }
    Ok(())
}

/// One row for each condition, in the units of the answer.
pub fn series(out: &mut dyn Write, analysed: &AnalysedSeries<'_>) -> io::Result<()> {
    let answer = analysed.answer;
    writeln!(out, "# slipfit {} series", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# manifest = {}", comment(&analysed.heading.path))?;
    writeln!(out, "# {}", comment(&answer.sentence()))?;
    let names = if analysed.options.calibration.is_some() {
        ["sliding friction force F", "viscous coefficient gamma"]
    } else {
        ["friction displacement x_F", "decay rate delta"]
    };
    let cells = || answer.table.iter().flat_map(|r| [&r.ring_down, &r.resonance, &r.joint]).flatten();
    let unit_of = |of: fn(&Estimate) -> &Quantity| cells().next().map_or("", |c| of(c).unit.as_str());
    writeln!(
        out,
        "# friction: {} [{}]; damping: {} [{}]; z: difference over its standard error",
        names[0],
        comment(unit_of(|c| &c.friction)),
        names[1],
        comment(unit_of(|c| &c.damping))
    )?;
    write!(out, "condition,value,value_std_error")?;
    for way in ["ringdown", "resonance", "joint"] {
        for what in ["friction", "damping"] {
            write!(out, ",{what}_{way},{what}_{way}_std_error,{what}_{way}_low_95,{what}_{way}_high_95")?;
        }
    }
    writeln!(out, ",friction_z,friction_p,damping_z,damping_p,p")?;
    for row in &answer.table {
        let mut cells = row.value.unwrap_or([f64::NAN; 2]).to_vec();
        for cell in [&row.ring_down, &row.resonance, &row.joint] {
            let of = |q: &Quantity| [q.value, q.std_error, q.interval_95[0], q.interval_95[1]];
            let both = cell.as_ref().map_or([[f64::NAN; 4]; 2], |c| [of(&c.friction), of(&c.damping)]);
            cells.extend(both.as_flattened());
        }
        for pair in [&row.friction, &row.damping] {
            cells.extend(pair.as_ref().map_or([f64::NAN; 2], |p| [p.z, p.p_value]));
        }
        cells.push(row.p_value.unwrap_or(f64::NAN));
        writeln!(out, "{},{}", quoted(&row.condition), numbers(cells))?;
    }
    Ok(())
}

fn head(out: &mut dyn Write, command: &str, path: &str, sha256: &str) -> io::Result<()> {
    writeln!(out, "# slipfit {} {command}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# file = {}", comment(path))?;
    writeln!(out, "# sha256 = {sha256}")
}

fn parameters(out: &mut dyn Write, parameters: &Parameters) -> io::Result<()> {
    parameters.iter().try_for_each(|(p, q)| quantity(out, p.name(), q))
}

fn quantity(out: &mut dyn Write, name: &str, q: &Quantity) -> io::Result<()> {
    let [low, high] = q.interval_95;
    writeln!(out, "# {name} = {} +- {} {} (95 %: {low} to {high})", q.value, q.std_error, comment(&q.unit))
}

fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    let cell = |v: f64| if v.is_finite() { v.to_string() } else { String::new() };
    values.into_iter().map(cell).collect::<Vec<_>>().join(",")
}

fn unit(unit: &str) -> String {
    if unit.is_empty() { "the unit of the signal".to_owned() } else { comment(unit) }
}

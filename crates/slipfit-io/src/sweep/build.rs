//! From the columns chosen to a curve.

use std::f64::consts::TAU;

use slipfit::{SignalKind, motion::steady::Phasor, resonance::Curve};

use super::{
    SweepProblem,
    choice::{Centre, Choice, Frequency, Picked, Response, Scale},
};
use crate::{
    ReadProblem, Table,
    columns::label,
    report::{ColumnInfo, Skipped},
};

/// A curve and the rows it is made of.
pub(super) struct Built {
    pub(super) curve: Curve,
    pub(super) rows_read: u64,
    pub(super) skipped: Vec<Skipped>,
    pub(super) notes: Vec<String>,
}

/// Rows with everything a point needs, and why the others have it not.
struct Rows<'a> {
    table: &'a Table,
    columns: &'a [ColumnInfo],
    /// Line of the file of the first row, where rows are lines.
    first_row: u64,
    kept: Vec<usize>,
    skipped: Vec<Skipped>,
}

impl<'a> Rows<'a> {
    fn new(table: &'a Table, columns: &'a [ColumnInfo], needed: &[usize], first_row: u64) -> Self {
        let mut skipped: Vec<Skipped> = table.skipped.clone();
        let mut kept = Vec::with_capacity(table.rows());
        let mut missing: Vec<(u64, u64)> = vec![(0, 0); needed.len()];
        for row in 0..table.rows() {
            match needed.iter().position(|&c| !table.columns[c].values[row].is_finite()) {
                None => kept.push(row),
                Some(at) => {
                    missing[at].0 += 1;
                    if missing[at].0 == 1 {
                        missing[at].1 = first_row + row as u64;
                    }
                }
            }
        }
        for (&column, (rows, first_row)) in needed.iter().zip(missing).filter(|(_, (rows, _))| *rows > 0) {
            skipped.push(Skipped { reason: format!("no value in column {}", column + 1), rows, first_row });
        }
        Self { table, columns, first_row, kept, skipped }
    }

    /// A few frequencies or periods below zero are slips; as many as a tenth are meant.
    fn leave_out_below_zero(&mut self, frequency: &Frequency) {
        let (picked, word) = match frequency {
            Frequency::Plain(p, _) => (p, "frequency below zero"),
            Frequency::Period(p, _) => (p, "period below zero"),
            Frequency::Shift(..) => return,
        };
        let column = &self.table.columns[picked.index].values;
        let below: Vec<usize> = self.kept.iter().copied().filter(|&row| column[row] < 0.0).collect();
        if let Some(&first) = below.first()
            && below.len() * 10 <= self.kept.len()
        {
            self.kept.retain(|&row| !(column[row] < 0.0));
            let (rows, first_row) = (below.len() as u64, self.first_row + first as u64);
            self.skipped.push(Skipped { reason: word.to_owned(), rows, first_row });
        }
    }

    fn values(&self, picked: &Picked) -> Vec<f64> {
        self.kept.iter().map(|&row| self.table.columns[picked.index].values[row]).collect()
    }

    fn label(&self, picked: &Picked) -> String {
        label(&self.columns[picked.index])
    }

    fn row(&self, kept: usize) -> u64 {
        self.first_row + self.kept[kept] as u64
    }
}

pub(super) fn build(
    table: &Table,
    columns: &[ColumnInfo],
    choice: &Choice,
    first_row: u64,
) -> Result<Built, ReadProblem> {
    let mut needed = choice.frequency.indices();
    needed.extend(choice.response.indices());
    needed.extend([&choice.drive, &choice.std_error].into_iter().flatten().map(|p| p.index));
    let mut rows = Rows::new(table, columns, &needed, first_row);
    if rows.kept.is_empty() {
        let names: Vec<String> = needed.iter().map(|&i| label(&columns[i])).collect();
        let reasons: Vec<String> =
            rows.skipped.iter().map(|s| format!("{} ({} rows)", s.reason, s.rows)).collect();
        let skipped =
            if reasons.is_empty() { String::new() } else { format!("; left out: {}", reasons.join(", ")) };
        return Err(ReadProblem::Sweep(SweepProblem::NoPoints { columns: names.join(" and "), skipped }));
    }
    let mut notes = Vec::new();
    rows.leave_out_below_zero(&choice.frequency);
    let frequency_hz = frequency(&rows, &choice.frequency)?;
    varied(&frequency_hz, &rows, &choice.frequency)?;
    let (values, phased) = response(&rows, &choice.response, &mut notes)?;
    let mut std_error = match (&choice.std_error, &choice.response) {
        (Some(p), _) => Some(rows.values(p)),
        (None, Response::Impedance(r, Some(x))) => inverted_error(&pairs(&rows, r, x), &values),
        _ => None,
    };
    let values =
        to_displacement(&frequency_hz, values, phased, std_error.as_deref_mut(), choice.kind, &mut notes);
    let unit =
        if choice.kind == SignalKind::Displacement { choice.unit.clone() } else { integrated(&choice.unit) };
    let builder = if phased {
        Curve::complex(frequency_hz, values)
    } else {
        Curve::builder(frequency_hz, values.iter().map(|z| z.re).collect())
    };
    let beside = matches!(choice.response, Response::Amplitude { .. });
    let mut builder = if phased && beside { builder.separate_phase() } else { builder }.unit(unit);
    if let Some(drive) = &choice.drive {
        builder = builder.drive(rows.values(drive));
    }
    if let Some(errors) = std_error {
        builder = builder.std_error(errors);
    }
    let curve = builder.build().map_err(|e| ReadProblem::Sweep(SweepProblem::Curve(e)))?;
    Ok(Built { curve, rows_read: rows.kept.len() as u64, skipped: rows.skipped, notes })
}

fn frequency(rows: &Rows<'_>, frequency: &Frequency) -> Result<Vec<f64>, ReadProblem> {
    let (picked, hz): (&Picked, Vec<f64>) = match frequency {
        Frequency::Plain(p, factor) => (p, rows.values(p).iter().map(|v| v * factor).collect()),
        // A period of zero is no number of Hz, and is counted as such with the points.
        Frequency::Period(p, seconds) => (p, rows.values(p).iter().map(|v| 1.0 / (v * seconds)).collect()),
        Frequency::Shift(p, factor, centre) => {
            let shifts = rows.values(p);
            let hz = match centre {
                Centre::Hz(hz) => shifts.iter().map(|v| hz + v * factor).collect(),
                Centre::Column(c, to_hz) => {
                    shifts.iter().zip(rows.values(c)).map(|(v, c)| c * to_hz + v * factor).collect()
                }
            };
            (p, hz)
        }
    };
    match hz.iter().position(|f| *f < 0.0) {
        None => Ok(hz),
        Some(i) => Err(ReadProblem::Sweep(SweepProblem::NegativeFrequency {
            row: rows.row(i),
            column: rows.label(picked),
            what: if matches!(frequency, Frequency::Period(..)) { "period" } else { "frequency" },
            value: rows.values(picked)[i],
            unit: picked.unit.clone(),
        })),
    }
}

/// A curve needs frequencies, and more than one of them.
fn varied(hz: &[f64], rows: &Rows<'_>, frequency: &Frequency) -> Result<(), ReadProblem> {
    let (Frequency::Plain(p, _) | Frequency::Period(p, _) | Frequency::Shift(p, ..)) = frequency;
    let first = hz.first().copied().unwrap_or(f64::NAN);
    if hz.iter().any(|f| *f != first) {
        return Ok(());
    }
    let (value, unit) = (rows.values(p)[0], p.unit.clone());
    Err(ReadProblem::Sweep(SweepProblem::OneFrequency {
        column: rows.label(p),
        value,
        unit,
        points: hz.len(),
    }))
}

/// Standard error of the admittances `1/Z` where that of the impedances is one and the same:
/// `|Y|^2` times it, from the scatter of neighbours; none where nothing scatters.
///
/// Of white noise the second difference has 3/2 of its variance, whatever the slope.
fn inverted_error(impedances: &[Phasor], admittances: &[Phasor]) -> Option<Vec<f64>> {
    /// Standard deviation over the median of the absolute value, of normal noise.
    const OF_MEDIAN: f64 = 1.482_602_218_505_602;
    let mut bends: Vec<f64> = impedances
        .windows(3)
        .flat_map(|z| [z[1].re - 0.5 * (z[0].re + z[2].re), z[1].im - 0.5 * (z[0].im + z[2].im)])
        .map(f64::abs)
        .filter(|v| v.is_finite())
        .collect();
    bends.sort_by(f64::total_cmp);
    let noise = OF_MEDIAN * bends.get(bends.len() / 2)? / 1.5_f64.sqrt();
    let errors: Vec<f64> = admittances.iter().map(|y| noise * y.norm_sqr()).collect();
    errors.iter().all(|e| *e > 0.0 && e.is_finite()).then_some(errors)
}

/// The response of each row, and whether it has a phase.
fn response(
    rows: &Rows<'_>,
    response: &Response,
    notes: &mut Vec<String>,
) -> Result<(Vec<Phasor>, bool), ReadProblem> {
    match response {
        Response::Amplitude { amplitude, scale, phase } => {
            let written = rows.values(amplitude);
            let linear = |v: f64| match scale {
                Scale::Linear => v,
                Scale::Decibel => 10f64.powf(v / 20.0),
                Scale::Power => v.sqrt(),
            };
            if *scale != Scale::Decibel
                && let Some(i) = written.iter().position(|v| *v < 0.0)
            {
                return Err(ReadProblem::Sweep(SweepProblem::NegativeAmplitude {
                    row: rows.row(i),
                    column: rows.label(amplitude),
                    value: written[i],
                }));
            }
            let amplitudes = written.into_iter().map(linear);
            Ok(match phase {
                None => (amplitudes.map(|a| Phasor::new(a, 0.0)).collect(), false),
                Some((column, factor)) => {
                    let phases = rows.values(column);
                    let turned = amplitudes.zip(phases).map(|(a, p)| Phasor::from_polar(a, p * factor));
                    (turned.collect(), true)
                }
            })
        }
        Response::Complex(re, im) => Ok((pairs(rows, re, im), true)),
        Response::Admittance(g, Some(b)) => {
            notes.push(
                "the admittance was divided by i omega: charge over voltage, in which the parallel capacitance is a \
                 constant background"
                    .to_owned(),
            );
            Ok((pairs(rows, g, b), true))
        }
        Response::Impedance(r, Some(x)) => {
            notes.push(
                "the series impedance was inverted to an admittance and divided by i omega: charge over voltage, in \
                 which the parallel capacitance is a constant background"
                    .to_owned(),
            );
            Ok((pairs(rows, r, x).into_iter().map(|z| Phasor::new(1.0, 0.0) / z).collect(), true))
        }
        Response::Admittance(only, None) | Response::Impedance(only, None) => {
            let values = rows.values(only);
            let largest = values.iter().copied().fold(0.0, f64::max);
            if largest <= 0.0 {
                let (value, column) = (values[0], rows.label(only));
                return Err(ReadProblem::Sweep(SweepProblem::NegativeAmplitude {
                    row: rows.row(0),
                    column,
                    value,
                }));
            }
            let negative = values.iter().filter(|v| **v < 0.0).count();
            notes.push(format!(
                "{} stands alone: the amplitude was taken as the square root of it times its maximum, which holds for \
                 viscous loss; with its other part the exact response can be fitted{}",
                rows.label(only),
                if negative > 0 { format!("; {negative} points below zero were taken as zero") } else { String::new() }
            ));
            let root = |v: &f64| Phasor::new((v.max(0.0) * largest).sqrt(), 0.0);
            Ok((values.iter().map(root).collect(), false))
        }
    }
}

fn pairs(rows: &Rows<'_>, re: &Picked, im: &Picked) -> Vec<Phasor> {
    rows.values(re).into_iter().zip(rows.values(im)).map(|(re, im)| Phasor::new(re, im)).collect()
}

/// Divides a velocity by `i omega`, an acceleration by `-omega²`.
fn to_displacement(
    frequency_hz: &[f64],
    mut values: Vec<Phasor>,
    phased: bool,
    std_error: Option<&mut [f64]>,
    kind: SignalKind,
    notes: &mut Vec<String>,
) -> Vec<Phasor> {
    let (times, word) = match kind {
        SignalKind::Velocity => (1, "a velocity"),
        SignalKind::Acceleration => (2, "an acceleration"),
        _ => return values,
    };
    if !notes.iter().any(|n| n.contains("divided by i omega")) {
        notes.push(format!(
            "{word}: divided by i omega{} to a displacement; --kind says otherwise",
            if times == 2 { " twice" } else { "" }
        ));
    }
    for (z, f) in values.iter_mut().zip(frequency_hz) {
        let i_omega = if phased { Phasor::new(0.0, TAU * f) } else { Phasor::new(TAU * f, 0.0) };
        *z /= i_omega.powi(times);
    }
    if let Some(errors) = std_error {
        errors.iter_mut().zip(frequency_hz).for_each(|(e, f)| *e /= (TAU * f).powi(times));
    }
    values
}

/// Unit of what has been integrated: `m/s` and `m/s^2` become `m`.
fn integrated(unit: &str) -> String {
    let trimmed = unit.trim();
    for suffix in ["/s^2", "/s²", "/s2", "/s/s", "/s", " s^-2", " s^-1"] {
        if let Some(base) = trimmed.strip_suffix(suffix) {
            return base.trim().to_owned();
        }
    }
    match trimmed {
        "" | "F" => trimmed.to_owned(),
        "g" => "g s^2".to_owned(),
        other => format!("{other} s"),
    }
}

//! Builds the points of a curve from its columns.

use std::f64::consts::TAU;

use slipfit::{SignalKind, motion::steady::Phasor, resonance::Curve};

use super::{
    chooser::ChosenColumn,
    curve::Choice,
    frequency::{Centre, Frequency},
    head::Head,
    response::Response,
    rows,
    scale::{self, Scale},
    sentinel, units,
};
use crate::{
    error::ReadProblem,
    report::{Note, Skipped},
};

/// A curve and the rows it was built from.
pub(crate) struct Points {
    pub(crate) curve: Curve,
    pub(crate) rows_read: u64,
    pub(crate) skipped: Vec<Skipped>,
    pub(crate) notes: Vec<Note>,
}

/// Rows with all values needed for a point.
struct Rows<'a> {
    head: &'a Head,
    values: &'a [Vec<f64>],
    /// Line number of the first row in the file, if rows are lines.
    first_row: u64,
    kept: Vec<usize>,
    skipped: Vec<Skipped>,
}

impl Rows<'_> {
    /// Leaves out negative frequencies or periods if they are few; a tenth or more is taken as intended.
    fn leave_out_below_zero(&mut self, frequency: &Frequency) {
        let (chosen, reason) = match frequency {
            Frequency::Plain(p, _) => (p, "frequency below zero"),
            Frequency::Period(p, _) => (p, "period below zero"),
            Frequency::Shift(..) | Frequency::Logarithm(..) => return,
        };
        let column = &self.values[chosen.index];
        let below: Vec<usize> = self.kept.iter().copied().filter(|&row| column[row] < 0.0).collect();
        if let Some(&first) = below.first()
            && below.len() * 10 <= self.kept.len()
        {
            self.kept.retain(|&row| !(column[row] < 0.0));
            let (rows, first_row) = (below.len() as u64, self.first_row + first as u64);
            self.skipped.push(Skipped { reason: reason.to_owned(), rows, first_row });
        }
    }

    /// Leaves out points with a sentinel for a missing value in one of the columns.
    fn leave_out_sentinels(&mut self, columns: &[usize]) {
        for &column in columns {
            let mut kept: Vec<f64> = self.kept.iter().map(|&row| self.values[column][row]).collect();
            for sentinel in sentinel::hide(&mut kept) {
                let row = self.first_row + self.kept[sentinel.first] as u64;
                self.skipped.push(sentinel.skipped(column + 1, row));
            }
            let mut kept = kept.iter();
            self.kept.retain(|_| kept.next().is_some_and(|v| v.is_finite()));
        }
    }

    fn values(&self, chosen: &ChosenColumn) -> Vec<f64> {
        self.kept.iter().map(|&row| self.values[chosen.index][row]).collect()
    }

    fn pairs(&self, re: &ChosenColumn, im: &ChosenColumn) -> Vec<Phasor> {
        self.pairs_times(re, im, [1.0; 2])
    }

    /// Complex numbers from two columns, each multiplied by its factor.
    fn pairs_times(&self, re: &ChosenColumn, im: &ChosenColumn, [a, b]: [f64; 2]) -> Vec<Phasor> {
        let columns = self.values(re).into_iter().zip(self.values(im));
        columns.map(|(re, im)| Phasor::new(re * a, im * b)).collect()
    }

    /// Problem for a negative number in a row that was kept.
    fn negative(&self, what: &'static str, chosen: &ChosenColumn, kept: usize) -> ReadProblem {
        let row = self.kept[kept];
        ReadProblem::Negative {
            what,
            row: self.first_row + row as u64,
            column: self.head.label(chosen.index),
            value: self.values[chosen.index][row],
            unit: if what == "amplitude" { String::new() } else { chosen.unit.clone() },
        }
    }

    fn frequency(&self, frequency: &Frequency) -> Result<Vec<f64>, ReadProblem> {
        let chosen = frequency.swept();
        let written = self.values(chosen);
        let hz: Vec<f64> = match frequency {
            Frequency::Plain(_, factor) => written.iter().map(|v| v * factor).collect(),
            Frequency::Logarithm(_, base, factor) => written.iter().map(|v| base.powf(*v) * factor).collect(),
            // A period of zero gives no finite frequency; it is counted later, with the points.
            Frequency::Period(_, seconds) => written.iter().map(|v| 1.0 / (v * seconds)).collect(),
            Frequency::Shift(_, factor, Centre::Hz(hz)) => written.iter().map(|v| hz + v * factor).collect(),
            Frequency::Shift(_, factor, Centre::Column(c, to_hz)) => {
                written.iter().zip(self.values(c)).map(|(v, c)| c * to_hz + v * factor).collect()
            }
        };
        if let Some(i) = hz.iter().position(|f| *f < 0.0) {
            let what = if matches!(frequency, Frequency::Period(..)) { "period" } else { "frequency" };
            return Err(self.negative(what, chosen, i));
        }
        let first = hz.first().copied().unwrap_or(f64::NAN);
        if hz.iter().all(|f| *f == first) {
            return Err(ReadProblem::OneFrequency {
                column: self.head.label(chosen.index),
                value: written[0],
                unit: chosen.unit.clone(),
                points: hz.len(),
            });
        }
        Ok(hz)
    }

    /// The response of each row, and whether it has a phase.
    fn response(
        &self,
        response: &Response,
        notes: &mut Vec<Note>,
    ) -> Result<(Vec<Phasor>, bool), ReadProblem> {
        const CHARGE: &str = "divided by i omega: charge over voltage, in which the parallel capacitance is a \
                              constant background";
        match response {
            Response::Amplitude(amplitude, scale, phase) => {
                let written = self.values(amplitude);
                if *scale != Scale::Decibel
                    && let Some(i) = written.iter().position(|v| *v < 0.0)
                {
                    return Err(self.negative("amplitude", amplitude, i));
                }
                let amplitudes = written.into_iter().map(|v| scale.linear(v));
                Ok(match phase {
                    None => (amplitudes.map(|a| Phasor::new(a, 0.0)).collect(), false),
                    Some((column, factor)) => {
                        let phases = self.values(column);
                        let points = amplitudes.zip(phases).map(|(a, p)| Phasor::from_polar(a, p * factor));
                        (points.collect(), true)
                    }
                })
            }
            Response::Complex(re, im) => Ok((self.pairs(re, im), true)),
            Response::Admittance(g, Some(b)) => {
                notes.push(format!("the admittance was {CHARGE}").into());
                Ok((self.pairs_times(g, b, to_si(units::siemens, g, Some(b))), true))
            }
            Response::Impedance(r, Some(x)) => {
                notes.push(format!("the series impedance was inverted to an admittance and {CHARGE}").into());
                let impedances = self.pairs_times(r, x, to_si(units::ohms, r, Some(x)));
                Ok((impedances.into_iter().map(|z| Phasor::new(1.0, 0.0) / z).collect(), true))
            }
            Response::Modulus { of, is_impedance, angle } => {
                let known = if *is_impedance { units::ohms } else { units::siemens };
                let [factor, _] = to_si(known, of, None);
                let moduli = self.values(of);
                if let Some(i) = moduli.iter().position(|v| *v < 0.0) {
                    return Err(self.negative("amplitude", of, i));
                }
                let how = if *is_impedance {
                    "impedance was inverted to an admittance and"
                } else {
                    "admittance was"
                };
                let alone = match angle {
                    Some(_) => "",
                    None => "; phases in addition to the amplitudes would separate it from the motion",
                };
                notes.push(format!("the {how} {CHARGE}{alone}").into());
                let angles = match angle {
                    Some((column, to_radians)) => {
                        self.values(column).iter().map(|v| v * to_radians).collect()
                    }
                    None => vec![0.0; moduli.len()],
                };
                let point = |(modulus, angle): (f64, f64)| {
                    let (r, phi) = if *is_impedance {
                        (1.0 / (modulus * factor), -angle)
                    } else {
                        (modulus * factor, angle)
                    };
                    Phasor::from_polar(r, phi)
                };
                Ok((moduli.into_iter().zip(angles).map(point).collect(), angle.is_some()))
            }
            Response::Admittance(only, None) | Response::Impedance(only, None) => {
                let known =
                    if matches!(response, Response::Admittance(..)) { units::siemens } else { units::ohms };
                let [factor, _] = to_si(known, only, None);
                let values: Vec<f64> = self.values(only).into_iter().map(|v| v * factor).collect();
                let largest = values.iter().copied().fold(0.0, f64::max);
                if largest <= 0.0 {
                    return Err(self.negative("amplitude", only, 0));
                }
                let negative = match values.iter().filter(|v| **v < 0.0).count() {
                    0 => String::new(),
                    n => format!("; {n} points below zero were taken as zero"),
                };
                let label = self.head.label(only.index);
                notes.push(Note::new(format!(
                    "{label} is given without its other part: the amplitude was taken as the square root \
                     of {label} times its maximum, which holds for viscous loss; with the other part the \
                     exact response can be fitted{negative}"
                )));
                let root = |v: &f64| Phasor::new((v.max(0.0) * largest).sqrt(), 0.0);
                Ok((values.iter().map(root).collect(), false))
            }
        }
    }

    /// Standard errors of the responses.
    fn std_errors(&self, choice: &Choice, responses: &[Phasor]) -> Option<Vec<f64>> {
        let Some(column) = &choice.std_error else {
            return match &choice.response {
                Response::Impedance(r, Some(x)) => {
                    inverted_error(&self.pairs_times(r, x, to_si(units::ohms, r, Some(x))), responses)
                }
                _ => None,
            };
        };
        let written = self.values(column);
        let each = |of: &dyn Fn(f64, f64) -> f64| {
            let pairs = written.iter().zip(responses);
            Some(pairs.map(|(error, response)| of(*error, response.norm())).collect())
        };
        let in_si = |known: fn(&str) -> Option<f64>, first: &ChosenColumn, second: Option<&ChosenColumn>| {
            known(&column.unit).unwrap_or(to_si(known, first, second)[0])
        };
        // The error of 1/Z is that of Z times |Y|^2.
        let inverse = |factor: f64| move |error: f64, y: f64| error * factor * y * y;
        match &choice.response {
            Response::Amplitude(amplitude, scale, _) => {
                each(&|error, a| scale.error(error, &column.unit, a, &amplitude.unit))
            }
            Response::Complex(real, _) => {
                let factor = units::ratio(&column.unit, &real.unit).unwrap_or(1.0);
                each(&|error, _| error * factor)
            }
            Response::Admittance(g, Some(b)) => {
                let factor = in_si(units::siemens, g, Some(b));
                each(&|error, _| error * factor)
            }
            Response::Impedance(r, Some(x)) => each(&inverse(in_si(units::ohms, r, Some(x)))),
            Response::Modulus { of, is_impedance: true, .. } => each(&inverse(in_si(units::ohms, of, None))),
            Response::Modulus { of, .. } => {
                let factor = in_si(units::siemens, of, None);
                each(&|error, _| error * factor)
            }
            Response::Admittance(only, None) | Response::Impedance(only, None) => {
                let is_admittance = matches!(choice.response, Response::Admittance(..));
                let factor = in_si(if is_admittance { units::siemens } else { units::ohms }, only, None);
                let largest = responses.iter().map(|a| a.norm()).fold(0.0, f64::max);
                each(&|error, a| scale::of_root(error * factor, a, largest))
            }
        }
    }
}

/// Builds the curve from the chosen columns; the first row of the table is line `first_row`.
pub(crate) fn build(
    head: &Head,
    values: &[Vec<f64>],
    choice: &Choice,
    first_row: u64,
    mut skipped: Vec<Skipped>,
) -> Result<Points, ReadProblem> {
    let needed: Vec<usize> = choice.columns().into_iter().map(|(_, chosen)| chosen.index).collect();
    let kept = rows::complete(values, &needed, first_row, &mut skipped);
    if kept.is_empty() {
        let names: Vec<String> = needed.iter().map(|&i| head.label(i)).collect();
        let reasons: Vec<String> =
            skipped.iter().map(|s| format!("{} ({} rows)", s.reason, s.rows)).collect();
        let skipped =
            if reasons.is_empty() { String::new() } else { format!("; left out: {}", reasons.join(", ")) };
        return Err(ReadProblem::NoPoints { columns: names.join(" and "), skipped });
    }
    let mut rows = Rows { head, values, first_row, kept, skipped };
    let mut notes = Vec::new();
    rows.leave_out_below_zero(&choice.frequency);
    let response = choice.response.columns().into_iter().map(|(_, chosen)| chosen.index);
    let swept = choice.frequency.columns().into_iter().take(1).map(|(_, chosen)| chosen.index);
    rows.leave_out_sentinels(&response.chain(swept).collect::<Vec<_>>());
    let frequency_hz = rows.frequency(&choice.frequency)?;
    let (values, phased) = rows.response(&choice.response, &mut notes)?;
    let mut std_error = rows.std_errors(choice, &values);
    let values =
        to_displacement(&frequency_hz, values, phased, std_error.as_deref_mut(), choice.kind, &mut notes);
    let is_displacement = choice.kind == SignalKind::Displacement;
    let unit = if is_displacement { choice.unit.clone() } else { units::integrated(&choice.unit) };
    let hz = if choice.drive.is_some() { frequency_hz.clone() } else { Vec::new() };
    let builder = if phased {
        Curve::complex(frequency_hz, values)
    } else {
        Curve::builder(frequency_hz, values.iter().map(|z| z.re).collect())
    };
    let beside = matches!(choice.response, Response::Amplitude(..));
    let mut builder = if phased && beside { builder.separate_phase() } else { builder }.unit(unit);
    if let Some(drive) = &choice.drive {
        let times = match drive.kind {
            SignalKind::Velocity => 1,
            SignalKind::Acceleration => 2,
            _ => 0,
        };
        let levels = rows.values(&drive.column).into_iter().zip(&hz);
        let levels = levels.map(|(v, f)| drive.scale.linear(v) / (TAU * f).powi(times));
        builder = builder.drive(levels.collect());
    }
    if let Some(errors) = std_error {
        builder = builder.std_error(errors);
    }
    let curve = builder.build().map_err(ReadProblem::Data)?;
    Ok(Points { curve, rows_read: rows.kept.len() as u64, skipped: rows.skipped, notes })
}

/// Factors of two columns to S or Ω; a column without a known unit is assumed to have the unit of the other.
fn to_si(known: fn(&str) -> Option<f64>, first: &ChosenColumn, second: Option<&ChosenColumn>) -> [f64; 2] {
    let (a, b) = (known(&first.unit), second.and_then(|second| known(&second.unit)));
    [a.or(b), b.or(a)].map(|factor| factor.unwrap_or(1.0))
}

/// Standard error of the admittances `1/Z` for a uniform standard error of the impedances: `|Y|^2` times that error,
/// which is estimated from the scatter of neighbours; `None` if there is no scatter.
///
/// For white noise the second difference has 3/2 of its variance, for any slope.
fn inverted_error(impedances: &[Phasor], admittances: &[Phasor]) -> Option<Vec<f64>> {
    /// Ratio of the standard deviation to the median absolute value for normal noise.
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

/// Divides a velocity by `i omega`, an acceleration by `-omega²`.
fn to_displacement(
    frequency_hz: &[f64],
    mut values: Vec<Phasor>,
    phased: bool,
    std_error: Option<&mut [f64]>,
    kind: SignalKind,
    notes: &mut Vec<Note>,
) -> Vec<Phasor> {
    let (times, word) = match kind {
        SignalKind::Velocity => (1, "a velocity"),
        SignalKind::Acceleration => (2, "an acceleration"),
        _ => return values,
    };
    if !notes.iter().any(|n| n.text.contains("divided by i omega")) {
        let twice = if times == 2 { " twice" } else { "" };
        let text = format!("{word}: divided by i omega{twice} to a displacement");
        notes.push(Note::new(text).hint("kind", "gives another"));
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

//! The bare fit of rows.

use crate::answer::{Estimate, Status};
use crate::table::Row;
use crate::trace::{Beside, Held, Input, Scratch};
use slipfit::InferenceCriteria;
use slipfit::ringdown::{AmplitudeFit, EvenTraces, Sampling, fit_amplitudes};
use std::ops::Range;

/// What fits traces of one length side by side: that of the first row that is not null.
pub(crate) fn side_by_side(input: &Input<'_>) -> Option<EvenTraces> {
    let first = || (0..input.signal.rows()).find_map(|row| input.signal.held(row));
    input.is_plain().then(first).flatten().map(|trace| EvenTraces::new(trace.len()))
}

/// Some rows: together those of one length, one by one the others and what fails.
pub(crate) fn rows(
    input: &Input<'_>,
    range: Range<usize>,
    scratch: &mut Scratch,
    together: Option<&EvenTraces>,
) -> Vec<Row> {
    let mut all: Vec<Option<Row>> = Vec::new();
    all.resize_with(range.len(), || None);
    if let Some(together) = together {
        let mut doubles: Group<'_, f64> = Group::default();
        let mut singles: Group<'_, f32> = Group::default();
        for row in range.clone() {
            let Ok(beside) = input.beside(row) else { continue };
            let (Some(trace), Some(interval)) = (input.signal.held(row), beside.interval_s) else { continue };
            if trace.len() != together.samples() {
                continue;
            }
            match trace {
                Held::Doubles(trace) => doubles.push((row, beside), (trace, interval)),
                Held::Singles(trace) => singles.push((row, beside), (trace, interval)),
            }
        }
        doubles.fit(together, range.start, &mut all);
        singles.fit(together, range.start, &mut all);
    }
    let alone =
        |(at, found): (usize, Option<Row>)| found.unwrap_or_else(|| row(input, range.start + at, scratch));
    all.into_iter().enumerate().map(alone).collect()
}

/// Rows of one length and number type.
struct Group<'a, T> {
    rows: Vec<(usize, Beside)>,
    traces: Vec<(&'a [T], f64)>,
}

impl<T> Default for Group<'_, T> {
    fn default() -> Self {
        Self { rows: Vec::new(), traces: Vec::new() }
    }
}

impl<'a, T: Copy + Into<f64>> Group<'a, T> {
    fn push(&mut self, row: (usize, Beside), trace: (&'a [T], f64)) {
        self.rows.push(row);
        self.traces.push(trace);
    }

    fn fit(self, together: &EvenTraces, first: usize, all: &mut [Option<Row>]) {
        let samples = together.samples();
        for ((row, beside), fit) in self.rows.into_iter().zip(together.fit(&self.traces)) {
            // A gap, or a reason, is found alone.
            all[row - first] = fit.ok().map(|fit| answer(&fit, &beside, samples, samples));
        }
    }
}

fn row(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Row {
    fitted(input, row, scratch).unwrap_or_else(Row::failed)
}

fn fitted(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Result<Row, String> {
    let beside = input.beside(row)?;
    let Scratch { signal, quadrature, times } = scratch;
    let mut amplitude = input.signal.get(row, signal).ok_or("the trace is null")?;
    let all = amplitude.len();
    let modulus: Vec<f64>;
    if let Some(y) = &input.quadrature {
        let y = y.get(row, quadrature).ok_or("the quadrature is null")?;
        if y.len() != all {
            return Err(format!("{} values of Y for {all} of X", y.len()));
        }
        modulus = amplitude.iter().zip(y).map(|(x, y)| x.hypot(*y)).collect();
        amplitude = &modulus;
    }
    let mut stamps = input.times(row, all, times)?;
    if let Some(least) = beside.min_amplitude {
        let end = amplitude.iter().position(|a| *a < least).unwrap_or(all);
        amplitude = &amplitude[..end];
        stamps = stamps.map(|t| &t[..end]);
    }
    let sampling = match (stamps, beside.interval_s) {
        (Some(stamps), _) => Sampling::At(stamps),
        (None, interval_s) => Sampling::Every(interval_s.unwrap_or(f64::NAN)),
    };
    let whole = amplitude.iter().chain(stamps.unwrap_or_default()).all(|v| v.is_finite());
    let (fit, used) = if whole {
        (fit_amplitudes(sampling, amplitude), amplitude.len())
    } else {
        // What is missing leaves a gap in the clock.
        let time = |i: usize| match sampling {
            Sampling::Every(interval) => interval * i as f64,
            Sampling::At(stamps) => stamps[i],
        };
        let kept = || amplitude.iter().enumerate().filter(|(i, a)| a.is_finite() && time(*i).is_finite());
        let stamps: Vec<f64> = kept().map(|(i, _)| time(i)).collect();
        let values: Vec<f64> = kept().map(|(_, a)| *a).collect();
        (fit_amplitudes(Sampling::At(&stamps), &values), values.len())
    };
    let fit = fit.map_err(|error| error.to_string())?;
    Ok(answer(&fit, &beside, used, all))
}

/// A fit as a row: of `used` samples of `all`.
fn answer(fit: &AmplitudeFit, beside: &Beside, used: usize, all: usize) -> Row {
    let p_value = fit.sliding_p_value(used);
    let mut warnings = String::new();
    let mut warn = |code: &str, warned: bool| {
        if warned {
            warnings += if warnings.is_empty() { "" } else { " " };
            warnings += code;
        }
    };
    let [delta, delta_error] = fit.decay_rate_per_s;
    warn("not_converged", !fit.converged);
    warn("not_separable", fit.correlation.abs() > SEPARABLE);
    warn("negative_damping", delta < -UNLIKELY * delta_error);
    warn("negative_friction", fit.sliding_rate[0] < -UNLIKELY * fit.sliding_rate[1]);
    Row {
        status: if warnings.is_empty() { Status::Done } else { Status::Warned },
        reason: warnings,
        initial_amplitude: Estimate::normal(fit.initial_amplitude),
        decay_rate: Estimate::normal(fit.decay_rate_per_s),
        sliding_rate: Estimate::normal(fit.sliding_rate),
        friction_displacement: beside
            .frequency_hz
            .map_or(Estimate::NONE, |f| Estimate::normal(fit.friction_displacement(f))),
        correlation: fit.correlation,
        residual_rms: fit.residual_rms,
        p_value,
        detected: Some(p_value < InferenceCriteria::default().detected),
        samples: used as i64,
        left_out: (all - used) as i64,
        ..Row::default()
    }
}

/// Correlation of the two losses beyond which the trace does not tell them apart.
const SEPARABLE: f64 = 0.999;
/// Standard errors below zero that chance does not explain, once in 30 000 traces.
const UNLIKELY: f64 = 4.0;

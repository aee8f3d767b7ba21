//! The fit of one model to rows, without comparison.

use crate::answer::{Estimate, Status};
use crate::table::{Fits, Part, Row, detected};
use crate::trace::{AllValues, Input, RowNumbers, Scratch};
use slipfit::ringdown::{AmplitudeFit, EvenTraces, Sampling, TraceCriteria, fit_amplitudes};
use std::ops::Range;

/// The fit of several traces of one length at a time; the length is that of the first row that is not null.
pub(crate) fn even_traces(input: &Input<'_>) -> Option<EvenTraces> {
    let first = || (0..input.signal.rows()).find_map(|row| input.signal.place(row));
    input.is_plain().then(first).flatten().map(|place| EvenTraces::new(place.len()))
}

/// Fits some rows of a part: those of the common length together; the others, and those that fail, one by one.
pub(crate) fn rows(
    input: &Input<'_>,
    range: Range<usize>,
    scratch: &mut Scratch,
    together: Option<&EvenTraces>,
    part: &mut Part<'_>,
) {
    match (together, input.signal.all_values()) {
        (Some(together), AllValues::Doubles(values)) => block(input, range, scratch, together, values, part),
        (Some(together), AllValues::Singles(values)) => block(input, range, scratch, together, values, part),
        (None, _) => range.for_each(|i| part.write(i, &row(input, i, scratch))),
    }
}

fn block<T: Copy + Into<f64>>(
    input: &Input<'_>,
    range: Range<usize>,
    scratch: &mut Scratch,
    together: &EvenTraces,
    values: &[T],
    part: &mut Part<'_>,
) {
    let samples = together.samples();
    let same = input.common_numbers();
    let mut lacks_numbers = Vec::with_capacity(range.len());
    // A row that is not fitted here has no trace, and a row without an interval has no frequency either.
    let mut traces: Vec<(&[T], f64)> = Vec::with_capacity(range.len());
    let mut frequency_hz = Vec::with_capacity(range.len());
    for row in range.clone() {
        let numbers = same.or_else(|| input.row_numbers(row).ok());
        let interval = numbers.and_then(|numbers| numbers.interval_s);
        let place = input.signal.place(row).filter(|place| place.len() == samples);
        let trace = interval.zip(place).map_or((&values[..0], f64::NAN), |(dt, place)| (&values[place], dt));
        traces.push(trace);
        frequency_hz.push(numbers.and_then(|numbers| numbers.frequency_hz).unwrap_or(f64::NAN));
        lacks_numbers.push(numbers.is_some_and(|numbers| numbers.missing.contains(&true)));
    }
    let (fits, failed) = together.fit_with_failures(&traces);
    let friction_displacement = AmplitudeFit::friction_displacements(&fits, &frequency_hz);
    let p_value = AmplitudeFit::sliding_p_values(&fits, samples);
    let all = Fits { fits: &fits, friction_displacement: &friction_displacement, p_value: &p_value, samples };
    part.write_fits(range.start, &all);
    let mut failed = failed.into_iter().map(|(at, _)| at).peekable();
    for (at, fit) in fits.iter().enumerate() {
        let number = range.start + at;
        if failed.next_if_eq(&at).is_some() {
            // A gap, or the reason of a failure, is found by fitting the row alone.
            part.write(number, &row(input, number, scratch));
            continue;
        }
        let (trace, interval) = traces[at];
        let floor = ends_in_noise(fit, interval * (samples - 1) as f64, trace.iter().map(|v| (*v).into()));
        if lacks_numbers[at] || warnings(fit, samples, floor).iter().any(|(_, warned)| *warned) {
            let numbers = same.map_or_else(|| input.row_numbers(number), Ok);
            let answered = numbers.map(|numbers| answer(fit, &numbers, [samples; 2], floor));
            part.write(number, &answered.unwrap_or_else(Row::failed));
        }
    }
}

fn row(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Row {
    fitted(input, row, scratch).unwrap_or_else(Row::failed)
}

fn fitted(input: &Input<'_>, row: usize, scratch: &mut Scratch) -> Result<Row, String> {
    let numbers = input.row_numbers(row)?;
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
    if let Some(least) = numbers.min_amplitude {
        let end = amplitude.iter().position(|a| *a < least).unwrap_or(all);
        amplitude = &amplitude[..end];
        stamps = stamps.map(|t| &t[..end]);
    }
    let sampling = match (stamps, numbers.interval_s) {
        (Some(stamps), _) => Sampling::At(stamps),
        (None, interval_s) => Sampling::Every(interval_s.unwrap_or(f64::NAN)),
    };
    let whole = amplitude.iter().chain(stamps.unwrap_or_default()).all(|v| v.is_finite());
    let (fit, used) = if whole {
        (fit_amplitudes(sampling, amplitude), amplitude.len())
    } else {
        // A missing sample leaves a gap in the clock.
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
    let elapsed = |i: usize| match sampling {
        Sampling::Every(interval) => interval * i as f64,
        Sampling::At(stamps) => stamps[i] - stamps[0],
    };
    let last = amplitude.len().saturating_sub(1);
    let floor = ends_in_noise(&fit, elapsed(last), amplitude.iter().copied());
    Ok(answer(&fit, &numbers, [used, all], floor))
}

/// A fit as a row; it used `used` of `all` samples.
fn answer(fit: &AmplitudeFit, numbers: &RowNumbers, [used, all]: [usize; 2], floor: bool) -> Row {
    let p_value = fit.sliding_p_value(used);
    let all_warnings = warnings(fit, used, floor).into_iter().chain(numbers.warnings());
    let warned: Vec<&str> = all_warnings.filter_map(|(code, warned)| warned.then_some(code)).collect();
    Row {
        status: if warned.is_empty() { Status::Done } else { Status::Warned },
        reason: warned.join(" "),
        initial_amplitude: Estimate::normal(fit.initial_amplitude),
        decay_rate: Estimate::normal(fit.decay_rate_per_s),
        sliding_rate: Estimate::normal(fit.sliding_rate),
        friction_displacement: numbers
            .frequency_hz
            .map_or(Estimate::NONE, |f| Estimate::normal(fit.friction_displacement(f))),
        correlation: fit.correlation,
        residual_rms: fit.residual_rms,
        p_value,
        detected: Some(detected(p_value)),
        samples: used as i64,
        left_out: (all - used) as i64,
        ..Row::default()
    }
}

/// Whether a trace ends in its noise and is never negative: noise then raises its last amplitudes.
fn ends_in_noise(fit: &AmplitudeFit, duration_s: f64, mut trace: impl Iterator<Item = f64>) -> bool {
    let least = TraceCriteria::default().noise_floor * fit.residual_rms;
    // Missing samples are ignored.
    fit.amplitude_at(duration_s) < least && trace.all(|v| !(v < 0.0))
}

/// Codes of warnings, and whether each applies to a fit to this number of samples.
fn warnings(fit: &AmplitudeFit, samples: usize, floor: bool) -> [(&'static str, bool); 6] {
    let TraceCriteria { inseparable, unlikely, misfit, .. } = TraceCriteria::default();
    let unlikely = |[value, error]: [f64; 2]| value < -unlikely * error;
    // Ratios below this are likely for any number of degrees of freedom, so that nearly all traces need no tail
    // probability.
    let leaves = fit.lack_of_fit[0] > MAX_LIKELY_RATIO && fit.misfit_p_value(samples) < misfit;
    [
        ("not_converged", !fit.converged),
        ("not_separable", fit.correlation.abs() > inseparable),
        ("misfit", leaves),
        ("noise_floor", floor),
        ("negative_damping", unlikely(fit.decay_rate_per_s)),
        ("negative_friction", unlikely(fit.sliding_rate)),
    ]
}

/// Variance ratio that is exceeded once in 3000 traces at thirteen degrees of freedom.
const MAX_LIKELY_RATIO: f64 = 2.9;

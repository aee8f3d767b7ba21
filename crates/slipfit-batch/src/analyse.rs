//! The whole analysis of one row.

use crate::answer::{Estimate, Status};
use crate::table::Row;
use crate::trace::{Input, Scratch};
use slipfit::answer::Warning;
use slipfit::ringdown::{Options, analyse};
use slipfit::{Parameter, Record};

pub(crate) fn row(input: &Input<'_>, row: usize, scratch: &mut Scratch, options: &Options) -> Row {
    analysed(input, row, scratch, options).unwrap_or_else(Row::failed)
}

fn analysed(input: &Input<'_>, row: usize, scratch: &mut Scratch, options: &Options) -> Result<Row, String> {
    let numbers = input.row_numbers(row)?;
    let Scratch { signal, quadrature, times } = scratch;
    let signal = input.signal.get(row, signal).ok_or("the trace is null")?;
    let all = signal.len();
    let quadrature = match &input.quadrature {
        Some(y) => {
            let y = y.get(row, quadrature).ok_or("the quadrature is null")?;
            if y.len() != all {
                return Err(format!("{} values of Y for {all} of X", y.len()));
            }
            Some(y.to_vec())
        }
        None => None,
    };
    let times = input.times(row, all, times)?.map(<[f64]>::to_vec);
    let rate_hz = numbers.interval_s.map_or(f64::NAN, |interval| 1.0 / interval);
    let signal = signal.to_vec();
    let record = match (times, quadrature) {
        (Some(times), None) => Record::new(times, signal),
        (Some(times), Some(y)) => Record::lock_in(times, signal, y),
        (None, None) => Record::uniform(rate_hz, signal),
        (None, Some(y)) => Record::lock_in_uniform(rate_hz, signal, y),
    };
    let record = record.map_err(|error| error.to_string())?;
    let record = record.with_kind(input.kind).with_unit(input.unit);
    let mut options = options.clone();
    options.frequency_hz = numbers.frequency_hz.filter(|_| !input.kind.oscillates());
    options.min_amplitude = numbers.min_amplitude;
    let answer = analyse(&record, &options).map_err(|error| error.to_string())?;
    options.check_reached(&answer).map_err(|error| error.to_string())?;
    let of = |parameter| answer.parameter(parameter).map_or(Estimate::NONE, Estimate::from);
    let missing = numbers.warnings().into_iter().filter_map(|(code, missing)| missing.then_some(code));
    let codes: Vec<&str> = answer.warnings.iter().map(Warning::code).chain(missing).collect();
    Ok(Row {
        status: if codes.is_empty() { Status::Done } else { Status::Warned },
        reason: codes.join(" "),
        model: answer.model.name(),
        frequency: of(Parameter::Frequency),
        initial_amplitude: of(Parameter::InitialAmplitude),
        decay_rate: of(Parameter::DECAY_RATE),
        sliding_rate: of(Parameter::SlidingRate),
        friction_displacement: of(Parameter::FRICTION_DISPLACEMENT),
        correlation: answer
            .correlation(Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT)
            .unwrap_or(f64::NAN),
        residual_rms: answer.diagnostics.residual_rms,
        p_value: answer.sliding.p_value,
        detected: Some(answer.sliding.detected),
        samples: record.len() as i64,
        left_out: (all - record.len()) as i64,
        start_s: answer.segment.start_s,
        end_s: answer.segment.end_s,
    })
}

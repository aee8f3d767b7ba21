//! A steady line beside a decay, such as hum of the mains folded to a low frequency: found where the motion has died
//! away, and subtracted.

use super::criteria::SteadyLineCriteria;
use super::samples::Samples;
use super::two_modes::{ViscousMode, steady_mode};
use super::window::StartReason;
use super::{Answer, Criteria, second_mode};
use crate::Error;

/// The answer with a steady line subtracted, `refit` to the samples without it, where the record ends with one and the
/// decay is described better without it; else the answer as it is.
///
/// A line is tried only where the decay was refused, begins late or lies in noise beyond that of single cycles: all
/// that a line which outlasts the motion does to it.
pub(crate) fn without_steady_line<'a>(
    samples: &Samples<'a>,
    answer: Result<Answer, Error>,
    criteria: &Criteria,
    refit: impl Fn(Samples<'a>) -> Option<Answer>,
) -> Result<Answer, Error> {
    let c = &criteria.steady_line;
    let suspicious = match &answer {
        Ok(answer) => {
            answer.segment.start_reason == StartReason::LeadIn
                || noise(answer) > c.noise * answer.diagnostics.noise_rms.powi(2)
        }
        Err(refusal) => matches!(refusal, Error::NotARingDown { .. } | Error::NoFit { .. }),
    };
    let line = if suspicious { at_the_end(samples, criteria) } else { None };
    let Some(found) = line.and_then(|line| second_mode::refine(samples, line, &criteria.two_modes, refit))
    else {
        return answer;
    };
    match answer {
        Ok(before) if !better(&found, &before, c) => Ok(before),
        _ => Ok(found),
    }
}

/// Variance of one sample beside the motion.
fn noise(answer: &Answer) -> f64 {
    let d = &answer.diagnostics;
    d.noise_rms.powi(2) * d.noise_inflation * d.residual_excess.max(1.0)
}

fn better(found: &Answer, before: &Answer, criteria: &SteadyLineCriteria) -> bool {
    let earlier = before.segment.start_reason == StartReason::LeadIn
        && found.segment.start_s < before.segment.start_s
        && found.segment.end_s >= before.segment.start_s;
    let quiet = found.diagnostics.residual_excess < criteria.noise;
    quiet && (earlier || noise(found) * criteria.noise < noise(before))
}

/// The line in the last part of the samples, where it is steady and small beside the motion before.
fn at_the_end(samples: &Samples, criteria: &Criteria) -> Option<ViscousMode> {
    let c = &criteria.steady_line;
    let n = samples.len();
    if n > c.most_samples {
        return None;
    }
    let from = n - n / c.part;
    let mode = steady_mode(&samples.time[from..], &samples.signal[from..], &criteria.two_modes, c)?;
    let rest = samples.signal[from..].iter().sum::<f64>() / (n - from) as f64;
    let largest = samples.signal.iter().map(|x| (x - rest).abs()).fold(0.0, f64::max);
    (mode.amplitude() < c.most_amplitude * largest).then_some(mode)
}

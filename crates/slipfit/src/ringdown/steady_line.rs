//! A steady line in addition to a decay, such as mains hum aliased to a low frequency: detected after the
//! motion has decayed, and subtracted.

use super::criteria::SteadyLineCriteria;
use super::samples::Samples;
use super::two_modes::{ViscousMode, steady_mode};
use super::window::StartReason;
use super::{Answer, Criteria, second_mode};
use crate::Error;

/// The answer with a steady line subtracted, obtained by `refit` of the samples without it, if the record
/// ends with such a line and the decay is described better without it; otherwise the answer as given.
///
/// A line is tried only if the decay was refused, begins late or has more noise than single cycles do: these
/// are the effects of a line that outlasts the motion.
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
    let Some(found) = line.and_then(|line| second_mode::refine(samples, line, criteria, refit)) else {
        return answer;
    };
    match answer {
        Ok(before) if !better(&found, &before, c) => Ok(before),
        _ => Ok(found),
    }
}

/// Variance of one sample about the motion.
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

/// The line in the last part of the samples, if it is steady and small compared with the preceding motion.
fn at_the_end(samples: &Samples, criteria: &Criteria) -> Option<ViscousMode> {
    let c = &criteria.steady_line;
    let n = samples.len();
    if n > c.most_samples {
        return None;
    }
    let from = n - n / c.part;
    let mode = steady_mode(&samples.time[from..], &samples.signal[from..], criteria)?;
    let rest = samples.signal[from..].iter().sum::<f64>() / (n - from) as f64;
    let largest = samples.signal.iter().map(|x| (x - rest).abs()).fold(0.0, f64::max);
    (mode.amplitude() < c.most_amplitude * largest).then_some(mode)
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Parameter, Record};
    use std::f64::consts::TAU;

    const HUM_HZ: f64 = 1.0;

    /// A decay stopped by friction within a third of the record, with hum over the whole record.
    fn with_hum(hum: f64, seed: usize) -> Record {
        let oscillator = Oscillator::kinematic(TAU * 1.7, 0.178, 0.0262).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let time_s: Vec<f64> = (0..716).map(|i| f64::from(i) / 51.0).collect();
        let at = |(i, &t): (usize, &f64)| {
            let noise = 0.01 * jitter(1000 * seed + i, 2);
            decay.displacement(t) + noise + hum * (TAU * HUM_HZ * t + seed as f64).sin()
        };
        let signal = time_s.iter().enumerate().map(at).collect();
        Record::new(time_s, signal).expect("valid")
    }

    #[test]
    fn hum_beside_a_decay_is_subtracted() {
        let record = |seed| with_hum(0.05, seed);
        assert_held(record, &Options::default(), Parameter::FRICTION_DISPLACEMENT, 0.0262);
        let answer = analyse(&record(0), &Options::default()).expect("fits");
        let hum = answer.second_mode.expect("found");
        assert!((hum.frequency.value - HUM_HZ).abs() < 0.01, "{hum:?}");
        assert!((hum.amplitude.value - 0.05).abs() < 0.01, "{hum:?}");
        let x_f = answer.parameters.get(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
        assert!(x_f.std_error < 0.003, "{x_f:?}");
    }

    #[test]
    fn noise_at_rest_is_no_line() {
        let found = (0..8).filter(|&seed| {
            let answer = analyse(&with_hum(0.0, seed), &Options::default()).expect("fits");
            answer.second_mode.is_some()
        });
        assert_eq!(found.count(), 0);
    }
}

//! The rest after the motion: when it begins, and where the mass stays.

use super::Stop;
use super::criteria::StopCriteria;
use super::measured::MeasuredDecay;
use super::samples::Samples;
use super::window::EndReason;
use crate::signal::blocks::Block;
use std::f64::consts::TAU;

/// The rest after the last block of the decay, if the record goes on and holds still.
/// `converter_step` is that of the samples, zero if unknown.
pub(crate) fn stop(
    samples: &Samples,
    measured: &MeasuredDecay,
    converter_step: f64,
    criteria: &StopCriteria,
) -> Option<Stop> {
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let last = measured.points.last()?;
    // The phase of a strange record may run backwards.
    let period = TAU / last.omega.abs();
    let n = signal.len();
    if let Some(silent) = silence(time, last, period, criteria) {
        return Some(Stop {
            time_s: time[silent],
            position: signal[silent] - last.offset,
            position_std_error: measured.noise_rms.hypot(converter_step),
            static_displacement: None,
        });
    }
    let tail = (n - last.end) / criteria.tail_part;
    let goes_on = time[n - 1] - time[last.end.min(n - 1)] >= criteria.tail_periods * period;
    if tail < criteria.tail_samples || !goes_on {
        return None;
    }
    let rest = &signal[n - tail..];
    let position = rest.iter().sum::<f64>() / tail as f64;
    let scatter = (rest.iter().map(|v| (v - position).powi(2)).sum::<f64>() / tail as f64).sqrt();
    // Samples at rest may show less than their noise where the converter rounds it away.
    let deviation = scatter.max(measured.noise_rms.min(criteria.most_deviation * scatter));
    let within = (criteria.rest_deviations * deviation)
        .max(criteria.rest_steps * converter_step)
        .max(1e-9 * measured.points[0].amplitude);
    let moving = (last.first..n).rev().find(|&i| (signal[i] - position).abs() > within)?;
    if moving + 1 >= n || time[n - 1] - time[moving] < criteria.rest_periods * period {
        return None;
    }
    // A rest is entered within a swing or two; a fading one only sinks below the noise.
    let before = time.partition_point(|&t| t < time[moving] - period);
    let swing = signal[before..=moving].iter().map(|v| (v - position).abs()).fold(0.0, f64::max);
    if swing < criteria.last_swing * within && measured.window.end_reason != EndReason::Rest {
        return None;
    }
    let error = scatter / (tail as f64).sqrt();
    Some(Stop {
        time_s: time[moving + 1],
        position: position - last.offset,
        position_std_error: error.hypot(measured.noise_rms * last.unit_variance.sqrt()),
        static_displacement: None,
    })
}

/// The last sample before a silence: a recorder that writes a row when something moves writes
/// none at rest. After a mere drop-out the swing would go on.
fn silence(time: &[f64], last: &Block, period: f64, criteria: &StopCriteria) -> Option<usize> {
    let n = time.len();
    let silent = (last.first..n - 1).find(|&i| time[i + 1] - time[i] > criteria.silence_periods * period)?;
    let in_a_period = (last.end - last.first) as f64 / last.span_s * period;
    ((n - 1 - silent) as f64 <= criteria.samples_after * in_a_period).then_some(silent)
}

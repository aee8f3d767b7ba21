//! The rest after the motion: its start, and the position of the mass.

use super::Stop;
use super::criteria::StopCriteria;
use super::measured::MeasuredDecay;
use super::samples::Samples;
use crate::signal::blocks::Block;
use std::f64::consts::TAU;

/// End of the motion according to a fit.
pub(crate) struct FittedEnd {
    /// Time of the last turning point, if friction stops the motion there.
    pub(crate) last_turn_s: Option<f64>,
    /// Centre of the oscillation at that time, and its standard error.
    pub(crate) middle: [f64; 2],
}

/// The rest after the last block of the decay, if the record continues and the signal stays constant.
/// `converter_step` is that of the samples, zero if unknown; `rests` states that the motion is known to stop
/// in them.
pub(crate) fn stop(
    samples: &Samples,
    measured: &MeasuredDecay,
    fitted: &FittedEnd,
    converter_step: f64,
    rests: bool,
    criteria: &StopCriteria,
) -> Option<Stop> {
    let [middle, middle_error] = fitted.middle;
    let (time, signal) = (&samples.time[..], &samples.signal[..]);
    let last = measured.points.last()?;
    // The phase of an unusual record may run backwards.
    let period = TAU / last.omega.abs();
    // A jolt or a second release ends the rest.
    let beyond = criteria.another_motion * last.amplitude.max(measured.noise_rms);
    let another = |i: &usize| (signal[*i] - last.offset).abs() > beyond;
    let n = (last.end..signal.len()).find(another).unwrap_or(signal.len());
    let (time, signal) = (&time[..n], &signal[..n]);
    if let Some(silent) = silence(time, last, period, criteria) {
        return Some(Stop {
            time_s: time[silent],
            position: signal[silent] - middle,
            position_std_error: measured.noise_rms.hypot(converter_step).hypot(middle_error),
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
    // Samples at rest may scatter by less than their noise if the converter rounds it away.
    let deviation = scatter.max(measured.noise_rms.min(criteria.most_deviation * scatter));
    // The tail of a normal distribution is below exp(-z²/2).
    let of_all = (2.0 * ((n - last.end) as f64 / criteria.rest_chance).ln()).sqrt();
    let within = (criteria.rest_deviations.max(of_all) * deviation)
        .max(criteria.rest_steps * converter_step)
        .max(1e-9 * measured.points[0].amplitude);
    // The last block may already lie in the rest.
    let from = measured.points[measured.points.len().saturating_sub(2)].first;
    let moving = (from..n).rev().find(|&i| (signal[i] - position).abs() > within)?;
    if moving + 1 >= n || time[n - 1] - time[moving] < criteria.rest_periods * period {
        return None;
    }
    // A motion that stops reaches the rest within one or two swings; a fading one only falls below the noise.
    let before = time.partition_point(|&t| t < time[moving] - period);
    let swing = signal[before..=moving].iter().map(|v| (v - position).abs()).fold(0.0, f64::max);
    if swing < criteria.last_swing * within && !rests {
        return None;
    }
    let error = scatter / (tail as f64).sqrt();
    Some(Stop {
        time_s: fitted.last_turn_s.unwrap_or(time[moving + 1]),
        position: position - middle,
        position_std_error: error.hypot(middle_error),
        static_displacement: None,
    })
}

/// The last sample before a silence: a recorder that writes a row only when something moves writes none at
/// rest. After a mere dropout the oscillation would continue.
fn silence(time: &[f64], last: &Block, period: f64, criteria: &StopCriteria) -> Option<usize> {
    let n = time.len();
    let silent = (last.first..n - 1).find(|&i| time[i + 1] - time[i] > criteria.silence_periods * period)?;
    let in_a_period = (last.end - last.first) as f64 / last.span_s * period;
    ((n - 1 - silent) as f64 <= criteria.samples_after * in_a_period).then_some(silent)
}

#[cfg(test)]
mod tests {
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};
    use std::f64::consts::TAU;

    /// The last turning point and the rest position are found to a fiftieth of a period and within the
    /// errors.
    #[test]
    fn the_stop_is_that_of_the_last_turning_point() {
        for (q, x_f, noise) in [(60.0, 0.01, 2e-3), (20.0, 0.01, 1e-4), (60.0, 0.02, 1e-8)] {
            let oscillator = Oscillator::kinematic(TAU * 1.2, TAU * 0.6 / q, x_f).expect("valid");
            let decay = FreeDecay::from_rest(&oscillator, 0.4).expect("valid");
            let truth = decay.stop().expect("stops");
            let mut stops = 0;
            for repeat in 0..8 {
                let at =
                    |i: usize| decay.displacement(i as f64 / 50.0) + noise * jitter(i + 3000 * repeat, 8);
                let record = Record::uniform(50.0, (0..3000).map(at).collect()).expect("valid");
                let Some(found) = analyse(&record, &Options::default()).expect("fits").stop else { continue };
                stops += 1;
                assert!(
                    (found.time_s - truth.time_s).abs() < 0.02 / 1.2,
                    "{q} {noise}: {found:?} for {truth:?}"
                );
                let off = (found.position - truth.position) / found.position_std_error;
                assert!(off.abs() < 4.0, "{q} {noise}: {found:?} for {truth:?}");
            }
            assert!(stops >= 6, "{q} {noise}: {stops} of 8 records have a stop");
        }
    }

    /// With three releases, the stop must be that of the motion analysed.
    #[test]
    fn the_stop_is_that_of_the_motion_used() {
        let stop_s = |x_f: f64| {
            let oscillator = Oscillator::kinematic(TAU * 2.0, 0.05, x_f).expect("valid");
            FreeDecay::from_rest(&oscillator, 1.0).expect("valid")
        };
        let decays = [stop_s(0.02), stop_s(0.03), stop_s(0.04)];
        let at = |i: usize| {
            let t = i as f64 / 100.0;
            let hit = ((t / 20.0) as usize).min(2);
            decays[hit].displacement(t - 20.0 * hit as f64) + 1e-3 * jitter(i, 4)
        };
        let record = Record::uniform(100.0, (0..6000).map(at).collect()).expect("valid");
        let answer = analyse(&record, &Options::default()).expect("fits");
        let hit = ((answer.segment.start_s + 0.5) / 20.0) as usize;
        let truth = 20.0 * hit as f64 + decays[hit].stop().expect("stops").time_s;
        let found = answer.stop.expect("it comes to rest").time_s;
        assert!((found - truth).abs() < 0.5, "{found} for {truth}: {:?}", answer.segment);
    }
}

//! The rest after the motion: its start, and the position of the mass.

use super::Stop;
use super::criteria::StopCriteria;
use super::fitted::FittedMotion;
use super::measured::MeasuredDecay;
use super::samples::Samples;
use crate::inference::least_squares::{Normal, linear_of};
use crate::signal::blocks::Block;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// End of the motion according to a fit.
pub(crate) struct FittedEnd {
    /// The fitted motion, continued to the end of the samples.
    pub(crate) motion: FittedMotion,
    /// Whether sliding friction was detected.
    pub(crate) slides: bool,
    /// Whether it stops the motion within the fitted window.
    pub(crate) stops_in_window: bool,
    /// Centre of the oscillation at the end of the motion, and its standard error.
    pub(crate) middle: [f64; 2],
}

impl FittedEnd {
    /// Time of the last turning point, if friction stops the motion: a time in the fitted window, or one after it that
    /// is less than a period from the end of the visible motion.
    fn last_turn_s(&self, visible_end_s: f64, period: f64) -> Option<f64> {
        let near = |t: &f64| self.stops_in_window || (t - visible_end_s).abs() < period;
        self.motion.rest_s().filter(|t| self.slides && near(t))
    }

    /// Whether no sliding friction was detected and the fitted amplitude at a time is at most `limit`.
    fn fades(&self, time_s: f64, limit: f64) -> bool {
        !self.slides && self.motion.amplitude_at(time_s) <= limit
    }
}

/// Level of a rest by least squares: a constant, or a straight line because the level of a sensor may drift.
struct RestLevel {
    /// Time and value that the coefficients refer to.
    origin: [f64; 2],
    /// The constant, and the slope of a line.
    coefficients: Vec<f64>,
    unit_covariance: DMatrix<f64>,
    /// Root mean square of the residuals.
    scatter: f64,
}

const CONSTANT: &[usize] = &[0];
const LINE: &[usize] = &[0, 1];

impl RestLevel {
    fn fit(time: &[f64], signal: &[f64], columns: &[usize]) -> Option<Self> {
        let origin = [0.5 * (time.first()? + time.last()?), *signal.first()?];
        let mut sums = Normal::zeros(LINE.len());
        for (t, v) in time.iter().zip(signal) {
            sums.add_row(&[1.0, t - origin[0]], v - origin[1], 1.0);
        }
        let (coefficients, unit_covariance, rss) = linear_of(&sums, columns)?;
        Some(Self { origin, coefficients, unit_covariance, scatter: (rss / time.len() as f64).sqrt() })
    }

    /// Whether the slope of a line exceeds a number of its standard errors.
    fn drifts(&self, errors: f64) -> bool {
        self.coefficients[1].abs() > errors * self.scatter * self.unit_covariance[(1, 1)].sqrt()
    }

    fn at(&self, time_s: f64) -> f64 {
        let slope = self.coefficients.get(1).unwrap_or(&0.0);
        self.origin[1] + self.coefficients[0] + slope * (time_s - self.origin[0])
    }

    /// Standard error of the level of a line at a time.
    fn std_error_at(&self, time_s: f64) -> f64 {
        let row = DVector::from_column_slice(&[1.0, time_s - self.origin[0]]);
        self.scatter * (row.transpose() * &self.unit_covariance * &row)[0].max(0.0).sqrt()
    }
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
    let (tail_s, tail) = (&time[n - tail..], &signal[n - tail..]);
    let line = RestLevel::fit(tail_s, tail, LINE)?;
    let level =
        if line.drifts(criteria.drift_errors) { line } else { RestLevel::fit(tail_s, tail, CONSTANT)? };
    // Samples at rest may scatter by less than their noise if the converter rounds it away.
    let deviation = level.scatter.max(measured.noise_rms.min(criteria.most_deviation * level.scatter));
    // The tail of a normal distribution is below exp(-z²/2).
    let of_all = (2.0 * ((n - last.end) as f64 / criteria.rest_chance).ln()).sqrt();
    let within = (criteria.rest_deviations.max(of_all) * deviation)
        .max(criteria.rest_steps * converter_step)
        .max(1e-9 * measured.points[0].amplitude);
    // The last block may already lie in the rest.
    let from = measured.points[measured.points.len().saturating_sub(2)].first;
    let moving = (from..n).rev().find(|&i| (signal[i] - level.at(time[i])).abs() > within)?;
    if moving + 1 >= n || time[n - 1] - time[moving] < criteria.rest_periods * period {
        return None;
    }
    // A motion that stops reaches the rest within one or two swings; a fading one only falls below the noise.
    let before = time.partition_point(|&t| t < time[moving] - period);
    let swing = (before..=moving).map(|i| (signal[i] - level.at(time[i])).abs()).fold(0.0, f64::max);
    if swing < criteria.last_swing * within && !rests || fitted.fades(time[moving] + period, within) {
        return None;
    }
    let last_turn_s = fitted.last_turn_s(time[moving + 1], period);
    let time_s = last_turn_s.unwrap_or(time[moving + 1]);
    // The end of the last swing lies within the noise; it is over with the last turning point, or a period later.
    let over_s = last_turn_s.unwrap_or(time[moving] + period);
    let over = time.partition_point(|t| *t < over_s).min(n - tail.len());
    let rest = RestLevel::fit(&time[over..], &signal[over..], LINE)?;
    Some(Stop {
        time_s,
        position: rest.at(time_s) - middle,
        position_std_error: rest.std_error_at(time_s).hypot(middle_error),
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
    use std::f64::consts::{PI, TAU};

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

    /// A level that drifts by a hundredth of the amplitude, and a rest of two cycles.
    #[test]
    fn the_stop_is_found_on_a_drifting_level_and_before_a_short_rest() {
        let oscillator = Oscillator::kinematic(TAU * 1.2, TAU * 0.6 / 50.0, 0.01).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.4).expect("valid");
        let truth = decay.stop().expect("stops");
        for (end_s, drift) in [(60.0, 0.01), (60.0, 0.04), (truth.time_s + 2.2 / 1.2, 0.0)] {
            let samples = (end_s * 50.0) as usize;
            let mut stops = 0;
            for repeat in 0..8 {
                let at = |i: usize| {
                    let time_s = i as f64 / 50.0;
                    let level = drift * 0.4 * time_s / end_s;
                    decay.displacement(time_s) + level + 4e-4 * jitter(i + samples * repeat, 12)
                };
                let record = Record::uniform(50.0, (0..samples).map(at).collect()).expect("valid");
                let Some(found) = analyse(&record, &Options::default()).expect("fits").stop else { continue };
                stops += 1;
                assert!(
                    (found.time_s - truth.time_s).abs() < 0.02 / 1.2,
                    "{end_s} {drift}: {found:?} {truth:?}"
                );
                let off = (found.position - truth.position) / found.position_std_error;
                assert!(off.abs() < 4.0, "{end_s} {drift}: {found:?} {truth:?}");
            }
            assert!(stops >= 6, "{end_s} {drift}: {stops} of 8 records have a stop");
        }
    }

    /// At Q 3 a fading motion disappears in the noise within two swings.
    #[test]
    fn a_viscous_decay_has_no_stop() {
        let oscillator = Oscillator::kinematic(TAU, PI / 3.0, 0.0).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        for (repeat, noise) in [1e-1, 1e-2, 1e-3, 1e-4].into_iter().cycle().take(40).enumerate() {
            let at = |i: usize| decay.displacement(i as f64 / 50.0) + noise * jitter(i + 2000 * repeat, 13);
            let record = Record::uniform(50.0, (0..2000).map(at).collect()).expect("valid");
            if let Ok(found) = analyse(&record, &Options::default())
                && !found.sliding.detected
            {
                assert!(found.stop.is_none(), "{repeat} {noise}: {:?}", found.stop);
            }
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

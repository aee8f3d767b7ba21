//! Another motion in the same record: a release before or after the one that is analysed.

use super::Answer;
use super::criteria::OtherMotionCriteria;
use super::samples::Samples;
use super::window::{EndReason, StartReason};
use crate::Parameter;
use std::ops::Range;

/// The motions of a record other than the one analysed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OtherMotion {
    /// The longest other motion.
    pub(crate) range: Range<usize>,
    /// The samples around the motion analysed, up to the others.
    pub(crate) own: Range<usize>,
}

/// Other motions, each separated from the motion analysed by a rest; `None` if there are none.
///
/// A window of one cycle counts as moving if its root mean square about a straight line exceeds a fraction of
/// the first amplitude and a multiple of the noise.
pub(crate) fn other_motion(
    samples: &Samples,
    answer: &Answer,
    criteria: &OtherMotionCriteria,
) -> Option<OtherMotion> {
    let segment = &answer.segment;
    if segment.start_reason == StartReason::RecordStart && segment.end_reason == EndReason::RecordEnd {
        return None;
    }
    let value = |parameter| answer.parameter(parameter).map(|q| q.value);
    let (frequency_hz, amplitude) = (value(Parameter::Frequency)?, value(Parameter::InitialAmplitude)?);
    let least =
        (criteria.least_amplitude * amplitude).max(criteria.least_noise * answer.diagnostics.noise_rms);
    let windows = cycles(&samples.time, frequency_hz)?;
    let at = |time_s: f64| samples.time.partition_point(|t| *t < time_s);
    let (start, end) = (at(segment.start_s), at(segment.end_s));
    let first = windows.iter().position(|w| w.end > start)?;
    let last = windows.iter().rposition(|w| w.start < end)?;
    let motion = |(i, window): (usize, &Range<usize>)| match rms(&samples.signal[window.clone()]) {
        _ if (first..=last).contains(&i) => Motion::Moves,
        rms if rms > least => Motion::Moves,
        rms if rms > criteria.quiet * least => Motion::Between,
        _ => Motion::Rests,
    };
    let motions: Vec<Motion> = windows.iter().enumerate().map(motion).collect();
    let others = |run: &Range<usize>| run.len() >= criteria.least_cycles && !run.contains(&first);
    let runs: Vec<Range<usize>> = runs(&motions, criteria.rest_cycles).into_iter().filter(others).collect();
    let before = runs.iter().rfind(|run| run.end <= first);
    let after = runs.iter().find(|run| run.start > last);
    let longest = runs.iter().max_by_key(|run| run.len())?;
    let samples_of = |run: &Range<usize>| windows[run.start].start..windows[run.end - 1].end;
    let own = before.map_or(0, |run| windows[run.end].start)
        ..after.map_or(samples.len(), |run| windows[run.start - 1].start);
    Some(OtherMotion { range: samples_of(longest), own })
}

/// Windows of one cycle; `None` without a frequency.
fn cycles(time: &[f64], frequency_hz: f64) -> Option<Vec<Range<usize>>> {
    let mut windows = Vec::new();
    let mut from = 0;
    while from < time.len() {
        let end = from + time[from..].partition_point(|t| (t - time[from]) * frequency_hz < 1.0);
        windows.push(from..end);
        from = end.max(from + 1);
    }
    (frequency_hz > 0.0 && !windows.is_empty()).then_some(windows)
}

#[derive(Clone, Copy, PartialEq)]
enum Motion {
    Moves,
    Between,
    Rests,
}

/// Runs of windows that begin and end with a moving one and are separated by at least `rest` resting windows.
fn runs(motions: &[Motion], rest: usize) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    let (mut resting, mut rested) = (0, true);
    for (i, motion) in motions.iter().enumerate() {
        resting = if *motion == Motion::Rests { resting + 1 } else { 0 };
        rested |= resting >= rest;
        if *motion == Motion::Moves {
            match runs.last_mut() {
                Some(run) if !rested => run.end = i + 1,
                _ => runs.push(i..i + 1),
            }
            rested = false;
        }
    }
    runs
}

/// Root mean square of the deviations from a straight line.
fn rms(signal: &[f64]) -> f64 {
    let n = signal.len() as f64;
    let mean = signal.iter().sum::<f64>() / n;
    let centred = || signal.iter().enumerate().map(|(i, x)| (i as f64 - 0.5 * (n - 1.0), x - mean));
    let (along, lengths) = centred().fold((0.0, 0.0), |(xy, xx), (u, x)| (xy + u * x, xx + u * u));
    let slope = if lengths > 0.0 { along / lengths } else { 0.0 };
    (centred().map(|(u, x)| (x - slope * u).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use crate::answer::Warning;
    use crate::motion::decay::FreeDecay;
    use crate::noise::{assert_held, jitter};
    use crate::ringdown::{Answer, Options, analyse};
    use crate::{Oscillator, Parameter, Record};

    const DELTA: f64 = 0.05;

    /// Releases, each given by its amplitude and its duration in s, at 50 samples per second.
    fn releases(of: &[(f64, f64)], repeat: usize) -> Record {
        let oscillator = Oscillator::kinematic(7.5, DELTA, 6e-4).expect("valid");
        let mut signal = Vec::new();
        for (amplitude, seconds) in of {
            let decay = FreeDecay::from_rest(&oscillator, *amplitude).expect("valid");
            signal.extend((0..(50.0 * seconds) as usize).map(|i| decay.displacement(i as f64 / 50.0)));
        }
        signal.iter_mut().enumerate().for_each(|(i, x)| *x += 1e-3 * jitter(i + 10_000 * repeat, 3));
        Record::uniform(50.0, signal).expect("valid").with_unit("rad")
    }

    fn warned_range(answer: &Answer) -> Option<[f64; 2]> {
        answer.warnings.iter().find_map(|w| match w {
            Warning::OtherMotion { from_s, to_s } => Some([*from_s, *to_s]),
            _ => None,
        })
    }

    #[test]
    fn every_other_release_is_left_out_and_the_longest_is_in_a_warning() {
        let options = Options::default();
        let record = |repeat| releases(&[(0.1, 30.0), (0.12, 40.0), (0.08, 25.0)], repeat);
        assert_held(record, &options, Parameter::DECAY_RATE, DELTA);
        assert_held(record, &options, Parameter::FRICTION_DISPLACEMENT, 6e-4);
        let answer = analyse(&record(0), &options).expect("a ring-down");
        let [from_s, to_s] = warned_range(&answer).expect("a warning");
        let other = Options { start_s: Some(from_s), end_s: Some(to_s), ..options };
        let other = analyse(&record(0), &other).expect("a ring-down");
        assert!(other.segment.start_s >= from_s && other.segment.end_s <= to_s);
        assert!(answer.segment.end_s <= from_s || answer.segment.start_s >= to_s);
        assert_eq!(warned_range(&other), None);
    }

    #[test]
    fn one_release_has_no_other() {
        for of in [&[(0.1, 60.0)][..], &[(1e-3, 20.0), (0.1, 60.0)], &[(0.1, 2.0), (0.12, 60.0)]] {
            let answer = analyse(&releases(of, 0), &Options::default()).expect("a ring-down");
            assert_eq!(warned_range(&answer), None, "{of:?}");
        }
    }
}

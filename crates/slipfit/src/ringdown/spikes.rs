//! Spikes (single samples far from the motion shown by their neighbours) and dropouts.

use super::criteria::SpikeCriteria;
use crate::numeric::robust::deviation;
use crate::numeric::{extremes, sum_of};

/// Number of samples judged together, since noise and motion change along a record.
const WINDOW: usize = 256;
/// Ratio of the squared largest deviation to the mean square in a window above which it may be a spike;
/// exceeded in one of 400 windows of normal noise.
const GATE: f64 = 20.0;
/// Number of neighbours on either side that predict a sample.
const REACH: usize = 2;

/// The indices of samples that do not show the motion, ascending: spikes and dropouts. Frequent deviations
/// are not counted as spikes, since they are part of the motion or of its sensor.
///
/// If several spikes have exactly the same value, this value marks a dropout wherever it occurs: a dropout to
/// zero lies far from the motion at large amplitude but is hidden at small amplitude, where it reduces the
/// amplitude as friction does. If values repeat anyway, as with the steps of a converter, they carry no such
/// information.
pub(crate) fn spikes_and_dropouts(
    time: &[f64],
    signal: &[f64],
    repeats: impl FnOnce() -> bool,
    criteria: &SpikeCriteria,
) -> Vec<usize> {
    let n = signal.len() as f64;
    let mut spikes = spikes(time, signal, criteria);
    let lost = repeated_value(signal, &spikes, criteria.least_lost).filter(|_| !repeats());
    let is_lost = |i: &usize| Some(signal[*i]) == lost;
    let all_lost: Vec<usize> = (0..signal.len()).filter(|i| lost.is_some() && is_lost(i)).collect();
    if all_lost.len() as f64 > criteria.most_lost * n {
        return if spikes.len() as f64 > criteria.most_part * n { Vec::new() } else { spikes };
    }
    spikes.retain(|i| !is_lost(i));
    if spikes.len() as f64 > criteria.most_part * n {
        spikes.clear();
    }
    spikes.extend(all_lost);
    spikes.sort_unstable();
    spikes
}

/// The most frequent value of the given samples, if it occurs at least `least` times.
fn repeated_value(signal: &[f64], samples: &[usize], least: usize) -> Option<f64> {
    let mut values: Vec<f64> = samples.iter().map(|i| signal[*i]).collect();
    values.sort_unstable_by(f64::total_cmp);
    let runs = values.chunk_by(|a, b| a == b);
    runs.max_by_key(|run| run.len()).filter(|run| run.len() >= least).map(|run| run[0])
}

/// The indices of the spikes among the samples, ascending.
///
/// A sample with two neighbours on either side is close to `(4 (x₋₁ + x₊₁) - (x₋₂ + x₊₂))/6`, which is exact
/// for a cubic. A spike deviates from this by many times the typical deviation of its surroundings. It also
/// differs from both of its neighbours in the same direction, by more than these differ from theirs, unlike a
/// step or the crest of a wave.
fn spikes(time: &[f64], signal: &[f64], criteria: &SpikeCriteria) -> Vec<usize> {
    let n = signal.len();
    let mut found = Vec::new();
    let mut off = [0.0; WINDOW];
    let mut from = REACH;
    while from + REACH < n {
        let end = (from + WINDOW).min(n - REACH);
        let off = &mut off[..end - from];
        let rows = signal[from - REACH..end + REACH].windows(2 * REACH + 1);
        off.iter_mut().zip(rows).for_each(|(off, row)| *off = deviation_from_neighbours(row));
        let sum = sum_of(off, |o| o * o);
        let (low, high) = extremes(off);
        let largest = (low * low).max(high * high);
        if largest * off.len() as f64 > GATE * sum {
            let least = least_spike(&signal[from - REACH..end + REACH], off, criteria);
            let is_spike = |i: &usize| {
                let near = i - REACH..i + REACH + 1;
                off[i - from].abs() > least
                    && stands_out(&signal[near.clone()], least)
                    && is_even(&time[near], criteria.step_range)
            };
            found.extend((from..end).filter(is_spike));
        }
        from = end;
    }
    found
}

/// Deviation of the middle one of five samples from the cubic through the others.
fn deviation_from_neighbours(row: &[f64]) -> f64 {
    row[2] - (4.0 * (row[1] + row[3]) - (row[0] + row[4])) / 6.0
}

/// Minimum deviation of a spike among the given samples, in deviations of all or in steps of the converter.
fn least_spike(signal: &[f64], off: &[f64], criteria: &SpikeCriteria) -> f64 {
    let noise = deviation(off.iter().copied()).unwrap_or(f64::INFINITY);
    let steps = signal.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| *step > 0.0);
    criteria.deviations * noise.max(steps.fold(f64::INFINITY, f64::min))
}

/// Whether the middle one of five samples lies on one side of both neighbours, by more than these differ from
/// theirs.
fn stands_out(row: &[f64], least: f64) -> bool {
    let (left, right) = (row[2] - row[1], row[2] - row[3]);
    let beside = (row[1] - row[0]).abs().max((row[3] - row[4]).abs());
    left * right > 0.0 && left.abs().min(right.abs()) > least.max(beside)
}

/// Whether the intervals between time stamps are nearly equal.
fn is_even(time: &[f64], range: f64) -> bool {
    let steps = || time.windows(2).map(|w| w[1] - w[0]);
    let (least, most) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    most <= range * least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Warning;
    use crate::motion::decay::FreeDecay;
    use crate::noise::jitter;
    use crate::ringdown::{Options, analyse};
    use crate::{Oscillator, Record};

    const SPIKES: [(usize, f64); 4] = [(300, 0.5), (301 + 256, -0.04), (1200, 0.03), (2998, -2.0)];

    fn time() -> Vec<f64> {
        (0..3000).map(|i| 0.02 * f64::from(i)).collect()
    }

    /// 60 s of a decay ended by friction, with kinks of the acceleration at its turning points.
    fn motion(noise: f64, seed: u64) -> Vec<f64> {
        let oscillator = Oscillator::kinematic(8.0, 0.04, 4e-4).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 0.1).expect("valid");
        time().iter().enumerate().map(|(i, t)| decay.displacement(*t) + noise * jitter(i, seed)).collect()
    }

    fn left_out(time: &[f64], signal: &[f64]) -> Vec<usize> {
        spikes_and_dropouts(time, signal, || false, &SpikeCriteria::default())
    }

    #[test]
    fn spikes_are_found_and_nothing_else() {
        for noise in [0.0, 1e-6, 1e-3] {
            let mut signal = motion(noise, 1);
            assert_eq!(left_out(&time(), &signal), [0usize; 0], "noise {noise}");
            SPIKES.iter().for_each(|(i, size)| signal[*i] += size);
            // The last sample but one has too few neighbours.
            assert_eq!(left_out(&time(), &signal), [300, 557, 1200], "noise {noise}");
        }
    }

    #[test]
    fn steps_quanta_and_frequent_ones_are_kept() {
        let quantised: Vec<f64> = motion(1e-4, 2).iter().map(|x| (x / 2e-3).round() * 2e-3).collect();
        assert_eq!(left_out(&time(), &quantised), [0usize; 0]);
        let stepped: Vec<f64> =
            motion(1e-4, 3).iter().enumerate().map(|(i, x)| x + if i < 1000 { 1.0 } else { 0.0 }).collect();
        assert_eq!(left_out(&time(), &stepped), [0usize; 0]);
        let clicking: Vec<f64> = motion(1e-4, 4)
            .iter()
            .enumerate()
            .map(|(i, x)| x + if i % 25 == 0 { 0.1 } else { 0.0 })
            .collect();
        assert_eq!(left_out(&time(), &clicking), [0usize; 0]);
        for signal in [vec![], vec![1.0; 4], vec![1e300, -1e300, 1e300, -1e300, 1e300, 0.0]] {
            let time: Vec<f64> = (0..signal.len()).map(|i| i as f64).collect();
            assert_eq!(left_out(&time, &signal), [0usize; 0]);
        }
    }

    #[test]
    fn an_answer_is_that_without_the_spikes_and_counts_them() {
        let clean = motion(1e-3, 5);
        let mut spiked = clean.clone();
        SPIKES[..3].iter().for_each(|(i, size)| spiked[*i] += size);
        let answer = |signal| {
            let record = Record::new(time(), signal).expect("valid").with_unit("rad");
            analyse(&record, &Options::default()).expect("a ring-down")
        };
        let (clean, spiked) = (answer(clean), answer(spiked));
        for ((_, without), (_, with)) in clean.parameters.iter().zip(spiked.parameters.iter()) {
            let moved = (with.value - without.value).abs();
            assert!(moved <= 0.2 * without.std_error, "{with:?} for {without:?}");
        }
        let warning = spiked.warnings.iter().find(|w| w.code() == "spikes");
        assert!(matches!(warning, Some(Warning::Spikes { samples: 3, .. })), "{warning:?}");
        assert!(clean.warnings.iter().all(|w| w.code() != "spikes"));
    }

    #[test]
    fn samples_lost_to_zero_are_left_out_of_early_and_late_swings() {
        let lost = |i: &usize| [0, 1, 2, 3, 17, 18].contains(&(i * 7919 % 301));
        for noise in [0.0, 1e-4, 1e-3] {
            let signal: Vec<f64> =
                motion(noise, 6).iter().enumerate().map(|(i, x)| if lost(&i) { 0.0 } else { *x }).collect();
            let all: Vec<usize> = (0..signal.len()).filter(lost).collect();
            assert_eq!(left_out(&time(), &signal), all, "noise {noise}");
            // Zeros of a converter are ordinary samples.
            let found = spikes_and_dropouts(&time(), &signal, || true, &SpikeCriteria::default());
            assert!(found.len() < all.len(), "{}", found.len());
        }
        // If half of the samples are zero, the zeros are part of the signal.
        let half: Vec<f64> =
            motion(1e-3, 7).iter().enumerate().map(|(i, x)| if i % 2 == 0 { 0.0 } else { *x }).collect();
        assert_eq!(left_out(&time(), &half), [0usize; 0]);
    }
}

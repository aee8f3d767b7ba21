//! Active part of a record: the short stretch that moves while the rest of the record is quiet.

use super::criteria::ActivePartCriteria;
use crate::numeric::robust::median;
use crate::numeric::sum_of;
use std::ops::Range;

/// Number of windows that the record is divided into.
const WINDOWS: usize = 256;
/// Minimum number of samples per window.
const LEAST_WINDOW: usize = 4;
/// Maximum number of quiet windows between two active ones that still belong to the motion (turning points,
/// beats).
const GAP: usize = 3;

/// The samples of the strongest motion with their surroundings, if the record is quiet for most of its
/// length; `None` otherwise.
///
/// The variance of each of [`WINDOWS`] windows about its own mean is compared with the median over all
/// windows, which is the noise variance if more than half of the record is at rest. Blocks chosen for the
/// whole record would be longer than such a motion, and its spectral line would be lost in the noise of the
/// rest.
///
/// Windows shorter than a cycle are quiet at its turning points. The stretches outside the part that are as
/// long as the part must therefore be quiet as well, apart from a drift that is small compared with the
/// motion.
pub(crate) fn active_part(signal: &[f64], criteria: &ActivePartCriteria) -> Option<Range<usize>> {
    let n = signal.len();
    let length = n.div_ceil(WINDOWS).max(LEAST_WINDOW);
    let variance: Vec<f64> = signal.chunks(length).map(variance_of).collect();
    let quiet = median(&mut variance.clone())?;
    let strongest = (0..variance.len()).max_by(|&a, &b| variance[a].total_cmp(&variance[b]))?;
    if !(variance[strongest] > criteria.strongest_ratio * quiet) {
        return None;
    }
    let active = |i: usize| variance[i] > criteria.active_ratio * quiet;
    let reach = |indices: &mut dyn Iterator<Item = usize>| {
        let mut last = strongest;
        for i in indices {
            if active(i) {
                last = i;
            } else if i.abs_diff(last) > GAP {
                break;
            }
        }
        last
    };
    let first = reach(&mut (0..strongest).rev());
    let last = reach(&mut (strongest + 1..variance.len()));
    let moving = (last - first + 1) * length;
    let from = (first * length).saturating_sub(moving);
    let end = ((last + 1) * length + (criteria.rest_kept * moving as f64) as usize).min(n);
    if (end - from) as f64 > criteria.most_of_record * n as f64 {
        return None;
    }
    let most =
        (criteria.active_ratio * quiet).max(criteria.elsewhere_ratio * variance_of(&signal[from..end]));
    let rest = [&signal[..from], &signal[end..]];
    let elsewhere = rest.into_iter().flat_map(|rest| rest.chunks_exact(end - from));
    let mut elsewhere: Vec<f64> = elsewhere.map(variance_of).collect();
    median(&mut elsewhere).is_none_or(|variance| variance <= most).then_some(from..end)
}

fn variance_of(part: &[f64]) -> f64 {
    let n = part.len() as f64;
    let mean = sum_of(part, |x| x) / n;
    sum_of(part, |x| (x - mean).powi(2)) / n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    fn record(n: usize, from: usize, decay: f64) -> Vec<f64> {
        let motion = |i: usize| if i < from { 0.0 } else { (-((i - from) as f64) / decay).exp() };
        (0..n).map(|i| motion(i) * (0.2 * i as f64).sin() + 0.1 * jitter(i, 3)).collect()
    }

    #[test]
    fn a_short_motion_in_a_long_record_is_found() {
        let criteria = ActivePartCriteria::default();
        let part = active_part(&record(100_000, 60_000, 300.0), &criteria).expect("quiet for most of it");
        assert!(part.contains(&59_990), "{part:?}");
        assert!(part.contains(&61_000), "{part:?}");
        assert!(part.len() < 8_000, "{part:?}");
    }

    #[test]
    fn a_record_that_moves_for_most_of_its_length_stays_whole() {
        let criteria = ActivePartCriteria::default();
        assert_eq!(active_part(&record(10_000, 0, 3_000.0), &criteria), None);
        assert_eq!(active_part(&record(10_000, 10_000, 1.0), &criteria), None);
        assert_eq!(active_part(&[0.0; 50], &criteria), None);
    }

    /// Five cycles of a hundred samples each: windows at their turning points are as quiet as the noise.
    #[test]
    fn slow_swings_are_no_rest() {
        let criteria = ActivePartCriteria::default();
        for seed in 0..20 {
            let swing = |i: usize| (-(i as f64) / 400.0).exp() * (0.063 * i as f64).sin();
            let signal: Vec<f64> = (0..512).map(|i| swing(i) + 0.01 * jitter(i, seed)).collect();
            assert_eq!(active_part(&signal, &criteria), None, "seed {seed}");
        }
    }

    #[test]
    fn a_drift_small_beside_the_motion_is_a_rest() {
        let criteria = ActivePartCriteria::default();
        let mut signal = record(100_000, 60_000, 300.0);
        for (i, x) in signal.iter_mut().enumerate() {
            *x += 0.5 * (3e-4 * i as f64).sin();
        }
        let part = active_part(&signal, &criteria).expect("quiet for most of it");
        assert!(part.contains(&60_500) && part.len() < 10_000, "{part:?}");
    }
}

//! Properties of an oscillation that are found without any fit.

use super::Record;
use crate::numeric::robust::median;

/// Maximum number of samples examined.
const MOST_SAMPLES: usize = 1 << 18;
/// Part of the largest excursion that a swing must exceed on both sides of the middle, so that noise and the steps of
/// a converter do not count.
const DEAD_BAND: f64 = 0.1;

/// The swings of a record about its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Swings {
    /// Number of changes from one side of the middle to the other.
    pub crossings: usize,
    /// Median time between two crossings to the same side (s), if there are two.
    pub period_s: Option<f64>,
}

impl Record {
    /// Counts the swings about the median that exceed a tenth of the largest. For a record of more than 2¹⁸ samples
    /// only that many are examined, starting 2¹⁵ before the sample farthest from the mean, or the last ones if fewer
    /// follow.
    ///
    /// ```
    /// use slipfit::Record;
    /// let swing = |i| (-0.01 * f64::from(i)).exp() * (0.2 * f64::from(i)).cos();
    /// let record = Record::uniform(10.0, (0..200).map(swing).collect())?;
    /// assert!((record.swings().period_s.unwrap() - 3.14).abs() < 0.1);
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    #[must_use]
    pub fn swings(&self) -> Swings {
        let signal = &self.signal;
        let mean = signal.iter().sum::<f64>() / signal.len() as f64;
        let far = |from: f64| {
            move |&(_, a): &(usize, f64), &(_, b): &(usize, f64)| {
                (a - from).abs().total_cmp(&(b - from).abs())
            }
        };
        let (largest, _) = signal.iter().copied().enumerate().max_by(far(mean)).unwrap_or_default();
        // A decay follows its largest swing.
        let from = largest.saturating_sub(MOST_SAMPLES / 8).min(signal.len().saturating_sub(MOST_SAMPLES));
        let part = &signal[from..signal.len().min(from + MOST_SAMPLES)];
        let middle = median(&mut part.to_vec()).unwrap_or(mean);
        let band = DEAD_BAND * part.iter().map(|x| (x - middle).abs()).fold(0.0, f64::max);
        let (mut above, mut crossings, mut upward_s) = (None, 0, Vec::new());
        for (i, x) in part.iter().enumerate() {
            let now = match x - middle {
                d if d > band => true,
                d if d < -band => false,
                _ => continue,
            };
            if above.is_some_and(|before| before != now) {
                crossings += 1;
                if now {
                    upward_s.push(self.time_s(from + i));
                }
            }
            above = Some(now);
        }
        let mut periods_s: Vec<f64> = upward_s.windows(2).map(|w| w[1] - w[0]).collect();
        Swings { crossings, period_s: median(&mut periods_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swings(x: impl Fn(f64) -> f64) -> Swings {
        Record::uniform(100.0, (0..4000).map(|i| x(0.01 * f64::from(i))).collect()).unwrap().swings()
    }

    #[test]
    fn a_decay_swings_and_a_drift_or_a_peak_does_not() {
        let decay = swings(|t| 3.0 + (-0.1 * t).exp() * (5.0 * t).cos());
        assert!(decay.crossings > 30, "{decay:?}");
        assert!((decay.period_s.unwrap() / 1.2566 - 1.0).abs() < 0.02, "{decay:?}");
        assert_eq!(swings(|t| 20.0 + 0.01 * t), Swings { crossings: 1, period_s: None });
        assert!(swings(|t| 1.0 / (1.0 + (t - 20.0).powi(2))).crossings <= 2);
        assert!(swings(|t| (20.0 - t).atan()).crossings <= 2);
    }

    #[test]
    fn a_short_decay_is_found_in_a_long_rest() {
        let x = |i: usize| {
            let t = 1e-3 * i as f64 - 900.0;
            if t < 0.0 { 0.0 } else { (-t).exp() * (20.0 * t).sin() }
        };
        let record = Record::uniform(1000.0, (0..1 << 20).map(x).collect()).unwrap();
        assert!(record.swings().crossings >= 8, "{:?}", record.swings());
    }
}

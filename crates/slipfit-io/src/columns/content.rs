//! What the numbers of a column look like.

/// Blocks a column is cut into at most.
const BLOCKS: usize = 64;

/// A column as its numbers describe it; gaps are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Content {
    /// Share of rows that hold a number.
    pub(super) filled: f64,
    /// Share of steps that go up, of those that go up or down.
    pub(super) rising: f64,
    /// Share of steps that are not zero.
    pub(super) moving: f64,
    /// All steps are exactly one.
    pub(super) counts: bool,
    /// All values are whole numbers.
    pub(super) whole: bool,
    /// Mean step between rows.
    pub(super) mean_step: f64,
    pub(super) least: f64,
    pub(super) greatest: f64,
    /// Greatest rms about the mean in any block.
    pub(super) swing: f64,
    /// Share of blocks, but for one, whose rms is between 3 % and 80 % of the greatest.
    pub(super) gradual: f64,
    /// Correlation of successive samples.
    pub(super) smoothness: f64,
    /// Whether the values scatter little about a positive mean, the first aside.
    pub(super) steady_positive: bool,
}

impl Content {
    pub(super) fn of(column: &[f64]) -> Self {
        let values: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
        let n = values.len();
        let steps = || values.windows(2).map(|w| w[1] - w[0]);
        let up = steps().filter(|s| *s > 0.0).count() as f64;
        let down = steps().filter(|s| *s < 0.0).count() as f64;
        let (mean, rms) = mean_and_rms(&values);
        let covariance =
            values.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / n.max(1) as f64;
        // Blocks of less than two cycles would differ by their phase alone.
        let crossings = values.windows(2).filter(|w| (w[0] < mean) != (w[1] < mean)).count();
        let blocks = BLOCKS.min(n / 16).min(crossings / 4).max(4).min(n.max(1));
        let of_block = |b: usize| mean_and_rms(&values[b * n / blocks..(b + 1) * n / blocks]).1;
        let block_rms: Vec<f64> = (0..blocks).map(of_block).collect();
        let swing = block_rms.iter().copied().fold(0.0, f64::max);
        let between = block_rms.iter().filter(|r| **r > 0.03 * swing && **r < 0.8 * swing).count();
        Self {
            filled: n as f64 / column.len().max(1) as f64,
            rising: if up + down > 0.0 { up / (up + down) } else { 0.0 },
            moving: (up + down) / n.saturating_sub(1).max(1) as f64,
            counts: n > 1 && steps().all(|s| s == 1.0),
            whole: n > 1 && values.iter().all(|v| v.fract() == 0.0),
            mean_step: match values[..] {
                [first, .., last] => (last - first) / (n - 1) as f64,
                _ => 0.0,
            },
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            swing,
            // One block between is where a drive was switched off.
            gradual: between.saturating_sub(1) as f64 / blocks as f64,
            smoothness: if rms > 0.0 { covariance / (rms * rms) } else { 0.0 },
            steady_positive: steady_positive(&values),
        }
    }

    /// Whether the numbers could be times: they go up, rarely down.
    pub(super) fn is_monotone(&self) -> bool {
        self.filled > 0.0 && self.greatest > self.least && self.rising >= 0.98 && self.moving >= 0.02
    }

    /// Whether the numbers could be times between samples: positive, nearly
    /// equal, and the first, which has nothing before it, different.
    pub(super) fn is_interval(&self) -> bool {
        self.steady_positive && self.least >= 0.0 && self.greatest > self.least
    }

    /// Whether the numbers oscillate and die down by degrees.
    pub(super) fn is_ringing(&self) -> bool {
        self.gradual >= 0.1 && self.smoothness >= 0.3
    }
}

fn mean_and_rms(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

fn steady_positive(values: &[f64]) -> bool {
    let Some((first, rest)) = values.split_first() else { return false };
    let (mean, rms) = mean_and_rms(rest);
    rest.len() > 3 && rest.iter().all(|v| *v > 0.0) && rms < 0.3 * mean && *first < 0.5 * mean
}

/// Whether `candidate` runs like the derivative of `column`: correlation with
/// its central differences above 0.9.
pub(super) fn is_derivative(candidate: &[f64], column: &[f64]) -> bool {
    let pairs: Vec<(f64, f64)> = column
        .windows(3)
        .zip(candidate.get(1..).unwrap_or_default())
        .map(|(w, &v)| (w[2] - w[0], v))
        .filter(|(d, v)| d.is_finite() && v.is_finite())
        .collect();
    let n = pairs.len().max(1) as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / n;
    let (mean_d, mean_v) = (mean(&|p| p.0), mean(&|p| p.1));
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - mean_d, p.1 - mean_v)).sum::<f64>();
    let (dd, vv, dv) = (sum(&|d, _| d * d), sum(&|_, v| v * v), sum(&|d, v| d * v));
    dd > 0.0 && vv > 0.0 && dv / (dd * vv).sqrt() > 0.9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(f: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..2000).map(|i| f(f64::from(i) * 0.05)).collect()
    }

    #[test]
    fn a_ring_down_is_told_from_its_drive_its_noise_and_its_times() {
        assert!(Content::of(&wave(|t| (-0.05 * t).exp() * (3.0 * t).cos())).is_ringing());
        assert!(!Content::of(&wave(|t| if t < 50.0 { (3.0 * t).cos() } else { 0.0 })).is_ringing());
        assert!(!Content::of(&wave(|t| (t * 1e5).sin() * (-0.05 * t).exp())).is_ringing());
        assert!(Content::of(&wave(|t| t)).is_monotone());
        assert!(Content::of(&wave(|t| (t / 2.0).floor())).is_monotone());
        assert!(!Content::of(&wave(|t| t.cos())).is_monotone());
    }

    #[test]
    fn intervals_are_steady_after_the_first() {
        let mut steps = vec![20.0; 50];
        assert!(!Content::of(&steps).is_interval());
        steps[0] = 0.0;
        steps[7] = 21.0;
        assert!(Content::of(&steps).is_interval());
    }

    #[test]
    fn a_velocity_is_the_derivative_of_its_angle_and_not_the_reverse() {
        let angle = wave(|t| (-0.02 * t).exp() * (3.0 * t).cos());
        let velocity = wave(|t| -3.0 * (-0.02 * t).exp() * (3.0 * t).sin());
        assert!(is_derivative(&velocity, &angle));
        assert!(!is_derivative(&angle, &velocity));
    }

    #[test]
    fn no_numbers_have_no_content() {
        for column in [vec![], vec![f64::NAN; 9], vec![1.0], vec![1e308, -1e308]] {
            let content = Content::of(&column);
            assert!(!content.is_monotone());
            assert!(!content.is_ringing());
            assert!(!content.is_interval());
            assert!(!is_derivative(&column, &column));
        }
    }
}

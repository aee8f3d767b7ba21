//! Properties of a column derived from its numbers.

use super::sentinel;

/// Criteria that distinguish a ringing column from the others by its numbers alone. All were chosen on the measured
/// files and on simulated phone records (three axes, 0.3 % to 1 % noise, rest periods up to 300 times the decay).
mod criteria {
    /// Maximum number of blocks into which a column is divided.
    pub(super) const BLOCKS: usize = 64;
    /// Crossings of the mean per block: blocks of less than two cycles would differ by their phase alone.
    pub(super) const BLOCK_CROSSINGS: usize = 4;
    /// Rms of a block relative to the greatest, below which the column is at rest.
    pub(super) const REST: f64 = 0.03;
    /// Rms of a block relative to the greatest, above which the motion has not yet decayed.
    pub(super) const FULL: f64 = 0.8;
    /// Minimum share of blocks between these limits in a decaying column, excluding its edges.
    pub(super) const LEAST_DECAYING_SHARE: f64 = 0.1;
    /// Correlation of successive samples, below which a column or a block is noise.
    pub(super) const SMOOTH: f64 = 0.3;
    /// Minimum number of mean crossings in the moving part of a column for cutting off the rest.
    pub(super) const MOTION_CROSSINGS: usize = 8;
    /// Part of a column's variance explained by the squares of another: 0.9 and more in simulated phones on a pendulum,
    /// none in axes that move independently.
    pub(super) const SQUARE: f64 = 0.8;
    /// Number of first rows that may be fragments of lines, as written by a serial monitor that starts in mid-line.
    pub(super) const STRAY_ROWS: usize = 5;
    /// Minimum number of rows after these for setting them aside.
    pub(super) const OTHER_ROWS: usize = 50;
}
use criteria::{
    BLOCK_CROSSINGS, BLOCKS, FULL, LEAST_DECAYING_SHARE, MOTION_CROSSINGS, OTHER_ROWS, REST, SMOOTH, SQUARE,
    STRAY_ROWS,
};

/// Numerical properties of a column; gaps are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Content {
    /// Share of rows that hold a number.
    pub(super) filled: f64,
    /// Share of rising steps among those that rise or fall.
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
    pub(super) greatest_rms: f64,
    /// Share of blocks of the motion that are not noise and lie between rest and full swing, excluding its edges.
    pub(super) decaying_share: f64,
    /// Correlation of successive samples of the motion.
    pub(super) smoothness: f64,
    /// Whether the values, except the first, scatter little about a positive mean.
    pub(super) steady_positive: bool,
}

impl Content {
    pub(super) fn of(column: &[f64]) -> Self {
        let mut values: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
        if !sentinel::hide(&mut values).is_empty() {
            values.retain(|v| v.is_finite());
        }
        let n = values.len();
        let Steps { up, down, ones } = Steps::of(&values);
        let (up, down) = (up as f64, down as f64);
        let (rest, motion) = motion(&values);
        let blocks_of_motion = blocks(motion);
        // Most columns move from the first row to the last.
        let whole_moves = motion.len() == n;
        Self {
            filled: n as f64 / column.len().max(1) as f64,
            rising: if up + down > 0.0 { up / (up + down) } else { 0.0 },
            moving: (up + down) / n.saturating_sub(1).max(1) as f64,
            counts: n > 1 && ones == n - 1,
            whole: n > 1 && values[stray_rows(&values)..].iter().all(|v| v.fract() == 0.0),
            mean_step: match values[stray_rows(&values)..] {
                [first, .., last] => (last - first) / (n - stray_rows(&values) - 1) as f64,
                _ => 0.0,
            },
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            greatest_rms: if whole_moves {
                greatest_rms(&blocks_of_motion)
            } else {
                greatest_rms(&blocks(&values))
            },
            decaying_share: decaying_share(&blocks_of_motion, rest > 0),
            smoothness: smoothness(motion),
            steady_positive: steady_positive(&values),
        }
    }

    /// Whether the numbers could be times: they increase and rarely decrease.
    pub(super) fn is_monotone(&self) -> bool {
        self.filled > 0.0 && self.greatest > self.least && self.rising >= 0.98 && self.moving >= 0.02
    }

    /// Whether the numbers could be time steps between samples: positive and nearly equal, except for the first, which
    /// has no predecessor.
    pub(super) fn is_interval(&self) -> bool {
        self.steady_positive && self.least >= 0.0 && self.greatest > self.least
    }

    /// Whether the numbers oscillate and decay gradually.
    pub(super) fn is_ringing(&self) -> bool {
        self.decaying_share >= LEAST_DECAYING_SHARE && self.smoothness >= SMOOTH
    }
}

/// Number of first values that are fragments: one of them has a fractional part or exceeds its successor, which none of
/// the many values after them does.
fn stray_rows(values: &[f64]) -> usize {
    let Some((first, others)) = values.split_at_checked(STRAY_ROWS).filter(|(_, o)| o.len() >= OTHER_ROWS)
    else {
        return 0;
    };
    let breaks_count = |pair: &[f64]| pair[0].fract() != 0.0 || pair[0] > pair[1];
    let all = &values[..=first.len()];
    let counts = others.iter().all(|v| v.fract() == 0.0) && !others.windows(2).any(breaks_count);
    if counts && all.windows(2).any(breaks_count) { STRAY_ROWS } else { 0 }
}

/// Numbers of steps from row to row that rise, that fall, and that are exactly one.
#[derive(Default)]
struct Steps {
    up: usize,
    down: usize,
    ones: usize,
}

impl Steps {
    fn of(values: &[f64]) -> Self {
        let mut all = Self::default();
        for (value, next) in values.iter().zip(values.iter().skip(1)) {
            let step = next - value;
            all.up += usize::from(step > 0.0);
            all.down += usize::from(step < 0.0);
            all.ones += usize::from(step == 1.0);
        }
        all
    }
}

/// Sum of a function of pairs of values, in several independent lanes: sequential additions would have to wait for each
/// other.
#[inline(always)]
fn sum_of_pairs(values: &[f64], others: &[f64], of: impl Fn(f64, f64) -> f64) -> f64 {
    const LANES: usize = 8;
    let (pieces, rest) = values.as_chunks::<LANES>();
    let (others, other_rest) = others.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (piece, other) in pieces.iter().zip(others) {
        for k in 0..LANES {
            sums[k] += of(piece[k], other[k]);
        }
    }
    sums.iter().sum::<f64>() + rest.iter().zip(other_rest).map(|(v, w)| of(*v, *w)).sum::<f64>()
}

fn mean_of(values: &[f64]) -> f64 {
    sum_of_pairs(values, values, |v, _| v) / values.len().max(1) as f64
}

fn mean_and_rms(values: &[f64]) -> (f64, f64) {
    let mean = mean_of(values);
    let squares = sum_of_pairs(values, values, |v, _| (v - mean) * (v - mean));
    (mean, (squares / values.len().max(1) as f64).sqrt())
}

/// Divides a column into blocks of at least two cycles.
fn blocks(values: &[f64]) -> Vec<&[f64]> {
    let n = values.len();
    let count = BLOCKS.min(n / 16).min(crossings(values) / BLOCK_CROSSINGS).max(4).min(n.max(1));
    (0..count).map(|b| &values[b * n / count..(b + 1) * n / count]).collect()
}

fn greatest_rms(blocks: &[&[f64]]) -> f64 {
    blocks.iter().map(|block| mean_and_rms(block).1).fold(0.0, f64::max)
}

/// Number of values at rest before the motion, and the part around the greatest swing between two rest periods. A
/// single block of a long record could contain a short decay completely.
fn motion(values: &[f64]) -> (usize, &[f64]) {
    let (mut rest, mut part) = (0, values);
    loop {
        let blocks = blocks(part);
        let rms: Vec<f64> = blocks.iter().map(|block| mean_and_rms(block).1).collect();
        let Some(peak) = (0..rms.len()).max_by(|a, b| rms[*a].total_cmp(&rms[*b])) else {
            return (rest, part);
        };
        let greatest = rms[peak];
        let rests = |rms: &f64| *rms <= REST * greatest;
        let first = rms[..peak].iter().rposition(rests).map_or(0, |i| i + 1);
        let last = rms[peak..].iter().position(rests).map_or(rms.len(), |i| peak + i);
        let start: usize = blocks[..first].iter().map(|b| b.len()).sum();
        let length: usize = blocks[first..last].iter().map(|b| b.len()).sum();
        let inner = &part[start..start + length];
        if inner.len() == part.len() || crossings(inner) < MOTION_CROSSINGS {
            return (rest, part);
        }
        (rest, part) = (rest + start, inner);
    }
}

fn crossings(values: &[f64]) -> usize {
    let mean = mean_of(values);
    let pairs = values.iter().zip(values.iter().skip(1));
    pairs.map(|(v, next)| usize::from((*v < mean) != (*next < mean))).sum()
}

/// Share of the blocks of a motion in which it decays, excluding those in which a drive was switched on or off.
fn decaying_share(blocks: &[&[f64]], begins_at_rest: bool) -> f64 {
    let greatest = greatest_rms(blocks);
    let dies_down = |block: &&&[f64]| {
        let rms = mean_and_rms(block).1;
        rms > REST * greatest && rms < FULL * greatest && smoothness(block) >= SMOOTH
    };
    let switched = 1 + usize::from(begins_at_rest);
    blocks.iter().filter(dies_down).count().saturating_sub(switched) as f64 / blocks.len() as f64
}

/// Correlation of successive values.
fn smoothness(values: &[f64]) -> f64 {
    let (mean, rms) = mean_and_rms(values);
    let next = values.get(1..).unwrap_or_default();
    let products = sum_of_pairs(&values[..next.len()], next, |v, w| (v - mean) * (w - mean));
    let covariance = products / values.len().max(1) as f64;
    if rms > 0.0 { covariance / (rms * rms) } else { 0.0 }
}

fn steady_positive(values: &[f64]) -> bool {
    let Some((first, rest)) = values.split_first() else { return false };
    let (mean, rms) = mean_and_rms(rest);
    rest.len() > 3 && rest.iter().all(|v| *v > 0.0) && rms < 0.3 * mean && *first < 0.5 * mean
}

/// Whether `candidate` behaves like the derivative of `column`: correlation with its central differences above 0.9.
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

/// Row distances whose difference serves as velocity; one of them is close to an eighth or a quarter of a period.
const VELOCITY_ROWS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// Whether `candidate` behaves like the square of an oscillation in `column` and of its velocity, as the acceleration
/// along a pendulum does when `column` is the acceleration across it.
pub(super) fn is_square(candidate: &[f64], column: &[f64]) -> bool {
    let mean = |values: &[f64]| {
        let finite = || values.iter().filter(|v| v.is_finite());
        finite().sum::<f64>() / finite().count().max(1) as f64
    };
    let (mean_u, mean_c) = (mean(column), mean(candidate));
    VELOCITY_ROWS.into_iter().any(|apart| {
        let rows = column.windows(2 * apart + 1).zip(candidate.get(apart..).unwrap_or_default());
        let rows: Vec<[f64; 3]> = rows
            .map(|(w, c)| [(w[apart] - mean_u).powi(2), (w[2 * apart] - w[0]).powi(2), c - mean_c])
            .filter(|row| row.iter().all(|v| v.is_finite()))
            .collect();
        explained(&rows) > SQUARE
    })
}

/// Part of the variance of the third number of each row explained by the first two.
fn explained(rows: &[[f64; 3]]) -> f64 {
    let n = rows.len().max(1) as f64;
    let mean = [0, 1, 2].map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / n);
    let product = |i: usize, j: usize| rows.iter().map(|r| (r[i] - mean[i]) * (r[j] - mean[j])).sum::<f64>();
    let (aa, bb, ab) = (product(0, 0), product(1, 1), product(0, 1));
    let (ac, bc, cc) = (product(0, 2), product(1, 2), product(2, 2));
    let determinant = aa * bb - ab * ab;
    if determinant > 1e-9 * aa * bb && cc > 0.0 {
        (ac * (ac * bb - bc * ab) + bc * (bc * aa - ac * ab)) / (determinant * cc)
    } else {
        0.0
    }
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
    fn a_short_decay_in_a_long_rest_rings_and_what_ends_at_once_does_not() {
        let long =
            |f: &dyn Fn(f64) -> f64| -> Vec<f64> { (0..60_000).map(|i| f(f64::from(i) * 0.01)).collect() };
        let after = |t: f64, from: f64| (t - from).max(0.0);
        let decay = long(&|t| if t < 20.0 { 0.0 } else { (-0.5 * after(t, 20.0)).exp() * (9.0 * t).cos() });
        assert!(Content::of(&decay).is_ringing());
        let burst = long(&|t| if (20.0..30.0).contains(&t) { (9.0 * t).cos() } else { 0.0 });
        assert!(!Content::of(&burst).is_ringing());
        let gate = long(&|t| (-2.0 * after(t, 20.0)).exp());
        assert!(!Content::of(&gate).is_ringing());
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
    fn what_runs_along_a_pendulum_is_the_square_of_what_runs_across_it() {
        let decay = |t: f64| 0.3 * (-0.03 * t).exp();
        let across = wave(|t| 2.0 + decay(t) * (3.0 * t).cos() + 2e-3 * (t * 1e5).sin());
        let along = wave(|t| {
            let (angle, velocity) = (decay(t) * (3.0 * t).cos(), -decay(t) * (3.0 * t).sin());
            9.81 * (angle.cos() + velocity * velocity) + 0.02 * (t * 2e5).sin()
        });
        assert!(is_square(&along, &across));
        assert!(!is_square(&across, &along));
        let second_axis = wave(|t| decay(t) * (3.1 * t).sin());
        assert!(!is_square(&second_axis, &across));
        assert!(!is_square(&wave(|t| 0.1 * (t * 1e5).sin()), &across));
        assert!(!is_square(&wave(|t| 9.81 + 0.3 * decay(t) * (3.0 * t).cos()), &across));
        assert!(!is_square(&along, &wave(|t| (t * 1e5).cos())));
    }

    #[test]
    fn no_numbers_have_no_content() {
        for column in [vec![], vec![f64::NAN; 9], vec![1.0], vec![1e308, -1e308]] {
            let content = Content::of(&column);
            assert!(!content.is_monotone());
            assert!(!content.is_ringing());
            assert!(!content.is_interval());
            assert!(!is_derivative(&column, &column));
            assert!(!is_square(&column, &column));
        }
    }
}

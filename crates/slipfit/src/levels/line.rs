//! The straight line through the levels that move, and what departs from it.

use super::answer::{Breakaway, LevelPoint};
use super::criteria::LevelCriteria;
use crate::inference::least_squares::linear;
use crate::numeric::order::ascending;
use std::f64::consts::FRAC_PI_4;

/// The straight line through the moving levels.
pub(super) struct Line {
    /// Which levels, by rising drive, move.
    pub(super) moving: Vec<bool>,
    pub(super) slope: f64,
    pub(super) intercept: f64,
    pub(super) rss: f64,
    total: f64,
}

/// The split that describes stuck (about zero) and moving (a rising line) branch best.
///
/// Split by the drive, unless that leaves clearly more unexplained than a split by amplitude: levels
/// that were raised and lowered, or raised only while the mass stuck beyond the threshold.
pub(super) fn split(x: &[f64], y: &[f64], weight: &[f64], c: &LevelCriteria) -> Option<Line> {
    let n = x.len();
    let by_drive = best_split(x, y, weight, &(0..n).collect::<Vec<_>>(), Order::Drive, c);
    let by_amplitude = best_split(x, y, weight, &ascending(y), Order::Amplitude, c);
    match (by_drive, by_amplitude) {
        (Some(drive), Some(amplitude)) if amplitude.total < c.amplitude_split * drive.total => {
            Some(amplitude)
        }
        (None, Some(amplitude)) => Some(amplitude),
        (drive, _) => drive,
    }
}

/// Whether two drives, the lower one first, are readings of one level.
pub(super) fn same_level(lower: f64, higher: f64, c: &LevelCriteria) -> bool {
    higher - lower <= c.same_level * higher
}

/// By what levels are split.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    Drive,
    Amplitude,
}

/// The best split where the levels move from one on in an order. In that of the drive all readings of a level
/// stick or all move, and the line's threshold is not far below the highest stuck level; in that of the amplitude what
/// sticks beside or above a level that moves reads far less than the line there.
fn best_split(
    x: &[f64],
    y: &[f64],
    weight: &[f64],
    order: &[usize],
    by: Order,
    c: &LevelCriteria,
) -> Option<Line> {
    let n = order.len();
    let mut best: Option<Line> = None;
    for first in 0..=n.checked_sub(3)? {
        let (stuck, moving) = order.split_at(first);
        if by == Order::Drive
            && let (Some(&last), Some(&next)) = (stuck.last(), moving.first())
            && same_level(x[last], x[next], c)
        {
            continue;
        }
        let rows = moving.iter().map(|&i| (vec![1.0, x[i]], y[i], weight[i]));
        let Some((line, _, rss)) = linear(rows, 2) else { continue };
        let (intercept, slope) = (line[0], line[1]);
        if !(slope > 0.0) {
            continue;
        }
        let contradicts = match by {
            Order::Drive => stuck.last().is_some_and(|&last| -intercept / slope < c.stuck_reach * x[last]),
            Order::Amplitude => {
                let lowest = moving.iter().map(|&i| x[i]).fold(f64::INFINITY, f64::min);
                let beside = stuck.iter().filter(|&&i| lowest < x[i] || same_level(x[i], lowest, c));
                beside.into_iter().any(|&i| y[i] > c.stuck_of_expected * (intercept + slope * x[i]))
            }
        };
        if contradicts {
            continue;
        }
        // What sticks reads its own level, the noise floor of an amplitude.
        let total_weight: f64 = stuck.iter().map(|&i| weight[i]).sum();
        let floor =
            stuck.iter().map(|&i| weight[i] * y[i]).sum::<f64>() / total_weight.max(f64::MIN_POSITIVE);
        let off: f64 = stuck.iter().map(|&i| weight[i] * (y[i] - floor).powi(2)).sum();
        let total = rss + off;
        // One more level on the stuck branch costs nothing but must pay.
        if best.as_ref().is_none_or(|b| total < b.total * (1.0 - 1.0 / n as f64)) {
            let mut moves = vec![false; n];
            moving.iter().for_each(|&i| moves[i] = true);
            best = Some(Line { moving: moves, slope, intercept, rss, total });
        }
    }
    best
}

impl Line {
    pub(super) fn moving_levels(&self) -> usize {
        self.moving.iter().filter(|moves| **moves).count()
    }

    /// The line through the same moving levels with other amplitudes.
    pub(super) fn through(&self, x: &[f64], y: &[f64], weight: &[f64]) -> Option<Self> {
        let moving = (0..x.len()).filter(|&i| self.moving[i]);
        let (c, _, rss) = linear(moving.map(|i| (vec![1.0, x[i]], y[i], weight[i])), 2)?;
        let (intercept, slope) = (c[0], c[1]);
        let total = self.total - self.rss + rss;
        (slope > 0.0).then(|| Self { moving: self.moving.clone(), slope, intercept, rss, total })
    }
}

/// Where the mass breaks loose, by the branches; `amplitudes`: of the motion, without what a detector adds.
pub(super) fn breakaway(
    points: &[LevelPoint],
    amplitudes: &[f64],
    [intercept, slope]: [f64; 2],
    c: &LevelCriteria,
) -> Option<Breakaway> {
    let threshold = -intercept / slope;
    // Above the threshold, and far from what the line expects there.
    let against_the_line = |(p, amplitude): &(&LevelPoint, &f64)| {
        let expected = slope * (p.drive - threshold);
        **amplitude < c.stuck_of_expected * expected && expected > c.expected_errors * p.std_error
    };
    let all = || points.iter().zip(amplitudes);
    let stuck_above_threshold = all().filter(against_the_line).map(|(p, _)| p.drive).next_back();
    let ratio = |stuck_at: f64| stuck_at / (FRAC_PI_4 * threshold);
    Some(Breakaway {
        stuck_below: points.iter().filter(|p| !p.moving).map(|p| p.drive).next_back(),
        moving_from: all().find(|each| each.0.moving && !against_the_line(each)).map(|(p, _)| p.drive)?,
        stuck_above_threshold,
        static_ratio_at_least: stuck_above_threshold.map(ratio).filter(|r| *r > 1.0 && r.is_finite()),
    })
}

//! The straight line through the levels that move, and what departs from it.

use super::answer::{Breakaway, LevelPoint};
use super::criteria::LevelCriteria;
use crate::inference::evidence::f_tail;
use crate::inference::least_squares::linear;
use crate::numeric::order::ascending;
use std::f64::consts::FRAC_PI_4;

/// The straight line through the moving levels.
pub(super) struct Line {
    /// Which levels, by rising drive, it goes through: those that move and stand out of the noise.
    pub(super) moving: Vec<bool>,
    /// Which levels stick. The lowest others may stick as well as move.
    pub(super) sticks: Vec<bool>,
    pub(super) slope: f64,
    pub(super) intercept: f64,
    pub(super) rss: f64,
    total: f64,
}

/// The split that describes stuck (about zero) and moving (a rising line) branch best.
///
/// Split by the drive, unless that leaves clearly more unexplained than a split by amplitude: levels
/// that were raised and lowered, or raised only while the mass stuck beyond the threshold. Levels that bend would take
/// stuck ones into their line: they are split beside a parabola where that leaves far less.
pub(super) fn split(x: &[f64], y: &[f64], weight: &[f64], c: &LevelCriteria) -> Option<Line> {
    let n = x.len();
    let by_rising_drive: Vec<usize> = (0..n).collect();
    let by_drive = best_split(x, y, weight, &by_rising_drive, Order::Drive, STRAIGHT, c);
    let by_amplitude = best_split(x, y, weight, &ascending(y), Order::Amplitude, STRAIGHT, c);
    let line = match (by_drive, by_amplitude) {
        (Some(drive), Some(amplitude)) if amplitude.total < c.amplitude_split * drive.total => amplitude,
        (None, Some(amplitude)) => amplitude,
        (drive, _) => drive?,
    };
    // Beside the curve and what sticks.
    let dof = n as f64 - PARABOLA as f64 - 1.0;
    let curve = best_split(x, y, weight, &by_rising_drive, Order::Drive, PARABOLA, c).filter(|curve| {
        let f = (line.total - curve.total) / (curve.total / dof).max(f64::MIN_POSITIVE);
        dof > 0.0 && f_tail(f, 1.0, dof) < c.not_straight
    });
    let (columns, found) = curve.map_or((STRAIGHT, line), |curve| (PARABOLA, curve));
    Some(without_uncertain(x, y, weight, found, columns, c))
}

/// The line without the lowest levels that may stick as well as move: those whose amplitude, by all higher ones, does
/// not stand out of the noise. Taken in, a stuck one hides a bend. What they read has no part in that, so that none is
/// left out for its noise. Nothing is left out where no level sticks.
fn without_uncertain(
    x: &[f64],
    y: &[f64],
    weight: &[f64],
    mut line: Line,
    columns: usize,
    c: &LevelCriteria,
) -> Line {
    if line.moving.iter().all(|moves| *moves) {
        return line;
    }
    let widest = x.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let row = |x: f64| row_of(x / widest);
    while line.moving_levels() > columns + 2 {
        let Some(lowest) = line.moving.iter().position(|moves| *moves) else { break };
        let mut moving = line.moving.clone();
        moving[lowest] = false;
        let rows = (0..x.len()).filter(|&i| moving[i]);
        let rows = rows.map(|i| (row(x[i])[..columns].to_vec(), y[i], weight[i]));
        let Some((found, _, rss)) = linear(rows, columns) else { break };
        let expected: f64 = row(x[lowest]).iter().zip(&found).map(|(r, c)| r * c).sum();
        let dof = (line.moving_levels() - 1 - columns) as f64;
        if expected > c.least_motion * (rss / dof / weight[lowest]).sqrt() {
            break;
        }
        match Line::of(moving, x, y, weight, line.total - line.rss) {
            Some(shorter) => line = Line { sticks: line.sticks, ..shorter },
            None => break,
        }
    }
    line
}

/// Columns of a line and a parabola at a drive over the highest.
fn row_of(x: f64) -> [f64; 3] {
    [1.0, x, x * x]
}

/// Columns of the moving branch.
const STRAIGHT: usize = 2;
const PARABOLA: usize = 3;

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
/// stick or all move, and the line's threshold is not far below the highest stuck level. What sticks where the line says
/// that it moves reads far less than the line: in the order of the drive where the line stands out of the noise, in that
/// of the amplitude beside or above a level that moves.
fn best_split(
    x: &[f64],
    y: &[f64],
    weight: &[f64],
    order: &[usize],
    by: Order,
    columns: usize,
    c: &LevelCriteria,
) -> Option<Line> {
    let n = order.len();
    let widest = x.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let row = |x: f64| row_of(x / widest);
    let least = if columns == STRAIGHT { 3 } else { c.bend_levels };
    let mut best: Option<Line> = None;
    for first in 0..=n.checked_sub(least)? {
        let (stuck, moving) = order.split_at(first);
        if by == Order::Drive
            && let (Some(&last), Some(&next)) = (stuck.last(), moving.first())
            && same_level(x[last], x[next], c)
        {
            continue;
        }
        let rows = moving.iter().map(|&i| (row(x[i])[..columns].to_vec(), y[i], weight[i]));
        let Some((found, _, rss)) = linear(rows, columns) else { continue };
        let expected = |x: f64| row(x).iter().zip(&found).map(|(r, c)| r * c).sum::<f64>();
        let lowest = moving.iter().map(|&i| x[i]).fold(f64::INFINITY, f64::min);
        let highest = moving.iter().map(|&i| x[i]).fold(0.0, f64::max);
        let slope = |x: f64| found[1] + 2.0 * found.get(2).unwrap_or(&0.0) * x / widest;
        if !(slope(lowest) > 0.0 && slope(highest) > 0.0) {
            continue;
        }
        // What sticks where the mass should move reads far less than it would then.
        let reads_as_moving = |i: usize| y[i] > c.stuck_of_expected * expected(x[i]);
        let contradicts = match by {
            Order::Drive => {
                let dof = (moving.len() as f64 - columns as f64).max(1.0);
                let stands_out =
                    |i: usize| expected(x[i]) > c.expected_errors * (rss / dof / weight[i]).sqrt();
                let below = |last: usize| expected(c.stuck_reach * x[last]) > 0.0;
                stuck.last().is_some_and(|&last| below(last))
                    || stuck.iter().any(|&i| stands_out(i) && reads_as_moving(i))
            }
            Order::Amplitude => {
                let beside = stuck.iter().filter(|&&i| lowest < x[i] || same_level(x[i], lowest, c));
                beside.into_iter().any(|&i| reads_as_moving(i))
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
            best = Line::of(moves, x, y, weight, off).map(|line| Line { total, ..line });
        }
    }
    best
}

impl Line {
    pub(super) fn moving_levels(&self) -> usize {
        self.moving.iter().filter(|moves| **moves).count()
    }

    /// The straight line through the levels that move; `off`: what the others leave.
    fn of(moving: Vec<bool>, x: &[f64], y: &[f64], weight: &[f64], off: f64) -> Option<Self> {
        let rows = (0..x.len()).filter(|&i| moving[i]).map(|i| (vec![1.0, x[i]], y[i], weight[i]));
        let (c, _, rss) = linear(rows, STRAIGHT)?;
        let (intercept, slope) = (c[0], c[1]);
        let sticks = moving.iter().map(|moves| !moves).collect();
        (slope > 0.0).then_some(Self { moving, sticks, slope, intercept, rss, total: rss + off })
    }

    /// The line through the same moving levels with other amplitudes.
    pub(super) fn through(&self, x: &[f64], y: &[f64], weight: &[f64]) -> Option<Self> {
        let line = Self::of(self.moving.clone(), x, y, weight, self.total - self.rss)?;
        Some(Self { sticks: self.sticks.clone(), ..line })
    }
}

/// Which levels were seen neither stuck nor moving: those that by the line may stick as well as move, and whose own reading
/// does not stand out of the noise.
pub(super) fn undecided(
    points: &[LevelPoint],
    amplitudes: &[f64],
    line: &Line,
    c: &LevelCriteria,
) -> Vec<bool> {
    let stands_out = |p: &LevelPoint, amplitude: f64| amplitude > c.expected_errors * p.std_error;
    points
        .iter()
        .zip(amplitudes)
        .zip(&line.moving)
        .map(|((p, amplitude), in_line)| p.moving && !in_line && !stands_out(p, *amplitude))
        .collect()
}

/// Where the mass breaks loose, by the branches; `amplitudes`: of the motion, without what a detector adds.
pub(super) fn breakaway(
    points: &[LevelPoint],
    amplitudes: &[f64],
    undecided: &[bool],
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
    let first_moving = all()
        .zip(undecided)
        .find(|(each, undecided)| each.0.moving && !**undecided && !against_the_line(each))
        .map(|((p, _), _)| p.drive);
    let stuck_above_threshold = all().filter(against_the_line).map(|(p, _)| p.drive).next_back();
    let ratio = |stuck_at: f64| stuck_at / (FRAC_PI_4 * threshold);
    Some(Breakaway {
        stuck_below: points.iter().filter(|p| !p.moving).map(|p| p.drive).next_back(),
        moving_from: first_moving?,
        stuck_above_threshold,
        static_ratio_at_least: stuck_above_threshold.map(ratio).filter(|r| *r > 1.0 && r.is_finite()),
    })
}

//! The straight line through the moving levels, and deviations from it.

use super::criteria::LevelCriteria;
use super::sorted::SortedLevels;
use crate::inference::evidence::f_tail;
use crate::inference::least_squares::linear;
use crate::numeric::order::ascending;

/// The straight line through the moving levels.
pub(super) struct Line {
    /// Levels, by increasing drive, that the line goes through: those that move and exceed the noise.
    pub(super) moving: Vec<bool>,
    /// Levels that stick. The lowest of the others may stick or move.
    pub(super) sticks: Vec<bool>,
    pub(super) slope: f64,
    pub(super) intercept: f64,
    pub(super) rss: f64,
    total: f64,
}

/// The split that best describes a stuck branch (about zero) and a moving branch (a rising line).
///
/// The levels are split by drive, unless that leaves clearly larger residuals than a split by amplitude: levels that
/// were raised and lowered, or only raised while the mass stuck beyond the threshold. With bent levels a straight line
/// would include stuck levels; these are split with a parabola if its residuals are far smaller.
pub(super) fn split(levels: &SortedLevels, c: &LevelCriteria) -> Option<Line> {
    let n = levels.len();
    let by_rising_drive: Vec<usize> = (0..n).collect();
    let by_drive = best_split(levels, &by_rising_drive, Order::Drive, STRAIGHT, c);
    let by_amplitude = best_split(levels, &ascending(&levels.amplitude), Order::Amplitude, STRAIGHT, c);
    let line = match (by_drive, by_amplitude) {
        (Some(drive), Some(amplitude)) if amplitude.total < c.amplitude_split * drive.total => amplitude,
        (None, Some(amplitude)) => amplitude,
        (drive, _) => drive?,
    };
    // In addition to the parameters of the curve and the mean of the stuck levels.
    let dof = n as f64 - PARABOLA as f64 - 1.0;
    let curve = best_split(levels, &by_rising_drive, Order::Drive, PARABOLA, c).filter(|curve| {
        let f = (line.total - curve.total) / (curve.total / dof).max(f64::MIN_POSITIVE);
        dof > 0.0 && f_tail(f, 1.0, dof) < c.not_straight
    });
    let (columns, found) = curve.map_or((STRAIGHT, line), |curve| (PARABOLA, curve));
    Some(without_uncertain(levels, found, columns, c))
}

/// The line without its lowest levels that may stick or move: those whose amplitude, as predicted by all higher levels,
/// does not exceed the noise. A stuck level included in the line hides a bend. Their own readings are not used, so that
/// no level is excluded because of its noise. Nothing is excluded if no level sticks.
fn without_uncertain(levels: &SortedLevels, mut line: Line, columns: usize, c: &LevelCriteria) -> Line {
    if line.moving.iter().all(|moves| *moves) {
        return line;
    }
    let row = scaled_rows(levels);
    while line.moving_levels() > columns + 2 {
        let Some(lowest) = line.moving.iter().position(|moves| *moves) else { break };
        let mut moving = line.moving.clone();
        moving[lowest] = false;
        let rows = (0..levels.len()).filter(|&i| moving[i]);
        let rows = rows.map(|i| (row(i)[..columns].to_vec(), levels.response(i), levels.weight(i)));
        let Some((found, _, rss)) = linear(rows, columns) else { break };
        let expected = levels.rows[lowest].offset + product(&row(lowest), &found);
        let dof = (line.moving_levels() - 1 - columns) as f64;
        if expected > c.least_motion * (rss / dof / levels.weight(lowest)).sqrt() {
            break;
        }
        match Line::of(moving, levels, &levels.amplitude, line.total - line.rss) {
            Some(shorter) => line = Line { sticks: line.sticks, ..shorter },
            None => break,
        }
    }
    line
}

/// Columns of a line and of a parabola for each level, with the drive relative to the highest.
fn scaled_rows(levels: &SortedLevels) -> impl Fn(usize) -> [f64; 3] + '_ {
    let widest = levels.widest();
    move |i| {
        let [by_intercept, by_slope] = levels.rows[i].by;
        [by_intercept, by_slope / widest, (levels.drive[i] / widest).powi(2)]
    }
}

/// The columns that `found` has coefficients for, times these.
fn product(row: &[f64], found: &[f64]) -> f64 {
    row.iter().zip(found).map(|(r, c)| r * c).sum()
}

/// Number of columns of the moving branch.
const STRAIGHT: usize = 2;
const PARABOLA: usize = 3;

/// Whether two drives, the lower one first, belong to one level.
pub(super) fn same_level(lower: f64, higher: f64, c: &LevelCriteria) -> bool {
    higher - lower <= c.same_level * higher
}

/// Order by which levels are split.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    Drive,
    Amplitude,
}

/// The best split in which all levels from some position of the order on move. In the order of the drive all readings
/// of one level stick or move together, and the threshold of the line is not far below the highest stuck level. A level
/// that sticks although the line predicts motion must read far less than the line: in the order of the drive where the
/// line exceeds the noise, in the order of the amplitude at or above the lowest drive of a moving level.
fn best_split(
    levels: &SortedLevels,
    order: &[usize],
    by: Order,
    columns: usize,
    c: &LevelCriteria,
) -> Option<Line> {
    let n = order.len();
    let (x, y, widest) = (&levels.drive, &levels.amplitude, levels.widest());
    let weight = |i: usize| levels.weight(i);
    let row = scaled_rows(levels);
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
        // A level that no line near the fit moves does not determine it.
        if moving.iter().filter(|&&i| levels.rows[i].by != [0.0; 2]).count() < least {
            continue;
        }
        let rows = moving.iter().map(|&i| (row(i)[..columns].to_vec(), levels.response(i), weight(i)));
        let Some((found, _, rss)) = linear(rows, columns) else { continue };
        let expected = |i: usize| levels.rows[i].offset + product(&row(i), &found);
        let lowest = moving.iter().map(|&i| x[i]).fold(f64::INFINITY, f64::min);
        let highest = moving.iter().map(|&i| x[i]).fold(0.0, f64::max);
        let slope = |x: f64| found[1] + 2.0 * found.get(2).unwrap_or(&0.0) * x / widest;
        if !(slope(lowest) > 0.0 && slope(highest) > 0.0) {
            continue;
        }
        let dof = (moving.len() as f64 - columns as f64).max(1.0);
        let noise = |i: usize| (rss / dof / weight(i)).sqrt();
        // A level that sticks where the mass should move must read far less than a moving one.
        let reads_as_moving = |i: usize| y[i] > c.stuck_of_expected * expected(i);
        let contradicts = match by {
            Order::Drive => {
                let stands_out = |i: usize| expected(i) > c.expected_errors * noise(i);
                let below = |last: usize| {
                    let x = c.stuck_reach * x[last] / widest;
                    product(&[1.0, x, x * x], &found) > 0.0
                };
                stuck.last().is_some_and(|&last| below(last))
                    || stuck.iter().any(|&i| stands_out(i) && reads_as_moving(i))
            }
            Order::Amplitude => {
                let beside = || stuck.iter().filter(|&&i| lowest < x[i] || same_level(x[i], lowest, c));
                // Noise alone orders stuck levels as well.
                let highest_stuck = beside().map(|&i| x[i]).fold(0.0, f64::max);
                let in_noise = |i: usize| y[i] <= c.least_motion * noise(i);
                beside().any(|&i| reads_as_moving(i))
                    || moving.iter().any(|&i| x[i] < highest_stuck && in_noise(i))
            }
        };
        if contradicts {
            continue;
        }
        // Stuck levels have their own mean, the noise floor of an amplitude.
        let total_weight: f64 = stuck.iter().map(|&i| weight(i)).sum();
        let floor =
            stuck.iter().map(|&i| weight(i) * y[i]).sum::<f64>() / total_weight.max(f64::MIN_POSITIVE);
        let off: f64 = stuck.iter().map(|&i| weight(i) * (y[i] - floor).powi(2)).sum();
        let total = rss + off;
        // An additional stuck level has no cost of its own, so it must reduce the residuals.
        if best.as_ref().is_none_or(|b| total < b.total * (1.0 - 1.0 / n as f64)) {
            let mut moves = vec![false; n];
            moving.iter().for_each(|&i| moves[i] = true);
            best = Line::of(moves, levels, y, off).map(|line| Line { total, ..line });
        }
    }
    best
}

impl Line {
    pub(super) fn moving_levels(&self) -> usize {
        self.moving.iter().filter(|moves| **moves).count()
    }

    /// The straight line through the moving levels; `off`: sum of squares of the others.
    fn of(moving: Vec<bool>, levels: &SortedLevels, y: &[f64], off: f64) -> Option<Self> {
        let row = |i: usize| (levels.rows[i].by.to_vec(), y[i] - levels.rows[i].offset, levels.weight(i));
        let rows = (0..levels.len()).filter(|&i| moving[i]).map(row);
        let (c, _, rss) = linear(rows, STRAIGHT)?;
        let (intercept, slope) = (c[0], c[1]);
        let sticks = moving.iter().map(|moves| !moves).collect();
        (slope > 0.0).then_some(Self { moving, sticks, slope, intercept, rss, total: rss + off })
    }

    /// The line through the same moving levels with other amplitudes.
    pub(super) fn through(&self, levels: &SortedLevels, y: &[f64]) -> Option<Self> {
        let line = Self::of(self.moving.clone(), levels, y, self.total - self.rss)?;
        Some(Self { sticks: self.sticks.clone(), ..line })
    }
}

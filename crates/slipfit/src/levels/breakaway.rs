//! Breakaway of the mass: levels at which it sticks, moves, or may do either.

use super::answer::{Breakaway, LevelPoint};
use super::branch::MovingBranch;
use super::criteria::LevelCriteria;
use std::f64::consts::FRAC_PI_4;

/// Levels that were seen neither stuck nor moving: those that may stick or move according to the line and whose own
/// reading does not exceed the noise, and those below the threshold of the line, at which the exact motion stops twice
/// per cycle.
pub(super) fn undecided(points: &[LevelPoint], branch: &MovingBranch, c: &LevelCriteria) -> Vec<bool> {
    let threshold = -branch.fit.parameters[0] / branch.fit.parameters[1];
    let is_exact = branch.drawn.exact_q.is_some();
    let of = |(i, p): (usize, &LevelPoint)| {
        let stands_out = branch.motion[i] > c.expected_errors * p.std_error;
        let stops = is_exact && p.drive <= threshold;
        p.moving && (stops || !branch.line.moving[i] && !stands_out)
    };
    points.iter().enumerate().map(of).collect()
}

/// Breakaway according to the branches.
pub(super) fn breakaway(
    points: &[LevelPoint],
    branch: &MovingBranch,
    undecided: &[bool],
    c: &LevelCriteria,
) -> Option<Breakaway> {
    let threshold = -branch.fit.parameters[0] / branch.fit.parameters[1];
    // Above the threshold, and far from the expected value.
    let against_the_line = |i: &usize| {
        let (p, expected) = (&points[*i], branch.expected[*i]);
        let reads_less = branch.motion[*i] < c.stuck_of_expected * expected;
        p.drive > threshold && reads_less && expected > c.expected_errors * p.std_error
    };
    let all = || 0..points.len();
    let first_moving =
        all().find(|i| points[*i].moving && !undecided[*i] && !against_the_line(i)).map(|i| points[i].drive);
    let stuck_above_threshold = all().filter(against_the_line).map(|i| points[i].drive).next_back();
    let ratio = |stuck_at: f64| stuck_at / (FRAC_PI_4 * threshold);
    Some(Breakaway {
        stuck_below: points.iter().filter(|p| !p.moving).map(|p| p.drive).next_back(),
        moving_from: first_moving?,
        stuck_above_threshold,
        static_ratio_at_least: stuck_above_threshold.map(ratio).filter(|r| *r > 1.0 && r.is_finite()),
    })
}

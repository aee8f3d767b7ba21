//! Finds the turning point at which friction stopped the motion.
//!
//! The rest position alternates in sign as the friction grows, so the sum of squares has a minimum for every
//! turning point at which the motion may have stopped. For a given turning point the sum of squares is
//! smooth, and its minimum is no higher than that of any motion that stops there. The turning points are
//! examined in order of increasing minima.

use super::minimise::{Minimum, Sums, inverse, step};
use super::samples::{Samples, Stop, improved_start};
use crate::motion::decay::amplitude::sliding_gain;
use crate::motion::decay::closed_sums::Fall;
use std::f64::consts::PI;

/// Number of initial parts of the record that are tried as the motion, and the factor by which each is
/// shorter than the last.
const PART_RATIO: f64 = 0.82;
const PARTS: usize = 20;
/// Minimum number of half cycles and of samples per part.
const LEAST_TURNS: f64 = 1.5;
const LEAST_SAMPLES: usize = 8;
/// Number of turning points examined on either side of the lowest minimum.
const TURNS_PER_SIDE: usize = 3;
/// Number of turning points after the start that are examined.
const FIRST_TURNS: usize = 4;
/// Number of motions, those with the lowest sum of squares, whose stop is searched for.
const CANDIDATES: usize = 8;
/// Number of times a search that has not converged is continued.
const MOST_CONTINUATIONS: usize = 4;
/// Number of steps along the boundary of the motions that stop at a turning point.
const EDGE_STEPS: usize = 12;

/// Amplitude that remains at the turning point `n` after friction is overcome: the motion continues if it is
/// positive.
fn remaining_amplitude(&[a0, x_f, delta, phase, omega, _]: &[f64; 6], n: f64) -> f64 {
    let fall = Fall::after(delta, (n * PI - phase) / omega);
    a0 * fall.e - x_f * (sliding_gain(delta, omega)[0] * fall.g + 1.0)
}

/// The index of the first turning point after `t`.
fn turn_after(p: &[f64; 6], t: f64) -> f64 {
    ((p[3] + p[4] * t) / PI).ceil()
}

/// The turning point at which friction stops the motion, if before `last`.
fn stop_of(p: &[f64; 6], last: f64) -> Option<f64> {
    let (mut moves, mut rests) = ((p[3] / PI).floor(), turn_after(p, last));
    if !(p[4] > 0.0 && rests - moves < 1e9) || remaining_amplitude(p, rests) > 0.0 {
        return None;
    }
    while rests - moves > 1.0 {
        let middle = (0.5 * (moves + rests)).floor();
        if remaining_amplitude(p, middle) <= 0.0 { rests = middle } else { moves = middle }
    }
    Some(rests)
}

/// The lowest minimum among motions near `stopping`, which stops, and `known`, which does not.
pub(super) fn near_stopping(
    samples: &Samples<'_>,
    stopping: &[f64; 6],
    known: Minimum<6>,
) -> Option<Minimum<6>> {
    let mut stops = Stops { samples, known: Vec::new() };
    stops.about(stopping);
    stops.lowest(Some(known))
}

/// The lowest minimum over all turning points at which the motion may stop, including `known`. Any initial
/// part of the record may be the motion.
pub(super) fn of_any_part(
    samples: &Samples<'_>,
    start: &[f64; 6],
    known: Option<Minimum<6>>,
) -> Option<Minimum<6>> {
    let mut stops = Stops { samples, known: Vec::new() };
    if let Some(known) = &known {
        stops.about(&known.best);
    }
    let (origin, n) = (samples.time[0], samples.time.len());
    let duration = samples.time[n - 1] - origin;
    let first = (start[3] / PI).floor();
    let mut motions: Vec<(f64, [f64; 6])> = (1..=FIRST_TURNS).map(|k| (first + k as f64, *start)).collect();
    let mut end = duration;
    for _ in 0..PARTS {
        let count = samples.time.partition_point(|t| t - origin <= end);
        if count < LEAST_SAMPLES || end * start[4] < LEAST_TURNS * PI {
            break;
        }
        let part =
            Samples { time: &samples.time[..count], signal: &samples.signal[..count], power: samples.power };
        let near = improved_start(part.time, part.signal, start).map_or(*start, |(near, _)| near);
        for from in [near, *start] {
            if let Some(motion) = part.fit(from, Stop::Never) {
                motions.push((turn_after(&motion.best, end), motion.best));
                motions.extend(stop_of(&motion.best, duration).map(|turn| (turn, motion.best)));
            }
            if near == *start {
                break;
            }
        }
        end *= PART_RATIO;
    }
    let rss =
        |(turn, p): &(f64, [f64; 6])| samples.sums(p, Stop::Turn(*turn)).map_or(f64::INFINITY, |s| s.rss);
    let mut motions: Vec<_> = motions.iter().map(|motion| (rss(motion), motion)).collect();
    motions.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, (turn, p)) in motions.into_iter().take(CANDIDATES) {
        stops.offer(*turn, p);
    }
    stops.lowest(known)
}

/// Minima for given turning points of the stop.
struct Stops<'a> {
    samples: &'a Samples<'a>,
    known: Vec<(f64, Minimum<6>)>,
}

impl Stops<'_> {
    /// The minimum reached from a start; for a motion of few half cycles it may lie at the end of a long
    /// valley.
    fn fit(&self, from: [f64; 6], stop: Stop) -> Option<Minimum<6>> {
        let mut found = self.samples.fit(from, stop)?;
        for _ in 0..MOST_CONTINUATIONS {
            if found.converged {
                break;
            }
            found = self.samples.fit(found.best, stop)?;
        }
        Some(found)
    }

    /// Searches from `from` for the minimum of motions that stop at the turning point `turn`.
    fn offer(&mut self, turn: f64, from: &[f64; 6]) {
        let last = self.samples.time[self.samples.time.len() - 1] - self.samples.time[0];
        if !(turn > from[3] / PI && (turn * PI - from[3]) < from[4] * last) {
            return;
        }
        let Some(found) = self.samples.fit(*from, Stop::Turn(turn)) else { return };
        match self.known.iter_mut().find(|(known, _)| *known == turn) {
            Some((_, known)) if known.rss <= found.rss => {}
            Some((_, known)) => *known = found,
            None => self.known.push((turn, found)),
        }
    }

    /// Offers the turning point at which friction stops the motion `p`.
    fn about(&mut self, p: &[f64; 6]) {
        let last = self.samples.time[self.samples.time.len() - 1] - self.samples.time[0];
        if let Some(turn) = stop_of(p, last) {
            self.offer(turn, p);
        }
    }

    /// Searches on both sides of the lowest minimum until no lower one is found.
    fn spread(&mut self) {
        let lowest = |known: &[(f64, Minimum<6>)]| {
            known.iter().min_by(|a, b| a.1.rss.total_cmp(&b.1.rss)).map(|(turn, fit)| (*turn, *fit))
        };
        let mut about = None;
        while let Some((turn, fit)) = lowest(&self.known).filter(|(turn, _)| Some(*turn) != about) {
            about = Some(turn);
            for side in [-1.0, 1.0] {
                let mut from = fit.best;
                for k in 1..=TURNS_PER_SIDE {
                    let next = turn + side * k as f64;
                    self.offer(next, &from);
                    let Some((_, found)) = self.known.iter().find(|(known, _)| *known == next) else { break };
                    from = found.best;
                }
            }
        }
    }

    /// The lowest minimum among all motions stopped by friction and `known`.
    fn lowest(mut self, known: Option<Minimum<6>>) -> Option<Minimum<6>> {
        self.spread();
        let mut best = known;
        self.known.sort_by(|a, b| a.1.rss.total_cmp(&b.1.rss));
        for (turn, minimum) in &self.known {
            if best.is_some_and(|best| best.rss <= minimum.rss) {
                break;
            }
            let found = self.within(*turn, minimum);
            best = [best, found].into_iter().flatten().min_by(|a, b| a.rss.total_cmp(&b.rss));
        }
        best
    }

    /// The lowest of the motions stopped by friction at this turning point, near the minimum over all that
    /// stop there.
    fn within(&self, turn: f64, minimum: &Minimum<6>) -> Option<Minimum<6>> {
        let p = &minimum.best;
        if remaining_amplitude(p, turn) <= 0.0 && remaining_amplitude(p, turn - 1.0) > 0.0 {
            return self.fit(*p, Stop::Friction);
        }
        // The minimum lasts one half cycle too long or too short: the boundary is the motion that just stops.
        let edge = if remaining_amplitude(p, turn) > 0.0 { turn } else { turn - 1.0 };
        let edge = self.along_edge(turn, edge, *p)?;
        self.fit(edge, Stop::Friction)
    }

    /// The minimum under the constraint that the remaining amplitude at the turning point `edge` is zero.
    fn along_edge(&self, turn: f64, edge: f64, from: [f64; 6]) -> Option<[f64; 6]> {
        let mut p = from;
        for _ in 0..EDGE_STEPS {
            let sums: Sums<6> = self.samples.sums(&p, Stop::Turn(turn))?;
            let inverse = inverse(&sums.jtj)?;
            let (free, _) = step(&sums, 0.0)?;
            let here = remaining_amplitude(&p, edge);
            let slope: [f64; 6] = std::array::from_fn(|k| {
                let h = 1e-6 * (inverse[k][k].max(0.0) * sums.rss.max(1e-12 * self.samples.power)).sqrt();
                let (mut up, mut down) = (p, p);
                up[k] += h;
                down[k] -= h;
                if h > 0.0 {
                    (remaining_amplitude(&up, edge) - remaining_amplitude(&down, edge)) / (2.0 * h)
                } else {
                    0.0
                }
            });
            let along: [f64; 6] = std::array::from_fn(|i| (0..6).map(|k| inverse[i][k] * slope[k]).sum());
            let steep: f64 = (0..6).map(|k| along[k] * slope[k]).sum();
            let promised: f64 = here + (0..6).map(|k| free[k] * slope[k]).sum::<f64>();
            if !(steep > 0.0) {
                return None;
            }
            let next: [f64; 6] = std::array::from_fn(|k| p[k] + free[k] - along[k] * promised / steep);
            let length: f64 = (0..6).map(|k| (next[k] - p[k]).powi(2) / inverse[k][k]).fold(0.0, f64::max);
            p = next;
            if length <= 1e-10 * sums.rss {
                break;
            }
        }
        p.iter().all(|v| v.is_finite()).then_some(p)
    }
}

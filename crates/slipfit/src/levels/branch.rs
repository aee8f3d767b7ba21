//! The moving branch: its line, the reading that the detector adds, and its bend.

use super::answer::{Detector, FittedLevels};
use super::bend::{CurvedFit, averaged, bend};
use super::criteria::Criteria;
use super::curve::Growth;
use super::line::{Line, split};
use super::noise::{AveragedFit, LinearLevels};
use super::plateau::{Corrected, OffsetKind, Plateau};
use super::sorted::SortedLevels;
use crate::inference::least_squares::linear;

/// Analysis of the moving levels.
pub(super) struct MovingBranch {
    pub(super) line: Line,
    /// Amplitude of the motion at each level, with the reading added by the detector subtracted.
    pub(super) motion: Vec<f64>,
    /// The same as expected from `fit` without a bend.
    pub(super) expected: Vec<f64>,
    /// Change of intercept and slope per relative change of the Q that shapes the exact motion.
    pub(super) by_log_q: [f64; 2],
    pub(super) plateau: Option<(Plateau, OffsetKind)>,
    /// Intercept and slope of the line with their covariance, or of curves in the limit of small amplitudes if the
    /// levels do not lie on a line.
    pub(super) fit: AveragedFit,
    /// The curve, if the levels do not exclude a line.
    pub(super) rival: Option<CurvedFit>,
    /// p value of a straight line, and whether the slope decreases.
    pub(super) bend: (f64, bool),
    /// Weighted root mean square of the residuals.
    pub(super) residual_rms: f64,
    /// The line or curve that is drawn.
    pub(super) drawn: FittedLevels,
}

impl MovingBranch {
    /// `None` if fewer than three levels move, or if the amplitude does not increase with the drive.
    pub(super) fn of(sorted: &SortedLevels, criteria: &Criteria) -> Option<Self> {
        Self::through(split(sorted, &criteria.levels)?, sorted, criteria)
    }

    /// The branch through the moving levels of `line`.
    pub(super) fn through(mut line: Line, sorted: &SortedLevels, criteria: &Criteria) -> Option<Self> {
        let c = &criteria.levels;
        let (x, weights) = (&sorted.drive, sorted.weights.as_deref());
        let weight: Vec<f64> = (0..x.len()).map(|i| sorted.weight(i)).collect();
        let moving = line.moving.clone();
        let straight =
            |y: &[f64]| AveragedFit::of(&LinearLevels::of_line(&sorted.rows, y, &moving), weights, c);
        let mut fit = straight(&sorted.amplitude)?;
        let mut motion = sorted.amplitude.clone();
        let mut detector = Detector::default();
        let mut plateau = None;
        let dof = (line.moving_levels() as f64 - 2.0).max(1.0);
        let errors_known = fit.dof.is_infinite();
        let minus_two_log =
            |line: &Line| if errors_known { line.rss } else { dof * line.rss.max(f64::MIN_POSITIVE).ln() };
        let found = Plateau::of(x, &sorted.amplitude, &weight, &line, c);
        let corrected = found.and_then(|p| {
            let through = |y: &[f64]| line.through(sorted, y);
            p.subtracted_from(&sorted.amplitude, through, straight, minus_two_log).map(|c| (p, c))
        });
        // The values are averaged over both ways in which a detector may add its reading; the one drawn is one of them.
        let mut drawn = [fit.parameters[0], fit.parameters[1]];
        if let Some((found, Corrected { kind, at_rest, levels, line: by_one, found: averaged })) = corrected {
            plateau = Some((found, kind));
            detector = Detector { at_rest, squares: kind == OffsetKind::Quadrature };
            (motion, line, fit) = (levels, by_one, averaged);
            drawn = [line.intercept, line.slope];
        }
        let of_moving =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&moving).filter(|(_, m)| **m).map(|(v, _)| *v).collect() };
        let precision: Vec<f64> = fit.variance.iter().map(|v| 1.0 / v.max(f64::MIN_POSITIVE)).collect();
        let bend = bend(sorted, &motion, &moving, &precision, c.bend_levels);
        let through =
            |growth| CurvedFit::through(growth, sorted, &motion, &moving, [line.intercept, line.slope], c);
        let [mut square, cube] = Growth::ALL.map(through);
        let (mut rss, mut bent, mut growth, mut rival) = (line.rss, 0.0, Growth::Square, None);
        let is_bent = bend.0 < c.not_straight;
        let rising = |curve: &CurvedFit| curve.rises() && is_bent;
        let curves: Vec<CurvedFit> =
            [square.take_if(|c| rising(c)), cube.filter(rising)].into_iter().flatten().collect();
        if let Some(best) = curves.iter().min_by(|a, b| a.rss.total_cmp(&b.rss)) {
            let by_line = straight(&motion)?;
            let (parameters, covariance) = averaged(&curves, errors_known, c);
            (rss, bent, growth) = (best.rss, best.bend(), best.growth);
            // A plateau changes the curve and its covariance by as much as it changes the line.
            drawn = [0, 1].map(|i| drawn[i] + best.fit.parameters[i] - by_line.parameters[i]);
            for i in 0..2 {
                fit.parameters[i] += parameters[i] - by_line.parameters[i];
                for j in 0..2 {
                    fit.covariance[(i, j)] += covariance[(i, j)] - by_line.covariance[(i, j)];
                }
            }
            (fit.variance, fit.dof) = (best.fit.variance.clone(), best.fit.dof);
        } else if let Some(curve) = square {
            let [intercept, slope, bend] = curve.averaged_with_line(drawn, c, &criteria.inference);
            (drawn, bent) = ([intercept, slope], bend);
            rival = Some(curve);
        }
        let total: f64 = of_moving(&weight).iter().sum();
        let [intercept, slope] = drawn;
        let threshold = (-intercept / slope).max(0.0);
        let drawn = FittedLevels { slope, threshold, exact_q: None, bend: bent, growth, detector };
        let by_log_q = shift_by_log_q(sorted, &moving, &precision).unwrap_or_default();
        let expected = sorted.rows.iter().map(|row| row.amplitude([fit.parameters[0], fit.parameters[1]]));
        let expected = expected.collect();
        let residual_rms = (rss / total).sqrt();
        Some(Self { line, motion, expected, by_log_q, plateau, fit, rival, bend, residual_rms, drawn })
    }
}

/// Change of intercept and slope by which the moving levels make up for a relative change of Q.
fn shift_by_log_q(sorted: &SortedLevels, moving: &[bool], weight: &[f64]) -> Option<[f64; 2]> {
    let rows = sorted.rows.iter().zip(weight).zip(moving).filter(|(_, moves)| **moves);
    let rows = rows.map(|((row, weight), _)| (row.by.to_vec(), -row.by_log_q, *weight));
    let (shift, ..) = linear(rows, 2)?;
    Some([shift[0], shift[1]])
}

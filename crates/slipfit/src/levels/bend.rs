//! Levels on a curve: loss proportional to the square of the amplitude, or a compressive detector.

use super::criteria::LevelCriteria;
use super::curve::Growth;
use super::level_row::LevelRow;
use super::noise::{AveragedFit, LinearLevels};
use super::sorted::SortedLevels;
use crate::inference::Z_95;
use crate::inference::coefficient::{AbsentCoefficient, WeightedEstimate};
use crate::inference::criteria::InferenceCriteria;
use crate::inference::evidence::{f_tail, student_factor};
use crate::inference::least_squares::{LeastSquares, Normal, linear, minimise};
use crate::inference::model_average::ModelWeights;
use nalgebra::DMatrix;

/// p value of a quadratic term or of a kink in the moving branch, and whether its slope decreases; 1 if there are fewer
/// than `least` levels. The p value is multiplied by the number of alternatives: one for the quadratic term and one for
/// each level at which a kink, as of a saturating amplifier, may lie.
pub(super) fn bend(
    levels: &SortedLevels,
    motion: &[f64],
    moving: &[bool],
    weight: &[f64],
    least: usize,
) -> (f64, bool) {
    let all: Vec<usize> = (0..motion.len()).filter(|&i| moving[i]).collect();
    let n = all.len();
    if n < least {
        return (1.0, false);
    }
    let x = |i: usize| levels.drive[i];
    let centre = all.iter().map(|&i| x(i)).sum::<f64>() / n as f64;
    let fit = |further: Option<&dyn Fn(f64) -> f64>| {
        let rows = all.iter().map(|&i| {
            let [by_intercept, by_slope] = levels.rows[i].by;
            let mut row = vec![by_intercept, by_slope - centre * by_intercept];
            row.extend(further.map(|f| f(x(i))));
            (row, motion[i] - levels.rows[i].offset, weight[i])
        });
        linear(rows, if further.is_some() { 3 } else { 2 })
    };
    let Some((.., straight)) = fit(None) else { return (1.0, false) };
    let with = |further: &dyn Fn(f64) -> f64, times: f64| {
        let (c, _, rss) = fit(Some(further))?;
        let dof = n as f64 - 3.0;
        let f = (straight - rss).max(0.0) / (rss / dof).max(f64::MIN_POSITIVE);
        Some(((times * f_tail(f, 1.0, dof)).min(1.0), c[2] < 0.0))
    };
    let kinks = all.get(2..n.saturating_sub(2)).unwrap_or_default();
    let kinked =
        kinks.iter().filter_map(|&at| with(&|drive| (drive - x(at)).max(0.0), kinks.len() as f64 + 1.0));
    let bent = with(&|x| (x - centre).powi(2), kinks.len() as f64 + 1.0);
    bent.into_iter().chain(kinked).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((1.0, false))
}

/// The moving levels on `y + c y² = a + b x`, or on `y + c y³`: viscous loss and a further loss balance the excess of
/// the drive over the threshold.
///
/// Slope `b` and intercept `a` are those in the limit of small amplitudes, as for the line; `c` times an amplitude, or
/// times its square, is the ratio of the further loss to the viscous one at this amplitude: drag, or cubic damping. A
/// compressive detector bends the levels in the same direction, an expanding one or friction that decreases with speed
/// in the opposite direction.
pub(super) struct CurvedFit {
    pub(super) growth: Growth,
    /// `a`, `b` and `c` with their covariance.
    pub(super) fit: AveragedFit,
    /// Weighted sum of squares.
    pub(super) rss: f64,
    /// Highest amplitude of the motion.
    highest: f64,
    /// Number of moving levels.
    levels: usize,
}

/// Slots of the parameters.
const INTERCEPT: usize = 0;
const SLOPE: usize = 1;
const BEND: usize = 2;

/// Levels with amplitudes and weights; amplitudes and drives are scaled by their largest values.
struct Problem<'a> {
    growth: Growth,
    levels: &'a [(LevelRow, [f64; 2])],
}

/// The amplitude at a level, and its derivatives with respect to the parameters.
fn amplitude(growth: Growth, p: &[f64], level: &LevelRow) -> Option<(f64, [f64; 3])> {
    let [y, rise] = growth.on_curve(level.amplitude([p[INTERCEPT], p[SLOPE]]), p[BEND])?;
    Some((y, [level.by[0] * rise, level.by[1] * rise, -growth.of(y) * rise]))
}

impl LeastSquares for Problem<'_> {
    fn parameters(&self) -> usize {
        3
    }

    fn observations(&self) -> f64 {
        self.levels.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        for (level, [y, weight]) in self.levels {
            let Some((at, row)) = amplitude(self.growth, p, level) else { return false };
            out.add_row(&row, y - at, *weight);
        }
        out.rss.is_finite()
    }
}

/// A quantity and its gradient with respect to intercept and slope.
pub(super) type LineFunction<'a> = &'a dyn Fn([f64; 2]) -> (f64, [f64; 2]);

impl CurvedFit {
    /// The curve through the moving levels, started from the straight line `[intercept, slope]`; `None` if there are
    /// fewer than `curve_levels` moving levels or no curve is found.
    pub(super) fn through(
        growth: Growth,
        sorted: &SortedLevels,
        motion: &[f64],
        moving: &[bool],
        [intercept, slope]: [f64; 2],
        c: &LevelCriteria,
    ) -> Option<Self> {
        let all = || (0..motion.len()).filter(|&i| moving[i]);
        let count = all().count();
        if count < c.curve_levels {
            return None;
        }
        let largest = |of: &[f64]| all().map(|i| of[i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let (widest, highest) = (largest(&sorted.drive), largest(motion));
        let scaled = |i: usize| {
            let LevelRow { offset, by: [by_intercept, by_slope], .. } = sorted.rows[i];
            let row =
                LevelRow { offset: offset / highest, by: [by_intercept, by_slope / widest], by_log_q: 0.0 };
            (row, [motion[i] / highest, sorted.weight(i)])
        };
        let levels: Vec<_> = all().map(scaled).collect();
        let start = [intercept / highest, slope * widest / highest, 0.0];
        let p = minimise(&Problem { growth, levels: &levels }, &start, &[INTERCEPT, SLOPE, BEND])?;
        let unit = [highest, highest / widest, highest.powi(-growth.of_coefficient())];
        let at: Vec<f64> = p.parameters.iter().zip(unit).map(|(p, unit)| p * unit).collect();
        let mut near = LinearLevels { columns: Vec::new(), response: Vec::new(), amplitude: motion, moving };
        for (level, y) in sorted.rows.iter().zip(motion) {
            // Levels that stick are not part of the fit.
            let (fitted, row) = amplitude(growth, &at, level).unwrap_or_default();
            near.response.push(y - fitted + row.iter().zip(&at).map(|(r, p)| r * p).sum::<f64>());
            near.columns.push(row.to_vec());
        }
        let fit = AveragedFit::of(&near, sorted.weights.as_deref(), c)?;
        let rss = p.rss * highest * highest;
        fit.covariance.iter().all(|v| v.is_finite()).then_some(Self {
            growth,
            fit,
            rss,
            highest,
            levels: count,
        })
    }

    /// `c`, in inverse units of the amplitude or of its square.
    pub(super) fn bend(&self) -> f64 {
        self.fit.parameters[BEND]
    }

    /// Whether the amplitude of small motions increases with the drive.
    pub(super) fn rises(&self) -> bool {
        self.fit.parameters[SLOPE] > 0.0
    }

    /// The largest bend that may go undetected in levels on a line.
    fn largest_bend(&self, c: &LevelCriteria) -> f64 {
        c.largest_bend * self.highest.powi(-self.growth.of_coefficient())
    }

    /// Variance of a quantity with this gradient at a known bend, and its derivative with respect to the bend.
    fn at_known_bend(&self, gradient: [f64; 2]) -> [f64; 2] {
        let v = &self.fit.covariance;
        let with = |k: usize| gradient[INTERCEPT] * v[(INTERCEPT, k)] + gradient[SLOPE] * v[(SLOPE, k)];
        let by_bend = with(BEND) / v[(BEND, BEND)];
        let whole = gradient[INTERCEPT] * with(INTERCEPT) + gradient[SLOPE] * with(SLOPE);
        [(whole - by_bend * with(BEND)).max(0.0), by_bend]
    }

    /// Estimates, by levels on a curve, of a quantity with this gradient with respect to intercept and slope, for which
    /// the straight line gives the value `straight`.
    ///
    /// The prior of the bend at the highest amplitude is uniform between zero and `largest_bend`, with additional weak
    /// bends of either sign.
    pub(super) fn estimates(
        &self,
        straight: f64,
        gradient: [f64; 2],
        c: &LevelCriteria,
        shared: &InferenceCriteria,
    ) -> Vec<WeightedEstimate> {
        let Some(coefficients) = self.coefficients(c, shared) else { return Vec::new() };
        let total = 1.0 + coefficients.iter().map(|b| b.odds).sum::<f64>();
        let [given, by_bend] = self.at_known_bend(gradient);
        let given = given * student_factor(self.fit.dof).powi(2);
        coefficients.map(|b| b.weighted_estimate(straight, by_bend, given, total)).to_vec()
    }

    /// `None` if too few levels move to weight the curves.
    fn coefficients(&self, c: &LevelCriteria, shared: &InferenceCriteria) -> Option<[AbsentCoefficient; 3]> {
        if self.levels < c.bend_levels {
            return None;
        }
        let std_error = student_factor(self.fit.dof) * self.fit.covariance[(BEND, BEND)].sqrt();
        if !(std_error > 0.0 && std_error.is_finite()) {
            return None;
        }
        let most = self.largest_bend(c);
        let (weak, odds) = (shared.weak_loss * most, 0.5 * shared.weak_loss_odds * c.bend_odds);
        let ranges = [[most, c.bend_odds], [weak, odds], [-weak, odds]];
        Some(ranges.map(|[most, odds]| AbsentCoefficient::within(self.bend(), std_error, most, odds)))
    }

    /// Intercept, slope and bend averaged over line and curve with their probabilities; `intercept` and `slope` are
    /// those of the straight line.
    pub(super) fn averaged_with_line(
        &self,
        [intercept, slope]: [f64; 2],
        c: &LevelCriteria,
        shared: &InferenceCriteria,
    ) -> [f64; 3] {
        let Some(coefficients) = self.coefficients(c, shared) else { return [intercept, slope, 0.0] };
        let total = 1.0 + coefficients.iter().map(|b| b.odds).sum::<f64>();
        let bend: f64 = coefficients
            .iter()
            .map(|b| b.weighted_estimate(0.0, 1.0, 0.0, total))
            .map(|w| w.weight * w.value)
            .sum();
        let [by_intercept, by_slope] = [[1.0, 0.0], [0.0, 1.0]].map(|g| self.at_known_bend(g)[1]);
        [intercept + by_intercept * bend, slope + by_slope * bend, bend]
    }

    /// The end of the interval of a quantity by the curve, on the side to which a bend shifts it, and whether that is
    /// the upper side; limited to the value at the largest bend.
    pub(super) fn limit(&self, of: LineFunction, c: &LevelCriteria) -> Option<(f64, bool)> {
        let AveragedFit { parameters: p, covariance: v, dof, .. } = &self.fit;
        let factor = student_factor(*dof);
        let end = |at: [f64; 2], known: bool| {
            let (value, gradient) = of(at);
            let [given, by_bend] = self.at_known_bend(gradient);
            let variance = given + if known { 0.0 } else { by_bend * by_bend * v[(BEND, BEND)] };
            let reach = Z_95 * factor * variance.sqrt();
            (value + reach.copysign(by_bend), by_bend > 0.0)
        };
        let (curve, upwards) = end([p[INTERCEPT], p[SLOPE]], false);
        let rest = self.largest_bend(c) - self.bend();
        let moved = |k: usize| p[k] + v[(k, BEND)] / v[(BEND, BEND)] * rest;
        let (most, _) = end([moved(INTERCEPT), moved(SLOPE)], true);
        let limit = if upwards { curve.min(most) } else { curve.max(most) };
        (self.rises() && limit.is_finite()).then_some((limit, upwards))
    }
}

/// Intercept and slope averaged over curves through the same levels with their probabilities, with their covariance.
pub(super) fn averaged(
    curves: &[CurvedFit],
    errors_known: bool,
    c: &LevelCriteria,
) -> (Vec<f64>, DMatrix<f64>) {
    let of = |curve: &CurvedFit| {
        let dof = (curve.levels as f64 - curve.fit.parameters.len() as f64).max(1.0);
        let rss = curve.rss;
        let minus_two_log = if errors_known { rss } else { dof * rss.max(f64::MIN_POSITIVE).ln() };
        [curve.growth.odds(c), minus_two_log]
    };
    let fit = |curve: usize| &curves[curve].fit;
    ModelWeights::new(curves.iter().map(of))
        .moments(|curve| &fit(curve).parameters[..BEND], |curve, at| fit(curve).covariance[at])
}

#[cfg(test)]
mod tests {
    use super::super::{Levels, Options, analyse};
    use crate::Parameter;
    use crate::answer::Warning;
    use crate::noise::jitter;

    const SLOPE: f64 = 100.0;
    const NOISE: f64 = 0.3;

    /// Levels whose loss by drag is `bend` times the viscous loss at an amplitude of 100, as read by a detector.
    fn levels(seed: u64, threshold: f64, bend: f64, read: impl Fn(f64) -> f64) -> Levels {
        let drive: Vec<f64> =
            (1..=20).map(|i| 0.05 * f64::from(i)).filter(|d| *d > 1.1 * threshold).collect();
        let at = |(i, d): (usize, &f64)| {
            let line = SLOPE * (d - threshold);
            let y = 2.0 * line / (1.0 + (1.0 + 4.0 * bend / 100.0 * line).sqrt());
            (read(y) + NOISE * jitter(i, seed)).abs()
        };
        let amplitude = drive.iter().enumerate().map(at).collect();
        Levels::builder(drive, amplitude).unit("mm").drive_unit("V").build().unwrap()
    }

    /// Number of intervals that cover threshold and slope, number of records with a warning of a bend, and number of
    /// thresholds that are off by more than four standard errors, of 300 records.
    fn held(bend: f64, read: impl Fn(f64) -> f64) -> [usize; 4] {
        let mut counts = [0; 4];
        for (seed, threshold) in (0..100).flat_map(|seed| [0.05, 0.1, 0.3].map(|threshold| (seed, threshold)))
        {
            let answer = analyse(&levels(seed, threshold, bend, &read), &Options::default()).unwrap();
            let of = |parameter| answer.parameter(parameter).unwrap();
            let inside = |parameter, truth: f64| {
                let [low, high] = of(parameter).interval_95;
                usize::from(low <= truth && truth <= high)
            };
            counts[0] += inside(Parameter::Threshold, threshold);
            counts[1] += inside(Parameter::Slope, SLOPE);
            counts[2] += usize::from(answer.warnings.iter().map(Warning::code).any(|c| c == "bent"));
            let found = of(Parameter::Threshold);
            let off = (found.unbounded_value - threshold).abs() > 4.0 * found.std_error;
            counts[3] += usize::from(off);
        }
        counts
    }

    /// With a straight line 2 of these thresholds and none of the slopes are covered, and 172 thresholds are off by
    /// more than four standard errors.
    #[test]
    fn drag_is_told_from_friction() {
        let [threshold, slope, named, off] = held(0.1, |y| y);
        assert!(threshold >= 270 && slope >= 270, "{threshold} {slope}");
        assert!(named >= 150 && off <= 3, "{named} {off}");
    }

    /// A detector that reads 3 % too low at the highest amplitude; with a straight line 131 thresholds are covered.
    #[test]
    fn a_detector_that_compresses_is_counted() {
        let [threshold, _, _, off] = held(0.0, |y| y * (1.0 - 0.03 * (y / 100.0).powi(2)));
        assert!(threshold >= 255 && off <= 12, "{threshold} {off}");
    }

    #[test]
    fn straight_levels_keep_their_intervals() {
        let [threshold, slope, named, off] = held(0.0, |y| y);
        assert!((270..=298).contains(&threshold) && slope >= 270, "{threshold} {slope}");
        assert!(named <= 2 && off == 0, "{named} {off}");
    }

    /// A stuck level just below the threshold, which reads as much as the noise, was classified as moving and
    /// straightened the line: 241 of these thresholds were covered.
    #[test]
    fn a_level_in_the_noise_hides_no_bend() {
        let [mut held, mut off] = [0; 2];
        for seed in 0..300 {
            let drive: Vec<f64> = (1..=30).map(|i| f64::from(i) / 30.0).collect();
            let at = |(i, d): (usize, &f64)| {
                let line = SLOPE * (d - 0.61).max(0.0);
                let y = 2.0 * line / (1.0 + (1.0 + 4.0 * 0.1 / 39.0 * line).sqrt());
                (y + 0.39 * jitter(i, 2 * seed)).hypot(0.39 * jitter(i, 2 * seed + 1))
            };
            let amplitude = drive.iter().enumerate().map(at).collect();
            let levels = Levels::builder(drive, amplitude).build().unwrap();
            let answer = analyse(&levels, &Options::default()).unwrap();
            let q = answer.parameter(Parameter::Threshold).unwrap();
            held += usize::from(q.interval_95[0] <= 0.61 && 0.61 <= q.interval_95[1]);
            off += usize::from((q.unbounded_value - 0.61).abs() > 4.0 * q.std_error);
        }
        assert!(held >= 255 && off <= 30, "{held} {off}");
    }

    /// The straight line included the level below the threshold, and no bend was found.
    #[test]
    fn a_strong_bend_leaves_stuck_levels_out() {
        for seed in 0..50 {
            let drive: Vec<f64> = (1..=12).map(|i| f64::from(i) / 12.0).collect();
            let at = |(i, d): (usize, &f64)| {
                let line = SLOPE * (d - 0.31).max(0.0);
                let y = 2.0 * line / (1.0 + (1.0 + 4.0 * 0.005 * line).sqrt());
                (y + 0.05 * jitter(i, 2 * seed)).hypot(0.05 * jitter(i, 2 * seed + 1))
            };
            let amplitude = drive.iter().enumerate().map(at).collect();
            let levels = Levels::builder(drive, amplitude).build().unwrap();
            let answer = analyse(&levels, &Options::default()).unwrap();
            assert_eq!(answer.diagnostics.moving, 9, "{seed}");
            let threshold = answer.parameter(Parameter::Threshold).unwrap();
            assert!((threshold.value - 0.31).abs() < 5.0 * threshold.std_error, "{seed}: {threshold:?}");
            assert!(threshold.std_error < 0.002, "{seed}: {threshold:?}");
        }
    }

    #[test]
    fn the_curve_that_is_reported_is_drawn() {
        let answer = analyse(&levels(1, 0.1, 0.4, |y| y), &Options::default()).unwrap();
        for p in answer.points.iter().filter(|p| p.moving) {
            assert!((p.fitted - p.amplitude).abs() < 4.0 * NOISE, "{p:?}");
        }
        assert!(answer.diagnostics.residual_rms < 1.5 * NOISE);
    }

    /// For 300 records of evenly spaced levels with a threshold of 0.31 and noise in both quadratures: number of
    /// intervals that cover slope and threshold, and number of values that are off by more than four standard errors.
    fn held_in_noise(count: usize, bend: f64, noise: f64) -> [usize; 3] {
        let mut counts = [0; 3];
        for seed in 0..300 {
            let drive: Vec<f64> = (1..=count).map(|i| i as f64 / count as f64).collect();
            let at = |(i, d): (usize, &f64)| {
                let line = SLOPE * (d - 0.31).max(0.0);
                let y = 2.0 * line / (1.0 + (1.0 + 4.0 * bend / 69.0 * line).sqrt());
                (y + 69.0 * noise * jitter(i, 2 * seed)).hypot(69.0 * noise * jitter(i, 2 * seed + 1))
            };
            let amplitude = drive.iter().enumerate().map(at).collect();
            let answer =
                analyse(&Levels::builder(drive, amplitude).build().unwrap(), &Options::default()).unwrap();
            for (k, (parameter, truth)) in
                [(Parameter::Slope, SLOPE), (Parameter::Threshold, 0.31)].into_iter().enumerate()
            {
                let q = answer.parameter(parameter).unwrap();
                counts[k] += usize::from(q.interval_95[0] <= truth && truth <= q.interval_95[1]);
                counts[2] += usize::from((q.value - truth).abs() > 4.0 * q.std_error);
            }
        }
        counts
    }

    /// At 40 dB the test of a bend does not detect a drag of 10 %. With the line alone, 243 slopes and 271 thresholds
    /// of 12 levels were covered, and 30 were off by more than four standard errors.
    #[test]
    fn a_drag_that_hides_in_the_noise_is_counted() {
        for count in [12, 30] {
            let [slope, threshold, off] = held_in_noise(count, 0.1, 0.01);
            assert!(slope >= 279 && threshold >= 279 && off <= 3, "{count}: {slope} {threshold} {off}");
        }
    }

    /// Four levels are too few to test for a bend. With the line alone and a drag of 10 %, 203 slopes and 262
    /// thresholds were covered, and 106 were off by more than four standard errors.
    #[test]
    fn four_levels_count_a_bend() {
        for (bend, noise) in [(0.1, 0.01), (0.5, 0.01), (0.5, 0.001)] {
            let [slope, threshold, off] = held_in_noise(6, bend, noise);
            assert!(
                slope >= 273 && threshold >= 273 && off <= 6,
                "{bend} {noise}: {slope} {threshold} {off}"
            );
        }
    }

    /// A curve of second power through such levels gave false detections of friction in 61 of 100 records.
    #[test]
    fn a_detector_that_compresses_is_no_friction() {
        let mut claimed = 0;
        for seed in 0..300 {
            let drive: Vec<f64> = (1..=30).map(|i| f64::from(i) / 30.0).collect();
            let at = |(i, d): (usize, &f64)| {
                let y = SLOPE * d;
                let y = (y + 0.1 * jitter(i, 2 * seed)).hypot(0.1 * jitter(i, 2 * seed + 1));
                y * (1.0 - 0.03 * (y / 100.0).powi(2))
            };
            let amplitude = drive.iter().enumerate().map(at).collect();
            let answer =
                analyse(&Levels::builder(drive, amplitude).build().unwrap(), &Options::default()).unwrap();
            assert!(answer.warnings.iter().any(|w| w.code() == "bent"), "{seed}");
            claimed += usize::from(answer.detected);
        }
        assert!(claimed <= 9, "{claimed}");
    }
}

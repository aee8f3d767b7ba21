//! Levels along a curve: loss in proportion to the square of the amplitude, or a detector that compresses.

use super::criteria::LevelCriteria;
use super::noise::{AveragedFit, LinearLevels};
use super::sorted::SortedLevels;
use crate::inference::coefficient::{AbsentCoefficient, Weighed};
use crate::inference::criteria::InferenceCriteria;
use crate::inference::evidence::{f_tail, student_factor};
use crate::inference::least_squares::{LeastSquares, Normal, linear, minimise};

/// p value of a quadratic term or of a kink in the moving branch, and whether its slope falls; 1 for fewer than `least`
/// levels. A kink, as of an amplifier that saturates, counts once for each level at which it may lie.
pub(super) fn bend(x: &[f64], y: &[f64], weight: &[f64], least: usize) -> (f64, bool) {
    let n = x.len();
    if n < least {
        return (1.0, false);
    }
    let centre = x.iter().sum::<f64>() / n as f64;
    let straight = (0..n).map(|i| (vec![1.0, x[i] - centre], y[i], weight[i]));
    let Some((.., straight)) = linear(straight, 2) else { return (1.0, false) };
    let with = |further: &dyn Fn(f64) -> f64, times: f64| {
        let rows = (0..n).map(|i| (vec![1.0, x[i] - centre, further(x[i])], y[i], weight[i]));
        let (c, _, rss) = linear(rows, 3)?;
        let dof = n as f64 - 3.0;
        let f = (straight - rss).max(0.0) / (rss / dof).max(f64::MIN_POSITIVE);
        Some(((times * f_tail(f, 1.0, dof)).min(1.0), c[2] < 0.0))
    };
    let kinks = x.get(2..n.saturating_sub(2)).unwrap_or_default();
    let kinked = kinks.iter().filter_map(|at| with(&|x| (x - at).max(0.0), kinks.len() as f64 + 1.0));
    let bent = with(&|x| (x - centre).powi(2), kinks.len() as f64 + 1.0);
    bent.into_iter().chain(kinked).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((1.0, false))
}

/// The moving levels on `y + c y² = a + b x`: viscous loss and drag balance what the drive has above the threshold.
///
/// Slope `b` and intercept `a` are those of small amplitudes, as of the line; `c` times an amplitude is the loss by drag
/// over the viscous one there. A detector that compresses bends the levels likewise, an expanding one or friction that
/// falls with speed the other way.
pub(super) struct Curved {
    /// `a`, `b` and `c` with their errors.
    pub(super) fit: AveragedFit,
    /// Sum of squares, weighted.
    pub(super) rss: f64,
    /// Highest amplitude of the motion.
    highest: f64,
}

/// Slots of the parameters.
const INTERCEPT: usize = 0;
const SLOPE: usize = 1;
const BEND: usize = 2;

/// Amplitudes and drives over their largest.
struct Problem<'a> {
    levels: &'a [[f64; 3]],
}

/// The amplitude where the straight line lies at `line`, and its derivative by that; `None` where the curve has turned.
fn on_curve(line: f64, bend: f64) -> Option<[f64; 2]> {
    let root = (1.0 + 4.0 * bend * line).sqrt();
    (root > 0.0).then(|| [2.0 * line / (1.0 + root), 1.0 / root])
}

/// The amplitude at a drive, and its derivatives by the parameters.
fn amplitude(p: &[f64], drive: f64) -> Option<(f64, [f64; 3])> {
    let [y, slope] = on_curve(p[INTERCEPT] + p[SLOPE] * drive, p[BEND])?;
    Some((y, [slope, drive * slope, -y * y * slope]))
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
        for &[x, y, weight] in self.levels {
            let Some((at, row)) = amplitude(p, x) else { return false };
            out.add_row(&row, y - at, weight);
        }
        out.rss.is_finite()
    }
}

impl Curved {
    /// The curve through the moving levels, from the straight line `[intercept, slope]`; `None` for fewer than
    /// `bend_levels`, and where there is none.
    pub(super) fn through(
        sorted: &SortedLevels,
        motion: &[f64],
        moving: &[bool],
        [intercept, slope]: [f64; 2],
        c: &LevelCriteria,
    ) -> Option<Self> {
        let all = || (0..motion.len()).filter(|&i| moving[i]);
        if all().count() < c.bend_levels {
            return None;
        }
        let largest = |of: &[f64]| all().map(|i| of[i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let (widest, highest) = (largest(&sorted.drive), largest(motion));
        let levels: Vec<[f64; 3]> =
            all().map(|i| [sorted.drive[i] / widest, motion[i] / highest, sorted.weight(i)]).collect();
        let start = [intercept / highest, slope * widest / highest, 0.0];
        let p = minimise(&Problem { levels: &levels }, &start, &[INTERCEPT, SLOPE, BEND])?;
        let unit = [highest, highest / widest, 1.0 / highest];
        let at: Vec<f64> = p.parameters.iter().zip(unit).map(|(p, unit)| p * unit).collect();
        let mut near = LinearLevels { columns: Vec::new(), response: Vec::new(), amplitude: motion, moving };
        for (x, y) in sorted.drive.iter().zip(motion) {
            // Levels that stick have no part in the fit.
            let (fitted, row) = amplitude(&at, *x).unwrap_or_default();
            near.response.push(y - fitted + row.iter().zip(&at).map(|(r, p)| r * p).sum::<f64>());
            near.columns.push(row.to_vec());
        }
        let fit = AveragedFit::of(&near, sorted.weights.as_deref(), c)?;
        let rss = p.rss * highest * highest;
        fit.covariance.iter().all(|v| v.is_finite()).then_some(Self { fit, rss, highest })
    }

    /// `c`, one over the unit of the amplitudes.
    pub(super) fn bend(&self) -> f64 {
        self.fit.parameters[BEND]
    }

    /// Whether the amplitude of small motion rises with the drive.
    pub(super) fn rises(&self) -> bool {
        self.fit.parameters[SLOPE] > 0.0
    }

    /// What levels on a curve say of a quantity beside the straight line, by which it is `straight`, with this gradient
    /// by intercept and slope.
    ///
    /// Before the data the bend at the highest amplitude is anything between none and `largest_bend`, a weak one either way.
    pub(super) fn beside(
        &self,
        straight: f64,
        [by_intercept, by_slope]: [f64; 2],
        c: &LevelCriteria,
        shared: &InferenceCriteria,
    ) -> Vec<Weighed> {
        let AveragedFit { covariance, dof, .. } = &self.fit;
        let variance = covariance[(BEND, BEND)];
        let std_error = variance.sqrt();
        if !(std_error > 0.0 && std_error.is_finite()) {
            return Vec::new();
        }
        let most = c.largest_bend / self.highest;
        let (weak, odds) = (shared.weak_loss * most, 0.5 * shared.weak_loss_odds);
        let ranges = [[most, c.bend_odds], [weak, odds], [-weak, odds]];
        let of = |[most, odds]: [f64; 2]| AbsentCoefficient::within(self.bend(), std_error, most, odds);
        let coefficients = ranges.map(of);
        let total = 1.0 + coefficients.iter().map(|b| b.odds).sum::<f64>();
        let covariance_with =
            |k: usize| by_intercept * covariance[(INTERCEPT, k)] + by_slope * covariance[(SLOPE, k)];
        let slope = covariance_with(BEND) / variance;
        let whole = by_intercept * covariance_with(INTERCEPT) + by_slope * covariance_with(SLOPE);
        let given = (whole - slope * slope * variance).max(0.0);
        let by = |b: AbsentCoefficient| {
            let found = b.weighed(straight, slope, given, total);
            Weighed { std_error: found.std_error * student_factor(*dof), ..found }
        };
        coefficients.map(by).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Levels, Options, analyse};
    use crate::Parameter;
    use crate::answer::Warning;
    use crate::noise::jitter;

    const SLOPE: f64 = 100.0;
    const NOISE: f64 = 0.3;

    /// Levels whose loss by drag is `bend` times the viscous one at an amplitude of 100, as a detector reads them.
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

    /// How often threshold and slope are held, how often a bend is named, and how many thresholds are off by more than four
    /// errors, of 300 records.
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

    /// By a straight line 2 of these thresholds and none of the slopes are held, and 172 thresholds are off by more than
    /// four errors.
    #[test]
    fn drag_is_told_from_friction() {
        let [threshold, slope, named, off] = held(0.1, |y| y);
        assert!(threshold >= 270 && slope >= 270, "{threshold} {slope}");
        assert!(named >= 150 && off <= 3, "{named} {off}");
    }

    /// A detector that reads 3 % too little at the highest amplitude; by a straight line 131 thresholds are held.
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

    /// A stuck level just below the threshold, which reads what noise does, passed for a moving one and straightened the
    /// line: 241 of these thresholds were held.
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

    /// Their straight line took the level below the threshold in, and no bend was left.
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
}

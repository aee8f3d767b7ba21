//! Reading of the detector where the mass sticks: its zero or its noise, which the moving levels contain as well.

use super::criteria::LevelCriteria;
use super::line::{Line, same_level};
use super::noise::AveragedFit;
use crate::inference::evidence::student_factor;
use crate::inference::model_average::ModelWeights;
use crate::numeric::order::sort_by_value;
use nalgebra::DVector;

/// Mean amplitude of pure noise over the standard deviation of a quadrature (Rice distribution).
const MEAN_AT_REST: f64 = 1.253_314_137_315_5;
/// Variance of the same over the variance of a quadrature.
const VARIANCE_AT_REST: f64 = 0.429_203_673_205_1;

/// How the reading without motion adds to the amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OffsetKind {
    /// Zero offset: a constant in every reading.
    Constant,
    /// Noise within a bandwidth: in quadrature.
    Quadrature,
}

impl OffsetKind {
    /// An amplitude with the reading at rest subtracted.
    fn subtracted(self, reading: f64, at_rest: f64) -> f64 {
        match self {
            Self::Constant => reading - at_rest,
            Self::Quadrature => (reading * reading - at_rest * at_rest).max(0.0).sqrt(),
        }
    }
}

/// Reading of the stuck levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plateau {
    /// Mean reading.
    pub(super) reading: f64,
    /// Number of levels.
    pub(super) levels: usize,
    /// The part that is not noise of the quadratures, as a constant, and its standard error.
    constant: [f64; 2],
    /// The same in quadrature.
    in_squares: [f64; 2],
}

impl Plateau {
    /// The plateau of the levels that stick, if it exceeds the reading of noise alone.
    pub(super) fn of(x: &[f64], y: &[f64], weight: &[f64], line: &Line, c: &LevelCriteria) -> Option<Self> {
        let stuck: Vec<usize> = (0..x.len()).filter(|&i| line.sticks[i]).collect();
        let n = stuck.len() as f64;
        // Several readings of one level count once, because all of them may be about to move.
        let repeated = stuck.windows(2).filter(|pair| same_level(x[pair[0]], x[pair[1]], c)).count();
        let levels = stuck.len() - repeated;
        if levels < c.plateau_levels {
            return None;
        }
        let sum = |of: &dyn Fn(usize) -> f64| stuck.iter().map(|&i| weight[i] * of(i)).sum::<f64>();
        let total = sum(&|_| 1.0);
        let reading = sum(&|i| y[i]) / total;
        let scatter = sum(&|i| (y[i] - reading).powi(2));
        // A creeping mass follows the drive.
        let along = sum(&|i| x[i] * y[i]) / sum(&|i| x[i] * x[i]).max(f64::MIN_POSITIVE);
        if sum(&|i| (y[i] - along * x[i]).powi(2)) < scatter {
            return None;
        }
        let dof = (line.moving_levels() as f64 - 2.0).max(0.0) + n - 1.0;
        let variance = (line.rss + scatter / VARIANCE_AT_REST) / dof * n / total;
        let sigma = variance.sqrt();
        let std_error = sigma * (VARIANCE_AT_REST / n + MEAN_AT_REST * MEAN_AT_REST / (2.0 * dof)).sqrt();
        let constant = reading - MEAN_AT_REST * sigma;
        if !(constant > c.plateau_errors * student_factor(dof) * std_error) {
            return None;
        }
        let square = sum(&|i| y[i] * y[i]) / total - 2.0 * variance;
        let in_squares = [square.max(0.0).sqrt(), std_error];
        Some(Self { reading, levels, constant: [constant, std_error], in_squares })
    }

    /// The line through the moving levels with the plateau subtracted, averaged over both ways of adding by their
    /// likelihood; and the better way, with its line and levels. `fit` returns the line with its covariance.
    pub(super) fn subtracted_from(
        &self,
        y: &[f64],
        straight: impl Fn(&[f64]) -> Option<Line>,
        fit: impl Fn(&[f64]) -> Option<AveragedFit>,
        minus_two_log: impl Fn(&Line) -> f64,
    ) -> Option<Corrected> {
        let by = |kind: OffsetKind| {
            let [at_rest, std_error] =
                if kind == OffsetKind::Constant { self.constant } else { self.in_squares };
            let without =
                |at_rest: f64| -> Vec<f64> { y.iter().map(|y| kind.subtracted(*y, at_rest)).collect() };
            let levels = without(at_rest);
            let line = straight(&levels)?;
            let moved = straight(&without(at_rest + std_error))?;
            let mut found = fit(&levels)?;
            let steps = DVector::from_vec(vec![moved.intercept - line.intercept, moved.slope - line.slope]);
            found.covariance += &steps * steps.transpose();
            Some((minus_two_log(&line), Corrected { kind, at_rest, levels, line, found }))
        };
        let mut both: Vec<(f64, Corrected)> =
            [OffsetKind::Constant, OffsetKind::Quadrature].into_iter().filter_map(by).collect();
        sort_by_value(&mut both, |each| each.0);
        if both.is_empty() {
            return None;
        }
        let weights = ModelWeights::new(both.iter().map(|each| [1.0, each.0]));
        let found = |m: usize| &both[m].1.found;
        let (parameters, covariance) =
            weights.moments(|m| &found(m).parameters, |m, at| found(m).covariance[at]);
        let mut best = both.swap_remove(0).1;
        (best.found.parameters, best.found.covariance) = (parameters, covariance);
        Some(best)
    }
}

/// The levels with the reading of the detector at rest subtracted.
pub(super) struct Corrected {
    pub(super) kind: OffsetKind,
    pub(super) at_rest: f64,
    pub(super) levels: Vec<f64>,
    pub(super) line: Line,
    pub(super) found: AveragedFit,
}

#[cfg(test)]
mod tests {
    use super::super::{Levels, Options, analyse};
    use crate::Parameter;
    use crate::answer::Warning;
    use crate::noise::jitter;

    const SLOPE: f64 = 100.0;
    const NOISE: f64 = 0.5;

    /// Levels measured by a lock-in amplifier with noise in both quadratures, as read by a detector.
    fn levels(seed: usize, threshold: f64, read: impl Fn(f64) -> f64) -> Levels {
        let drive: Vec<f64> = (1..=20).map(|i| 0.1 * f64::from(i)).collect();
        let at = |(i, d): (usize, &f64)| {
            let seed = 2 * seed as u64;
            read(
                (SLOPE * (d - threshold).max(0.0) + NOISE * jitter(i, seed))
                    .hypot(NOISE * jitter(i, seed + 1)),
            )
        };
        let amplitude = drive.iter().enumerate().map(at).collect();
        Levels::builder(drive, amplitude).unit("mm").drive_unit("mm").build().unwrap()
    }

    /// Of 100 records, the number of intervals that cover the threshold, and the number with a given warning.
    fn held(threshold: f64, code: &str, read: impl Fn(f64) -> f64) -> [usize; 2] {
        let mut counts = [0; 2];
        for seed in 0..100 {
            let answer = analyse(&levels(seed, threshold, &read), &Options::default()).unwrap();
            let [low, high] = answer.parameter(Parameter::Threshold).unwrap().interval_95;
            counts[0] += usize::from((low..=high).contains(&threshold));
            counts[1] += usize::from(answer.warnings.iter().map(Warning::code).any(|c| c == code));
        }
        counts
    }

    #[test]
    fn what_a_detector_reads_at_rest_is_taken_off() {
        // Without the subtraction no interval covers the threshold.
        let [constant, warned] = held(0.65, "level_plateau", |a| a + 5.0);
        assert!(constant >= 88 && warned == 100, "{constant} {warned}");
        let [squares, warned] = held(0.65, "level_plateau", |a| a.hypot(15.0));
        assert!(squares >= 88 && warned == 100, "{squares} {warned}");
        let [plain, warned] = held(0.65, "level_plateau", |a| a);
        assert!(plain >= 88 && warned <= 1, "{plain} {warned}");
    }

    #[test]
    fn the_fit_is_drawn_as_the_detector_reads() {
        let answer = analyse(&levels(3, 0.65, |a| a + 5.0), &Options::default()).unwrap();
        for p in answer.points.iter().filter(|p| !p.moving || p.drive > 0.8) {
            assert!((p.fitted - p.amplitude).abs() < 2.5, "{p:?}");
        }
        for seed in 0..40 {
            let answer = analyse(&levels(seed, 0.65, |a| a + 5.0), &Options::default()).unwrap();
            let moving: Vec<f64> =
                answer.points.iter().filter(|p| p.moving).map(|p| p.amplitude - p.fitted).collect();
            let mean = moving.iter().sum::<f64>() / moving.len() as f64;
            let error = NOISE / (moving.len() as f64).sqrt();
            assert!(mean.abs() < error, "{seed}: {mean} of {error}");
        }
    }

    #[test]
    fn a_line_above_zero_without_a_drive_is_named() {
        assert_eq!(held(0.0, "above_zero", |a| a + 5.0)[1], 100);
        assert!(held(0.0, "above_zero", |a| a)[1] <= 1);
    }

    #[test]
    fn levels_that_creep_with_the_drive_are_no_plateau() {
        let creeping = levels(1, 0.65, |a| a);
        let amplitude = creeping.drive().iter().zip(creeping.amplitude());
        let amplitude = amplitude.map(|(d, a)| if *d < 0.65 { 10.0 * d } else { *a }).collect();
        let levels = Levels::builder(creeping.drive().to_vec(), amplitude).build().unwrap();
        let answer = analyse(&levels, &Options::default()).unwrap();
        assert!(!answer.warnings.iter().any(|w| w.code() == "level_plateau"), "{:?}", answer.warnings);
    }
}

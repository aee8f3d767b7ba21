//! Fit of the moving levels with noise that may grow with the amplitude.

use super::criteria::LevelCriteria;
use super::level_row::LevelRow;
use crate::inference::evidence::chi_square_tail;
use crate::inference::least_squares::linear;
use crate::inference::model_average::ModelWeights;
use nalgebra::DMatrix;

/// The moving levels as a linear problem.
pub(super) struct LinearLevels<'a> {
    /// Derivatives of the amplitude of each level with respect to the parameters.
    pub(super) columns: Vec<Vec<f64>>,
    /// Quantity described by the columns: amplitudes, or amplitudes of a curve linearised about a point.
    pub(super) response: Vec<f64>,
    pub(super) amplitude: &'a [f64],
    pub(super) moving: &'a [bool],
}

impl<'a> LinearLevels<'a> {
    /// Intercept and slope of the line.
    pub(super) fn of_line(rows: &[LevelRow], amplitude: &'a [f64], moving: &'a [bool]) -> Self {
        let columns = rows.iter().map(|row| row.by.to_vec()).collect();
        let response = amplitude.iter().zip(rows).map(|(y, row)| y - row.offset).collect();
        Self { columns, response, amplitude, moving }
    }

    fn parameters(&self) -> usize {
        self.columns[0].len()
    }

    fn of_moving(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.moving.len()).filter(|&i| self.moving[i])
    }

    /// Coefficients, their covariance at unit variance, and the sum of squares, for the given weights of the levels.
    fn fit(&self, weight: impl Fn(usize) -> f64) -> Option<(Vec<f64>, DMatrix<f64>, f64)> {
        let rows = self.of_moving().map(|i| (self.columns[i].clone(), self.response[i], weight(i)));
        linear(rows, self.parameters())
    }
}

/// Parameters with their covariance, averaged over the noise models that the levels allow.
pub(super) struct AveragedFit {
    pub(super) parameters: Vec<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// Variance of each level.
    pub(super) variance: Vec<f64>,
    /// Degrees of freedom of the variance; infinite if the given errors are accepted.
    pub(super) dof: f64,
}

/// Ratios tried per decade.
const PER_DECADE: f64 = 10.0;

impl AveragedFit {
    /// Uses the given inverse variances, or variances estimated from the levels.
    pub(super) fn of(levels: &LinearLevels, weight: Option<&[f64]>, c: &LevelCriteria) -> Option<Self> {
        match weight {
            Some(weight) => Self::with_errors(levels, weight, c),
            None => Self::averaged(levels, c),
        }
    }

    /// The given errors are accepted unless the levels scatter more; in that case all errors are scaled by one factor.
    fn with_errors(levels: &LinearLevels, weight: &[f64], c: &LevelCriteria) -> Option<Self> {
        let (parameters, unit, rss) = levels.fit(|i| weight[i])?;
        let dof = (levels.of_moving().count() as f64 - levels.parameters() as f64).max(1.0);
        let believed = chi_square_tail(rss, dof) > c.errors_too_small;
        let scale = if believed { 1.0 } else { rss / dof };
        Some(Self {
            parameters,
            covariance: unit * scale,
            variance: weight.iter().map(|w| scale / w).collect(),
            dof: if believed { f64::INFINITY } else { dof },
        })
    }

    /// The fit with constant noise and with variances `1 + ratio A²` for many ratios, averaged by their restricted
    /// likelihood (Patterson and Thompson 1971, Biometrika 58, 545). The prior is uniform in the logarithm of the
    /// ratio; the prior odds of any such noise against constant noise are `proportional_odds`, which increase in
    /// proportion to the span of the amplitudes above `narrow_span`.
    ///
    /// Levels that span decades have noise proportional to the amplitude (ranges, gain, drive), which few levels do not
    /// distinguish from constant noise. Therefore the standard errors account for both.
    fn averaged(levels: &LinearLevels, c: &LevelCriteria) -> Option<Self> {
        let (n, free) = (levels.of_moving().count() as f64, levels.parameters() as f64);
        let dof = (n - free).max(1.0);
        let square = |i: usize| if levels.moving[i] { levels.amplitude[i].powi(2) } else { 0.0 };
        let under = |ratio: f64| {
            let variance = |i: usize| 1.0 + ratio * square(i);
            let (parameters, unit, rss) = levels.fit(|i| 1.0 / variance(i))?;
            let logarithms: f64 = levels.of_moving().map(|i| variance(i).ln()).sum();
            let deviance = (n - free) * rss.ln() + logarithms - unit.determinant().ln();
            Some(Fitted { ratio, parameters, unit, variance: rss / dof, deviance })
        };
        let sizes = || levels.of_moving().map(|i| levels.amplitude[i].abs()).filter(|a| *a > 0.0);
        let span = sizes().fold(0.0, f64::max) / sizes().fold(f64::INFINITY, f64::min);
        let odds = c.proportional_odds * (span / c.narrow_span).max(1.0);
        let highest = levels.of_moving().map(square).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let [first, last] = [c.least_proportional, c.most_proportional]
            .map(|ratio| (ratio.log10() * PER_DECADE).round() as i32);
        let ratios = (first..=last).map(|k| 10f64.powf(f64::from(k) / PER_DECADE) / highest);
        let constant = under(0.0)?;
        let mut fits = vec![constant];
        if n >= free + c.noise_residuals as f64 && fits[0].deviance.is_finite() {
            fits.extend(ratios.filter_map(under).filter(|f| f.deviance.is_finite()));
        } else {
            // As the only fit it has the full weight, whatever its likelihood.
            fits[0].deviance = 0.0;
        }
        let share = odds / (fits.len() - 1).max(1) as f64;
        let prior = |f: &Fitted| if f.ratio > 0.0 { share } else { 1.0 };
        let weights = ModelWeights::new(fits.iter().map(|f| [prior(f), f.deviance]));
        let (parameters, covariance) =
            weights.moments(|f| &fits[f].parameters, |f, at| fits[f].unit[at] * fits[f].variance);
        let variance = |i| weights.mean(|f| fits[f].variance * (1.0 + fits[f].ratio * square(i)));
        let variance = (0..levels.moving.len()).map(variance).collect();
        Some(Self { parameters, covariance, variance, dof })
    }
}

/// The fit for one ratio.
struct Fitted {
    ratio: f64,
    parameters: Vec<f64>,
    /// Covariance over the variance of the floor.
    unit: DMatrix<f64>,
    /// Variance of the floor.
    variance: f64,
    /// Minus twice the logarithm of the restricted likelihood, up to a constant.
    deviance: f64,
}

#[cfg(test)]
mod tests {
    use super::super::{Levels, Options, analyse};
    use crate::Parameter;
    use crate::noise::jitter;

    /// Number of intervals that cover slope and threshold for levels of slope 100 with a noise floor and noise
    /// proportional to the amplitude.
    fn held(drive: &[f64], threshold: f64, floor: f64, part: f64) -> [usize; 2] {
        let mut held = [0; 2];
        for seed in 0..200 {
            let at = |(i, d): (usize, &f64)| {
                let exact = 100.0 * (d - threshold).max(0.0) * (1.0 + part * jitter(i, 3 * seed));
                (exact + floor * jitter(i, 3 * seed + 1)).hypot(floor * jitter(i, 3 * seed + 2))
            };
            let amplitude = drive.iter().enumerate().map(at).collect();
            let levels =
                Levels::builder(drive.to_vec(), amplitude).unit("mm").drive_unit("mm").build().unwrap();
            let Ok(answer) = analyse(&levels, &Options::default()) else { continue };
            for (held, (parameter, truth)) in
                held.iter_mut().zip([(Parameter::Slope, 100.0), (Parameter::Threshold, threshold)])
            {
                let [low, high] = answer.parameter(parameter).unwrap().interval_95;
                *held += usize::from((low..=high).contains(&truth));
            }
        }
        held
    }

    #[test]
    fn noise_in_proportion_over_decades_is_counted() {
        let decades = |n: i32| -> Vec<f64> {
            (0..n).map(|i| 0.1 * 300f64.powf(f64::from(i) / f64::from(n - 1))).collect()
        };
        // Few levels hardly distinguish a floor from a proportional part: 90 % of the slopes are covered, with many
        // levels 94 %.
        for (drive, least) in [(decades(5), 168), (decades(8), 172), (decades(15), 178)] {
            for threshold in [0.0, 0.5] {
                let [slope, at] = held(&drive, threshold, 0.3, 0.02);
                // With constant noise alone 75 to 106 slopes are covered.
                assert!(slope >= least && at >= 182, "{} levels, {threshold}: {slope} {at}", drive.len());
            }
        }
    }

    #[test]
    fn constant_noise_keeps_its_intervals() {
        let drive: Vec<f64> = (0..12).map(|i| 0.3 + 4.7 * f64::from(i) / 11.0).collect();
        for threshold in [0.0, 0.5] {
            let [slope, at] = held(&drive, threshold, 0.5, 0.0);
            assert!(slope >= 175 && at >= 178, "{threshold}: {slope} {at}");
        }
    }
}

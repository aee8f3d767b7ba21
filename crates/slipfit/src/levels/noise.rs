//! The line through the moving levels under noise that may grow with the amplitude.

use super::criteria::LevelCriteria;
use super::line::Line;
use crate::inference::least_squares::linear;

/// A line with its errors, averaged over the noise that the levels allow.
pub(super) struct AveragedLine {
    pub(super) intercept: f64,
    pub(super) slope: f64,
    /// Of intercept and slope.
    pub(super) covariance: [[f64; 2]; 2],
    /// Of each level.
    pub(super) variance: Vec<f64>,
}

impl AveragedLine {
    /// Of levels with errors, all of them `scale` times the variance given.
    pub(super) fn with_errors(line: &Line, weight: &[f64], scale: f64) -> Self {
        let covariance = [0, 1].map(|i| [0, 1].map(|j| scale * line.covariance[(i, j)]));
        let variance = weight.iter().map(|w| scale / w).collect();
        Self { intercept: line.intercept, slope: line.slope, covariance, variance }
    }
}

/// Ratios tried in each decade.
const PER_DECADE: f64 = 10.0;

/// The line under constant noise, and under variances `1 + ratio A²` for many ratios, averaged by their restricted
/// likelihood (Patterson and Thompson 1971, Biometrika 58, 545). Before the data the logarithm of the ratio is uniform; the odds
/// of any such noise against a constant one are `proportional_odds`, which grow in proportion to the span of the amplitudes
/// above `narrow_span`.
///
/// Levels over decades have a noise in proportion to the amplitude (ranges, gain, drive), and few of them do not tell it
/// from a constant one: the errors count both.
pub(super) fn averaged(x: &[f64], y: &[f64], line: &Line, c: &LevelCriteria) -> AveragedLine {
    let moving: Vec<usize> = (0..x.len()).filter(|&i| line.moving[i]).collect();
    let n = moving.len() as f64;
    let dof = (n - 2.0).max(1.0);
    let square = |i: usize| if line.moving[i] { y[i] * y[i] } else { 0.0 };
    let under = |ratio: f64| {
        let variance = |i: usize| 1.0 + ratio * square(i);
        let rows = moving.iter().map(|&i| (vec![1.0, x[i]], y[i], 1.0 / variance(i)));
        let (at, unit, rss) = linear(rows, 2)?;
        let logarithms: f64 = moving.iter().map(|&i| variance(i).ln()).sum();
        let deviance = (n - 2.0) * rss.ln() + logarithms - unit.view((0, 0), (2, 2)).determinant().ln();
        Some(Fitted {
            ratio,
            at: [at[0], at[1]],
            unit: [[unit[(0, 0)], unit[(0, 1)]], [unit[(1, 0)], unit[(1, 1)]]],
            variance: rss / dof,
            deviance,
        })
    };
    let sizes = || moving.iter().map(|&i| y[i].abs()).filter(|a| *a > 0.0);
    let span = sizes().fold(0.0, f64::max) / sizes().fold(f64::INFINITY, f64::min);
    let odds = c.proportional_odds * (span / c.narrow_span).max(1.0);
    let highest = moving.iter().map(|&i| square(i)).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let [first, last] =
        [c.least_proportional, c.most_proportional].map(|ratio| (ratio.log10() * PER_DECADE).round() as i32);
    let ratios = (first..=last).map(|k| 10f64.powf(f64::from(k) / PER_DECADE) / highest);
    let proportional: Vec<Fitted> = ratios.filter_map(under).filter(|f| f.deviance.is_finite()).collect();
    let share = odds / proportional.len().max(1) as f64;
    let constant = Fitted {
        ratio: 0.0,
        at: [line.intercept, line.slope],
        unit: [0, 1].map(|i| [0, 1].map(|j| line.covariance[(i, j)])),
        variance: line.rss / dof,
        deviance: under(0.0).map_or(f64::NEG_INFINITY, |f| f.deviance),
    };
    let told = moving.len() >= c.noise_levels && constant.deviance.is_finite();
    let mut fits = vec![(1.0, constant)];
    if told {
        fits.extend(proportional.into_iter().map(|f| (share, f)));
    }
    let least = fits.iter().map(|(_, f)| f.deviance).fold(f64::INFINITY, f64::min);
    for (weight, f) in &mut fits {
        *weight *= if told { (-0.5 * (f.deviance - least)).exp() } else { 1.0 };
    }
    let total: f64 = fits.iter().map(|(w, _)| w).sum();
    let mean = |of: &dyn Fn(&Fitted) -> f64| fits.iter().map(|(w, f)| w / total * of(f)).sum::<f64>();
    let at = [0, 1].map(|i| mean(&|f| f.at[i]));
    let covariance = [0, 1].map(|i| {
        [0, 1].map(|j| mean(&|f| f.unit[i][j] * f.variance + (f.at[i] - at[i]) * (f.at[j] - at[j])))
    });
    let variance = (0..x.len()).map(|i| mean(&|f| f.variance * (1.0 + f.ratio * square(i)))).collect();
    AveragedLine { intercept: at[0], slope: at[1], covariance, variance }
}

/// The line under one ratio.
struct Fitted {
    ratio: f64,
    at: [f64; 2],
    /// Covariance over the variance of the floor.
    unit: [[f64; 2]; 2],
    /// Of the floor.
    variance: f64,
    /// Minus twice the logarithm of the restricted likelihood, but for a constant.
    deviance: f64,
}

#[cfg(test)]
mod tests {
    use super::super::{Levels, Options, analyse};
    use crate::Parameter;
    use crate::noise::jitter;

    /// How often slope and threshold are held by levels of slope 100 with a floor and a part of every amplitude.
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
        // Few levels tell a floor from a part hardly: 90 % of the slopes, of many 94 %.
        for (drive, least) in [(decades(5), 168), (decades(8), 172), (decades(15), 178)] {
            for threshold in [0.0, 0.5] {
                let [slope, at] = held(&drive, threshold, 0.3, 0.02);
                // With constant noise alone 75 to 106 slopes.
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

//! Measured errors of the points and measured drive: comparison with the residuals.

use super::Options;
use super::block::Block;
use super::criteria::{ColumnCriteria, Criteria};
use super::fitted_models::{ColumnsSetAside, FittedModels, SetAside};
use super::noise::bic_at_own_precision;
use super::prepared::PreparedCurve;
use super::selection;
use crate::Error;
use nalgebra::{DMatrix, DVector};

/// The best fit with the columns as they are, or with a smoothed drive, or with errors estimated from the residuals, if
/// that describes the response better by a margin or if there is no fit otherwise.
///
/// Noise of a measured drive does not affect the motion, and a model that follows it is biased towards losses for which
/// the drive matters least. Errors from few repeats scatter themselves (from three repeats by 64 %), and weights
/// derived from them give most weight to a few points.
pub(super) fn best_fit(
    curve: &PreparedCurve,
    options: &Options,
    criteria: &Criteria,
    errors_known: bool,
) -> Result<FittedModels, Error> {
    let c = &criteria.columns;
    let mut found = selection::best_fit(curve, options, criteria, errors_known);
    let mut set_aside = ColumnsSetAside::default();
    let mut curve = curve.clone();
    let mut known = errors_known;
    if let Some((other, scatter)) = with_smooth_drive(&curve, c)
        && let Some(better) = fit_if_better(&found, &other, options, criteria, known)
    {
        set_aside.drive = Some(SetAside { scatter, no_fit: found.is_err() });
        (found, curve) = (Ok(better), other);
    }
    if known && let Some(scatter) = error_scatter(&curve.main).filter(|s| *s > c.error_scatter) {
        let other = with_equal_errors(&curve);
        known = false;
        if let Some(better) = fit_if_better(&found, &other, options, criteria, known) {
            set_aside.errors = Some(SetAside { scatter, no_fit: found.is_err() });
            found = Ok(better);
        }
    }
    found.map(|f| FittedModels { set_aside, ..f })
}

/// The fit of the other curve, if it is better than the one found or if there is none.
fn fit_if_better(
    found: &Result<FittedModels, Error>,
    other: &PreparedCurve,
    options: &Options,
    criteria: &Criteria,
    errors_known: bool,
) -> Option<FittedModels> {
    let fit = || selection::best_fit(other, options, criteria, errors_known);
    let candidate = other.main.work.within(criteria.search.share, fit).ok()?;
    let Ok(found) = found else { return Some(candidate) };
    let used = |f: &FittedModels, i: usize| f.problem.main.weight[i] > 0.0;
    let both: Vec<usize> = (0..other.main.len()).filter(|&i| used(found, i) && used(&candidate, i)).collect();
    let gain = bic_at_own_precision(found, &both)? - bic_at_own_precision(&candidate, &both)?;
    (gain > criteria.columns.margin).then_some(candidate)
}

/// The curve with a smoothed drive, and the scatter of the drive about it.
fn with_smooth_drive(curve: &PreparedCurve, c: &ColumnCriteria) -> Option<(PreparedCurve, f64)> {
    let (smooth, scatter) = fitted_drive(&curve.main, c)?;
    let mut other = curve.clone();
    other.main.drive = smooth;
    for block in [&mut other.reference, &mut other.all].into_iter().flatten() {
        if let Some((smooth, _)) = fitted_drive(block, c) {
            block.drive = smooth;
        }
    }
    Some((other, scatter))
}

/// The polynomial of lowest BIC through the relative drive, and the scatter about it; `None` if the drive does not
/// scatter.
fn fitted_drive(b: &Block, c: &ColumnCriteria) -> Option<(Vec<f64>, f64)> {
    let n = b.len();
    let (first, last) = (*b.omega.first()?, *b.omega.last()?);
    let place = |i: usize| (2.0 * b.omega[i] - first - last) / (last - first).max(f64::MIN_POSITIVE);
    let drive = DVector::from_column_slice(&b.drive);
    let of_degree = |degree: usize| {
        let powers = DMatrix::from_fn(n, degree + 1, |i, k| place(i).powi(k as i32));
        let square = powers.tr_mul(&powers).cholesky()?;
        let fitted = &powers * square.solve(&powers.tr_mul(&drive));
        let rss = (&drive - &fitted).norm_squared();
        let spare = n as f64 - degree as f64 - 1.0;
        let bic = n as f64 * rss.max(f64::MIN_POSITIVE).ln() + (degree as f64 + 1.0) * (n as f64).ln();
        (spare >= 1.0).then(|| (bic, fitted, (rss / spare).sqrt()))
    };
    let degrees = (0..=c.course_degree).filter_map(of_degree);
    let (_, fitted, scatter) = degrees.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let above_zero = fitted.iter().all(|d| *d > 0.0);
    (above_zero && scatter > c.drive_scatter).then(|| (fitted.iter().copied().collect(), scatter))
}

/// Standard deviation of the logarithm of the errors from point to point, from second differences, whose median is
/// hardly affected by a smooth variation.
fn error_scatter(b: &Block) -> Option<f64> {
    let error: Vec<f64> = b.precision.iter().map(|p| -0.5 * p.ln()).collect();
    let mut second: Vec<f64> = error.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    if second.is_empty() {
        return None;
    }
    let middle = second.len() / 2;
    // Half of the absolute values of a normal variable are below 0.6745 standard deviations.
    Some(*second.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.6745 * 6f64.sqrt()))
}

/// The curve with equal errors for all points.
fn with_equal_errors(curve: &PreparedCurve) -> PreparedCurve {
    let mut other = curve.clone();
    let blocks = [Some(&mut other.main), other.reference.as_mut(), other.all.as_mut()];
    for block in blocks.into_iter().flatten() {
        block.precision.fill(1.0);
        block.weight.fill(1.0);
    }
    other
}

#[cfg(test)]
mod tests {
    use super::super::{Curve, CurveBuilder, DriveAmplitude, Options, analyse};
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::{Oscillator, Parameter};

    const POINTS: usize = 101;
    const X_F: f64 = 0.5 * std::f64::consts::FRAC_PI_4;

    fn hz() -> Vec<f64> {
        (0..POINTS).map(|i| 1.0 + 0.03 * (2.0 * i as f64 / (POINTS - 1) as f64 - 1.0)).collect()
    }

    /// The response for Q = 100 at one frequency and drive.
    fn response(hz: f64, drive: f64, x_f: f64) -> Phasor {
        let o = Oscillator::builder().frequency_hz(1.0).q_factor(100.0).friction_displacement(x_f).build();
        scan::reading(&o.unwrap(), drive, hz).unwrap().fundamental
    }

    fn noisy(z: &[Phasor], part: f64, seed: u64) -> Vec<f64> {
        let sigma = part * z.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let at = |(i, z): (usize, &Phasor)| z + Phasor::new(jitter(i, seed), jitter(i, seed + 1)) * sigma;
        z.iter().enumerate().map(at).map(|z| z.norm()).collect()
    }

    /// Number of intervals that cover the friction displacement, and number of warnings with this code.
    fn held(x_f: f64, code: &str, curve: impl Fn(u64) -> CurveBuilder) -> (usize, usize) {
        let known = DriveAmplitude { value: 1.0, std_error: 0.0 };
        let options = Options { drive_amplitude: Some(known), ..Options::default() };
        let (mut held, mut warned) = (0, 0);
        for seed in 0..20 {
            let answer = analyse(&curve(10 * seed).build().unwrap(), &options).unwrap();
            let [low, high] = answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().interval_95;
            held += usize::from((low..=high).contains(&x_f));
            warned += usize::from(answer.warnings.iter().any(|w| w.code() == code));
        }
        (held, warned)
    }

    #[test]
    fn noise_of_the_drive_column_is_told_from_a_drive_that_varies() {
        let steady: Vec<Phasor> = hz().iter().map(|hz| response(*hz, 1.0, X_F)).collect();
        let read = |seed: u64, of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..POINTS).map(|i| of(i) * (1.0 + 0.02 * jitter(i, seed + 7))).collect()
        };
        let (kept, warned) = held(X_F, "drive_readback", |seed| {
            Curve::builder(hz(), noisy(&steady, 0.003, seed)).drive(read(seed, &|_| 1.0))
        });
        // With the drive as read 9 of 20 intervals cover it; the others give half of the friction.
        assert!(kept >= 17 && warned == 20, "{kept} {warned}");
        let (kept, warned) = held(X_F, "drive_readback", |seed| {
            let mut drive = read(seed, &|_| 1.0);
            // The known amplitude refers to the mean drive.
            let mean = drive.iter().sum::<f64>() / POINTS as f64;
            drive.iter_mut().for_each(|d| *d /= mean);
            let z: Vec<Phasor> = hz().iter().zip(&drive).map(|(hz, d)| response(*hz, *d, X_F)).collect();
            Curve::builder(hz(), noisy(&z, 0.003, seed)).drive(drive)
        });
        assert!(kept >= 17 && warned == 0, "{kept} {warned}");
    }

    #[test]
    fn errors_of_three_repeats_do_not_weigh_the_points() {
        for x_f in [0.0, X_F] {
            let z: Vec<Phasor> = hz().iter().map(|hz| response(*hz, 1.0, x_f)).collect();
            let (kept, warned) = held(x_f, "scattered_errors", |seed| {
                let repeats: Vec<Vec<f64>> = (0..3).map(|k| noisy(&z, 0.02, seed + 2 * k)).collect();
                let mean = |i: usize| repeats.iter().map(|r| r[i]).sum::<f64>() / 3.0;
                let square = |i: usize| repeats.iter().map(|r| (r[i] - mean(i)).powi(2)).sum::<f64>() / 2.0;
                Curve::builder(hz(), (0..POINTS).map(mean).collect())
                    .std_error((0..POINTS).map(|i| square(i).sqrt()).collect())
            });
            assert!(kept >= 17 && warned == 20, "{x_f}: {kept} {warned}");
            let (kept, warned) = held(x_f, "scattered_errors", |seed| {
                let error = |i: usize| 0.5 * (0.7 * jitter(i, seed + 9)).exp();
                let at = |(i, z): (usize, &Phasor)| {
                    (z + Phasor::new(jitter(i, seed), jitter(i, seed + 1)) * error(i)).norm()
                };
                Curve::builder(hz(), z.iter().enumerate().map(at).collect())
                    .std_error((0..POINTS).map(error).collect())
            });
            assert!(kept >= 17 && warned == 0, "{x_f}, right errors: {kept} {warned}");
        }
    }
}

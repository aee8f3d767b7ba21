//! Noise that grows with the amplitude: a floor and a part of every amplitude.

use super::alternatives::{Alternative, OtherFit, TermSet};
use super::criteria::NoiseCriteria;
use super::fitted_models::FittedModels;
use super::prepared::PreparedCurve;
use super::problem::Problem;
use super::term_sets::within_limits;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::noise_law::{Scale, Scatter, likelihood};

/// Variance of a quadrature `floor² (1 + ratio a²)` where the amplitude is `a`.
///
/// Instruments with ranges, drives whose level wanders and mechanics that jitter have a noise in
/// proportion to the signal; taken as constant it hides what the flanks tell, and makes the errors of
/// everything else too small (Carroll and Ruppert 1988, Transformation and Weighting in Regression).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoiseLaw {
    /// Square of the proportional part over that of the floor, per squared amplitude.
    ratio: f64,
}

impl NoiseLaw {
    /// The law by which the residuals of a fit have the greatest likelihood, where it explains them
    /// better than a constant noise does. `None` where they are no noise.
    pub(super) fn of(fitted: &FittedModels, c: &NoiseCriteria) -> Option<Self> {
        let (law, gain, observations) = Self::most_likely(fitted, c)?;
        (gain - observations.ln() > c.proportional_margin).then_some(law)
    }

    /// The law by which they have the greatest likelihood, by how much minus twice its logarithm is lower than that of a
    /// constant noise, and the number of residuals.
    fn most_likely(fitted: &FittedModels, c: &NoiseCriteria) -> Option<(Self, f64, f64)> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
        if fitted.comparison.noise.variance_inflation > 1.0 {
            return None;
        }
        let problem = fitted.problem_of(chosen);
        let of_block = |reference| scatter(&problem, &chosen.unbounded, reference);
        // The reference comes from the same instrument: its floor may be another, the ratio is the same.
        let blocks: Vec<Vec<Scatter>> = [false, true].into_iter().filter_map(of_block).collect();
        let all = || blocks.iter().flatten();
        let observations: f64 = all().map(|s| s.count).sum();
        if observations < chosen.unbounded.free.len() as f64 + c.spare_observations {
            return None;
        }
        let most = all().map(|s| s.square).fold(0.0, f64::max);
        let minus_two_log = |ratio: f64| -> f64 {
            blocks.iter().map(|b| likelihood(b, ratio, Scale::Estimated).minus_two_log).sum()
        };
        // The ratio at the highest amplitude: from a tenth of the floor to a thousand times the floor.
        const STEPS: i32 = 80;
        let at = |step: i32| 10f64.powf(f64::from(step) * 0.1 - 2.0) / most.max(f64::MIN_POSITIVE);
        let likely = (0..=STEPS).map(|step| (at(step), minus_two_log(at(step)))).filter(|l| l.1.is_finite());
        let (ratio, best) = likely.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((Self { ratio }, minus_two_log(0.0) - best, observations))
    }

    /// The fit reported, its points weighed by the most likely law, as another fit beside it: few points do not tell
    /// the noise of high amplitudes from that of low ones, and errors by a constant noise may be too small.
    pub(super) fn alternative(fitted: &FittedModels, c: &NoiseCriteria) -> Option<Alternative> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
        let (law, gain, _) = Self::most_likely(fitted, c)?;
        let mut problem = fitted.problem_of(chosen);
        let blocks = std::iter::once(&mut problem.main).chain(&mut problem.reference);
        let mut typical = None;
        for block in blocks {
            let precision: Vec<f64> = block.amplitudes().into_iter().map(|a| law.precision(a)).collect();
            let typical = *typical.get_or_insert_with(|| geometric_mean(&precision));
            for (k, law) in precision.into_iter().enumerate() {
                block.precision[k] *= law / typical;
                block.weight[k] *= law / typical;
            }
        }
        let free = &chosen.unbounded.free;
        let unbounded = minimise(&problem, &chosen.unbounded.parameters, free)?;
        let bounded = within_limits(&problem, &unbounded)?;
        let odds = (0.5 * (gain - c.unsettled_penalty)).exp();
        let fit = OtherFit { set: TermSet::of(&problem, free), unbounded, bounded };
        // It has no other terms: that BIC is of no interest.
        let weight = 1.0 - 1.0 / (1.0 + odds);
        weight.is_finite().then_some(Alternative {
            fit,
            weight,
            frequency_weight: weight,
            delta_bic: f64::INFINITY,
        })
    }

    /// One over the variance at an amplitude, over that at the floor.
    fn precision(self, amplitude: f64) -> f64 {
        1.0 / (1.0 + self.ratio * amplitude * amplitude)
    }

    /// The curve with its points weighed by this law; `fitted` is the fit so far.
    pub(super) fn weighed(self, curve: &PreparedCurve, fitted: &FittedModels) -> Option<PreparedCurve> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
        let modelled = fitted.problem.predict(&chosen.unbounded.parameters, false);
        let main: Vec<f64> = modelled
            .iter()
            .enumerate()
            .map(|(i, m)| self.precision(m.map_or(curve.main.amplitude(i), |m| m.value.norm())))
            .collect();
        // A typical point keeps its precision: noise is reported as that of such a point.
        let typical = geometric_mean(&main);
        let scaled = |precision: &mut f64, law: f64| *precision *= law / typical;
        let mut weighed = curve.clone();
        weighed.main.precision.iter_mut().zip(&main).for_each(|(p, law)| scaled(p, *law));
        weighed.main.weight.clone_from(&weighed.main.precision);
        for block in [&mut weighed.reference, &mut weighed.all].into_iter().flatten() {
            let amplitudes = block.amplitudes();
            block.precision.iter_mut().zip(amplitudes).for_each(|(p, a)| scaled(p, self.precision(a)));
            block.weight.clone_from(&block.precision);
        }
        Some(weighed)
    }

    /// Noise over the amplitude where the floor is nothing, by the fit that this law weighs.
    pub(super) fn part(self, fitted: &FittedModels) -> f64 {
        let Some(chosen) = fitted.comparison.reported().or_else(|| fitted.comparison.preferred()) else {
            return 0.0;
        };
        let b = &fitted.problem.main;
        let sigma = fitted.comparison.noise.residual_variance(&chosen.bounded).sqrt();
        let parts = (0..b.len()).map(|i| self.precision(b.amplitude(i)) * self.ratio / b.precision[i]);
        sigma * (parts.sum::<f64>() / b.len() as f64).sqrt()
    }

    /// Whether two laws are the same to within a factor.
    pub(super) fn is_near(self, other: Self, factor: f64) -> bool {
        (self.ratio / other.ratio).ln().abs() < factor.ln()
    }
}

/// The BIC of the fit reported at some points, each weighed by its own precision, but for a constant: fits of one curve
/// with points weighed in several ways are compared by it.
pub(super) fn bic_at_own_precision(fitted: &FittedModels, points: &[usize]) -> Option<f64> {
    let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
    let problem = fitted.problem_of(chosen);
    let b = &problem.main;
    let residuals = problem.residuals(&chosen.unbounded.parameters);
    let count = if b.complex { 2.0 } else { 1.0 };
    let of = |&i: &usize| {
        let residual = residuals[i]?.norm_sqr();
        Some(Scatter { square: 0.0, floor: 1.0 / b.precision[i], residual, count })
    };
    let scatter: Vec<Scatter> = points.iter().map(of).collect::<Option<_>>()?;
    let parameters =
        chosen.unbounded.free.len() as f64 + f64::from(u8::from(fitted.proportional_noise.is_some()));
    let penalty = parameters * (count * scatter.len() as f64).ln();
    Some(likelihood(&scatter, 0.0, Scale::Estimated).minus_two_log + penalty)
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Residuals of a block at precision one, each freed of the part that the fit took (its leverage).
fn scatter(problem: &Problem, fit: &Fit, reference: bool) -> Option<Vec<Scatter>> {
    const STEP: f64 = 1e-3;
    const MOST_LEVERAGE: f64 = 0.9;
    let b = problem.block(reference)?;
    let factor = if reference { problem.reference_weight } else { 1.0 };
    let here = problem.predict(&fit.parameters, reference);
    let mut leverage = vec![0.0; b.len()];
    let noise = (fit.rss / problem.observations()).sqrt();
    for step in fit.principal_steps() {
        let mut p = fit.parameters.clone();
        p.iter_mut().zip(&step).for_each(|(p, s)| *p += STEP * noise * s);
        for (i, (near, m)) in problem.predict(&p, reference).into_iter().zip(&here).enumerate() {
            if let (Some(near), Some(m)) = (near, m) {
                let slope = (b.reading(i, &near) - b.reading(i, m)) / (STEP * noise);
                leverage[i] += factor * b.weight[i] * slope.norm_sqr();
            }
        }
    }
    let count = if b.complex { 2.0 } else { 1.0 };
    let used = (0..b.len()).filter(|&i| b.weight[i] > 0.0);
    let found: Option<Vec<Scatter>> = used
        .map(|i| {
            let m = here[i]?;
            let left = 1.0 - (leverage[i] / count).min(MOST_LEVERAGE);
            let residual = b.residual(i, &m).norm_sqr() / left;
            Some(Scatter { square: m.value.norm_sqr(), floor: 1.0, residual, count })
        })
        .collect();
    found.filter(|list| !list.is_empty())
}

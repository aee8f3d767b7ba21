//! Noise that grows with the amplitude: a floor and a part proportional to the amplitude.

use super::alternatives::{Alternative, Kind, OtherFit, TermSet};
use super::criteria::NoiseCriteria;
use super::fitted_models::FittedModels;
use super::prepared::PreparedCurve;
use super::problem::Problem;
use super::response::Modelled;
use super::term_sets::within_limits;
use crate::inference::least_squares::{Fit, LeastSquares, Normal, log_determinant, minimise};
use crate::inference::noise_law::{Scale, Scatter, likelihood};
use crate::inference::normal::{invert, solve};
use crate::motion::steady::Phasor;

/// Variance of a quadrature `floor² (1 + ratio a²)` at the amplitude `a`.
///
/// Instruments with ranges, drives with fluctuating level and mechanical jitter have noise proportional to the signal.
/// If it is treated as constant, the information of the flanks is lost and the standard errors of everything else are
/// too small (Carroll and Ruppert 1988, Transformation and Weighting in Regression).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoiseLaw {
    /// Ratio of the proportional variance to that of the floor, per squared amplitude.
    ratio: f64,
}

impl NoiseLaw {
    /// The most likely law according to the residuals of a fit, if constant noise is excluded against all growing laws.
    /// `None` if the residuals are not noise. `weighted_by` is the law by which the points are already weighted.
    pub(super) fn of(fitted: &FittedModels, weighted_by: Option<Self>, c: &NoiseCriteria) -> Option<Self> {
        let laws = Residuals::of(fitted, weighted_by, c)?.laws(c);
        let best = laws.iter().max_by(|a, b| a.odds.total_cmp(&b.odds))?;
        let evidence = 2.0 * laws.iter().map(|law| law.odds).sum::<f64>().ln();
        (evidence > c.proportional_margin).then_some(Self { ratio: best.ratio })
    }

    /// The reported fit with its points weighted by each law that the residuals do not exclude, as additional fits: few
    /// points do not distinguish the noise at high amplitudes from that at low ones, and standard errors for constant
    /// noise, or for the most likely law, may be too small.
    pub(super) fn alternatives(fitted: &FittedModels, c: &NoiseCriteria) -> Vec<Alternative> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred());
        let Some((chosen, residuals)) = chosen.zip(Residuals::of(fitted, None, c)) else { return Vec::new() };
        let laws = residuals.laws(c);
        let total = 1.0 + laws.iter().map(|law| law.odds).sum::<f64>();
        let other = |law: &Law| {
            let weight = law.odds / total;
            // Written so that NaN counts as improbable as well.
            if !(weight > c.least_weight) {
                return None;
            }
            let mut problem = fitted.problem_of(chosen);
            problem.reference_weight *= law.reference;
            let by = Self { ratio: law.ratio };
            let mut typical = None;
            for block in std::iter::once(&mut problem.main).chain(&mut problem.reference) {
                let precision: Vec<f64> = block.amplitudes().into_iter().map(|a| by.precision(a)).collect();
                let typical = *typical.get_or_insert_with(|| geometric_mean(&precision));
                for (k, law) in precision.into_iter().enumerate() {
                    block.precision[k] *= law / typical;
                    block.weight[k] *= law / typical;
                }
            }
            let free = &chosen.unbounded.free;
            let unbounded = minimise(&problem, &chosen.unbounded.parameters, free)?;
            let bounded = within_limits(&problem, &unbounded)?;
            let fit = OtherFit { set: TermSet::of(&problem, free), unbounded, bounded };
            // It has no other terms, so its BIC is irrelevant.
            Some(Alternative {
                fit,
                kind: Kind::Noise,
                weight,
                frequency_weight: weight,
                delta_bic: f64::INFINITY,
            })
        };
        laws.iter().filter_map(other).collect()
    }

    /// Inverse variance at an amplitude, relative to that of the floor.
    fn precision(self, amplitude: f64) -> f64 {
        1.0 / (1.0 + self.ratio * amplitude * amplitude)
    }

    /// The curve with its points weighted by this law; `fitted` is the fit so far.
    pub(super) fn weighted(self, curve: &PreparedCurve, fitted: &FittedModels) -> Option<PreparedCurve> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
        let modelled = fitted.problem.predict(&chosen.unbounded.parameters, false);
        let main: Vec<f64> = modelled
            .iter()
            .enumerate()
            .map(|(i, m)| self.precision(m.map_or(curve.main.amplitude(i), |m| m.value.norm())))
            .collect();
        // A typical point keeps its precision, because the noise is reported for such a point.
        let typical = geometric_mean(&main);
        let scaled = |precision: &mut f64, law: f64| *precision *= law / typical;
        let mut weighted = curve.clone();
        weighted.main.precision.iter_mut().zip(&main).for_each(|(p, law)| scaled(p, *law));
        weighted.main.weight.clone_from(&weighted.main.precision);
        for block in [&mut weighted.reference, &mut weighted.all].into_iter().flatten() {
            let amplitudes = block.amplitudes();
            block.precision.iter_mut().zip(amplitudes).for_each(|(p, a)| scaled(p, self.precision(a)));
            block.weight.clone_from(&block.precision);
        }
        Some(weighted)
    }

    /// Ratio of the noise to the amplitude where the floor is negligible, from the fit weighted by this law.
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

/// The BIC of the reported fit at some points, each weighted by its own precision, up to a constant; it compares fits
/// of one curve with different weights of the points.
pub(super) fn bic_at_own_precision(fitted: &FittedModels, points: &[usize]) -> Option<f64> {
    let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
    let problem = fitted.problem_of(chosen);
    let b = &problem.main;
    let residuals = problem.residuals(&chosen.unbounded.parameters);
    let count = if b.complex { 2.0 } else { 1.0 };
    let of = |&i: &usize| {
        let residual = residuals[i]?.norm_sqr();
        Some(Scatter { square: 0.0, floor: 1.0 / b.precision[i], sum_of_squares: residual, count })
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

/// Number of variance ratios tried per decade.
const STEPS_PER_DECADE: f64 = 4.0;

/// Minus twice the logarithm of the restricted likelihood, up to a constant, with the other most likely values for a
/// given ratio.
struct RestrictedLikelihood {
    minus_two_log: f64,
    /// Noise of the floor of the curve.
    noise: f64,
    /// Ratio of its variance to the value assumed relative to that of the reference.
    reference: f64,
}

/// A ratio of the two parts.
struct Law {
    ratio: f64,
    /// Posterior odds against constant noise.
    odds: f64,
    reference: f64,
}

/// Weighted residuals of a fit with their derivatives along its principal steps, for the curve and for its reference.
/// Both come from the same instrument: their floors may differ, but the ratio is the same.
struct Residuals {
    blocks: Vec<Vec<Observation>>,
    parameters: usize,
}

struct Observation {
    /// Square of the modelled amplitude.
    square: f64,
    residual: f64,
    slopes: Vec<f64>,
}

impl Residuals {
    fn of(fitted: &FittedModels, weighted_by: Option<NoiseLaw>, c: &NoiseCriteria) -> Option<Self> {
        let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
        if fitted.comparison.noise.variance_inflation > 1.0 {
            return None;
        }
        let problem = fitted.problem_of(chosen);
        let of_block = |reference| observations(&problem, &chosen.unbounded, reference, weighted_by);
        let blocks: Vec<Vec<Observation>> = [false, true].into_iter().filter_map(of_block).collect();
        let found = Self { blocks, parameters: chosen.unbounded.free.len() };
        (found.observations() >= found.parameters as f64 + c.spare_observations).then_some(found)
    }

    fn observations(&self) -> f64 {
        self.blocks.iter().map(Vec::len).sum::<usize>() as f64
    }

    /// The laws whose proportional part at the highest amplitude is between a third of the floor and three hundred
    /// times the floor.
    fn laws(&self, c: &NoiseCriteria) -> Vec<Law> {
        const STEPS: i32 = 24;
        let most = self.blocks.iter().flatten().map(|o| o.square).fold(f64::MIN_POSITIVE, f64::max);
        let Some(constant) = self.likelihood_at(0.0) else { return Vec::new() };
        let law = |step: i32| {
            let ratio = 10f64.powf(f64::from(step) / STEPS_PER_DECADE - 1.0) / most;
            let likely = self.likelihood_at(ratio)?;
            // The prior is uniform in the logarithm of the ratio, up to a noise that no instrument has.
            let part = ratio.sqrt() * likely.noise / c.most_proportional;
            let before = c.proportional_odds / STEPS_PER_DECADE / (1.0 + part.powi(4));
            let odds = before * (0.5 * (constant.minus_two_log - likely.minus_two_log)).exp();
            Some(Law { ratio, odds, reference: likely.reference })
        };
        (0..=STEPS).filter_map(law).collect()
    }

    /// Restricted likelihood of the residuals, independent of the parameters (Patterson and Thompson 1971, Biometrika
    /// 58, 545): points that determine the parameters have hardly any residual and therefore do not determine the
    /// noise.
    fn likelihood_at(&self, ratio: f64) -> Option<RestrictedLikelihood> {
        const ROUNDS: usize = 4;
        let n = self.parameters;
        let all: Vec<usize> = (0..n).collect();
        let law = |o: &Observation| 1.0 / (1.0 + ratio * o.square);
        let sums_of = |block: &Vec<Observation>| {
            let mut sums = Normal::zeros(n);
            block.iter().for_each(|o| sums.add_row(&o.slopes, o.residual, law(o)));
            sums
        };
        let sums: Vec<Normal> = self.blocks.iter().map(sums_of).collect();
        let mut variances: Vec<f64> =
            self.blocks.iter().zip(&sums).map(|(b, s)| s.rss / b.len() as f64).collect();
        let mut minus_two_log = f64::NAN;
        for _ in 0..ROUNDS {
            let mut whole = Normal::zeros(n);
            for (s, v) in sums.iter().zip(&variances) {
                let add = |(sum, x): (&mut f64, &f64)| *sum += x / v;
                whole.jtj.as_mut_slice().iter_mut().zip(s.jtj.as_slice()).for_each(add);
                whole.jtr.as_mut_slice().iter_mut().zip(s.jtr.as_slice()).for_each(add);
            }
            let (moved, _) = solve(&whole, &all, 0.0)?;
            let covariance = invert(&whole, &all, n)?;
            minus_two_log = log_determinant(&whole, &all)?;
            for ((block, s), v) in self.blocks.iter().zip(&sums).zip(&mut variances) {
                let (mut left, mut used_freedom) = (s.rss, 0.0);
                for i in 0..n {
                    left -= 2.0 * moved[i] * s.jtr[i];
                    for j in 0..n {
                        let product = s.jtj[(i.max(j), i.min(j))];
                        left += moved[i] * moved[j] * product;
                        used_freedom += covariance[(i, j)] * product / *v;
                    }
                }
                let count = block.len() as f64;
                minus_two_log += left / *v + count * v.ln();
                *v = left / (count - used_freedom).max(1.0);
            }
        }
        minus_two_log -= self.blocks.iter().flatten().map(|o| law(o).ln()).sum::<f64>();
        let reference = variances.last().map_or(1.0, |v| variances[0] / v);
        let found = RestrictedLikelihood { minus_two_log, noise: variances[0].sqrt(), reference };
        found.minus_two_log.is_finite().then_some(found)
    }
}

/// The observations of a block, with both quadratures if it is complex.
fn observations(
    problem: &Problem,
    fit: &Fit,
    reference: bool,
    weighted_by: Option<NoiseLaw>,
) -> Option<Vec<Observation>> {
    const STEP: f64 = 1e-3;
    let b = problem.block(reference)?;
    let factor = if reference { problem.reference_weight } else { 1.0 };
    let here = problem.predict(&fit.parameters, reference);
    let noise = STEP * (fit.rss / problem.observations()).sqrt();
    let near: Vec<Vec<Option<Modelled>>> = fit
        .principal_steps()
        .iter()
        .map(|step| {
            let p: Vec<f64> = fit.parameters.iter().zip(step).map(|(p, s)| p + noise * s).collect();
            problem.predict(&p, reference)
        })
        .collect();
    let mut found = Vec::new();
    for i in (0..b.len()).filter(|&i| b.weight[i] > 0.0) {
        let m = here[i].as_ref()?;
        let law = weighted_by.map_or(1.0, |law| law.precision(m.value.norm()));
        let root = (factor * b.weight[i] / law).sqrt();
        let residual = b.residual(i, m) * root;
        let slope = |near: &Option<Modelled>| {
            near.as_ref()
                .map_or(Phasor::default(), |near| (b.reading(i, near) - b.reading(i, m)) * (root / noise))
        };
        let slopes: Vec<Phasor> = near.iter().map(|near| slope(&near[i])).collect();
        let square = m.value.norm_sqr();
        let part = |of: fn(&Phasor) -> f64| Observation {
            square,
            residual: of(&residual),
            slopes: slopes.iter().map(of).collect(),
        };
        found.push(part(|z| z.re));
        if b.complex {
            found.push(part(|z| z.im));
        }
    }
    (!found.is_empty()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::super::{Curve, Options, analyse};
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::{Oscillator, Parameter};

    /// Amplitudes whose noise is 0.4 % of each and 0.02 % of the highest. According to the scatter of the flanks the
    /// peak would be known to a twentieth of its noise, and its few points determine the parameters.
    #[test]
    fn few_points_do_not_tell_that_the_noise_is_constant() {
        const CURVES: usize = 60;
        let oscillator = |x_f: f64| {
            Oscillator::builder()
                .frequency_hz(1.0)
                .q_factor(100.0)
                .friction_displacement(x_f)
                .build()
                .unwrap()
        };
        let hz: Vec<f64> = (0..13).map(|i| 0.96 + 0.08 * f64::from(i) / 12.0).collect();
        let read = |x_f: f64, seed: u64| {
            let clean: Vec<Phasor> =
                hz.iter().map(|f| scan::reading(&oscillator(x_f), 1.0, *f).unwrap().fundamental).collect();
            let highest = clean.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let noisy = |(i, z): (usize, &Phasor)| {
                let noise = Phasor::new(jitter(i, 2 * seed), jitter(i, 2 * seed + 1));
                (z + noise * (4e-3 * z.norm()).hypot(2e-4 * highest)).norm()
            };
            Curve::builder(hz.clone(), clean.iter().enumerate().map(noisy).collect()).build().unwrap()
        };
        let [x_f, delta] = [0.39, std::f64::consts::PI / 100.0];
        let mut missed = [0; 2];
        for curve in 0..CURVES as u64 {
            let options = Options { reference: Some(read(0.0, 2 * curve + 1)), ..Options::default() };
            let answer = analyse(&read(x_f, 2 * curve), &options).unwrap();
            let truths = [(Parameter::DECAY_RATE, delta), (Parameter::NaturalFrequency, 1.0)];
            for (missed, (parameter, truth)) in missed.iter_mut().zip(truths) {
                let [low, high] = answer.parameter(parameter).unwrap().interval_95;
                *missed += usize::from(!(low..=high).contains(&truth));
            }
        }
        // Three of sixty are expected at a coverage of 95 %.
        assert!(missed[0] + missed[1] <= 10, "{missed:?} of {CURVES}");
    }
}

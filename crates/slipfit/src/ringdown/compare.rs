//! All loss models on one set of data: which terms are needed, and the
//! intervals of those that are there.

use super::LossModel;
use super::envelope::{A0, DELTA, DRAG, X_F};
use super::ranked::{self, Entry};
use crate::inference::evidence::{bic, one_sided, student_factor};
use crate::inference::interval::bounded_interval;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};

/// The data's scale: how the sum of squares turns into evidence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// Observations behind the sum of squares.
    pub(crate) observations: f64,
    /// Variance of one weighted observation; `None`: from the residuals.
    pub(crate) variance: Option<f64>,
    /// Factor on variances for residuals that hang together.
    pub(crate) widening: f64,
}

impl Scale {
    pub(crate) fn variance_of(&self, fit: &Fit) -> f64 {
        let dof = (self.observations - fit.free.len() as f64).max(1.0);
        self.variance.unwrap_or(fit.rss / dof)
    }

    fn dof(&self, fit: &Fit) -> f64 {
        if self.variance.is_some() {
            f64::INFINITY
        } else {
            ((self.observations - fit.free.len() as f64) * self.share_of_dof()).max(1.0)
        }
    }

    pub(crate) fn bic(&self, rss: f64, parameters: usize) -> f64 {
        match self.variance {
            // With the noise known the likelihood needs no estimate of it.
            Some(v) => {
                rss / (v * self.widening).max(f64::MIN_POSITIVE) + parameters as f64 * self.effective().ln()
            }
            None => bic(rss, self.observations, self.effective(), parameters),
        }
    }

    /// Degrees of freedom left to the variance of AR(1) residuals: their squares
    /// correlate as rho², so `(1 - rho²)/(1 + rho²)` of them, with `widening = (1 + rho)/(1 - rho)`.
    fn share_of_dof(&self) -> f64 {
        2.0 * self.widening / (1.0 + self.widening * self.widening)
    }

    /// Independent observations: what is left of them after the widening.
    fn effective(&self) -> f64 {
        (self.observations / self.widening).max(2.0)
    }
}

/// Every model that could be fitted.
#[derive(Debug, Clone)]
pub(crate) struct Comparison {
    pub(crate) entries: Vec<Entry>,
}

fn terms(model: LossModel) -> Vec<usize> {
    [(model.has_sliding(), X_F), (model.has_viscous(), DELTA), (model.has_drag(), DRAG)]
        .into_iter()
        .filter_map(|(has, index)| has.then_some(index))
        .collect()
}

/// Free parameters of a model: amplitude, its loss terms, the nuisances.
pub(crate) fn free_of(model: LossModel, nuisance: &[usize]) -> Vec<usize> {
    let mut free = vec![A0];
    free.extend(terms(model));
    free.extend(nuisance);
    free.sort_unstable();
    free
}

/// Fits every model, each from its nearest relative's solution.
///
/// `start` holds the amplitude, a decay rate and the nuisances.
pub(crate) fn compare(
    problem: &dyn LeastSquares,
    start: &[f64],
    nuisance: &[usize],
    scale: Scale,
    sliding_start: f64,
) -> Comparison {
    let mut fits: Vec<(LossModel, Fit)> = Vec::new();
    let mut base = start.to_vec();
    (base[X_F], base[DRAG]) = (0.0, 0.0);
    let mut sliding = base.clone();
    (sliding[DELTA], sliding[X_F]) = (0.0, sliding_start);
    for model in LossModel::ALL {
        let free = free_of(model, nuisance);
        if (scale.observations as usize) <= free.len() {
            continue;
        }
        // Relatives with one term less, best first; or the bare start.
        let mut starts: Vec<&Fit> = fits
            .iter()
            .filter(|(m, _)| terms(*m).iter().all(|t| terms(model).contains(t)))
            .map(|(_, f)| f)
            .collect();
        starts.sort_by(|a, b| a.rss.total_cmp(&b.rss));
        let bare = if model.has_viscous() { &base } else { &sliding };
        let from = starts.first().map_or(bare.as_slice(), |f| f.parameters.as_slice());
        let fit = minimise(problem, from, &free).or_else(|| minimise(problem, bare, &free));
        if let Some(fit) = fit {
            fits.push((model, fit));
        }
    }
    let entries = ranked::ranked(&fits, terms, |rss, parameters| scale.bic(rss, parameters));
    Comparison { entries }
}

impl Comparison {
    pub(crate) fn get(&self, model: LossModel) -> Option<&Entry> {
        ranked::of(&self.entries, model)
    }

    /// The model of least BIC among those with every term inside its limit, handicaps
    /// counted.
    pub(crate) fn best(&self) -> Option<&Entry> {
        ranked::best(&self.entries)
    }

    /// The entry whose terms are those of `model` and one more.
    pub(crate) fn with_term(&self, model: LossModel, term: usize) -> Option<&Entry> {
        LossModel::from_terms(
            model.has_viscous() || term == DELTA,
            model.has_sliding() || term == X_F,
            model.has_drag() || term == DRAG,
        )
        .and_then(|m| self.get(m))
    }

    /// p value of sliding friction, given the best model without it, and the BIC's verdict;
    /// 1 and 0 where the record is too short for the models it takes.
    pub(crate) fn sliding_evidence(&self, scale: Scale) -> (f64, f64) {
        ranked::sliding_evidence(&self.entries, |small, large| test(small, large, scale))
    }

    /// p value of a purely viscous decay against `model`.
    pub(crate) fn viscous_only(&self, model: LossModel, scale: Scale) -> f64 {
        match (self.get(LossModel::Viscous), self.get(model)) {
            (Some(v), Some(m)) if model != LossModel::Viscous && model.has_viscous() => test(v, m, scale),
            (Some(v), Some(_)) if model != LossModel::Viscous => self
                .with_term(LossModel::Viscous, if model.has_sliding() { X_F } else { DRAG })
                .map_or(1.0, |union| test(v, union, scale)),
            _ => 1.0,
        }
    }
}

/// One-sided p value of the smaller model against the larger.
fn test(small: &Entry, large: &Entry, scale: Scale) -> f64 {
    let variance = scale.variance_of(&large.bounded) * scale.widening;
    one_sided((small.bounded.rss - large.bounded.rss) / variance, scale.dof(&large.fit))
}

/// A loss coefficient with its honest interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounded {
    pub(crate) estimate: f64,
    pub(crate) std_error: f64,
    pub(crate) interval: [f64; 2],
}

/// Interval of a non-negative parameter: Wald far from zero, profile likelihood
/// with the limit's own critical values near it.
pub(crate) fn interval(problem: &dyn LeastSquares, fit: &Fit, parameter: usize, scale: Scale) -> Bounded {
    let estimate = fit.parameters[parameter];
    let sigma = (scale.variance_of(fit) * scale.widening).sqrt();
    let factor = student_factor(scale.dof(fit));
    let std_error = fit.unit_std(parameter) * sigma;
    let wide = std_error * factor;
    let z = estimate / wide;
    if !(z < NEAR) || !z.is_finite() {
        let half = crate::inference::Z_95 * wide;
        return Bounded { estimate, std_error, interval: [estimate - half, estimate + half] };
    }
    let profile = Profile { problem, fit, parameter, unit: sigma * factor, std_error: wide };
    // Distance of the limit in root-likelihood units takes the place of z.
    let distance = -profile.root(0.0).unwrap_or(-z);
    let [low, high] = bounded_interval(distance);
    let find = |target: f64| profile.solve(target).unwrap_or(estimate + target * wide);
    let lower = if low <= 0.0 { 0.0 } else { find(low - distance).max(0.0) };
    let upper = find(high - distance).max(0.0);
    Bounded { estimate, std_error, interval: [lower, upper] }
}

/// Nearer to its limit than this many standard errors an estimate gets a profile.
const NEAR: f64 = 6.0;

struct Profile<'a> {
    problem: &'a dyn LeastSquares,
    fit: &'a Fit,
    parameter: usize,
    unit: f64,
    std_error: f64,
}

impl Profile<'_> {
    /// Signed root of the likelihood ratio at a fixed value of the parameter.
    fn root(&self, value: f64) -> Option<f64> {
        let k = self.parameter;
        let shift = value - self.fit.parameters[k];
        let variance = self.fit.unit_covariance[(k, k)];
        let mut start = self.fit.parameters.clone();
        for (i, p) in start.iter_mut().enumerate() {
            *p += shift * self.fit.unit_covariance[(i, k)] / variance;
        }
        start[k] = value;
        let free: Vec<usize> = self.fit.free.iter().copied().filter(|&i| i != k).collect();
        let fit = minimise(self.problem, &start, &free)?;
        Some(shift.signum() * (fit.rss - self.fit.rss).max(0.0).sqrt() / self.unit)
    }

    /// The value where the root is `target`, by three secant steps from the Wald guess.
    fn solve(&self, target: f64) -> Option<f64> {
        let centre = self.fit.parameters[self.parameter];
        let mut slope = 1.0 / self.std_error;
        let mut value = centre + target / slope;
        for _ in 0..4 {
            let root = self.root(value)?;
            let error = root - target;
            if error.abs() < 0.01 {
                break;
            }
            if value != centre && root != 0.0 {
                slope = root / (value - centre);
            }
            value = centre + target / slope;
        }
        value.is_finite().then_some(value)
    }
}

//! Model comparison: every loss model is fitted to the same data within physical limits and ranked by BIC.

use super::criteria::InferenceCriteria;
use super::least_squares::Fit;
use super::noise::NoiseModel;
use crate::model::loss::{LossModel, LossTerm};
use std::sync::Arc;

/// One loss model, fitted.
#[derive(Debug, Clone)]
pub(crate) struct ModelFit {
    pub(crate) model: LossModel,
    /// Best fit without limits: losses may be negative.
    pub(crate) unbounded: Arc<Fit>,
    /// Best fit within the limits: the same fit, or that of the smaller model to which it reduces.
    pub(crate) bounded: Arc<Fit>,
    /// The loss term that is negative in the unbounded fit, if any.
    pub(crate) at_limit: Option<LossTerm>,
    pub(crate) bic: f64,
}

impl ModelFit {
    /// Slots of the coefficients of all its loss terms but one; `slot` as in [`ModelComparison::new`].
    pub(crate) fn other_slots(&self, term: LossTerm, slot: impl Fn(LossTerm) -> usize) -> Vec<usize> {
        self.model.terms().filter(|other| *other != term).map(slot).collect()
    }
}

/// All loss models that could be fitted to one set of data.
#[derive(Debug, Clone)]
pub(crate) struct ModelComparison {
    pub(crate) fits: Vec<ModelFit>,
    pub(crate) noise: NoiseModel,
    pub(crate) criteria: InferenceCriteria,
    /// Viscous loss is certain in addition to sliding loss: models without it do not limit what may replace it.
    pub(crate) viscous_is_sure: bool,
}

impl ModelComparison {
    /// Applies the limits to the fits and ranks them; `slot` is the index of the coefficient of a loss term in the
    /// problem.
    pub(crate) fn new(
        fits: &[(LossModel, Fit)],
        slot: impl Fn(LossTerm) -> usize,
        noise: NoiseModel,
        criteria: &InferenceCriteria,
    ) -> Self {
        let fits: Vec<(LossModel, Arc<Fit>)> = fits.iter().map(|(m, f)| (*m, Arc::new(f.clone()))).collect();
        let negative = |m: LossModel, f: &Fit| m.terms().find(|t| f.parameters[slot(*t)] < 0.0);
        let fits = fits
            .iter()
            .map(|(model, fit)| {
                let at_limit = negative(*model, fit);
                let bounded = if at_limit.is_none() {
                    fit
                } else {
                    // At the limit the model reduces to one of the smaller models within it.
                    fits.iter()
                        .filter(|(m, f)| m.is_within(*model) && negative(*m, f).is_none())
                        .min_by(|a, b| a.1.rss.total_cmp(&b.1.rss))
                        .map_or(fit, |(_, f)| f)
                };
                ModelFit {
                    model: *model,
                    unbounded: Arc::clone(fit),
                    bounded: Arc::clone(bounded),
                    at_limit,
                    bic: noise.bic(bounded.rss, fit.free.len()),
                }
            })
            .collect();
        Self { fits, noise, criteria: criteria.clone(), viscous_is_sure: false }
    }

    /// The same fits with another noise model.
    pub(crate) fn with_noise(mut self, noise: NoiseModel) -> Self {
        for fit in &mut self.fits {
            fit.bic = noise.bic(fit.bounded.rss, fit.unbounded.free.len());
        }
        self.noise = noise;
        self
    }

    /// The terms of the models compared; terms compared by default are included even if the data were too few.
    pub(crate) fn terms(&self) -> impl Iterator<Item = LossTerm> {
        let fitted = |t: LossTerm| self.fits.iter().any(|f| f.model.has(t));
        LossTerm::ALL.iter().copied().filter(move |t| t.is_compared() || fitted(*t))
    }

    /// Criterion by which models are ranked, lower is better.
    fn rank(&self, fit: &ModelFit) -> f64 {
        let further = !fit.model.is_within(LossModel::VISCOUS_SLIDING);
        let penalised = further && !fit.model.has(LossTerm::Viscous);
        fit.bic + if penalised { self.criteria.no_viscous_penalty } else { 0.0 }
    }

    fn lowest<'a>(&self, of: impl Iterator<Item = &'a ModelFit>) -> Option<&'a ModelFit> {
        of.min_by(|a, b| self.rank(a).total_cmp(&self.rank(b)))
    }

    /// The fit of a model.
    pub(crate) fn get(&self, model: LossModel) -> Option<&ModelFit> {
        self.fits.iter().find(|f| f.model == model)
    }

    /// The largest model with its terms unbounded: its residuals are noise if any of the models is valid.
    pub(crate) fn largest(&self) -> Option<&ModelFit> {
        self.fits.iter().max_by_key(|f| f.model.terms().count())
    }

    /// The fit of the requested model, or, if the data do not determine all of its parameters, that of the largest
    /// model within it.
    pub(crate) fn largest_within(&self, asked: LossModel) -> Option<&ModelFit> {
        let within = self.fits.iter().filter(|f| f.model.is_within(asked));
        self.get(asked).or_else(|| {
            within.max_by(|a, b| {
                let terms = |f: &ModelFit| f.model.terms().count();
                terms(a).cmp(&terms(b)).then(b.bic.total_cmp(&a.bic))
            })
        })
    }

    /// The model of lowest BIC, including penalties, among those with every term inside its limit. Terms other than
    /// viscous and sliding loss must also be significant, because for few observations the BIC is less strict than the
    /// F test.
    pub(crate) fn preferred(&self) -> Option<&ModelFit> {
        let inside = || self.fits.iter().filter(|f| f.at_limit.is_none());
        let best = self.lowest(inside()).or_else(|| self.lowest(self.fits.iter()))?;
        let further = |m: LossModel| m.terms().filter(|t| !LossModel::VISCOUS_SLIDING.has(*t));
        if further(best.model).next().is_none() {
            return Some(best);
        }
        let Some(plain) = self.lowest(inside().filter(|f| further(f.model).next().is_none())) else {
            return Some(best);
        };
        let larger = self.get(best.model.terms().fold(plain.model, LossModel::with));
        let p_value = larger.map_or(0.0, |larger| self.p_value(plain, larger));
        Some(if p_value < self.criteria.further_significance { best } else { plain })
    }

    /// The model whose values are reported: the preferred one, always with viscous and sliding loss, at their limits if
    /// the data do not require them.
    ///
    /// A term left out because it is not detected is not known to be zero: without it the intervals of the other terms
    /// would cover the true value far less often than stated (Leeb and Pötscher 2005, Econometric Theory 21, 21).
    pub(crate) fn reported(&self) -> Option<&ModelFit> {
        let preferred = self.preferred()?.model;
        self.get(preferred.with(LossTerm::Viscous).with(LossTerm::Sliding))
    }

    /// A model that describes the data as well as the preferred one, to within `bic`, and that has terms which are not
    /// reported, or lacks some terms other than viscous and sliding loss.
    pub(crate) fn rival(&self, bic: f64) -> Option<&ModelFit> {
        let preferred = self.preferred()?;
        let reported = |m: LossModel| m.with(LossTerm::Viscous).with(LossTerm::Sliding);
        let other = |f: &&ModelFit| reported(f.model) != reported(preferred.model) && f.at_limit.is_none();
        let close = self.fits.iter().filter(other).filter(|f| f.bic < preferred.bic + bic);
        close.min_by(|a, b| a.bic.total_cmp(&b.bic))
    }

    /// Lowest BIC of all models.
    pub(crate) fn lowest_bic(&self) -> f64 {
        self.fits.iter().map(|f| f.bic).fold(f64::INFINITY, f64::min)
    }

    /// The fit that determines a loss term: that of the chosen model if it has the term, otherwise that of the chosen
    /// model with the term added.
    pub(crate) fn fit_with(&self, chosen: &ModelFit, term: LossTerm) -> Option<&ModelFit> {
        self.get(chosen.model.with(term))
    }

    /// p value of sliding friction given the best model without it, and the BIC difference between the best models
    /// without and with it; 1 and 0 if there are too few data for the required models.
    pub(crate) fn sliding_evidence(&self) -> (f64, f64) {
        let best = |sliding: bool| self.lowest(self.fits.iter().filter(|f| f.model.has_sliding() == sliding));
        let (Some(without), Some(with)) = (best(false), best(true)) else { return (1.0, 0.0) };
        let both = self.get(without.model.with(LossTerm::Sliding));
        (both.map_or(1.0, |both| self.p_value(without, both)), self.rank(without) - self.rank(with))
    }

    /// p value of sliding friction in addition to the other losses of a fit; `None` if the fit has no sliding friction
    /// or no other loss, or if the model without it was not fitted.
    pub(crate) fn sliding_p_value_in(&self, fit: &ModelFit) -> Option<f64> {
        let others: Vec<LossTerm> = fit.model.terms().filter(|t| *t != LossTerm::Sliding).collect();
        let without = LossModel::from_terms(&others).and_then(|m| self.get(m));
        without.filter(|_| fit.model.has_sliding()).map(|without| self.p_value(without, fit))
    }

    /// p value of a purely viscous loss against a model; 1 for the viscous model itself.
    pub(crate) fn viscous_only(&self, model: LossModel) -> f64 {
        let pair = self.get(LossModel::VISCOUS).zip(self.get(model.with(LossTerm::Viscous)));
        match pair {
            Some((viscous, both)) if model != LossModel::VISCOUS => self.p_value(viscous, both),
            _ => 1.0,
        }
    }

    /// p value of the smaller model against the larger.
    fn p_value(&self, small: &ModelFit, large: &ModelFit) -> f64 {
        self.noise.p_value(small.bounded.rss, &large.bounded, &large.unbounded)
    }

    /// Largest value of a loss coefficient that the data allow: its value in the model with this loss alone plus a
    /// number of standard errors. `None` if that model was not fitted.
    pub(crate) fn most(&self, term: LossTerm, slot: usize) -> Option<f64> {
        let alone = &self.get(LossModel::from_terms(&[term])?)?.unbounded;
        let most = alone.parameters[slot].max(0.0)
            + self.criteria.allowed_errors * self.noise.std_error(alone, slot);
        most.is_finite().then_some(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::covariance::Covariance;
    use nalgebra::DMatrix;

    fn fit(rss: f64) -> Fit {
        Fit {
            parameters: vec![0.1; 8],
            unit_covariance: Covariance::new(DMatrix::zeros(1, 1), &[0], 8),
            rss,
            free: vec![0],
            converged: true,
        }
    }

    #[test]
    fn a_model_that_the_data_do_not_determine_falls_to_the_largest_within_it() {
        let noise = NoiseModel::white(100.0);
        let viscous_drag = LossModel::VISCOUS_DRAG;
        let all = LossModel::VISCOUS_SLIDING.with(LossTerm::Drag);
        let fits = [
            (LossModel::VISCOUS, fit(1.0)),
            (LossModel::VISCOUS_SLIDING, fit(0.9)),
            (viscous_drag, fit(0.8)),
        ];
        let comparison = ModelComparison::new(&fits, |_| 0, noise, &InferenceCriteria::default());
        let found = |asked| comparison.largest_within(asked).map(|f| f.model);
        assert_eq!(found(LossModel::VISCOUS_SLIDING), Some(LossModel::VISCOUS_SLIDING));
        // Two models with two terms each: the one that fits better.
        assert_eq!(found(all), Some(viscous_drag));
        assert_eq!(found(LossModel::SLIDING), None);
    }
}

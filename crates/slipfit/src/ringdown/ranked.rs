//! Loss models with their evidence, none with a loss below zero.

use super::LossModel;
use crate::inference::least_squares::Fit;

/// One loss model's best fit.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) model: LossModel,
    /// Best fit, limits lifted.
    pub(crate) fit: Fit,
    /// Best fit within the limits: that of this model or of the smaller one it falls to.
    pub(crate) bounded: Fit,
    pub(crate) at_limit: Option<usize>,
    pub(crate) bic: f64,
}

impl Entry {
    /// What models are compared by: the less the better.
    pub(crate) fn rank(&self) -> f64 {
        self.bic + self.model.handicap()
    }
}

/// The entry of a model.
pub(crate) fn of(entries: &[Entry], model: LossModel) -> Option<&Entry> {
    entries.iter().find(|e| e.model == model)
}

fn least<'a>(of: impl Iterator<Item = &'a Entry>) -> Option<&'a Entry> {
    of.min_by(|a, b| a.rank().total_cmp(&b.rank()))
}

/// The model of least rank among those with every term inside its limit.
pub(crate) fn best(entries: &[Entry]) -> Option<&Entry> {
    least(entries.iter().filter(|e| e.at_limit.is_none())).or_else(|| least(entries.iter()))
}

/// The best model with or without sliding friction.
fn best_where(entries: &[Entry], sliding: bool) -> Option<&Entry> {
    least(entries.iter().filter(|e| e.model.has_sliding() == sliding))
}

/// p value of sliding friction by `test` of a small model against a large one, given the best model
/// without it, and the BIC's verdict; 1 and 0 where there are too few data for the models it takes.
pub(crate) fn sliding_evidence(entries: &[Entry], test: impl Fn(&Entry, &Entry) -> f64) -> (f64, f64) {
    let (Some(without), Some(with)) = (best_where(entries, false), best_where(entries, true)) else {
        return (1.0, 0.0);
    };
    let m = without.model;
    let union = LossModel::from_terms(m.has_viscous(), true, m.has_drag()).and_then(|m| of(entries, m));
    (union.map_or(1.0, |union| test(without, union)), without.rank() - with.rank())
}

/// The fits held to their limits; `terms` are a model's losses, `bic` of a sum of squares and a
/// number of parameters.
pub(crate) fn ranked(
    fits: &[(LossModel, Fit)],
    terms: impl Fn(LossModel) -> Vec<usize>,
    bic: impl Fn(f64, usize) -> f64,
) -> Vec<Entry> {
    let physical = |m: LossModel, f: &Fit| terms(m).iter().all(|&t| f.parameters[t] >= 0.0);
    fits.iter()
        .map(|(model, fit)| {
            let own = terms(*model);
            let at_limit = own.iter().copied().find(|&t| fit.parameters[t] < 0.0);
            let bounded = if at_limit.is_none() {
                fit.clone()
            } else {
                // On the limit the model is one of its smaller relatives.
                fits.iter()
                    .filter(|(m, f)| terms(*m).iter().all(|t| own.contains(t)) && physical(*m, f))
                    .min_by(|a, b| a.1.rss.total_cmp(&b.1.rss))
                    .map_or_else(|| fit.clone(), |(_, f)| f.clone())
            };
            let bic = bic(bounded.rss, fit.free.len());
            Entry { model: *model, fit: fit.clone(), bounded, at_limit, bic }
        })
        .collect()
}

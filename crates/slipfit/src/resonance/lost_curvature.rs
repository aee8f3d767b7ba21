//! Effect of the curvature of the response within a group on the means of dense points.

use super::block::Block;
use super::fitted_models::FittedModels;
use super::prepared::PreparedCurve;
use crate::motion::steady::Phasor;

/// The curve with its means corrected for the curvature of the response within each group: the difference between the
/// mean of the fitted response over a group and the response at the mean frequency is subtracted. `None` if no
/// parameter would change by more than `errors` standard errors.
///
/// By the Cauchy-Schwarz inequality a change of the data changes no parameter by more standard errors than the square
/// root of its sum of squares over the variance of a point. The error of a fit to uncorrected means enters the
/// correction only through the small part of the response that is lost, so that a few iterations converge to rounding.
pub(super) fn corrected(curve: &PreparedCurve, fitted: &FittedModels, errors: f64) -> Option<PreparedCurve> {
    let (all, measured) = (fitted.all.as_ref()?, curve.all.as_ref()?);
    let chosen = fitted.comparison.reported().or_else(|| fitted.comparison.preferred())?;
    let groups = &fitted.problem.main;
    // Amplitudes of complex means are not means of amplitudes.
    if fitted.phases_ignored || groups.len() != curve.main.len() {
        return None;
    }
    let p = &chosen.bounded.parameters;
    let modelled = |block: &Block| -> Vec<Phasor> {
        let mut problem = fitted.problem.clone();
        problem.main = Block { rice: groups.rice, ..block.clone() };
        let value = |(i, m): (usize, Option<_>)| m.map_or(NONE, |m| problem.main.reading(i, &m));
        problem.predict(p, false).into_iter().enumerate().map(value).collect()
    };
    // Weighted as the measured points were, whatever the fit did with their errors.
    let precision = measured.precision.clone();
    let means = Block { data: modelled(all), precision, ..all.clone() }.grouped(curve.group).data;
    let lost_by = |(mean, centre): (&Phasor, Phasor)| {
        let lost = mean - centre;
        let lost = if lost.is_finite() { lost } else { Phasor::default() };
        if fitted.conjugated { lost.conj() } else { lost }
    };
    let lost: Vec<Phasor> = means.iter().zip(modelled(groups)).map(lost_by).collect();
    let before = |k: usize| curve.lost.get(k).copied().unwrap_or_default();
    let changes = || lost.iter().enumerate().map(|(k, lost)| lost - before(k));
    let squares: f64 = changes().zip(&groups.weight).map(|(change, weight)| weight * change.norm_sqr()).sum();
    let variance = fitted.comparison.noise.residual_variance(&chosen.bounded);
    if !(squares > errors * errors * variance) {
        return None;
    }
    let mut better = curve.clone();
    better.main.data.iter_mut().zip(changes()).for_each(|(mean, change)| *mean -= change);
    better.lost = lost;
    Some(better)
}

/// Value where the model has no motion.
const NONE: Phasor = Phasor::new(f64::NAN, f64::NAN);

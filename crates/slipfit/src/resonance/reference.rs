//! Fit of the friction-free reference alone.

use super::block::Block;
use super::criteria::{Criteria, SearchCriteria};
use super::peak;
use super::problem::Problem;
use super::residuals::{refit_with_rice, variance};
use super::response::{
    BG_IM, BG_RE, COUNT, DELAY, DELTA, DRAG, DUFFING, FLOOR, OFFSET, OMEGA, PHASE, R_BG_IM, R_BG_RE, R_DELTA,
    R_OMEGA, R_PHASE, X_0, X_F,
};
use super::search::{best, starts};
use super::start;
use crate::Error;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::inference::noise::NoiseModel;

/// A reference without friction, fitted alone.
pub(super) struct FrictionFreeFit {
    pub(super) block: Block,
    /// Start values of its parameters, and of its drive, in the joint fit.
    parameters: Vec<f64>,
    /// Variance of its points.
    pub(super) variance: f64,
}

impl FrictionFreeFit {
    /// The reference must be a resonance by itself, and it has its own noise; method and centre are those of the
    /// curve's `problem`.
    pub(super) fn new(
        block: Block,
        problem: &Problem,
        background: bool,
        criteria: &Criteria,
    ) -> Result<Self, Error> {
        let no = |reason| Error::NoResonance { reason };
        let peak = peak::find(&block).ok_or(no("the reference has no amplitude above zero"))?;
        let mut own =
            Problem { main: block, centre: peak.omega, reference: None, prior: None, ..problem.clone() };
        let mut free = vec![OMEGA, DELTA, X_0];
        if own.main.complex {
            free.push(PHASE);
        }
        if background {
            free.extend([BG_RE, BG_IM]);
        }
        own.used = free.clone();
        let linear = start::linear(&own.main, &peak, false).map(|(s, _)| s);
        let mut list = starts(&own.main, &peak, linear, None, false);
        for p in &mut list {
            p[X_F] = 0.0;
        }
        if own.observations() as usize <= free.len() {
            return Err(Error::TooFewPoints { points: own.main.len(), parameters: free.len() });
        }
        let mut fit = best(&own, &list, &free, &criteria.search)
            .ok_or(no("no resonance could be fitted to the reference"))?;
        refit_with_rice(&mut own, &mut fit, &free, &criteria.residuals);
        let p = &fit.parameters;
        let mut parameters = vec![0.0; COUNT];
        parameters[R_OMEGA] = p[OMEGA] + peak.omega - problem.centre;
        (parameters[R_DELTA], parameters[X_0]) = (p[DELTA], p[X_0]);
        (parameters[R_PHASE], parameters[R_BG_RE], parameters[R_BG_IM]) = (p[PHASE], p[BG_RE], p[BG_IM]);
        let variance = variance(&own, &fit).max(f64::MIN_POSITIVE);
        Ok(Self { block: own.main, parameters, variance })
    }

    pub(super) fn drive(&self) -> f64 {
        self.parameters[X_0]
    }

    /// Free parameters in addition to those of the curve.
    pub(super) fn free(&self, phase: bool, background: bool) -> Vec<usize> {
        let mut free = vec![R_OMEGA, R_DELTA];
        if self.block.complex && phase {
            free.push(R_PHASE);
        }
        if background {
            free.extend([R_BG_RE, R_BG_IM]);
        }
        free
    }

    /// Copies its parameters into start values of the joint fit.
    pub(super) fn copy_to(&self, p: &mut [f64]) {
        p[R_OMEGA..].copy_from_slice(&self.parameters[R_OMEGA..]);
    }
}

/// p value of no sliding friction in the reference alone, with its drive free; `fit` is the joint fit.
pub(super) fn sliding_p_value(problem: &Problem, fit: &Fit, c: &SearchCriteria) -> f64 {
    let Some(block) = problem.reference.clone() else { return 1.0 };
    let q = &fit.parameters;
    let mut p = vec![0.0; COUNT];
    (p[OMEGA], p[DELTA], p[X_0], p[PHASE]) = (q[R_OMEGA], q[R_DELTA], q[X_0], q[R_PHASE]);
    (p[BG_RE], p[BG_IM], p[DELAY]) = (q[R_BG_RE], q[R_BG_IM], q[DELAY]);
    let shared = [DRAG, DUFFING, OFFSET, FLOOR];
    shared.into_iter().for_each(|k| p[k] = q[k]);
    let mut free = vec![OMEGA, DELTA, X_0];
    free.extend(shared.into_iter().filter(|k| fit.free.contains(k)));
    if block.complex {
        free.push(PHASE);
    }
    if fit.free.contains(&R_BG_RE) {
        free.extend([BG_RE, BG_IM]);
    }
    let mut own =
        Problem { main: block, reference: None, prior: None, used: free.clone(), ..problem.clone() };
    let Some(without) = minimise(&own, &p, &free) else { return 1.0 };
    free.push(X_F);
    free.sort_unstable();
    own.used = free.clone();
    let mut start = without.parameters.clone();
    start[X_F] = SLIDING_START * start[X_0];
    match best(&own, &[start, without.parameters.clone()], &free, c) {
        Some(with) if with.parameters[X_F] > 0.0 => {
            NoiseModel::white(own.main.observations()).p_value(without.rss, &with, &with)
        }
        _ => 1.0,
    }
}

/// Start value of the friction displacement over the drive.
const SLIDING_START: f64 = 0.05;

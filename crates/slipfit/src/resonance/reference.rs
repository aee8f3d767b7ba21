//! The friction-free reference beside the curve.

use super::block::Block;
use super::peak;
use super::problem::Problem;
use super::residuals::{settle_rice, variance};
use super::response::{
    BG_IM, BG_RE, COUNT, DELTA, OMEGA, PHASE, R_BG_IM, R_BG_RE, R_DELTA, R_OMEGA, R_PHASE, X_0, X_F,
};
use super::search::{best, starts};
use super::start;
use crate::Error;
use crate::inference::least_squares::{LeastSquares, minimise};

/// A reference fitted by itself.
pub(super) struct FrictionFreeFit {
    pub(super) block: Block,
    /// Where its parameters, and its drive, begin in the joint fit.
    parameters: Vec<f64>,
    /// Of its points.
    pub(super) variance: f64,
}

impl FrictionFreeFit {
    /// Fits a line without friction: the reference must be one by itself, and its noise is its own.
    pub(super) fn new(block: Block, problem: &Problem, background: bool) -> Result<Self, Error> {
        let no = |reason| Error::NoResonance { reason };
        let line = peak::find(&block).ok_or(no("the reference has no amplitude above zero"))?;
        let mut own =
            Problem { main: block, centre: line.omega, reference: None, prior: None, ..problem.clone() };
        let mut free = vec![OMEGA, DELTA, X_0];
        if own.main.complex {
            free.push(PHASE);
        }
        if background {
            free.extend([BG_RE, BG_IM]);
        }
        own.used = free.clone();
        let linear = start::linear(&own.main, &line, false).map(|(s, _)| s);
        let mut list = starts(&own.main, &line, linear, None, false);
        for p in &mut list {
            p[X_F] = 0.0;
        }
        if own.observations() as usize <= free.len() {
            return Err(Error::TooFewPoints { points: own.main.len(), parameters: free.len() });
        }
        let mut fit = best(&own, &list, &free).ok_or(no("no line was reached in the reference"))?;
        if !own.main.complex {
            for _ in 0..2 {
                let v = variance(&own, &fit);
                settle_rice(&mut own, &fit.parameters, v);
                if let Some(f) = minimise(&own, &fit.parameters, &free) {
                    fit = f;
                }
            }
        }
        let p = &fit.parameters;
        let mut parameters = vec![0.0; COUNT];
        parameters[R_OMEGA] = p[OMEGA] + line.omega - problem.centre;
        (parameters[R_DELTA], parameters[X_0]) = (p[DELTA], p[X_0]);
        (parameters[R_PHASE], parameters[R_BG_RE], parameters[R_BG_IM]) = (p[PHASE], p[BG_RE], p[BG_IM]);
        let variance = variance(&own, &fit).max(f64::MIN_POSITIVE);
        Ok(Self { block: own.main, parameters, variance })
    }

    pub(super) fn drive(&self) -> f64 {
        self.parameters[X_0]
    }

    /// Parameters free beside those of the curve.
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

    /// Puts its own parameters into a first value of the joint fit.
    pub(super) fn copy_to(&self, p: &mut [f64]) {
        p[R_OMEGA..].copy_from_slice(&self.parameters[R_OMEGA..]);
    }
}

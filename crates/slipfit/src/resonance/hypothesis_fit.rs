//! The fit of a hypothesis: viscous damping and sliding friction, in addition to the terms of the hypothesis.

use super::Options;
use super::alternatives::OtherFit;
use super::criteria::Criteria;
use super::hypothesis::{Hypothesis, Kind};
use super::prepared::PreparedCurve;
use super::presence;
use super::problem::Problem;
use super::reference::FrictionFreeFit;
use super::residuals::{drop_outliers, refit_with_rice, set_rice, variance};
use super::response::{
    BG_IM, BG_RE, DELAY, DELTA, DUFFING, FLOOR, OFFSET, OMEGA, PHASE, R_OMEGA, X_0, X_F, slot,
};
use super::search::{best, rss, starts};
use crate::Error;
use crate::inference::least_squares::{Fit, LeastSquares, minimise};
use crate::model::loss::LossTerm;
use crate::motion::steady::Phasor;
use std::cell::OnceCell;

/// A hypothesis with its parameters fitted.
pub(super) struct HypothesisFit<'a> {
    pub(super) options: &'a Options,
    pub(super) criteria: &'a Criteria,
    pub(super) hypothesis: Hypothesis,
    pub(super) problem: Problem,
    pub(super) fit: Fit,
    /// Start values of the oscillator together with those of the instrument.
    pub(super) starts: Vec<Vec<f64>>,
    /// Other sets of instrument terms, fitted.
    pub(super) others: Vec<OtherFit>,
    /// Several minima, if a background in amplitudes was searched for.
    pub(super) minima: Vec<Fit>,
    /// Oscillators that fit best at each of many backgrounds, without and with a Duffing term: starts of that search
    /// for every set of terms, computed on first use.
    pub(super) background_starts: [OnceCell<Vec<Vec<f64>>>; 2],
    pub(super) outliers: usize,
    /// Noise of one amplitude, from differences between neighbours.
    pub(super) noise: f64,
    /// Residual variance of the curve alone, before terms were added.
    pub(super) first_variance: f64,
    /// Free parameters before terms were added or dropped.
    full: Vec<usize>,
}

impl<'a> HypothesisFit<'a> {
    /// Fits curve and reference, with Rice noise and outliers treated.
    pub(super) fn new(
        curve: &PreparedCurve,
        hypothesis: Hypothesis,
        options: &'a Options,
        criteria: &'a Criteria,
    ) -> Result<Self, Error> {
        let (mut this, reference) = Self::curve_alone(curve, hypothesis, options, criteria)?;
        let noise = this.noise.min(this.first_variance.sqrt());
        if let Some(reason) = presence::absence(&this.problem, &this.fit, noise, criteria) {
            return Err(Error::NoResonance { reason });
        }
        this.join(reference);
        refit_with_rice(&mut this.problem, &mut this.fit, &this.full, &criteria.residuals);
        this.outliers =
            drop_outliers(&mut this.problem, &this.fit.parameters, this.noise, &criteria.residuals);
        if this.outliers > 0 {
            this.refit();
        }
        Ok(this)
    }

    /// Fits the curve without its reference, to estimate the noise that weights it, and the reference alone.
    fn curve_alone(
        curve: &PreparedCurve,
        hypothesis: Hypothesis,
        options: &'a Options,
        criteria: &'a Criteria,
    ) -> Result<(Self, Option<FrictionFreeFit>), Error> {
        let Hypothesis { peak, instrument, oscillator, .. } = hypothesis;
        let wanted = options.terms;
        let phase = wanted.phase_offset != Some(false);
        let background = wanted.background == Some(true) || instrument.background != Phasor::default();
        let main = hypothesis.view(&curve.main);
        let complex = main.complex;
        let problem = Problem {
            method: options.method,
            background_delayed: instrument.delayed,
            ..Problem::new(main, peak.omega, Vec::new())
        };
        let fixed = options.drive_amplitude.is_some_and(|d| d.std_error == 0.0);
        let mut full = vec![OMEGA, DELTA, X_F];
        full.extend(LossTerm::further_of(options.model).map(slot));
        let mut free_if = |yes: bool, terms: &[usize]| full.extend(terms.iter().filter(|_| yes));
        free_if(!fixed, &[X_0]);
        free_if(complex && phase, &[PHASE]);
        free_if(background, &[BG_RE, BG_IM]);
        free_if(complex && (wanted.delay == Some(true) || instrument.delay != 0.0), &[DELAY]);
        free_if(!complex && wanted.amplitude_offset == Some(true), &[OFFSET]);
        free_if(!complex && wanted.noise_floor == Some(true), &[FLOOR]);
        free_if(wanted.duffing == Some(true), &[DUFFING]);
        let reference = curve.reference.as_ref().map(|block| hypothesis.view(block));
        let reference =
            reference.map(|block| FrictionFreeFit::new(block, &problem, background, criteria)).transpose()?;
        if let Some(reference) = &reference {
            full.extend(reference.free(phase, background));
        }
        full.sort_unstable();
        let observations =
            problem.observations() + reference.as_ref().map_or(0.0, |r| r.block.observations());
        if (observations as usize) <= full.len() {
            return Err(Error::TooFewPoints { points: problem.main.len(), parameters: full.len() });
        }
        let known = options.drive_amplitude.map(|d| d.value).or(reference.as_ref().map(|r| r.drive()));
        let mut starts = starts(&problem.main, &peak, oscillator, known, fixed);
        for s in &mut starts {
            (s[BG_RE], s[BG_IM]) = (instrument.background.re, instrument.background.im);
            s[DELAY] = instrument.delay;
            if let Some(reference) = &reference {
                reference.copy_to(s);
            }
            if !full.contains(&PHASE) {
                s[PHASE] = 0.0;
            }
        }
        let own: Vec<usize> = full.iter().copied().filter(|&k| k < R_OMEGA).collect();
        let problem = problem.with(&own);
        let fit = best(&problem, &starts, &own, &criteria.search).ok_or(Error::NoFit {
            reason: "no resonance curve with viscous and sliding loss could be fitted from any start value",
        })?;
        let first_variance = variance(&problem, &fit).max(f64::MIN_POSITIVE);
        let this = Self {
            options,
            criteria,
            hypothesis,
            problem,
            fit,
            starts,
            others: Vec::new(),
            minima: Vec::new(),
            background_starts: Default::default(),
            outliers: 0,
            noise: if hypothesis.kind == Kind::Plain { curve.noise } else { curve.fitted_noise },
            first_variance,
            full,
        };
        Ok((this, reference))
    }

    /// Fits curve and reference together, each weighted by its own noise.
    fn join(&mut self, reference: Option<FrictionFreeFit>) {
        let weight = |of_curve: f64, of_reference: f64| (of_curve / of_reference).clamp(1e-12, 1e12);
        if let Some(drive) = self.options.drive_amplitude.filter(|d| d.std_error > 0.0) {
            self.problem.prior =
                Some([drive.value, self.first_variance / (drive.std_error * drive.std_error)]);
        }
        let mut here = self.fit.parameters.clone();
        let mut reference_variance = None;
        if let Some(reference) = reference {
            reference.copy_to(&mut here);
            reference_variance = Some(reference.variance);
            self.problem.reference_weight = weight(self.first_variance, reference.variance);
            self.problem.reference = Some(reference.block);
        }
        self.starts.insert(0, here);
        match best(&self.problem, &self.starts, &self.full, &self.criteria.search) {
            Some(fit) => self.fit = fit,
            None => self.fit.free.clone_from(&self.full),
        }
        // Without the reference the fit from the shape alone may have ended at another minimum, where its residuals do
        // not measure the noise; with the reference they do.
        let Some(reference_variance) = reference_variance else { return };
        let c = &self.criteria.reference;
        let own = self.problem.used.len() as f64;
        for _ in 0..c.weight_rounds {
            let alone = Problem { reference: None, ..self.problem.clone() };
            let Some(left) = rss(&alone, &self.fit.parameters, f64::INFINITY) else { return };
            let better = weight(left / (alone.observations() - own).max(1.0), reference_variance);
            if (better / self.problem.reference_weight).ln().abs() < c.weight_change {
                return;
            }
            self.problem.reference_weight = better;
            if !self.refit() {
                return;
            }
        }
    }

    /// Weights the reference by its residuals in the present fit: before the instrument terms were added, they were not
    /// noise. Returns whether the weight changed.
    pub(super) fn settle_reference(&mut self) -> bool {
        let Some(reference) = &self.problem.reference else { return false };
        let c = &self.criteria.reference;
        let alone = Problem { reference: None, prior: None, ..self.problem.clone() };
        let Some(left) = rss(&alone, &self.fit.parameters, f64::INFINITY) else { return false };
        let own = self.fit.free.iter().filter(|k| **k >= R_OMEGA).count() as f64;
        let of_reference = (self.fit.rss - left).max(0.0) / self.problem.reference_weight;
        let of_reference = of_reference / (reference.observations() - own).max(1.0);
        let of_curve = left / (alone.observations() - (self.fit.free.len() as f64 - own)).max(1.0);
        let weight = (of_curve / of_reference).clamp(1e-12, 1e12);
        if !((weight / self.problem.reference_weight).ln().abs() > c.weight_change) {
            return false;
        }
        let problem = Problem { reference_weight: weight, ..self.problem.clone() };
        let Some(fit) = minimise(&problem, &self.fit.parameters, &self.fit.free) else { return false };
        (self.problem, self.fit) = (problem, fit);
        true
    }

    /// Repeats the fit from the present parameters; returns whether there is one.
    fn refit(&mut self) -> bool {
        let here = std::slice::from_ref(&self.fit.parameters);
        let found = best(&self.problem, here, &self.full, &self.criteria.search);
        let exists = found.is_some();
        self.fit = found.unwrap_or_else(|| self.fit.clone());
        exists
    }

    /// Variance of a point with precision one.
    pub(super) fn variance(&self) -> f64 {
        variance(&self.problem, &self.fit)
    }

    /// For amplitudes, sets the Rice noise from the residuals.
    pub(super) fn settle_rice(&mut self) {
        if !self.problem.main.complex {
            let variance = self.variance();
            set_rice(&mut self.problem, &self.fit.parameters, variance, &self.criteria.residuals);
        }
    }

    /// Whether the fit has more terms than the hypothesis started with, or a background.
    pub(super) fn has_more_terms(&self) -> bool {
        self.fit.free.len() > self.full.len() || self.fit.free.contains(&BG_RE)
    }
}

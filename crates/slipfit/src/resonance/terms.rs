//! Terms the fit of a curve takes up unasked, or drops again: background, delay, lean, drag.

use super::fits::Fitting;
use super::peak::Peak;
use super::problem::Problem;
use super::residuals::{autocorrelation_of, plain_scale};
use super::response::{
    BG_IM, BG_RE, COUNT, DELAY, DELTA, DRAG, DUFFING, R_BG_IM, R_BG_RE, R_OMEGA, X_0, X_F,
};
use super::search::{best_of, thinned};
use super::start;
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise, promised_gain};
use crate::inference::noise::NoiseModel;
use crate::model::loss::LossTerm;
use crate::motion::steady::Phasor;

/// A term is taken up unasked only when it lowers the BIC by this much.
const TAKEN_UP: f64 = 14.0;
/// Drag may do worse than another term by so much and is taken up all the same.
const PREFERRED: f64 = 6.0;

/// A fit with more terms.
struct Richer {
    /// By which the BIC falls.
    gain: f64,
    fit: Fit,
    /// Every minimum, where a background was looked for under amplitudes.
    minima: Vec<Fit>,
}

impl Fitting<'_> {
    /// Takes out what a fit that began behind a background and a delay does as well without.
    pub(super) fn drop_unneeded(&mut self) {
        let wanted = self.options.terms;
        if wanted.delay.is_none() {
            self.drop_where_unneeded(&[DELAY]);
        }
        if wanted.background.is_none() {
            self.drop_where_unneeded(&[BG_RE, BG_IM, R_BG_RE, R_BG_IM]);
        }
    }

    fn drop_where_unneeded(&mut self, terms: &[usize]) {
        let fewer: Vec<usize> = self.fit.free.iter().copied().filter(|k| !terms.contains(k)).collect();
        let trial = self.problem.with(&fewer);
        let mut start = self.fit.parameters.clone();
        for &k in terms {
            start[k] = 0.0;
        }
        let scale = noisy_scale(&self.problem, &self.fit);
        if let Some(f) = minimise(&trial, &start, &fewer)
            && scale.bic(f.rss, fewer.len()) - scale.bic(self.fit.rss, self.fit.free.len()) < TAKEN_UP
        {
            (self.problem, self.fit) = (trial, f);
        }
    }

    /// Takes up the terms the data cannot do without, the one that brings most first.
    pub(super) fn take_up(&mut self) {
        let wanted = self.options.terms;
        let candidates: [(&[usize], Option<bool>, bool); 3] = [
            (&[BG_RE, BG_IM], wanted.background, true),
            (&[DELAY], wanted.delay, self.problem.main.complex),
            (&[DUFFING], wanted.duffing, true),
        ];
        for _ in 0..candidates.len() {
            let tried = candidates
                .iter()
                .filter(|(terms, asked, possible)| {
                    asked.is_none() && *possible && !self.fit.free.contains(&terms[0])
                })
                .filter_map(|(terms, ..)| self.with_terms(terms));
            let most = |a: Richer, b: Richer| if b.gain > a.gain { b } else { a };
            let Some(mut found) = tried.filter(|r| r.gain > TAKEN_UP).reduce(most) else { break };
            // Before the instrument or the spring is blamed: drag, a loss of its own.
            if self.drag_is_possible()
                && !self.fit.free.contains(&DRAG)
                && let Some(dragged) = self.with_drag()
                && dragged.gain > TAKEN_UP.max(found.gain - PREFERRED)
            {
                found = dragged;
            }
            if !found.minima.is_empty() {
                self.minima = found.minima;
            }
            self.problem = self.problem.with(&found.fit.free);
            self.fit = found.fit;
            self.settle_rice();
        }
    }

    /// Whether the delay is the background's too, as the data have it.
    pub(super) fn settle_order(&mut self) {
        let free = &self.fit.free;
        if !(self.problem.main.complex && free.contains(&BG_RE) && free.contains(&DELAY)) {
            return;
        }
        let other = Problem { background_delayed: !self.problem.background_delayed, ..self.problem.clone() };
        if let Some(fit) = minimise(&other, &self.fit.parameters, free).filter(|f| f.rss < self.fit.rss) {
            (self.problem, self.fit) = (other, fit);
        }
    }

    fn with_terms(&self, terms: &[usize]) -> Option<Richer> {
        let hidden = terms[0] == BG_RE && !self.problem.main.complex;
        let mut more = self.fit.free.clone();
        more.extend(terms);
        if self.problem.reference.is_some() && terms[0] == BG_RE {
            more.extend([R_BG_RE, R_BG_IM]);
        }
        more.sort_unstable();
        if (self.problem.observations() as usize) < more.len() + 4 {
            return None;
        }
        let trial = self.problem.with(&more);
        // A step of the quadratic model first: most curves need no more to say no.
        if !worth_trying(&trial, &self.fit, &more) {
            return None;
        }
        let minima = if hidden {
            backgrounds(&trial, &self.fit, &self.line, &more)
        } else {
            minimise(&trial, &self.fit.parameters, &more).into_iter().collect()
        };
        let fit = minima.first()?.clone();
        let gain = gain(&trial, &self.fit, &fit);
        Some(Richer { gain, fit, minima: if hidden { minima } else { Vec::new() } })
    }

    /// The fit with drag beside what is free.
    fn with_drag(&self) -> Option<Richer> {
        let mut more = self.fit.free.clone();
        more.push(DRAG);
        more.sort_unstable();
        if (self.problem.observations() as usize) < more.len() + 4 {
            return None;
        }
        let trial = self.problem.with(&more);
        let fit = minimise(&trial, &self.fit.parameters, &more).filter(|f| f.parameters[DRAG] > 0.0)?;
        Some(Richer { gain: gain(&trial, &self.fit, &fit), fit, minima: Vec::new() })
    }

    pub(super) fn drag_is_possible(&self) -> bool {
        self.options.model.is_none_or(|m| m.has(LossTerm::Drag))
    }

    /// Keeps the minima that belong to the terms now free; looks for them where a background was
    /// asked for under amplitudes.
    pub(super) fn keep_minima(&mut self) {
        let hidden = !self.problem.main.complex && self.options.terms.background == Some(true);
        if hidden && self.minima.is_empty() {
            self.minima = backgrounds(&self.problem, &self.fit, &self.line, &self.fit.free);
            self.fit = self.minima.first().unwrap_or(&self.fit).clone();
        }
        let free = &self.fit.free;
        if free.contains(&DUFFING) || free.contains(&DRAG) {
            // Other minima were those without the terms taken up since.
            let again = |m: &Fit| minimise(&self.problem, &m.parameters, free);
            self.minima = self.minima.iter().filter_map(again).collect();
        }
    }
}

/// What terms lower the BIC by. A term that is missing makes residuals hang together: what counts
/// is how they do with it.
fn gain(richer: &Problem, poor: &Fit, rich: &Fit) -> f64 {
    let scale = noisy_scale(richer, rich);
    scale.bic(poor.rss, poor.free.len()) - scale.bic(rich.rss, rich.free.len())
}

fn noisy_scale(problem: &Problem, fit: &Fit) -> NoiseModel {
    NoiseModel { variance_inflation: autocorrelation_of(problem, fit).2, ..plain_scale(problem) }
}

/// Minima that are kept.
const KEPT: usize = 8;

/// Every minimum with a background under amplitudes alone, the best first: it may lie on either
/// side of the line, and much of it looks like friction.
fn backgrounds(problem: &Problem, fit: &Fit, line: &Peak, free: &[usize]) -> Vec<Fit> {
    let few = thinned(problem);
    let coarse = few.as_ref().unwrap_or(problem);
    let mut from = vec![fit.parameters.clone()];
    let fixed: Vec<usize> = free.iter().copied().filter(|k| ![BG_RE, BG_IM].contains(k)).collect();
    let known = (!free.contains(&X_0)).then(|| fit.parameters[X_0]);
    let mut oscillators: Vec<Vec<f64>> =
        start::grid(line, 0.0, known).iter().map(|s| start::of(s, known)).collect();
    oscillators.push(fit.parameters.clone());
    for p in &mut oscillators {
        p[R_OMEGA..].copy_from_slice(&fit.parameters[R_OMEGA..]);
    }
    for size in [0.04, 0.2, 0.6] {
        for eighth in 0..8 {
            let b = Phasor::from_polar(size * line.height, std::f64::consts::FRAC_PI_4 * f64::from(eighth));
            for p in &mut oscillators {
                (p[BG_RE], p[BG_IM]) = (b.re, b.im);
            }
            from.extend(best_of(coarse, &oscillators, &fixed, 2).map(|f| f.parameters));
        }
    }
    let mut minima = distinct(coarse, from, line, free);
    if few.is_some() {
        by_rss(minima.get_mut(1..).unwrap_or_default());
        minima.truncate(1 + KEPT);
        minima = distinct(problem, minima.into_iter().map(|m| m.parameters).collect(), line, free);
    }
    let near = minima.first().cloned();
    by_rss(&mut minima);
    // Where the best leaves more than noise, a far one may only mend what the law lacks.
    if minima.first().is_some_and(|m| autocorrelation_of(problem, m).2 > 1.0) {
        return near.into_iter().collect();
    }
    minima.truncate(KEPT);
    minima
}

fn by_rss(minima: &mut [Fit]) {
    minima.sort_by(|a, b| a.rss.total_cmp(&b.rss));
}

/// Where these lead, each minimum once; no loss below zero but from the first.
fn distinct(problem: &Problem, from: Vec<Vec<f64>>, line: &Peak, free: &[usize]) -> Vec<Fit> {
    let mut minima: Vec<Fit> = Vec::new();
    for p in from {
        let Some(f) = minimise(problem, &p, free) else { continue };
        let apart = |m: &Fit| {
            [X_F, BG_RE, BG_IM].into_iter().any(|k| {
                let error = (m.unit_std(k).powi(2) * m.rss / problem.observations()).sqrt();
                (m.parameters[k] - f.parameters[k]).abs() > 0.1 * error.max(1e-9 * line.height)
            })
        };
        let sound = f.parameters[X_F] >= 0.0 && f.parameters[DELTA] >= 0.0;
        if (sound || minima.is_empty()) && minima.iter().all(apart) {
            minima.push(f);
        }
    }
    minima
}

/// Whether the sums at the present fit promise enough for the new terms.
fn worth_trying(trial: &Problem, fit: &Fit, free: &[usize]) -> bool {
    let mut sums = Normal::zeros(COUNT);
    if !trial.normal(&fit.parameters, &mut sums) {
        return false;
    }
    let scale = plain_scale(trial);
    // The quadratic model underrates what several steps bring: a margin of three.
    promised_gain(&sums, free).is_some_and(|gain| {
        let promised = (fit.rss - 3.0 * gain).max(0.05 * fit.rss);
        scale.bic(fit.rss, fit.free.len()) - scale.bic(promised, free.len()) > 0.0
    })
}

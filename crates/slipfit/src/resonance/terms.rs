//! Terms that are automatically added to the fit of a curve or dropped: background, offset, noise floor, delay,
//! Duffing, drag.

use super::hypothesis_fit::HypothesisFit;
use super::problem::Problem;
use super::residuals::noise_model;
use super::response::{BG_IM, BG_RE, COUNT, DELAY, DRAG, DUFFING, FLOOR, OFFSET, R_BG_IM, R_BG_RE};
use super::search::best;
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise, predicted_gain};
use crate::inference::noise::NoiseModel;
use crate::model::loss::LossTerm;

/// A fit with more terms.
struct Extended {
    /// Decrease of the BIC.
    gain: f64,
    fit: Fit,
    /// All minima, if a background in amplitudes was searched for.
    minima: Vec<Fit>,
}

impl HypothesisFit<'_> {
    /// Adds the terms that the data require, the one with the largest gain first.
    pub(super) fn add_needed(&mut self) {
        let margin = self.criteria.inference.instrument_bic_margin;
        let wanted = self.options.terms;
        let complex = self.problem.main.complex;
        let candidates: [(&[usize], Option<bool>, bool); 5] = [
            (&[BG_RE, BG_IM], wanted.background, true),
            (&[OFFSET], wanted.amplitude_offset, !complex),
            (&[FLOOR], wanted.noise_floor, !complex),
            (&[DELAY], wanted.delay, complex),
            (&[DUFFING], wanted.duffing, true),
        ];
        for _ in 0..candidates.len() {
            let tried = candidates
                .iter()
                .filter(|(terms, asked, possible)| {
                    let free = &self.fit.free;
                    // Amplitudes do not distinguish a background from an offset or a noise floor.
                    let alike = [BG_RE, OFFSET, FLOOR];
                    let instead =
                        !complex && alike.contains(&terms[0]) && alike.iter().any(|k| free.contains(k));
                    asked.is_none() && *possible && !instead && !free.contains(&terms[0])
                })
                .filter_map(|(terms, ..)| self.with_terms(terms));
            let most = |a: Extended, b: Extended| if b.gain > a.gain { b } else { a };
            let Some(mut found) = tried.filter(|e| e.gain > margin).reduce(most) else { break };
            // Before an instrument or spring term is added, drag, which is a loss, is tried.
            if self.drag_is_possible()
                && !self.fit.free.contains(&DRAG)
                && let Some(dragged) = self.with_drag()
                && dragged.gain > margin.max(found.gain - self.criteria.terms.drag_preference)
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

    fn with_terms(&self, terms: &[usize]) -> Option<Extended> {
        let hidden = terms[0] == BG_RE && !self.problem.main.complex;
        let mut more = self.fit.free.clone();
        more.extend(terms);
        if self.problem.reference.is_some() && terms[0] == BG_RE {
            more.extend([R_BG_RE, R_BG_IM]);
        }
        let trial = self.extended(&mut more)?;
        // First one step of the quadratic model, which suffices to reject the terms for most curves.
        if !self.worth_trying(&trial, &more) {
            return None;
        }
        let minima = if hidden {
            self.background_minima(&trial, &self.fit, &more)
        } else {
            minimise(&trial, &self.fit.parameters, &more).into_iter().collect()
        };
        // The square of the noise cannot be negative.
        let exists = |f: &&Fit| terms[0] != FLOOR || f.parameters[FLOOR] > 0.0;
        let mut fit = minima.first().filter(exists)?.clone();
        let mut gain = self.gain(&trial, &self.fit, &fit);
        // The skewed peak is not at the position of the symmetric one.
        if terms[0] == DUFFING
            && gain > self.criteria.inference.instrument_bic_margin
            && let Some(anew) = best(&trial, &self.starts, &more, &self.criteria.search)
            && anew.rss < fit.rss
        {
            gain = self.gain(&trial, &self.fit, &anew);
            fit = anew;
        }
        Some(Extended { gain, fit, minima: if hidden { minima } else { Vec::new() } })
    }

    /// The fit with drag in addition to the free parameters.
    fn with_drag(&self) -> Option<Extended> {
        let mut more = self.fit.free.clone();
        more.push(DRAG);
        let trial = self.extended(&mut more)?;
        let fit = minimise(&trial, &self.fit.parameters, &more).filter(|f| f.parameters[DRAG] > 0.0)?;
        Some(Extended { gain: self.gain(&trial, &self.fit, &fit), fit, minima: Vec::new() })
    }

    /// The problem with these parameters free, if there are enough data.
    pub(super) fn extended(&self, free: &mut [usize]) -> Option<Problem> {
        free.sort_unstable();
        let spare = self.criteria.terms.spare_observations;
        let enough = self.problem.observations() as usize >= free.len() + spare;
        enough.then(|| self.problem.with(free))
    }

    pub(super) fn drag_is_possible(&self) -> bool {
        self.options.model.is_none_or(|m| m.has(LossTerm::Drag))
    }

    /// Keeps the minima that belong to the terms now free; searches for them if a background in amplitudes was
    /// requested.
    pub(super) fn settle_minima(&mut self) {
        let hidden = !self.problem.main.complex && self.options.terms.background == Some(true);
        if hidden && self.minima.is_empty() {
            self.minima = self.background_minima(&self.problem, &self.fit, &self.fit.free);
            self.fit = self.minima.first().unwrap_or(&self.fit).clone();
        }
        let free = &self.fit.free;
        if free.contains(&DUFFING) || free.contains(&DRAG) {
            // The other minima were found without the terms added since.
            let again = |m: &Fit| minimise(&self.problem, &m.parameters, free);
            self.minima = self.minima.iter().filter_map(again).collect();
        }
    }

    /// Decrease of the BIC by additional terms. A missing term makes the residuals autocorrelated; therefore the noise
    /// model is taken from the residuals of the fit with the terms, in the problem `richer`.
    fn gain(&self, richer: &Problem, poor: &Fit, rich: &Fit) -> f64 {
        let noise = noise_model(richer, rich, &self.criteria.residuals);
        noise.bic(poor.rss, poor.free.len()) - noise.bic(rich.rss, rich.free.len())
    }

    /// Whether the sums at the present fit predict a sufficient gain of the new terms.
    fn worth_trying(&self, trial: &Problem, free: &[usize]) -> bool {
        let mut sums = Normal::zeros(COUNT);
        if !trial.normal(&self.fit.parameters, &mut sums) {
            return false;
        }
        let (c, rss) = (&self.criteria.terms, self.fit.rss);
        let noise = NoiseModel::white(trial.observations());
        // The quadratic model underestimates the gain of several steps.
        predicted_gain(&sums, free).is_some_and(|gain| {
            let promised = (rss - c.promise_factor * gain).max(c.promise_rest * rss);
            noise.bic(rss, self.fit.free.len()) > noise.bic(promised, free.len())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::block::Block;
    use super::super::criteria::Criteria;
    use super::super::hypothesis::{Hypothesis, Kind};
    use super::super::instrument_start::InstrumentTerms;
    use super::super::prepared::PreparedCurve;
    use super::super::{Curve, Options, models};
    use super::*;
    use crate::Oscillator;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;

    /// A background and a delay that the fit started with and dropped remain in no model.
    #[test]
    fn a_term_that_was_dropped_is_nowhere_held_at_its_start() {
        let o = Oscillator::kinematic(6.3, 0.06, 0.1).unwrap();
        let (hz, z) = (0..81)
            .map(|i| {
                let hz = 0.95 + 0.00125 * i as f64;
                let noise = Phasor::new(jitter(i, 1), jitter(i, 2)) * 0.05;
                (hz, scan::reading(&o, 1.0, hz).unwrap().fundamental + noise)
            })
            .unzip();
        let curve = Curve::complex(hz, z).build().unwrap();
        let (options, criteria) = (Options::default(), Criteria::default());
        let prepared = PreparedCurve::new(Block::new(&curve), None, &options, &criteria).unwrap();
        let instrument = InstrumentTerms { background: Phasor::new(1.5, -0.8), delay: 0.05, delayed: false };
        let plain = Hypothesis::plain(&prepared);
        let hypothesis = Hypothesis { kind: Kind::Instrument, instrument, ..plain };
        let mut fit = HypothesisFit::new(&prepared, hypothesis, &options, &criteria).unwrap();
        assert!(fit.starts.iter().all(|s| s[BG_RE] != 0.0));
        assert!(fit.starts.iter().all(|s| s[DELAY] != 0.0));
        fit.settle_instrument();
        let dropped = [DELAY, BG_RE, BG_IM];
        assert!(dropped.iter().all(|k| !fit.fit.free.contains(k)), "{:?}", fit.fit.free);
        assert!(dropped.iter().all(|&k| fit.starts.iter().all(|s| s[k] == 0.0)));
        let models = models::compare(&prepared, fit).unwrap().comparison.fits;
        assert!(dropped.iter().all(|&k| models.iter().all(|m| m.unbounded.parameters[k] == 0.0)));
    }
}

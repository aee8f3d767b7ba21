//! Selection of the disturbances of phase and offset that the samples of a window require.

use super::envelope::DRAG;
use super::waveform::{BACKBONE, CHIRP, COUNT, OFFSET, OMEGA, PHASE, Waveform};
use crate::inference::least_squares::{
    Fit, LeastSquares, Normal, STEP_TOLERANCE, minimise_until, predicted_gain,
};

/// Parameters of phase and offset that every motion has.
pub(super) const ALWAYS: [usize; 3] = [PHASE, OMEGA, OFFSET];
/// Disturbances of phase and offset, included in the model only if the data require them.
pub(super) const OPTIONAL: [usize; 4] = [BACKBONE, CHIRP, OFFSET + 1, OFFSET + 2];

/// A fit with the nuisance parameters selected so far.
#[derive(Debug, Clone)]
pub(super) struct NuisanceSelection {
    pub(super) fit: Fit,
    /// Losses fitted together with them: first those that no disturbance may explain.
    pub(super) basic: Vec<usize>,
    pub(super) nuisance: Vec<usize>,
    /// Decrease of the sum of squares, in noise variances, required for including a disturbance.
    pub(super) price: f64,
}

impl NuisanceSelection {
    /// The fit with one further loss.
    pub(super) fn with_loss(mut self, problem: &Waveform, slot: usize) -> Option<Self> {
        self.basic.push(slot);
        self.fit = minimum(problem, &self.fit.parameters, &self.free(&self.nuisance))?;
        Some(self)
    }

    /// Adds the nuisance parameter with the largest predicted gain, as long as one exceeds the price.
    pub(super) fn add(&mut self, problem: &Waveform) -> Option<()> {
        let rough = problem.gathered.as_ref().and_then(|(sums, _)| sums.roughly_at(&self.fit.parameters));
        if let Some((_, gain)) = rough.and_then(|sums| self.most_promising(problem, sums))
            && gain < ROUGH_PART * self.price
        {
            return Some(());
        }
        let mut sums = Normal::zeros(COUNT);
        for _ in 0..OPTIONAL.len() {
            if !problem.normal(&self.fit.parameters, &mut sums) {
                return None;
            }
            let candidate = self.most_promising(problem, &sums).filter(|(_, gain)| *gain > self.price);
            let Some((term, _)) = candidate else { break };
            let wider = self.with_term(term);
            let Some(next) = minimum(problem, &self.fit.parameters, &self.free(&wider)) else { break };
            self.nuisance = wider;
            self.fit = next;
        }
        Some(())
    }

    /// The nuisance parameter with the largest predicted gain from the sums at the fit, and this gain in
    /// variances.
    fn most_promising(&self, problem: &Waveform, sums: &Normal) -> Option<(usize, f64)> {
        let freedom = problem.time.len() as f64 - self.fit.free.len() as f64;
        let variance = sums.rss / freedom.max(1.0);
        // Evaluated with drag free, since drag may explain the same.
        let promised = |nuisance: &[usize]| {
            let mut free = self.free(nuisance);
            free.push(DRAG);
            predicted_gain(sums, &free)
        };
        let alone = promised(&self.nuisance)?;
        let others = OPTIONAL.into_iter().filter(|o| !self.nuisance.contains(o));
        let others = others.filter(|&o| o != OFFSET + 2 || self.nuisance.contains(&(OFFSET + 1)));
        let gains = others.filter_map(|o| Some((o, (promised(&self.with_term(o))? - alone) / variance)));
        gains.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Removes a nuisance parameter if the fit without it is worse by less than the price.
    pub(super) fn drop(&mut self, problem: &Waveform, term: usize) {
        if self.nuisance.contains(&term) {
            let fewer = self.nuisance.iter().copied().filter(|&o| o != term).collect();
            self.replace_by(problem, term, fewer);
        }
    }

    /// Replaces a frequency drift by a frequency that depends on the amplitude, if the fit becomes worse by
    /// less than the price: every pendulum has the latter, and along a short decay the two look alike.
    pub(super) fn prefer_backbone(&mut self, problem: &Waveform) {
        if self.nuisance.contains(&CHIRP) && !self.nuisance.contains(&BACKBONE) {
            let with_backbone =
                self.nuisance.iter().map(|&o| if o == CHIRP { BACKBONE } else { o }).collect();
            self.replace_by(problem, CHIRP, with_backbone);
        }
    }

    /// Replaces the nuisance parameters by `others`, without `absent`, if the fit becomes worse by less than
    /// the price.
    fn replace_by(&mut self, problem: &Waveform, absent: usize, others: Vec<usize>) {
        let mut start = self.fit.parameters.clone();
        start[absent] = 0.0;
        let Some(found) = minimum(problem, &start, &self.free(&others)) else { return };
        let freedom = problem.time.len() as f64 - self.fit.free.len() as f64;
        if (found.rss - self.fit.rss) / (self.fit.rss / freedom.max(1.0)) < self.price {
            self.nuisance = others;
            self.fit = found;
        }
    }

    /// The losses and the given nuisance parameters, in ascending order.
    fn free(&self, nuisance: &[usize]) -> Vec<usize> {
        in_order(&self.basic, nuisance)
    }

    fn with_term(&self, term: usize) -> Vec<usize> {
        self.nuisance.iter().copied().chain([term]).collect()
    }
}

/// Fraction of the price that the approximate predicted gain must reach for a disturbance to be considered.
const ROUGH_PART: f64 = 0.5;

/// Losses and nuisance parameters, in ascending order.
pub(super) fn in_order(losses: &[usize], nuisance: &[usize]) -> Vec<usize> {
    let mut free = [losses, nuisance].concat();
    free.sort_unstable();
    free
}

/// The minimum reached from a start; the last small step is taken.
pub(super) fn minimum(problem: &Waveform, start: &[f64], free: &[usize]) -> Option<Fit> {
    minimise_until(problem, start, free, STEP_TOLERANCE, true)
}

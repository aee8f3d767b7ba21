//! Fits of every set of instrument terms that may be part of a curve: the one chosen, and the others, including the one
//! with or without a Duffing term.

use super::alternatives::{OtherFit, TermSet, counted_parameters};
use super::background_minima::distinct;
use super::hypothesis::Kind;
use super::hypothesis_fit::HypothesisFit;
use super::problem::Problem;
use super::residuals::noise_model;
use super::response::{BG_IM, BG_RE, DELAY, DRAG, DUFFING, FLOOR, OFFSET, R_BG_IM, R_BG_RE, slot};
use super::search::best;
use crate::answer::describe::constrained;
use crate::inference::least_squares::{Fit, by_rss};
use crate::inference::model_selection::ModelComparison;
use crate::model::loss::LossTerm;
use std::borrow::Cow;

const NOTHING: TermSet = TermSet {
    background: false,
    delay: false,
    background_delayed: false,
    offset: false,
    floor: false,
    duffing: false,
};
const SETS: [TermSet; 7] = [
    NOTHING,
    TermSet { background: true, ..NOTHING },
    TermSet { offset: true, ..NOTHING },
    TermSet { floor: true, ..NOTHING },
    TermSet { delay: true, ..NOTHING },
    TermSet { background: true, delay: true, ..NOTHING },
    TermSet { background: true, delay: true, background_delayed: true, ..NOTHING },
];

const BACKGROUNDS: [usize; 4] = [BG_RE, BG_IM, R_BG_RE, R_BG_IM];

impl TermSet {
    pub(super) fn of(problem: &Problem, free: &[usize]) -> Self {
        let (background, delay) = (free.contains(&BG_RE), free.contains(&DELAY));
        let background_delayed = background && delay && problem.background_delayed;
        let [offset, floor, duffing] = [OFFSET, FLOOR, DUFFING].map(|k| free.contains(&k));
        Self { background, delay, background_delayed, offset, floor, duffing }
    }

    /// Number of terms apart from the oscillator.
    fn terms(self) -> f64 {
        let terms = [self.background, self.delay, self.offset, self.floor];
        terms.into_iter().map(|term| f64::from(u8::from(term))).sum()
    }
}

impl HypothesisFit<'_> {
    /// Fits every set of instrument terms allowed by the options, and takes the one of lowest BIC with a margin for
    /// each term; terms are dropped by the same rule as they are added.
    pub(super) fn settle_instrument(&mut self) {
        let mut others: Vec<(Problem, OtherFit)> = Vec::new();
        let now = TermSet::of(&self.problem, &self.fit.free);
        let has_drag = self.fit.free.contains(&DRAG);
        // Whether it was added before or not, the other choice may only widen the intervals.
        let other_spring = TermSet { duffing: !now.duffing, ..now };
        let sets = SETS.map(|set| TermSet { duffing: now.duffing, ..set }).into_iter().chain([other_spring]);
        for set in sets.filter(|set| self.is_allowed(*set)) {
            for drag in [has_drag, !has_drag] {
                let may_go = has_drag && self.options.model.is_none();
                if drag != has_drag && !may_go || (set == now && drag == has_drag) {
                    continue;
                }
                let found = self.with_set(set, drag, &others);
                others.extend(found);
            }
        }
        others.extend(self.other_minima(now, &others));
        let terms = |o: &OtherFit| o.unbounded.free.len();
        let richest = others.iter().min_by(|(_, a), (_, b)| {
            terms(b).cmp(&terms(a)).then(a.unbounded.rss.total_cmp(&b.unbounded.rss))
        });
        let noise = match richest {
            Some((problem, o)) if o.unbounded.free.len() > self.fit.free.len() => {
                noise_model(problem, &o.unbounded, &self.criteria.residuals)
            }
            _ => noise_model(&self.problem, &self.fit, &self.criteria.residuals),
        };
        // If the residuals are more than noise, a term may only compensate for a deficiency of the law.
        let margin = if noise.variance_inflation > 1.0 {
            self.criteria.inference.instrument_bic_margin
        } else {
            self.criteria.terms.instrument_margin
        };
        let floor_margin = self.criteria.terms.floor_over_constant;
        let rank = |set: TermSet, fit: &Fit| {
            let floor = if set.floor { floor_margin } else { 0.0 };
            noise.bic(fit.rss, counted_parameters(&fit.free)) + margin * set.terms() + floor
        };
        let least = rank(now, &self.fit);
        // Drag is judged among the loss models; the Duffing term was decided before.
        let comparable = |o: &OtherFit| {
            [DRAG, DUFFING].iter().all(|k| o.unbounded.free.contains(k) == self.fit.free.contains(k))
        };
        let best = (0..others.len())
            .filter(|&i| comparable(&others[i].1))
            .map(|i| (rank(others[i].1.set, &others[i].1.unbounded), i))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        self.others = others.into_iter().map(|(_, other)| other).collect();
        if let Some((_, i)) = best.filter(|(rank, _)| *rank < least) {
            self.take(i);
        }
        let drag_instead = self.with_drag_instead();
        self.others.extend(drag_instead);
    }

    /// Fits with drag in place of instrument terms, which may look alike.
    fn with_drag_instead(&self) -> Vec<OtherFit> {
        let now = TermSet::of(&self.problem, &self.fit.free);
        // If the plain curve is implausible, drag is not the reason.
        if self.hypothesis.kind != Kind::Plain
            || self.fit.free.contains(&DRAG)
            || self.options.model.is_some()
        {
            return Vec::new();
        }
        // Drag cannot explain a curve whose fit is hopeless without it.
        let most = self.criteria.search.hopeless * self.fit.rss;
        let hopeful = |set: TermSet| self.others.iter().any(|o| o.set == set && o.bounded.rss < most);
        let fewer = SETS.into_iter().map(|set| TermSet { duffing: now.duffing, ..set });
        let fewer = fewer.filter(|set| set.terms() < now.terms() && hopeful(*set));
        fewer.flat_map(|set| self.with_set(set, true, &[])).map(|(_, other)| other).collect()
    }

    /// Replaces the present fit by one with another set of terms; the present fit becomes one of the others.
    fn take(&mut self, i: usize) {
        let now = TermSet::of(&self.problem, &self.fit.free);
        let left = OtherFit { set: now, unbounded: self.fit.clone(), bounded: self.within_limits() };
        let taken = std::mem::replace(&mut self.others[i], left);
        let problem = self.problem.with(&taken.unbounded.free);
        self.drop_from_starts(taken.set);
        let beside = |set: TermSet| [set.background, set.offset, set.floor];
        if beside(taken.set) != beside(now) {
            self.minima.clear();
        }
        self.problem = Problem { background_delayed: taken.set.background_delayed, ..problem };
        self.fit = taken.unbounded;
    }

    /// For amplitudes without phases that prefer drag, takes a background, an offset or a noise floor instead, unless
    /// the preference is clear; returns whether it did.
    pub(super) fn background_instead_of_drag(&mut self, comparison: &ModelComparison) -> bool {
        let now = TermSet::of(&self.problem, &self.fit.free);
        if self.problem.main.complex
            || now.background
            || now.offset
            || now.floor
            || self.options.model.is_some()
        {
            return false;
        }
        let Some(with_drag) = comparison.preferred().filter(|f| f.model.has(LossTerm::Drag)) else {
            return false;
        };
        let most = with_drag.bic + self.criteria.terms.drag_over_background;
        let instead = [
            TermSet { background: true, ..now },
            TermSet { offset: true, ..now },
            TermSet { floor: true, ..now },
        ];
        let bic = |o: &OtherFit| comparison.noise.bic(o.bounded.rss, counted_parameters(&o.unbounded.free));
        let best = (0..self.others.len())
            .filter(|&i| {
                instead.contains(&self.others[i].set) && !self.others[i].unbounded.free.contains(&DRAG)
            })
            .min_by(|&a, &b| bic(&self.others[a]).total_cmp(&bic(&self.others[b])));
        let Some(i) = best.filter(|&i| bic(&self.others[i]) < most) else { return false };
        // Backgrounds that fit equally well are several minima of one fit.
        let instead = self.others[i].set;
        let minima = self.others.iter().filter(|o| o.set == instead && !o.unbounded.free.contains(&DRAG));
        let mut minima: Vec<Fit> = minima.map(|o| o.unbounded.clone()).collect();
        by_rss(&mut minima);
        let (unbounded, bounded) = (Fit::clone(&with_drag.unbounded), Fit::clone(&with_drag.bounded));
        self.take(i);
        self.others.push(OtherFit { set: now, unbounded, bounded });
        self.minima = minima;
        true
    }

    /// Whether the options allow this set of terms, and the points can determine it.
    fn is_allowed(&self, set: TermSet) -> bool {
        let wanted = self.options.terms;
        let allowed = |asked: Option<bool>, has: bool| asked.is_none_or(|asked| asked == has);
        allowed(wanted.background, set.background)
            && allowed(wanted.delay, set.delay)
            && allowed(wanted.duffing, set.duffing)
            && allowed(wanted.amplitude_offset, set.offset)
            && allowed(wanted.noise_floor, set.floor)
            && (self.problem.main.complex || !set.delay)
            && !(self.problem.main.complex && (set.offset || set.floor))
    }

    /// Minima of fits with a subset of the terms `free`, as starts: a delay and a background together have several
    /// minima, which few points do not distinguish, and an offset or a noise floor is far from a background that was
    /// fitted instead.
    fn starts_of_parts(&self, free: &[usize], others: &[(Problem, OtherFit)]) -> Vec<Vec<f64>> {
        // Other hypotheses already provide other starts.
        let several = [DELAY, BG_RE].iter().all(|k| free.contains(k))
            || [OFFSET, FLOOR].iter().any(|k| free.contains(k));
        if self.hypothesis.kind != Kind::Plain || !several {
            return Vec::new();
        }
        let is_part = |part: &[usize]| part.len() < free.len() && part.iter().all(|k| free.contains(k));
        let parts = others.iter().map(|(_, o)| &o.unbounded).filter(|f| is_part(&f.free));
        parts.map(|f| f.parameters.clone()).collect()
    }

    /// Minima of the chosen terms other than the fit itself.
    fn other_minima(&self, now: TermSet, others: &[(Problem, OtherFit)]) -> Vec<(Problem, OtherFit)> {
        let parts = self.starts_of_parts(&self.fit.free, others);
        if parts.is_empty() {
            return Vec::new();
        }
        let from = std::iter::once(self.fit.parameters.clone()).chain(parts).collect();
        let peak = &self.hypothesis.peak;
        let minima = distinct(&self.problem, from, peak, &self.fit.free, &self.criteria.terms);
        minima.into_iter().skip(1).filter_map(|m| with_limits(&self.problem, now, m)).collect()
    }

    fn with_set(&self, set: TermSet, drag: bool, others: &[(Problem, OtherFit)]) -> Vec<(Problem, OtherFit)> {
        let hidden = set.background && !self.problem.main.complex;
        let mut free: Vec<usize> = self.fit.free.clone();
        free.retain(|k| !(BACKGROUNDS.contains(k) || [DELAY, DUFFING, DRAG, OFFSET, FLOOR].contains(k)));
        if set.background {
            let own = if self.problem.reference.is_some() { BACKGROUNDS.len() } else { 2 };
            free.extend(&BACKGROUNDS[..own]);
        }
        free.extend(
            [
                (set.delay, DELAY),
                (set.offset, OFFSET),
                (set.floor, FLOOR),
                (set.duffing, DUFFING),
                (drag, DRAG),
            ]
            .iter()
            .filter(|(is, _)| *is)
            .map(|(_, k)| *k),
        );
        let Some(problem) = self.extended(&mut free) else { return Vec::new() };
        let problem = Problem { background_delayed: set.background_delayed, ..problem };
        let mut start = self.fit.parameters.clone();
        for k in BACKGROUNDS.into_iter().chain([DELAY, OFFSET, FLOOR, DRAG, DUFFING]) {
            if !free.contains(&k) {
                start[k] = 0.0;
            }
        }
        let fits: Vec<Fit> = if hidden && !self.fit.free.contains(&BG_RE) {
            let fewer: Vec<usize> = free.iter().copied().filter(|k| !BACKGROUNDS.contains(k)).collect();
            // Without drag the fit may diverge from the parameters found with drag.
            let drag_goes = self.fit.free.contains(&DRAG) && !drag;
            let starts = if drag_goes { &self.starts[..] } else { &[] };
            let from: Vec<Vec<f64>> = std::iter::once(start).chain(starts.iter().cloned()).collect();
            let without = problem.with(&fewer);
            let Some(near) = best(&without, &from, &fewer, &self.criteria.search) else { return Vec::new() };
            self.background_minima(&problem, &near, &free)
        } else {
            let from = std::iter::once(start).chain(self.starts_of_parts(&free, others)).collect();
            distinct(&problem, from, &self.hypothesis.peak, &free, &self.criteria.terms)
        };
        let exists = |f: &Fit| !set.floor || f.parameters[FLOOR] > 0.0;
        fits.into_iter()
            .filter(exists)
            .filter_map(|unbounded| with_limits(&problem, set, unbounded))
            .collect()
    }

    fn within_limits(&self) -> Fit {
        within_limits(&self.problem, &self.fit).unwrap_or_else(|| self.fit.clone())
    }

    /// The loss models are also started from these values: a term that is not free would keep its value there.
    fn drop_from_starts(&mut self, set: TermSet) {
        for start in &mut self.starts {
            if !set.background {
                BACKGROUNDS.iter().for_each(|&k| start[k] = 0.0);
            }
            if !set.delay {
                start[DELAY] = 0.0;
            }
            if !set.offset {
                start[OFFSET] = 0.0;
            }
            if !set.floor {
                start[FLOOR] = 0.0;
            }
        }
    }
}

fn with_limits(problem: &Problem, set: TermSet, unbounded: Fit) -> Option<(Problem, OtherFit)> {
    let bounded = within_limits(problem, &unbounded)?;
    Some((problem.clone(), OtherFit { set, unbounded, bounded }))
}

/// The fit without negative losses.
pub(super) fn within_limits(problem: &Problem, fit: &Fit) -> Option<Fit> {
    let losses: Vec<usize> = LossTerm::ALL.iter().map(|term| slot(*term)).collect();
    constrained(problem, fit, &losses).map(Cow::into_owned)
}

//! The least-squares problem: curve and reference compared with the response of the oscillator.

use super::Method;
use super::block::Block;
use super::response::{
    BG_IM, BG_RE, COUNT, DELAY, DELTA, DRAG, DUFFING, FLOOR, MAIN, ModelResponse, Modelled, OFFSET, OMEGA,
    PHASE, R_BG_IM, R_BG_RE, R_DELTA, R_OMEGA, R_PHASE, X_0, X_F,
};
use super::sums;
use crate::inference::least_squares::{LeastSquares, Normal};
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::Follower;
use std::f64::consts::FRAC_PI_4;

/// Slots of the parameters of the main block among all parameters.
const OF_MAIN: [usize; MAIN] = {
    let mut slots = [0; MAIN];
    let mut k = 0;
    while k < MAIN {
        slots[k] = k;
        k += 1;
    }
    slots
};
/// The same for the reference. It has no friction and no further loss; those slots are never read. Drag and the Duffing
/// term belong to the oscillator, not to the contact, and are shared with the curve.
const OF_REFERENCE: [usize; MAIN] = {
    let mut slots = [COUNT; MAIN];
    (slots[OMEGA], slots[DELTA], slots[X_0]) = (R_OMEGA, R_DELTA, X_0);
    (slots[DRAG], slots[DUFFING], slots[OFFSET], slots[FLOOR]) = (DRAG, DUFFING, OFFSET, FLOOR);
    (slots[PHASE], slots[DELAY], slots[BG_RE], slots[BG_IM]) = (R_PHASE, DELAY, R_BG_RE, R_BG_IM);
    slots
};

/// Parameters apart from the drive that are shared by curve and reference.
const SHARED: [usize; 5] = [DELAY, DRAG, DUFFING, OFFSET, FLOOR];

/// All data and parameters that are fitted at once.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub(crate) main: Block,
    pub(crate) reference: Option<Block>,
    /// Ratio of the variance of the points of the main block to that of the reference.
    pub(crate) reference_weight: f64,
    /// Centre frequency, rad/s.
    pub(crate) centre: f64,
    pub(crate) method: Method,
    /// Known drive amplitude, and the ratio of the variance of the main block to its variance.
    pub(crate) prior: Option<[f64; 2]>,
    /// Whether slot [`X_F`] contains the friction ratio.
    pub(crate) ratio: bool,
    /// Whether the delay also applies to the background, because it occurs after the two are added.
    pub(crate) background_delayed: bool,
    /// Parameters of the main block whose derivatives are required.
    pub(crate) used: Vec<usize>,
}

impl Problem {
    /// A curve alone, with the exact response.
    pub(crate) fn new(main: Block, centre: f64, used: Vec<usize>) -> Self {
        Self {
            main,
            reference: None,
            reference_weight: 1.0,
            centre,
            method: Method::Exact,
            prior: None,
            ratio: false,
            background_delayed: false,
            used,
        }
    }

    /// The same with the derivatives required for these parameters.
    pub(crate) fn with(&self, free: &[usize]) -> Self {
        let used = free.iter().copied().filter(|&k| k < R_OMEGA).collect();
        Self { used, ..self.clone() }
    }

    /// The background as read at one frequency.
    pub(crate) fn background_at(&self, p: &[f64], omega: f64) -> Phasor {
        self.response(p, false).background_at(omega)
    }

    fn slots(reference: bool) -> &'static [usize; MAIN] {
        if reference { &OF_REFERENCE } else { &OF_MAIN }
    }

    pub(super) fn block(&self, reference: bool) -> Option<&Block> {
        if reference { self.reference.as_ref() } else { Some(&self.main) }
    }

    /// Parameters of a block whose derivatives are required.
    fn columns(&self, reference: bool) -> Vec<usize> {
        if !reference {
            return self.used.clone();
        }
        let complex = self.reference.as_ref().is_some_and(|r| r.complex);
        let mut own = vec![OMEGA, DELTA, X_0];
        if complex || self.used.contains(&PHASE) {
            own.push(PHASE);
        }
        own.extend(SHARED.into_iter().chain([BG_RE, BG_IM]).filter(|k| self.used.contains(k)));
        own
    }

    /// The response of a block for these parameters.
    pub(super) fn response(&self, p: &[f64], reference: bool) -> ModelResponse {
        let slots = Self::slots(reference);
        let get = |k: usize| p.get(slots[k]).copied().unwrap_or(0.0);
        let (x_0, friction) = (get(X_0), get(X_F));
        ModelResponse {
            method: self.method,
            centre: self.centre,
            shift: get(OMEGA),
            delta: get(DELTA),
            x_0,
            x_f: if self.ratio { FRAC_PI_4 * friction * x_0 } else { friction },
            ratio: self.ratio.then_some([FRAC_PI_4 * friction, FRAC_PI_4 * x_0]),
            amplitude_dependent: self
                .used
                .iter()
                .any(|k| (DRAG..=DUFFING).contains(k) && (!reference || SHARED.contains(k))),
            drag: get(DRAG),
            with_further: !reference && self.used.iter().any(|k| (DRAG + 1..DUFFING).contains(k)),
            further: std::array::from_fn(|k| get(DRAG + 1 + k)),
            duffing: get(DUFFING),
            phase: get(PHASE),
            delay: get(DELAY),
            background: Phasor::new(get(BG_RE), get(BG_IM)),
            background_delayed: self.background_delayed,
            offset: get(OFFSET),
            floor: get(FLOOR),
        }
    }

    /// The model at every point of a block; `None` at points where it has no motion.
    pub(crate) fn predict(&self, p: &[f64], reference: bool) -> Vec<Option<Modelled>> {
        let Some(b) = self.block(reference) else { return Vec::new() };
        let at = self.response(p, reference);
        let mut follower = Follower::for_fit(b.work.for_report());
        let modelled = (0..b.len())
            .map(|i| {
                let here = b.data[i] - at.background_at(b.omega[i]);
                let guess = if b.complex { here.norm() } else { at.amplitude_from_reading(b.data[i].re) };
                at.at(b.omega[i], b.drive[i], guess, &mut follower)
            })
            .collect();
        b.work.spend(b.len(), follower.work());
        modelled
    }

    /// Measured minus modelled at every point: the complex difference, or that of amplitudes.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<Option<Phasor>> {
        let b = &self.main;
        let of = |(i, m): (usize, Option<Modelled>)| m.map(|m| b.residual(i, &m));
        self.predict(p, false).into_iter().enumerate().map(of).collect()
    }

    /// Adds the sums of one block times `factor`; `false` if the model does not exist or the sum of squares exceeds
    /// `limit`.
    fn add_sums(&self, p: &[f64], reference: bool, factor: f64, limit: f64, out: &mut Normal) -> bool {
        let Some(block) = self.block(reference) else { return true };
        let columns = self.columns(reference);
        let at = self.response(p, reference);
        let Some(sums) = sums::products(block, at, &columns, limit / factor) else { return false };
        let slots = Self::slots(reference);
        let n = columns.len();
        for a in 0..n {
            let i = slots[columns[a]];
            out.jtr[i] += factor * sums.total(n, a);
            for c in 0..=a {
                let j = slots[columns[c]];
                out.jtj[(i.max(j), i.min(j))] += factor * sums.total(a, c);
            }
        }
        let rss = sums.total(n, n);
        out.rss += factor * rss;
        rss.is_finite()
    }
}

impl LeastSquares for Problem {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.main.observations()
            + self.reference.as_ref().map_or(0.0, Block::observations)
            + if self.prior.is_some() { 1.0 } else { 0.0 }
    }

    fn rounding(&self) -> f64 {
        self.main.rounding() + self.reference_weight * self.reference.as_ref().map_or(0.0, Block::rounding)
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_within(p, out, f64::INFINITY)
    }

    fn is_spent(&self) -> bool {
        self.main.work.remaining() == 0
    }

    fn normal_within(&self, p: &[f64], out: &mut Normal, limit: f64) -> bool {
        out.clear();
        if self.main.work.is_spent() {
            return false;
        }
        // A resonance outside the points by a factor of ten produces no peak in them.
        let omega_0 = self.centre + p[OMEGA];
        let ends = [self.main.omega.first(), self.main.omega.last()].map(|w| w.copied().unwrap_or(omega_0));
        if !(p[X_0] > 0.0 && omega_0 > 0.1 * ends[0] && omega_0 < 10.0 * ends[1]) {
            return false;
        }
        if let Some([value, weight]) = self.prior {
            let r = value - p[X_0];
            out.jtj[(X_0, X_0)] += weight;
            out.jtr[X_0] += weight * r;
            out.rss += weight * r * r;
        }
        out.rss += self.rounding();
        self.add_sums(p, false, 1.0, limit, out) && self.add_sums(p, true, self.reference_weight, limit, out)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Curve;
    use super::*;

    fn problem(complex: bool, used: Vec<usize>, ratio: bool) -> Problem {
        let f: Vec<f64> = (0..71).map(|i| 0.8 + 0.0056 * f64::from(i)).collect();
        let z: Vec<Phasor> =
            f.iter().map(|f| Phasor::from_polar(1.0 / (0.1 + (f - 1.0).abs()), -2.0 * f)).collect();
        let block = |factor: f64| {
            let curve = if complex {
                Curve::complex(f.clone(), z.iter().map(|z| z * factor).collect()).build().unwrap()
            } else {
                Curve::builder(f.clone(), z.iter().map(|z| z.norm() * factor).collect()).build().unwrap()
            };
            Block::new(&curve)
        };
        let mut main = block(1.0);
        if !complex {
            main.rice = 0.04;
        }
        Problem {
            main,
            reference: Some(block(1.2)),
            reference_weight: 0.7,
            centre: 6.2,
            method: Method::Exact,
            prior: Some([0.4, 3.0]),
            ratio,
            background_delayed: ratio,
            used,
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_sum_of_squares() {
        let linear = vec![OMEGA, DELTA, X_0, X_F, PHASE, DELAY, BG_RE, BG_IM, OFFSET, FLOOR];
        let amplitude_dependent: Vec<usize> = (0..MAIN).collect();
        for (complex, used, ratio) in [
            (true, linear.clone(), false),
            (false, linear.clone(), true),
            (true, amplitude_dependent.clone(), true),
            (false, amplitude_dependent, false),
        ] {
            let problem = problem(complex, used.clone(), ratio);
            let mut p = vec![0.0; COUNT];
            (p[OMEGA], p[DELTA], p[X_0]) = (0.1, 0.3, 0.45);
            p[X_F] = if ratio { 0.3 } else { 0.1 };
            (p[PHASE], p[DELAY], p[BG_RE], p[BG_IM], p[OFFSET]) = (0.2, 0.05, 0.1, -0.2, 0.03);
            p[FLOOR] = 0.01;
            (p[R_OMEGA], p[R_DELTA], p[R_PHASE], p[R_BG_RE], p[R_BG_IM]) = (0.05, 0.25, 0.1, 0.02, 0.03);
            if used.contains(&DRAG) {
                p[DRAG..DUFFING].fill(0.02);
                p[DUFFING] = 0.01;
            }
            let mut sums = Normal::zeros(COUNT);
            assert!(problem.normal(&p, &mut sums));
            let free = used.iter().copied().chain([R_OMEGA, R_DELTA, R_PHASE, R_BG_RE, R_BG_IM]);
            for k in free {
                let step = 1e-6 * p[k].abs().max(0.1);
                let rss = |s: f64| {
                    let mut q = p.clone();
                    q[k] += s;
                    let mut sums = Normal::zeros(COUNT);
                    assert!(problem.normal(&q, &mut sums));
                    sums.rss
                };
                let numeric = -0.5 * (rss(step) - rss(-step)) / (2.0 * step);
                let error = (sums.jtr[k] - numeric).abs() / (1e-3 * sums.rss + numeric.abs());
                // The Rice excess is kept fixed while the amplitude changes: a small part of a small term.
                let tolerance = if complex { 1e-5 } else { 3e-3 };
                assert!(error < tolerance, "{complex} {ratio} {k}: {} {numeric}", sums.jtr[k]);
            }
        }
    }

    #[test]
    fn amplitudes_read_like_rices_mean() {
        let b = &problem(false, vec![OMEGA], false).main;
        // Means of the Rice distribution with unit variance, from 15-digit Bessel functions.
        let sigma = b.rice.sqrt();
        for (a, mean) in [(0.0, 1.253_314), (1.0, 1.548_572), (2.0, 2.272_383), (4.0, 4.127_194)] {
            let read = b.read(a * sigma, 0) / sigma;
            assert!((read / mean - 1.0).abs() < 1e-3, "{a}: {read} {mean}");
        }
    }

    /// Compared with single points: through all regimes, amplitude-dependent, noisy and with points left out.
    #[test]
    fn sums_are_those_of_single_points() {
        for (complex, amplitude_dependent, x_f, delta) in [
            (true, false, 0.3, 0.3),
            (false, false, 0.34, 0.6),
            (true, true, 0.2, 0.4),
            (true, false, -0.02, 0.4),
        ] {
            let mut used = vec![OMEGA, DELTA, X_0, X_F, PHASE, DELAY, BG_RE, BG_IM, OFFSET, FLOOR];
            if amplitude_dependent {
                used.extend(DRAG..=DUFFING);
            }
            let mut problem = problem(complex, used, false);
            problem.main.omega.iter_mut().for_each(|w| *w = 2.0 + 2.0 * (*w - 5.0));
            problem.reference = None;
            problem.prior = None;
            problem.main.weight[3] = 0.0;
            let mut p = vec![0.0; COUNT];
            (p[DELTA], p[X_0], p[X_F]) = (delta, 0.45, x_f);
            (p[PHASE], p[DELAY], p[BG_RE], p[BG_IM], p[OFFSET]) = (0.2, 0.05, 0.1, -0.2, 0.03);
            p[FLOOR] = 0.01;
            if amplitude_dependent {
                p[DRAG..DUFFING].fill(0.02);
                p[DUFFING] = 0.01;
            }
            let mut sums = Normal::zeros(COUNT);
            assert!(
                problem.normal(&p, &mut sums),
                "{complex} {amplitude_dependent} {:?}",
                problem.predict(&p, false)
            );
            let weight = problem.main.weight.clone();
            let single: f64 =
                problem.residuals(&p).iter().zip(&weight).map(|(r, w)| w * r.unwrap().norm_sqr()).sum();
            assert!(
                (sums.rss / single - 1.0).abs() < 1e-11,
                "{complex} {amplitude_dependent}: {} {single}",
                sums.rss
            );
            let stops = problem.predict(&p, false).iter().filter(|m| m.unwrap().regime.stops() > 0).count();
            assert!(amplitude_dependent || x_f < 0.0 || stops > 3, "{stops}");
        }
    }
}

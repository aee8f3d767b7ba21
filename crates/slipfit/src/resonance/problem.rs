//! Curve and reference against the response of the oscillator, for the minimiser.

use super::Method;
use super::block::Block;
use super::sums::{self, OWN};
use crate::inference::least_squares::{LeastSquares, Normal};
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::{Follower, Fundamental, Point, Regime, leading};
use std::f64::consts::FRAC_PI_4;

/// `omega_0` less the centre, rad/s.
pub(crate) const OMEGA: usize = 0;
pub(crate) const DELTA: usize = 1;
pub(crate) const X_0: usize = 2;
/// Friction displacement, or the friction ratio where [`Problem::ratio`] is set.
pub(crate) const X_F: usize = 3;
/// Drag rate a2 at the centre frequency, per s and unit.
pub(crate) const DRAG: usize = 4;
/// Shift of `omega_0` by the squared amplitude, rad/s per unit².
pub(crate) const DUFFING: usize = 5;
pub(crate) const PHASE: usize = 6;
pub(crate) const DELAY: usize = 7;
pub(crate) const BG_RE: usize = 8;
pub(crate) const BG_IM: usize = 9;
pub(super) const MAIN: usize = 10;
/// The same of the reference; drive and delay are shared.
pub(crate) const R_OMEGA: usize = 10;
pub(crate) const R_DELTA: usize = 11;
pub(crate) const R_PHASE: usize = 12;
pub(crate) const R_BG_RE: usize = 13;
pub(crate) const R_BG_IM: usize = 14;
pub(crate) const COUNT: usize = 15;

/// Where each parameter of a block stands among all.
const OF_MAIN: [usize; MAIN] = [OMEGA, DELTA, X_0, X_F, DRAG, DUFFING, PHASE, DELAY, BG_RE, BG_IM];
/// The reference has no friction, drag or lean; those slots are never read.
const OF_REFERENCE: [usize; MAIN] =
    [R_OMEGA, R_DELTA, X_0, COUNT, COUNT, COUNT, R_PHASE, DELAY, R_BG_RE, R_BG_IM];

/// What the model says at one point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Modelled {
    /// Instrument terms included.
    pub(crate) value: Phasor,
    /// The oscillator alone.
    pub(crate) oscillator: Phasor,
    pub(crate) regime: Regime,
}

/// The parameters as one block sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Setting {
    pub(super) centre: f64,
    pub(super) shift: f64,
    pub(super) delta: f64,
    pub(super) x_0: f64,
    pub(super) x_f: f64,
    /// With the friction ratio a parameter: `x_F` by the drive, and by the ratio.
    pub(super) ratio: Option<[f64; 2]>,
    /// Drag or lean are there.
    pub(super) amplitude_dependent: bool,
    pub(super) drag: f64,
    pub(super) duffing: f64,
    pub(super) phase: f64,
    pub(super) delay: f64,
    pub(super) background: Phasor,
    /// The delay is the background's too.
    pub(super) background_delayed: bool,
}

impl Setting {
    /// The background as it is read at one frequency.
    pub(super) fn background_at(&self, omega: f64) -> Phasor {
        let turned = self.background_delayed && self.delay != 0.0;
        let turn = || Phasor::from_polar(1.0, (self.centre - omega) * self.delay);
        if turned { self.background * turn() } else { self.background }
    }

    #[inline(always)]
    pub(super) fn point(&self, omega: f64, level: f64) -> Point {
        Point {
            omega,
            omega_0: self.centre + self.shift,
            detuning: (omega - self.centre) - self.shift,
            delta: self.delta,
            x_0: self.x_0 * level,
            x_f: self.x_f,
        }
    }
}

/// Everything that is fitted at once.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub(crate) main: Block,
    pub(crate) reference: Option<Block>,
    /// Variance of the main block's points over the reference's.
    pub(crate) reference_weight: f64,
    /// Centre frequency, rad/s.
    pub(crate) centre: f64,
    pub(crate) method: Method,
    /// Known drive amplitude, and the variance of the main block over its own.
    pub(crate) prior: Option<[f64; 2]>,
    /// Slot [`X_F`] holds the friction ratio.
    pub(crate) ratio: bool,
    /// The delay is the background's too: it lies beyond where the two meet.
    pub(crate) background_delayed: bool,
    /// Parameters of the main block whose derivative is ever asked for.
    pub(crate) used: Vec<usize>,
}

impl Problem {
    /// A curve by itself against the exact response.
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

    /// The same with the derivatives that these parameters need.
    pub(crate) fn with(&self, free: &[usize]) -> Self {
        let used = free.iter().copied().filter(|&k| k < R_OMEGA).collect();
        Self { used, ..self.clone() }
    }

    /// The background as it is read at one frequency.
    pub(crate) fn background_at(&self, p: &[f64], omega: f64) -> Phasor {
        self.setting(p, false).background_at(omega)
    }

    pub(super) fn slots(reference: bool) -> &'static [usize; MAIN] {
        if reference { &OF_REFERENCE } else { &OF_MAIN }
    }

    pub(super) fn block(&self, reference: bool) -> Option<&Block> {
        if reference { self.reference.as_ref() } else { Some(&self.main) }
    }

    /// Parameters of a block whose derivatives are wanted.
    pub(super) fn columns(&self, reference: bool) -> Vec<usize> {
        if !reference {
            return self.used.clone();
        }
        let complex = self.reference.as_ref().is_some_and(|r| r.complex);
        let mut own = vec![OMEGA, DELTA, X_0];
        if complex || self.used.contains(&PHASE) {
            own.push(PHASE);
        }
        own.extend([DELAY, BG_RE, BG_IM].into_iter().filter(|k| self.used.contains(k)));
        own
    }

    /// The parameters as a block sees them.
    pub(super) fn setting(&self, p: &[f64], reference: bool) -> Setting {
        let slots = Self::slots(reference);
        let get = |k: usize| p.get(slots[k]).copied().unwrap_or(0.0);
        let (x_0, friction) = (get(X_0), get(X_F));
        Setting {
            centre: self.centre,
            shift: get(OMEGA),
            delta: get(DELTA),
            x_0,
            x_f: if self.ratio { FRAC_PI_4 * friction * x_0 } else { friction },
            ratio: self.ratio.then_some([FRAC_PI_4 * friction, FRAC_PI_4 * x_0]),
            amplitude_dependent: !reference && (self.used.contains(&DRAG) || self.used.contains(&DUFFING)),
            drag: get(DRAG),
            duffing: get(DUFFING),
            phase: get(PHASE),
            delay: get(DELAY),
            background: Phasor::new(get(BG_RE), get(BG_IM)),
            background_delayed: self.background_delayed,
        }
    }

    /// The model at one frequency; `level` is the relative drive, `guess` an amplitude that
    /// says which branch is meant where there are several.
    pub(crate) fn at(
        &self,
        at: &Setting,
        omega: f64,
        level: f64,
        guess: f64,
        follower: &mut Follower,
    ) -> Option<Modelled> {
        let mut by = [Phasor::default(); OWN];
        let f = self.oscillator(at, &at.point(omega, level), guess, follower, &mut by)?;
        let turn = Phasor::from_polar(1.0, at.phase - (omega - self.centre) * at.delay);
        let value = f.value * turn + at.background_at(omega);
        Some(Modelled { value, oscillator: f.value, regime: f.regime })
    }

    /// The oscillator alone, and its derivatives.
    pub(super) fn oscillator(
        &self,
        at: &Setting,
        point: &Point,
        guess: f64,
        follower: &mut Follower,
        by: &mut [Phasor; OWN],
    ) -> Option<Fundamental> {
        if at.amplitude_dependent {
            return self.amplitude_dependent(point, [at.drag, at.duffing], guess, follower, by);
        }
        let f = self.kernel(point, follower)?;
        (by[OMEGA], by[DELTA], by[X_0], by[X_F]) = (f.by_omega_0, f.by_delta, f.by_x_0, f.by_x_f);
        Some(f)
    }

    fn kernel(&self, point: &Point, follower: &mut Follower) -> Option<Fundamental> {
        match self.method {
            Method::Exact | Method::Paper => follower.fundamental(point),
            Method::Leading => {
                let damped = point.delta.abs() < point.omega_0 && point.x_0 > 0.0 && point.omega_0 > 0.0;
                if damped { leading(point) } else { None }
            }
        }
    }

    /// With drag and lean, both by the amplitude itself: `R = |Z(delta + a2 R omega/omega_c,
    /// omega_0 + c R²)|`, found by Newton's method from the amplitude measured.
    fn amplitude_dependent(
        &self,
        point: &Point,
        [drag, duffing]: [f64; 2],
        guess: f64,
        follower: &mut Follower,
        by: &mut [Phasor; OWN],
    ) -> Option<Fundamental> {
        let rate = point.omega / self.centre;
        let mut r = guess.max(0.0);
        let mut found = None;
        for _ in 0..60 {
            let lean = duffing * r * r;
            if lean.abs() > 0.5 * point.omega_0 {
                return None;
            }
            let there = Point {
                delta: point.delta + drag * rate * r,
                omega_0: point.omega_0 + lean,
                detuning: point.detuning - lean,
                ..*point
            };
            let f = self.kernel(&there, follower)?;
            let m = f.value.norm();
            let z_r = f.by_delta * (drag * rate) + f.by_omega_0 * (2.0 * duffing * r);
            let along = |d: Phasor| if m > 0.0 { (f.value.re * d.re + f.value.im * d.im) / m } else { 0.0 };
            let slope = along(z_r);
            let gain = sums::bounded(1.0 - slope);
            let step = (m - r) / gain;
            found = Some((f, m, r, z_r, gain));
            if (m - r).abs() <= 1e-12 * m.max(r) {
                break;
            }
            let reach = 0.5 * (r + m);
            r = (r + step.clamp(-reach, reach)).max(0.0);
        }
        let (f, m, r, z_r, gain) = found?;
        if (m - r).abs() > 1e-6 * m.max(r) {
            return None;
        }
        let through = |d: Phasor| {
            if m > 0.0 { d + z_r * ((f.value.re * d.re + f.value.im * d.im) / m / gain) } else { d }
        };
        by[OMEGA] = through(f.by_omega_0);
        by[DELTA] = through(f.by_delta);
        by[X_0] = through(f.by_x_0);
        by[X_F] = through(f.by_x_f);
        by[DRAG] = through(f.by_delta * (rate * r));
        by[DUFFING] = through(f.by_omega_0 * (r * r));
        Some(f)
    }

    /// The model at every point of a block, none where it has no motion.
    pub(crate) fn predict(&self, p: &[f64], reference: bool) -> Vec<Option<Modelled>> {
        let Some(b) = self.block(reference) else { return Vec::new() };
        let at = self.setting(p, reference);
        let mut follower = Follower::default();
        (0..b.len())
            .map(|i| {
                let here = b.data[i] - at.background_at(b.omega[i]);
                let guess = if b.complex { here.norm() } else { b.data[i].re };
                self.at(&at, b.omega[i], b.drive[i], guess, &mut follower)
            })
            .collect()
    }

    /// Measured less modelled at every point: the complex difference, or that of amplitudes.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<Option<Phasor>> {
        let b = &self.main;
        let of = |(i, m): (usize, Option<Modelled>)| m.map(|m| b.residual(i, m.value));
        self.predict(p, false).into_iter().enumerate().map(of).collect()
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

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_within(p, out, f64::INFINITY)
    }

    fn normal_within(&self, p: &[f64], out: &mut Normal, limit: f64) -> bool {
        out.clear();
        // A resonance ten times outside the points leaves no line in them.
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
        sums::add(self, p, false, 1.0, limit, out)
            && sums::add(self, p, true, self.reference_weight, limit, out)
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
        let linear = vec![OMEGA, DELTA, X_0, X_F, PHASE, DELAY, BG_RE, BG_IM];
        let amplitude_dependent = vec![OMEGA, DELTA, X_0, X_F, DRAG, DUFFING, PHASE, DELAY, BG_RE, BG_IM];
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
            (p[PHASE], p[DELAY], p[BG_RE], p[BG_IM]) = (0.2, 0.05, 0.1, -0.2);
            (p[R_OMEGA], p[R_DELTA], p[R_PHASE], p[R_BG_RE], p[R_BG_IM]) = (0.05, 0.25, 0.1, 0.02, 0.03);
            if used.contains(&DRAG) {
                (p[DRAG], p[DUFFING]) = (0.02, 0.01);
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
                // Rice's excess is held while the amplitude moves: a small part of a small term.
                let tolerance = if complex { 1e-5 } else { 3e-3 };
                assert!(error < tolerance, "{complex} {ratio} {k}: {} {numeric}", sums.jtr[k]);
            }
        }
    }

    #[test]
    fn amplitudes_read_like_rices_mean() {
        let b = &problem(false, vec![OMEGA], false).main;
        // Means of Rice's distribution with unit variance: by 15-digit Bessel functions.
        let sigma = b.rice.sqrt();
        for (a, mean) in [(0.0, 1.253_314), (1.0, 1.548_572), (2.0, 2.272_383), (4.0, 4.127_194)] {
            let read = b.read(a * sigma, 0) / sigma;
            assert!((read / mean - 1.0).abs() < 1e-3, "{a}: {read} {mean}");
        }
    }

    /// Against every point by itself: all the way round the regimes, amplitude_dependent, noisy and left out.
    #[test]
    fn sums_are_those_of_single_points() {
        for (complex, amplitude_dependent, x_f, delta) in [
            (true, false, 0.3, 0.3),
            (false, false, 0.34, 0.6),
            (true, true, 0.2, 0.4),
            (true, false, -0.02, 0.4),
        ] {
            let mut used = vec![OMEGA, DELTA, X_0, X_F, PHASE, DELAY, BG_RE, BG_IM];
            if amplitude_dependent {
                used.extend([DRAG, DUFFING]);
            }
            let mut problem = problem(complex, used, false);
            problem.main.omega.iter_mut().for_each(|w| *w = 2.0 + 2.0 * (*w - 5.0));
            problem.reference = None;
            problem.prior = None;
            problem.main.weight[3] = 0.0;
            let mut p = vec![0.0; COUNT];
            (p[DELTA], p[X_0], p[X_F]) = (delta, 0.45, x_f);
            (p[PHASE], p[DELAY], p[BG_RE], p[BG_IM]) = (0.2, 0.05, 0.1, -0.2);
            if amplitude_dependent {
                (p[DRAG], p[DUFFING]) = (0.02, 0.01);
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

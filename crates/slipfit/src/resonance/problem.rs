//! Curve and reference against the response of the oscillator, for the minimiser.

use super::{Curve, Method, Response};
use crate::estimate::least_squares::{LeastSquares, Normal};
use crate::steady::Phasor;
use crate::steady::fundamental::{Fundamental, Point, Regime, fundamental, leading};
use std::f64::consts::{FRAC_PI_4, TAU};

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
const MAIN: usize = 10;
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

/// Points by rising frequency.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block {
    pub(crate) omega: Vec<f64>,
    /// Real when there is no phase.
    pub(crate) data: Vec<Phasor>,
    pub(crate) complex: bool,
    /// One over the variance of a point (of a quadrature), in units of the block's own.
    pub(crate) precision: Vec<f64>,
    /// What the sums use: precision, zero for points left out, corrected for Rice's noise.
    pub(crate) weight: Vec<f64>,
    /// Drive level over its mean.
    pub(crate) drive: Vec<f64>,
    /// Place in the order of measurement.
    pub(crate) index: Vec<usize>,
    /// Variance of a quadrature at precision 1, for amplitudes; zero: none assumed.
    pub(crate) rice: f64,
}

impl Block {
    pub(crate) fn new(curve: &Curve) -> Self {
        let f = curve.frequency_hz();
        let mut index: Vec<usize> = (0..curve.len()).collect();
        index.sort_by(|&a, &b| f[a].total_cmp(&f[b]));
        let data = index
            .iter()
            .map(|&i| match curve.response() {
                Response::Amplitude(a) => Phasor::new(a[i], 0.0),
                Response::Complex(z) => z[i],
            })
            .collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let drive = match curve.drive() {
            Some(d) => index.iter().map(|&i| d[i] / mean(d)).collect(),
            None => vec![1.0; index.len()],
        };
        let precision: Vec<f64> = match curve.std_error() {
            Some(s) => {
                let typical = mean(&s.iter().map(|s| s.ln()).collect::<Vec<_>>()).exp();
                index.iter().map(|&i| (typical / s[i]).powi(2)).collect()
            }
            None => vec![1.0; index.len()],
        };
        Self {
            omega: index.iter().map(|&i| TAU * f[i]).collect(),
            data,
            complex: curve.is_complex(),
            weight: precision.clone(),
            precision,
            drive,
            index,
            rice: 0.0,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.omega.len()
    }

    /// Means of so many neighbours; what is lost is their curvature within a group.
    pub(crate) fn grouped(&self, size: usize) -> Self {
        let n = self.len().div_ceil(size);
        let groups = (0..n).map(|g| g * size..((g + 1) * size).min(self.len()));
        let mut out = Self {
            omega: Vec::with_capacity(n),
            data: Vec::with_capacity(n),
            precision: Vec::with_capacity(n),
            drive: Vec::with_capacity(n),
            index: Vec::with_capacity(n),
            weight: Vec::new(),
            ..*self
        };
        for g in groups {
            let total: f64 = self.precision[g.clone()].iter().sum();
            let mean = |v: &[f64]| g.clone().map(|i| self.precision[i] * v[i]).sum::<f64>() / total;
            out.omega.push(mean(&self.omega));
            out.drive.push(mean(&self.drive));
            out.data.push(g.clone().map(|i| self.data[i] * self.precision[i]).sum::<Phasor>() / total);
            out.precision.push(total);
            out.index.push(self.index[g.start]);
        }
        out.weight = out.precision.clone();
        out
    }

    /// Numbers measured at points in use.
    pub(crate) fn observations(&self) -> f64 {
        let points = self.weight.iter().filter(|w| **w > 0.0).count() as f64;
        if self.complex { 2.0 * points } else { points }
    }

    pub(crate) fn amplitude(&self, i: usize) -> f64 {
        if self.complex { self.data[i].norm() } else { self.data[i].re }
    }

    pub(crate) fn highest(&self) -> f64 {
        (0..self.len()).map(|i| self.amplitude(i)).fold(0.0, f64::max)
    }

    /// Square of what an amplitude of size `m` reads on average under noise in both
    /// quadratures, over the variance `v` of one, less `m²/v`: Rice's mean to 0.1 %.
    fn rice_excess(&self, m_squared: f64, v: f64) -> f64 {
        let a = m_squared / v;
        1.0 + (std::f64::consts::FRAC_PI_2 - 1.0) / (1.0 + a * (0.4 + 0.05 * a))
    }

    /// Variance of a quadrature at point `i`.
    pub(crate) fn rice_at(&self, i: usize) -> f64 {
        self.rice / self.precision[i]
    }

    /// What is read where the true amplitude is `m`.
    pub(crate) fn read(&self, m: f64, i: usize) -> f64 {
        let v = self.rice_at(i);
        if v > 0.0 { (m * m + v * self.rice_excess(m * m, v)).sqrt() } else { m }
    }

    /// Weight that goes with it: the variance falls where the amplitude drowns.
    pub(crate) fn rice_weight(&self, m: f64, i: usize) -> f64 {
        let v = self.rice_at(i);
        let share = if v > 0.0 { 2.0 - self.rice_excess(m * m, v) } else { 1.0 };
        self.precision[i] / share
    }
}

/// What the model says at one point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Modelled {
    /// Instrument terms included.
    pub(crate) value: Phasor,
    /// The oscillator alone.
    pub(crate) oscillator: Phasor,
    pub(crate) regime: Regime,
    by: [Phasor; MAIN],
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
    /// Parameters of the main block whose derivative is ever asked for.
    pub(crate) used: Vec<usize>,
}

impl Problem {
    fn slots(reference: bool) -> &'static [usize; MAIN] {
        if reference { &OF_REFERENCE } else { &OF_MAIN }
    }

    fn block(&self, reference: bool) -> Option<&Block> {
        if reference { self.reference.as_ref() } else { Some(&self.main) }
    }

    /// The model at one frequency; `level` is the relative drive, `guess` an amplitude that
    /// says which branch is meant where there are several.
    pub(crate) fn at(
        &self,
        p: &[f64],
        reference: bool,
        omega: f64,
        level: f64,
        guess: f64,
    ) -> Option<Modelled> {
        let slots = Self::slots(reference);
        let get = |k: usize| p.get(slots[k]).copied().unwrap_or(0.0);
        let (x_0, friction) = (get(X_0), get(X_F));
        let x_f = if self.ratio { FRAC_PI_4 * friction * x_0 } else { friction };
        let shift = get(OMEGA);
        let point = Point {
            omega,
            omega_0: self.centre + shift,
            detuning: (omega - self.centre) - shift,
            delta: get(DELTA),
            x_0: x_0 * level,
            x_f,
        };
        let bent = !reference && (self.used.contains(&DRAG) || self.used.contains(&DUFFING));
        let mut by = [Phasor::default(); MAIN];
        let f = if bent {
            self.bent(&point, [get(DRAG), get(DUFFING)], guess, &mut by)?
        } else {
            let f = self.kernel(&point)?;
            (by[OMEGA], by[DELTA], by[X_0], by[X_F]) = (f.by_omega_0, f.by_delta, f.by_x_0, f.by_x_f);
            f
        };
        by[X_0] *= level;
        if self.ratio {
            by[X_0] += by[X_F] * (FRAC_PI_4 * friction);
            by[X_F] *= FRAC_PI_4 * x_0;
        }
        let (phase, delay) = (get(PHASE), get(DELAY));
        let mut value = f.value;
        if phase != 0.0 || delay != 0.0 {
            let turn = Phasor::from_polar(1.0, phase - (omega - self.centre) * delay);
            value *= turn;
            for d in &mut by[..PHASE] {
                *d *= turn;
            }
        }
        by[PHASE] = Phasor::new(-value.im, value.re);
        by[DELAY] = by[PHASE] * -(omega - self.centre);
        by[BG_RE] = Phasor::new(1.0, 0.0);
        by[BG_IM] = Phasor::new(0.0, 1.0);
        value += Phasor::new(get(BG_RE), get(BG_IM));
        Some(Modelled { value, oscillator: f.value, regime: f.regime, by })
    }

    fn kernel(&self, point: &Point) -> Option<Fundamental> {
        match self.method {
            Method::Exact | Method::Paper => fundamental(point),
            Method::Leading => {
                let damped = point.delta.abs() < point.omega_0 && point.x_0 > 0.0 && point.omega_0 > 0.0;
                if damped { leading(point) } else { None }
            }
        }
    }

    /// With drag and lean, both by the amplitude itself: `R = |Z(delta + a2 R omega/omega_c,
    /// omega_0 + c R²)|`, found by Newton's method from the amplitude measured.
    fn bent(
        &self,
        point: &Point,
        [drag, duffing]: [f64; 2],
        guess: f64,
        by: &mut [Phasor; MAIN],
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
            let f = self.kernel(&there)?;
            let m = f.value.norm();
            let z_r = f.by_delta * (drag * rate) + f.by_omega_0 * (2.0 * duffing * r);
            let along = |d: Phasor| if m > 0.0 { (f.value.re * d.re + f.value.im * d.im) / m } else { 0.0 };
            let slope = along(z_r);
            // At a fold the root is double; a bounded slope keeps the step finite.
            let gain = 1.0 - slope;
            let gain = if gain.abs() < 0.02 { 0.02f64.copysign(gain) } else { gain };
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

    /// The model at point `i` of a block.
    pub(crate) fn modelled(&self, p: &[f64], reference: bool, i: usize) -> Option<Modelled> {
        let b = self.block(reference)?;
        let background = Phasor::new(p[BG_RE], p[BG_IM]);
        let guess = if b.complex { (b.data[i] - background).norm() } else { b.data[i].re };
        self.at(p, reference, b.omega[i], b.drive[i], guess)
    }

    /// Measured less modelled at point `i`: the complex difference, or that of amplitudes.
    pub(crate) fn residual(&self, p: &[f64], reference: bool, i: usize) -> Option<Phasor> {
        let b = self.block(reference)?;
        let m = self.modelled(p, reference, i)?;
        Some(if b.complex {
            b.data[i] - m.value
        } else {
            Phasor::new(b.data[i].re - b.read(m.value.norm(), i), 0.0)
        })
    }

    fn sum(&self, p: &[f64], reference: bool, factor: f64, limit: f64, out: &mut Normal) -> bool {
        let Some(b) = self.block(reference) else { return true };
        let slots = Self::slots(reference);
        let own: Vec<usize> =
            if reference { vec![OMEGA, DELTA, X_0, PHASE, DELAY, BG_RE, BG_IM] } else { self.used.clone() };
        let n = own.len();
        let mut jtj = [[0.0f64; MAIN]; MAIN];
        let mut jtr = [0.0f64; MAIN];
        let mut rss = 0.0;
        let mut cols = [Phasor::default(); MAIN];
        for i in 0..b.len() {
            let w = b.weight[i];
            if w == 0.0 {
                continue;
            }
            if factor * rss > limit {
                return false;
            }
            let Some(m) = self.modelled(p, reference, i) else { return false };
            if b.complex {
                let r = b.data[i] - m.value;
                for (c, &k) in cols[..n].iter_mut().zip(&own) {
                    *c = m.by[k];
                }
                for a in 0..n {
                    let (re, im) = (w * cols[a].re, w * cols[a].im);
                    jtr[a] += re * r.re + im * r.im;
                    for c in 0..=a {
                        jtj[a][c] += re * cols[c].re + im * cols[c].im;
                    }
                }
                rss += w * r.norm_sqr();
            } else {
                let size = m.value.norm();
                let v = b.rice_at(i);
                let read = b.read(size, i);
                let r = b.data[i].re - read;
                // d read/d size; the excess hardly moves with it.
                let slope = if v > 0.0 { size / read } else { 1.0 };
                let along = if size > 0.0 { m.value.conj() * (slope / size) } else { Phasor::default() };
                for (c, &k) in cols[..n].iter_mut().zip(&own) {
                    c.re = (along * m.by[k]).re;
                }
                for a in 0..n {
                    let re = w * cols[a].re;
                    jtr[a] += re * r;
                    for c in 0..=a {
                        jtj[a][c] += re * cols[c].re;
                    }
                }
                rss += w * r * r;
            }
        }
        for a in 0..n {
            let i = slots[own[a]];
            out.jtr[i] += factor * jtr[a];
            for c in 0..=a {
                let j = slots[own[c]];
                out.jtj[(i.max(j), i.min(j))] += factor * jtj[a][c];
            }
        }
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

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_within(p, out, f64::INFINITY)
    }

    fn normal_within(&self, p: &[f64], out: &mut Normal, limit: f64) -> bool {
        out.clear();
        if !(p[X_0] > 0.0 && self.centre + p[OMEGA] > 0.0) {
            return false;
        }
        if let Some([value, weight]) = self.prior {
            let r = value - p[X_0];
            out.jtj[(X_0, X_0)] += weight;
            out.jtr[X_0] += weight * r;
            out.rss += weight * r * r;
        }
        self.sum(p, false, 1.0, limit, out) && self.sum(p, true, self.reference_weight, limit, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(complex: bool, used: Vec<usize>, ratio: bool) -> Problem {
        let f: Vec<f64> = (0..31).map(|i| 0.8 + 0.0131 * f64::from(i)).collect();
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
            used,
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_sum_of_squares() {
        let linear = vec![OMEGA, DELTA, X_0, X_F, PHASE, DELAY, BG_RE, BG_IM];
        let bent = vec![OMEGA, DELTA, X_0, X_F, DRAG, DUFFING, PHASE, DELAY, BG_RE, BG_IM];
        for (complex, used, ratio) in [
            (true, linear.clone(), false),
            (false, linear.clone(), true),
            (true, bent.clone(), true),
            (false, bent, false),
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
}

//! Points of one curve in order of increasing frequency, with their weights.

use super::response::Modelled;
use super::work::Work;
use super::{Curve, Response};
use crate::motion::steady::Phasor;
use crate::numeric::order::ascending;
use std::f64::consts::TAU;

/// Points of a curve in order of increasing frequency.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block {
    pub(crate) omega: Vec<f64>,
    /// Real if there is no phase.
    pub(crate) data: Vec<Phasor>,
    pub(crate) complex: bool,
    /// Whether phases were measured separately from the amplitudes, not as real and imaginary parts.
    pub(crate) separate_phase: bool,
    /// Inverse variance of a point (of a quadrature), relative to the variance of the block.
    pub(crate) precision: Vec<f64>,
    /// Weight in the sums: precision, zero for points left out, corrected for Rice noise.
    pub(crate) weight: Vec<f64>,
    /// Drive level relative to its mean.
    pub(crate) drive: Vec<f64>,
    /// Index in the order of measurement.
    pub(crate) index: Vec<usize>,
    /// Variance of a quadrature at precision 1, for amplitudes with Rice noise; zero if none is assumed.
    pub(crate) rice: f64,
    /// Variance of a quadrature at precision 1 due to the rounding of frequencies and responses.
    pub(super) rounding_variance: f64,
    /// Remaining work for fits of this curve.
    pub(crate) work: Work,
}

impl Block {
    pub(crate) fn new(curve: &Curve) -> Self {
        let f = curve.frequency_hz();
        let index = ascending(f);
        let data: Vec<Phasor> = index
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
        let largest = data.iter().map(|z| z.norm()).fold(0.0, f64::max);
        Self {
            omega: index.iter().map(|&i| TAU * f[i]).collect(),
            rounding_variance: (relative_rounding(f, &index) * largest).powi(2),
            data,
            complex: curve.is_complex(),
            separate_phase: curve.has_separate_phase(),
            weight: precision.clone(),
            precision,
            drive,
            index,
            rice: 0.0,
            work: Work::default(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.omega.len()
    }

    /// Means of `size` neighbours; the curvature within a group is lost.
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
            work: self.work.clone(),
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

    /// Number of measured values at the points in use.
    pub(crate) fn observations(&self) -> f64 {
        let points = self.weight.iter().filter(|w| **w > 0.0).count() as f64;
        if self.complex { 2.0 * points } else { points }
    }

    /// The part of the weighted sum of squares due to rounding.
    pub(crate) fn rounding(&self) -> f64 {
        let quadratures = if self.complex { 2.0 } else { 1.0 };
        self.rounding_variance * quadratures * self.weight.iter().sum::<f64>()
    }

    /// Weighted variance of a point (of a quadrature) about the mean of those in use.
    pub(crate) fn variation(&self) -> f64 {
        let used = || self.data.iter().zip(&self.weight);
        let total: f64 = self.weight.iter().sum();
        let mean = used().map(|(z, w)| z * *w).sum::<Phasor>() / total;
        let squares: f64 = used().map(|(z, w)| w * (z - mean).norm_sqr()).sum();
        squares / (self.observations() - 1.0).max(1.0)
    }

    pub(crate) fn amplitude(&self, i: usize) -> f64 {
        if !self.complex {
            return self.data[i].re;
        }
        let square = self.data[i].norm_sqr();
        // Faster than the formula that avoids overflow of the square.
        if square > 1e-280 && square < 1e280 { square.sqrt() } else { self.data[i].norm() }
    }

    /// The amplitudes of all points.
    pub(crate) fn amplitudes(&self) -> Vec<f64> {
        if !self.complex {
            return self.data.iter().map(|z| z.re).collect();
        }
        let mut all: Vec<f64> = self.data.iter().map(Phasor::norm_sqr).collect();
        let plain = all.iter().fold(true, |plain, s| plain & (*s > 1e-280) & (*s < 1e280));
        if plain {
            all.iter_mut().for_each(|s| *s = s.sqrt());
        } else {
            all.iter_mut().zip(&self.data).for_each(|(s, z)| *s = z.norm());
        }
        all
    }

    /// All amplitudes scaled to the mean drive, as if the response were proportional to the drive.
    pub(crate) fn levels(&self) -> Vec<f64> {
        let mut all = self.amplitudes();
        all.iter_mut().zip(&self.drive).for_each(|(a, drive)| *a /= drive);
        all
    }

    /// The points at these indices.
    pub(crate) fn subset(&self, indices: &[usize]) -> Self {
        let some = |v: &[f64]| indices.iter().map(|&i| v[i]).collect::<Vec<_>>();
        Self {
            omega: some(&self.omega),
            data: indices.iter().map(|&i| self.data[i]).collect(),
            precision: some(&self.precision),
            weight: some(&self.weight),
            drive: some(&self.drive),
            index: indices.iter().map(|&i| self.index[i]).collect(),
            work: self.work.clone(),
            ..*self
        }
    }

    /// The same points without their phases.
    pub(crate) fn without_phases(&self) -> Self {
        let data = self.amplitudes().into_iter().map(|a| Phasor::new(a, 0.0)).collect();
        Self { data, complex: false, weight: self.precision.clone(), ..self.clone() }
    }

    /// The same points with the phase convention `e^(-i omega t)`.
    pub(crate) fn conjugated(&self) -> Self {
        Self { data: self.data.iter().map(Phasor::conj).collect(), ..self.clone() }
    }

    /// Every `stride`-th point.
    pub(crate) fn thinned(&self, stride: usize) -> Self {
        let every = |v: &[f64]| v.iter().step_by(stride).copied().collect::<Vec<_>>();
        Self {
            omega: every(&self.omega),
            data: self.data.iter().step_by(stride).copied().collect(),
            complex: self.complex,
            separate_phase: self.separate_phase,
            precision: every(&self.precision),
            weight: every(&self.weight),
            drive: every(&self.drive),
            index: self.index.iter().step_by(stride).copied().collect(),
            rice: self.rice,
            rounding_variance: self.rounding_variance,
            work: self.work.clone(),
        }
    }

    /// Measured minus modelled value at point `i`: the complex difference, or that of amplitudes.
    pub(crate) fn residual(&self, i: usize, model: &Modelled) -> Phasor {
        self.data[i] - self.reading(i, model)
    }

    /// Reading at point `i` according to the model, real if there is no phase.
    pub(crate) fn reading(&self, i: usize, model: &Modelled) -> Phasor {
        if self.complex { model.value } else { Phasor::new(self.read(model.size(), i) + model.offset, 0.0) }
    }

    pub(crate) fn highest(&self) -> f64 {
        (0..self.len()).map(|i| self.amplitude(i)).fold(0.0, f64::max)
    }

    /// Square of the mean reading of an amplitude of size `m` with noise in both quadratures, over the variance `v` of
    /// one quadrature, minus `m²/v`: the mean of the Rice distribution to 0.1 %.
    #[inline(always)]
    fn rice_excess(&self, m_squared: f64, v: f64) -> f64 {
        let a = m_squared / v;
        1.0 + (std::f64::consts::FRAC_PI_2 - 1.0) / (1.0 + a * (0.4 + 0.05 * a))
    }

    /// Variance of a quadrature at point `i`.
    #[inline(always)]
    pub(crate) fn rice_at(&self, i: usize) -> f64 {
        self.rice / self.precision[i]
    }

    /// Mean reading for a true amplitude `m`.
    #[inline(always)]
    pub(crate) fn read(&self, m: f64, i: usize) -> f64 {
        let v = self.rice_at(i);
        if v > 0.0 { (m * m + v * self.rice_excess(m * m, v)).sqrt() } else { m }
    }

    /// The corresponding weight: the variance decreases where the amplitude is below the noise.
    pub(crate) fn rice_weight(&self, m: f64, i: usize) -> f64 {
        let v = self.rice_at(i);
        let share = if v > 0.0 { 2.0 - self.rice_excess(m * m, v) } else { 1.0 };
        self.precision[i] / share
    }
}

/// Relative rounding error, with respect to the highest amplitude, of a response computed at rounded frequencies: a
/// response varies within the width of its line, a few of which are covered by the points.
fn relative_rounding(frequency_hz: &[f64], ascending: &[usize]) -> f64 {
    const ROUNDINGS: f64 = 16.0;
    let [first, last] = [ascending.first(), ascending.last()].map(|i| i.map_or(0.0, |&i| frequency_hz[i]));
    let across = if last > first { last / (last - first) } else { 0.0 };
    ROUNDINGS * f64::EPSILON * (1.0 + across)
}

//! Least-squares problem of every sample and the exact motion.
//!
//! The sums over the samples are computed by the [half-cycle kernel](crate::motion::decay::half_cycle).

use super::criteria::WaveformCriteria;
use super::gathered::{Closeness, Gathered};
use crate::inference::least_squares::{LeastSquares, Normal};
use crate::motion::decay::closed_sums::{ClosedSums, Pass, Stop};
use crate::motion::decay::half_cycle::Passed;
use crate::motion::decay::parameters::{A0, DELTA, X_F, law_of, range, shape_of, shapes_exist};
use crate::motion::decay::window::Window;
use nalgebra::DVector;
use std::f64::consts::PI;
use std::sync::Arc;

pub(crate) use crate::motion::decay::parameters::{BACKBONE, CHIRP, COUNT, OFFSET, OMEGA, PHASE};
pub(crate) use crate::motion::decay::window::{BackboneIntegral, Observable};

/// Parameters of the phase, in the order of [`Window::phase`].
pub(crate) const PHASE_SLOTS: [usize; 4] = [PHASE, OMEGA, BACKBONE, CHIRP];

/// Samples of one window and the shape of the model.
#[derive(Debug, Clone)]
pub(crate) struct Waveform<'a> {
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    pub(crate) observable: Observable,
    /// Excludes samples of an acceleration next to its turning points, where friction makes it jump.
    pub(crate) guard: Option<Guard>,
    /// Start of the window, s; parameters refer to it.
    pub(crate) origin: f64,
    pub(crate) duration: f64,
    /// Shape of the backbone; `None` leaves [`BACKBONE`] without effect.
    pub(crate) backbone: Option<BackboneIntegral>,
    pub(crate) rest: RestLevel,
    /// Rounding error of times and motion, which is included as noise in every sample.
    pub(crate) rounding_rms: f64,
    /// Parameters whose derivatives are computed.
    pub(crate) active: Vec<usize>,
    /// Sums near a reference motion, if they were gathered.
    pub(crate) gathered: Option<(Arc<Gathered>, Closeness)>,
}

/// Exclusion of samples next to the turning points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guard {
    /// Phase before and after a turning point, rad.
    pub(crate) reach: f64,
    /// Number of samples to which every sum of squares is scaled: otherwise a motion with more turning points
    /// would have a smaller sum because it excludes more samples. `None`: no scaling.
    pub(crate) stands_for: Option<f64>,
}

/// The parameters of the closed-form motion, in the order of its sums.
const CLOSED: [usize; 6] = [A0, X_F, DELTA, PHASE, OMEGA, OFFSET];

/// Sums over some samples of the derivative by the phase: times the residual, times the derivative by the
/// offset, and squared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseSums {
    pub(crate) along: f64,
    pub(crate) offset: f64,
    pub(crate) square: f64,
}

/// What the level of the samples at rest implies for the motion before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RestLevel {
    /// It determines which half cycle was the last.
    Exact,
    /// It lies anywhere within `±x_F`: its derivative by the loss is not valid over any step that a fit could
    /// take.
    Bounded,
    /// Nothing, because the offset wanders.
    Free,
}

/// Whether the rest position for this friction displacement determines the last half cycle: it must exceed
/// [`WaveformCriteria::rest_errors`] standard errors of an amplitude from all `n` samples,
/// `sigma sqrt(2 * 6/n)`.
pub(crate) fn rest_position_matters(x_f: f64, noise_rms: f64, n: usize, criteria: &WaveformCriteria) -> bool {
    x_f > criteria.rest_errors * noise_rms * (12.0 / n.max(1) as f64).sqrt()
}

impl Waveform<'_> {
    /// Whether samples at rest have a level, the rest position: velocities and accelerations are zero at
    /// rest.
    fn rest_has_a_level(&self) -> bool {
        self.observable == Observable::Displacement
    }

    fn window<'a>(&'a self, active: &'a [usize]) -> Window<'a> {
        Window {
            time: self.time,
            signal: self.signal,
            observable: self.observable,
            guard: self.guard.map_or(0.0, |guard| guard.reach),
            origin: self.origin,
            duration: self.duration,
            backbone: self.backbone.as_ref(),
            models_rest_position: self.rest == RestLevel::Exact && self.rest_has_a_level(),
            active,
        }
    }

    /// Sums for the `active` parameters and residuals; `false` if the model does not exist.
    fn pass(
        &self,
        p: &[f64],
        active: &[usize],
        out: &mut Normal,
        mut residuals: Option<&mut Vec<f64>>,
    ) -> bool {
        if residuals.is_none()
            && let Some(at_rest) = self.closed_pass(p, active, out)
        {
            if self.rest != RestLevel::Exact && at_rest < self.time.len() {
                self.level_of_rest(p, active, at_rest, out, None);
            }
            return out.rss.is_finite();
        }
        let found = self.window(active).sums(p, residuals.as_deref_mut());
        let Some(Passed { sums, at_rest, left_out }) = found else { return false };
        let n = active.len();
        let sum = |i: usize, j: usize| sums[i * (i + 1) / 2 + j];
        for (i, &a) in active.iter().enumerate() {
            out.jtr[a] = sum(n, i);
            for (j, &b) in active[..=i].iter().enumerate() {
                out.jtj[(a.max(b), a.min(b))] = sum(i, j);
            }
        }
        out.rss = sum(n, n);
        if self.rest != RestLevel::Exact && self.rest_has_a_level() && at_rest < self.time.len() {
            self.level_of_rest(p, active, at_rest, out, residuals);
        }
        if let Some(all) = self.guard.and_then(|guard| guard.stands_for) {
            out.rss *= all / (self.time.len() - left_out).max(1) as f64;
        }
        out.rss.is_finite()
    }

    /// The same problem with its sums gathered about a motion near its minimum, if possible.
    pub(crate) fn gathered_about(self, p: &[f64]) -> Self {
        let gathered = Gathered::about(&self.window(&self.active), p);
        Self { gathered: gathered.map(|sums| (Arc::new(sums), Closeness::Coarse)), ..self }
    }

    /// The sums near the motion about which they were gathered; returns whether they are available.
    fn gathered_pass(&self, p: &[f64], free: &[usize], out: &mut Normal) -> bool {
        let Some((gathered, closeness)) = &self.gathered else { return false };
        let sums = |from: usize, from_s: f64, p: &[f64], active: &[usize], out: &mut Normal| {
            let (time, signal) = (&self.time[from..], &self.signal[from..]);
            let origin = self.origin + from_s;
            let after = Waveform {
                time,
                signal,
                observable: self.observable,
                guard: self.guard.map(|guard| Guard { stands_for: None, ..guard }),
                origin,
                duration: self.duration,
                backbone: None,
                rest: self.rest,
                rounding_rms: 0.0,
                active: Vec::new(),
                gathered: None,
            };
            after.pass(p, active, out, None)
        };
        gathered.normal_of(p, free, *closeness, out, &sums).is_some()
    }

    /// The same problem; its gathered sums are used only where they are as accurate as those of all samples.
    pub(crate) fn accurate(&self) -> Self {
        // An acceleration jumps at its turning points, which the gathered sums cannot reproduce for other
        // motions.
        if self.observable == Observable::Acceleration {
            return self.exact();
        }
        let gathered = self.gathered.clone().map(|(sums, _)| (sums, Closeness::Fine));
        Self { gathered, ..self.clone() }
    }

    /// The same problem, with every sum computed sample by sample.
    pub(crate) fn exact(&self) -> Self {
        Self { gathered: None, ..self.clone() }
    }

    /// The sums if viscous and sliding loss alone act, with undisturbed phase and offset; returns the first
    /// sample at rest, or `None` if this does not apply.
    fn closed_pass(&self, p: &[f64], active: &[usize], out: &mut Normal) -> Option<usize> {
        let sums = self.closed_sums(p, active, &[], &mut Vec::new())?;
        for (i, &a) in CLOSED.iter().enumerate().filter(|(_, a)| active.contains(a)) {
            out.jtr[a] = sums.jtr[i];
            for (j, &b) in CLOSED[..=i].iter().enumerate().filter(|(_, b)| active.contains(b)) {
                out.jtj[(a, b)] = sums.jtj[i][j];
            }
        }
        out.rss = sums.rss;
        Some(sums.at_rest)
    }

    /// The closed-form sums of the samples after the last of the `borders`; those before each border are put
    /// in `parts`.
    fn closed_sums(
        &self,
        p: &[f64],
        active: &[usize],
        borders: &[usize],
        parts: &mut Vec<ClosedSums>,
    ) -> Option<ClosedSums> {
        let others = p.iter().enumerate().filter(|(k, _)| !CLOSED.contains(k));
        if self.observable != Observable::Displacement
            || !active.iter().all(|k| CLOSED.contains(k))
            || others.into_iter().any(|(_, v)| *v != 0.0)
        {
            return None;
        }
        let (time, signal, origin) = (self.time, self.signal, self.origin);
        let (p, models_rest_position) = (&CLOSED.map(|k| p[k]), self.rest == RestLevel::Exact);
        let stop = Stop::Friction;
        crate::numeric::dispatch(Pass { time, signal, origin, p, stop, models_rest_position, borders, parts })
    }

    /// The rows of the lower triangle of these sums, for each part.
    fn closed_parts(&self, p: &[f64], free: &[usize], borders: &[usize]) -> Option<Vec<Vec<f64>>> {
        let places: Option<Vec<usize>> =
            free.iter().map(|slot| CLOSED.iter().position(|k| k == slot)).collect();
        let places = places?;
        let n = self.time.len();
        let mut parts = Vec::with_capacity(borders.len() + 1);
        // Borders at the end of the samples lie after the last part.
        let inside = borders.iter().take_while(|border| **border < n).count();
        let last = self.closed_sums(p, free, &borders[..inside], &mut parts)?;
        parts.push(last);
        let rows_of = |sums: &ClosedSums| {
            let mut rows = Vec::with_capacity((free.len() + 1) * (free.len() + 2) / 2);
            for (i, &a) in places.iter().enumerate() {
                rows.extend(places[..=i].iter().map(|&b| sums.jtj[a.max(b)][a.min(b)]));
            }
            rows.extend(places.iter().map(|&a| sums.jtr[a]));
            rows.push(sums.rss);
            rows
        };
        let mut rows: Vec<Vec<f64>> = parts.iter().map(rows_of).collect();
        let none = vec![0.0; (free.len() + 1) * (free.len() + 2) / 2];
        rows.resize(borders.len() + 1, none);
        Some(rows)
    }

    /// Gives the samples at rest a separate level: the mean of their residuals, or `±x_F` if the level is
    /// bounded and the mean lies beyond.
    fn level_of_rest(
        &self,
        p: &[f64],
        active: &[usize],
        from: usize,
        out: &mut Normal,
        residuals: Option<&mut Vec<f64>>,
    ) {
        let inverse_duration = 1.0 / self.duration.max(f64::MIN_POSITIVE);
        let (mut sums, mut left) = ([0.0; 3], 0.0);
        for (t, x) in self.time[from..].iter().zip(&self.signal[from..]) {
            let v = (t - self.origin) * inverse_duration;
            let powers = [1.0, v, v * v];
            left += x - powers.iter().zip(&p[OFFSET..]).map(|(v, c)| v * c).sum::<f64>();
            sums.iter_mut().zip(powers).for_each(|(s, v)| *s += v);
        }
        let n = (self.time.len() - from) as f64;
        let x_f = p[X_F].max(0.0);
        let most = if self.rest == RestLevel::Free { f64::INFINITY } else { x_f };
        let level = (left / n).clamp(-most, most);
        let offsets = || active.iter().copied().filter(|i| (OFFSET..OFFSET + 3).contains(i));
        for i in offsets() {
            out.jtr[i] -= sums[i - OFFSET] * level;
        }
        if level == left / n {
            for i in offsets() {
                for j in offsets().filter(|j| *j <= i) {
                    out.jtj[(i, j)] -= sums[i - OFFSET] * sums[j - OFFSET] / n;
                }
            }
        } else if active.contains(&X_F) {
            let sign = left.signum();
            out.jtr[X_F] += sign * (left - n * level);
            out.jtj[(X_F, X_F)] += n;
            for i in offsets() {
                out.jtj[(i.max(X_F), i.min(X_F))] += sign * sums[i - OFFSET];
            }
        }
        // For exact samples the difference is a rounding error of either sign.
        let rounding = f64::EPSILON * n * level * level;
        out.rss = (out.rss + n * level * level - 2.0 * level * left).max(0.0) + rounding;
        if let Some(list) = residuals {
            list[from..].iter_mut().for_each(|r| *r -= level);
        }
    }
}

impl LeastSquares for Waveform<'_> {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.time.len() as f64
    }

    fn rounding(&self) -> f64 {
        self.observations() * self.rounding_rms.powi(2)
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        self.normal_of(p, &self.active, out, f64::INFINITY)
    }

    fn normal_of(&self, p: &[f64], free: &[usize], out: &mut Normal, _limit: f64) -> bool {
        out.clear();
        let omega = p[OMEGA];
        // The lowest phase rate in the window must be positive, so that the phase increases monotonically.
        let slowest =
            [0.0, self.duration].map(|t| self.window(free).phase(p, t).1).into_iter().fold(omega, f64::min);
        if !(p[A0] > 0.0 && omega > 0.0 && slowest > 0.1 * omega && shapes_exist(p)) {
            return false;
        }
        // Every half cycle is computed: across a gap of millions of them there are no samples for comparison.
        if omega * self.duration > 100.0 * PI * self.time.len() as f64 {
            return false;
        }
        let found = self.gathered_pass(p, free, out) || self.pass(p, free, out, None);
        out.rss += self.rounding();
        found
    }

    fn range(&self, parameter: usize) -> [f64; 2] {
        range(parameter)
    }

    fn without_influence(&self, zero: usize) -> Option<(usize, f64)> {
        shape_of(zero)
    }
}

impl Waveform<'_> {
    /// Residuals (data minus model), sample by sample; NaN where the model does not exist.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        if let Some(known) = self.gathered.as_ref().and_then(|(sums, _)| sums.residuals_at(p)) {
            return known.to_vec();
        }
        let mut residuals = Vec::with_capacity(self.time.len());
        self.pass(p, &[], &mut Normal::zeros(COUNT), Some(&mut residuals));
        residuals.resize(self.time.len(), f64::NAN);
        residuals
    }

    /// Number of samples that count.
    pub(crate) fn counted(&self) -> f64 {
        self.guard.and_then(|guard| guard.stands_for).unwrap_or(self.time.len() as f64)
    }

    /// Number of samples excluded because they are too close to a turning point.
    pub(crate) fn at_turns(&self, p: &[f64]) -> usize {
        let passed = self.guard.and_then(|_| self.window(&[]).sums(p, None));
        passed.map_or(0, |passed| passed.left_out)
    }

    /// Time for which the mass moves inside the window, s.
    pub(crate) fn moving_s(&self, p: &[f64]) -> f64 {
        let stop = law_of(p, p[OMEGA]).stop_time_s().unwrap_or(f64::INFINITY);
        stop.min(self.duration).max(f64::MIN_POSITIVE)
    }

    /// Mean phase rate while the mass moves, as a combination of parameters.
    pub(crate) fn mean_rate(&self, p: &[f64]) -> [(usize, f64); 3] {
        let t = self.moving_s(p);
        let [_, _, backbone, chirp] = self.window(&[]).phase(p, t).2;
        [(OMEGA, 1.0), (BACKBONE, backbone / t), (CHIRP, chirp / t)]
    }

    /// Derivatives of the phase with respect to some of its parameters, at a time on the record's clock.
    pub(crate) fn phase_by(&self, p: &[f64], slots: &[usize], time_s: f64) -> Vec<f64> {
        let by = self.window(&[]).phase(p, time_s - self.origin).2;
        slots.iter().filter_map(|s| PHASE_SLOTS.iter().position(|k| k == s)).map(|k| by[k]).collect()
    }

    /// Products of the derivatives by the `free` parameters with that by the phase, summed over the samples
    /// before the first of the `borders`, between consecutive ones, and after the last; `None` if the model
    /// does not exist.
    pub(crate) fn along_phase(
        &self,
        p: &[f64],
        free: &[usize],
        borders: &[usize],
    ) -> Option<Vec<DVector<f64>>> {
        let phase = free.iter().position(|f| *f == PHASE)?;
        let parts = self.sums_of_parts(p, free, borders)?;
        // Rows of the lower triangle.
        let row = |i: usize| (i.max(phase), i.min(phase));
        let of = |part: &Vec<f64>| {
            DVector::from_fn(free.len(), |i, _| {
                let (a, b) = row(i);
                part[a * (a + 1) / 2 + b]
            })
        };
        Some(parts.iter().map(of).collect())
    }

    /// Products of the derivatives by the `free` parameters and the residual, as rows of the lower triangle,
    /// summed over the samples before the first of the `borders`, between consecutive ones, and after the
    /// last; `None` if the model does not exist.
    pub(crate) fn sums_of_parts(
        &self,
        p: &[f64],
        free: &[usize],
        borders: &[usize],
    ) -> Option<Vec<Vec<f64>>> {
        self.closed_parts(p, free, borders).or_else(|| self.window(free).sums_of_parts(p, borders, None))
    }

    /// Sums of the residuals times the derivative by the phase, over the samples before the first of the
    /// `borders`, between consecutive ones, and after the last; `None` if the model does not exist.
    pub(crate) fn sums_by_phase(&self, p: &[f64], borders: &[usize]) -> Option<Vec<PhaseSums>> {
        let parts = self.sums_of_parts(p, &[PHASE, OFFSET], borders)?;
        // Rows of the triangle: phase; offset; residual.
        let of = |part: &Vec<f64>| PhaseSums { along: part[3], offset: part[1], square: part[0] };
        Some(parts.iter().map(of).collect())
    }

    /// Phase of the model's signal at a time on the record's clock.
    pub(crate) fn phase_at(&self, p: &[f64], time_s: f64) -> crate::signal::blocks::PhaseAt {
        let (phase, omega, _) = self.window(&[]).phase(p, time_s - self.origin);
        let phase = phase + self.observable.phase_lead();
        crate::signal::blocks::PhaseAt { phase, omega, chirp: 0.0, loss: 0.0 }
    }
}

#[cfg(test)]
mod tests;
